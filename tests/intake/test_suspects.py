"""Suspects of the checks act on records as mechanics written by hand says, and new ones take part.

The campaigns are spoiled by the tests' own tank, never by the actions that are looked for.
"""

from __future__ import annotations

import numpy as np
import pytest

from pmmkit import Effect, Parameter, register_effect
from pmmkit.effects import CATALOGUE, Suspect
from pmmkit.intake import examine, summarise
from pmmkit.intake.checks.agreement.asking import Records, suspects
from pmmkit.intake.checks.agreement.rows import CHANNELS, PHASES, groups_of, phases
from tests.support import spoiled
from tests.support.by_hand import (
    behind_a_filter,
    forces,
    larger_side_force,
    late,
    longer_strokes,
    misaligned,
    moments_about_a_point,
    motion_of_a_point,
    weight_left_in,
)
from tests.support.hidden_effects import hidden_campaign
from tests.support.hidden_effects.hull import TRUTH
from tests.support.hidden_effects.motion import motion_of
from tests.support.hidden_effects.programmes import plans

PLANS = {plan.id: plan for plan in plans("small")}
TRIED = {
    "drift": (misaligned, 8.0, 8.0),
    "amplitude": (longer_strokes, 1.25, 0.25),
    "lag": (late, 0.5, 0.5),
    "filter": (behind_a_filter, 0.25, 0.25),
    "motion point": (motion_of_a_point, -0.1, -0.1),
    "moment point": (moments_about_a_point, 0.05, 0.05),
    "gain of Y": (larger_side_force, 1.5, 0.5),
}
"""By suspect: the fault by hand, the value of the suspect, and what it is by hand."""


@pytest.fixture(scope="module")
def group():
    """The runs of the tank without noise, and their derivatives."""
    made = hidden_campaign("small", {}, noise="none")
    made = spoiled.each(made, made.runs, spoiled.keep_without_roll)
    (found,) = groups_of(made, [summarise(run, made) for run in made.runs])
    at = {name: k for k, name in enumerate(found.usual.names)}
    value = np.zeros(len(at))
    for name, true in TRUTH.items():
        value[at[name]] = true / found.scale[at[name]]
    return found, value


def by_hand(group, make, size):
    """Histories over the units of a group of what a fault changes, (n, 32, 3)."""
    found = []
    for item in group.summaries:
        plan = PLANS[item.run.id]
        t = phases() / plan.omega if plan.dynamic else np.zeros(PHASES)
        shown, true = make(plan, t, size), forces(motion_of(plan, t))
        found.append(np.stack([shown[name] - true[name] for name in CHANNELS], axis=1))
    return np.stack(found) / group.units[:, None, :]


def valued(runs, derivatives):
    """The forces that the derivatives give."""
    return Records(group=runs, histories=runs.histories(), value=derivatives)


@pytest.mark.parametrize("name", TRIED)
def test_a_suspect_is_what_a_faulty_laboratory_writes_down(name, group):
    runs, derivatives = group
    make, value, size = TRIED[name]
    (suspect,) = [item for item in suspects() if item.name == name]
    told = Records(group=runs, histories=runs.histories())
    found = (suspect.histories(told, value) - told.histories) @ derivatives
    expected = by_hand(runs, make, size)
    touched = [suspect.concerns(item.run) for item in runs.summaries]
    assert any(touched)
    np.testing.assert_allclose(found[touched], expected[touched], atol=1e-9 * np.ptp(expected))


def test_a_mass_of_unknown_size_is_one_left_in_the_forces(group):
    runs, derivatives = group
    (suspect,) = [item for item in suspects() if item.name == "mass"]
    column = suspect.column(valued(runs, derivatives), 1.0)
    expected = by_hand(runs, weight_left_in, suspect.spread(1.0))
    expected = runs.design(expected[..., None])[..., 0]
    np.testing.assert_allclose(column, expected, atol=1e-9 * np.ptp(expected))


def test_clocks_of_their_own_shift_as_the_rate_of_the_forces(group):
    runs, derivatives = group
    (suspect,) = [item for item in suspects() if item.name == "clocks"]
    column = suspect.column(valued(runs, derivatives), 0.4)
    expected = 4000.0 * by_hand(runs, late, 1e-4)
    expected = runs.design(expected[..., None])[..., 0]
    np.testing.assert_allclose(column, expected, atol=1e-3 * np.ptp(expected))


@pytest.mark.parametrize("suspect", suspects(), ids=lambda item: item.name)
def test_every_suspect_says_what_is_wrong_at_all_its_values(suspect, group):
    runs, derivatives = group
    told = Records(group=runs, histories=runs.histories())
    for value in suspect.grid:
        assert suspect.says(value)
        if suspect.unknown:
            found = suspect.column(valued(runs, derivatives), value)
        else:
            found = (suspect.histories(told, value) - told.histories) @ derivatives
        assert np.isfinite(found).all()
        assert np.any(found) or not any(suspect.concerns(item.run) for item in runs.summaries)
        untouched = [k for k, name in enumerate(CHANNELS) if name not in suspect.channels]
        of_channels = found[:, untouched] if suspect.unknown else found[..., untouched]
        assert not np.any(of_channels)


