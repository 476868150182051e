"""Sets of effects fitted through the equations, with unknown forces of their own size."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Final

import numpy as np
from numpy.typing import NDArray

from pmmkit.diagnosis.free_running.base import most_likely
from pmmkit.diagnosis.free_running.hypotheses import (
    Names,
    WeighedScreens,
    damped,
    probable,
    unlikely,
    weighed,
)
from pmmkit.diagnosis.free_running.information import Forces, Information, WindowInformation
from pmmkit.diagnosis.free_running.question import RecordQuestion
from pmmkit.diagnosis.free_running.slopes import Sheet
from pmmkit.numerics import Array

STEPS: Final = 15
"""Most steps of a fit."""
SETTLED: Final = 0.05
"""A fit ends when no number moves by more than this share of its standard deviation."""
DAMPED: Final = (0.0, 1e-2, 0.1, 1.0, 10.0, 1e2)
"""Damping of the steps that are tried one after another until the records are more probable; the
next step begins with that, with a little less where the first try was taken and `AGREES`."""
AGREES: Final = 0.75
"""Share of what a linear problem promises of a step from which it holds for a longer one: what
trust regions usually take. It and the promises that `_stepped` heeds spare 48 of 257 linear
problems of HSVA's zigzags."""
PATHS: Final = 2
"""Times that the path of the model as given is told anew."""
WILD: Final = 1e12
"""Slope of what a channel shows over a force from which an unstable motion has no meaning."""
SLACK: Final = 0.5
"""By how much less probable, in ln, a step may leave the records: near the top all is flat."""
FINE: Final = (2.0, 1.4)
"""By which the sizes of unknown forces are varied about those that are nearly right."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Linearised:
    """The linear problem about some numbers.

    `question`: with the starts about which it is made. `columns`: numbers whose slopes it has.
    `held`: rows of its windows, some 25 MB of 13 records; None where they are made when they are
    asked for.
    """

    question: RecordQuestion
    z: Array
    columns: NDArray[np.intp]
    information: Information
    held: list[list[Sheet]] | None = None

    @property
    def sheets(self) -> list[list[Sheet]]:
        """Rows of the windows of each record."""
        return self.question.sheets(self.z, self.columns) if self.held is None else self.held

    @property
    def small(self) -> Linearised:
        """The same without its rows, to be kept beside many others."""
        return replace(self, held=None)

    @property
    def whole(self) -> Linearised:
        """The same with its rows, to be asked for them again and again."""
        return replace(self, held=self.sheets)


@dataclass(frozen=True, kw_only=True, eq=False)
class SetFit:
    """A set fitted through the equations.

    `spread`: most probable spread of the base. `z (q,)`: most probable numbers, zero where they
    take no part. `forces`: unknown forces of the most probable size. `log_probability`: ln of
    how probable the records are, averaged over the spreads of the base. `known`: what each
    record says, under these forces. `place`: the linear problem there.
    """

    names: Names
    spread: float
    z: Array
    covariance: Array
    forces: Forces
    log_probability: float
    known: WindowInformation
    place: Linearised

    @cached_property
    def followed(self) -> RecordQuestion:
        """The question along the path that the sensors tell, as they are read with its numbers."""
        return self.place.question.followed(self.z)

    @property
    def sensors(self) -> Mapping[str, float]:
        """Noise of the sensors."""
        return self.place.question.sensors

    def read_by(self, sensors: Mapping[str, float]) -> SetFit:
        """The same numbers beside records with some noise of the sensors."""
        question = self.place.question.read_by(sensors)
        if question is self.place.question:
            return self
        return replace(self, place=replace(self.place, question=question))

    def weighed(self) -> WeighedScreens:
        """All sets by the linear problem there and under its forces."""
        return weighed(self.known, self.place.question.numbers)


def place_at(
    question: RecordQuestion, z: Array, columns: NDArray[np.intp] | None = None
) -> Linearised:
    """The linear problem about some numbers, with the slopes of some columns or of all."""
    used = question.numbers.every if columns is None else columns
    return _placed(question, z, used, question.sheets(z, used))


def _placed(
    question: RecordQuestion, z: Array, columns: NDArray[np.intp], sheets: list[list[Sheet]]
) -> Linearised:
    information = question.information(sheets, z)
    return Linearised(question=question, z=z, columns=columns, information=information, held=sheets)


def fitted(
    place: Linearised, names: Sequence[str], forces: Forces | None = None, *, whole: bool = False
) -> SetFit:
    """The most probable numbers of a set, by Gauss and Newton from some place.

    Notes
    -----
    Starts and unknown forces are told from each window anew in each step. A step that makes the
    records less probable, by unknown forces of the best size there, is damped.
    """
    numbers = place.question.numbers
    own = numbers.used(names)
    begin = np.zeros_like(place.z)
    begin[own] = place.z[own]
    _, used = numbers.moving(names)
    question = place.question
    if np.any(begin != place.z):
        place = _along(place_at(question.followed(begin), begin, used), names)
        place = place_at(place.question, begin, used)
    else:
        place = place.whole
    found = at_place(place, names, forces, fine=forces is not None)
    stands, forces = _standing(found, place)
    first = 0
    for _ in range(STEPS):
        there = (
            None if _is_settled(found) else _stepped(found, used, stands, forces, DAMPED[first:])
        )
        if there is None:
            break
        place, now, forces, damping, promised = there
        gained, stands, at = now - stands, now, DAMPED.index(damping)
        holds = at == first and gained >= AGREES * promised
        first = max(at - 1, 0) if holds else at
        found = at_place(place, names, found.forces, fine=True)
        if gained < SLACK:
            break
    last = found if _is_settled(found) else _where_it_stands(found, stands)
    last = _with_all(last) if whole else last
    return replace(last, place=last.place.small)


def _with_all(found: SetFit) -> SetFit:
    """The same fit with the slopes of all columns."""
    place = place_at(found.place.question, found.place.z)
    return replace(found, place=place, known=place.information.under(found.forces))


def _is_settled(found: SetFit) -> bool:
    """Whether the linear problem leads nowhere else."""
    std = np.sqrt(np.maximum(np.diagonal(found.covariance), 1e-24))
    away = np.abs(found.z - found.place.z)
    return bool(np.all(away <= SETTLED * np.where(std > 1e-11, std, np.inf)))


def _standing(found: SetFit, place: Linearised) -> tuple[float, Forces]:
    """How probable records and numbers of a place are, in ln, by unknown forces of the best size
    there; and these forces."""

    def value(known: WindowInformation) -> float:
        return known.normal.log_density_at(np.zeros(0))

    question = place.question
    asked = place.information.at(place.z)
    forces, best = most_likely(asked, value, question.least, found.forces, FINE)
    before = unlikely(question.numbers, found.names, found.spread, place.z)
    return best - before, forces


def _where_it_stands(found: SetFit, stands: float) -> SetFit:
    """A fit that no step takes further: not what the linear problem promises from there."""
    numbers = found.place.question.numbers
    promised = found.known.normal.log_density_at(found.z)
    promised -= unlikely(numbers, found.names, found.spread, found.z)
    lower = found.log_probability - max(promised - stands, 0.0)
    return replace(found, z=found.place.z, log_probability=lower)


def _along(place: Linearised, names: Sequence[str]) -> Linearised:
    """The linear problem about the most probable path, unknown forces of the best size on it."""
    _, forces = _standing(at_place(place, names), place)
    return place_at(
        place.question.moved(place.sheets, np.zeros_like(place.z), forces),
        place.z,
        place.question.numbers.used(names),
    )


def first_place(question: RecordQuestion) -> Linearised:
    """The linear problem of the model as it is given, with all slopes."""
    place = place_at(question, np.zeros(len(question.numbers.every)), np.zeros(0, np.intp))
    for _ in range(PATHS):
        place = _along(place, ())
    return place_at(place.question, place.z)


def having(place: Linearised, names: Sequence[str]) -> Linearised:
    """The linear problem of a place, some candidates counted to the base."""
    numbers, order = place.question.numbers.having(names)
    return replace(
        place,
        question=replace(place.question, numbers=numbers),
        z=place.z[order],
        columns=np.flatnonzero(np.isin(order, place.columns)),
        information=place.information.only(order),
    )


def _tried(question: RecordQuestion, z: Array, columns: NDArray[np.intp]) -> Linearised | None:
    """The linear problem about some numbers; None where a little more leads to nowhere at all."""
    with np.errstate(all="ignore"):
        sheets = question.sheets(z, columns)
        largest = max(float(np.max(np.abs(x.forces))) for own in sheets for x in own)
    return _placed(question, z, columns, sheets) if largest < WILD else None


def at_place(
    place: Linearised, names: Sequence[str], forces: Forces | None = None, *, fine: bool = False
) -> SetFit:
    """The most probable numbers of a set by the linear problem of a place."""
    numbers = place.question.numbers
    few, columns = numbers.moving(names)

    def value(known: WindowInformation) -> float:
        return weighed(known, few)(names)

    asked = place.information.only(columns)
    least = place.question.least
    how = {"factors": FINE} if fine else {}
    best, probability = most_likely(asked, value, least, forces, **how)
    known = place.information.under(best)
    spread = float(numbers.base.spreads[weighed(known, numbers).best(names)])
    z, covariance = probable(known, numbers, names, spread)
    return SetFit(
        names=tuple(names),
        spread=spread,
        z=z,
        covariance=covariance,
        forces=best,
        log_probability=probability,
        known=known,
        place=place,
    )


def _stepped(
    found: SetFit,
    columns: NDArray[np.intp],
    stands: float,
    forces: Forces,
    dampings: Sequence[float],
) -> tuple[Linearised, float, Forces, float, float] | None:
    """The linear problem a step further, how it stands there by which forces (`_standing`), by
    which damping, and what was promised; None where no step helps.

    Undamped it goes where the linear problem of a set leads by the unknown forces it needs there,
    damped by those that explain what is missed now. By these the first often leads down: then it is
    not tried (of HSVA's zigzags none of 22 such steps helped). Once a try has failed, shorter ones
    end where they promise nothing.
    """
    place = found.place
    question, numbers = place.question, place.question.numbers
    known = place.information.under(forces)
    about = (known, numbers, found.names, found.spread, place.z)

    def level(z: Array) -> float:
        return known.normal.log_density_at(z) - unlikely(numbers, found.names, found.spread, z)

    begins = level(place.z)
    for damping in dampings:
        z = damped(*about, damping) if damping else found.z
        promised = level(z) - begins
        if promised < 0.0:
            continue
        if promised < SLACK and damping > dampings[0]:
            return None
        moved = question.moved(place.sheets, z - place.z, forces)
        if not moved.sails(z):
            continue
        there = _tried(moved, z, columns)
        if there is None:
            continue
        now, needed = _standing(found, there)
        if now > stands - SLACK:
            return there, now, needed, damping, promised
    return None
