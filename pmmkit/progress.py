"""Progress on standard error: a bar on a terminal, a few plain lines elsewhere."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import TextIO

Progress = Callable[[str, int, int], None]
"""Called with what is being done, how many are done and how many there are."""


def silent(what: str, done: int, total: int) -> None:
    """Progress that nobody sees.

    Parameters
    ----------
    what : str
        What is being done.
    done, total : int
        How many are done, how many there are.
    """


@contextmanager
def shown(stream: TextIO | None = None) -> Iterator[Progress]:
    """Show progress while a block runs.

    Parameters
    ----------
    stream : text stream, optional
        Where to; standard error by default.

    Yields
    ------
    Progress
        To be called with the name of a step, the count done and the total.

    Examples
    --------
    >>> with shown(sys.stdout) as progress:
    ...     for run in range(1, 5):
    ...         progress("runs", run, 4)
    runs: 1 of 4
    runs: 4 of 4
    """
    target = stream or sys.stderr
    if target.isatty():
        yield from _bar(target)
    else:
        yield _lines(target)


def _lines(stream: TextIO) -> Progress:
    """The first and the last of each step, so that a log stays short."""

    def tell(what: str, done: int, total: int) -> None:
        if done in (1, total):
            print(f"{what}: {done} of {total}", file=stream, flush=True)

    return tell


def _bar(stream: TextIO) -> Iterator[Progress]:
    from rich.console import Console
    from rich.progress import BarColumn, MofNCompleteColumn, TextColumn, TimeElapsedColumn
    from rich.progress import Progress as Bar

    columns = (
        TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn(), TimeElapsedColumn(),
    )  # fmt: skip
    with Bar(*columns, console=Console(file=stream)) as bar:
        tasks = {}

        def tell(what: str, done: int, total: int) -> None:
            if what not in tasks:
                tasks[what] = bar.add_task(what, total=total)
            bar.update(tasks[what], completed=done, total=total)

        yield tell