def of_n_in_y(run, at):
    """A share of the moment, over the length, in the side force."""
    return {"Y": run.forces["Y"] + at["share"] * run.forces["N"] / run.ship.L}


OWN = Effect(
    name="fault_of_a_test",
    family="own",
    kind="fault",
    summary="A gauge of the side force that feels the moment.",
    parameters=(Parameter(name="share", text="of N over L"),),
    acts=of_n_in_y,
    suspects=(
        Suspect(
            name="moment in Y",
            says=lambda value: f"the gauge of Y feels {100 * value:.0f} % of the moment",
            remedy="Hang a weight far forward.",
            at=lambda value: {"share": value},
            grid=(-1.0, -0.5, 0.5, 1.0),
            continuous=True,
            channels=("Y",),
        ),
    ),
    check="a weight at two places",
)


def test_a_fault_of_one_s_own_is_found_by_the_checks_without_being_told():
    def feels(run, data):
        values = {key: data[key].values for key in data}
        return values | {"Y": values["Y"] + 0.8 * values["N"] / 4.861111}

    clean = spoiled.clean("small", 5)
    chosen = tuple(run for run in clean.runs if run.test == "yaw_drift")
    campaign = spoiled.each(clean, chosen, feels)
    register_effect(OWN)
    try:
        assert not [item for item in examine(clean) if item.severity != "info"]
        (finding,) = [item for item in examine(campaign) if item.check == "agreement"]
    finally:
        CATALOGUE.forget(OWN.name)
    assert OWN.name not in CATALOGUE
    assert finding.runs == tuple(run.id for run in chosen)
    assert finding.cause == OWN.name
    assert "the gauge of Y feels" in finding.message
    assert "a weight at two places" in finding.remedy
    assert finding.numbers["value"] == pytest.approx(0.8, abs=0.15)


ALL = tuple(dict.fromkeys(plan.test for plan in plans("small")))


def spoiled_by(make, size, tests, seed=6):
    """A campaign of the tank with its usual noise, some kinds of its runs spoiled by hand."""
    made = hidden_campaign("small", {}, noise="standard", seed=seed)
    clean = spoiled.each(made, made.runs, spoiled.keep_without_roll)

    def shown(run, data):
        plan, t = PLANS[run.id], data["t"].values
        faulty, true = make(plan, t, size), forces(motion_of(plan, t))
        return {name: data[name].values + faulty[name] - true[name] for name in CHANNELS}

    return spoiled.each(clean, tuple(run for run in clean.runs if run.test in tests), shown)


def with_drift(campaign, finding):
    """The drift that the runs had."""
    more = np.radians(finding.numbers["value"])
    runs = tuple(run for run in campaign.runs if run.id in finding.runs)
    return spoiled.set_(campaign, runs, drift=lambda run: run.settings.drift + more)


def with_amplitudes(campaign, finding):
    """The amplitudes that the runs had."""
    times = finding.numbers["value"]
    swung = tuple(run for run in campaign.runs if run.dynamic)
    return spoiled.set_(
        campaign,
        swung,
        amplitude=lambda run: run.settings.amplitude and times * run.settings.amplitude,
        yaw_amplitude=lambda run: run.settings.yaw_amplitude and times * run.settings.yaw_amplitude,
    )


def with_moment_point(campaign, finding):
    """The point to which the moments refer."""
    return campaign.with_(moment_reference_x=finding.numbers["x"])


def with_scale(campaign, finding):
    """The side force less its gain."""
    runs = tuple(run for run in campaign.runs if run.id in finding.runs)
    return spoiled.each(campaign, runs, spoiled.factor("Y", 1.0 / finding.numbers["value"]))


@pytest.mark.slow
@pytest.mark.parametrize(
    ("make", "size", "tests", "check", "mended", "value"),
    [
        (misaligned, 4.0, ("yaw_drift",), "agreement", with_drift, 4.0),
        (misaligned, -6.0, ALL, "agreement", with_drift, -6.0),
        (longer_strokes, 0.1, ALL, "agreement", with_amplitudes, 1.1),
        (moments_about_a_point, 0.06, ALL, "moment reference", with_moment_point, 0.06 * 4.861111),
        (larger_side_force, 0.2, ("yaw_drift",), "agreement", with_scale, 1.2),
    ],
)
def test_what_the_checks_propose_mends_the_campaign(make, size, tests, check, mended, value):
    campaign = spoiled_by(make, size, tests)
    said = [item for item in examine(campaign) if item.severity != "info"]
    finding = next(item for item in said if item.check == check)
    found = finding.numbers["x" if check == "moment reference" else "value"]
    assert found == pytest.approx(value, rel=0.2)
    again = [item for item in examine(mended(campaign, finding)) if item.severity != "info"]
    assert [str(item) for item in again] == []
