"""The tank of the hidden-effect study, against closed forms and its own promises."""

from __future__ import annotations

import math
from functools import cache

import numpy as np
import pytest
from hidden_effects import EFFECTS, INSIDE, OUTSIDE, SHIP, WATER, catalogue, hidden_campaign
from hidden_effects.gauges import inertia
from hidden_effects.hull import TRUTH, one_pole
from hidden_effects.motion import Rig, motion_of
from hidden_effects.noise import background, draw
from hidden_effects.programmes import plans
from hidden_effects.sizes import CHANNELS, NOISE, SIZES, scale, unit
from hidden_effects.sources import digital_filter
from hidden_effects.tank import fine_times, motions

import pmmkit as pk

RUDDER = {"static_rudder", "drift_rudder"}
OSCILLATING = {"pure_sway", "pure_yaw", "yaw_drift", "sway_yaw"}
TURNING = {"pure_yaw", "yaw_drift", "sway_yaw"}
DRIFTING = {"static_drift", "drift_rudder", "pure_sway", "yaw_drift", "sway_yaw"}
SWAYING = {"pure_sway", "sway_yaw"}


def silent(effects=None, programme="full", **given):
    return _silent(tuple((effects or {}).items()), programme, **given)


@cache
def _silent(effects, programme, **given):
    return hidden_campaign(programme, dict(effects), noise="none", **given)


def kept(run):
    """Channels of the cycles that count, in shares of the channel scale of the run's speed."""
    start, data = 48 if run.dynamic else 0, run.data
    return np.stack(
        [
            data[name].values[start:] / unit(name, run.settings.speed) / NOISE["scale"][name]
            for name in CHANNELS
        ]
    )


def change(effects, programme="full", truth="catalogue"):
    """What effects do to each run, by its id."""
    bare = records((), programme, "catalogue")
    return {
        name: values - bare[name]
        for name, values in records(tuple(effects.items()), programme, truth).items()
    }


@cache
def records(effects, programme, truth):
    return {run.id: kept(run) for run in _silent(effects, programme, truth=truth)}


def harmonic(values, n):
    """Cosine and sine of a record of whole cycles at 48 samples a cycle."""
    theta = 2 * np.pi * n * np.arange(len(values)) / 48
    return 2 * np.mean(values * np.cos(theta)), 2 * np.mean(values * np.sin(theta))


# --- the clean tank against closed forms --------------------------------------------------------


@pytest.mark.parametrize(
    ("programme", "count", "dynamic"), [("full", 48, 26), ("middle", 27, 9), ("small", 13, 6)]
)
def test_the_programmes_have_the_runs_they_should(programme, count, dynamic):
    campaign = silent(programme=programme)
    assert len({run.id for run in campaign}) == len(campaign) == count
    assert sum(run.dynamic for run in campaign) == dynamic
    for run in campaign:
        samples = run.data["t"].size
        assert samples == (4 * 48 if run.dynamic else 3 * 48)
        if run.dynamic:
            assert run.data["t"].values[48] == pytest.approx(run.settings.period)
            assert run.settings.omega * run.settings.speed / WATER.g < 0.26
        else:
            assert run.data["t"].values[-1] == pytest.approx(
                3 * math.pi * SHIP.L / run.settings.speed, rel=0.01
            )


def test_repeats_repeat_and_one_sided_programmes_have_nothing_to_port():
    campaign = silent()
    for run in campaign:
        if run.settings.repeat_of:
            np.testing.assert_array_equal(kept(run), kept(campaign[run.settings.repeat_of]))
    one = silent(sided="one")
    assert len(one) == 48
    assert all(run.settings.drift >= 0 and run.settings.rudder >= 0 for run in one)


def test_static_drift_by_hand():
    run = silent()["SD_1.5_12"]
    beta = math.radians(12)
    v = -math.sin(beta)
    force = 0.5 * 999.1 * 4.861111**2 * 1.5**2
    X = force * (-0.0004226 * math.cos(beta) ** 2 - 0.00386 * v**2)
    Y = force * (-0.0116 * v - 0.109 * v**3)
    N = force * 4.861111 * (-0.0038545 * v + 0.001492 * v**3)
    for name, value in {"X": X, "Y": Y, "N": N}.items():
        np.testing.assert_allclose(run.data[name], value, rtol=1e-12)


