"""Records of a carriage from rest to rest: the DTC in shallow water, as its laboratory writes."""

from __future__ import annotations

import shutil

import numpy as np
import pytest

import pmmkit as pk
from pmmkit.cli import main
from pmmkit.reduction import PreparedRun

TYPED = {
    "# L = ...": "L = 3.984",
    "# B = ...": "B = 0.5723",
    "# d = ...": "d = 0.163",
    "# mass = ...": "volume = 0.2459",
    "# Izz = ...": "Izz = 240.0",
}
"""355 m by 51 m at 1:89.11; block and gyration as of such a ship: they enter no mean."""
DEPTH = {"C1": 0.326, "C2": 0.326, "C3": 0.1956}
"""2.0 and 1.2 draughts."""
STEADY = {
    "C1": (0.327, -0.81, 0.73e-3),
    "C2": (0.872, -5.58, 6.60e-3),
    "C3": (0.327, -1.11, 1.36e-3),
}
"""Speed [m/s], X [N], heave [m], read by eye off the steady part."""


@pytest.fixture(scope="module")
def campaign(shared_data, tmp_path_factory):
    source = shared_data / "dtc_captive"
    if not source.is_dir():
        pytest.skip("the records of the DTC are not there")
    folder = tmp_path_factory.mktemp("dtc")
    for name in DEPTH:
        shutil.copy(source / f"{name}.dat", folder)
    assert main(["new-campaign", str(folder), "--quiet"]) == 0
    file = folder / "campaign.toml"
    text = file.read_text(encoding="utf-8")
    for draft, typed in TYPED.items():
        assert draft in text
        text = text.replace(draft, typed, 1)
    for name, depth in DEPTH.items():
        text = text.replace(f'id = "{name}"', f'id = "{name}"\ndepth = {depth}', 1)
    file.write_text(text, encoding="utf-8")
    return pk.open_campaign(file)


def test_the_steady_part_is_found(campaign):
    for run in campaign:
        speed, X, heave = STEADY[run.id]
        found = PreparedRun.of(run, campaign).result
        assert run.settings.speed == pytest.approx(speed, abs=5e-4)
        assert found.measured["X"][0] == pytest.approx(X, abs=0.035)
        assert abs(found.extras["sinkage"]) == pytest.approx(heave, abs=0.06e-3)
        assert np.isfinite(found.covariance["X"]).all()


def test_each_bottom_is_a_campaign(campaign):
    assert campaign.depths == (0.326, 0.1956)
    assert [[run.id for run in part] for part in campaign.by_depth()] == [["C1", "C2"], ["C3"]]
