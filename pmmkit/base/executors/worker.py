"""What is sent to a worker, and what it does with it."""

from __future__ import annotations

import gc
import multiprocessing
import socket
import time
from typing import Any

from pmmkit.base.version import __version__


def packed(content: object) -> bytes | None:
    """What is sent; None where it lives in this process only, as an open file does."""
    import cloudpickle

    try:
        found: bytes = cloudpickle.dumps(content)
    except Exception:  # pickle raises whatever the objects raise
        return None
    return found


def unpacked(content: bytes) -> Any:
    """What `packed` was given."""
    import cloudpickle

    return cloudpickle.loads(content)


def done(work: bytes, things: bytes, version: str, attempt: int) -> bytes:  # noqa: ARG001
    """What a worker does: the seconds it takes, and of each thing the result or what went wrong."""
    from threadpoolctl import threadpool_limits

    if version != __version__:
        raise RuntimeError(
            f"{socket.gethostname()} has pmmkit {__version__}, {version} is asked for"
        )
    begin = time.perf_counter()
    answers: list[tuple[bool, Any]] = []
    with threadpool_limits(1):
        does = unpacked(work)
        for thing in unpacked(things):
            try:
                answers.append((True, does(thing)))
            except Exception as error:  # the process that asks does it itself and tells its own
                answers.append((False, f"{socket.gethostname()}: {error}"))
    content = packed((time.perf_counter() - begin, answers))
    if content is None:
        raise TypeError("what came of it cannot be sent")
    if multiprocessing.parent_process() is not None and not gc.get_freeze_count():
        gc.freeze()  # what is imported by now: loky collects each second, which takes it 60 ms
    return content
