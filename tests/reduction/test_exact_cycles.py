"""Cycles that hold nothing between the harmonics: a table, or an error that says where."""

from __future__ import annotations

import re
import warnings

import numpy as np
import pytest

from pmmkit.base import CampaignError
from pmmkit.reduction import reduce_campaign
from tests.support.exact_cycles import campaign

CASES = [
    (structure, order, fn)
    for structure in ("abkowitz3", "cubic")
    for order in (1, 2, 3, 5)
    for fn in ("each", "pooled")
]


@pytest.mark.parametrize(("structure", "order", "fn"), CASES)
def test_it_ends_in_a_table_or_says_which_channel_at_which_speed(structure, order, fn):
    """Neither an error of an equation solver nor a warning of a division reaches anybody."""
    with warnings.catch_warnings():
        warnings.simplefilter("error", RuntimeWarning)
        try:
            found = reduce_campaign(
                campaign(order), structure=structure, fn=fn, check=False, executor=1
            )
            ended = "a table" if np.isfinite(found.table["Yv"]).all() else "no value"
        except CampaignError as error:
            ended = str(error)
    assert re.match(r"a table|[XYN]( at Fn 0\.\d+)?: these runs have no solution", ended)


def test_an_error_of_the_solver_names_channel_and_froude_number(monkeypatch):
    def fails(*_):
        raise np.linalg.LinAlgError("Matrix is not positive definite")

    monkeypatch.setattr("pmmkit.reduction.estimate.whiteners", fails)
    with pytest.raises(CampaignError, match=r"^X at Fn 0\.145: .* no solution in numbers"):
        reduce_campaign(campaign(3), check=False, executor=1)
