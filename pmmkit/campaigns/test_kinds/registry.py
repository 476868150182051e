"""All kinds of test: those of this folder and those of installed packages."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from functools import cache
from types import MappingProxyType
from typing import Final

from pmmkit.base import UnknownNameError, offered
from pmmkit.campaigns.test_kinds import free_running, oscillating, steady
from pmmkit.campaigns.test_kinds.kind import TestKind
from pmmkit.conventions import did_you_mean

BUILT_IN: Final[Mapping[str, TestKind]] = MappingProxyType(
    {kind.name: kind for kind in (*steady.KINDS, *oscillating.KINDS, *free_running.KINDS)}
)
GROUP: Final = "pmmkit.test_kinds"
"""Entry points by which other packages bring their kinds of test."""


@cache
def kinds() -> Mapping[str, TestKind]:
    """All kinds of test by name: steady, oscillating, free running, then those of other packages.

    Examples
    --------
    >>> [name for name, kind in kinds().items() if kind.sways]
    ['pure_sway', 'sway_yaw']
    """
    return MappingProxyType({**BUILT_IN, **offered(GROUP, TestKind, BUILT_IN)})


def captive_kinds() -> tuple[TestKind, ...]:
    """Kinds of captive test, the steady ones first."""
    return tuple(kind for kind in kinds().values() if kind.captive)


def kind_of(name: str) -> TestKind:
    """The kind of test of a name.

    Raises
    ------
    UnknownNameError
        With the names there are.

    Examples
    --------
    >>> kind_of("pure_yaw").quasi_steady
    3.0
    """
    # Other packages are only asked for names that are not ours: their import may take long.
    known = BUILT_IN if name in BUILT_IN else kinds()
    if name not in known:
        raise UnknownNameError(not_a_kind(name))
    return known[name]


def not_a_kind(name: str) -> str:
    """What is wrong with a name that is none of a kind of test.

    Examples
    --------
    >>> not_a_kind("pure_jaw").partition(", ")[0], not_a_kind("pure_jaw").partition("; ")[2]
    ("'pure_jaw' is not one of resistance", "did you mean 'pure_yaw'?")
    """
    return f"{name!r} is not one of {', '.join(kinds())}{did_you_mean(name, kinds()) or '.'}"


def kind_with(
    *, swings: Collection[str] = (), held: Collection[str] = (), turning: bool = False
) -> TestKind | None:
    """The captive kind that oscillates so and holds these settings; the simplest of several.

    Parameters
    ----------
    swings : collection of str
        Velocities that oscillate: ``u``, ``v``, ``r``.
    held : collection of str
        Angles that are held: ``drift``, ``rudder``, ``heel``.
    turning : bool
        Whether the model is held in a steady turn.

    Examples
    --------
    >>> kind_with(swings={"r"}, held={"drift"}).name, kind_with(held={"drift", "rudder"}).name
    ('yaw_drift', 'drift_rudder')
    """
    wanted = {*held, *(("yaw_rate",) if turning else ())}
    for kind in captive_kinds():
        if set(kind.held) == wanted and {swing.velocity for swing in kind.swings} == set(swings):
            return kind
    return None


def held_too(kind: TestKind, name: str) -> TestKind:
    """The kind of test with one more angle held; the same where there is none.

    Examples
    --------
    >>> held_too(kind_of("pure_yaw"), "rudder").name, held_too(kind_of("pure_sway"), "rudder").name
    ('yaw_rudder', 'pure_sway')
    """
    swings = {swing.velocity for swing in kind.swings}
    return kind_with(swings=swings, held={*kind.held, name}) or kind