def test_drift_with_rudder_by_hand():
    run = silent()["DR_1.5_6_-20"]
    v, d = -math.sin(math.radians(6)), math.radians(-20)
    force = 0.5 * 999.1 * 4.861111**2 * 1.5**2
    Y = force * (-0.0116 * v - 0.109 * v**3 - 0.00298 * d)
    np.testing.assert_allclose(run.data["Y"], Y, rtol=1e-12)


def test_pure_sway_harmonics_in_closed_form():
    """With U² = Uc² + v², expanded to the fourth power of e = V/Uc."""
    run = silent()["SW_1.5_0.22"]
    Uc, e = 1.5, 0.22
    V, L = e * Uc, SHIP.L
    omega = 2.0 * Uc / L
    half = 0.5 * WATER.rho * L**2
    c1, s1 = harmonic(run.data["Y"].values[48:], 1)
    linear = TRUTH["Yv"] * Uc * V * (1 + 3 / 8 * e**2 - 5 / 64 * e**4)
    cubic = TRUTH["Yvvv"] * V**3 / Uc * (3 / 4 - 5 / 16 * e**2 + 105 / 512 * e**4)
    assert c1 == pytest.approx(half * (linear + cubic), rel=2e-4)
    assert s1 == pytest.approx(-half * TRUTH["Yvdot"] * L * V * omega, rel=1e-7)
    mean = np.mean(run.data["X"].values[48:])
    assert mean == pytest.approx(half * (TRUTH["Xuu"] * Uc**2 + TRUTH["Xvv"] * V**2 / 2), rel=1e-7)


def test_pure_yaw_moment_in_phase_with_heading_is_the_added_inertia():
    run = silent()["YW_1.5_0.5"]
    omega = run.settings.omega
    _, s1 = harmonic(run.data["N"].values[48:], 1)
    J = -TRUTH["Nrdot"] * 0.5 * WATER.rho * SHIP.L**5
    assert s1 == pytest.approx(J * run.settings.yaw_amplitude * omega**2, rel=1e-7)


def test_the_balance_holds_the_models_inertia():
    water, balance = silent(), silent(balance=True)
    assert balance.forces == "balance"
    for bare, run in zip(water, balance, strict=True):
        state = bare.nominal_motion(bare.data["t"].values[48:])
        m = SHIP.mass
        expected = {
            "X": m * (state.udot - state.r * state.v),
            "Y": m * (state.vdot + state.r * state.u),
            "N": SHIP.Izz * state.rdot,
        }
        for name, part in expected.items():
            np.testing.assert_allclose(
                bare.data[name].values[48:] - run.data[name].values[48:], part, atol=1e-2
            )


def test_heel_in_static_drift_by_hand_and_only_where_it_is_measured():
    run = silent()["SD_1.5_12"]
    Y = float(run.data["Y"][0])
    expected = -0.15 * Y / (999.1 * 9.81 * SHIP.volume * 0.027)
    np.testing.assert_allclose(run.data["phi"], expected, rtol=1e-9)
    assert "phi" not in silent(roll_measured=False)["SD_1.5_12"].data


def test_the_startup_is_gone_when_the_first_cycle_is_over():
    for run in silent():
        if run.dynamic:
            cycles = run.data["Y"].values.reshape(4, 48)
            size = np.ptp(cycles[3])
            assert abs(cycles[0] - cycles[3]).max() > 0.03 * size
            np.testing.assert_allclose(cycles[1], cycles[3], atol=1e-3 * size)


# --- kinematics ---------------------------------------------------------------------------------


@pytest.mark.parametrize("programme", ["full", "middle", "small"])
def test_the_motion_is_the_one_that_the_package_takes_the_settings_for(programme):
    for plan, run in zip(plans(programme), silent(programme=programme), strict=True):
        t = run.data["t"].values
        mine, theirs = motion_of(plan, t), run.nominal_motion(t)
        for name in ("u", "v", "r", "udot", "vdot", "rdot"):
            np.testing.assert_allclose(getattr(mine, name), getattr(theirs, name), atol=1e-12)


