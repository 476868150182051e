"""Processes that read runs side by side, within a given memory.

Reducing a run is many small steps in Python, which threads do not share. The processes are started
as plain programs: unlike those of `multiprocessing` they do not run the user's script again, and
they end with the process that asks them, however it ends.
"""

from __future__ import annotations

import io
import json
import os
import queue
import subprocess
import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, Final

from pmmkit.campaigns.run import Run
from pmmkit.campaigns.samples.loading import data_files
from pmmkit.errors import DataError
from pmmkit.reduction.reading.run import Reading, ReductionSettings, read_run
from pmmkit.reduction.reading.worker import receive, send

PROCESS_MB: Final = 125.0
"""Memory of a process that has read a small run."""
SAMPLE_BYTES: Final = 480.0
"""Memory for each sample of a history while it is reduced."""
WHOLE: Final = 8.0
"""Memory over file size where a file is read whole."""
PIECES_MB: Final = 40.0
"""Memory for the pieces in which a large text file is read."""
HEAD: Final = 1 << 16
MB: Final = 1e6
_START: Final = (
    "import sys, json; sys.path[:] = json.loads(sys.argv[1]); "
    "from pmmkit.reduction.reading.worker import serve; serve()"
)
_SETTINGS: Final = {
    "OMP_NUM_THREADS": "1",
    "OPENBLAS_NUM_THREADS": "1",
    "MKL_NUM_THREADS": "1",
    "MALLOC_MMAP_THRESHOLD_": "4000000",
}
"""One thread each; large arrays go back to the system (glibc keeps them otherwise)."""


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
    """Bytes of the files of a run."""
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


@dataclass(frozen=True)
class Room:
    """Memory that may be taken, in the order of asking.

    Parameters
    ----------
    size : float
        How much there is [MB]. What needs more gets all of it, alone.
    """

    size: float
    _taken: list[float] = field(default_factory=list)
    _turn: threading.Lock = field(default_factory=threading.Lock)
    _changed: threading.Condition = field(default_factory=threading.Condition)

    @contextmanager
    def taken(self, need: float) -> Iterator[None]:
        """Wait until there is room, and hold it."""
        need = min(need, self.size)
        with self._turn, self._changed:
            self._changed.wait_for(lambda: sum(self._taken) + need <= self.size or not self._taken)
            self._taken.append(need)
        try:
            yield
        finally:
            with self._changed:
                self._taken.remove(need)
                self._changed.notify_all()


@dataclass(frozen=True)
class WorkerPool:
    """Running worker processes.

    Parameters
    ----------
    settings : ReductionSettings
        How runs are read.
    size : int
        How many processes there are.
    room : Room
        Memory for the runs that are being read.
    """

    settings: ReductionSettings
    size: int
    room: Room
    _idle: queue.SimpleQueue[subprocess.Popen[bytes] | None] = field(
        default_factory=queue.SimpleQueue
    )
    _here: threading.Lock = field(default_factory=threading.Lock)

    def read(self, run: Run) -> Reading:
        """Have a run read; waits for a process and for memory. May be called from threads.

        A run whose process ends, as for want of memory, is read in this one.

        Raises
        ------
        DataError
            As `read_run`.
        """
        with self.room.taken(memory_of(run)):
            process = self._idle.get()
            answer = None if process is None else _answer(process, run)
            self._idle.put(None if answer is None else process)
            if answer is None:
                with self._here:
                    return read_run(run, self.settings)
        kind, content = answer
        if kind == "read":
            return _with_own_loader(content, run)
        if kind == "wrong":
            raise DataError(content)
        raise RuntimeError(f"Reading run {run.id} failed:\n{content}")


def _answer(process: subprocess.Popen[bytes], run: Run) -> tuple[str, Any] | None:
    """What a process answers; None if it has ended."""
    assert process.stdin is not None
    assert process.stdout is not None
    try:
        send(process.stdin, run)
        answer: tuple[str, Any] = receive(process.stdout)
    except (EOFError, OSError, ValueError):
        return None
    return answer


def _with_own_loader(reading: Reading, run: Run) -> Reading:
    """The result with the run of this process instead of the copy that came back."""
    result = reading.rows.result
    kept = run.with_(settings=result.run.settings)
    return replace(
        reading,
        rows=replace(reading.rows, result=replace(result, run=kept)),
        summary=replace(reading.summary, run=run),
    )


def how_many(jobs: int | None, memory: float, own: float) -> int:
    """How many processes are worth starting.

    Parameters
    ----------
    jobs : int or None
        As many as asked for; None for the number of processors.
    memory : float
        What all may take together [MB].
    own : float
        What the asking process takes itself [MB].

    Examples
    --------
    >>> how_many(4, 1000.0, 150.0), how_many(64, 1000.0, 150.0)
    (4, 5)
    """
    return max(1, min(jobs or os.cpu_count() or 1, int((memory - own) / (1.25 * PROCESS_MB))))


@contextmanager
def worker_pool(
    settings: ReductionSettings, sample: Run, count: int, room: float
) -> Iterator[WorkerPool | None]:
    """Processes that read runs, ended with the block.

    Parameters
    ----------
    settings : ReductionSettings
        How runs are read.
    sample : Run
        One of the runs, to see whether they can be sent to another process.
    count : int
        How many processes.
    room : float
        Memory for the runs that are read at one time [MB].

    Yields
    ------
    WorkerPool or None
        None where no process can be started, or the runs live in this one only.
    """
    lean = replace(settings, campaign=settings.campaign.with_(runs=(), excluded=()))
    processes = _started(lean, count) if _can_be_sent((lean, sample)) else []
    try:
        ready = [process for process in processes if _is_ready(process)]
        found = WorkerPool(settings, len(ready), Room(room))
        for process in ready:
            found._idle.put(process)
        yield found if ready else None
    finally:
        for process in processes:
            process.kill()
            process.wait()


def _can_be_sent(content: object) -> bool:
    try:
        send(io.BytesIO(), content)
    except Exception:  # pickle raises whatever the objects raise
        return False
    return True


def _started(settings: ReductionSettings, count: int) -> list[subprocess.Popen[bytes]]:
    environment = {**os.environ, **_SETTINGS}
    command = [sys.executable, "-P", "-c", _START, json.dumps(sys.path)]
    processes: list[subprocess.Popen[bytes]] = []
    try:
        for _ in range(count):
            process = subprocess.Popen(
                command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, env=environment
            )
            processes.append(process)
            assert process.stdin is not None
            send(process.stdin, settings)
    except (OSError, ValueError):
        pass
    return processes


def _is_ready(process: subprocess.Popen[bytes]) -> bool:
    assert process.stdout is not None
    try:
        return bool(receive(process.stdout) == "ready")
    except Exception:  # whatever another program wrote there
        return False
