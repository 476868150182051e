"""What is still to be done, what is under way, and what becomes of what is lost."""

from __future__ import annotations

import math
import os
import sys
import warnings
from collections import Counter, deque
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import (
    FIRST_COMPLETED,
    BrokenExecutor,
    CancelledError,
    Executor,
    Future,
    wait,
)
from contextlib import ExitStack
from dataclasses import dataclass, field
from typing import Any, Final, TypeVar

from pmmkit.base.errors import DataError, Remedy, Way
from pmmkit.base.executors import worker
from pmmkit.base.executors.places import processes
from pmmkit.base.executors.worker import packed
from pmmkit.base.version import __version__

PIECE: Final = 0.3
"""Seconds of work that are sent at a time, at least where there is so much: sending takes 1 ms."""
AHEAD: Final = 2
"""Pieces for each worker that are under way, so that none waits for the next one."""
WIDE: Final = 256
"""Pieces under way where nothing says how many workers there are."""
MOST: Final = 3
"""Times that the process that does a thing may end before the thing is named."""
STRIKES: Final = 3
"""Things that this process can do and no worker could, from which the workers are of no use."""


@dataclass(kw_only=True, eq=False)
class Board:
    """The one thing that changes while work is under way.

    `names`: what each thing is called. `needs`: memory that each takes. `room`: memory that
    those under way may take together. `width`: pieces that may be under way. `waiting`: places
    of what is to be sent. `losses`: how often the process that did a thing ended. `broken`:
    whether the executor has ended. `seconds, done`: what workers have taken for how many
    things. `strikes, trouble`: how many things only this process could do, and what the last
    worker said.
    """

    names: Sequence[str]
    needs: Sequence[float]
    room: float
    width: int = 1
    waiting: deque[int] = field(init=False)
    flying: dict[Future[bytes], tuple[int, ...]] = field(default_factory=dict)
    losses: Counter[int] = field(default_factory=Counter)
    broken: bool = False
    seconds: float = 0.0
    done: int = 0
    strikes: int = 0
    trouble: str = ""

    def __post_init__(self) -> None:
        self.waiting = deque(range(len(self.names)))

    def send(self, crew: Executor, work: bytes, things: Sequence[object]) -> list[int]:
        """Send what there is room for; gives what cannot be sent."""
        left: list[int] = []
        while chosen := self._next():
            content = worker.packed([things[place] for place in chosen])
            if content is None:
                left += chosen
                continue
            attempt = max(self.losses[place] for place in chosen)
            try:
                with warnings.catch_warnings():  # dask's, on pieces above 10 MB
                    warnings.filterwarnings("ignore", message="Sending large graph")
                    future = crew.submit(worker.done, work, content, __version__, attempt)
            except (RuntimeError, OSError):  # it has ended
                self.broken = True
                self._lose(chosen)
                break
            self.flying[future] = chosen
        return left

    def _next(self) -> tuple[int, ...]:
        """What is sent next; nothing where there is no room."""
        suspect = MOST - 1
        under_way = [place for own in self.flying.values() for place in own]
        if not self.waiting or len(self.flying) >= self.width or self.broken:
            return ()
        risks = [self.losses[place] for place in (*under_way, self.waiting[0])]
        if under_way and max(risks) >= suspect:
            return ()
        left = math.ceil(len(self.waiting) / (2 * self.width))
        size = min(left, int(PIECE * self.done / max(self.seconds, 1e-6)))
        taken = sum(max(self.needs[place] for place in own) for own in self.flying.values())
        chosen: list[int] = []
        while self.waiting and len(chosen) < max(size, 1):
            place = self.waiting[0]
            need = max(self.needs[x] for x in (*chosen, place))
            if (chosen or self.flying) and (taken + need > self.room or self.losses[place]):
                break
            chosen.append(self.waiting.popleft())
            if self.losses[place]:
                break
        return tuple(chosen)

    def landed(self) -> tuple[list[tuple[int, Any]], list[int]]:
        """Results that have come, and what workers could not do."""
        found: list[tuple[int, Any]] = []
        failed: list[int] = []
        for future in wait(self.flying, timeout=0.5, return_when=FIRST_COMPLETED).done:
            chosen = self.flying.pop(future)
            try:
                seconds, answers = worker.unpacked(future.result())
            except (BrokenExecutor, CancelledError):
                self.broken = True
                self._lose(chosen)
                continue
            except Exception as error:  # of the executor, or of what it does around the work
                if _killed(error):
                    self._lose(chosen, MOST if len(chosen) == 1 else MOST - 1)
                    continue
                failed += chosen
                self.trouble = f"{type(error).__name__}: {error}"
                continue
            self.seconds += seconds
            for place, (well, answer) in zip(chosen, answers, strict=True):
                if well:
                    self.done += 1
                    found.append((place, answer))
                else:
                    failed.append(place)
                    self.trouble = answer
        return found, failed

    def check(self, strike: bool) -> None:
        """Whether workers are of any use, after this process could do what they could not."""
        self.strikes += strike
        if self.strikes >= STRIKES and not self.done:
            raise DataError(
                f"No worker could do what this process can: {self.trouble}",
                remedy=Remedy(
                    "Each worker needs this version of pmmkit and has to see the files under "
                    "the same path: a folder that all machines share, given as an absolute "
                    "path. Without {} this machine does it alone.",
                    (Way("executor=", "--scheduler"),),
                ),
            )

    def _lose(self, chosen: Sequence[int], times: int = 1) -> None:
        """What a process that ended did is done again, from the second time on alone."""
        self.losses.update(dict.fromkeys(chosen, times))
        self.waiting.extendleft(reversed(chosen))
        dead = [self.names[place] for place in chosen if self.losses[place] >= MOST]
        if dead:
            raise DataError(
                f"The process that did {', '.join(dead)} ended {MOST} times over it.",
                remedy=Remedy(
                    "It may want more memory than there is, or its file breaks a library. {} "
                    "does it in this process, where the fault shows.",
                    (Way("executor=1", "--workers 1"),),
                ),
            )

    def ground(self) -> None:
        """Call back all that is under way."""
        for future, chosen in self.flying.items():
            future.cancel()
            self._lose(chosen)
        self.flying.clear()
        self.broken = False


