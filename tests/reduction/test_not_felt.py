"""Terms that the motion of the runs hardly makes: no value rather than any value."""

from __future__ import annotations

import numpy as np
import pytest
from small_campaign import TRUTH, write_campaign

import pmmkit as pk
from pmmkit.reduction import reduce_campaign

COUPLED = ("Xvr", "Yvvr", "Yvrr", "Nvvr", "Nvrr")


def turned(folder, drift):
    """The small programme, its yaw tests with drift all at one angle, as the file says it."""
    write_campaign(folder)
    file = folder / "campaign.toml"
    head, *entries = file.read_text(encoding="utf-8").split("\n[[runs]]")
    kept = [entry for entry in entries if "yaw_drift" not in entry]
    yaws = [entry.replace("pure_yaw", "yaw_drift") + f"drift_deg = {drift}\n" for entry in kept
            if "pure_yaw" in entry]  # fmt: skip
    kept = [entry for entry in kept if "pure_yaw" not in entry]
    file.write_text("\n[[runs]]".join([head, *kept, *yaws]), encoding="utf-8")
    return reduce_campaign(pk.open_campaign(folder), executor=1)


@pytest.mark.slow
def test_a_hundredth_of_a_degree_of_drift_shows_no_coupling(tmp_path):
    """A laboratory's yaw tests at 0.009° of drift gave Nvvr 153 +- 836 (no hull has 1)."""
    table = turned(tmp_path / "tests", 0.01).table
    for name in COUPLED:
        assert np.isnan(table[name]).all(), name
    for name in ("Yv", "Nv", "Yr", "Nr", "Nrrr", "Yvdot", "Nrdot"):
        away = (table[name] - TRUTH[name]) / table.std[:, table.index(name)]
        assert np.max(np.abs(away)) < 4.0, name


@pytest.mark.slow
def test_four_degrees_show_it(tmp_path):
    folder = tmp_path / "tests"
    write_campaign(folder)
    table = reduce_campaign(pk.open_campaign(folder), executor=1).table
    assert all(np.isfinite(table[name]).all() for name in COUPLED)
