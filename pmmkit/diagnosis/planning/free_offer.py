"""What manoeuvres would tell beside free-running records, by the diagnosis of records."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from types import MappingProxyType
from typing import Final

import numpy as np
from numpy.typing import NDArray

from pmmkit.base import DataError, SimulationError
from pmmkit.diagnosis.free_running.diagnose import FreeSystem
from pmmkit.diagnosis.free_running.fits import SetFit, fitted
from pmmkit.diagnosis.free_running.hypotheses import WIDER, FreeCandidate, probable, screen, weighed
from pmmkit.diagnosis.free_running.information import WindowInformation
from pmmkit.diagnosis.free_running.settling import follow
from pmmkit.diagnosis.free_running.windows import WINDOW, stretches_of
from pmmkit.diagnosis.planning.options import Option
from pmmkit.diagnosis.planning.planned_records import FreeOption, planned_record, sea_of
from pmmkit.diagnosis.planning.separation import Likely, UsualEffects
from pmmkit.effects import CURRENT, OUTSIDE
from pmmkit.identification import FreeRecord
from pmmkit.numerics import Array
from pmmkit.presentation import counted

IMPOSSIBLE: Final = 1e-12
"""Share of a spread of the base that even a large surprise would not bring back."""
SAME: Final = 0.02
"""Share of what a manoeuvre tells by which it must differ on another course to be offered there."""
TOLD: Final = 20
"""Manoeuvres between two lines of progress."""


@dataclass(frozen=True, kw_only=True, eq=False)
class FreeOffer:
    """Manoeuvres, by what the records that are made tell.

    `system`: records, model and candidates. `given`: faults of the records that are known.
    `options`: manoeuvres that could be made, by name, with the time they take. `products (q,
    q)`: what each would tell of the numbers.
    """

    system: FreeSystem
    given: tuple[str, ...]
    options: Mapping[str, Option]
    products: Mapping[str, Array]

    @cached_property
    def candidates(self) -> dict[str, FreeCandidate]:
        """Who takes part, by name."""
        return {item.name: item for item in self.system.every if item.name not in self.given}

    @property
    def names(self) -> tuple[str, ...]:
        """Effects that take part."""
        return tuple(self.candidates)

    def check(self, name: str) -> str:
        """What settles an effect at the bench or on the rig."""
        return self.candidates[name].check

    def least(self, _: Option, /) -> int:
        """Once: each record has a start and unknown forces of its own."""
        return 1

    def likely(self, names: Sequence[str]) -> tuple[Likely, ...]:
        """A set of effects as the records leave it, for each spread of the base."""
        every = (*self.given, *names)
        fit, numbers = self.system.fit(every), self.system.question.numbers
        values = [item(every) for item in weighed(fit.known, numbers).screens]
        top = max(values)
        shares = [math.exp(value - top) for value in values]
        places = numbers.used(every)
        found = []
        for share, spread in zip(shares, numbers.base.spreads.tolist(), strict=True):
            if share < IMPOSSIBLE:
                continue
            z, covariance = probable(fit.known, numbers, every, spread)
            found.append(
                Likely(
                    share=share / sum(shares),
                    places=places,
                    mean=z[places],
                    covariance=covariance[np.ix_(places, places)],
                )
            )
        return tuple(found)

    def added(self, run: str, times: int) -> Array:
        """Rows of unit covariance that stand for a manoeuvre."""
        sizes, vectors = np.linalg.eigh(self.products[run])
        found: Array = np.sqrt(times * np.maximum(sizes, 0.0))[:, None] * vectors.T
        return found

    @cached_property
    def _null(self) -> SetFit:
        return fitted(self.system.place, self.given, whole=True)

    @cached_property
    def usual(self) -> UsualEffects:
        """Effects at their usual sizes."""
        seen = screen(self._null.known, self.system.question.numbers, self._null.spread)
        sizes = np.zeros((len(seen.normal.score), len(self.names)))
        groups = []
        for number, name in enumerate(self.names):
            at = seen.columns[name]
            sizes[at, number] = 1.0 / WIDER
            groups.append((at[None], np.array([number])))
        return UsualEffects(names=self.names, sizes=sizes, groups=tuple(groups))

    def _gram(self, run: str | None, times: int) -> Array:
        """Information on all candidates, the base averaged over, after a manoeuvre."""
        fit = self._null
        total = fit.known.products.sum(axis=0)
        if run is not None:
            total[:-1, :-1] += times * self.products[run]
        known = WindowInformation(
            products=total[None], volumes=np.zeros(1), owners=np.zeros(1, np.int64)
        )
        return screen(known, self.system.question.numbers, fit.spread).normal.information

    def signals(self, run: str | None = None, times: int = 1) -> Array:
        """Squared signal over noise of each effect after a manoeuvre."""
        return self.usual.signals(self._gram(run, times))

    def separations(self, run: str | None = None, times: int = 1) -> Array:
        """The part of it that no size of another explains, after a manoeuvre."""
        return self.usual.separations(self._gram(run, times))


def free_offer(
    system: FreeSystem,
    names: Sequence[str],
    options: Sequence[FreeOption],
    *,
    given: Sequence[str] = (),
    rivals: Sequence[str] | None = None,
    wait: float,
    tell: Callable[[str], None],
) -> FreeOffer:
    """Manoeuvres sailed with the best set, and what each would tell.

    wait [s].
    """
    fit = system.fit((*given, *names))
    sea = sea_of(system, fit)
    numbers = system.question.numbers
    columns = numbers.every if rivals is None else numbers.used((*given, *rivals))
    records: dict[str, FreeRecord] = {}
    offered: dict[str, Option] = {}
    for number, option in enumerate(options, 1):
        if number % TOLD == 1:
            tell(f"Sailing manoeuvres {number} to {min(number + TOLD - 1, len(options))}")
        try:
            record = planned_record(sea, option)
        except (SimulationError, DataError):
            continue
        seconds, pace = float(record.t[-1] - record.t[0]), record.speed / system.model.ship.L
        records[option.id] = record
        offered[option.id] = option.lasting(seconds, wait, pace)
    if not offered:
        raise DataError(
            "The ship can make none of these manoeuvres: give speeds that the model's values cover."
        )
    tell(f"What {counted(len(offered), 'manoeuvre')} would tell")
    told = _products(system, fit, list(records.values()), columns)
    products = _unlike(dict(zip(records, told, strict=True)), options)
    return FreeOffer(
        system=system,
        given=tuple(given),
        options=MappingProxyType({name: offered[name] for name in products}),
        products=MappingProxyType(products),
    )


def _unlike(products: Mapping[str, Array], options: Sequence[FreeOption]) -> dict[str, Array]:
    """Without the manoeuvres that tell the same as on the course of the records."""
    plain = {option.id: replace(option, course=0.0).id for option in options}
    found = {}
    for name, own in products.items():
        other = products.get(plain[name], own)
        apart = float(np.linalg.norm(own - other))
        if plain[name] == name or apart > SAME * float(np.linalg.norm(other)):
            found[name] = own
    return found


def _products(
    system: FreeSystem, fit: SetFit, records: Sequence[FreeRecord], columns: NDArray[np.intp]
) -> Iterator[Array]:
    """What planned records would tell of the numbers, by slopes about a fit."""
    question = system.question
    window = WINDOW if system.window is None else system.window * system.speed / system.model.ship.L
    stretches = stretches_of(
        question.model,
        records,
        question.numbers.values,
        sensors=question.sensors,
        window=window,
        extrapolate=system.extrapolate,
    )
    change = question.numbers.T @ fit.z
    # Planned columns show the ship as she is: no fault of the instruments is in them.
    instruments = [name for name in OUTSIDE if name not in (*CURRENT, "rudder_zero")]
    plain = np.where(np.isin(question.numbers.values, instruments), 0.0, change)
    for stretch in stretches:
        asked = replace(question, stretches=(follow(stretch, plain, question.sensors),))
        known = asked.information(asked.sheets(fit.z, columns), fit.z).under(fit.forces)
        yield known.normal.information
