"""All kinds of test: those of this folder and those of installed packages."""

from __future__ import annotations

from collections.abc import Collection
from typing import Final

from pmmkit.base import Registry, listed_in
from pmmkit.campaigns.test_kinds.kind import TestKind

GROUP: Final = "pmmkit.test_kinds"
"""Entry points by which other packages bring their kinds of test."""
TEST_KINDS: Final = Registry(
    TestKind,
    listed_in(
        "pmmkit.campaigns.test_kinds", "KINDS", first=("steady", "oscillating", "free_running")
    ),
    what="kind of test",
    group=GROUP,
    unknown="{name!r} is not one of {names}{guess}",
    contract="pmmkit.testing.test_kinds:check_test_kind",
)
"""All kinds of test by name: steady, oscillating, free running, then those of other packages."""


def captive_kinds() -> tuple[TestKind, ...]:
    """Kinds of captive test, the steady ones first."""
    return tuple(kind for kind in TEST_KINDS.values() if kind.captive)


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
    >>> [held_too(TEST_KINDS[name], "rudder").name for name in ("pure_yaw", "pure_sway")]
    ['yaw_rudder', 'pure_sway']
    """
    swings = {swing.velocity for swing in kind.swings}
    return kind_with(swings=swings, held={*kind.held, name}) or kind
