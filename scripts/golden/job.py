"""A job of the golden set, and what its workers see of the machine: nothing."""

from __future__ import annotations

import datetime as dt
import os
import re
import tempfile
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

ROOT = Path(__file__).parents[2]
SPEEDS = {
    "s175": 8.0,
    "s175-3dof": 8.0,
    "kvlcc2": 7.97,
    "kvlcc2-l7": 1.179,
    "kcs": 12.35,
    "mariner": 7.7175,
    "esso190k": 8.23,
    "esso-osaka-3m": 0.4,
    "tanker-320": 7.97,
    "bulk-carrier-170": 7.25,
    "patrol-vessel-44": 14.92,
}
"""Approach speeds [m/s] of the ships of the library."""


@dataclass(frozen=True)
class Job:
    """What is asked of the package.

    Parameters
    ----------
    name : str
        Of the job and of the file that keeps its answer.
    make : callable
        Gives the answer: mappings, lists, numbers and texts.
    tolerance : float
        By which a number may differ, over its size: 1e-9 where nothing is iterated.
    measured : bool
        Whether it needs measurements that are not part of the repository.
    """

    name: str
    make: Callable[[], Any]
    tolerance: float = 1e-9
    measured: bool = False


ITERATED = 3e-5
"""Tolerance of a job in which a search, a filter or an adaptive step ends at one of its own: two
processors differed by 1e-5 in an odds and in a size found by a search."""
AMPLIFIED = 1e-3
"""The same where rounding grows: the uncertainty of an unstable ship's motion, the phase of a wave
at the end of a turn. They differed by 2e-4 of them."""


TOOK = re.compile(
    r"(?m)^(  (?:ekf|ukf|trajectory|regression|sindy|posterior) .*?) +[0-9.]+ s$|"
    r"^(  model .*?) +time$|^(.* from the regression .*), [0-9.]+ s\.$"
)
"""Lines that end with how long a method took."""


def measurements() -> Path | None:
    """The folder of measurements that are not part of the repository; None without one."""
    folder = Path(os.environ.get("PMMKIT_DATA", ROOT.parent / "shared" / "data"))
    return folder if folder.is_dir() else None


@contextmanager
def empty_folder() -> Iterator[Path]:
    """A new folder, which is the current one meanwhile."""
    before = Path.cwd()
    with tempfile.TemporaryDirectory() as place:
        folder = Path(place).resolve()
        os.chdir(folder)
        try:
            yield folder
        finally:
            os.chdir(before)


def masked(text: str, folder: Path | None = None) -> str:
    """A text without what differs from one day, version, machine or folder to another.

    Lines of progress, which come by the clock, are left out.
    """
    from pmmkit import __version__

    if folder is not None:
        text = text.replace(str(folder), "FOLDER")
    data = measurements()
    if data is not None:
        text = text.replace(str(data), "DATA")
    text = text.replace(str(ROOT), "ROOT")
    text = re.sub(rf"(?<![\d.]){re.escape(__version__)}(?![\d])", "VERSION", text)
    text = re.sub(rf"{re.escape(tempfile.gettempdir())}/[\w.-]+", "TEMPORARY", text)
    today = dt.date.today()
    for day in (today, today - dt.timedelta(days=1)):
        text = re.sub(rf"{day.isoformat()}(?:[T ][0-9:.+Z]*)?", "DAY", text)
        text = text.replace(f"{day.day} {day:%B %Y}", "DAY")
    text = re.sub(r"(?m)^\s*\d+ of \d+: .*\n?", "", text)
    text = TOOK.sub(lambda x: f"{x[1] or x[2] or x[3]} SECONDS", text)
    return re.sub(r"\b[0-9.]+ m?s (?=of the processor|passed)", "SECONDS ", text)
