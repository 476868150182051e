"""The evidence of effects in closed form: multivariate normals written out, and counted chances."""

from __future__ import annotations

import math
from itertools import combinations
from types import SimpleNamespace

import numpy as np
import pytest
from scipy.stats import multivariate_normal, ncx2

from pmmkit.diagnosis.captive import evidence
from pmmkit.diagnosis.captive.evidence import Sets, gate, ranked_sets, sets_of
from pmmkit.diagnosis.evidence import PRICE, could_hide, mimics, weight, with_or_without
from pmmkit.inference import Normal

ROWS = 40


def block_of(name, first, count=1, value=None):
    """An effect of some columns of a system, at one point of its grid."""
    candidate = SimpleNamespace(name=name, size=name)
    columns = slice(first, first + count)
    places = np.arange(first, first + count)
    return SimpleNamespace(
        candidate=candidate, columns=columns, places=places, drawn=None, count=count, value=value
    )


def system_of(blocks, columns, data, centre=None):
    """What the evidence asks of a system: whitened columns (n, q) and data (n,)."""
    return SimpleNamespace(
        blocks=blocks,
        normal=Normal.of(columns, data, None if centre is None else np.asarray(centre, float)),
    )


@pytest.fixture
def measured():
    """Columns of four effects, one of which has two points, and data that hold the second."""
    rng = np.random.default_rng(7)
    columns = rng.normal(size=(ROWS, 6))
    columns[:, 2] = columns[:, 1] + 0.3 * rng.normal(size=ROWS)
    data = rng.normal(size=ROWS) + 2.0 * columns[:, 1] - 1.5 * columns[:, 5]
    blocks = [
        block_of("asymmetry", 0),
        block_of("lag", 1, value=1.0),
        block_of("lag", 2, value=2.0),
        block_of("wind", 3, count=2),
        block_of("roll", 5),
    ]
    return system_of(blocks, columns, data, centre=[0.2, 0.0, 0.0, -0.5, 0.1, 0.0]), columns, data


def by_density(columns, data, centre):
    """ln N(d; E c, I + E E') less ln N(d; 0, I), by scipy."""
    whole = np.eye(len(data)) + columns @ columns.T
    return multivariate_normal(columns @ centre, whole).logpdf(data) - multivariate_normal(
        np.zeros(len(data)), np.eye(len(data))
    ).logpdf(data)


def test_the_odds_of_an_effect_do_not_hang_on_what_else_is_in_the_catalogue(measured):
    """Two entries more, of which one resembles the wind: nothing changes for the others."""
    system, columns, data = measured
    more = np.column_stack([columns, columns[:, 3] + 0.1 * columns[:, 0], columns[:, 4]])
    blocks = [*system.blocks, block_of("memory", 6), block_of("stall", 7)]
    larger = system_of(blocks, more, data, [*system.normal.centre, 0.0, 0.0])
    before, after = (ranked_sets(sets_of(x), most=2) for x in (system, larger))
    odds = {item.names: item.log_evidence for item in after}
    assert before
    for item in before:
        assert odds[item.names] == pytest.approx(item.log_evidence, rel=1e-12)


def test_a_set_is_averaged_over_its_grid_and_pays_for_each_effect(measured):
    system, columns, data = measured
    sets = Sets(
        system=system, by_name=sets_of(system).by_name, near=sets_of(system).near, beside={}
    )
    of = [by_density(columns[:, [k]], data, system.normal.centre[[k]]) for k in (1, 2)]
    alone = sets.entry(["lag"])
    assert alone.log_evidence == pytest.approx(np.logaddexp(*of) - math.log(2) - PRICE)
    assert alone.values == (1.0 if of[0] > of[1] else 2.0,)
    both = [by_density(columns[:, [k, 5]], data, system.normal.centre[[k, 5]]) for k in (1, 2)]
    pair = sets.entry(["lag", "roll"])
    assert pair.log_evidence == pytest.approx(np.logaddexp(*both) - math.log(2) - 2 * PRICE)
    roll = sets.entry(["roll"]).log_evidence
    assert sets.added(pair) == pytest.approx(
        (pair.log_evidence - roll, pair.log_evidence - alone.log_evidence)
    )


def test_a_set_has_one_effect_two_or_three(measured):
    system, *_ = measured
    sets, names = sets_of(system), ("asymmetry", "lag", "roll", "wind")
    for most in (1, 2, 3):
        found = ranked_sets(sets, most=most)
        logs = [item.log_evidence for item in found]
        assert logs == sorted(logs, reverse=True)
        # Of four effects all pairs are asked, and triples that hold one of the three best pairs.
        asked = {tuple(sorted(item.names)) for item in found}
        assert {x for x in asked if len(x) < 3} == {
            own for count in range(1, min(most, 2) + 1) for own in combinations(names, count)
        }
        pairs = [set(item.names) for item in found if len(item.names) == 2][:3]
        assert {x for x in asked if len(x) == 3} == {
            own for own in combinations(names, 3) if most > 2 and any(p < set(own) for p in pairs)
        }
    assert ranked_sets(sets) == ranked_sets(sets, most=evidence.MOST)


