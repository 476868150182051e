"""Faults of a measurement: what they show, against mechanics written by hand.

The truth is the tests' own tank (`tests/support/by_hand.py`), which shares no formula with the
package: a test that spoils and finds with one function would prove nothing.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from pmmkit.conventions import Convention
from pmmkit.diagnosis.captive.base import CaptiveBase
from pmmkit.diagnosis.captive.candidate import columns_of
from pmmkit.effects import CATALOGUE
from pmmkit.effects.faults.rig import strokes
from pmmkit.reduction import RunViews, View
from tests.support.by_hand import BY_HAND, behind_a_filter, forces, longer_strokes
from tests.support.hidden_effects import SHIP, WATER, hidden_campaign
from tests.support.hidden_effects.hull import TRUTH
from tests.support.hidden_effects.motion import motion_of
from tests.support.hidden_effects.programmes import plans
from tests.support.spoiled import each, keep_without_roll

PLANS = {plan.id: plan for plan in plans("small")}
BASE = CaptiveBase(
    names={channel: tuple(name for name in TRUTH if name[0] == channel) for channel in "XYN"},
    values=TRUTH,
    ship=SHIP,
    water=WATER,
    convention=Convention(),
    reference=1.5,
)
SMALL = {
    "fault_misalignment": 0.01,
    "fault_pmm_amplitude": 1e-4,
    "fault_time_lag": 1e-5,
    "fault_motion_point": 1e-4,
    "fault_moment_point": 0.03,
    "fault_gauge_gain": 0.05,
    "fault_cross_talk": 0.05,
    "fault_inertia": 0.1,
    "current": 1e-4,
}
"""So small that a fault acts in proportion to a thousandth; any size where it does throughout."""


@pytest.fixture(scope="module")
def views():
    """Each kind of run of the tank, without noise."""
    made = hidden_campaign("small", {}, noise="none")
    return View.of(each(made, made.runs, keep_without_roll), unknown_noise=True, pieces=False)


def by_hand(make, view, size):
    """Harmonics of what a fault changes."""
    plan = PLANS[view.run.id]
    shown, true = make(plan, view.t, size), forces(motion_of(plan, view.t))
    return {name: view.project(x - true[name]) for name, x in shown.items()}


@pytest.mark.parametrize("name", BY_HAND)
def test_columns_are_the_slopes_of_what_a_faulty_laboratory_writes_down(name, views):
    size = SMALL[name]
    for view in views:
        (columns,) = columns_of(CATALOGUE[name])([view], BASE, 0.0)
        true = by_hand(BY_HAND[name], view, size)
        scale = {
            channel: np.abs(x).max() for channel, x in BASE.expecting([view])[0].expected.items()
        }
        largest = max(np.abs(x).max() / scale[channel] for channel, x in true.items())
        for channel, expected in true.items():
            found = columns[channel][:, 0] if channel in columns else np.zeros(view.rows)
            np.testing.assert_allclose(
                size * found, expected, atol=2e-3 * largest * scale[channel] + 1e-12
            )


@pytest.mark.parametrize("name", BY_HAND)
def test_actions_are_exact_at_any_size(name, views):
    size = 30.0 * SMALL[name] if SMALL[name] < 0.02 else SMALL[name]
    effect = CATALOGUE[name]
    label = effect.coefficients[0].name
    for view in views:
        run = RunViews(views=(view,), base=BASE)
        shown = effect.shown(run, {label: size})
        for channel, expected in by_hand(BY_HAND[name], view, size).items():
            found = shown.get(channel, run.forces[channel]) - run.forces[channel]
            scale = np.abs(run.forces[channel]).max()
            np.testing.assert_allclose(found, expected, atol=1e-9 * scale)


def test_a_whole_filter_is_one_of_its_corner(views):
    for view in views:
        at = {"share": 1.0, "corner": 1 / (2 * np.pi * 0.08)}
        shown = CATALOGUE["fault_filter_lag"].shown(RunViews(views=(view,), base=BASE), at)
        for channel, expected in by_hand(behind_a_filter, view, 0.08).items():
            found = shown[channel] - RunViews(views=(view,), base=BASE).forces[channel]
            scale = np.abs(RunViews(views=(view,), base=BASE).forces[channel]).max()
            np.testing.assert_allclose(found, expected, atol=1e-9 * scale)


@settings(deadline=None, max_examples=25)
@given(share=st.floats(-0.5, 0.5))
def test_longer_strokes_of_sway_and_heading_are_exact(share):
    made = hidden_campaign("small", {}, noise="none")
    chosen = [run for run in made.runs if run.dynamic]
    kept = each(made.with_(runs=tuple(chosen)), tuple(chosen), keep_without_roll)
    for view in View.of(kept, unknown_noise=True, pieces=False):
        run = RunViews(views=(view,), base=BASE)
        found = run.along(strokes(run, 1.0 + share, 1.0 + share))
        for channel, expected in by_hand(longer_strokes, view, share).items():
            scale = np.abs(run.forces[channel]).max()
            change = found[channel] - run.forces[channel]
            np.testing.assert_allclose(change, expected, atol=1e-8 * scale)


def test_a_mass_on_the_balance_that_is_not_the_ship_s_is_what_is_left_in(views):
    """A share of what hangs there: its own mass, about its own centre of gravity."""
    ship = replace(SHIP, balance_mass=0.5 * SHIP.mass, balance_xG=0.1 * SHIP.L)
    view = next(view for view in views if view.run.test == "sway_yaw")
    m = motion_of(PLANS[view.run.id], view.t)
    shown = CATALOGUE["fault_inertia"].shown(
        RunViews(views=(view,), base=replace(BASE, ship=ship)), {"mass share": 0.1}
    )
    mass, x = 0.05 * SHIP.mass, 0.1 * SHIP.L
    read = {
        "X": -mass * (m.ax - x * m.r**2),
        "Y": -mass * (m.ay + x * m.rdot),
        "N": -mass * x * m.ay,
    }
    for channel, expected in read.items():
        change = shown[channel] - BASE.expecting([view])[0].expected[channel]
        np.testing.assert_allclose(change, view.project(expected), rtol=1e-8, atol=1e-8)
