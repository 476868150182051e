"""Motion of captive tests: closed forms against numerical differentiation of the path."""

from __future__ import annotations

import math

import numpy as np
import pytest
import xarray as xr
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import cumulative_simpson

from pmmkit import Run
from pmmkit.base import CampaignError
from pmmkit.campaigns import RUN_SETTINGS, TEST_KINDS, Settings
from pmmkit.effects import State

UC, PERIOD, SWAY, YAW, RUDDER, DRIFT, PHASE = 1.5, 12.0, 0.35, 0.3, 0.5, 0.12, 0.7
OMEGA = 2 * math.pi / PERIOD
OSCILLATING = [kind.name for kind in TEST_KINDS.values() if kind.oscillates]


def run_of(test: str, **changes: object) -> Run:
    given_ = {
        "speed": UC,
        "period": PERIOD,
        "amplitude": SWAY,
        "yaw_amplitude": YAW,
        "rudder_amplitude": RUDDER,
        "phase": PHASE,
        **{item.name: item.typical for item in RUN_SETTINGS.brought if item.typical is not None},
    } | changes
    settings = Settings.of(given_)
    return Run(id=f"{test}_1", test=test, kind="history", settings=settings, loader=lambda: None)


def path(test: str, t: np.ndarray, drift: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Earth-fixed path and heading as design.md words them; y of a yaw test by quadrature."""
    theta = OMEGA * t + PHASE
    x, y, psi = UC * t, np.zeros_like(t), np.zeros_like(t)
    if test == "pure_surge":
        x = UC * t + SWAY * np.sin(theta)
    if test in ("pure_sway", "sway_yaw"):
        y = SWAY * np.sin(theta)
    if test in ("pure_yaw", "yaw_drift", "yaw_rudder"):
        psi = YAW * np.sin(theta)
        y = cumulative_simpson(UC * np.tan(psi), x=t, initial=0.0)
    if test == "sway_yaw":
        psi = -YAW * np.cos(theta)
    return x, y, psi + drift


@pytest.mark.parametrize("drift", [0.0, DRIFT, -0.4])
@pytest.mark.parametrize("test", OSCILLATING)
def test_velocities_are_the_derivatives_of_the_path(test: str, drift: float) -> None:
    t = np.linspace(0.0, 15.0, 15001)
    x, y, psi = path(test, t, drift)
    xdot, ydot = np.gradient(x, t), np.gradient(y, t)
    u = xdot * np.cos(psi) + ydot * np.sin(psi)
    v = -xdot * np.sin(psi) + ydot * np.cos(psi)
    r = np.gradient(psi, t)
    expected = {
        "u": u,
        "v": v,
        "r": r,
        "udot": np.gradient(u, t),
        "vdot": np.gradient(v, t),
        "rdot": np.gradient(r, t),
    }
    state = run_of(test, drift=drift).nominal_motion(t)
    inner = slice(10, -10)
    for name, value in expected.items():
        np.testing.assert_allclose(getattr(state, name)[inner], value[inner], atol=2e-6)


def test_pure_yaw_has_no_sway_at_all() -> None:
    state = run_of("pure_yaw").nominal_motion(np.linspace(0, 20, 99))
    assert not state.v.any()
    assert not state.vdot.any()
    assert np.ptp(state.u) == pytest.approx(UC / math.cos(YAW) - UC, rel=0.01)


def test_pure_sway_keeps_the_carriage_speed_ahead_exactly() -> None:
    state = run_of("pure_sway").nominal_motion(np.linspace(0, 20, 99))
    assert (state.u == UC).all()
    assert not state.udot.any()
    assert not state.r.any()


def test_surge_acceleration_of_pure_yaw_is_u_r_tan_heading() -> None:
    t = np.linspace(0, PERIOD, 50)
    state = run_of("pure_yaw").nominal_motion(t)
    psi = YAW * np.sin(OMEGA * t + PHASE)
    np.testing.assert_allclose(state.udot, state.u * state.r * np.tan(psi), atol=1e-14)


def test_drift_angle_of_yaw_with_drift_is_constant() -> None:
    state = run_of("yaw_drift", drift=DRIFT).nominal_motion(np.linspace(0, 20, 99))
    np.testing.assert_allclose(np.arctan2(-state.v, state.u), DRIFT, atol=1e-15)


def test_yaw_rate_and_sway_velocity_of_sway_yaw_are_in_quadrature() -> None:
    theta = np.linspace(0, 2 * np.pi, 200, endpoint=False)
    state = run_of("sway_yaw").motion_at_phase(theta)
    np.testing.assert_allclose(state.r, YAW * OMEGA * np.sin(theta), atol=1e-15)
    assert abs(np.mean(state.v * np.sin(theta))) < 1e-14
    assert np.mean(state.v * np.cos(theta)) > 0.1


@pytest.mark.parametrize("test", ["static_drift", "resistance", "drift_rudder", "propulsion"])
def test_static_tests_have_velocity_components_of_the_drift_angle(test: str) -> None:
    run = run_of(test, drift=DRIFT, heel=0.1, rudder=-0.2, propeller_rps=9.9)
    state = run.nominal_motion(np.arange(5.0))
    np.testing.assert_allclose(state.u, UC * math.cos(DRIFT))
    np.testing.assert_allclose(state.v, -UC * math.sin(DRIFT))
    assert (state.phi == 0.1).all()
    assert (state.delta == -0.2).all()
    assert (state.rps == 9.9).all()
    for name in ("r", "udot", "vdot", "rdot", "p", "pdot", "thrust"):
        assert not getattr(state, name).any()


def test_circular_motion_runs_its_circle_in_one_turn() -> None:
    """Integrated over 2πR/U, the path of midship closes, and its mean radius is R."""
    radius = 8.0
    t = np.linspace(0, 2 * math.pi * radius / UC, 4001)
    state = run_of("circular_motion", radius=radius, drift=DRIFT).nominal_motion(t)
    psi = cumulative_simpson(state.r, x=t, initial=0.0)
    x = cumulative_simpson(state.u * np.cos(psi) - state.v * np.sin(psi), x=t, initial=0.0)
    y = cumulative_simpson(state.u * np.sin(psi) + state.v * np.cos(psi), x=t, initial=0.0)
    assert math.hypot(x[-1], y[-1]) < 1e-8
    assert math.hypot(x[2000], y[2000]) == pytest.approx(2 * radius, rel=1e-9)
    assert y[1000] > 0


def test_a_stated_yaw_rate_counts_before_the_radius() -> None:
    state = run_of("circular_motion", radius=8.0, yaw_rate=-0.1).nominal_motion([0.0])
    assert state.r == [-0.1]


@settings(max_examples=60, deadline=None)
@given(
    test=st.sampled_from(OSCILLATING),
    speed=st.floats(0.1, 12),
    period=st.floats(2, 60),
    sway=st.floats(0.01, 3),
    yaw=st.floats(0.01, 0.9),
    drift=st.floats(-0.6, 0.6),
    phase=st.floats(-3, 3),
    start=st.floats(-50, 50),
)
def test_accelerations_belong_to_the_velocities(
    test, speed, period, sway, yaw, drift, phase, start
):
    """Central differences of u, v, r give their rates, whatever the settings."""
    run = run_of(
        test,
        speed=speed,
        period=period,
        amplitude=sway,
        yaw_amplitude=yaw,
        drift=drift,
        phase=phase,
    )
    t = start + np.linspace(0, period, 40)
    h = period * 1e-5
    before, here, after = (run.nominal_motion(t + away) for away in (-h, 0.0, h))
    scale = speed + 2 * math.pi * (sway + yaw) / period
    for name in ("u", "v", "r"):
        slope = (getattr(after, name) - getattr(before, name)) / (2 * h)
        np.testing.assert_allclose(
            getattr(here, f"{name}dot"),
            slope,
            atol=2e-6 * 2 * math.pi / period * scale / math.cos(yaw) ** 3,
        )


def uneven(cycles: float = 3.3, n: int = 500, start: float = 2.1) -> np.ndarray:
    rng = np.random.default_rng(5)
    return start + np.sort(rng.uniform(0, cycles * PERIOD, n))


@pytest.mark.parametrize("drift", [0.0, DRIFT])
@pytest.mark.parametrize("test", OSCILLATING)
def test_measured_velocities_are_differentiated_through_their_series(test, drift) -> None:
    """A yaw motion of small angle is a short series; six harmonics leave next to nothing."""
    run, t = run_of(test, drift=drift, yaw_amplitude=0.1), uneven()
    truth = run.nominal_motion(t)
    data = xr.Dataset({name: ("t", getattr(truth, name)) for name in ("u", "v", "r")}, {"t": t})
    state = run_of(test, drift=0.0, amplitude=None, yaw_amplitude=None).measured_motion(data, t)
    for name in ("u", "v", "r", "udot", "vdot", "rdot"):
        np.testing.assert_allclose(getattr(state, name), getattr(truth, name), atol=2e-7)


@pytest.mark.slow
@pytest.mark.parametrize("of_carriage", [True, False])
@pytest.mark.parametrize("test", ["pure_surge", "pure_sway", "pure_yaw", "yaw_drift"])
def test_positions_give_the_velocities(test: str, of_carriage: bool) -> None:
    fine = np.linspace(0, 40, 400001)
    x, y, psi = path(test, fine, DRIFT)
    run, t = run_of(test, drift=DRIFT), uneven(3.0, 400)
    data = xr.Dataset(
        {
            "x": ("t", np.interp(t, fine, x - UC * fine * of_carriage)),
            "y": ("t", np.interp(t, fine, y)),
            "psi": ("t", np.interp(t, fine, psi)),
        },
        {"t": t},
    )
    blind = run_of(test, drift=0.0, phase=0.0, amplitude=None, yaw_amplitude=None)
    state, truth = blind.measured_motion(data, t), run.nominal_motion(t)
    for name in ("u", "v", "r", "udot", "vdot", "rdot"):
        np.testing.assert_allclose(getattr(state, name), getattr(truth, name), atol=2e-4)


def test_a_sway_displacement_alone_is_enough() -> None:
    run, t = run_of("pure_sway"), uneven()
    y = 0.36 * np.sin(OMEGA * t + 1.1)
    state = run.measured_motion(xr.Dataset({"y": ("t", y)}, {"t": t}), t)
    np.testing.assert_allclose(state.v, 0.36 * OMEGA * np.cos(OMEGA * t + 1.1), atol=1e-12)
    np.testing.assert_allclose(state.vdot, -(OMEGA**2) * y, atol=1e-12)
    assert np.allclose(state.u, UC)


def test_measured_channels_count_before_nominal_ones() -> None:
    run, t = run_of("pure_yaw", heel=0.02, rudder=0.1, propeller_rps=9.0), uneven(n=300)
    rng = np.random.default_rng(1)
    channels = {
        name: rng.normal(size=300)
        for name in ("u", "v", "r", "p", "udot", "vdot", "rdot", "pdot", "phi", "delta", "n", "T")
    }
    data = xr.Dataset({name: ("t", value) for name, value in channels.items()}, {"t": t})
    state = run.measured_motion(data, t)
    for name, value in channels.items():
        target = {"n": "rps", "T": "thrust"}.get(name, name)
        np.testing.assert_array_equal(getattr(state, target), value)


def test_nothing_measured_is_the_nominal_motion() -> None:
    run, t = run_of("yaw_drift", drift=DRIFT, rudder=0.1), uneven()
    data = xr.Dataset({"Y": ("t", t), "r": ("t", np.full_like(t, np.nan))}, {"t": t})
    state, nominal = run.measured_motion(data, t), run.nominal_motion(t)
    for name in ("u", "v", "r", "udot", "vdot", "rdot", "delta"):
        np.testing.assert_allclose(getattr(state, name), getattr(nominal, name), atol=1e-14)


def test_what_is_not_measured_follows_at_the_measured_phase() -> None:
    """A yaw rate half a radian ahead of the stated phase takes the surge velocity with it."""
    t = uneven()
    truth = run_of("pure_yaw", phase=PHASE + 0.5).nominal_motion(t)
    data = xr.Dataset({"r": ("t", truth.r)}, {"t": t})
    state = run_of("pure_yaw").measured_motion(data, t)
    np.testing.assert_allclose(state.u, truth.u, atol=1e-12)
    np.testing.assert_allclose(state.udot, truth.udot, atol=1e-12)


def test_gaps_in_a_channel_stay_gaps_and_do_not_spoil_its_derivative() -> None:
    run, t = run_of("pure_sway"), uneven()
    truth = run.nominal_motion(t)
    v = truth.v.copy()
    v[100:110] = np.nan
    state = run.measured_motion(xr.Dataset({"v": ("t", v)}, {"t": t}), t)
    assert np.isnan(state.v).sum() == 10
    np.testing.assert_allclose(state.vdot, truth.vdot, atol=1e-12)


def test_static_tests_take_measured_means_and_no_acceleration() -> None:
    run, t = run_of("static_drift", drift=DRIFT), np.linspace(0, 30, 301)
    rng = np.random.default_rng(2)
    psi = 0.13 + rng.normal(0, 1e-3, 301)
    state = run.measured_motion(xr.Dataset({"psi": ("t", psi)}, {"t": t}), t)
    np.testing.assert_allclose(state.v, -UC * math.sin(psi.mean()))
    assert not state.r.any()
    noisy = xr.Dataset({"u": ("t", UC + rng.normal(size=301))}, {"t": t})
    state = run.measured_motion(noisy, t)
    assert not state.udot.any()
    np.testing.assert_array_equal(state.u, noisy["u"])
    np.testing.assert_allclose(state.v, -UC * math.sin(DRIFT))


def test_means_hold_for_all_times_in_a_static_test_only() -> None:
    data = xr.Dataset({"u": 1.4, "v": -0.2, "delta": 0.05})
    state = run_of("static_drift").measured_motion(data, np.arange(4.0))
    assert (state.u == 1.4).all()
    t = uneven()
    state = run_of("pure_sway").measured_motion(data, t)
    np.testing.assert_allclose(state.v, run_of("pure_sway").nominal_motion(t).v)
    assert (state.delta == 0.05).all()


def test_harmonics_of_a_motion_are_summed() -> None:
    run = run_of("pure_sway").with_(kind="harmonics")
    data = xr.Dataset(
        {"v_cos": ("harmonic", [0.0, 0.2, 0.01]), "v_sin": ("harmonic", [0.0, 0.03, 0.0])},
        {"harmonic": [0, 1, 2]},
    )
    t = np.linspace(0, PERIOD, 64, endpoint=False)
    theta = OMEGA * t + PHASE
    expected = 0.2 * np.cos(theta) + 0.03 * np.sin(theta) + 0.01 * np.cos(2 * theta)
    state = run.measured_motion(data, t)
    np.testing.assert_allclose(state.v, expected, atol=1e-14)
    slope = OMEGA * (0.03 * np.cos(theta) - 0.2 * np.sin(theta) - 0.02 * np.sin(2 * theta))
    np.testing.assert_allclose(state.vdot, slope, atol=1e-14)
    np.testing.assert_allclose(run.displacement_phase(data, t), theta)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("test", "channel"),
    [
        ("pure_surge", "x"),
        ("pure_surge", "u"),
        ("pure_sway", "y"),
        ("pure_sway", "v"),
        ("pure_yaw", "psi"),
        ("pure_yaw", "r"),
        ("yaw_drift", "psi"),
        ("yaw_rudder", "r"),
        ("sway_yaw", "y"),
        ("sway_yaw", "r"),
    ],
)
@pytest.mark.parametrize("ahead", [0.0, 0.4, -2.5, 3.0])
def test_phase_of_the_measured_motion(test: str, channel: str, ahead: float) -> None:
    t = uneven()
    fine = np.linspace(0, 50, 500001)
    moved = run_of(test, phase=PHASE + ahead, drift=DRIFT)
    if channel in ("x", "y", "psi"):
        values = dict(zip("xyp", path(test, fine + ahead / OMEGA, DRIFT), strict=True))[channel[0]]
        values = np.interp(t, fine, values)
    else:
        values = getattr(moved.nominal_motion(t), channel)
    theta = run_of(test).displacement_phase(xr.Dataset({channel: ("t", values)}, {"t": t}), t)
    np.testing.assert_allclose(theta, OMEGA * t + PHASE + ahead, atol=1e-6)


def test_phase_of_a_noisy_record_is_within_its_standard_error() -> None:
    rng = np.random.default_rng(3)
    t = np.arange(0, 5 * PERIOD, 0.05)
    errors = []
    for _ in range(200):
        v = 0.2 * np.cos(OMEGA * t + 0.3) + rng.normal(0, 0.1, len(t))
        theta = run_of("pure_sway").displacement_phase(xr.Dataset({"v": ("t", v)}), t)
        errors.append(theta[0] - 0.3)
    expected = 0.1 / 0.2 * math.sqrt(2 / len(t))
    assert np.std(errors) == pytest.approx(expected, rel=0.2)
    assert abs(np.mean(errors)) < 4 * expected / math.sqrt(200)


def test_noise_alone_does_not_move_the_phase() -> None:
    rng = np.random.default_rng(4)
    t = np.arange(0, 4 * PERIOD, 0.1)
    data = xr.Dataset({"v": ("t", rng.normal(size=len(t)))}, {"t": t})
    np.testing.assert_array_equal(
        run_of("pure_sway").displacement_phase(data, t), OMEGA * t + PHASE
    )


def test_few_samples_a_cycle_give_as_many_harmonics_as_they_can() -> None:
    """Eight samples a cycle cannot tell the fifth harmonic from the third."""
    t = np.arange(0, 4 * PERIOD, PERIOD / 8)
    truth = run_of("pure_sway").nominal_motion(t)
    state = run_of("pure_sway").measured_motion(xr.Dataset({"v": ("t", truth.v)}, {"t": t}), t)
    np.testing.assert_allclose(state.vdot, truth.vdot, atol=1e-12)


def test_motion_moves_from_a_point_to_midship_with_the_rigid_ship() -> None:
    """A point on the ship: its earth-fixed path, differentiated, gives v + x r."""
    run, x = run_of("sway_yaw"), 1.7
    t = np.linspace(0, 20, 200001)
    ahead, aside, psi = path("sway_yaw", t, 0.0)
    xdot = np.gradient(ahead + x * np.cos(psi), t)
    ydot = np.gradient(aside + x * np.sin(psi), t)
    midship = run.nominal_motion(t)
    point = midship.with_(
        u=xdot * np.cos(psi) + ydot * np.sin(psi), v=-xdot * np.sin(psi) + ydot * np.cos(psi)
    )
    moved = point.moved_aft(x)
    np.testing.assert_allclose(moved.v[2:-2], midship.v[2:-2], atol=1e-7)
    np.testing.assert_allclose(moved.u[2:-2], midship.u[2:-2], atol=1e-7)


@settings(max_examples=40, deadline=None)
@given(x=st.floats(-5, 5), v=st.floats(-1, 1), r=st.floats(-1, 1), rdot=st.floats(-1, 1))
def test_moving_there_and_back_changes_nothing(x, v, r, rdot):
    state = State.of(u=1.0, v=v, r=r, vdot=v * r, rdot=rdot)
    back = state.moved_aft(x).moved_aft(-x)
    assert back.v == pytest.approx(state.v, abs=1e-14)
    assert back.vdot == pytest.approx(state.vdot, abs=1e-14)


def test_missing_settings_are_named_all_at_once() -> None:
    run = run_of("sway_yaw", period=None, amplitude=None, yaw_amplitude=None)
    with pytest.raises(CampaignError) as caught:
        run.nominal_motion([0.0])
    assert len(caught.value.problems) == 3
    for word in ("period", "amplitude", "yaw_amplitude", "sway_yaw_1"):
        assert word in str(caught.value)


@pytest.mark.parametrize(
    ("test", "changes", "words"),
    [
        ("pure_yaw", {"yaw_amplitude": 1.6}, "below 90"),
        ("pure_sway", {"period": 0.0}, "positive"),
        ("pure_sway", {"period": math.nan}, "positive"),
        ("circular_motion", {}, "yaw_rate"),
        ("circular_motion", {"radius": 0.0}, "yaw_rate"),
        ("turning", {}, "free running"),
    ],
)
def test_impossible_settings_are_refused(test: str, changes: dict, words: str) -> None:
    with pytest.raises(CampaignError, match=words):
        run_of(test, **changes).nominal_motion([0.0, 1.0])
    with pytest.raises(CampaignError, match=words):
        run_of(test, **changes).measured_motion(xr.Dataset(), [0.0, 1.0])


def test_a_record_shorter_than_a_period_is_not_differentiated() -> None:
    t = np.linspace(0, 0.6 * PERIOD, 200)
    data = xr.Dataset({"v": ("t", np.cos(OMEGA * t))}, {"t": t})
    with pytest.raises(CampaignError, match=r"0\.60 periods"):
        run_of("pure_sway").measured_motion(data, t)
    complete = data.assign(u=data.v, r=data.v, udot=data.v, vdot=data.v, rdot=data.v)
    assert run_of("pure_sway").measured_motion(complete, t).v[0] == 1.0


def test_lengths_that_differ_are_refused_by_channel() -> None:
    data = xr.Dataset({"v": ("t", np.zeros(5)), "r": ("t", np.zeros(5))})
    with pytest.raises(CampaignError) as caught:
        run_of("pure_sway").measured_motion(data, np.arange(6.0))
    assert [problem.column for problem in caught.value.problems] == ["v", "r"]


def test_a_static_test_has_no_phase() -> None:
    with pytest.raises(CampaignError, match="does not oscillate"):
        run_of("static_drift").displacement_phase(xr.Dataset(), [0.0])
