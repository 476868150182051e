"""Fixtures that several tests share."""

from __future__ import annotations

import gc
import io
import json
import os
from contextlib import redirect_stdout
from pathlib import Path
from typing import Any

import pytest
from hypothesis import settings
from kept import Kept

# The same examples for everyone; scripts/studies/properties.py looks for others.
settings.register_profile("everyone", deadline=None, derandomize=True)
settings.load_profile("everyone")

ROOT = Path(__file__).parents[1]


@pytest.hookimpl(tryfirst=True)
def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Slow tests come first, so that no worker is left with one when the others are done; those
    that share a fixture of their module go to one worker, which makes it once."""
    items.sort(key=lambda item: item.get_closest_marker("slow") is None)
    for item in items:
        known = getattr(item, "_fixtureinfo", None)
        made = known.name2fixturedefs.values() if known else ()
        if any(own[-1].scope != "function" and own[-1].baseid == _file(item) for own in made):
            item.add_marker(pytest.mark.xdist_group(_file(item)))


def pytest_collection_finish() -> None:
    """What was collected stays to the end. The search for garbage passes over it: else it costs
    many times as much, and comes so seldom that reports and figures pile up between."""
    gc.collect()
    gc.freeze()
    gc.collect()  # sets the count of what may be garbage, on which the next search hangs


def _file(item: pytest.Item) -> str:
    return item.nodeid.split("::")[0]


@pytest.fixture(scope="session")
def kept(tmp_path_factory: pytest.TempPathFactory) -> Kept:
    """What is made once for all workers."""
    own = tmp_path_factory.getbasetemp()
    return Kept((own.parent if "PYTEST_XDIST_WORKER" in os.environ else own) / "kept")


@pytest.fixture(scope="session")
def shared_data() -> Path:
    """The folder of real measurements, which are not part of the repository."""
    folder = Path(os.environ.get("PMMKIT_DATA", ROOT.parent / "shared" / "data"))
    if not folder.is_dir():
        pytest.skip("the real measurements (PMMKIT_DATA) are not on this machine")
    return folder


@pytest.fixture(scope="session")
def datasets() -> Path:
    """The datasets that come with pmmkit."""
    return ROOT / "datasets"


@pytest.fixture(scope="session")
def hmri(
    shared_data: Path, datasets: Path, tmp_path_factory: pytest.TempPathFactory
) -> tuple[Path, dict[str, Any]]:
    """What a typed reduction of HMRI's tests writes, pictures left out, and what it says."""
    from pmmkit.cli import main

    folder = tmp_path_factory.mktemp("hmri") / "kvlcc2_hmri-reduced"
    words = ["reduce", datasets / "kvlcc2_hmri", "--data", shared_data, "--structure", "mmg"]
    with redirect_stdout(io.StringIO()) as told:
        assert main([*map(str, words), "--out", str(folder), "--json"]) == 0
    return folder, json.loads(told.getvalue())
