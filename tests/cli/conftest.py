"""What several files of tests type first, typed once."""

from __future__ import annotations

import io
import json
from collections.abc import Mapping
from contextlib import redirect_stdout
from pathlib import Path
from typing import Any

import pytest

from pmmkit.cli import main

Typed = tuple[Path, Mapping[str, Any]]


@pytest.fixture(scope="session")
def hmri(shared_data: Path, datasets: Path, tmp_path_factory: pytest.TempPathFactory) -> Typed:
    """The folder that a reduction of HMRI's tests writes, and what it says."""
    folder = tmp_path_factory.mktemp("hmri") / "kvlcc2_hmri-reduced"
    words = ["reduce", datasets / "kvlcc2_hmri", "--data", shared_data, "--structure", "mmg"]
    with pytest.MonkeyPatch.context() as patch, redirect_stdout(io.StringIO()) as told:
        patch.setattr("pmmkit.report.drawn.svg", lambda figure: "<svg></svg>")
        assert main([*map(str, words), "--out", str(folder), "--json"]) == 0
    return folder, json.loads(told.getvalue())
