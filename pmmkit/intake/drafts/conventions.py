"""Axes and signs of a source, proposed from what the forces of all of its runs say together.

A hull fixes the signs of what it answers (`pmmkit.intake.checks.physics`). The ways in which a
source may differ from our axes are few: which axes point the other way, in which direction drift,
rudder and the oscillations are counted, which column is a resistance. All of them are tried on all
signs at once; what is proposed agrees with every one of them.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Final

from pmmkit.campaigns import Frame
from pmmkit.intake.checks.physics import AskedSign

_AXES: Final = ("", "yz", "xz", "xy")
"""Right-handed axes by those that point the other way."""
_AXES_COST: Final = {"": 0.0, "yz": 1.0, "xz": 1.0, "xy": 1.5}
_SOLVERS_COST: Final = {"": 0.0, "yz": 0.5, "xz": 0.5, "xy": 1.5}
"""Meshes have z up."""
_FLIP_COST: Final = {"X": 1.0, "Y": 3.0, "N": 3.0, "drift": 0.9, "rudder": 0.9, "sway": 1, "yaw": 1}
_UNLIKELY: Final = 3.0
"""Cost from which a flip is listed for a person to judge, and never proposed."""
_LISTED: Final = 3
_FEWEST: Final = 3
"""Runs without which nothing is proposed."""


@dataclass(frozen=True, kw_only=True)
class SourceConvention:
    """One way in which a source may differ from our axes and signs.

    `reversed_axes`: axes that point the other way. `flips`: of the others: forces whose column
    has the other sign, and motions (``drift``, ``rudder``, ``sway``, ``yaw``) that are counted
    the other way. `cost`: how unusual it is.
    """

    reversed_axes: str = ""
    flips: frozenset[str] = frozenset()
    cost: float = 0.0

    @property
    def changes(self) -> bool:
        """Whether anything differs."""
        return bool(self.reversed_axes or self.flips)

    def __str__(self) -> str:
        words = [_AXES_WORDS[self.reversed_axes]] if self.reversed_axes else []
        words += [_FLIP_WORDS[name] for name in _FLIP_COST if name in self.flips]
        return ", ".join(words) or "our axes and signs"


_AXES_WORDS: Final = {
    "yz": 'axes y = "-y", z = "-z" (y to port, z up)',
    "xz": 'axes x = "-x", z = "-z" (x aft, z up)',
    "xy": 'axes x = "-x", y = "-y" (x aft, y to port)',
}
_FLIP_WORDS: Final = {
    "X": "X the other way (a resistance: scale = -1)",
    "Y": "Y the other way (scale = -1)",
    "N": "N the other way (scale = -1)",
    "drift": 'drift_positive = "port-bow"',
    "rudder": 'rudder_positive = "port"',
    "sway": "sway begun the other way (phase_deg = 180)",
    "yaw": "yaw begun the other way (phase_deg = 180)",
}


@dataclass(frozen=True, kw_only=True)
class Ranking:
    """What physics leaves of all conventions.

    `best`: what agrees with every sign and is clearly ahead; None where several ways remain
    that give different results, or none. `remaining`: where there is no best: the likeliest of
    those that contradict the fewest signs. `signs`: those that are certain. `contradicted`:
    signs that even the remaining ones contradict.
    """

    best: SourceConvention | None
    remaining: tuple[SourceConvention, ...]
    signs: tuple[AskedSign, ...]
    contradicted: int = 0


@dataclass(frozen=True, kw_only=True)
class Proposal:
    """What a draft says of axes and signs, and why.

    `convention`: what stands in the draft as if a person had said it; None where that is left
    to one. `remaining`: what physics leaves where it is left to a person. `seen`: what the runs
    showed. `balance`: whether the model's inertia is inside the forces; None where that is not
    known. `along_tank`: whether forces of tests with a constant drift angle stay along the
    tank. `recorded`: motions that were recorded.
    """

    convention: SourceConvention | None = None
    remaining: tuple[SourceConvention, ...] = ()
    seen: str = ""
    balance: bool | None = None
    why_balance: str = ""
    along_tank: bool | None = None
    why_along: str = ""
    recorded: frozenset[str] = frozenset()


def ranked(
    signs: Sequence[AskedSign], *, recorded: Collection[str] = (), computed: bool = False
) -> Ranking:
    """The conventions that agree with the signs that physics asks.

    Two ways that turn all sideways forces and all motions alike are mirror images: they give the
    same derivatives but for Y0 and N0, and the more usual one stands for both.

    Examples
    --------
    >>> def sign(channel, motion, value, right):
    ...     return AskedSign(channel=channel, motion=motion, words="", value=value, std=0.0,
    ...                      right=right, runs=("a", "b", "c"))
    >>> runs = [sign("Y", "drift", -1.0, 1), sign("N", "drift", -0.4, 1),
    ...         sign("Y", "sway", -1.0, -1), sign("N", "sway", -0.4, -1)]
    >>> print(ranked(runs, computed=True).best)
    axes y = "-y", z = "-z" (y to port, z up)
    >>> print(ranked(runs).best)
    drift_positive = "port-bow"
    >>> print(ranked([sign("N", "drift", -0.4, 1), *runs[2:], sign("Y", "drift", 1.0, 1)]).best)
    None
    """
    certain = tuple(sign for sign in signs if sign.verdict)
    runs = {run for sign in certain for run in sign.runs}
    if len(runs) < _FEWEST or not {"Y", "N"} <= {sign.channel for sign in certain}:
        return Ranking(best=None, remaining=(), signs=certain)
    tried = sorted(_conventions(certain, recorded, computed=computed), key=lambda item: item.cost)
    wrong = {item: _contradicted(item, certain, recorded) for item in tried}
    fewest = min(wrong.values())
    left = [item for item in tried if wrong[item] == fewest]
    classes: dict[tuple[int, ...], SourceConvention] = {}
    for item in left:
        classes.setdefault(_without_mirror(item, certain, recorded), item)
    best = next(iter(classes.values()))
    if fewest or len(classes) > 1 or _unlikely(best, recorded):
        remaining = tuple(classes.values()) if len(classes) > 1 else tuple(left)
        return Ranking(best=None, remaining=remaining[:_LISTED], signs=certain, contradicted=fewest)
    return Ranking(best=best, remaining=(), signs=certain)


def _conventions(
    signs: Sequence[AskedSign], recorded: Collection[str], *, computed: bool
) -> Iterator[SourceConvention]:
    """All ways of which the signs say something."""
    seen = {sign.channel for sign in signs} | {sign.motion for sign in signs}
    free = [name for name in _FLIP_COST if name in seen]
    costs = _SOLVERS_COST if computed else _AXES_COST
    for axes in _AXES:
        if "x" in axes and "X" not in seen:
            continue
        turned = {name for name in ("X", "Y", "N") if Frame(reversed_axes=axes).sign(name) < 0}
        own = [name for name in free if name not in turned]
        for count in range(len(own) + 1):
            for flips in itertools.combinations(own, count):
                cost = costs[axes] + sum(_cost(name, recorded) for name in flips)
                yield SourceConvention(reversed_axes=axes, flips=frozenset(flips), cost=cost)


def _cost(name: str, recorded: Collection[str]) -> float:
    return _UNLIKELY if name in recorded else _FLIP_COST[name]


def _unlikely(item: SourceConvention, recorded: Collection[str]) -> bool:
    return any(_cost(name, recorded) >= _UNLIKELY for name in item.flips)


_TURNED_BY: Final[Mapping[str, Callable[[Frame, bool], int]]] = {
    "ahead": lambda frame, recorded: 1,  # noqa: ARG005
    "drift": lambda frame, recorded: frame.sign("psi") if recorded else 1,
    "rudder": lambda frame, recorded: 1,  # noqa: ARG005
    "sway": lambda frame, recorded: frame.sign("y"),  # noqa: ARG005
    "yaw": lambda frame, recorded: frame.sign("psi"),  # noqa: ARG005
}
"""How motions turn with the axes; a stated drift is counted as `drift_positive` says."""


def _net(item: SourceConvention, name: str, recorded: Collection[str]) -> int:
    """-1 where a force or motion changes its sign."""
    frame = Frame(reversed_axes=item.reversed_axes)
    turn = _TURNED_BY.get(name)
    sign = frame.sign(name) if turn is None else turn(frame, name in recorded)
    return -sign if name in item.flips else sign


def _contradicted(
    item: SourceConvention, signs: Sequence[AskedSign], recorded: Collection[str]
) -> int:
    return sum(
        sign.verdict * _net(item, sign.channel, recorded) * _net(item, sign.motion, recorded) < 0
        for sign in signs
    )


def _without_mirror(
    item: SourceConvention, signs: Sequence[AskedSign], recorded: Collection[str]
) -> tuple[int, ...]:
    """The signs that all forces and motions get, the same for two mirror images."""
    names = dict.fromkeys(name for sign in signs for name in (sign.channel, sign.motion))
    sideways = [name for name in names if name not in ("X", "ahead")]
    nets = [_net(item, name, recorded) for name in sideways]
    along = [_net(item, "X", recorded)] if "X" in names else []
    return (*along, *(net * nets[0] for net in nets))
