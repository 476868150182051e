"""Doing a thing to each of many, wherever that is."""

from __future__ import annotations

import math
import os
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import Executor
from contextlib import ExitStack
from typing import TypeVar

from pmmkit.executors.board import Board, width_of
from pmmkit.executors.places import processes
from pmmkit.executors.worker import packed

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
