"""Lags, added mass in drift, resistance over speed, drag that grows to the ends: closed forms."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import quad, solve_ivp

import pmmkit as pk
from pmmkit.effects.cross_flow import force as crossflow
from pmmkit.effects.memory import late_cross_flow_force, late_sway_force
from pmmkit.equations import prepare
from pmmkit.identification.forces import ForceRecord
from pmmkit.models import load_model

L, U, RHO = 4.0, 1.5, 1000.0


def response(force, omega, lag, amplitude=0.1):
    """First harmonic of Y over v in forced sway, the state integrated by scipy."""
    period = 2 * math.pi / omega
    count = 8 + math.ceil(12 * lag * L / U / period)
    t = np.linspace((count - 2) * period, count * period, 401)[:-1]

    def rate(now, s):
        return [force(amplitude * math.cos(omega * now), U, L, RHO, s[0], 1.0, 0.0, lag)[2]]

    found = solve_ivp(rate, (0.0, t[-1]), [0.0], t_eval=t, rtol=1e-9, atol=1e-12, max_step=0.05)
    v = amplitude * np.cos(omega * t)
    Y = np.array(
        [force(x, U, L, RHO, s, 1.0, 0.0, lag)[0] for x, s in zip(v, found.y[0], strict=True)]
    )
    return 2 * np.mean(Y * np.exp(-1j * omega * t)) / (0.5 * RHO * L**2 * U**2 * (amplitude / U))


@pytest.mark.slow
@pytest.mark.parametrize("omega", [0.3, 1.0, 4.0])
@pytest.mark.parametrize("lag", [0.15, 0.8])
def test_forced_sway_sees_the_frequency_response_of_the_lag(omega, lag):
    """C1 falls by ω²T²/(1+ω²T²) and S1 grows to ωT/(1+ω²T²): 1/(1+iωT) - 1."""
    expected = 1 / (1 + 1j * omega * lag * L / U) - 1
    assert response(late_sway_force, omega, lag) == pytest.approx(expected, abs=1e-5)
    cubic = 0.75 * (0.1 / U) ** 2 * expected
    assert response(late_cross_flow_force, omega, lag) == pytest.approx(cubic, abs=1e-8)


def test_a_history_with_time_follows_the_lag_and_without_it_has_settled():
    """States along a prescribed motion: scipy's solution of the same equation."""
    model = pk.with_effect(
        load_model("kvlcc2-l7"), "memory", coefficients={"Yv_late": -0.004}, value=0.4
    )
    ready = prepare(model, 1.2)
    base = prepare(load_model("kvlcc2-l7"), 1.2)
    t = np.linspace(0.0, 40.0, 801)
    motion = {"u": 1.2 + 0.1 * np.sin(0.2 * t), "v": 0.3 * np.sin(0.5 * t) + 0.1}

    def rate(now, s):
        u, v = 1.2 + 0.1 * math.sin(0.2 * now), 0.3 * math.sin(0.5 * now) + 0.1
        speed = math.hypot(u, v)
        return [(speed * v - s[0]) * speed / (0.4 * model.ship.L)]

    speed = np.hypot(motion["u"], motion["v"])
    first = [speed[0] * motion["v"][0]]
    s = solve_ivp(rate, (0.0, 40.0), first, t_eval=t, rtol=1e-10, atol=1e-12).y[0]
    unit = 0.5 * model.water.rho * model.ship.L**2
    plain = base.water_forces(motion)["Y"]
    found = ready.water_forces(motion | {"t": t})["Y"] - plain
    expected = -0.004 * unit * (s - speed * motion["v"])
    np.testing.assert_allclose(found, expected, atol=2e-4 * np.abs(expected).max())
    given_state = ready.water_forces(motion | {"late_sway": s})["Y"] - plain
    np.testing.assert_allclose(given_state, expected, atol=1e-9 * np.abs(plain).max())
    settled = ready.water_forces(motion)["Y"]
    np.testing.assert_allclose(settled, plain, rtol=1e-12)


def by_hand(model):
    """Rates of u, v, r from those of a model, with its mass matrix and more force or mass."""
    ready, half = prepare(model, 9.0), model.ship.L
    m, xG, Izz = model.ship.mass, model.ship.xG, model.ship.Izz
    unit = 0.5 * model.water.rho * half**3
    added = model.values("added_mass")
    Yvdot, Yrdot = unit * added["Yvdot"], unit * half * added["Yrdot"]
    Nvdot, Nrdot = unit * half * added["Nvdot"], unit * half**2 * added["Nrdot"]
    M = np.array([[m - Yvdot, m * xG - Yrdot], [m * xG - Nvdot, Izz - Nrdot]])

    def rates(u, v, r, delta, force=(0.0, 0.0), mass=0.0):
        du, dv, dr, _ = ready.accelerations(u, v, r, delta=delta, n=1.4)
        return [du, *np.linalg.solve(M + mass, M @ [dv, dr] + force)]

    return rates


