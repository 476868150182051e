"""Published figures beside ours: each within the share that is stated, and the pages as they stand.

All of them go to one worker, which computes each of ours once.
"""

from __future__ import annotations

import re
from typing import get_args

import pytest

from pmmkit.conventions import bibliography
from scripts.documentation.fences import DOCS
from scripts.validation import measurements
from scripts.validation.chains import CHAINS
from scripts.validation.page import NAMES, SHARES, pages
from scripts.validation.published import AGREES, Part, table

pytestmark = pytest.mark.xdist_group("published")
FIGURES = [figure for figures in CHAINS.values() for figure in figures]
PARTS = {part: [x for x in FIGURES if x.part == part] for part in get_args(Part)}


def tables_of(text: str) -> list[list[list[str]]]:
    """Cells of the tables of a page, without their heads."""
    found = re.findall(r"^\|.*\n\|(?:---\|)+\n((?:\|.*\n)+)", text, re.M)
    split = re.compile(r"(?<!\\)\|")
    return [
        [[x.strip() for x in split.split(line)[1:-1]] for line in of.splitlines()] for of in found
    ]


@pytest.mark.slow
@pytest.mark.parametrize("chain", CHAINS)
def test_ours_lie_within_what_is_stated(chain):
    off = [
        f"{figure.table}, {figure.name}: {figure.value:g}, ours {figure.ours():g}"
        for figure in CHAINS[chain]
        if not abs(figure.off) <= figure.within
    ]
    assert off == []


@pytest.mark.slow
def test_what_does_not_agree_says_why():
    silent = [f"{x.table}, {x.name}" for x in FIGURES if abs(x.off) > AGREES[-1] and not x.why]
    assert silent == []


@pytest.mark.slow
def test_the_pages_are_up_to_date():
    for name, text in pages().items():
        assert (DOCS / name).read_text(encoding="utf-8") == text, "run python -m scripts.validation"


def test_each_figure_is_one_of_three():
    """A prediction stands beside what was measured, a program beside what nobody measured."""
    assert sum(map(len, PARTS.values())) == len(FIGURES)
    assert {x.nature for x in PARTS["prediction"]} == {"measured"}
    assert "measured" not in {x.nature for x in PARTS["program"]}
    assert all(len({x.part for x in FIGURES if x.table == y.table}) == 1 for y in FIGURES)


@pytest.mark.slow
def test_the_front_page_opens_with_its_counts_and_has_every_prediction():
    text = pages()[NAMES["prediction"]]
    title, _, head, *_ = text.splitlines()
    assert title == "# Our predictions beside measurements"
    assert head.startswith("| ship and test | figures | median difference |")
    (*rows, last), *shown = tables_of(text)
    assert [int(row[1]) for row in rows] == [len(of) for of in shown]
    for column, share in enumerate((float("inf"), *SHARES)):
        place = 1 if not column else 3 + column
        near = sum(abs(x.off) <= share for x in PARTS["prediction"])
        assert sum(int(row[place]) for row in rows) == int(last[place]) == near


@pytest.mark.slow
def test_what_is_no_prediction_stands_behind_and_two_other_parties_are_not_counted():
    made = pages()
    chains, natures, _, *shown = tables_of(made[NAMES["program"]])
    for of in (chains, natures):
        assert sum(int(row[1]) for row in of[:-1]) == int(of[-1][1]) == len(PARTS["program"])
    assert sum(map(len, shown)) == len(PARTS["program"])
    others = tables_of(made[NAMES["literature"]])
    assert [row[0] for of in others for row in of] == [x.name for x in PARTS["literature"]]


def test_no_figure_stands_twice_and_each_names_its_source():
    names = [(figure.table, figure.name) for figure in FIGURES]
    assert len(set(names)) == len(names)
    for figure in FIGURES:
        assert set(figure.sources) <= set(bibliography())
        assert figure.place
        assert figure.how


@pytest.mark.parametrize("section", ["hydrostatics", "head_seas", "resistance"])
def test_what_is_kept_of_files_that_are_not_here_is_what_comes_of_them(shared_data, section):
    """HMRI's parts are held to it beside the reduction that they take (test_parts.py); of hull and
    zigzags the kept figures are made anew by ``--data`` alone."""
    found = measurements.RECIPES[section](shared_data)
    assert found == pytest.approx(measurements.kept(section)(), rel=1e-5)


def test_a_figure_knows_its_difference_over_its_size():
    far, near = table(
        "t",
        {"a": -2.0, "b": 4.0},
        lambda: {"a": -3.0, "b": 4.06},
        sources=(),
        place="p",
        nature="printed",
        part="program",
        how="h",
        within=1.0,
        unit={"b": "m"},
        std={"b": 0.03},
        why={"a": "it is made up"},
    )
    assert (far.off, far.agrees, far.why, far.unit) == (-0.5, float("inf"), "it is made up", "")
    assert near.off == pytest.approx(0.015)
    assert (near.agrees, near.unit) == (0.02, "m")
    assert (far.std, far.expected, near.expected) == (0.0, False, True)
