"""Derivatives that follow the Froude number of the moment, against ways that do not share code."""

from __future__ import annotations

import math
from dataclasses import replace
from functools import partial

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import solve_ivp
from support.commands import said

from pmmkit.base import DataError, ModelError, SimulationError
from pmmkit.conventions import Convention
from pmmkit.equations import prepare, prepare_following
from pmmkit.imo import imo_verdicts
from pmmkit.models import Model, Part, from_values, interpolate, load_model, save_model
from pmmkit.simulation import Spread, froude_sweep, monte_carlo, sensitivities, simulate, sobol

BASE = load_model("s175-3dof")
FN = (0.12, 0.16, 0.22)
SPEEDS = tuple(BASE.ship.speed(Fn) for Fn in FN)
HULL = {
    "Xu": (-0.0011, -0.0009, -0.0008),
    "Xvr": (0.0039, 0.0037, 0.0033),
    "Xvv": (-0.0038, -0.0035, -0.0033),
    "Xrr": (0.0002, 0.0003, 0.0002),
    "Yv": (-0.0117, -0.0110, -0.0100),
    "Yr": (0.0022, 0.0023, 0.0024),
    "Yvvv": (-0.107, -0.098, -0.084),
    "Yvrr": (-0.041, -0.040, -0.037),
    "Nv": (-0.0039, -0.0032, -0.0024),
    "Nr": (-0.0022, -0.0019, -0.0014),
    "Nvvr": (-0.042, -0.050, -0.059),
    "Nrrr": (-0.0023, -0.0023, -0.0022),
}
RUDDER = {"Xdd": -0.0011, "Yd": -0.0026, "Nd": 0.00126}
ADDED = {
    "Xudot": (-0.0002, -0.0003, -0.00025),
    "Yvdot": (-0.0076, -0.0070, -0.0066),
    "Yrdot": (-0.0003, -0.0002, -0.00035),
    "Nvdot": (-0.00035, -0.0003, -0.0004),
    "Nrdot": (-0.00043, -0.00039, -0.00045),
}
LOSS = Model(
    name="in the loss of speed",
    ship=BASE.ship,
    parts={
        "hull_polynomial": Part(effect="hull_polynomial", values=HULL),
        "rudder_abkowitz": Part(effect="rudder_abkowitz", values=RUDDER),
        "added_mass": Part(effect="added_mass", values=ADDED),
    },
    convention=Convention(surge="delta-u"),
    Fn=FN,
)


def with_rows(*rows, **convention):
    """The S175 with propeller and rudder, its derivatives times a factor at each Froude number."""

    def over_fn(part, names):
        values = {
            name: tuple(x * (1 + (row - 1) * (1 if i % 2 else 0.5)) for row in rows)
            if name in names
            else x
            for i, (name, x) in enumerate(part.values.items())
        }
        return replace(part, values=values)

    parts = {
        **BASE.parts,
        "hull_polynomial": over_fn(BASE.parts["hull_polynomial"], HULL | {"Xuu": 0}),
        "added_mass": over_fn(BASE.parts["added_mass"], ADDED),
        "propeller": over_fn(BASE.parts["propeller"], {"wp", "t"}),
    }
    return BASE.with_(
        parts=parts, Fn=FN[: len(rows)], convention=replace(BASE.convention, **convention)
    )


sail = partial(simulate, compiled=False)
THREE = with_rows(1.1, 1.0, 0.85)


# The right-hand side, against the model made for each speed


@pytest.mark.parametrize("convention", [{}, {"U": "carriage"}, {"system": "prime-d"}])
@given(
    share=st.floats(0.0, 1.0),
    beta=st.floats(-0.4, 0.4),
    turn=st.floats(-0.9, 0.9),
    delta=st.floats(-0.6, 0.6),
)
@settings(max_examples=40, deadline=None)
def test_the_rates_of_a_moment_are_those_of_a_model_made_for_its_speed(
    convention, share, beta, turn, delta
):
    model = with_rows(1.1, 1.0, 0.85, **convention)
    U = SPEEDS[0] + share * (SPEEDS[2] - SPEEDS[0])
    motion = [0, 0, 0.3, U * math.cos(beta), -U * math.sin(beta), turn * U / model.ship.L]
    now = math.hypot(motion[3], motion[4])
    n = 0.12 * U
    expected = prepare(model, now).rates(motion, delta, n)
    found = prepare_following(model, 7.0).rates(motion, delta, n)
    size = np.array([U, U, U / model.ship.L, *(U**2 / model.ship.L,) * 2, (U / model.ship.L) ** 2])
    np.testing.assert_allclose((np.array(found) - expected) / size, 0.0, atol=1e-13)


