"""Sets of effects, and how far the base moves, weighed by what the records make of them.

p(records | set) is the mean over the spreads s of the base of ∫ p(records | z) N(z; 0, K + s² 1) dz
(Laplace): by products of the base first (`screen`), then of the set.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from types import MappingProxyType
from typing import Final, Literal

import numpy as np
from numpy.typing import NDArray

from pmmkit.base import DataError
from pmmkit.diagnosis.evidence import PRICE, integrated_out, why_no_size
from pmmkit.diagnosis.free_running.base import FreeBase
from pmmkit.diagnosis.free_running.information import WindowInformation
from pmmkit.effects import CATALOGUE, HULL, INERTIA, OUTSIDE, Effect, Move
from pmmkit.identification import ONE_SEA, FreeRecord
from pmmkit.inference import Normal
from pmmkit.models import Model, Part, Sailing
from pmmkit.numerics import Array

# What may be missing of a free-running ship's model, from the catalogue: terms, values, faults.


APART: Final = 1.1
"""Ratio of two speeds of approach from which they count as two."""
DEEP: Final = 6.0
"""Draughts from which the bottom adds at most 3 % to the linear derivatives."""


@dataclass(frozen=True, kw_only=True)
class FreeCandidate:
    """One effect, or one fault, as directions in which the values of a model may move.

    `name, family`: name in the catalogue; family by which an answer is given first. `kind`:
    whether it is the ship and its surroundings, or a measurement. `summary`: one sentence for
    people. `moves`: by coefficient: which values of the model it moves, and by how much for a
    coefficient of 1. `lag`: the coefficient that is no size but how long a flow remembers, as it
    comes to that of the model; empty where there is none. `price`: ln of the odds against it before
    the records. Values are named as in `identify`, with ``current_x``, ``current_y`` and
    ``rudder_zero``. `typical`: usual size of each coefficient. `part`: what the model is given
    to have these values, where it lacks them. `options, begins`: what parts of the model are
    told to use these values, and what these are then, as in `effects.seen.Move`. `check`: a run
    that tells it from others, in words. `signed`: whether nature has a sign for it.
    """

    name: str
    family: str
    summary: str
    moves: Mapping[str, Mapping[str, float]]
    typical: Mapping[str, float]
    kind: Literal["physics", "fault"] = "physics"
    part: Part | None = None
    options: Mapping[str, Mapping[str, str]] = field(default_factory=lambda: MappingProxyType({}))
    begins: Mapping[str, float] = field(default_factory=lambda: MappingProxyType({}))
    check: str = ""
    signed: bool = False
    lag: str = ""
    price: float = PRICE

    @property
    def values(self) -> tuple[str, ...]:
        """All values that it moves."""
        return tuple(dict.fromkeys(name for own in self.moves.values() for name in own))

    def added_to(self, model: Model) -> Model:
        """The model with a place for the effect, its size still zero."""
        made = Sailing(model, 1.0).told(self.options, self.begins)
        if self.part is not None and self.part.effect not in model.parts:
            made = replace(
                made, parts=MappingProxyType({**made.parts, self.part.effect: self.part})
            )
        for name in self.values:
            if "." in name or name in OUTSIDE or _known(made, name):
                continue
            home = INERTIA if name.endswith("dot") else HULL
            made = made.with_values(home, **{name: 0.0})
        return made


def _known(model: Model, name: str) -> bool:
    return any(name in part.values for part in model.derivative_parts.values())


def excited(model: Model, records: Sequence[FreeRecord]) -> frozenset[str]:
    """What records hold, in the words of `Effect.EXCITES`."""
    speeds = [item.speed for item in records]
    return frozenset(
        word
        for word, there in {
            "rudder": True,
            "large motion": True,
            "several speeds": bool(speeds) and max(speeds) > APART * min(speeds),
            "roll": model.rolls
            or (bool(records) and all(item.roll is not None for item in records)),
            "wind": bool(records) and all(item.wind_speed is not None for item in records),
            "waves": bool(model.in_role("waves"))
            and bool(records)
            and all(item.wave_height is not None for item in records),
            "depth": any((item.depth or math.inf) < DEEP * model.ship.d for item in records),
        }.items()
        if there
    )


_LOGGED: Final[Mapping[str, str]] = MappingProxyType(
    {
        "roll": "log the roll angle in every run",
        "wind": "log the wind in every run, or state its speed and direction",
        "waves": "state the sea of every run, and give the model a table (pmmkit seakeeping)",
        "depth": "state the depth of the water; in deep water there is nothing to ask",
        "several speeds": "sail at a second speed",
    }
)
"""What gives records what they lack, by the words of `Effect.EXCITES`."""


def lacking(effect: Effect, model: Model, records: Sequence[FreeRecord]) -> str:
    """What records must hold to be asked for an effect and do not, and what would give it; empty
    where they hold it all."""
    held = excited(model, records)
    words = [word for word in effect.excites if word not in held]
    if not words:
        return ""
    remedy = "; ".join(_LOGGED[word] for word in words if word in _LOGGED)
    lack = f"these records lack {' and '.join(effect.EXCITES[word] for word in words)}"
    return f"{lack}: {remedy}" if remedy else lack


def why_not_asked(effect: Effect, model: Model, records: Sequence[FreeRecord]) -> str:
    """Why records are not asked for an effect, and what would tell; empty where they are."""
    if not effect.asked_in_free_running:
        if "shaft" in effect.roles:
            return (
                "the model sails with the revolutions that are recorded: log their order too, and "
                "compare what an engine makes of it with them"
            )
        told = "; captive tests are asked for it" if effect.asked_in_captive else ""
        return (
            f"{effect.not_free_running}{told}" if effect.not_free_running else why_no_size(effect)
        )
    lacks = lacking(effect, model, records)
    if lacks:
        return lacks
    if not free_candidate_of(effect, Sailing(model, records[0].speed)).moves:
        return "the model has no place for it: it is asked once there is a part that it changes"
    return ""


def check_seas(model: Model, records: Sequence[FreeRecord]) -> None:
    """Refuse records of seas that one table of drift cannot stand for."""
    periods = [item.wave_period for item in records if item.wave_period is not None]
    if model.in_role("waves") and periods and max(periods) > ONE_SEA * min(periods):
        raise DataError(
            f"The records state waves of {min(periods):g} to {max(periods):g} s, and a table of "
            f"wave drift holds at one period: give the records of one sea, with a table made for "
            f"it (pmmkit seakeeping --tp)."
        )


def candidates_for(
    model: Model,
    records: Sequence[FreeRecord],
    *,
    windage: tuple[float, float] | None = None,
    own: Sequence[Effect] = (),
) -> tuple[FreeCandidate, ...]:
    """Everything that may be missing of a model, as far as it has a place for it.

    windage [m²].

    Examples
    --------
    >>> from pmmkit.models import load_model
    >>> found = candidates_for(load_model("kvlcc2-l7"), [])
    >>> [item.name for item in found if item.family == "asymmetry"]
    ['fault_rudder_zero', 'asymmetry', 'even_hull_terms']
    """
    speeds = [record.speed for record in records]
    vessel = Sailing(model, sum(speeds) / len(speeds) if speeds else 1.0)
    held = excited(model, records)
    given = {} if windage is None else {"AF": windage[0], "AL": windage[1]}
    every = {item.name: item for item in (*CATALOGUE.values(), *own)}
    # A bottom that is near acts on every ship: a model of deep water lacks it, whoever asks.
    near = () if model.in_role("depth") else ("depth",)
    candidates = [
        replace(
            free_candidate_of(effect, vessel, given),
            price=0.0 if set(near) & set(effect.excites) else PRICE,
        )
        for effect in every.values()
        if effect.asked_in_free_running and held.issuperset(effect.excites)
    ]
    return tuple(item for item in candidates if item.moves)


def free_candidate_of(
    effect: Effect, vessel: Sailing, given: Mapping[str, float] = MappingProxyType({})
) -> FreeCandidate:
    """An effect as free-running records are asked for it; without moves if it has no place.

    Parameters
    ----------
    effect : Effect
        Of the catalogue, or one's own.
    vessel : Sailing
        The model at its speed.
    given : mapping of str to float
        Values of the effect's own that stand in the place of the usual ones.
    """
    moves, part, lag = dict(vessel.moves(effect)), None, ""
    if effect.enters:
        part = _part(effect, vessel, given)
    inner = effect.nonlinear
    if moves and effect.kind == "state" and inner is not None and inner.form is None:
        # Records tell how long a flow remembers once they tell that it does.
        lag = inner.name
        values = {f"{effect.name}.{lag}": 1.0}
        moves[lag] = Move(values=values, typical=0.5 * (inner.grid[-1] - inner.grid[0]))
    return FreeCandidate(
        name=effect.name,
        family=effect.family.replace("_", " "),
        kind="fault" if effect.faulty else "physics",
        summary=effect.summary,
        moves=MappingProxyType({label: move.values for label, move in moves.items()}),
        typical=MappingProxyType({label: move.typical for label, move in moves.items()}),
        part=part,
        options=MappingProxyType(
            {x: y for move in moves.values() for x, y in move.options.items()}
        ),
        begins=MappingProxyType({x: y for move in moves.values() for x, y in move.begins.items()}),
        check=effect.check,
        # What a value is off by, and what a ship has to one side, have none.
        signed=effect.kind not in ("fault", "freed") and effect.family != "asymmetry",
        lag=lag,
    )


def _part(effect: Effect, vessel: Sailing, given: Mapping[str, float]) -> Part:
    """The effect as a part of no size."""
    known = dict(effect.estimates(vessel)) if effect.estimates is not None else {}
    known |= {name: value for name, value in given.items() if effect.parameter(name)}
    inner = effect.nonlinear
    if inner is not None and inner.form is None:
        known[inner.name] = inner.grid[len(inner.grid) // 2]
    return Part(
        effect=effect.name,
        values=MappingProxyType({**known, **dict.fromkeys(effect.typical, 0.0)}),
        source="candidate",
        text=effect.text,
    )


Names = tuple[str, ...]
WIDER: Final = 1.5
"""Standard deviation of a coefficient before, over its usual size."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Numbers:
    """All that may move: the values of the base over their sizes, then coefficients.

    `values`: values of the model, and what the records show wrongly. `T (m, q)`: ``values = T
    numbers``; a coefficient of 1 is `WIDER` times its usual size. `columns`: those of each
    candidate.
    """

    values: tuple[str, ...]
    T: Array
    base: FreeBase
    columns: Mapping[str, NDArray[np.intp]]

    @property
    def width(self) -> int:
        """Number of columns of the base."""
        return len(self.base.known)

    def at(self, names: Sequence[str]) -> NDArray[np.intp]:
        """Columns of candidates."""
        found = [self.columns[name] for name in names]
        return np.concatenate([np.zeros(0, np.intp), *found])

    def used(self, names: Sequence[str]) -> NDArray[np.intp]:
        """Columns of the base and of candidates."""
        return np.concatenate([np.arange(self.width), self.at(names)])

    def moving(self, names: Sequence[str]) -> tuple[Numbers, NDArray[np.intp]]:
        """Those of the base that move, and of candidates, alone; and where each was."""
        order = np.concatenate([np.flatnonzero(self.base.moves), self.at(names)])
        return self._in_order(self.base.moving, names, order), order

    def _in_order(self, base: FreeBase, names: Sequence[str], order: NDArray[np.intp]) -> Numbers:
        """Those of a base, and behind them of candidates."""
        columns, begin = {}, len(base.known)
        for name in names:
            count = len(self.columns[name])
            columns[name] = np.arange(begin, begin + count)
            begin += count
        return replace(self, T=self.T[:, order], base=base, columns=columns)

    def having(self, names: Sequence[str]) -> tuple[Numbers, NDArray[np.intp]]:
        """Those of a base that has some of the candidates, and where each was."""
        rest = [name for name in self.columns if name not in names]
        order = self.used((*names, *rest))
        moved = self._in_order(self.base, (*names, *rest), order)
        columns = {name: moved.columns[name] for name in rest}
        base = self.base.having(len(self.at(names)))
        return replace(moved, base=base, columns=columns), order

    def steps(self, columns: NDArray[np.intp]) -> dict[int, float]:
        """The values that some columns move, and by how much for a slope."""
        size = np.max(np.abs(self.T[:, columns]), axis=1, initial=0.0)
        return {int(i): 1e-3 * float(size[i]) for i in np.flatnonzero(size)}

    @cached_property
    def every(self) -> NDArray[np.intp]:
        """All columns."""
        return np.arange(self.T.shape[1])


