"""Runs looked at together give what each gives alone."""

from __future__ import annotations

import numpy as np
import pytest
from hidden_effects import BASE, hidden_campaign

from pmmkit.diagnosis.captive.adequacy import gains
from pmmkit.diagnosis.captive.diagnose import captive_system
from pmmkit.diagnosis.captive.evidence import spread
from pmmkit.diagnosis.captive.refit import captive_candidates
from pmmkit.reduction import RunViews
from pmmkit.reduction.observations import views

SLOPE = 1e-10
"""Rounding of a force over the step of 1e-4 by which slopes are taken, and room for two digits."""


@pytest.fixture(scope="module")
def system():
    return captive_system(hidden_campaign("small", {}, seed=4), BASE)


@pytest.mark.parametrize("item", captive_candidates((1.0, 1.5)), ids=lambda item: item.name)
def test_columns_of_several_runs_are_those_of_each(system, item):
    value = item.grid[-1]
    together = item.columns(system.views, system.base, value)
    for view, found in zip(system.views, together, strict=True):
        (alone,) = item.columns([view], system.base, value)
        for name, force in view.force.items():
            none = np.zeros((len(force), item.size))
            columns, largest = alone.get(name, none), np.abs(force).max()
            np.testing.assert_allclose(
                found.get(name, none), columns, rtol=1e-11, atol=SLOPE * largest
            )


def test_runs_stand_in_their_order_and_are_cut_before_they_are_too_long(system, monkeypatch):
    whole = list(RunViews.stretches(system.views, system.base))
    assert [view for own in whole for view in own.views] == list(system.views)
    assert all(own.size <= views.SAMPLES for own in whole if len(own.views) > 1)
    monkeypatch.setattr(views, "SAMPLES", 1)
    cut = RunViews.stretches(system.views, system.base)
    assert [own.views for own in cut] == [(view,) for view in system.views]


def test_numbers_of_each_run_stand_at_its_samples(system):
    (own, *_) = RunViews.stretches(system.views, system.base)
    np.testing.assert_allclose(own.means(own.speed), own.speed, rtol=1e-14)
    for view, samples in zip(own.views, own.samples, strict=True):
        np.testing.assert_array_equal(own.history("v")[samples], view.motion.v)


def test_what_an_effect_adds_beside_a_transient_is_the_same_written_out(monkeypatch):
    """Evidence of both is that of the transient and that of the other beside it."""
    monkeypatch.setattr("pmmkit.diagnosis.captive.build.MANY", 5)
    found = captive_system(hidden_campaign("small", {"fault_transient": 1.0}, seed=4), BASE)
    names = ("fault_transient", "modulus_sway_drag")
    blocks = [next(b for b in found.blocks if b.candidate.name == name) for name in names]
    assert blocks[0].drawn is not None
    written, dense = spread(found, blocks)
    assert gains(found, blocks) == pytest.approx(gains(written, dense), rel=1e-8, abs=1e-8)


def test_a_few_runs_are_whitened_as_among_all(system):
    projection = system.pieces[1].projection
    columns = np.random.default_rng(1).normal(size=(len(projection.channel.y), 3))
    rows = np.concatenate([projection.channel.runs[number] for number in (4, 1)])
    np.testing.assert_allclose(
        projection.whitened_runs((4, 1), columns[rows]),
        projection.whitened(columns)[rows],
        rtol=1e-10,
    )
