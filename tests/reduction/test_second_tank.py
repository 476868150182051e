"""A tanker on a raw balance, from a tank that shares no formula with the package or the first."""

from __future__ import annotations

import numpy as np
import pytest

from pmmkit.reduction import reduce_campaign
from tests.support import second_tank


def reduced(seed, gain, offset):
    made = second_tank.campaign(
        "small", seed, gain, offset, lambda rng: float(rng.standard_normal())
    )
    return reduce_campaign(made, structure=list(second_tank.CENTRAL), executor=1)


@pytest.mark.slow
def test_runs_that_scatter_give_the_truth_within_intervals_that_say_so():
    """Errors of 1 % of the gain and 0.6 % of the scale, told to nobody."""
    found = [reduced(seed, 0.01, 0.006) for seed in range(4)]
    right = second_tank.truth(second_tank.MIDDLE)
    names = found[0].table.names
    errors = np.array(
        [
            (table.value[0] - [right[name] for name in names]) / table.std[0]
            for table in (item.table for item in found)
        ]
    )
    assert 0.7 < np.sqrt(np.mean(errors**2)) < 1.4
    quiet = reduced(0, 0.0, 0.0)
    assert np.median(found[0].table.std / quiet.table.std) > 1.3
    assert quiet.verdict.use == "usable"
    assert not any(item.influences.odd for item in found)