def test_the_programme_reaches_its_amplitudes():
    for plan in plans("full"):
        m = motion_of(plan, fine_times(plan))
        values = [float(x) for x in plan.id.removesuffix("_again").split("_")[2:]]
        if plan.test == "pure_sway":
            assert np.max(m.v) / plan.speed == pytest.approx(values[0], rel=1e-4)
        elif plan.test in ("pure_yaw", "yaw_drift"):
            assert np.max(m.r) * SHIP.L / plan.speed == pytest.approx(values[0], rel=1e-4)
        elif plan.test == "sway_yaw":
            assert np.max(m.v) / plan.speed == pytest.approx(values[0], rel=0.02)
            assert np.max(abs(m.r)) * SHIP.L / plan.speed == pytest.approx(values[1], rel=1e-3)
            assert abs(np.mean(m.v * m.r)) < 1e-9


RIGS = {
    "heading": Rig(heading=0.02),
    "speed": Rig(speed=0.03),
    "stroke": Rig(stroke=0.1),
    "mistiming": Rig(mistiming=0.1),
    "current": Rig(current=0.05),
}


@pytest.mark.parametrize("name", RIGS)
def test_accelerations_are_the_derivatives_of_velocities_whatever_the_rig_does(name):
    for plan in plans("full"):
        t = np.arange(0, 4, 1e-3)
        m = motion_of(plan, t, RIGS[name])
        for value, rate in ((m.u, m.udot), (m.v, m.vdot), (m.r, m.rdot)):
            np.testing.assert_allclose(np.gradient(value, t)[1:-1], rate[1:-1], atol=2e-6)


def test_what_the_rig_does_wrong_by_hand():
    run = {plan.id: plan for plan in plans("full")}
    t = np.arange(48) / 5.0
    turned = motion_of(run["SD_1.5_6"], t, RIGS["heading"])
    assert turned.v[0] == pytest.approx(-1.5 * math.sin(math.radians(6) + 0.02))
    fast = motion_of(run["SD_2.0_6"], t, RIGS["speed"])
    assert fast.U[0] == pytest.approx(2.06)
    assert motion_of(run["SD_1.5_6"], t, RIGS["speed"]).U[0] == pytest.approx(1.5)
    flow = motion_of(run["SD_1.0_3"], t, RIGS["current"])
    beta = math.radians(3)
    assert flow.v[0] == pytest.approx(-math.sin(beta) - 0.05 * math.cos(beta))
    assert flow.u[0] == pytest.approx(math.cos(beta) - 0.05 * math.sin(beta))
    plan = run["YW_1.5_0.25"]
    late = motion_of(plan, t, RIGS["mistiming"])
    slope = 1.5 * np.tan(plan.yaw * np.sin(plan.omega * t + 0.1))
    psi = plan.yaw * np.sin(plan.omega * t)
    np.testing.assert_allclose(late.v, slope * np.cos(psi) - 1.5 * np.sin(psi), atol=1e-12)
    still = motion_of(plan, t, RIGS["stroke"])
    np.testing.assert_allclose(still.v, 0.0, atol=1e-12)
    sway = motion_of(run["SW_1.5_0.22"], t, RIGS["stroke"])
    assert sway.v[0] == pytest.approx(1.1 * 0.22 * 1.5)


# --- noise --------------------------------------------------------------------------------------


@pytest.mark.parametrize("level", ["standard", "double", "hard"])
def test_noise_has_the_size_and_the_memory_it_should(level):
    runs = [draw(level, 5, number, 192) for number in range(400)]
    for name in CHANNELS:
        record = np.stack([run.record[name] for run in runs]) / scale(name)
        assert np.sqrt(np.mean(record**2)) == pytest.approx(NOISE["rms"][level], rel=0.03)
        variance = np.mean(record**2)
        first, second = (np.mean(record[:, k:] * record[:, :-k]) / variance for k in (1, 2))
        assert first == pytest.approx(0.8 * 0.8, abs=0.02)
        assert second / first == pytest.approx(0.8, abs=0.02)
        assert np.std([run.gain[name] for run in runs]) == pytest.approx(0.005, rel=0.12)
    offsets = [run.offset[name] / scale(name) / 0.003 for run in runs for name in CHANNELS]
    middle, tail = np.quantile(np.abs(offsets), [0.5, 0.99])
    assert middle == pytest.approx(0.765 if level == "hard" else 0.6745, rel=0.12)
    assert tail > 4 if level == "hard" else tail < 3
    headings = np.degrees(np.std([run.heading for run in runs]))
    assert headings == pytest.approx(0.03 if level == "hard" else 0.0, rel=0.12)


