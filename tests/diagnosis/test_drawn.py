"""What each of very many runs draws stands beside the system: the same numbers as written out."""

from __future__ import annotations

import numpy as np
import pytest
from hidden_effects import BASE, hidden_campaign

from pmmkit.diagnosis.captive import build
from pmmkit.diagnosis.captive.diagnose import captive_system
from pmmkit.diagnosis.captive.evidence import (
    condition_on,
    evidence_of,
    ranked_sets,
    sets_of,
    spread,
)
from pmmkit.diagnosis.captive.verdict import answer, coverage
from pmmkit.diagnosis.captive.whitening import OwnColumns


@pytest.fixture(scope="module")
def systems():
    """One campaign of a transient, its columns written out and beside the system."""
    campaign = hidden_campaign("small", {"fault_transient": 1.0}, seed=4)
    written = captive_system(campaign, BASE)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(build, "MANY", 5)
        beside = captive_system(campaign, BASE)
    return written, beside


def named(system, name):
    return [block for block in system.blocks if block.candidate.name == name]


def test_the_columns_stand_beside_the_system_and_evidence_is_the_same(systems):
    written, beside = systems
    ours, theirs = (named(system, "fault_transient") for system in systems)
    assert all(block.drawn is None for block in ours)
    assert all(block.drawn is not None for block in theirs)
    assert len(beside.normal.information) < len(written.normal.information)
    for one, other in zip(ours, theirs, strict=True):
        assert one.count == other.count
        assert evidence_of(beside, other) == pytest.approx(evidence_of(written, one), rel=1e-10)


def test_written_out_it_is_the_system_it_would_have_been(systems):
    """Products of everything with everything, in another order."""
    written, beside = systems
    whole, blocks = spread(beside, named(beside, "fault_transient"))
    for one, other in zip(named(written, "fault_transient"), blocks, strict=True):
        a, b = one.places, other.places
        np.testing.assert_allclose(
            whole.normal.information[np.ix_(b, b)],
            written.normal.information[np.ix_(a, a)],
            atol=1e-9,
        )
        np.testing.assert_allclose(
            whole.normal.score[b], written.normal.score[a], rtol=1e-9, atol=1e-9
        )
    (first, second, *_), (ours, other, *_) = blocks, named(written, "fault_transient")
    np.testing.assert_allclose(
        whole.normal.information[np.ix_(first.places, second.places)],
        written.normal.information[np.ix_(ours.places, other.places)],
        atol=1e-9,
    )


@pytest.mark.parametrize("given", [("modulus_sway_drag",), ("fault_transient",)])
def test_beside_what_is_known_it_is_the_same(systems, given):
    found = []
    for system in systems:
        known = condition_on(system, [named(system, name)[0] for name in given])
        sets = sets_of(known)
        found.append({item.names: item.log_evidence for item in ranked_sets(sets, most=2)})
    assert found[0].keys() == found[1].keys()
    for names, value in found[0].items():
        assert found[1][names] == pytest.approx(value, rel=1e-8, abs=1e-7)


def test_what_the_runs_could_show_is_the_same(systems):
    ours, theirs = ({item.name: item for item in coverage(system)} for system in systems)
    one, other = ours["fault_transient"], theirs["fault_transient"]
    assert other.signal == pytest.approx(one.signal, rel=1e-9)
    assert other.without_a_run == pytest.approx(one.without_a_run, rel=1e-9)
    assert other.mimics == pytest.approx(one.mimics, rel=1e-6)


def test_the_answer_is_the_same(systems):
    written, beside = (answer(system, floor=0.005) for system in systems)
    assert written.group == beside.group == ((("fault_transient",), 1.0),)
    (one,), (other,) = written.findings, beside.findings
    assert other.coefficients == pytest.approx(one.coefficients, rel=1e-9)
    assert other.error_after == pytest.approx(one.error_after, rel=1e-9)


def test_a_row_belongs_to_one_run_or_to_none():
    own = OwnColumns(values=np.array([2.0, 3.0, 5.0]), column=np.array([1, -1, 0]), count=2)
    np.testing.assert_allclose(own.dense(), [[0.0, 2.0], [0.0, 0.0], [5.0, 0.0]])
    np.testing.assert_allclose(own.sparse().toarray(), own.dense())