@pytest.mark.parametrize("edge", [0, -1])
def test_beyond_the_tested_range_the_values_of_its_edge_are_held(edge):
    beyond = SPEEDS[edge] * (0.5 if edge == 0 else 1.7)
    motion = [0, 0, 0, beyond, -0.2 * beyond, 0.4 * beyond / THREE.ship.L]
    expected = prepare(THREE, SPEEDS[edge]).rates(motion, 0.3, 1.2)
    found = prepare_following(THREE, 7.0).rates(motion, 0.3, 1.2)
    np.testing.assert_allclose(found, expected, rtol=1e-12, atol=1e-15)


def test_an_approach_that_is_carried_on_beyond_the_range_holds_there():
    fast = 1.2 * SPEEDS[-1]
    ready = prepare_following(THREE, fast, extrapolate=True)
    plain = prepare(THREE, fast, extrapolate=True)
    for speed in (fast, 1.1 * fast):
        motion = [0, 0, 0, speed, -0.1 * speed, 0.3 * speed / THREE.ship.L]
        np.testing.assert_allclose(
            ready.rates(motion, 0.2, 1.5), plain.rates(motion, 0.2, 1.5), rtol=1e-12
        )


# A turn, against an integration of its own


def turn_by_scipy(table, approach, rudder, rate, t):
    """A turn integrated by scipy, the equations and what lies between the rows written out here."""
    ship, rho = LOSS.ship, LOSS.water.rho
    L, m = ship.L, ship.mass
    low, high = table.Fn[0], table.Fn[-1]

    def motion(time, y):
        _, _, psi, u, v, r = y
        U = math.hypot(u, v)
        Fn = min(max(U / math.sqrt(9.81 * L), low), high)
        c = {name: np.interp(Fn, table.Fn, table[name]) for name in table.names}
        d = min(rate * time, rudder)
        du, b, w = (u - approach) / U, v / U, r * L / U
        X = c["Xu"] * du + c["Xvr"] * b * w + c["Xvv"] * b**2 + c["Xrr"] * w**2
        X += RUDDER["Xdd"] * d**2
        Y = c["Yv"] * b + c["Yr"] * w + c["Yvvv"] * b**3 + c["Yvrr"] * b * w**2 + RUDDER["Yd"] * d
        N = c["Nv"] * b + c["Nr"] * w + c["Nvvr"] * b**2 * w + c["Nrrr"] * w**3 + RUDDER["Nd"] * d
        force, mass = 0.5 * rho * L**2 * U**2, 0.5 * rho * L**3
        matrix = np.array(
            [
                [m - c["Yvdot"] * mass, m * ship.xG - c["Yrdot"] * mass * L],
                [m * ship.xG - c["Nvdot"] * mass * L, ship.Izz - c["Nrdot"] * mass * L**2],
            ]
        )
        udot = (force * X + m * v * r + m * ship.xG * r**2) / (m - c["Xudot"] * mass)
        across = [force * Y - m * u * r, force * L * N - m * ship.xG * u * r]
        vdot, rdot = np.linalg.solve(matrix, across)
        ahead, aside = math.cos(psi), math.sin(psi)
        return [u * ahead - v * aside, u * aside + v * ahead, r, udot, vdot, rdot]

    ramp = rudder / rate
    start = [0, 0, 0, approach, 0, 0]
    first = solve_ivp(motion, (0, ramp), start, method="DOP853", rtol=1e-10, atol=1e-12)
    return solve_ivp(
        motion, (ramp, t[-1]), first.y[:, -1], t_eval=t, method="DOP853", rtol=1e-10, atol=1e-12
    ).y


def test_a_turn_through_two_rows_and_below_the_range_is_scipys():
    table = from_values(HULL | ADDED, Fn=FN, ship=LOSS.ship, water=LOSS.water)
    between = np.linspace(FN[0], FN[2], 11)
    np.testing.assert_allclose(
        interpolate(table, between)["Nv"], np.interp(between, FN, HULL["Nv"]), rtol=1e-12
    )
    approach = SPEEDS[2]
    order = {"rudder_deg": 35, "rudder_rate_deg": 5.0, "duration": 300.0}
    track = sail(LOSS, speed=approach, fn="instant", rtol=1e-10, dt=0.5, **order)
    late = track.t > 10.0
    found = turn_by_scipy(table, approach, math.radians(35), math.radians(5.0), track.t[late])
    assert track.tested.slowest < FN[0] < FN[1] < track.tested.fastest
    L = LOSS.ship.L
    sizes = {"x": L, "y": L, "psi": 1.0, "u": approach, "v": approach, "r": approach / L}
    for row, (name, size) in zip(found, sizes.items(), strict=True):
        np.testing.assert_allclose(getattr(track, name)[late] / size, row / size, atol=2e-7)
    held = sail(LOSS, speed=approach, dt=0.5, **order)
    assert np.abs(held.y[late] - found[1]).max() > 0.1 * L