def test_noise_depends_on_the_seed_alone():
    first, again, other = (hidden_campaign("small", seed=seed) for seed in (1, 1, 2))
    for a, b, c in zip(first, again, other, strict=True):
        np.testing.assert_array_equal(kept(a), kept(b))
        assert abs(kept(a) - kept(c)).max() > 0.01


def test_the_same_noise_falls_on_whatever_is_hidden():
    effects = {"asymmetry": 1.0}
    clean, noisy = change(effects, programme="small"), {}
    for run, bare in zip(
        hidden_campaign("small", effects, seed=4), hidden_campaign("small", seed=4), strict=True
    ):
        noisy[run.id] = kept(run) - kept(bare)
    for name, part in clean.items():
        np.testing.assert_allclose(noisy[name], part, rtol=0.03, atol=1e-12)


def test_noise_is_the_same_in_newtons_at_every_speed():
    noisy, clean = hidden_campaign(seed=2), silent()
    for speed, expected in ((1.0, 2.25), (2.0, 0.5625)):
        parts = [
            (kept(run) - kept(bare)).std(axis=1)
            for run, bare in zip(noisy, clean, strict=True)
            if run.settings.speed == speed and not run.dynamic
        ]
        np.testing.assert_allclose(np.mean(parts), 0.015 * expected, rtol=0.12)


def test_the_background_of_the_hard_case_is_small_smooth_and_symmetric():
    every = [motion_of(plan, fine_times(plan)) for plan in plans("full")]
    for seed in range(3):
        force = background(seed)
        made = [force(m) for m in every]
        for name in CHANNELS:
            rms = [np.mean((made[k][name] / unit(name, m.U)) ** 2) for k, m in enumerate(every)]
            assert 0.001 < np.sqrt(np.mean(rms)) / NOISE["scale"][name] < 0.012
        port, starboard = (
            force(next(m for m in every if m.plan.id == f"SD_1.5_{beta}")) for beta in (-12, 12)
        )
        assert port["Y"][0] == pytest.approx(-starboard["Y"][0])
        assert port["X"][0] == pytest.approx(starboard["X"][0])


def test_the_hard_case_differs_by_background_and_settings():
    hard, standard = hidden_campaign("small", noise="hard"), hidden_campaign("small")
    for a, b in zip(hard, standard, strict=True):
        difference = abs(kept(a) - kept(b)).max()
        assert 0.001 < difference < 0.2


# --- effects ------------------------------------------------------------------------------------

ACTS = {
    "modulus_sway_drag": DRIFTING,
    "modulus_yaw_drag": TURNING,
    "crossflow_drag": None,
    "yaw_sway_coupling": {"yaw_drift", "sway_yaw"},
    "surge_yaw_coupling": {"yaw_drift", "sway_yaw"},
    "surge_fourth_order": DRIFTING,
    "resistance_curve": None,
    "asymmetry": None,
    "even_hull_terms": DRIFTING | TURNING,
    "memory": SWAYING,
    "lagged_crossflow": SWAYING,
    "nonlinear_added_mass": SWAYING | {"yaw_drift"},
    "rudder_stall": RUDDER,
    "rudder_cross_terms": {"drift_rudder"},
    "fault_time_lag": OSCILLATING,
    "fault_filter_lag": OSCILLATING,
    "fault_pmm_amplitude": SWAYING,
    "fault_pmm_phase": {"pure_yaw", "yaw_drift"},
    "fault_transient": OSCILLATING,
    "fault_inertia": OSCILLATING,
    "fault_gauge_zero": None,
    "fault_gauge_drift": None,
    "fault_misalignment": None,
    "current": None,
    "fault_cross_talk": None,
}
"""Kinds of tests in which the catalogue's form acts; None where it acts in all."""


