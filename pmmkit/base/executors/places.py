"""Who works: processes of this machine, the workers of a dask cluster, an executor as it is."""

from __future__ import annotations

import multiprocessing
import os
import signal
import socket
import sys
import threading
import time
from collections.abc import Iterator, Mapping
from concurrent.futures import Executor
from contextlib import contextmanager
from types import MappingProxyType
from typing import Final

from pmmkit.base.errors import DataError

# How many threads the linear algebra below takes.


ONE_THREAD: Final[Mapping[str, str]] = MappingProxyType(
    {"OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1", "MKL_NUM_THREADS": "1"}
)
"""Environment in which matrices are factored by one thread, set before numpy is imported.

Ours have a few hundred rows. Two threads of OpenBLAS factor 204 rows of 78 columns in 0.6 ms, one
in 0.2; where another program takes a core, two wait for each other and need 30 to 50 ms: fitting an
effect to eight zigzags then takes 120 s in place of 24 (two cores, 2026).
"""


Workers = Executor | int | str | None
"""Where work runs: an executor, processes of this machine, a dask scheduler, or as is usual."""
ANSWERS: Final = 5.0
"""Seconds in which a scheduler has to answer."""
_SOCKETS: Final = ("tcp", "tls")
"""Schemes of addresses behind which a port listens."""
_ENVIRONMENT: Final = {**ONE_THREAD, "MALLOC_MMAP_THRESHOLD_": "4000000"}
"""One thread each; large arrays go back to the system (glibc keeps them otherwise)."""


@contextmanager
def opened(executor: Workers, *, rounds: bool = False) -> Iterator[Executor | int | None]:
    """An executor for an address; anything else as it is.

    Parameters
    ----------
    executor : Executor, int or str, optional
        Where work is to run.
    rounds : bool
        Whether work of several rounds follows: processes of this machine then stay for all of it.

    Raises
    ------
    DataError
        If there cannot be so many processes; if dask is not installed, no scheduler answers at the
        address within seconds, or it has no worker.

    Examples
    --------
    >>> with opened(4) as ready:
    ...     print(ready)
    4
    """
    if isinstance(executor, str):
        with _cluster(executor) as found:
            yield found
        return
    if isinstance(executor, int) and executor < 1:
        raise DataError(f"executor = {executor}: at least one process is needed.")
    if not rounds or not isinstance(executor, int):
        yield executor
    elif executor == 1:
        yield None
    else:
        with processes(executor) as made:
            yield made


@contextmanager
def _cluster(address: str) -> Iterator[Executor]:
    try:
        from distributed import Client
    except ImportError as error:
        raise DataError(
            "A scheduler needs dask, which is not installed: pip install 'pmmkit[distributed]'."
        ) from error
    begin = "Start one: dask scheduler --host HOST; on each machine: dask worker ADDRESS."
    try:
        _knock(address)
        client = Client(address, timeout=ANSWERS, set_as_default=False)
    except (OSError, ValueError) as error:
        raise DataError(
            f"No dask scheduler answers at {address} within {ANSWERS:g} s.",
            remedy=f"{begin} Or leave it out: this machine does it alone.",
        ) from error
    with client:
        try:
            client.wait_for_workers(1, timeout=ANSWERS)
        except TimeoutError as error:
            raise DataError(
                f"The scheduler at {address} has no worker. Start some: dask worker {address}."
            ) from error
        yield client.get_executor()


def _knock(address: str) -> None:
    """Raise at once where nobody listens: a client first begins a thread, and leaves it behind."""
    from distributed.comm.addressing import parse_address, parse_host_port
    from distributed.comm.registry import get_backend

    scheme, place = parse_address(address)
    get_backend(scheme)
    if scheme in _SOCKETS:
        socket.create_connection(parse_host_port(place), timeout=ANSWERS).close()


@contextmanager
def processes(count: int) -> Iterator[Executor | None]:
    """Processes of this machine, ended with the block; None where none can be started."""
    from joblib.externals.loky import ProcessPoolExecutor

    if multiprocessing.current_process().daemon:
        # A process that ends with the one above it may have none below it.
        yield None
        return
    made = ProcessPoolExecutor(
        count, initializer=_begin, initargs=(os.getpid(),), env=dict(_ENVIRONMENT)
    )
    try:
        yield made if starts(made) else None
    finally:
        made.shutdown(wait=True, kill_workers=True)


def starts(made: Executor) -> bool:
    """Whether an executor has a process that answers."""
    try:
        made.submit(os.getpid).result()
    except (OSError, RuntimeError):
        return False
    return True


def _begin(parent: int) -> None:
    """A worker leaves Ctrl-C to the process that asks, and ends with it however that ends."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)

    def watch() -> None:
        above = multiprocessing.parent_process()
        if sys.platform == "win32" and above is not None:
            above.join()
        else:
            while os.getppid() == parent:
                time.sleep(0.5)
        os._exit(1)

    threading.Thread(target=watch, daemon=True).start()