def test_compiled_and_interpreted_agree():
    fast, slow = (simulate(THREE, speed=8.5, fn="instant", compiled=x) for x in (True, False))
    for name, value in fast.metrics.items():
        assert value == pytest.approx(slow.metrics[name], rel=1e-9)


# Where nothing follows


@pytest.mark.parametrize("convention", ["instantaneous", "carriage"])
@pytest.mark.parametrize("off", [1.0, 0.99, 1.01])
def test_one_row_gives_the_turn_of_the_approach_bit_for_bit(convention, off):
    model = with_rows(1.1, U=convention)
    speed = off * SPEEDS[0]
    approach, instant = (sail(model, speed=speed, fn=fn) for fn in ("approach", "instant"))
    assert dict(instant.metrics) == dict(approach.metrics)
    np.testing.assert_array_equal(instant.to_pandas().values, approach.to_pandas().values)
    assert instant.tested.low == instant.tested.high == FN[0]
    assert approach.tested is None


def test_rows_that_are_alike_give_the_turn_of_the_approach_bit_for_bit():
    model = with_rows(1.0, 1.0, 1.0)
    approach, instant = (sail(model, speed=8.0, fn=fn) for fn in ("approach", "instant"))
    assert dict(instant.metrics) == dict(approach.metrics)


def test_a_model_with_one_set_for_all_speeds_says_that_nothing_follows():
    approach, instant = (sail(BASE, speed=8.0, fn=fn) for fn in ("approach", "instant"))
    assert dict(instant.metrics) == dict(approach.metrics)
    assert instant.tested is None
    assert any("one set of values" in note for note in instant.notes)


@pytest.mark.parametrize("speed", [SPEEDS[0], 6.9, SPEEDS[2]])
def test_straight_ahead_at_a_held_speed_both_are_the_same(speed):
    held, follows = (
        sail(THREE, "accelerating", turns=1.0, speed=speed, fn=fn) for fn in ("approach", "instant")
    )
    assert held.n[0] == pytest.approx(follows.n[0], rel=1e-12)
    np.testing.assert_allclose(follows.u, speed, rtol=1e-9)
    np.testing.assert_allclose(follows.x, held.x, rtol=1e-9)
    assert follows.tested.below == follows.tested.above == 0.0


# What is told


def test_the_time_below_the_range_is_told_with_its_share():
    track = sail(THREE, speed=SPEEDS[2], fn="instant", dt=0.05)
    U = np.hypot(track.u, track.v)
    told = track.tested
    below = 0.05 * np.count_nonzero(U / SPEEDS[0] < 0.98)
    assert 10.0 < told.below < track.t[-1]
    assert told.below == pytest.approx(below, abs=0.11)
    assert told.share_below == pytest.approx(told.below / track.t[-1])
    assert told.above == 0.0
    assert (told.low, told.high) == (FN[0], FN[2])
    assert told.slowest == pytest.approx(THREE.ship.froude(U.min()), rel=1e-5)
    assert told.words in track.notes


def test_the_time_above_the_range_is_told():
    slow = 1.01 * SPEEDS[0]
    narrow = replace(THREE, Fn=(0.08, 0.09, FN[0]))
    track = sail(narrow, "accelerating", turns=1.5, speed=slow, fn="instant", dt=0.05)
    told = track.tested
    above = 0.05 * np.count_nonzero(np.hypot(track.u, track.v) > 1.02 * SPEEDS[0])
    assert told.below == 0.0
    assert told.above == pytest.approx(above, abs=0.11)
    assert "above it" in told.words


def test_the_answer_does_not_depend_on_how_finely_the_track_is_sampled():
    coarse, fine = (sail(THREE, speed=8.0, fn="instant", dt=dt) for dt in (5.0, 0.1))
    assert coarse.tested == fine.tested


# What is refused


def test_another_word_is_refused_with_those_there_are():
    with pytest.raises(DataError, match="approach, instant"):
        sail(THREE, speed=7.0, fn="now")