@pytest.mark.slow
@pytest.mark.parametrize("effect", ACTS)
def test_catalogue_forms_act_where_they_should_and_nowhere_else(effect):
    campaign, changes = silent(), change({effect: 1.0})
    for run in campaign:
        acts = ACTS[effect] is None or run.test in ACTS[effect]
        if effect == "resistance_curve" and run.settings.speed == 1.5:
            continue
        if effect == "crossflow_drag" and run.test == "static_rudder":
            continue
        found = abs(changes[run.id]).max()
        assert found > 1e-5 if acts else found < 1e-9, run.id


@pytest.mark.slow
@pytest.mark.parametrize("truth", ["catalogue", "foreign"])
@pytest.mark.parametrize(
    ("effect", "silent_tests"),
    [
        ("rudder_stall", {"static_drift", *OSCILLATING}),
        ("rudder_cross_terms", {"static_drift", "static_rudder", *OSCILLATING}),
        ("yaw_sway_coupling", {"static_drift", "pure_sway", "pure_yaw", *RUDDER}),
        ("surge_yaw_coupling", {"static_drift", "pure_sway", *RUDDER}),
        ("modulus_yaw_drag", {"static_drift", "pure_sway", *RUDDER}),
        ("memory", {"static_drift", "pure_yaw", *RUDDER}),
        ("lagged_crossflow", {"static_drift", "pure_yaw", *RUDDER}),
        ("fault_pmm_amplitude", {"static_drift", *RUDDER}),
        ("fault_pmm_phase", {"static_drift", "pure_sway", *RUDDER}),
        ("fault_time_lag", {"static_drift", *RUDDER}),
        ("fault_transient", {"static_drift", *RUDDER}),
        ("fault_inertia", {"static_drift", *RUDDER}),
    ],
)
def test_both_truths_leave_the_same_runs_alone(effect, truth, silent_tests):
    campaign, changes = silent(), change({effect: 1.0}, truth=truth)
    for run in campaign:
        if run.test in silent_tests:
            assert abs(changes[run.id]).max() < 1e-9, run.id
    assert max(abs(part).max() for part in changes.values()) > 0.005


@pytest.mark.slow
@pytest.mark.parametrize("effect", INSIDE)
def test_the_foreign_truth_is_about_as_large_as_the_catalogues(effect):
    """Rms over the runs in which the catalogue's form acts, channels in their scale."""
    known, foreign = (change({effect: 1.0}, truth=truth) for truth in ("catalogue", "foreign"))
    where = [name for name, part in known.items() if abs(part).max() > 1e-6]
    sizes = [
        np.sqrt(np.mean([np.mean(part[name] ** 2, axis=1).sum() for name in where]))
        for part in (known, foreign)
    ]
    assert sizes[1] / sizes[0] == pytest.approx(1.0, abs=0.2)
    overlap = sum(np.sum(known[name] * foreign[name]) for name in known)
    norms = [np.sqrt(sum(np.sum(part[name] ** 2) for name in part)) for part in (known, foreign)]
    assert overlap / norms[0] / norms[1] > 0.7


@pytest.mark.slow
@pytest.mark.parametrize(
    ("effect", "truth"),
    [(effect, "catalogue") for effect in EFFECTS] + [(effect, "foreign") for effect in INSIDE],
)
def test_effects_grow_with_their_size_and_turn_with_its_sign(effect, truth):
    whole, half, less = (
        change({effect: size}, truth=truth, programme="full" if "speed" in effect else "middle")
        for size in (1.0, 0.5, -1.0)
    )
    sizes = {
        key: max(abs(part).max() for part in parts.values())
        for key, parts in (("whole", whole), ("half", half))
    }
    assert 0.003 < sizes["whole"] < 1.0
    assert 0.4 < sizes["half"] / sizes["whole"] < 0.6
    if effect == "outside_dead_zone":
        return
    product = sum(np.sum(whole[name] * less[name]) for name in whole)
    assert product < -0.7 * sum(np.sum(part**2) for part in whole.values())


def test_unknown_names_are_refused():
    with pytest.raises(ValueError, match="ghost"):
        hidden_campaign("small", {"ghost": 1.0})
    with pytest.raises(ValueError, match="truth"):
        hidden_campaign("small", truth="third")


