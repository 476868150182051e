"""Straight-line stability and spirals: closed forms, other differences, long simulations."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.interpolate import CubicSpline

from pmmkit.equations import prepare
from pmmkit.models import load_model
from pmmkit.simulation import simulate, spiral_curve, stability

SMOOTH = {"s175-3dof": 7.0, "s175": 9.0, "mariner": 7.7175, "esso190k": 8.23}
"""Ships whose equations have derivatives at straight running."""
TANKER = 8.23


def kept_on_one_side(name):
    """A ship whose rudder inflow is straightened to both sides alike: its equations are smooth."""
    model = load_model(name)
    return model.with_values(
        "rudder_mmg", gamma_negative=model.values("rudder_mmg")["gamma_positive"]
    )


def jacobian(ready, y, delta, n):
    """Slopes of the rates over all states but x, y, ψ, by differences of the fourth order."""
    states = ready.structure.states
    free = list(range(3, len(states)))
    sizes = {"u": ready.speed, "v": ready.speed, "r": ready.speed / ready.L, "n": n}
    slopes = np.zeros((len(free), len(free)))
    for column, i in enumerate(free):
        h = 1e-5 * sizes.get(states[i], 0.1)
        for k, weight in ((1, 8.0), (-1, -8.0), (2, -1.0), (-2, 1.0)):
            moved = list(y)
            moved[i] += k * h
            rates = np.array(ready.rates(moved, delta, n))[free]
            slopes[:, column] += weight * rates / (12 * h)
    return slopes


def straight(ready, n):
    given = {"u": ready.speed, "n": n}
    return [given.get(name, 0.0) for name in ready.structure.states]


# Eigenvalues


@pytest.mark.parametrize(("name", "speed"), SMOOTH.items())
def test_eigenvalues_are_those_of_the_differentiated_right_hand_side(name, speed):
    """All degrees of freedom at once: the remaining eigenvalues are surge's and the shaft's."""
    ready = prepare(load_model(name), speed)
    n = ready.self_propulsion()
    whole = np.linalg.eigvals(jacobian(ready, straight(ready, n), 0.0, n)) * ready.L / speed
    found = stability(name, speed)
    assert len(found.eigenvalues) == (4 if ready.rolls else 2)
    left = list(whole)
    for value in found.eigenvalues:
        nearest = min(left, key=lambda x: abs(x - value))
        assert value == pytest.approx(nearest, rel=1e-4)
        left.remove(nearest)
    assert all(value.real < 0.0 for value in left)
    assert found.stable == all(value.real < 0.0 for value in whole)


@pytest.mark.parametrize(
    ("name", "speed", "stable"),
    [
        ("s175-3dof", 7.0, True),
        ("s175", 9.0, True),
        ("mariner", 7.7175, True),
        ("esso190k", 8.23, False),
    ],
)
def test_ships_known_to_be_stable_or_not(name, speed, stable):
    found = stability(name, speed)
    assert found.stable is stable
    assert (found.C > 0) is stable
    assert (found.lever_yaw > found.lever_sway) is stable
    assert (found.K > 0) is (found.T > 0) is stable


@pytest.mark.parametrize(("name", "speed"), [*SMOOTH.items(), ("kcs", 12.35)])
def test_a_small_turn_grows_or_dies_as_the_verdict_says(name, speed):
    """Free of all but a small yaw rate, to either side, for a hundred ship lengths."""
    ready = prepare(load_model(name), speed)
    n, pace = ready.self_propulsion(), speed / ready.L
    ends = []
    for side in (1e-4, -1e-4):
        y = straight(ready, n)
        y[5] = side * pace
        result = solve_ivp(
            lambda t, y: ready.rates(y, 0.0, n),
            (0.0, 100 / pace),
            y,
            method="LSODA",
            rtol=1e-9,
            atol=1e-12,
        )
        ends.append(result.y[5, -1] / pace)
    # what is there without the disturbance (the tanker, the Mariner) is in both
    grown = abs(ends[0] - ends[1]) > 2e-4 or abs(ends[0]) > 0.1
    assert stability(name, speed).stable != grown


def test_kvlcc2_is_not_called_stable_where_it_turns_away_to_port():
    """Flow straightening .640 to one side and .395 to the other; its spiral has a loop of .39°."""
    ready = prepare(load_model("kvlcc2"), 7.97)
    n, pace = ready.self_propulsion(), 7.97 / 320.0
    y = straight(ready, n)
    y[4], y[5] = 1e-4 * 7.97, -1e-4 * pace
    result = solve_ivp(
        lambda t, y: ready.rates(y, 0.0, n),
        (0.0, 200 / pace),
        y,
        method="LSODA",
        rtol=1e-9,
        atol=1e-12,
    )
    turned = abs(result.y[5, -1] / pace) > 0.1
    assert turned == (spiral_curve("kvlcc2", 7.97).loop_width_deg > 0.1)
    assert stability("kvlcc2", 7.97).stable != turned


@pytest.mark.parametrize("GM", [0.1, 0.3, 1.0])
def test_roll_oscillates_at_the_frequency_that_the_righting_moment_gives(GM):
    """ω² = g ∇ ρ GM / I, to 1 %: at low speed roll is weakly damped.

    The ship sways as it rolls, so I' = Ix' + Jx' - (my' ly')² / (m' + my').
    """
    model = load_model("s175")
    model = model.with_(ship=replace(model.ship, GM=GM))
    found = stability(model, 1.0)
    rolling = max(found.eigenvalues.imag) * 1.0 / 175.0
    inertia = 0.0000176 + 0.0000034 - (0.007049 * 0.0313) ** 2 / (0.00792 + 0.007049)
    inertia *= 0.5 * 1025.0 * 175.0**5
    assert rolling == pytest.approx(math.sqrt(9.81 * 21222.0 * 1025.0 * GM / inertia), rel=0.01)


# Closed forms


def test_the_mariner_has_the_criterion_of_its_published_derivatives():
    """C = Yv Nr - Nv (Yr - m') with the source's Yr - m' = -.00499 and Nr - m'xG' = -.00166."""
    found = stability("mariner", 7.7175)
    published = 0.0116 * 0.00166 - 0.00264 * 0.00499
    assert published == pytest.approx(6.08e-6, rel=1e-3)
    numbers = [found.C, found.lever_sway, found.lever_yaw]
    assert numbers == pytest.approx([published, 264 / 1160, 166 / 499], rel=1e-5, abs=0)
    assert found.rudder == pytest.approx((-0.00278, 0.00139), rel=1e-6)


def mariner_by_hand():
    """Mass matrix, slopes and rudder of Chislett and Strøm-Tejsen's tables; starboard positive."""
    m, xG, Iz = 798e-5, -0.023, 39.2e-5
    M = np.array([[m + 748e-5, m * xG + 9.354e-5], [m * xG - 4.646e-5, Iz + 43.8e-5]])
    A = np.array([[-1160e-5, -499e-5], [-264e-5, -166e-5]])
    return M, A, np.array([-278e-5, 139e-5])


def test_constants_of_nomoto_from_the_derivatives_of_the_mariner():
    """(M s - A)⁻¹ b: T1 T2 = |M|/|A|, T1 + T2, K and K T3 are ratios of determinants."""
    (a, b), (c, d) = mariner_by_hand()[0]
    (Yv, Yr), (Nv, Nr) = mariner_by_hand()[1]
    Yd, Nd = mariner_by_hand()[2]
    det = Yv * Nr - Nv * Yr
    found = stability("mariner", 7.7175)
    product, total, k = found.T1 * found.T2, found.T1 + found.T2, found.K
    assert product == pytest.approx((a * d - b * c) / det, rel=1e-5)
    assert total == pytest.approx(-(a * Nr + d * Yv - b * Nv - c * Yr) / det, rel=1e-5)
    assert k == pytest.approx((Nv * Yd - Yv * Nd) / det, rel=1e-5)
    assert k * found.T3 == pytest.approx((a * Nd - c * Yd) / det, rel=1e-5)
    assert total - found.T3 == pytest.approx(found.T, rel=1e-9)


def test_the_hull_and_the_rudder_of_the_s175_in_closed_form():
    """Rudder in the slipstream as a fin: lift slope times area and uR², moved by γ v' and cRr r'.

    Yr and Nr of the whole ship hold the Coriolis term -(m' + mx') of surge.
    """
    speed = 7.0
    n = prepare(load_model("s175-3dof"), speed).self_propulsion()
    uP = 1 - 0.184
    J = uP * speed / (n * 6.533)
    uR = uP * 0.921 * math.sqrt(1 + 8 * 0.631 * (0.527 - 0.455 * J) / (math.pi * J**2))
    lift = 6.13 * 1.8219 / (1.8219 + 2.25) * 33.0376 / 175.0**2 * uR
    side, arm = 1.237, -(0.5 + 0.237 * 0.48)
    Yv, Yr = -0.0116 - side * lift * 0.088, 0.00242 - 0.00792 - 0.000238 + side * lift * 0.156
    Nv, Nr = -0.0038545 - arm * lift * 0.088, -0.00222 + arm * lift * 0.156
    found = stability("s175-3dof", speed)
    assert found.rudder == pytest.approx((-side * lift * uR, -arm * lift * uR), rel=1e-6)
    numbers = [found.C, found.lever_sway, found.lever_yaw]
    assert numbers == pytest.approx([Yv * Nr - Nv * Yr, Nv / Yv, Nr / Yr], rel=1e-6, abs=0)


@pytest.mark.parametrize(("name", "speed"), SMOOTH.items())
def test_times_of_nomoto_are_those_of_the_eigenvalues(name, speed):
    found = stability(name, speed)
    assert abs(found.T1) > abs(found.T2)
    assert found.C * found.T1 * found.T2 > 0
    if len(found.eigenvalues) == 2:
        times = sorted(-1.0 / found.eigenvalues.real, key=abs, reverse=True)
        assert times == pytest.approx([found.T1, found.T2], rel=1e-9)


def test_the_prime_numbers_do_not_know_the_speed_of_a_ship_whose_forces_go_with_its_square():
    one, other = stability("s175-3dof", 4.0), stability("s175-3dof", 10.0)
    for name in ("C", "lever_sway", "lever_yaw", "K", "T", "T1", "T2", "T3"):
        assert getattr(one, name) == pytest.approx(getattr(other, name), rel=1e-6), name


def test_a_fin_at_the_stern_steadies_and_one_at_the_bow_does_not():
    """N'r more negative adds to C by Yv < 0; Nv more negative takes from it by Yr - m' < 0."""
    model = load_model("s175-3dof")
    hull = model.values("hull_polynomial")
    C = stability(model, 7.0).C
    Yv = hull["Yv"] - 1e-3
    damped = stability(model.with_values("hull_polynomial", Nr=hull["Nr"] - 1e-4), 7.0)
    weaker = stability(model.with_values("hull_polynomial", Nv=hull["Nv"] - 1e-4), 7.0)
    assert damped.C > C > weaker.C
    far = stability(model.with_values("hull_polynomial", Nv=-0.008), 7.0)
    assert not far.stable
    assert stability(model.with_values("hull_polynomial", Yv=Yv), 7.0).C > C


# Small rudder angles


@pytest.mark.slow
@pytest.mark.parametrize(
    ("model", "speed"),
    [(load_model("s175-3dof"), 6.0), (kept_on_one_side("kcs"), 12.0)],
    ids=["s175-3dof", "kcs"],
)
def test_a_small_rudder_gives_the_yaw_rate_k_delta(model, speed):
    K = stability(model, speed).K
    pace = speed / model.ship.L
    found = simulate(model, speed=speed, rudder_deg=0.002).metrics
    assert found["steady_yaw_rate_deg_s"] == pytest.approx(K * 0.002 * pace, rel=2e-4)


@pytest.mark.parametrize(
    ("model", "speed"),
    [
        (load_model("s175-3dof"), 6.0),
        (kept_on_one_side("kcs"), 12.0),
        (kept_on_one_side("kvlcc2"), 8.0),
    ],
    ids=["s175-3dof", "kcs", "kvlcc2"],
)
def test_a_step_of_the_rudder_is_answered_as_nomoto_says(model, speed):
    """r/(Kδ) = 1 - (T1 - T3)/(T1 - T2) exp(-t/T1) + (T2 - T3)/(T1 - T2) exp(-t/T2)."""
    found = stability(model, speed)
    track = simulate(
        model,
        speed=speed,
        rudder_deg=1e-4,
        rudder_rate_deg=1e5,
        rtol=1e-11,
        duration=12.0 * model.ship.L / speed,
    )
    t = track.t * speed / model.ship.L
    T1, T2, T3 = found.T1, found.T2, found.T3
    slow, fast = (T1 - T3) / (T1 - T2) * np.exp(-t / T1), (T2 - T3) / (T1 - T2) * np.exp(-t / T2)
    expected = found.K * np.radians(1e-4) * (1 - slow + fast) * speed / model.ship.L
    assert np.max(np.abs(track.r - expected)) < 1e-4 * np.max(np.abs(expected))


# Spirals


@pytest.mark.parametrize("name", ["s175-3dof", "kvlcc2-l7", "esso190k"])
def test_every_point_of_a_spiral_curve_is_a_motion_without_accelerations(name):
    speed = {"kvlcc2-l7": 1.179}.get(name, 8.23)
    model = load_model(name)
    curve = spiral_curve(model, speed, points=41)
    ready = prepare(model, speed)
    n, pace = ready.self_propulsion(), speed / ready.L
    for row in curve.to_pandas().to_dict("records"):
        drift = math.radians(row["drift_deg"])
        U = row["speed_ratio"] * speed
        y = straight(ready, n)
        y[3], y[4] = U * math.cos(drift), -U * math.sin(drift)
        y[5] = math.radians(row["yaw_rate_deg_s"])
        rates = ready.rates(y, math.radians(row["rudder_deg"]), n)
        assert rates[3] / (speed * pace) == pytest.approx(0.0, abs=1e-9)
        assert rates[4] / (speed * pace) == pytest.approx(0.0, abs=1e-9)
        assert rates[5] / pace**2 == pytest.approx(0.0, abs=1e-9)


@pytest.mark.parametrize("name", ["s175-3dof", "s175"])
@pytest.mark.parametrize("rudder_deg", [3.0, 10.0, -20.0])
def test_the_curve_goes_through_the_steady_turns(name, rudder_deg):
    curve = spiral_curve(name, 9.0)
    turn = simulate(name, speed=9.0, rudder_deg=rudder_deg).metrics
    side = math.copysign(1.0, rudder_deg)
    at = side * turn["steady_yaw_rate_deg_s"]
    through = CubicSpline(curve.yaw_rate_deg_s, np.transpose([curve.rudder_deg, curve.speed_ratio]))
    assert through(at) == pytest.approx([rudder_deg, turn["speed_ratio"]], rel=1e-3)


@pytest.mark.parametrize("name", ["s175-3dof", "s175"])
def test_the_spiral_of_a_stable_ship_is_a_single_line(name):
    curve = spiral_curve(name, 9.0)
    assert (curve.loop_width_deg, curve.loop_height_deg_s) == (0.0, 0.0)
    assert curve.neutral_deg == pytest.approx(0.0, abs=1e-9)
    assert np.all(curve.stable)
    assert np.all(np.diff(curve.rudder_deg) > 0)
    np.testing.assert_allclose(curve.rudder_deg, -curve.rudder_deg[::-1], atol=1e-8)
    K = stability("s175-3dof", 9.0).K
    middle = len(curve.rudder_deg) // 2
    slope = np.gradient(curve.rudder_deg, curve.yaw_rate_deg_s)[middle]
    if name == "s175-3dof":
        assert 1 / slope == pytest.approx(K * 9.0 / 175.0, rel=5e-3)


def test_the_spiral_of_kcs_which_rises_all_the_way_has_no_loop():
    curve = spiral_curve("kcs", 12.35)
    assert np.all(np.diff(curve.rudder_deg) > 0)
    assert curve.loop_width_deg == 0.0


def test_a_direct_spiral_of_a_stable_ship_comes_back_on_its_own_line():
    found = simulate("s175-3dof", "spiral", speed=9.0, rudder_deg=10.0, step_deg=5.0).metrics
    assert found["loop_width_deg"] == 0.0
    assert found["loop_height_deg_s"] < 1e-3
    curve = spiral_curve("s175-3dof", 9.0)
    for angle in (-10, -5, 5, 10):
        there = found[f"yaw_rate_deg_s_at_{angle:+g}_first"]
        assert there == pytest.approx(
            np.interp(angle, curve.rudder_deg, curve.yaw_rate_deg_s), rel=5e-3
        )
        assert found[f"yaw_rate_deg_s_at_{angle:+g}_back"] == pytest.approx(there, rel=5e-3)


def turn_left_after(start_deg, rudder_deg):
    """Yaw rate [deg/s] of the tanker long after its rudder went from one angle to another."""
    ready = prepare(load_model("esso190k"), TANKER)
    n, pace = ready.self_propulsion(), TANKER / ready.L
    y = straight(ready, n)
    for angle, lengths in ((start_deg, 100.0), (rudder_deg, 600.0)):
        result = solve_ivp(
            lambda t, y, angle=angle: ready.rates(y, math.radians(angle), n),
            (0.0, lengths / pace),
            y,
            method="LSODA",
            rtol=1e-8,
            atol=1e-10,
        )
        y = result.y[:, -1]
    return math.degrees(y[5])


def test_the_loop_of_the_unstable_tanker_is_where_long_turns_flip():
    """From a turn to starboard the ship stays in it down to the lower fold, and so the other way.

    The thrust pushes to port, so the loop is about a rudder angle to starboard.
    """
    curve = spiral_curve("esso190k", TANKER)
    low = curve.neutral_deg - curve.loop_width_deg / 2
    high = curve.neutral_deg + curve.loop_width_deg / 2
    assert 0.5 < curve.loop_width_deg < 1.5
    assert curve.neutral_deg > 0.2
    near = 0.02
    assert turn_left_after(4.0, low + near) > 0.05
    assert turn_left_after(4.0, low - near) < -0.05
    assert turn_left_after(-4.0, high - near) < -0.05
    assert turn_left_after(-4.0, high + near) > 0.05


def test_the_height_of_the_loop_is_between_the_two_turns_with_the_same_rudder():
    curve = spiral_curve("esso190k", TANKER)
    starboard = turn_left_after(4.0, curve.neutral_deg)
    port = turn_left_after(-4.0, curve.neutral_deg)
    assert port < 0 < starboard
    assert curve.loop_height_deg_s == pytest.approx(starboard - port, rel=1e-3)


@pytest.mark.slow
def test_the_direct_spiral_of_the_tanker_finds_its_loop_to_a_step():
    found = simulate("esso190k", "spiral", speed=TANKER, rudder_deg=3.0, step_deg=0.25).metrics
    exact = spiral_curve("esso190k", TANKER).loop_width_deg
    assert found["loop_width_deg"] == pytest.approx(exact, abs=0.25)
    assert found["yaw_rate_deg_s_at_+0.5_first"] > 0 > found["yaw_rate_deg_s_at_+0.5_back"]


@pytest.mark.slow
def test_the_direct_spiral_of_the_tanker_has_the_height_of_its_loop():
    found = simulate("esso190k", "spiral", speed=TANKER, rudder_deg=3.0, step_deg=0.25).metrics
    exact = spiral_curve("esso190k", TANKER).loop_height_deg_s
    assert found["loop_height_deg_s"] == pytest.approx(exact, rel=0.1)


def test_turns_that_the_curve_calls_stable_have_eigenvalues_to_the_left():
    curve = spiral_curve("esso190k", TANKER, points=81)
    ready = prepare(load_model("esso190k"), TANKER)
    n = ready.self_propulsion()
    fold = np.flatnonzero(np.diff(curve.stable))
    assert len(fold) == 2
    rows = curve.to_pandas()
    for i, row in rows.iterrows():
        if min(abs(i - fold)) < 3 or min(abs(i - fold - 1)) < 3:
            continue
        drift, U = math.radians(row["drift_deg"]), row["speed_ratio"] * TANKER
        y = straight(ready, n)
        y[3], y[4] = U * math.cos(drift), -U * math.sin(drift)
        y[5] = math.radians(row["yaw_rate_deg_s"])
        values = np.linalg.eigvals(jacobian(ready, y, math.radians(row["rudder_deg"]), n))
        assert bool(np.all(values.real < 0.0)) == row["stable"]


@pytest.mark.slow
def test_more_points_do_not_move_the_folds():
    coarse, fine = (spiral_curve("esso190k", TANKER, points=points) for points in (161, 641))
    assert coarse.loop_width_deg == pytest.approx(fine.loop_width_deg, rel=1e-3)
    assert coarse.neutral_deg == pytest.approx(fine.neutral_deg, rel=1e-3)


def test_a_steady_turn_of_the_curve_is_that_of_a_turning_circle():
    """Of a ship that heels by 2.9° in it."""
    turn = simulate("s175", speed=9.0, rudder_deg=25.0, duration=2500.0, rtol=1e-9).metrics
    curve = spiral_curve("s175", 9.0)
    assert turn["heel_steady_deg"] > 2.0
    for name, metric in (
        ("yaw_rate_deg_s", "steady_yaw_rate_deg_s"),
        ("drift_deg", "steady_drift_deg"),
        ("speed_ratio", "speed_ratio"),
    ):
        there = CubicSpline(curve.rudder_deg, getattr(curve, name))(25.0)
        assert there == pytest.approx(turn[metric], rel=2e-4)