def test_forces_of_each_effect_are_those_of_the_approach():
    with pytest.raises(SimulationError, match='fn = "approach"'):
        sail(THREE, speed=7.0, fn="instant", duration=10.0, forces=True)
    assert sail(THREE, speed=7.0, duration=10.0, forces=True).forces


def test_a_mass_matrix_that_is_not_positive_at_one_row_is_refused():
    broken = THREE.with_values("added_mass", Nrdot=(0.01, -0.0004, -0.0004))
    sail(broken, speed=SPEEDS[2])
    with pytest.raises(ModelError, match="mass matrix"):
        sail(broken, speed=SPEEDS[2], fn="instant")


def test_powers_of_shallow_water_that_differ_are_refused():
    part = Part(effect="shallow_water", values={"lambda_Yv": (2.3, 2.2, 2.1)})
    shallow = THREE.with_(parts={**THREE.parts, "shallow_water": part})
    with pytest.raises(ModelError, match="approach"):
        sail(shallow, speed=7.0, depth=20.0, fn="instant")


# Many ships, sweeps and criteria

TWO = with_rows(1.1, 0.85).with_(
    covariance=np.array(
        [
            [4e-8, 0.0, 2e-8, 0.0],
            [0.0, 1e-8, 0.0, -0.5e-8],
            [2e-8, 0.0, 9e-8, 0.0],
            [0.0, -0.5e-8, 0.0, 1e-8],
        ]
    ),
    covariance_names=("Yv", "Nr"),
)


def test_ships_that_follow_are_drawn_with_the_covariance_between_froude_numbers():
    drawn = Spread.of(TWO, 6.0, fn="instant")
    assert (drawn.names, drawn.speeds) == (("Yv", "Nr"), 2)
    np.testing.assert_allclose(drawn.covariance, TWO.covariance, rtol=1e-12, atol=1e-22)
    hull = TWO.parts["hull_polynomial"].values
    np.testing.assert_allclose(
        drawn.mean, [hull["Yv"][0], hull["Nr"][0], hull["Yv"][1], hull["Nr"][1]], rtol=1e-12
    )
    weights = np.array(TWO.weights(TWO.ship.froude(6.0)))
    at_approach = np.einsum("a,aibj,b", weights, TWO.covariance.reshape(2, 2, 2, 2), weights)
    np.testing.assert_allclose(Spread.of(TWO, 6.0).covariance, at_approach, rtol=1e-12)


def test_a_relative_spread_is_the_same_share_at_every_speed():
    drawn = Spread.of(THREE, 7.0, 0.05, fn="instant")
    ships = drawn.draw(1, 0, 5).reshape(5, 3, len(drawn.names))
    share = ships / drawn.mean.reshape(3, -1)
    np.testing.assert_allclose(share, np.broadcast_to(share[:, :1], share.shape), rtol=1e-12)
    assert np.ptp(share[:, 0], axis=0).min() > 0.0


def test_the_estimates_of_other_parts_stand_beside_the_covariance_at_every_speed():
    propeller = replace(TWO.parts["propeller"], std={"wp": 0.02, "kt0": 0.01})
    model = TWO.with_(parts={**TWO.parts, "propeller": propeller})
    drawn = Spread.of(model, 6.0, fn="instant")
    assert drawn.names == ("Yv", "Nr", "propeller.wp", "propeller.kt0")
    means = drawn.mean.reshape(2, 4)
    np.testing.assert_allclose(means[:, 2], propeller.values["wp"])
    np.testing.assert_allclose(means[:, 3], propeller.values["kt0"])
    std = np.sqrt(np.diagonal(drawn.covariance)).reshape(2, 4)
    np.testing.assert_allclose(std[:, :2], np.sqrt([[4e-8, 1e-8], [9e-8, 1e-8]]))
    np.testing.assert_allclose(std[:, 3], 0.01)
    np.testing.assert_allclose(std[1, 2] / std[0, 2], means[1, 2] / means[0, 2])


def test_a_drawn_ship_is_the_model_with_its_values():
    speed = 6.2
    many = monte_carlo(TWO, speed=speed, n=8, seed=4, fn="instant")
    nominal = sail(TWO, speed=speed, fn="instant")
    assert many.tested.below == pytest.approx(nominal.tested.below)
    assert many.tested.words in str(many)
    drawn = Spread.of(TWO, speed, fn="instant").draw(4, 0, 8).reshape(8, 2, 2)
    for metric, value in nominal.metrics.items():
        assert many.nominal[metric] == pytest.approx(value, rel=1e-9)
    for ship in (0, 5):
        Yv, Nr = drawn[ship].T
        own = TWO.with_values("hull_polynomial", Yv=tuple(Yv), Nr=tuple(Nr))
        expected = sail(own, speed=speed, fn="instant").metrics["tactical_diameter"]
        assert many.metrics["tactical_diameter"][ship] == pytest.approx(expected, rel=1e-9)


