"""What may be missing of a free-running ship's model, from the catalogue: terms, values, faults."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from types import MappingProxyType
from typing import Final, Literal

from pmmkit.base import DataError
from pmmkit.effects import CATALOGUE, HULL, INERTIA, OUTSIDE, Effect
from pmmkit.identification import ONE_SEA, FreeRecord
from pmmkit.models import Model, Part, Sailing

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
    coefficient of 1. Values are named as in `identify`, with ``current_x``, ``current_y`` and
    ``rudder_zero``. `typical`: usual size of each coefficient. `part`: what the model is given
    to have these values, where it lacks them. `options, begins`: what parts of the model are
    told to use these values, and what these are then, as in `effects.seen.Move`. `check`: a run
    that tells it from others, in words.
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


def why_not_asked(effect: Effect, model: Model, records: Sequence[FreeRecord]) -> str:
    """Why records are not asked for an effect, in words; empty where they are."""
    if effect.not_free_running or not effect.asked_in_free_running:
        return effect.not_free_running or "it moves nothing that such records show"
    held = excited(model, records)
    lacking = [effect.EXCITES[word] for word in effect.excites if word not in held]
    if lacking:
        return f"these records lack {' and '.join(lacking)}"
    if not free_candidate_of(effect, Sailing(model, records[0].speed)).moves:
        return "the model has no place for it"
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
    candidates = [
        free_candidate_of(effect, vessel, given)
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
    moves, part = vessel.moves(effect), None
    if effect.enters:
        part = _part(effect, vessel, given)
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