@pytest.mark.slow
@pytest.mark.parametrize("truth", ["catalogue", "foreign"])
@pytest.mark.parametrize("effect", ["froude_linear", "froude_nonlinear", "resistance_curve"])
def test_one_speed_cannot_show_what_depends_on_speed(effect, truth):
    one = change({effect: 1.0}, truth=truth, programme="small")
    many = change({effect: 1.0}, truth=truth)
    largest = [max(abs(part).max() for part in parts.values()) for parts in (one, many)]
    assert largest[0] < 0.01 * largest[1]


@pytest.mark.parametrize("truth", ["catalogue", "foreign"])
def test_the_transient_is_what_the_share_says_after_a_cycle_and_dies(truth):
    without, with_it = (
        silent(effects, truth=truth)["SW_1.5_0.22"].data["Y"].values
        for effects in (None, {"fault_transient": 1.0})
    )
    part = with_it - without
    half = 0.5 * np.ptp(without[-48:])
    assert abs(part[48]) / half == pytest.approx(0.08, rel=0.35)
    assert np.sign(part[48]) == np.sign(without[-48])
    assert abs(part[-48:]).max() < 0.05 * abs(part[48:60]).max()


def test_the_carriage_is_fast_at_one_speed_alone():
    for truth in ("catalogue", "foreign"):
        for name, part in change({"fault_carriage_speed": 1.0}, truth=truth).items():
            assert (abs(part).max() > 1e-4) == ("_2.0_" in name)


# --- faults by hand -----------------------------------------------------------------------------


@pytest.mark.slow
def test_gauge_faults_by_hand():
    bare = silent()["SD_1.0_6"].data
    zero = silent({"fault_gauge_zero": 0.5})["SD_1.0_6"].data
    np.testing.assert_allclose(zero["Y"] - bare["Y"], 1.2)
    np.testing.assert_allclose(zero["N"] - bare["N"], -1.75)
    gain = silent({"fault_gauge_gain": 1.0})["SD_1.0_6"].data
    np.testing.assert_allclose(gain["Y"], 1.03 * bare["Y"])
    drift = silent({"fault_gauge_drift": 1.0})["SD_1.0_6"].data
    np.testing.assert_allclose(drift["Y"] - bare["Y"], 2.0 * bare["t"] / 60, atol=1e-9)
    talk = silent({"fault_cross_talk": 1.0})["SD_1.0_6"].data
    np.testing.assert_allclose(talk["X"] - bare["X"], 0.01 * bare["Y"])
    point = silent({"fault_moment_point": 1.0})["SD_1.0_6"].data
    np.testing.assert_allclose(point["N"] - bare["N"], 0.01 * SHIP.L * bare["Y"])


@pytest.mark.slow
def test_a_lag_shifts_the_record_in_seconds():
    run = silent()["SW_1.5_0.22"]
    t, late = run.data["t"].values, silent({"fault_time_lag": 1.0})["SW_1.5_0.22"].data
    c, s = harmonic(run.data["Y"].values[48:], 1)
    turned = complex(*harmonic(late["Y"].values[48:], 1)) / complex(c, s)
    assert np.angle(turned) == pytest.approx(2 * np.pi / (t[48] - t[0]) * 0.04, rel=1e-2)


def test_filters_follow_their_transfer_function():
    t = np.arange(0, 80, 0.05)
    for lag, omega in ((0.08, 0.6), (0.3, 2.0), (0.9, 1.0)):
        x = np.cos(omega * t)
        for y in (one_pole(x, 0.05, lag), digital_filter(x, t, lag, rate=2000.0)):
            expected = np.real(np.exp(1j * omega * t) / (1 + 1j * omega * lag))
            np.testing.assert_allclose(y[800:], expected[800:], atol=2e-3)


def test_misalignment_is_the_model_turned():
    """Foreign: the run at 6° + 0.26°. Catalogue: its tangent."""
    beta = math.radians(6 + SIZES["fault_misalignment"]["deg"])
    v = -math.sin(beta)
    Y = unit("Y", 1.5) * (TRUTH["Yv"] * v + TRUTH["Yvvv"] * v**3)
    for truth, tolerance in (("foreign", 1e-9), ("catalogue", 1e-3)):
        run = silent({"fault_misalignment": 1.0}, truth=truth)["SD_1.5_6"]
        assert float(run.data["Y"][0]) == pytest.approx(Y, rel=tolerance)