def numbers_of(base: FreeBase, candidates: Sequence[FreeCandidate]) -> Numbers:
    """The numbers of a base and of candidates."""
    values = tuple(
        dict.fromkeys((*base.names, *(name for item in candidates for name in item.values)))
    )
    place = {name: i for i, name in enumerate(values)}
    blocks = [np.zeros((len(values), len(base.names)))]
    for j, (name, size) in enumerate(zip(base.names, base.sizes.tolist(), strict=True)):
        blocks[0][place[name], j] = size
    columns, begin = {}, len(base.names)
    for item in candidates:
        block = np.zeros((len(values), len(item.moves)))
        for j, (label, own) in enumerate(item.moves.items()):
            for name, amount in own.items():
                block[place[name], j] = WIDER * item.typical[label] * amount
        blocks.append(block)
        columns[item.name] = np.arange(begin, begin + block.shape[1])
        begin += block.shape[1]
    return Numbers(values=values, T=np.concatenate(blocks, axis=1), base=base, columns=columns)


@dataclass(frozen=True, kw_only=True, eq=False)
class Screen:
    """What is known of candidates when the base is averaged over one spread.

    `normal`: what the records say of their coefficients. `ground`: ln of how probable the
    records are without any. `columns`: places of each candidate.
    """

    normal: Normal
    ground: float
    columns: Mapping[str, NDArray[np.intp]]

    def __call__(self, names: Sequence[str]) -> float:
        """ln of how probable the records are with a set."""
        return self.ground + (self.gain(names) if names else 0.0)

    def gain(self, names: Sequence[str]) -> float:
        """ln evidence of a set against none of it."""
        return self.normal.only(np.concatenate([self.columns[name] for name in names])).log_evidence


