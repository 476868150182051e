"""Jobs done side by side, and their answers beside those that are kept."""

from __future__ import annotations

import difflib
import fnmatch
import json
import multiprocessing
import time
from collections.abc import Iterator, Mapping, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from scripts.golden.differences import Difference, differences
from scripts.golden.job import Job, measurements
from scripts.golden.kept import FOLDER, answer_of
from scripts.golden.values import plain


@dataclass(frozen=True)
class Judged:
    """A job that was done.

    Parameters
    ----------
    name : str
        Of the job.
    answer : object
        What came, as plain values.
    moved : tuple of Difference
        Against what is kept.
    new : bool
        Whether nothing was kept.
    seconds : float
        Of the clock.
    skipped : str
        Why it was not done.
    """

    name: str
    answer: Any = None
    moved: tuple[Difference, ...] = ()
    new: bool = False
    seconds: float = 0.0
    skipped: str = ""


def judge(job: Job, folder: Path = FOLDER) -> Judged:
    """Do a job and see what moved."""
    if job.measured and measurements() is None:
        return Judged(job.name, skipped="the measurements (PMMKIT_DATA) are not on this machine")
    began = time.perf_counter()
    # Through text, so that an answer that was kept and a fresh one are of the same kind.
    try:
        answer = json.loads(json.dumps(plain(job.make()), sort_keys=True))
    except Exception as error:  # the other jobs go on
        fell = Difference("the job", "an answer", f"{type(error).__name__}: {error}")
        return Judged(job.name, moved=(fell,), seconds=time.perf_counter() - began)
    kept = answer_of(job.name, folder)
    moved = () if kept is None else tuple(differences(kept, answer, job.tolerance))
    return Judged(job.name, answer, moved, kept is None, time.perf_counter() - began)


def refused_names(names: Sequence[str], every: Mapping[str, object]) -> str:
    """What to say of names that are no job's; nothing where all are."""
    for name in names:
        if not fnmatch.filter(every, name):
            near = difflib.get_close_matches(name, every, n=1)
            hint = f" Did you mean {near[0]!r}?" if near else ""
            return f"There is no job {name!r}.{hint} `list` names them."
    return ""


def judged(every: Mapping[str, Any], names: Sequence[str], workers: int) -> Iterator[Judged]:
    """Jobs as they are done, in processes of their own."""
    asked = [
        name for name in every if not names or any(fnmatch.fnmatch(name, own) for own in names)
    ]
    if workers < 2 or len(asked) < 2:
        yield from (judge(every[name]) for name in asked)
        return
    spawn = multiprocessing.get_context("spawn")
    with ProcessPoolExecutor(workers, mp_context=spawn) as pool:
        sent = [pool.submit(judge, every[name]) for name in asked]
        for done in as_completed(sent):
            yield done.result()
