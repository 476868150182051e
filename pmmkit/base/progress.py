"""Progress on standard error: a bar on a terminal, a few plain lines elsewhere."""

from __future__ import annotations

import math
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Final, TextIO

QUIET: Final = 30.0
"""Seconds between lines where there is no terminal."""

Progress = Callable[[int, int, str], None]
"""Called with how many are done, how many there are, and what is being done."""


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
        To be called with the count done, the total, and the name of the step.

    Examples
    --------
    >>> with shown(sys.stdout) as progress:
    ...     for run in range(1, 101):
    ...         progress(run, 100, f"reading run {run}")
      1 of 100: reading run 1
     50 of 100: reading run 50
    100 of 100: reading run 100
    """
    target = stream or sys.stderr
    if target.isatty():
        yield from _bar(target)
    else:
        yield _lines(target)


def _lines(stream: TextIO) -> Progress:
    """The first, the middle and the last, and one in half a minute: a log stays short."""
    told: tuple[float, int] = (-math.inf, -1)

    def tell(done: int, total: int, what: str) -> None:
        nonlocal told
        now = time.monotonic()
        if (done in (total // 2, total) and done != told[1]) or now - told[0] > QUIET:
            told = now, done
            print(f"{done:>{len(str(total))}} of {total}: {what}", file=stream, flush=True)

    return tell


def _bar(stream: TextIO) -> Iterator[Progress]:
    from rich.console import Console
    from rich.progress import BarColumn, MofNCompleteColumn, TextColumn, TimeElapsedColumn
    from rich.progress import Progress as Bar

    columns = (
        BarColumn(),
        MofNCompleteColumn(),
        TimeElapsedColumn(),
        TextColumn("{task.description}", markup=False),
    )
    with Bar(*columns, console=Console(file=stream)) as bar:
        task = bar.add_task("", total=None)

        def tell(done: int, total: int, what: str) -> None:
            bar.update(task, completed=done, total=total, description=what)

        yield tell
