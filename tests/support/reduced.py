"""Reductions that several files of tests look at: each is made once a run, for all workers."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import TypeVar

import cloudpickle
from kept import Kept

import pmmkit as pk
from pmmkit.reduction import Reduction, reduce_campaign

T = TypeVar("T")


def once(kept: Kept, name: str, make: Callable[[], T]) -> T:
    """What `make` gives; a reduction holds loaders and read-only mappings, which pickle refuses."""

    def write(folder: Path) -> None:
        (folder / "made").write_bytes(cloudpickle.dumps(make()))

    found: T = cloudpickle.loads((kept.folder(name, write) / "made").read_bytes())
    return found


def s175(kept: Kept, datasets: Path) -> Reduction:
    """The S175 programme as it comes with pmmkit."""
    return once(kept, "s175", lambda: reduce_campaign(pk.open_campaign(datasets / "s175")))


def hmri(kept: Kept, datasets: Path, shared_data: Path) -> Reduction:
    """HMRI's tests of the KVLCC2 with the terms of the MMG model, by all methods."""
    opened = pk.open_campaign(datasets / "kvlcc2_hmri", data=shared_data)
    return once(
        kept,
        "hmri-mmg",
        lambda: reduce_campaign(opened, structure="mmg", method="all", check=False),
    )


def hmri_usual(kept: Kept, datasets: Path, shared_data: Path) -> Reduction:
    """HMRI's tests as `reduce` takes them where nothing is said."""
    opened = pk.open_campaign(datasets / "kvlcc2_hmri", data=shared_data)
    return once(kept, "hmri-usual", lambda: reduce_campaign(opened))
