"""Reading all runs of a campaign, once each: several at a time, and on from where one stopped."""

from __future__ import annotations

import importlib
import math
import os
import time
from collections.abc import Callable, Generator, Sequence
from concurrent.futures import Executor, ThreadPoolExecutor
from contextlib import closing
from dataclasses import dataclass, field, replace
from functools import partial
from pathlib import Path
from typing import Final

from pmmkit.base import CampaignError, DataError, Workers, each, opened
from pmmkit.campaigns import Run
from pmmkit.numerics import one_thread
from pmmkit.presentation import counted
from pmmkit.reduction.reading.resume import StoredResults
from pmmkit.reduction.reading.run import Reading, ReductionSettings, read_run

# How much memory the reading of runs takes, and how many processes there is memory for.
#
# Executors know nothing of memory, and records of gigabytes read side by side would take all of
# it.


PROCESS_MB: Final = 125.0
"""Memory of a process that has read a small run."""
OWN_MB: Final = 160.0
"""Memory of the asking process, and of the results of some thousand runs in it."""
SAMPLE_BYTES: Final = 480.0
"""Memory for each sample of a history while it is reduced."""
WHOLE: Final = 8.0
"""Memory over file size where a file is read whole."""
PIECES_MB: Final = 40.0
"""Memory for the pieces in which a large text file is read."""
HEAD: Final = 1 << 16
MB: Final = 1e6


def memory_of(run: Run) -> float:
    """About how much memory the reading of a run takes [MB], from the sizes of its files.

    Files of the same name follow one another in time, others stand side by side.
    """
    samples: dict[str, float] = {}
    held = 0.0
    for path in _files(run):
        try:
            size = path.stat().st_size
            with path.open("rb") as stream:
                head = stream.read(HEAD)
        except OSError:
            continue
        whole = b"\0" in head or not head
        held = max(held, WHOLE * size if whole else min(WHOLE * size, PIECES_MB * MB))
        lines = 0.0 if whole else size * (head.count(b"\n") + 1) / len(head)
        samples[path.name] = samples.get(path.name, 0.0) + lines
    return (held + SAMPLE_BYTES * max(samples.values(), default=0.0)) / MB


def size_of(run: Run) -> int:
    """Bytes of the files of a run; of those behind a URL what their store says."""
    requests = run.requests
    if any(request.origin is not None for request in requests):
        return sum(item.origin.size or 0 for item in requests if item.origin is not None)
    total = 0
    for path in _files(run):
        try:
            total += path.stat().st_size
        except OSError:
            continue
    return total


def _files(run: Run) -> list[Path]:
    try:
        return list(run.files().values())
    except DataError:
        return []


def shared_out(memory: float, most: int | None) -> tuple[int, float]:
    """How many processes there is memory for, and what is left for the runs that they read [MB].

    memory [MB].

    Examples
    --------
    >>> shared_out(1000.0, 4), shared_out(1000.0, 64)
    ((4, 340.0), (5, 215.0))
    """
    left = memory - OWN_MB
    count = max(1, min(most or os.cpu_count() or 1, int(left / (1.25 * PROCESS_MB))))
    return count, max(left - count * PROCESS_MB, 0.0)


PATIENCE: Final = 2.0
"""Seconds of reading after which results are kept and processes started."""
PAYS: Final = 3.0
"""Seconds of further reading from which processes are worth their start."""
SMALL: Final = 50_000
"""Bytes of a file that take as long as the rest of a run's reduction."""

Progress = Callable[[int, int, str], None]
Result = Reading | DataError


@dataclass(frozen=True, kw_only=True)
class Means:
    """What may be used for the reading.

    `executor`: who reads: processes of this machine where a number, or nothing, is given.
    `memory`: memory of these [MB]; that of a given executor is its own affair. `kept`: folder
    for the results of runs.
    """

    executor: Workers = None
    memory: float = 1000.0
    kept: Path | None = None


