"""What a propeller does astern, estimated from its open water ahead."""

from __future__ import annotations

from types import MappingProxyType

import pytest

import pmmkit as pk
from pmmkit.base import ModelError
from pmmkit.cli import main
from pmmkit.models import Part
from pmmkit.models.model import ASTERN


def test_ahead_nothing_changes():
    """Whatever a ship does with her propeller ahead she does as before."""
    plain = pk.load_model("s175")
    turned = plain.with_estimated_astern()
    tracks = [pk.simulate(x, "zigzag", speed=9.0, compiled=False) for x in (plain, turned)]
    assert tracks[1].psi == pytest.approx(tracks[0].psi, abs=1e-9)
    assert tracks[1].u == pytest.approx(tracks[0].u, rel=1e-9)


def test_kvlcc2_stops_nearly_as_with_her_own_pitch_in_the_series():
    """P/D of her propeller is 0.721 (SIMMAN 2008); the estimate does not know it."""
    model = pk.load_model("kvlcc2")
    own = model.part("propeller").values
    series = Part(
        effect="four_quadrant_propeller",
        values=MappingProxyType({name: own[name] for name in ("D", "t", "wp")} | {"pitch": 0.721}),
        options=MappingProxyType({"characteristics": "b4-70"}),
    )
    parts = {name: part for name, part in model.parts.items() if name != "propeller"}
    with_series = model.with_(parts=MappingProxyType({**parts, series.effect: series}))
    reach = [
        pk.simulate(x, "stopping", speed=7.97, compiled=False).metrics["track_reach_L"]
        for x in (model.with_estimated_astern(), with_series)
    ]
    assert reach[0] == pytest.approx(reach[1], rel=0.12)


def test_who_knows_astern_stops_as_she_is():
    tanker = pk.load_model("esso190k")
    assert tanker.as_it_stops() is tanker
    assert pk.load_model("mariner").as_it_stops() is None
    with pytest.raises(ModelError, match="says already"):
        tanker.with_estimated_astern()
    with pytest.raises(ModelError, match="no propeller whose KT"):
        pk.load_model("mariner").with_estimated_astern()


def test_the_command_writes_a_model_that_stops(tmp_path, capsys):
    out = tmp_path / "kcs-astern.toml"
    assert main(["model", "astern", "kcs", "-o", str(out)]) == 0
    assert ASTERN in capsys.readouterr().out
    assert pk.load_model(out).knows_astern
    assert main(["model", "astern", "kcs", "propeller"]) == 2