def test_the_chance_of_the_null_is_counted(measured):
    """Of data that hold nothing the share whose best effect is as good, drawn anew here."""
    system, columns, _ = measured
    empty = np.random.default_rng(12).normal(size=(8_000, ROWS))
    best = np.full(len(empty), -np.inf)
    for places in ([[0]], [[1], [2]], [[3, 4]], [[5]]):
        own = []
        for at in places:
            E, c = columns[:, at], system.normal.centre[at]
            whole = np.eye(ROWS) + E @ E.T
            logs = multivariate_normal(E @ c, whole).logpdf(empty)
            own.append(logs - multivariate_normal(np.zeros(ROWS), np.eye(ROWS)).logpdf(empty))
        mean = np.logaddexp.reduce(own, axis=0) - math.log(len(places)) - PRICE
        best = np.maximum(best, mean)
    for share in (0.5, 0.1, 0.02):
        bar = float(np.quantile(best, 1 - share))
        found = gate(system, bar, draws=4_000)
        # Both are counts: 4,000 draws of ours and 8,000 here.
        std = math.sqrt(share * (1 - share) * (1 / 4_000 + 1 / 8_000))
        assert found == pytest.approx(share, abs=4 * std)


def test_the_chance_is_never_zero_and_never_above_one(measured):
    """One more than were counted, over one more than were drawn (Davison and Hinkley 1997)."""
    system, *_ = measured
    assert gate(system, 1e9, draws=99) == pytest.approx(1 / 100)
    assert gate(system, -1e9, draws=99) == 1.0


def test_a_mimic_reproduces_the_square_of_the_correlation():
    """Of a signature, by a column at the cosine .8 and by one at .6; .36 is none."""
    columns = np.array([[1.0, 0.0, 0.0], [0.8, 0.6, 0.0], [0.6, 0.0, 0.8], [1.0, 0.0, 0.0]]).T
    G = columns.T @ columns
    others = {"near": np.array([1]), "far": np.array([2]), "both": np.array([1, 2])}
    (found,) = mimics(G, G[:, :1], np.ones(1), others)
    assert found["near"] == pytest.approx(0.64)
    assert "far" not in found
    # Of the plane of both the normal is (-.48, .64, .36) over its length.
    assert found["both"] == pytest.approx(1.0 - 0.48**2 / (0.48**2 + 0.64**2 + 0.36**2))
    assert list(found) == ["both", "near"]


def test_what_nothing_shows_may_be_of_any_size():
    assert could_hide(np.zeros((2, 2)), np.ones(2)) == math.inf
    assert could_hide(np.full(1, 1e-9), np.ones(1)) == math.inf


@pytest.mark.parametrize("count", [1, 3])
def test_what_could_hide_is_the_size_that_a_noncentral_chi_square_finds(count):
    """Of a signal far above noise ln E is half a noncentral χ² less half of ln|1 + G|."""
    G = np.diag(np.full(count, 1e6))
    usual = np.full(count, 0.1)
    size = could_hide(G, usual, price=6.0)
    needed = 2.0 * 6.0 + count * math.log(1e6)
    found = ncx2.sf(needed, df=count, nc=size**2 * float(usual @ G @ usual))
    assert found == pytest.approx(0.95, abs=0.02)
    turned = np.linalg.qr(np.random.default_rng(2).normal(size=(count, count)))[0]
    spread = np.diag(np.linspace(1.0, 2.0, count)) * 1e4
    assert could_hide(turned @ spread @ turned.T, turned @ usual) == pytest.approx(
        could_hide(spread, usual), rel=0.05
    )


def test_a_small_effect_speaks_against_what_is_expected_of_it():
    """A size that is three standard deviations of the prior off costs 9/2 of ln evidence."""
    G, usual = np.diag([1e8]), np.ones(1)
    about_three = could_hide(G, usual, np.array([3.0]), price=6.0)
    assert about_three == pytest.approx(could_hide(G, usual, price=6.0 + 4.5), rel=1e-3)
    assert about_three > 1.05 * could_hide(G, usual, price=6.0)


@pytest.mark.parametrize(
    ("factor", "words"),
    [
        (151.0, "decisive"),
        (149.0, "likely"),
        (21.0, "likely"),
        (19.0, "cannot be told"),
        (1.0, "cannot be told"),
        (1.0 / 19.0, "cannot be told"),
        (1.0 / 21.0, "does not help"),
    ],
)
def test_evidence_is_told_in_the_grades_of_kass_and_raftery(factor, words):
    assert weight(math.log(factor)) == words


def test_what_leaves_the_held_out_misfit_does_not_help_whatever_its_odds():
    assert weight(1000.0, share=0.0049) == "does not help"
    assert weight(1000.0, share=0.0051) == "decisive"


def test_an_effect_is_weighed_against_the_best_that_does_without_it():
    ranked = (
        [("a",), 200.0],
        [("b",), 150.0],
        [("c",), 0.5],
        [("a", "b"), 198.0],
        [("d",), math.nan],
    )
    entries = [SimpleNamespace(names=names, log_evidence=x) for names, x in ranked]
    odds = {name: with_or_without(name, entries) for name in "abcd"}
    assert odds == {"a": 50.0, "b": -2.0, "c": -199.5, "d": -math.inf}
    assert with_or_without("c", entries[2:3]) == 0.5  # nothing at all is the other answer