def read_all(settings: ReductionSettings, tell: Progress, means: Means) -> list[Reading]:
    """All runs of a campaign, in their order."""
    runs = settings.campaign.runs
    if not runs:
        raise CampaignError(f"Campaign {settings.campaign.title!r} has no run to reduce.")
    kept = None if means.kept is None else StoredResults(folder=means.kept, settings=settings)
    found = _read_before(runs, kept, tell)
    left = [place for place in range(len(runs)) if place not in found]
    if not isinstance(means.executor, (str, Executor)):
        _fetch([runs[place] for place in left], tell)
    importlib.import_module("xarray")  # takes a second or two, once, and says nothing of the pace
    pace = _Pace(weights=[size_of(runs[place]) + SMALL for place in left])
    wrong: dict[int, DataError] = {}
    with (
        one_thread(),
        closing(_each([runs[place] for place in left], settings, means, pace)) as results,
    ):
        for done, (number, result) in enumerate(results, start=1):
            place = left[number]
            run = runs[place]
            if isinstance(result, DataError):
                wrong[place] = result
            else:
                found[place] = result
                if kept is not None and pace.seconds > PATIENCE:
                    kept.save(run, result)
            tell(len(runs) - len(left) + done, len(runs), f"reading {run.id}{pace(done)}")
    problems = [
        replace(item, run=item.run or runs[place].id)
        for place, error in sorted(wrong.items())
        for item in error.problems
    ]
    if problems:
        raise CampaignError(
            problems, title=f"Campaign {settings.campaign.title!r} cannot be reduced"
        )
    return [found[place] for place in range(len(runs))]


def _fetch(runs: Sequence[Run], tell: Progress) -> None:
    """Bring files behind URLs to this machine, side by side; other machines fetch their own."""
    afar = [item for run in runs for item in run.requests if item.origin is not None]
    if afar:
        tell(0, len(runs), f"fetching {counted(len(afar), 'file')}")
        Run.fetch(runs)


def _read_before(
    runs: Sequence[Run], kept: StoredResults | None, tell: Progress
) -> dict[int, Reading]:
    """What an interrupted call has read, by the place of the run."""
    if kept is None or not kept.folder.is_dir():
        return {}
    with ThreadPoolExecutor() as pool:
        loaded = dict(enumerate(pool.map(kept.load, runs)))
    found = {place: reading for place, reading in loaded.items() if reading is not None}
    if found:
        what = f"resumed: {len(found)} of {len(runs)} runs were read before"
        tell(len(found), len(runs), what)
    return found


@dataclass(frozen=True, kw_only=True)
class _Pace:
    """How fast the reading goes and how long it will still take.

    `weights`: what each run counts, in their order: about the bytes of its files.
    """

    weights: Sequence[int]
    started: float = field(default_factory=time.monotonic)

    @property
    def seconds(self) -> float:
        """Since the start."""
        return time.monotonic() - self.started

    def remaining(self, done: int) -> float:
        """Seconds that the rest will take if it goes on as it went."""
        return self.seconds * sum(self.weights[done:]) / max(sum(self.weights[:done]), 1)

    def __call__(self, done: int) -> str:
        if self.seconds < PATIENCE or done == len(self.weights):
            return ""
        minutes, seconds = divmod(round(self.remaining(done)), 60)
        return f" ({done / self.seconds:.1f} runs/s, {minutes}:{seconds:02d} left)"


def _each(
    runs: Sequence[Run], settings: ReductionSettings, means: Means, pace: _Pace
) -> Generator[tuple[int, Result], None, None]:
    """The result of each run with its number, in the order in which they are read.

    Processes of this machine are started when that pays; an executor that is given reads all.
    """
    done, here = 0, partial(_result, settings=settings)
    with opened(means.executor) as executor:
        room = math.inf
        if executor is None or isinstance(executor, int):
            for done, run in enumerate(runs, start=1):
                yield done - 1, here(run)
                if executor != 1 and pace.seconds > PATIENCE and pace.remaining(done) > PAYS:
                    break
            executor, room = shared_out(means.memory, executor)
        rest = runs[done:]
        lean = replace(settings, campaign=settings.campaign.with_(runs=(), excluded=()))
        for number, result in each(
            partial(read_run, settings=lean),
            rest,
            executor,
            names=[f"run {run.id}" for run in rest],
            here=here,
            needs=[memory_of(run) for run in rest] if math.isfinite(room) else None,
            room=room,
        ):
            yield done + number, _with_own_loader(result, rest[number])


def _result(run: Run, settings: ReductionSettings) -> Result:
    try:
        return read_run(run, settings)
    except DataError as error:
        return error


def _with_own_loader(result: Result, run: Run) -> Result:
    """The result with the run of this process instead of the copy that came back."""
    if isinstance(result, DataError):
        return result
    own = result.rows.result
    kept = run.with_(settings=own.run.settings)
    return replace(
        result,
        rows=replace(result.rows, result=replace(own, run=kept)),
        summary=replace(result.summary, run=run),
    )
