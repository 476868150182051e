"""Published figures beside ours: each within the share that is stated, and the page as it stands.

All of them go to one worker, which computes each of ours once.
"""

from __future__ import annotations

import pytest

from pmmkit.bibliography import bibliography
from scripts.documentation.fences import DOCS
from scripts.validation import measurements
from scripts.validation.chains import CHAINS
from scripts.validation.page import NAME, page
from scripts.validation.published import AGREES, table

pytestmark = pytest.mark.xdist_group("published")
FIGURES = [figure for figures in CHAINS.values() for figure in figures]


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
def test_the_page_is_up_to_date():
    assert (DOCS / NAME).read_text(encoding="utf-8") == page(), "run python -m scripts.validation"


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
        how="h",
        within=1.0,
        unit={"b": "m"},
        why={"a": "it is made up"},
    )
    assert (far.off, far.agrees, far.why, far.unit) == (-0.5, float("inf"), "it is made up", "")
    assert near.off == pytest.approx(0.015)
    assert (near.agrees, near.unit) == (0.02, "m")