def test_a_fault_of_the_motion_leaves_inertia_behind_where_the_stated_one_is_taken_off():
    """PMM amplitude: 3 % of the model's own inertia stays inside Y."""
    effects = {"fault_pmm_amplitude": 1.0}
    ideal, nominal = (
        silent(effects, truth="foreign", removal=removal)["SW_1.5_0.22"].data["Y"].values[48:]
        for removal in ("ideal", "nominal")
    )
    left = harmonic(nominal - ideal, 1)
    omega = 2.0 * 1.5 / SHIP.L
    assert left[1] == pytest.approx(0.03 * SHIP.mass * 0.22 * 1.5 * omega, rel=1e-3)
    assert abs(left[0]) < 1e-3 * left[1]


def test_forgotten_weights_are_inertia():
    plan = next(plan for plan in plans("full") if plan.id == "YW_1.5_0.5")
    _, m = motions(plan, {}, "catalogue")
    whole = inertia(m, 2.0, 3.0, 0.1)
    np.testing.assert_allclose(whole["N"], 3.0 * m.rdot + 0.2 * m.ay)
    np.testing.assert_allclose(m.ay, m.vdot + m.r * m.u, atol=1e-12)


def test_memory_has_the_harmonics_of_a_one_pole_lag():
    """C1 falls by w²T²/(1 + w²T²), S1 = wT/(1 + w²T²) of the share, to first order in sway."""
    run = "SW_1.0_0.12"
    part = change({"memory": 1.0})[run][1]
    c, s = harmonic(part, 1)
    x = 2.0 * SIZES["memory"]["lag_LU"]
    size = 0.2 * TRUTH["Yv"] * 0.12 / NOISE["scale"]["Y"]
    assert c == pytest.approx(-size * x**2 / (1 + x**2), rel=0.02)
    assert s == pytest.approx(size * x / (1 + x**2), rel=0.02)


def test_nonlinear_added_mass_has_equal_first_and_third_sine():
    part = change({"nonlinear_added_mass": 1.0})["SW_1.5_0.12"][1]
    first, third = harmonic(part, 1)[1], harmonic(part, 3)[1]
    assert third / first == pytest.approx(1.0, abs=0.03)


def test_outside_effects_are_what_they_are_called():
    spring = change({"outside_wall_spring": 1.0})
    c, s = harmonic(spring["SW_1.5_0.22"][1], 1)
    assert abs(c) < 0.02 * abs(s)
    slosh = change({"outside_sloshing": 1.0})
    assert set(slosh) == {run.id for run in silent()}
    assert all(np.std(part[1]) > 0 for part in slosh.values())
    loop = change({"outside_hysteresis": 1.0})
    slow, fast = (abs(loop[name][1]).max() for name in ("SW_1.0_0.17", "SW_1.5_0.17"))
    assert slow == pytest.approx(fast, rel=1e-2)  # rate-independent
    assert len(OUTSIDE) >= 6
    assert all(name.startswith("outside_") for name in OUTSIDE)
    assert not set(OUTSIDE) & set(catalogue.FORCES)


# --- the package takes it -----------------------------------------------------------------------


@pytest.mark.slow
@pytest.mark.parametrize("programme", ["full", "middle", "small"])
def test_a_clean_campaign_passes_the_checks(programme):
    for balance in (False, True):
        found = pk.examine(hidden_campaign(programme, balance=balance, seed=1))
        assert [finding.message for finding in found if finding.severity == "error"] == []


@pytest.mark.slow
def test_the_reduction_finds_the_truth():
    campaign = hidden_campaign("full", seed=1, stated=True)
    names = ["Xvr", *TRUTH]
    table = pk.reduce_campaign(campaign, structure=names, fn="pooled").table.to_pandas()
    table = table.set_index("derivative")
    truth = np.array([TRUTH.get(name, 0.0) for name in names])
    found = table.loc[names]
    z = (found["value"] - truth) / found["std"]
    assert np.sqrt(np.mean(z**2)) < 1.6
    assert abs(z).max() < 4
    assert np.mean((found["ci_low"] <= truth) & (truth <= found["ci_high"])) > 0.8
