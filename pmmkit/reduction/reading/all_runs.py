"""Reading all runs of a campaign, once each: several at a time, and on from where one stopped."""

from __future__ import annotations

import importlib
import time
from collections.abc import Callable, Generator, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import closing
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Final

from threadpoolctl import threadpool_limits

from pmmkit.campaigns.run import Run
from pmmkit.errors import CampaignError, DataError, Problem
from pmmkit.reduction.reading.pool import PROCESS_MB, how_many, size_of, worker_pool
from pmmkit.reduction.reading.resume import Kept
from pmmkit.reduction.reading.run import Reading, ReductionSettings, read_run

PATIENCE: Final = 2.0
"""Seconds of reading after which results are kept and processes started."""
PAYS: Final = 3.0
"""Seconds of further reading from which processes are worth their start."""
OWN_MB: Final = 160.0
"""Memory of this process, and of the results of some thousand runs in it."""
SMALL: Final = 50_000
"""Bytes of a file that take as long as the rest of a run's reduction."""

Progress = Callable[[int, int, str], None]
Result = Reading | DataError


@dataclass(frozen=True, kw_only=True)
class Means:
    """What may be used for the reading.

    Parameters
    ----------
    jobs : int or None
        Processes; None for the number of processors.
    memory : float
        Memory of all of them [MB].
    kept : Path or None
        Folder for the results of runs.
    """

    jobs: int | None = None
    memory: float = 1000.0
    kept: Path | None = None


def read_all(settings: ReductionSettings, tell: Progress, means: Means) -> list[Reading]:
    """All runs of a campaign, in their order.

    Parameters
    ----------
    settings : ReductionSettings
        The campaign and how its runs are read.
    tell : callable
        Called with (runs done, runs in all, what is done).
    means : Means
        Processes, memory and the folder of kept results.

    Raises
    ------
    CampaignError
        If there are no runs, or some cannot be read: with all problems of all of them.
    """
    runs = settings.campaign.runs
    if not runs:
        raise CampaignError(f"Campaign {settings.campaign.title!r} has no run to reduce.")
    kept = None if means.kept is None else Kept(folder=means.kept, settings=settings)
    found = _read_before(runs, kept, tell)
    left = [place for place in range(len(runs)) if place not in found]
    importlib.import_module("xarray")  # takes a second or two, once, and says nothing of the pace
    pace = _Pace(weights=[size_of(runs[place]) + SMALL for place in left])
    problems: list[Problem] = []
    with closing(_each([runs[place] for place in left], settings, means, kept, pace)) as results:
        for done, (place, result) in enumerate(zip(left, results, strict=True), start=1):
            tell(len(runs) - len(left) + done, len(runs), f"reading {runs[place].id}{pace(done)}")
            if isinstance(result, DataError):
                own = runs[place].id
                problems += [replace(item, run=item.run or own) for item in result.problems]
            else:
                found[place] = result
    if problems:
        raise CampaignError(
            problems, title=f"Campaign {settings.campaign.title!r} cannot be reduced"
        )
    return [found[place] for place in range(len(runs))]


def _read_before(runs: Sequence[Run], kept: Kept | None, tell: Progress) -> dict[int, Reading]:
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

    Parameters
    ----------
    weights : sequence of int
        What each run counts, in their order: about the bytes of its files.
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
    runs: Sequence[Run], settings: ReductionSettings, means: Means, kept: Kept | None, pace: _Pace
) -> Generator[Result, None, None]:
    """The result of each run: the first seconds in this process, the rest by several."""
    done = 0
    with threadpool_limits(1):
        for done, run in enumerate(runs, start=1):
            yield _result(run, lambda run: read_run(run, settings), kept, pace)
            if means.jobs != 1 and pace.seconds > PATIENCE and pace.remaining(done) > PAYS:
                break
    if done < len(runs):
        yield from _by_workers(runs[done:], settings, means, kept, pace)


def _by_workers(
    runs: Sequence[Run], settings: ReductionSettings, means: Means, kept: Kept | None, pace: _Pace
) -> Generator[Result, None, None]:
    count = min(how_many(means.jobs, means.memory, OWN_MB), len(runs))
    room = max(means.memory - OWN_MB - count * PROCESS_MB, 0.0)
    with threadpool_limits(1), worker_pool(settings, runs[0], count, room) as found:
        if found is None:
            yield from (
                _result(run, lambda run: read_run(run, settings), kept, pace) for run in runs
            )
            return
        pool = ThreadPoolExecutor(found.size)
        try:
            yield from pool.map(lambda run: _result(run, found.read, kept, pace), runs)
        finally:
            pool.shutdown(wait=False, cancel_futures=True)


def _result(run: Run, read: Callable[[Run], Reading], kept: Kept | None, pace: _Pace) -> Result:
    """What a run gives, kept on disk if the reading takes long."""
    try:
        reading = read(run)
    except DataError as error:
        return error
    if kept is not None and pace.seconds > PATIENCE:
        kept.save(run, reading)
    return reading
