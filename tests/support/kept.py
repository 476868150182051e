"""What takes long to make and several tests look at: made once a run, for all workers."""

from __future__ import annotations

import pickle
import shutil
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import TypeVar

T = TypeVar("T")


@dataclass(frozen=True)
class Kept:
    """A folder that the workers of one run of the tests share.

    Parameters
    ----------
    root : Path
        Where it is; it goes with the temporary folders of pytest.
    """

    root: Path

    def folder(self, name: str, make: Callable[[Path], object]) -> Path:
        """A folder that `make` fills once: tests read it, and copy it where they write."""
        path = self.root / name
        making = path.with_name(f"{path.name}.making")
        self.root.mkdir(exist_ok=True)
        while not path.exists():
            try:
                making.mkdir()
            except FileExistsError:
                time.sleep(0.05)  # another worker makes it
                continue
            try:
                make(making)
                making.rename(path)
            except BaseException:
                shutil.rmtree(making, ignore_errors=True)  # the next who asks tries anew
                raise
        return path

    def value(self, name: str, make: Callable[[], T]) -> T:
        """A value that `make` gives, made once and read by everyone else."""

        def write(folder: Path) -> None:
            (folder / "value.pickle").write_bytes(pickle.dumps(make()))

        value: T = pickle.loads((self.folder(name, write) / "value.pickle").read_bytes())
        return value
