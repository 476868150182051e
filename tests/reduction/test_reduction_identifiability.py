"""What the runs do not determine has no number, and the words say why."""

from __future__ import annotations

import math
import re

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from pmmkit.base import CampaignError, UnknownNameError
from pmmkit.inference import LeastSquares
from pmmkit.reduction import reduce_campaign
from scripts.datasets.virtual_tank import SON_NOMOTO, captive

DRIFT = [(f"SD{b}", "static_drift", 1.5, {"drift": math.radians(b)}) for b in (-10, -5, 0, 5, 10)]


def test_drift_alone_gives_no_yaw_derivative():
    found = reduce_campaign(captive(runs=DRIFT), check=False)
    values = found.table.at()
    assert values["Yv"] == pytest.approx(SON_NOMOTO["Yv"])
    for name in ("Yr", "Nrrr", "Yvvr", "Yvdot", "Nrdot", "Xrr", "Xvr"):
        assert math.isnan(values[name])
        assert np.isnan(found.table.std[0, found.table.index(name)])
        assert sum(name in re.split(r"[, ]+", note.split(" at Fn")[0]) for note in found.notes) == 1
    coupled = next(note for note in found.notes if "Nvvr" in note)
    assert "no value: that takes yaw with drift" in coupled
    assert len(found.notes) - len(found.untold) < 6


def test_one_drift_angle_cannot_part_linear_from_cubic():
    one = [(f"SD{b}", "static_drift", 1.5, {"drift": math.radians(b)}) for b in (-8, 8)]
    found = reduce_campaign(captive(runs=one), structure="Yv Yvvv", check=False)
    assert np.isnan(found.table.value).all()
    assert any("Yv and Yvvv" in note and "combination" in note for note in found.notes)


def test_one_sided_drift_has_an_offset_only_where_it_can_be_told():
    """Three angles on one side: Yv, Yvvv and the zero offset are all told apart, barely."""
    side = [(f"SD{b}", "static_drift", 1.5, {"drift": math.radians(b)}) for b in (3, 6, 9, 12)]
    found = reduce_campaign(captive(runs=side), structure="Yv Yvvv Nv Nvvv", check=False)
    assert found.table.at()["Yv"] == pytest.approx(SON_NOMOTO["Yv"], rel=1e-6)


def test_modulus_and_cubic_together_are_said_to_move_together():
    angles = (-12, -9, -6, -3, 0, 3, 6, 9, 12)
    fine = [(f"SD{b}", "static_drift", 1.5, {"drift": math.radians(b)}) for b in angles]
    found = reduce_campaign(
        captive(runs=fine, noise=lambda ch, U, n, k: np.random.default_rng(k).normal(size=n)),
        structure="Yv Yv|v| Yvvv",
        check=False,
    )
    assert any("move together" in note for note in found.notes)
    assert any("resembles other terms" in note for note in found.notes)


@given(
    st.integers(1, 6),
    st.integers(0, 3),
    st.integers(0, 2**31 - 1),
    st.lists(st.floats(-6, 6), min_size=6, max_size=6),
)
@settings(max_examples=60, deadline=None)
def test_fit_recovers_what_is_determined_and_only_that(count, extra, seed, exponents):
    """Random columns of any scale, some of them sums of two others: those and the two have no
    value, the rest is exact."""
    rng = np.random.default_rng(seed)
    design = rng.normal(size=(24, count)) * 10.0 ** np.array(exponents[:count])
    truth = rng.normal(size=count) / 10.0 ** np.array(exponents[:count])
    involved = set()
    columns = [design]
    for number in range(extra if count > 1 else 0):
        first, second = rng.choice(count, 2, replace=False)
        columns.append((design[:, first] + design[:, second])[:, None])
        if np.linalg.norm(design[:, first]) < 1e-5 * np.linalg.norm(design[:, second]):
            return
        if np.linalg.norm(design[:, second]) < 1e-5 * np.linalg.norm(design[:, first]):
            return
        involved |= {first, second, count + number}
    full = np.concatenate(columns, axis=1)
    names = [f"c{place}" for place in range(full.shape[1])]
    found = LeastSquares.of(names, full, design @ truth)
    for place in range(full.shape[1]):
        assert found.determined[place] == (place not in involved)
        if place < count and place not in involved:
            assert found.value[place] == pytest.approx(truth[place], rel=1e-6)


@pytest.mark.slow
def test_a_wrong_sign_of_added_mass_is_told():
    wrong = {**SON_NOMOTO, "Yvdot": 0.007}
    found = reduce_campaign(captive(wrong), check=False)
    assert any("Yvdot" in note and "no added mass" in note for note in found.notes)


def test_unknown_structure_names_the_known_ones():
    with pytest.raises(UnknownNameError, match="abkowitz3"):
        reduce_campaign(captive(runs=DRIFT), structure="abkowitz4", check=False)


def test_structure_without_a_measured_channel():
    with pytest.raises(CampaignError, match="no derivative"):
        reduce_campaign(captive(runs=DRIFT), structure="Kv Kphi", check=False)


def test_campaign_without_runs():
    with pytest.raises(CampaignError, match="no run"):
        reduce_campaign(captive(runs=DRIFT).with_(runs=()), check=False)
