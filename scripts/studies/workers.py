"""Where the work of a study runs: options that all studies share, as the commands have them.

The functions of a study are sent by name and not as what they hold, so that a worker keeps what
they remember from one thing to the next. Workers of a cluster must be able to import `scripts`.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import Executor
from contextlib import AbstractContextManager
from functools import partial
from importlib import import_module
from typing import Any, TypeVar

from pmmkit.base import each, opened

T = TypeVar("T")
R = TypeVar("R")


def add_workers(parser: argparse.ArgumentParser, usual: int) -> None:
    """The options ``--workers`` (or ``--jobs``) and ``--scheduler``, of which one is given."""
    either = parser.add_mutually_exclusive_group()
    either.add_argument(
        "--workers", "--jobs", type=int, default=usual, help="processes of this machine"
    )
    either.add_argument("--scheduler", help="address of a dask scheduler whose workers do it")


def crew(options: argparse.Namespace) -> AbstractContextManager[Executor | int | None]:
    """Who works, as the options say; None for this process alone."""
    return opened(options.scheduler or options.workers, rounds=True)


def as_done(
    work: Callable[[T], R], things: Iterable[T], executor: Executor | int | None
) -> Iterator[tuple[int, R]]:
    """What comes of each thing, with its place, in the order in which they are done."""
    listed = list(things)
    sent = by_name(work)
    title = getattr(sent, "func", sent).__name__
    names = [f"{title} of number {place}" for place in range(len(listed))]
    return each(sent, listed, executor, names=names)


def in_order(
    work: Callable[[T], R], things: Iterable[T], executor: Executor | int | None
) -> list[R]:
    """What comes of each thing, in their order."""
    return [found for _, found in sorted(as_done(work, things, executor), key=lambda item: item[0])]


def by_name(work: Callable[..., Any]) -> Callable[..., Any]:
    """A function of the module that was started, as another process imports it.

    Examples
    --------
    >>> by_name(partial(round, ndigits=2))(3.14159)
    3.14
    """
    if isinstance(work, partial):
        return partial(by_name(work.func), *work.args, **work.keywords)
    spec = getattr(sys.modules["__main__"], "__spec__", None)
    if work.__module__ != "__main__" or spec is None:
        return work
    named: Callable[..., Any] = getattr(import_module(spec.name), work.__name__)
    return named
