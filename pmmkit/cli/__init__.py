"""The command line: ``pmmkit reduce``, ``pmmkit simulate`` and so on."""

from __future__ import annotations

import gc
import os
import signal
import sys
import warnings
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from typing import Any

from pmmkit.actions import DONE, WRONG
from pmmkit.base import ONE_THREAD, PmmkitError

USAGE, STOPPED = 2, 130
YOUNG = 20_000
"""New objects after which Python looks for cycles; its own 700 cost a reduction 0.6 s of 9."""


def main(arguments: Sequence[str] | None = None) -> int:
    """Run one command."""
    if arguments is None:  # the process is ours
        os.environ.update({name: own for name, own in ONE_THREAD.items() if name not in os.environ})
        gc.set_threshold(YOUNG)
    given = list(sys.argv[1:] if arguments is None else arguments)
    _open_streams()
    for stream in (sys.stdout, sys.stderr):
        if hasattr(stream, "reconfigure"):
            stream.reconfigure(errors="replace")
    previous = _stop_on_termination()
    try:
        status = _run(given)
        sys.stdout.flush()
        return status
    except KeyboardInterrupt:  # between a command's end and the flush of what it said
        return STOPPED
    except OSError as error:
        if not isinstance(error, BrokenPipeError):
            why = f"standard output or a file cannot be written: {error.strerror or error}."
            print(f"pmmkit: {why}", file=sys.stderr)
        _give_up_output()
        return WRONG
    finally:
        if previous is not None:
            signal.signal(signal.SIGTERM, previous)


def _run(given: list[str]) -> int:
    import typer

    from pmmkit.cli.app import application
    from pmmkit.cli.output import tell_error, tell_usage

    as_json = "--json" in given
    usage_error: Any = typer.BadParameter.__base__
    try:
        with _one_line_each():
            status = application(*given[:1])(given, prog_name="pmmkit", standalone_mode=False)
    except (typer.Abort, KeyboardInterrupt):
        status = STOPPED
    except PmmkitError as error:
        tell_error(error, as_json=as_json)
        return WRONG
    except OSError as error:
        if error.filename is None:
            raise
        tell_error(error, as_json=as_json)
        return WRONG
    except usage_error as error:
        tell_usage(error, given, as_json=as_json)
        return USAGE
    if status == STOPPED:
        print("Stopped. No output was left half-written.", file=sys.stderr)
    return status if isinstance(status, int) else DONE


@contextmanager
def _one_line_each() -> Iterator[None]:
    """Warnings are a line for the person at the keyboard, without the place in the code."""

    def told(message: Warning | str, *_: object, **__: object) -> None:
        print(f"pmmkit: {message}", file=sys.stderr)

    with warnings.catch_warnings():
        warnings.showwarning = told
        yield


def _open_streams() -> None:
    """Standard streams that were closed lead nowhere, so that no file takes their place."""
    for name, mode in (("stdin", "r"), ("stdout", "w"), ("stderr", "w")):
        if getattr(sys, name) is None:
            setattr(sys, name, open(os.devnull, mode, encoding="utf-8"))  # noqa: SIM115, it stays


def _give_up_output() -> None:
    """Let what is still to be written vanish, or Python tries it again at its end."""
    try:
        sys.stdout.flush()
    except OSError:
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())


def _stop_on_termination() -> Any:
    """Let a termination clean up like Ctrl-C; gives what was set before."""

    def stop(*_: object) -> None:
        raise KeyboardInterrupt

    try:
        return signal.signal(signal.SIGTERM, stop)
    except ValueError:
        return None