def screen(known: WindowInformation, numbers: Numbers, spread: float) -> Screen:
    """The base taken out of what is known."""
    b, P = numbers.width, known.products.sum(axis=0)
    root = numbers.base.root(spread)
    rest, volume = integrated_out(root.T @ P[:b, :b] @ root, root.T @ P[:b, b:], P[b:, b:])
    normal = Normal.of_products(0.5 * (rest + rest.T), known.normal.volume + volume)
    return Screen(
        normal=normal,
        ground=normal.log_density_at(np.zeros(len(rest) - 1)),
        columns={name: at - b for name, at in numbers.columns.items()},
    )


def averaged(values: Sequence[float]) -> float:
    """ln of the mean of probabilities that are given by their logarithms."""
    top = max(values)
    return top + math.log(sum(math.exp(x - top) for x in values) / len(values))


@dataclass(frozen=True, kw_only=True, eq=False)
class WeighedScreens:
    """Screens of one information, one for each spread of the base."""

    screens: tuple[Screen, ...]

    def __call__(self, names: Sequence[str]) -> float:
        """ln of how probable the records are with a set, averaged over the spreads."""
        return averaged([item(names) for item in self.screens])

    def best(self, names: Sequence[str]) -> int:
        """Number of the most probable spread."""
        return int(np.argmax([item(names) for item in self.screens]))


