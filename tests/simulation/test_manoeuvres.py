"""The manoeuvres: against another integrator, quadratures, closed forms, symmetries."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.integrate import quad, solve_ivp
from scipy.interpolate import CubicSpline

from pmmkit.base import DataError, PmmkitError, UnknownNameError
from pmmkit.equations import prepare
from pmmkit.models import Part, load_model, scaled
from pmmkit.simulation import MANOEUVRES, simulate, spiral_curve, stability
from pmmkit.simulation.machinery import as_it_reverses

SHIP = load_model("s175-3dof")
SPEEDS = {"s175-3dof": 9.0, "s175": 9.0, "kvlcc2-l7": 1.179, "esso190k": 8.23}


def spline(track, channel):
    return CubicSpline(track.t, getattr(track, channel))


def crossing(track, channel, level, after=0.0):
    """First instant at which the samples, joined by a spline, pass a level."""
    return next(t for t in spline(track, channel).solve(level, extrapolate=False) if t > after)


# Zigzag


def swing(ready, n, t, y, order, rate, lag, end):
    """Instant and states at an event by DOP853; the rudder, last of the states, goes to its order.

    It turns at its rate, or with a lag at (order - angle) / lag where that is slower.
    """

    def solved(t, y, turning, *events):
        return solve_ivp(
            lambda t, y: [*ready.rates(y[:-1], y[-1], n), turning(y[-1])],
            (t, t + 1e4),
            y,
            method="DOP853",
            rtol=1e-10,
            atol=1e-12,
            events=events,
        )

    def there(t, y):
        return y[-1] - order

    there.terminal = end.terminal = True
    if lag:
        result = solved(t, y, lambda angle: np.clip((order - angle) / lag, -rate, rate), end)
    else:
        if abs(order - y[-1]) > 1e-12:
            side = math.copysign(1.0, order - y[-1])
            result = solved(t, y, lambda angle: side * rate, end, there)
            t, y = float(result.t[-1]), result.y[:, -1]
            if len(result.t_events[0]):
                return t, y
        result = solved(t, y, lambda angle: 0.0, end)
    assert len(result.t_events[0]) == 1
    return float(result.t[-1]), result.y[:, -1]


def zigzag_by_scipy(name, rudder_deg, switch_deg, executes, lag):
    """Overshoots [deg] and times of the executes, with the logic of the helmsman written out."""
    model, speed = load_model(name), SPEEDS[name]
    ready = prepare(model, speed)
    n = ready.self_propulsion()
    part = "tanker_bis" if name == "esso190k" else "rudder_mmg"
    rate = math.radians(model.values(part)["rate_deg_s"])
    start = {"u": speed, "n": n}
    t, y = 0.0, np.array([*(start.get(state, 0.0) for state in ready.structure.states), 0.0])
    side, switch = math.copysign(1.0, rudder_deg), math.radians(switch_deg)
    overshoots, times = [], []
    for execute in range(executes):
        order = side * math.radians(abs(rudder_deg))
        if execute:

            def turned(t, y):
                return y[5]

            t, y = swing(ready, n, t, y, order, rate, lag, turned)
            overshoots.append(math.degrees(-side * y[2] - switch))
        if execute < executes - 1:

            def passed(t, y, side=side):
                return side * y[2] - switch

            t, y = swing(ready, n, t, y, order, rate, lag, passed)
            times.append(t)
        side = -side
    return overshoots, times


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "rudder_deg", "switch_deg", "lag"),
    [
        ("s175-3dof", 10.0, 10.0, 0.0),
        ("s175", -20.0, 20.0, 0.0),
        ("kvlcc2-l7", 10.0, 10.0, 0.0),
        ("kvlcc2-l7", -10.0, 10.0, 0.0),
        ("kvlcc2-l7", 20.0, 5.0, 0.0),
        ("esso190k", 10.0, 15.0, 0.0),
        ("s175-3dof", 20.0, 10.0, 1.5),
    ],
)
def test_a_zigzag_is_that_of_another_integrator(name, rudder_deg, switch_deg, lag):
    overshoots, times = zigzag_by_scipy(name, rudder_deg, switch_deg, 5, lag)
    found = simulate(
        name,
        "zigzag",
        speed=SPEEDS[name],
        rudder_deg=rudder_deg,
        switch_deg=switch_deg,
        rudder_law="lag" if lag else "ramp",
        rudder_lag=lag or 1.0,
        rtol=1e-10,
    ).metrics
    assert len(overshoots) == len(times) == 4
    for i, (overshoot, time) in enumerate(zip(overshoots, times, strict=True), start=1):
        assert found[f"overshoot_{i}_deg"] == pytest.approx(overshoot, abs=1e-5)
        assert found[f"time_execute_{i + 1}"] == pytest.approx(time, rel=1e-6)


@pytest.mark.parametrize(
    ("name", "speed", "rudder_deg", "rate", "expected", "near"),
    [
        ("s175-3dof", 6.0, 10.0, 2.34, (3.86, 4.58), 0.1),
        ("s175-3dof", 6.0, 20.0, 2.34, (7.23, 6.83), 0.1),
        ("s175-3dof", 12.0, 10.0, 2.34, (5.47, 6.22), 0.1),
        ("s175-3dof", 12.0, 20.0, 2.34, (11.34, 10.57), 0.1),
        ("s175", 6.0, 10.0, 2.34, (4.03, 5.07), 0.1),
        ("s175", 6.0, 20.0, 2.34, (7.85, 7.21), 0.1),
        ("s175", 12.0, 10.0, 2.34, (7.26, 10.33), 0.1),
        ("s175", 12.0, 20.0, 2.34, (19.14, 13.72), 0.15),
        ("kvlcc2-l7", 1.179, 10.0, None, (4.98, 13.6), 0.1),
        ("kvlcc2-l7", 1.179, -10.0, None, (7.03, 8.81), 0.1),
        ("kvlcc2-l7", 1.179, 20.0, None, (10.5, 15.7), 0.1),
        ("kvlcc2-l7", 1.179, -20.0, None, (13.7, 11.7), 0.1),
        ("kcs", 12.347, 10.0, None, (6.17, 12.3), 0.15),
        ("kcs", 12.347, -10.0, None, (7.88, 9.48), 0.15),
        ("kcs", 12.347, 20.0, None, (14.0, 16.5), 0.25),
        ("kcs", 12.347, -20.0, None, (16.4, 14.2), 0.25),
    ],
)
def test_zigzags_as_other_programs_compute_them(name, speed, rudder_deg, rate, expected, near):
    """First and second overshoot by another port of the same public coefficients, rounded.

    Its S175 has a steering gear of 2.34°/s; its KCS runs 24 knots.
    """
    found = simulate(
        name,
        "zigzag",
        speed=speed,
        rudder_deg=rudder_deg,
        switch_deg=abs(rudder_deg),
        rudder_rate_deg=rate,
    ).metrics
    assert found["overshoot_1_deg"] == pytest.approx(expected[0], abs=near)
    assert found["overshoot_2_deg"] == pytest.approx(expected[1], abs=near)


@pytest.mark.slow
@pytest.mark.parametrize("name", ["s175-3dof", "s175"])
@pytest.mark.parametrize(
    ("manoeuvre", "given"),
    [
        ("zigzag", {"rudder_deg": 10.0}),
        ("initial_turning", {"rudder_deg": 10.0}),
        ("course_change", {"rudder_deg": 20.0}),
        ("williamson", {"rudder_deg": 35.0}),
        ("pull_out", {"rudder_deg": 15.0}),
    ],
)
def test_to_port_a_symmetric_ship_does_the_mirror_image(name, manoeuvre, given):
    one = simulate(name, manoeuvre, speed=9.0, rtol=1e-10, **given)
    other = simulate(
        name, manoeuvre, speed=9.0, rtol=1e-10, **{**given, "rudder_deg": -given["rudder_deg"]}
    )
    m = min(len(one), len(other)) - 1
    assert abs(len(one) - len(other)) <= 1
    np.testing.assert_allclose(other.psi[:m], -one.psi[:m], rtol=0, atol=1e-7)
    np.testing.assert_allclose(other.y[:m], -one.y[:m], rtol=0, atol=1e-4)
    np.testing.assert_allclose(other.x[:m], one.x[:m], rtol=0, atol=1e-4)
    for key, value in one.metrics.items():
        if manoeuvre == "williamson" and key == "heading_end_deg":
            assert (value, other.metrics[key]) == pytest.approx((-180.0, 180.0))
        elif "residual" not in key and key != "time_end":
            assert other.metrics[key] == pytest.approx(value, rel=1e-6), key


def test_the_overshoots_of_a_symmetric_ship_settle_to_one_value_a_tanker_keeps_two():
    """After the first execute the zigzag goes towards a cycle; to both sides alike on the S175."""
    symmetric = simulate(SHIP, "zigzag", speed=9.0, executes=12).metrics
    last = [symmetric[f"overshoot_{i}_deg"] for i in (10, 11)]
    assert last[0] == pytest.approx(last[1], abs=0.005)
    sided = simulate("kvlcc2-l7", "zigzag", speed=1.179, executes=12).metrics
    assert abs(sided["overshoot_10_deg"] - sided["overshoot_11_deg"]) > 2.0


def test_fewer_executes_are_the_beginning_of_more():
    few = simulate(SHIP, "zigzag", speed=9.0, executes=3).metrics
    more = simulate(SHIP, "zigzag", speed=9.0, executes=6).metrics
    for key in set(few) - {"speed_ratio_end"}:
        assert few[key] == pytest.approx(more[key], rel=1e-7), key
    assert "overshoot_5_deg" in more
    assert "overshoot_3_deg" not in few


@pytest.mark.parametrize("name", ["s175", "kvlcc2-l7"])
def test_model_and_ship_have_the_same_overshoots_at_the_same_froude_number(name):
    large, ratio = load_model(name), 0.04
    small = scaled(large, large.ship.L * ratio)
    speed = SPEEDS[name]
    one = simulate(large, "zigzag", speed=speed, rtol=1e-11).metrics
    other = simulate(small, "zigzag", speed=speed * math.sqrt(ratio), rtol=1e-11).metrics
    for key, value in one.items():
        factor = math.sqrt(ratio) if key.startswith(("time", "reach", "period", "initial")) else 1
        assert other[key] == pytest.approx(value * factor, rel=1e-8), key


def test_the_samples_of_a_zigzag_show_its_numbers():
    track = simulate("kvlcc2-l7", "zigzag", speed=1.179, dt=0.05)
    found, psi, side = track.metrics, spline(track, "psi"), 1.0
    turns = psi.derivative().roots(extrapolate=False)
    assert len(track.orders) == 5
    assert found["time_execute_2"] == found["initial_turning_time"] == track.orders[1]
    for i in range(1, 5):
        begin = track.orders[i]
        assert math.degrees(side * psi(begin)) == pytest.approx(10.0, abs=1e-4)
        top = next(t for t in (*turns, track.t[-1]) if t > begin)
        over = math.degrees(side * psi(top)) - 10.0
        assert found[f"overshoot_{i}_deg"] == pytest.approx(over, abs=1e-4)
        side = -side
    zero = [t for t in psi.roots(extrapolate=False) if t > track.orders[1]]
    assert found["reach"] == pytest.approx(zero[0], abs=1e-4)
    assert found["period"] == pytest.approx(zero[2] - zero[0], abs=1e-4)
    assert found["speed_ratio_end"] == pytest.approx(
        math.hypot(track.u[-1], track.v[-1]) / 1.179, rel=1e-6
    )
    assert np.max(np.abs(track.delta)) == pytest.approx(math.radians(10.0))


@pytest.mark.slow
def test_the_first_overshoot_does_not_know_how_many_executes_follow():
    """The Mariner to port, 20/20: the peak lies just after the beginning of a step."""
    one, two = (
        simulate("mariner", "zigzag", speed=7.7175, rudder_deg=-20, switch_deg=20, executes=n)
        for n in (2, 3)
    )
    assert one.metrics["overshoot_1_deg"] == pytest.approx(two.metrics["overshoot_1_deg"], rel=1e-6)


def test_no_sample_of_a_zigzag_lies_beyond_its_overshoot():
    """The second peak of this one lies just after the beginning of a step."""
    track = simulate("kvlcc2-l7", "zigzag", speed=1.179, rudder_deg=20, switch_deg=10, dt=0.02)
    begin, end = track.orders[2:4]
    largest = np.max(-np.degrees(track.psi[(track.t >= begin) & (track.t <= end)]))
    assert largest - 10.0 <= track.metrics["overshoot_2_deg"] + 1e-7


def test_a_slower_steering_gear_overshoots_more():
    rates = (1.0, 2.0, 4.0, 8.0, 16.0)
    over = [
        simulate(SHIP, "zigzag", speed=9.0, rudder_rate_deg=rate).metrics["overshoot_1_deg"]
        for rate in rates
    ]
    assert over == sorted(over, reverse=True)
    assert over[0] - over[-1] > 3.0


# Turns


def test_the_samples_of_a_turn_show_its_numbers():
    track = simulate(SHIP, speed=9.0, dt=0.2)
    found = track.metrics
    quarter, half = (crossing(track, "psi", angle) for angle in (math.pi / 2, math.pi))
    assert found["time_90"] == pytest.approx(quarter, rel=1e-6)
    assert found["time_180"] == pytest.approx(half, rel=1e-6)
    assert found["advance"] == pytest.approx(float(spline(track, "x")(quarter)), rel=1e-6)
    assert found["transfer"] == pytest.approx(float(spline(track, "y")(quarter)), rel=1e-6)
    assert found["tactical_diameter"] == pytest.approx(float(spline(track, "y")(half)), rel=1e-6)


@pytest.mark.parametrize("name", ["s175", "s175-3dof", "kvlcc2-l7", "esso190k"])
@pytest.mark.parametrize(("rudder_deg", "heading_deg"), [(10.0, 10.0), (-20.0, 30.0)])
def test_initial_turning_is_the_way_along_the_turn_with_that_rudder(name, rudder_deg, heading_deg):
    speed = SPEEDS[name]
    pace = speed / load_model(name).ship.L
    turn = simulate(
        name, speed=speed, rudder_deg=rudder_deg, dt=0.005 / pace, duration=8.0 / pace, rtol=1e-10
    )
    side = math.copysign(1.0, rudder_deg)
    there = crossing(turn, "psi", side * math.radians(heading_deg))
    over_ground = np.hypot(turn.u, turn.v * np.cos(turn.phi))
    way = CubicSpline(turn.t, over_ground).integrate(0.0, there)
    found = simulate(
        name, "initial_turning", speed=speed, rudder_deg=rudder_deg, heading_deg=heading_deg
    )
    assert found.metrics["time_to_heading"] == pytest.approx(there, rel=1e-5)
    assert found.metrics["initial_turning_distance"] == pytest.approx(float(way), rel=3e-6)
    assert found.metrics["initial_turning_distance_L"] == pytest.approx(way / found.L, rel=3e-6)
    assert found.metrics["yaw_rate_deg_s"] == pytest.approx(
        math.degrees(side * float(spline(turn, "r")(there))), rel=1e-4
    )
    assert found.t[-1] == pytest.approx(there, rel=1e-5)


# Pull-out


def test_after_a_pull_out_a_stable_ship_runs_straight():
    found = simulate(SHIP, "pull_out", speed=9.0, rudder_deg=15.0).metrics
    assert abs(found["residual_share"]) < 1e-4
    assert found["residual_yaw_rate_deg_s"] == pytest.approx(
        found["residual_share"] * found["steady_yaw_rate_deg_s"]
    )
    turn = simulate(SHIP, speed=9.0, rudder_deg=15.0).metrics
    assert found["steady_yaw_rate_deg_s"] == pytest.approx(turn["steady_yaw_rate_deg_s"], rel=2e-3)


def test_the_yaw_rate_of_a_pull_out_dies_away_at_the_slower_eigenvalue():
    """After a turn so slight that the speed is not lost, log r falls at λ U/L."""
    track = simulate(SHIP, "pull_out", speed=9.0, rudder_deg=0.2, rtol=1e-11)
    slower = max(stability(SHIP, 9.0).eigenvalues.real)
    amidships = track.orders[1]
    inside = (track.t > amidships + 4 * 175 / 9) & (track.t < amidships + 14 * 175 / 9)
    fall = np.polyfit(track.t[inside], np.log(track.r[inside]), 1)[0]
    assert fall == pytest.approx(slower * 9.0 / 175.0, rel=2e-3)


@pytest.mark.parametrize("rudder_deg", [15.0, -15.0])
def test_after_a_pull_out_the_unstable_tanker_turns_where_its_spiral_says(rudder_deg):
    """Its propeller pushes to port; with the rudder amidships only the turn to port is left."""
    track = simulate("esso190k", "pull_out", speed=8.23, rudder_deg=rudder_deg)
    curve = spiral_curve("esso190k", 8.23)
    port = curve.yaw_rate_deg_s < -0.1
    left = np.interp(0.0, curve.rudder_deg[port], curve.yaw_rate_deg_s[port])
    assert left < -0.1
    assert math.degrees(track.r[-1]) == pytest.approx(left, rel=5e-3)
    side = math.copysign(1.0, rudder_deg)
    assert track.metrics["residual_yaw_rate_deg_s"] == pytest.approx(side * left, rel=5e-3)


# Stopping and accelerating


def test_a_ship_without_thrust_coasts_as_the_closed_form_says():
    """u̇ = -k u²: u = u₁/(1 + k u₁ τ), way ln(1 + k u₁ τ)/k, with k = -Xuu / ((m' + mx') L)."""
    track = simulate(SHIP, "stopping", speed=9.0, turns=0.0, dt=5.0, rtol=1e-11)
    k = 0.0004226 / ((0.00792 + 0.000238) * 175.0)
    first = int(np.argmax(track.n == 0.0))
    assert first > 0
    u1, since = track.u[first], track.t[first:] - track.t[first]
    assert since[-1] > 100 * 175 / 9
    np.testing.assert_allclose(track.u[first:], u1 / (1 + k * u1 * since), rtol=1e-8)
    np.testing.assert_allclose(
        track.x[first:] - track.x[first], np.log1p(k * u1 * since) / k, rtol=1e-7, atol=1e-6
    )
    assert any("does not stop" in note for note in track.notes)
    for key in ("time_to_stop", "head_reach", "track_reach", "heading_at_stop_deg"):
        assert math.isnan(track.metrics[key])


@pytest.mark.parametrize(("name", "turns"), [("s175-3dof", -0.7), ("kvlcc2-l7", -0.3)])
def test_time_and_way_of_a_straight_stop_are_quadratures_over_the_speed(name, turns):
    """With the propeller steady astern, time is ∫du/u̇ and way ∫u du/u̇, from u₁ to 0."""
    speed = SPEEDS[name]
    given = {"turns": turns, "reversal_s": 20.0}
    ready = prepare(as_it_reverses(load_model(name), speed, **given), speed)
    track = simulate(name, "stopping", speed=speed, rtol=1e-10, **given)
    n = turns * ready.self_propulsion()
    first = int(np.argmax(np.abs(track.n - n) < 1e-12 * abs(n)))
    assert 0 < first < len(track) - 20

    def slowing(u):
        return -ready.accelerations(u, 0.0, 0.0, n=n)[0]

    u1 = float(track.u[first])
    time = quad(lambda u: 1.0 / slowing(u), 0.0, u1, epsrel=1e-9)[0]
    way = quad(lambda u: u / slowing(u), 0.0, u1, epsrel=1e-9)[0]
    found = track.metrics
    assert found["time_to_stop"] == pytest.approx(track.t[first] + time, rel=1e-6)
    assert found["head_reach"] == pytest.approx(track.x[first] + way, rel=1e-6)
    assert found["track_reach"] == pytest.approx(found["head_reach"], rel=1e-6)
    if name == "s175-3dof":
        assert found["lateral_deviation"] == found["heading_at_stop_deg"] == 0.0


def test_the_numbers_of_a_crash_stop_are_integrals_of_the_velocities():
    track = simulate("esso190k", "stopping", speed=8.23, dt=0.5, rtol=1e-10)
    found = track.metrics
    along = track.u * np.cos(track.psi) - track.v * np.sin(track.psi)
    across = track.u * np.sin(track.psi) + track.v * np.cos(track.psi)
    end = track.t[-1]
    assert found["time_to_stop"] == pytest.approx(end, rel=1e-12)
    assert track.u[-1] == pytest.approx(0.0, abs=1e-6)
    assert np.all(track.u[:-1] > 0.0)
    for key, rate in (
        ("head_reach", along),
        ("lateral_deviation", across),
        ("track_reach", np.hypot(track.u, track.v)),
    ):
        whole = float(CubicSpline(track.t, rate).integrate(0.0, end))
        assert found[key] == pytest.approx(whole, rel=1e-5), key
        assert found[f"{key}_L"] == pytest.approx(found[key] / 304.8)
    assert found["track_reach"] > math.hypot(found["head_reach"], found["lateral_deviation"])
    assert found["heading_at_stop_deg"] == pytest.approx(
        math.degrees(CubicSpline(track.t, track.r).integrate(0.0, end)), rel=1e-6
    )


def test_the_propeller_of_the_tanker_goes_astern_with_its_time_constant():
    """ṅ = (n_order - n)/50 s after the order of -0.7 n₀ at once."""
    track = simulate("esso190k", "stopping", speed=8.23, turns=-0.7)
    n0 = track.n[0]
    expected = n0 * (-0.7 + 1.7 * np.exp(-track.t / 50.0))
    np.testing.assert_allclose(track.n, expected, rtol=0, atol=1e-6 * n0)


def test_more_revolutions_astern_stop_sooner():
    reach = [
        simulate("esso190k", "stopping", speed=8.23, turns=turns).metrics["track_reach_L"]
        for turns in (-0.4, -0.7, -1.0)
    ]
    assert reach[0] > reach[1] > reach[2] > 0


@pytest.mark.parametrize("turns", [1.5, 0.6])
def test_speed_follows_revolutions_where_all_goes_with_the_square(turns):
    """Resistance and thrust are quadratic, so J ends where it began: u/u₀ = n/n₀."""
    track = simulate(SHIP, "accelerating", speed=7.0, turns=turns, rtol=1e-10)
    found = track.metrics
    assert found["speed_ratio"] == pytest.approx(turns, rel=1e-3)
    assert found["final_speed"] == pytest.approx(7.0 * found["speed_ratio"])
    assert found["distance"] == track.x[-1]
    assert np.all(np.diff(track.u) * (turns - 1.0) >= 0.0)


def test_way_of_an_acceleration_is_a_quadrature_over_the_speed():
    track = simulate(SHIP, "accelerating", speed=7.0, turns=1.4, rtol=1e-10)
    ready = prepare(SHIP, 7.0)
    n = 1.4 * ready.self_propulsion()
    first = int(np.argmax(np.abs(track.n - n) < 1e-12 * n))
    last = first + 100

    def gaining(u):
        return ready.accelerations(u, 0.0, 0.0, n=n)[0]

    ends = float(track.u[first]), float(track.u[last])
    assert ends[1] - ends[0] > 1.0
    time = quad(lambda u: 1.0 / gaining(u), *ends)[0]
    way = quad(lambda u: u / gaining(u), *ends)[0]
    assert track.t[last] - track.t[first] == pytest.approx(time, rel=1e-6)
    assert track.x[last] - track.x[first] == pytest.approx(way, rel=1e-6)


# Course change and Williamson turn


@pytest.mark.parametrize("name", ["s175-3dof", "kvlcc2-l7", "esso190k"])
@pytest.mark.parametrize("rudder_deg", [15.0, -15.0])
def test_a_course_change_lays_the_rudder_over_on_the_heading_and_ends_without_turning(
    name, rudder_deg
):
    track = simulate(
        name,
        "course_change",
        speed=SPEEDS[name],
        rudder_deg=rudder_deg,
        heading_deg=40.0,
        dt=0.01 * load_model(name).ship.L / SPEEDS[name],
    )
    found, side = track.metrics, math.copysign(1.0, rudder_deg)
    assert found["time_counter"] == pytest.approx(
        crossing(track, "psi", side * math.radians(40.0)), rel=1e-5
    )
    assert found["time_end"] == track.t[-1]
    assert track.r[-1] == pytest.approx(0.0, abs=1e-7 * np.max(np.abs(track.r)))
    assert found["heading_end_deg"] == pytest.approx(side * math.degrees(track.psi[-1]), rel=1e-9)
    assert found["heading_end_deg"] == pytest.approx(np.degrees(np.max(side * track.psi)), rel=1e-9)
    assert found["overshoot_deg"] == pytest.approx(found["heading_end_deg"] - 40.0)
    assert found["overshoot_deg"] > 0
    assert (found["advance"], found["transfer"]) == pytest.approx((track.x[-1], side * track.y[-1]))


def test_the_first_swing_of_a_zigzag_is_a_course_change():
    change = simulate(SHIP, "course_change", speed=9.0, rudder_deg=20.0, heading_deg=20.0).metrics
    swing = simulate(SHIP, "zigzag", speed=9.0, rudder_deg=20.0, switch_deg=20.0).metrics
    assert change["overshoot_deg"] == pytest.approx(swing["overshoot_1_deg"], rel=1e-7)
    assert change["time_counter"] == pytest.approx(swing["time_execute_2"], rel=1e-12)


def test_more_counter_rudder_less_overshoot():
    over = [
        simulate(SHIP, "course_change", speed=9.0, counter_deg=counter).metrics["overshoot_deg"]
        for counter in (5.0, 10.0, 20.0, 35.0)
    ]
    assert over == sorted(over, reverse=True)


def test_a_course_change_meets_the_heading_asked_for_when_the_counter_rudder_comes_early():
    """Ordered at the heading less the overshoot found before, the ship ends on its course."""
    asked, heading = 45.0, 45.0
    for _ in range(6):
        found = simulate(SHIP, "course_change", speed=9.0, heading_deg=heading).metrics
        heading += asked - found["heading_end_deg"]
    assert found["heading_end_deg"] == pytest.approx(asked, abs=1e-3)
    assert heading < asked


@pytest.mark.parametrize("name", ["s175-3dof", "kvlcc2-l7", "esso190k"])
@pytest.mark.parametrize("rudder_deg", [35.0, -35.0])
def test_a_williamson_turn_goes_back_along_its_own_track(name, rudder_deg):
    track = simulate(name, "williamson", speed=SPEEDS[name], rudder_deg=rudder_deg)
    found, side = track.metrics, math.copysign(1.0, rudder_deg)
    assert found["heading_end_deg"] == pytest.approx(-side * 180.0, abs=1e-3)
    assert found["time_shift"] == pytest.approx(
        crossing(track, "psi", side * math.radians(60.0)), rel=1e-5
    )
    assert found["time_ease"] == pytest.approx(
        crossing(track, "psi", -side * math.radians(160.0)), rel=1e-5
    )
    assert (found["advance"], found["offset"]) == pytest.approx((track.x[-1], side * track.y[-1]))
    plain = simulate(name, speed=SPEEDS[name], rudder_deg=rudder_deg).metrics
    assert abs(found["offset"]) < 0.5 * plain["tactical_diameter"]
    assert track.u[-1] * math.cos(track.psi[-1]) < 0.0


# Wind and current


@pytest.mark.slow
@pytest.mark.parametrize(
    ("manoeuvre", "given"),
    [("turning", {"duration": 400.0}), ("zigzag", {}), ("williamson", {}), ("stopping", {})],
)
def test_a_current_carries_the_whole_manoeuvre_along(manoeuvre, given):
    still = simulate("s175", manoeuvre, speed=9.0, rtol=1e-11, dt=2.0, **given)
    drift = simulate(
        "s175",
        manoeuvre,
        speed=9.0,
        rtol=1e-11,
        dt=2.0,
        current_speed=1.5,
        current_direction_deg=120.0,
        **given,
    )
    assert len(still) == len(drift)
    along, across = 1.5 * math.cos(math.radians(120)), 1.5 * math.sin(math.radians(120))
    np.testing.assert_allclose(drift.x, still.x + along * still.t, rtol=0, atol=1e-4)
    np.testing.assert_allclose(drift.y, still.y + across * still.t, rtol=0, atol=1e-4)
    for channel in ("psi", "u", "v", "r", "phi", "delta", "n"):
        engine = 1e-6 if channel == "n" else 1e-7  # which starting air turns: a kink
        np.testing.assert_allclose(
            getattr(drift, channel), getattr(still, channel), rtol=0, atol=engine
        )


def test_lengths_of_a_turn_are_taken_over_ground():
    still = simulate(SHIP, speed=9.0).metrics
    drift = simulate(SHIP, speed=9.0, current_speed=1.0, current_direction_deg=90.0).metrics
    assert drift["advance"] == pytest.approx(still["advance"], rel=1e-6)
    assert drift["transfer"] == pytest.approx(still["transfer"] + still["time_90"], rel=1e-6)
    assert drift["tactical_diameter"] == pytest.approx(
        still["tactical_diameter"] + still["time_180"], rel=1e-6
    )
    assert drift["steady_diameter"] == pytest.approx(still["steady_diameter"], rel=1e-6)


SAIL = SHIP.with_(
    parts={**SHIP.parts, "wind": Part(effect="wind", values={"AF": 500.0, "AL": 2800.0})}
)


def sail(manoeuvre, **given):
    return simulate(SAIL, manoeuvre, speed=9.0, compiled=False, **given)


@pytest.mark.parametrize("direction", [0.0, 180.0])
@pytest.mark.parametrize("manoeuvre", ["stopping", "accelerating"])
def test_wind_from_ahead_or_astern_does_not_turn_a_symmetric_ship(manoeuvre, direction):
    track = sail(manoeuvre, wind_speed=15.0, wind_direction_deg=direction)
    assert track.x[-1] > 0.0
    np.testing.assert_allclose(track.y, 0.0, atol=1e-4)
    np.testing.assert_allclose(track.psi, 0.0, atol=1e-7)


def test_a_head_wind_takes_revolutions_and_stops_the_ship_sooner():
    given = [{"wind_speed": 15.0, "wind_direction_deg": direction} for direction in (0.0, 180.0)]
    ahead, astern = (sail("stopping", revolutions=1.4, **wind) for wind in given)
    assert ahead.metrics["track_reach"] < astern.metrics["track_reach"]
    ahead, astern = (sail("stopping", **wind) for wind in given)
    assert ahead.n[0] > astern.n[0]


def test_resistance_of_the_wind_is_in_the_revolutions_of_the_approach():
    """Thrust less deduction = hull resistance + ½ ρ CX AF (U + W)², cx = 0.7."""
    n = sail("accelerating", wind_speed=10.0).n[0]
    J = 9.0 * (1 - 0.184) / (n * 6.533)
    thrust = (1 - 0.175) * 1025.0 * n**2 * 6.533**4 * (0.527 - 0.455 * J)
    hull = 0.0004226 * 0.5 * 1025.0 * 175.0**2 * 9.0**2
    assert thrust == pytest.approx(hull + 0.5 * 1.225 * 0.7 * 500.0 * 19.0**2, rel=1e-9)


def test_wind_from_the_other_side_mirrors_the_turn():
    one = sail("turning", wind_speed=12.0, wind_direction_deg=50.0, duration=300.0)
    other = sail(
        "turning", wind_speed=12.0, wind_direction_deg=-50.0, rudder_deg=-35.0, duration=300.0
    )
    np.testing.assert_allclose(other.y, -one.y, rtol=0, atol=1e-4)
    calm = sail("turning", duration=300.0)
    assert np.max(np.abs(one.y - calm.y)) > 10.0


def test_air_and_water_that_move_together_are_calm():
    calm = sail("zigzag", rtol=1e-11, dt=2.0)
    moving = sail(
        "zigzag",
        rtol=1e-11,
        dt=2.0,
        wind_speed=8.0,
        wind_direction_deg=-30.0,
        current_speed=8.0,
        current_direction_deg=150.0,
    )
    for channel in ("psi", "u", "v", "r"):
        np.testing.assert_allclose(
            getattr(moving, channel), getattr(calm, channel), rtol=0, atol=1e-7
        )


# Every manoeuvre


@pytest.mark.slow
@pytest.mark.parametrize(
    "manoeuvre",  # one that is held straight has a structure of its own: 10 s to compile
    sorted(
        name
        for name, item in MANOEUVRES.items()
        if name not in ("turning", "zigzag") and not item.held_straight
    ),
)
@pytest.mark.parametrize("name", ["s175", "esso190k"])
def test_interpreted_and_compiled_agree(name, manoeuvre):
    given = {"rudder_deg": 10.0, "step_deg": 10.0} if manoeuvre == "spiral" else {}
    speed = SPEEDS[name]
    fast = simulate(name, manoeuvre, speed=speed, compiled=True, **given)
    slow = simulate(name, manoeuvre, speed=speed, compiled=False, **given)
    assert slow.metrics.keys() == fast.metrics.keys()
    for key, value in fast.metrics.items():
        assert slow.metrics[key] == pytest.approx(value, rel=1e-8, abs=1e-6), key


@pytest.mark.parametrize("manoeuvre", sorted(MANOEUVRES))
def test_positions_are_integrals_of_the_velocities(manoeuvre):
    given = {"rudder_deg": 5.0, "step_deg": 5.0} if manoeuvre == "spiral" else {}
    track = simulate("kvlcc2-l7", manoeuvre, speed=1.179, dt=0.1, rtol=1e-10, **given)
    along = track.u * np.cos(track.psi) - track.v * np.sin(track.psi)
    across = track.u * np.sin(track.psi) + track.v * np.cos(track.psi)
    for channel, rate in (("x", along), ("y", across), ("psi", track.r)):
        integral = CubicSpline(track.t, rate).antiderivative()(track.t)
        span = max(np.ptp(integral), 1e-3)
        assert np.max(np.abs(getattr(track, channel) - integral)) < 3e-5 * span


@pytest.mark.parametrize("manoeuvre", sorted(MANOEUVRES))
def test_the_rudder_never_turns_faster_than_its_gear(manoeuvre):
    given = {"rudder_deg": 5.0, "step_deg": 5.0} if manoeuvre == "spiral" else {}
    track = simulate(SHIP, manoeuvre, speed=9.0, dt=0.5, rudder_rate_deg=1.5, **given)
    rates = np.abs(np.diff(np.degrees(track.delta)) / np.diff(track.t))
    assert np.max(rates) <= 1.5 * (1 + 1e-9)
    if manoeuvre not in ("stopping", "accelerating", "straight", "astern_to_ahead"):
        assert np.max(rates) == pytest.approx(1.5)


def test_an_interval_without_a_decimal_point_is_the_same_interval():
    whole, point = (simulate(SHIP, "initial_turning", speed=9.0, dt=dt) for dt in (1, 1.0))
    np.testing.assert_array_equal(whole.t, point.t)
    np.testing.assert_array_equal(whole.psi, point.psi)


# What is refused


@pytest.mark.parametrize(
    ("manoeuvre", "given", "named"),
    [
        ("zigzag", {"switch_deg": -10.0}, "switch_deg"),
        ("zigzag", {"rudder_deg": 0.0}, "rudder_deg"),
        ("zigzag", {"rudder_deg": 91.0}, "rudder_deg"),
        ("zigzag", {"rudder_deg": math.nan}, "rudder_deg"),
        ("zigzag", {"executes": 1}, "two executes"),
        ("zigzag", {"executes": -3}, "executes"),
        ("zigzag", {"executes": True}, "executes"),
        ("zigzag", {"heading_deg": 10.0}, "heading_deg"),
        ("turning", {"switch_deg": 10.0}, "switch_deg"),
        ("turning", {"duration": "long"}, "duration"),
        ("initial_turning", {"heading_deg": 0.0}, "heading_deg"),
        ("spiral", {"step_deg": 30.0}, "step_deg"),
        ("spiral", {"step_deg": math.inf}, "step_deg"),
        ("stopping", {"turns": math.inf}, "turns"),
        ("stopping", {"turns": "astern"}, "turns"),
        ("accelerating", {"turns": math.nan}, "turns"),
        ("course_change", {"counter_deg": -1.0}, "counter_deg"),
        ("williamson", {"shift_deg": 0.0}, "shift_deg"),
        ("williamson", {"ease_deg": math.nan}, "ease_deg"),
    ],
)
def test_a_setting_that_makes_no_sense_is_named(manoeuvre, given, named):
    with pytest.raises(DataError, match=named):
        simulate(SHIP, manoeuvre, speed=9.0, **given)


def test_all_wrong_settings_are_named_at_once():
    with pytest.raises(DataError) as caught:
        simulate(SHIP, "zigzag", speed=0.0, rudder_deg=0.0, switch_deg=-1.0, loops=3, depth=-2.0)
    assert len(caught.value.problems) == 5


def test_the_manoeuvres_there_are_are_listed():
    with pytest.raises(UnknownNameError) as caught:
        simulate(SHIP, "zig-zag", speed=9.0)
    for name in MANOEUVRES:
        assert name in str(caught.value)


def test_half_an_execute_is_refused():
    with pytest.raises(DataError, match="executes"):
        simulate(SHIP, "zigzag", speed=9.0, executes=3.5)


@pytest.mark.parametrize(
    "given",
    [
        {"wind_speed": math.nan},
        {"wind_speed": -3.0},
        {"wind_speed": 5.0, "wind_direction_deg": math.inf},
        {"current_speed": math.nan},
        {"current_speed": 1.0, "current_direction_deg": math.inf},
    ],
)
def test_wind_and_current_that_make_no_sense_are_refused(given):
    with pytest.raises(DataError, match=next(reversed(given))):
        sail("zigzag", **given)


@pytest.mark.parametrize("given", [{"ease_deg": 200.0}, {"shift_deg": 400.0}])
def test_a_williamson_turn_of_impossible_angles_is_refused(given):
    with pytest.raises(PmmkitError, match=next(iter(given))):
        simulate(SHIP, "williamson", speed=9.0, **given)


def test_a_straight_run_of_a_symmetric_ship_stays_straight_and_at_its_speed():
    track = simulate("s175-3dof", "straight", speed=8.0, duration=200.0, compiled=False)
    assert track.t[-1] == pytest.approx(200.0)
    assert track.metrics["final_speed"] == pytest.approx(8.0, rel=1e-6)
    assert abs(track.metrics["lateral_deviation"]) < 1e-6
    assert np.all(track.delta == 0.0)


def test_a_weave_lays_the_rudder_over_by_the_clock():
    """A quarter of the period, then halves; the ship weaves with the period of her rudder."""
    track = simulate(
        "s175-3dof", "weave", speed=8.0, rudder_deg=15.0, period=120.0, cycles=3, compiled=False
    )
    assert track.orders == pytest.approx([0.0, *(30.0 + 60.0 * np.arange(6))])
    held = np.interp([25.0, 85.0, 145.0], track.t, np.degrees(track.delta))
    assert held == pytest.approx([15.0, -15.0, 15.0])
    late, early = (np.interp(np.arange(130.0, 250.0) + x, track.t, track.r) for x in (120.0, 0.0))
    assert np.abs(late - early).max() < 0.1 * np.abs(early).max()
