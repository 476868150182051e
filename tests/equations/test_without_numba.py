"""Where numba cannot be imported Python runs the equations, with the same numbers, and says so."""

from __future__ import annotations

import json
import sys
from functools import cache

import numpy as np
import pytest

import pmmkit as pk
from pmmkit.cli import main
from pmmkit.equations import compilation, run


@pytest.fixture
def without_numba(monkeypatch):
    """numba cannot be imported, and nothing that was compiled before is at hand."""
    monkeypatch.delitem(sys.modules, "pmmkit.equations.compiled_cache", raising=False)
    monkeypatch.delattr("pmmkit.equations.compiled_cache", raising=False)
    monkeypatch.setitem(sys.modules, "numba", None)
    monkeypatch.setattr(compilation, "compiled", cache(compilation.compiled.__wrapped__))


def test_many_ships_turn_as_those_of_compiled_equations(without_numba):
    turn = {"rudder_deg": 35, "speed": 8.0}
    with pytest.warns(UserWarning, match=r"interpreted.*Install numba"):
        many = pk.monte_carlo("kvlcc2", "turning", **turn, n=2, spread=0.05)
    single = pk.simulate("kvlcc2", "turning", **turn, compiled=False)
    known = single.metrics["tactical_diameter_L"]
    assert many.nominal["tactical_diameter_L"] == pytest.approx(known, rel=1e-9)
    assert np.ptp(many.metrics["tactical_diameter_L"]) > 0


def test_the_command_turns_a_ship(without_numba, monkeypatch, tmp_path, capsys):
    # As in a session of its own, whatever other tests sailed before.
    monkeypatch.setattr(run, "ENOUGH", 10**9)
    monkeypatch.setattr(run, "FEW", 10**9)
    monkeypatch.setattr(run, "is_loaded", lambda _: False)
    turn = ["--speed", "8", "--rudder-deg", "35", "--no-figures", "--out", str(tmp_path / "turn")]
    assert main(["simulate", "kvlcc2", *turn]) == 0
    assert "interpreted" not in capsys.readouterr().err  # one turn takes no longer
    metrics = json.loads((tmp_path / "turn" / "metrics.json").read_text(encoding="utf-8"))
    assert metrics["tactical_diameter_L"] == pytest.approx(3.004, abs=0.01)
