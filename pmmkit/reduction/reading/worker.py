"""A process that reads runs for another one, which asks through a pipe.

It reads from its standard input how the runs are to be read and then run after run, and answers
each on its standard output. It ends when its input does, so none is left behind however the other
process ends.
"""

from __future__ import annotations

import os
import pickle
import signal
import sys
import traceback
from types import MappingProxyType
from typing import IO, Any

from pmmkit.errors import DataError
from pmmkit.reduction.reading.run import read_run


def _read_only(mapping: dict[Any, Any]) -> MappingProxyType[Any, Any]:
    return MappingProxyType(mapping)


class _Pickler(pickle.Pickler):
    """Knows read-only mappings, which pickle by itself does not."""

    def reducer_override(self, obj: Any) -> Any:
        if isinstance(obj, MappingProxyType):
            return _read_only, (dict(obj),)
        return NotImplemented


def send(stream: IO[bytes], content: object) -> None:
    """Write a message."""
    _Pickler(stream, protocol=pickle.HIGHEST_PROTOCOL).dump(content)
    stream.flush()


def receive(stream: IO[bytes]) -> Any:
    """Read a message that `send` wrote.

    Raises
    ------
    EOFError
        If the other side has ended.
    """
    return pickle.load(stream)


def serve() -> None:
    """Read runs until there are none: what a worker process does."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    answers = os.fdopen(os.dup(1), "wb")
    os.dup2(2, 1)
    asked = sys.stdin.buffer
    settings = receive(asked)
    send(answers, "ready")
    while True:
        try:
            run = receive(asked)
        except EOFError:
            return
        try:
            send(answers, ("read", read_run(run, settings)))
        except DataError as error:
            send(answers, ("wrong", error.problems))
        except Exception:
            send(answers, ("failed", traceback.format_exc()))
