"""How much memory the reading of runs takes, and how many processes there is memory for.

Executors know nothing of memory, and records of gigabytes read side by side would take all of it.
"""

from __future__ import annotations

import os
from pathlib import Path
from typing import Final

from pmmkit.campaigns.run import Run
from pmmkit.campaigns.samples.loading import data_files, requests_of
from pmmkit.errors import DataError

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

    Parameters
    ----------
    run : Run
        The run; one that does not come from files of its own takes nothing.
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
    requests = requests_of(run)
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
        return list(data_files(run).values())
    except DataError:
        return []


def shared_out(memory: float, most: int | None) -> tuple[int, float]:
    """How many processes there is memory for, and what is left for the runs that they read [MB].

    Parameters
    ----------
    memory : float
        What all may take together, the asking process too [MB].
    most : int or None
        As many as asked for; None for the number of processors.

    Examples
    --------
    >>> shared_out(1000.0, 4), shared_out(1000.0, 64)
    ((4, 340.0), (5, 215.0))
    """
    left = memory - OWN_MB
    count = max(1, min(most or os.cpu_count() or 1, int(left / (1.25 * PROCESS_MB))))
    return count, max(left - count * PROCESS_MB, 0.0)
