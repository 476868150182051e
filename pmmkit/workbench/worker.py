"""A process of its own for long work: it tells how far it is, and can be ended at any time."""

from __future__ import annotations

import math
import multiprocessing
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from multiprocessing.connection import Connection
from threading import Lock, Thread
from types import MappingProxyType
from typing import Any, Final, Literal

from pmmkit.base import DataError, PmmkitError

Tell = Callable[[int, int, str], None]
Task = Callable[..., None]
Stand = Literal["idle", "running", "done", "failed", "cancelled"]
PATIENCE: Final = 2.0
"""Seconds that a process is given to end."""


@dataclass(frozen=True, kw_only=True)
class Job:
    """How a piece of long work stands.

    `stand`: how far it is. `done, total`: parts of the work; 0 of 0 where nothing is known.
    `text`: what is being done, or why it failed. `began, heard, ended`: seconds of a monotonic
    clock: of the begin, of the last part that was told, of the end. `usual`: seconds that the
    task took the last time; NaN where it was not done yet. `asked`: what the task was asked.
    """

    number: int = 0
    name: str = ""
    stand: Stand = "idle"
    done: int = 0
    total: int = 0
    text: str = ""
    began: float = 0.0
    heard: float = 0.0
    ended: float = 0.0
    usual: float = math.nan
    asked: Mapping[str, Any] = field(default_factory=lambda: MappingProxyType({}))

    def left(self, now: float) -> float | None:
        """Seconds that are left at some time: as many as the last time, else as many as the parts
        that are done foretell; None where neither can be told."""
        share = self.done / self.total if self.total else 0.0
        ends = self.began + self.usual
        if math.isnan(ends) and share:
            ends = self.began + (self.heard - self.began) / share
        return ends - now if ends > now else None

    def to_dict(self) -> dict[str, Any]:
        """As the page reads it: with the seconds gone and, where it can be told, those left."""
        until = time.monotonic() if self.stand == "running" else self.ended
        gone = until - self.began if self.number else 0.0
        left = self.left(until)
        return {
            "number": self.number,
            "name": self.name,
            "stand": self.stand,
            "done": self.done,
            "total": self.total,
            "text": self.text,
            "seconds": round(gone, 1),
            "left": None if left is None else round(left, 1),
            "effect": self.asked.get("effect"),
        }


class Worker:
    """One process that does one task after another.

    `make`: called in the process: gives its tasks by name. They get what is asked and `tell`.
    `finished`: called with the job when its task is done; what it raises fails the job.
    """

    def __init__(
        self, make: Callable[[], Mapping[str, Task]], finished: Callable[[Job], None]
    ) -> None:
        self._make = make
        self._finished = finished
        self._lock = Lock()
        self._job = Job()
        self._took: dict[str, float] = {}
        self._process: multiprocessing.process.BaseProcess | None = None
        self._pipe: Connection | None = None

    @property
    def job(self) -> Job:
        """The last job."""
        with self._lock:
            return self._job

    def start(self, name: str, asked: Mapping[str, Any]) -> Job:
        """Begin a task."""
        with self._lock:
            if self._job.stand == "running":
                raise DataError("Something else is being worked out: wait for it, or cancel it.")
            if self._process is None or not self._process.is_alive():
                self._begin()
            assert self._pipe is not None
            number = self._job.number + 1
            now = time.monotonic()
            job = Job(
                number=number,
                name=name,
                stand="running",
                began=now,
                heard=now,
                usual=self._took.get(name, math.nan),
                asked=asked,
            )
            self._job = job
            self._pipe.send((name, dict(asked)))
            Thread(target=self._listen, args=(self._pipe, number), daemon=True).start()
            return job

    def warm(self) -> None:
        """Begin the process, which takes a second or two, before it is needed."""
        with self._lock:
            if self._process is None:
                self._begin()

    def cancel(self) -> Job:
        """End what is running."""
        with self._lock:
            if self._job.stand == "running":
                self._end("cancelled", "")
                self._stop()
            return self._job

    def close(self) -> None:
        """End the process."""
        with self._lock:
            if self._job.stand == "running":
                self._end("cancelled", "")
            self._stop()

    def _begin(self) -> None:
        context = multiprocessing.get_context("spawn")
        self._pipe, theirs = context.Pipe()
        self._process = context.Process(target=_serve, args=(theirs, self._make), daemon=True)
        self._process.start()
        theirs.close()

    def _stop(self) -> None:
        if self._process is not None:
            self._process.terminate()
            self._process.join(PATIENCE)
            if self._process.is_alive():
                self._process.kill()
        if self._pipe is not None:
            self._pipe.close()
        self._process = self._pipe = None

    def _end(self, stand: Stand, text: str) -> None:
        self._job = replace(self._job, stand=stand, text=text, ended=time.monotonic())
        if stand == "done":
            self._took[self._job.name] = self._job.ended - self._job.began

    def _listen(self, pipe: Connection, number: int) -> None:
        lost = False
        while True:
            try:
                kind, content = pipe.recv()
            except (EOFError, OSError, TypeError):
                lost = True
                kind, content = "failed", "The process ended before its time. Try again."
            with self._lock:
                if self._job.number != number or self._job.stand != "running":
                    return
                if kind == "progress":
                    done, total, text = content
                    now = time.monotonic()
                    self._job = replace(self._job, done=done, total=total, text=text, heard=now)
                    continue
                job = self._job
            if kind == "done":
                try:
                    self._finished(job)
                except PmmkitError as error:
                    kind, content = "failed", str(error)
            with self._lock:
                if lost and self._pipe is pipe:
                    # Its pipe ends a moment before the process does: nothing more is sent to it.
                    self._stop()
                if self._job.number == number and self._job.stand == "running":
                    self._end(
                        "done" if kind == "done" else "failed", "" if kind == "done" else content
                    )
            return


def _serve(pipe: Connection, make: Callable[[], Mapping[str, Task]]) -> None:
    """The life of the process."""
    import signal

    # Ctrl+C belongs to the server, which ends this process.
    signal.signal(signal.SIGINT, signal.SIG_IGN)

    tasks = make()

    def tell(done: int, total: int, text: str) -> None:
        pipe.send(("progress", (done, total, text)))

    while True:
        try:
            name, asked = pipe.recv()
        except EOFError:
            return
        try:
            tasks[name](**asked, tell=tell)
            pipe.send(("done", ""))
        except PmmkitError as error:
            pipe.send(("failed", str(error)))
        except Exception as error:
            pipe.send(("failed", f"{type(error).__name__}: {error}"))