def test_ships_of_one_row_are_those_of_the_approach_bit_for_bit():
    model = with_rows(1.1)
    approach, instant = (
        monte_carlo(model, speed=SPEEDS[0], n=4, spread=0.05, fn=fn)
        for fn in ("approach", "instant")
    )
    for metric, values in approach.metrics.items():
        np.testing.assert_array_equal(instant.metrics[metric], values)


def test_a_ship_without_a_positive_mass_matrix_below_is_counted_as_failed():
    std = np.diag([1e-6, 1e-12])
    loose = TWO.with_(covariance=std**2, covariance_names=("Nrdot",))
    assert monte_carlo(loose, speed=6.2, n=40, fn="instant").failed == 0
    wild = loose.with_(covariance=(1e3 * std) ** 2)
    many = monte_carlo(wild, speed=6.2, n=40, fn="instant")
    drawn = Spread.of(wild, 6.2, fn="instant").draw(0, 0, 40)[:, 0]
    unit = 0.5 * TWO.water.rho * TWO.ship.L**5
    hopeless = TWO.ship.Izz - drawn * unit < 0.0
    assert np.isnan(many.metrics["steady_diameter"][hopeless]).all()
    assert 0 < np.count_nonzero(hopeless) <= many.failed < 40


def test_which_derivative_decides_is_asked_of_the_approach():
    for asked in (sensitivities, sobol):
        with pytest.raises(DataError, match="monte_carlo"):
            asked(TWO, speed=6.0, fn="instant")


def test_a_sweep_follows_at_each_speed_and_tells_the_shares_outside():
    found = froude_sweep(THREE, [6.0, 8.0], fn="instant", compiled=False)
    assert found.attrs["fn"] == "instant"
    for i, speed in enumerate((6.0, 8.0)):
        track = sail(THREE, speed=speed, fn="instant")
        assert found["tactical_diameter_L"].values[i] == track.metrics["tactical_diameter_L"]
        assert found["share_below"].values[i] == track.tested.share_below
        assert found["share_above"].values[i] == 0.0
    assert "share_below" not in froude_sweep(THREE, [6.0], compiled=False)


def test_the_criteria_are_judged_on_manoeuvres_that_follow():
    found = imo_verdicts(THREE, 8.5, fn="instant", compiled=False)
    track = sail(THREE, speed=8.5, fn="instant")
    turn = next(verdict for verdict in found if verdict.criterion == "tactical_diameter")
    assert turn.value == track.metrics["tactical_diameter_L"]
    assert any(track.tested.words in said for said in turn.conditions)


# The command


@pytest.mark.slow
def test_the_command_follows_the_moment_and_says_how_long_it_was_outside(tmp_path, capsys):
    path = tmp_path / "ship.toml"
    save_model(THREE, path)
    given = ["simulate", path, "--speed", 8.5, "--no-figures"]
    approach = said(capsys, *given, "--out", tmp_path / "approach")[1]
    instant, words = said(capsys, *given, "--fn", "instant", "--out", tmp_path / "instant")[1:]
    expected = sail(THREE, speed=8.5, fn="instant")
    assert instant["tactical_diameter"] == expected.metrics["tactical_diameter"]
    assert expected.tested.words in words
    assert instant["tested_range"] == expected.tested.numbers
    assert approach["tested_range"] is None
    assert approach["tactical_diameter"] != instant["tactical_diameter"]


@pytest.mark.slow
def test_sweep_and_imo_take_the_word_as_well(tmp_path, capsys):
    path = tmp_path / "ship.toml"
    save_model(THREE, path)
    given = [path, "--fn", "instant", "--out"]
    rows = said(capsys, "sweep", *given, tmp_path / "sweep", "--speeds", "6,8.5")[1]["sweep"]
    track = sail(THREE, speed=8.5, fn="instant")
    assert rows[1]["tactical_diameter_L"] == track.metrics["tactical_diameter_L"]
    assert rows[1]["share_below"] == track.tested.share_below
    imo = said(capsys, "imo", *given, tmp_path / "imo", "--speed", "8.5", "--ships", "0")[1]
    turn = next(row for row in imo["verdicts"] if row["criterion"] == "tactical_diameter")
    assert turn["value"] == pytest.approx(track.metrics["tactical_diameter_L"], rel=1e-9)