def _killed(error: Exception) -> bool:
    """Whether dask has given a thing up over which its workers ended."""
    dask = sys.modules.get("distributed")
    return dask is not None and isinstance(error, dask.KilledWorker)


def width_of(crew: Executor) -> int:
    """How many pieces an executor is given at a time."""
    count = getattr(crew, "_max_workers", None)
    return AHEAD * count if isinstance(count, int) else WIDE


# Doing a thing to each of many, wherever that is.


T = TypeVar("T")
R = TypeVar("R")


def each(
    work: Callable[[T], R],
    things: Sequence[T],
    executor: Executor | int | None,
    *,
    names: Sequence[str],
    here: Callable[[T], R] | None = None,
    needs: Sequence[float] | None = None,
    room: float = math.inf,
) -> Iterator[tuple[int, R]]:
    """What comes of each thing, with its place, in the order in which they are done.

    A thing whose process ends is done again by another one, in the end alone. What a worker cannot
    do, as for want of a file that it does not see, is done in this process.

    Parameters
    ----------
    work : callable
        What is done with a thing. It need not be a function of a module.
    things : sequence
        To be done.
    executor : Executor or int, optional
        As `opened` gives it; 1 and None are this process.
    names : sequence of str
        What each is called, such as ``run SD_1``.
    here : callable, optional
        Instead of `work` in this process. It may give an error as its result.
    needs : sequence of float, optional
        Memory that each takes.
    room : float
        Memory that those under way may take together; one that needs more goes alone.

    Yields
    ------
    (int, result)

    Raises
    ------
    DataError
        If processes end again and again over a thing, or no worker can do anything.

    Examples
    --------
    >>> dict(each(len, ["rudder", "hull"], None, names=["a", "b"]))
    {0: 6, 1: 4}
    """
    at_home = here or work
    sent = None if executor is None or executor == 1 or not things else packed(work)
    if sent is None:
        yield from ((place, at_home(thing)) for place, thing in enumerate(things))
        return
    board = Board(names=names, needs=needs or [0.0] * len(things), room=room)
    count = executor if isinstance(executor, int) else os.cpu_count() or 1
    crew = None if isinstance(executor, int) else executor
    with ExitStack() as stack:
        try:
            while board.waiting or board.flying:
                crew = crew or stack.enter_context(processes(min(count, len(board.waiting))))
                if crew is None:
                    yield from ((place, at_home(things[place])) for place in board.waiting)
                    return
                board.width = width_of(crew)
                alone = board.send(crew, sent, things)
                found, failed = board.landed()
                yield from found
                for place in (*alone, *failed):
                    result = at_home(things[place])
                    board.check(place in failed and not isinstance(result, Exception))
                    yield place, result
                if board.broken:
                    board.ground()
                    stack.close()
                    crew = None
        finally:
            for future in board.flying:
                future.cancel()
