"""The page tells each derivative with the words of the table."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import pmmkit as pk
from pmmkit.presentation import WIDE, plus_minus
from pmmkit.views import page_of
from pmmkit.views.pages.missing import coefficients_page


@pytest.fixture(scope="module")
def reduction(datasets):
    return pk.reduce_campaign(pk.open_campaign(datasets / "s175"), structure="linear")


@pytest.mark.parametrize("share", [1.0, 1e-5])
def test_a_derivative_is_told_as_in_the_table(reduction, share):
    """With a hundred-thousandth of its uncertainty both ends of an interval have five digits
    alike."""
    table = reduction.table.with_(covariance=share**2 * reduction.table.covariance)
    page = page_of(replace(reduction, table=table))
    told = {row["name"]: [item["told"] for item in row["values"]] for row in page["rows"]}
    grid = {row[0]: row[1:] for group in table.grid().groups for row in group.rows}
    assert told == grid
    assert any(np.isfinite(table.value.ravel()))


def test_a_coefficient_has_half_of_its_95_percent_interval():
    (row,) = coefficients_page(["Yv F"], [0.0015], [5e-5], [-0.001])
    assert row["half"] == pytest.approx(WIDE * 5e-5, rel=1e-4)
    assert plus_minus(row["value"], row["half"]) == "0.001500 ± 0.000098"