def test_a_turn_with_memory_is_that_of_the_equations_written_by_hand():
    """The whole turn, states and all, against scipy on hand-written equations."""
    plain = load_model("s175-3dof")
    lag, Yv, Nv = 0.5, -0.006, -0.002
    model = pk.with_effect(plain, "memory", coefficients={"Yv_late": Yv, "Nv_late": Nv}, value=lag)
    track = pk.simulate(
        model,
        "turning",
        rudder_deg=30,
        speed=9.0,
        duration=150.0,
        revolutions=1.4,
        compiled=False,
        rtol=1e-8,
    )
    half = plain.ship.L
    rates = by_hand(plain)

    def rate(t, y):
        u, v, r, s = y
        speed = math.hypot(u, v)
        missing = 0.5 * plain.water.rho * half**2 * (s - speed * v)
        delta = float(np.interp(t, track.t, track.delta))
        force = (Yv * missing, Nv * half * missing)
        return [*rates(u, v, r, delta, force), (speed * v - s) * speed / (lag * half)]

    found = solve_ivp(
        rate, (0.0, 150.0), [track.u[0], 0.0, 0.0, 0.0], t_eval=[50.0, 100.0, 150.0], rtol=1e-8,
        atol=1e-10, max_step=1.0,
    ).y  # fmt: skip
    for name, values in zip("uvr", found, strict=False):
        at = np.interp([50.0, 100.0, 150.0], track.t, getattr(track, name))
        np.testing.assert_allclose(at, values, rtol=2e-3)
    without = pk.simulate(plain, "turning", rudder_deg=30, speed=9.0, compiled=False)
    assert track.metrics["advance"] != pytest.approx(without.metrics["advance"], rel=1e-3)


@pytest.mark.slow
@given(beta=st.floats(-0.5, 0.5), r=st.floats(-0.6, 0.6), delta=st.floats(-0.5, 0.5))
def test_added_mass_in_drift_stands_in_the_mass_matrix(beta, r, delta):
    """-½ρL³ Yvvvdot v'² more mass in sway, -½ρL⁴ Nvvvdot v'² in the moment of sway."""
    plain = load_model("s175-3dof")
    model = pk.with_effect(
        plain, "nonlinear_added_mass", coefficients={"Yvvvdot": -0.02, "Nvvvdot": -0.004}
    )
    half = plain.ship.L
    u, v, r = 9.0 * math.cos(beta), -9.0 * math.sin(beta), r * 9.0 / half
    more = 0.5 * plain.water.rho * half**3 * math.sin(beta) ** 2
    mass = np.array([[0.02 * more, 0.0], [0.004 * half * more, 0.0]])
    expected = by_hand(plain)(u, v, r, delta, mass=mass)
    found = prepare(model, 9.0).accelerations(u, v, r, delta=delta, n=1.4)[:3]
    assert found == pytest.approx(tuple(expected), rel=1e-9, abs=1e-12)


def test_resistance_follows_its_curve_at_the_actual_speed():
    plain = load_model("s175-3dof")
    model = pk.with_effect(
        plain, "resistance_curve", coefficients={"X_F": -1e-4, "X_FF": -4e-5}, Fn=(0.15, 0.2, 0.25)
    )
    speeds = plain.ship.speed(0.2) * np.array([0.5, 1.0, 1.3])
    one, other = (
        x.water_forces({"u": speeds})["X"] for x in (prepare(model, 9.0), prepare(plain, 9.0))
    )
    F = np.array([0.5, 1.0, 1.3]) ** 2 - 1
    unit = 0.5 * plain.water.rho * plain.ship.L**2 * speeds**2
    np.testing.assert_allclose(one - other, unit * F * (-1e-4 - 4e-5 * F), rtol=1e-9, atol=1e-6)
    slow, fast = (prepare(x, 12.0).self_propulsion() for x in (plain, model))
    assert fast > slow


@pytest.mark.slow
@given(v=st.floats(-2, 2), r=st.floats(-1, 1), growth=st.floats(-0.5, 3))
def test_drag_that_grows_to_the_ends_is_its_integral(v, r, growth):
    """Numerical quadrature of CD(x) |v + xr| (v + xr) and its moment."""

    def section(x, power):
        w = v + r * x
        return (1 + growth * (2 * x / L) ** 2) * abs(w) * w * x**power

    turn = [-v / r] if r and abs(v / r) < L / 2 else None
    found = crossflow(v, r, L, 0.3, RHO, 0, 2, 0.6, 1.0, 1.0, growth, (0.0,), (0.0,))
    for power, value in enumerate(found):
        whole, _ = quad(section, -L / 2, L / 2, (power,), points=turn, epsabs=1e-12)
        assert value == pytest.approx(-0.5 * RHO * 0.3 * 0.6 * whole, rel=1e-8, abs=1e-6)


def test_steady_turns_and_straight_line_stability_do_not_feel_a_lag():
    plain = load_model("s175-3dof")
    model = pk.with_effect(plain, "memory", coefficients={"Yv_late": -0.006, "Nv_late": -0.002})
    one, other = (pk.stability(x, 9.0) for x in (model, plain))
    for name in ("C", "K", "T"):
        assert getattr(one, name) == pytest.approx(getattr(other, name), rel=1e-6)
    turn, still = (pk.spiral_curve(x, 9.0, points=9) for x in (model, plain))
    np.testing.assert_allclose(turn.rudder_deg, still.rudder_deg, atol=1e-6)


def test_size_and_lag_are_fitted_from_forces_along_a_history():
    model = pk.with_effect(
        load_model("s175-3dof"),
        "memory",
        coefficients={"Yv_late": -0.004, "Nv_late": -0.001},
        value=0.35,
    )
    t = np.linspace(0.0, 400.0, 800)
    motion = {"t": t, "u": np.full(800, 9.0), "v": 1.5 * np.sin(0.15 * t) + np.sin(0.04 * t)}
    ready = prepare(model, 9.0)
    record = ForceRecord(
        name="sway",
        motion=motion,
        speed=9.0,
        std={"Y": 1e3, "N": 1e5},
        forces={c: ready.water_forces(motion)[c] for c in "YN"},
    )
    start = pk.with_effect(load_model("s175-3dof"), "memory")
    names = ["memory.Yv_late", "memory.Nv_late", "memory.lag"]
    start = start.with_values("memory", Yv_late=-0.001, Nv_late=-0.001)
    found = pk.fit_to_forces(start, [record], names)
    assert found.values == pytest.approx([-0.004, -0.001, 0.35], rel=1e-4)