def weighed(known: WindowInformation, numbers: Numbers) -> WeighedScreens:
    """Screens for all spreads of the base."""
    return WeighedScreens(
        screens=tuple(screen(known, numbers, float(x)) for x in numbers.base.spreads)
    )


def probable(
    known: WindowInformation, numbers: Numbers, names: Sequence[str], spread: float
) -> tuple[Array, Array]:
    """The most probable numbers (q,) of a set, zero where they take no part; their covariance."""
    whole = _whole(numbers, names, spread)
    mean, covariance = known.normal.in_terms_of(whole).posterior
    return whole @ mean, whole @ covariance @ whole.T


def damped(
    known: WindowInformation,
    numbers: Numbers,
    names: Sequence[str],
    spread: float,
    begin: Array,
    damping: float,
) -> Array:
    """A step towards the most probable numbers, damped after Levenberg and Marquardt."""
    whole = _whole(numbers, names, spread)
    y = np.linalg.lstsq(whole, begin, rcond=None)[0]
    own = known.normal.in_terms_of(whole)
    H = own.information + np.eye(len(y))
    step = np.linalg.solve(H + damping * np.diag(np.diagonal(H)), own.score - H @ y)
    found: Array = begin + whole @ step
    return found


def _whole(numbers: Numbers, names: Sequence[str], spread: float) -> Array:
    """Numbers of a set over such as are standard normal before."""
    b, at = numbers.width, numbers.at(names)
    root = numbers.base.root(spread)
    whole = np.zeros((len(numbers.every), root.shape[1] + len(at)))
    whole[:b, : root.shape[1]] = root
    whole[at, np.arange(root.shape[1], whole.shape[1])] = 1.0
    return whole


def unlikely(numbers: Numbers, names: Sequence[str], spread: float, z: Array) -> float:
    """Half the sum of squares of some numbers by what is known of them before; infinite where one
    is moved that does not move at this spread."""
    total = float(z[numbers.at(names)] @ z[numbers.at(names)])
    root = numbers.base.root(spread)
    moves = root.any(axis=1)
    if np.any(z[: numbers.width][~moves]):
        return math.inf
    if root.shape[1]:
        own = np.linalg.solve(root[moves], z[: numbers.width][moves])
        total += float(own @ own)
    return 0.5 * total
