"""A reduction on a cluster, a worker of which is killed half-way, beside the same on one machine.

    python -m scripts.studies.cluster FOLDER [--runs 2000] [--mb 0.5] [--workers 2] [--serial]

One scheduler and the workers are started with dask's own commands on the loopback interface. The
campaign is made in FOLDER by `make_large` unless it lies there. The tables are compared to the bit.
Beside the seconds on the wall stand those of all processors, of all processes together.
"""

from __future__ import annotations

import argparse
import os
import re
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory

import pmmkit as pk
from pmmkit.base import Workers
from pmmkit.reduction import Reduction, reduce_campaign
from scripts.datasets.make_large import make

HERE = "executor=None"
BEGIN = 30.0
"""Seconds in which a scheduler has to begin."""


@dataclass(frozen=True)
class Cluster:
    """A scheduler and its workers, each a process of its own."""

    address: str
    scheduler: subprocess.Popen[bytes]
    workers: list[subprocess.Popen[bytes]]


@contextmanager
def cluster(workers: int) -> Iterator[Cluster]:
    """A scheduler and so many workers on the loopback interface."""
    with TemporaryDirectory() as place:
        log = Path(place)
        options = ["--nthreads", "1", "--no-dashboard"]
        started = [
            _dask(
                log / "scheduler", "scheduler", "--host", "127.0.0.1", "--port", "0", *options[2:]
            )
        ]
        try:
            address = _said(log / "scheduler", r"tcp://127\.0\.0\.1:\d+")
            for number in range(workers):
                started.append(_dask(log / f"{number}", "worker", address, *options))
            for number in range(workers):
                _said(log / f"{number}", "Registered to")
            yield Cluster(address=address, scheduler=started[0], workers=started[1:])
        finally:
            for process in started:
                kill(process)


def kill(process: subprocess.Popen[bytes]) -> None:
    """End a process and those that it has started, without a word to them."""
    with suppress(ProcessLookupError):
        os.killpg(process.pid, signal.SIGKILL)
    process.wait()


def spent(cluster: Cluster | None = None) -> float:
    """Seconds of the processors so far, of this process and those it started."""
    own = sum(os.times()[:4])
    if cluster is None:
        return own
    import psutil

    begun = [
        psutil.Process(x.pid) for x in (cluster.scheduler, *cluster.workers) if x.poll() is None
    ]
    every = {y.pid: y for x in begun for y in (x, *x.children(recursive=True))}
    return own + sum(sum(x.cpu_times()[:2]) for x in every.values())


def _dask(log: Path, *arguments: str) -> subprocess.Popen[bytes]:
    """A command of dask in a group of its own, so that it is killed with what it starts."""
    with log.open("wb") as stream:
        return subprocess.Popen(
            [sys.executable, "-m", "dask", *arguments],
            stderr=stream,
            cwd=log.parent,
            start_new_session=True,
        )


def _said(log: Path, pattern: str) -> str:
    """What a command writes once it is ready."""
    end = time.monotonic() + BEGIN
    while time.monotonic() < end:
        if found := re.search(pattern, log.read_text()):
            return found[0]
        time.sleep(0.1)
    raise RuntimeError(f"dask does not begin: {log.read_text()[-500:]}")


def everything(found: Reduction) -> object:
    """All numbers of a reduction, to the bit."""
    tables = [found.table, *found.families.values(), *found.single_runs.values()]
    numbers = [part.tobytes() for item in tables for part in (item.value, item.covariance)]
    return numbers, found.runs_to_pandas().to_csv(), [str(item) for item in found.findings]


def timed(
    folder: Path, executor: Workers, half_way: Callable[[], object] = int
) -> tuple[float, object]:
    """Seconds that a reduction takes, and its numbers; something happens when half is read."""
    told = []

    def progress(done: int, total: int, _: str) -> None:
        if 2 * done >= total and not told:
            told.append(done)
            half_way()

    begin = time.perf_counter()
    found = reduce_campaign(
        pk.open_campaign(folder), structure="cubic", executor=executor, progress=progress
    )
    return time.perf_counter() - begin, everything(found)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("folder", type=Path)
    parser.add_argument("--runs", type=int, default=2000)
    parser.add_argument("--mb", type=float, default=0.5, help="size of a usual run")
    parser.add_argument("--workers", type=int, default=2)
    parser.add_argument("--serial", action="store_true", help="also in this process alone")
    given = parser.parse_args()
    folder = given.folder.resolve()
    if not (folder / "campaign.toml").is_file():
        make(folder, runs=given.runs, mb=given.mb, jobs=given.workers)

    def told(
        what: str,
        executor: Workers,
        half_way: Callable[[], object] = int,
        machines: Cluster | None = None,
    ) -> object:
        before = spent(machines)
        seconds, found = timed(folder, executor, half_way)
        costs = "" if half_way is not int else f"{spent(machines) - before:7.1f} s of processors"
        same = "" if what == HERE else f"  the same to the bit: {found == here}"
        print(f"{what:40s}{seconds:7.1f} s{costs:25s}{same}", flush=True)
        return found

    here = told(HERE, None)
    if given.serial:
        told("executor=1", 1)
    with cluster(given.workers) as machines:
        what = f"dask, {given.workers} workers"
        told(what, machines.address, machines=machines)
        told(f"{what}, one killed half-way", machines.address, lambda: kill(machines.workers[0]))


if __name__ == "__main__":
    main()
