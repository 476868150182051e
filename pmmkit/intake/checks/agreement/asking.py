"""How much better the runs agree if something was wrong with one of them, or with all."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, fields, replace
from functools import cached_property
from types import MappingProxyType
from typing import Final

import numpy as np
from numpy.typing import NDArray

from pmmkit.campaigns import Run
from pmmkit.conventions import Ship, Water
from pmmkit.effects import CATALOGUE, Effect, State, Suspect
from pmmkit.inference import log_normal
from pmmkit.intake.checks.agreement.posterior import Agreement, evidence
from pmmkit.intake.checks.agreement.rows import CHANNELS, MAIN, PHASES, RunGroup, phases
from pmmkit.intake.checks.finding import Summary
from pmmkit.numerics import Array

# The runs of a group as the faults of the catalogue see them.


@dataclass(frozen=True, kw_only=True, eq=False)
class Records:
    """All runs of a group; `effects.seen.Observed` says what each word is.

    Forces are histories by channel, (n, 32) with values of the parameters [N, N m], and without
    them what each parameter multiplies, (n, 32, p), over ½ρL²U² of the run [-, m].

    `histories (n, 32, 3, p)`: what each parameter multiplies along the motion, as
    `Group.histories` gives it.
    """

    group: RunGroup
    histories: Array
    value: Array | None = None

    @property
    def ship(self) -> Ship:
        """The model that was tested."""
        return self.group.campaign.ship

    @property
    def water(self) -> Water:
        """The water of the tank."""
        return self.group.campaign.water

    @property
    def motion(self) -> State:
        """Motion of midship at 32 phases of each run."""
        return self.group.motion

    @cached_property
    def heading(self) -> Array:
        """Heading in the tank [rad]."""
        return self.group.heading.ravel()

    @cached_property
    def drift(self) -> Array:
        """Heading about which the model is swung [rad]."""
        return _each([item.run.settings.drift for item in self.group.summaries])

    @cached_property
    def t(self) -> Array:
        """Time within a cycle [s]; 0 in a steady run."""
        period = np.divide(2 * np.pi, self.omega, where=self.omega > 0, out=0.0 * self.omega)
        return period * np.tile(np.arange(PHASES) / PHASES, len(self.group.summaries))

    @cached_property
    def speed(self) -> Array:
        """Speed of the carriage [m/s]."""
        return _each([item.run.settings.speed for item in self.group.summaries])

    @cached_property
    def omega(self) -> Array:
        """Angular frequency of the oscillation [rad/s]; 0 for a steady run."""
        return _each(self.group.omega)

    @cached_property
    def sways(self) -> Array:
        """Whether the rig oscillates the model across the tank."""
        return _each([item.run.kind_of_test.sways for item in self.group.summaries])

    @cached_property
    def yaws(self) -> Array:
        """Whether the rig oscillates the heading."""
        return _each([item.run.kind_of_test.yaws for item in self.group.summaries])

    @property
    def day(self) -> Array:
        """No run is held against another hour of the day here."""
        return np.zeros_like(self.speed)

    @cached_property
    def forces(self) -> Mapping[str, Array]:
        """The forces along the motion, by channel."""
        return self._by_channel(self.histories)

    def along(self, motion: State, *, speed: float | Array | None = None) -> Mapping[str, Array]:
        """The forces if the model, or its carriage, went otherwise."""
        return self._by_channel(self.group.histories(motion, speed=speed))

    def means(self, history: Array) -> Array:
        """Mean of a history over each run."""
        return _each(history.reshape(-1, PHASES).mean(axis=1))

    def project(self, history: Array) -> Array:
        """A history as a force: of no parameter, so that only forces with values know it."""
        if self.value is None:
            raise ValueError(
                "A fault that adds a force of its own is asked with an unknown size: see "
                "Suspect.unknown."
            )
        return history.reshape(-1, PHASES)

    def shaped(self, force: Array, shape: Callable[[Array], Array]) -> Array:
        """A force of which each instant is changed by itself."""
        return shape(force)

    def times(self, force: Array, history: Array) -> Array:
        """A force times a history."""
        return np.asarray(force * history.reshape(-1, PHASES, *(1,) * (force.ndim - 2)))

    def filtered(
        self, factor: Callable[[Array, Array], NDArray[np.complex128]], *channels: str
    ) -> dict[str, Array]:
        """Forces with each harmonic times a factor."""
        gain = factor(np.arange(PHASES // 2 + 1.0)[None, :], self.group.omega[:, None])
        found = {}
        for name in channels or CHANNELS:
            force = self.forces[name]
            shape = gain.reshape(*gain.shape, *(1,) * (force.ndim - 2))
            spectrum = np.fft.rfft(force, axis=1) * shape
            found[name] = np.fft.irfft(spectrum, PHASES, axis=1)
        return found

    def as_histories(
        self, forces: Mapping[str, Array], others: Array, touched: NDArray[np.bool_]
    ) -> Array:
        """Forces of some channels and runs over the units of the group, the rest as in others."""
        out = others.copy()
        for k, name in enumerate(CHANNELS):
            if name in forces:
                shown = _over(forces[name], self._unit(k, forces[name].ndim))
                if touched.all():
                    out[:, :, k] = shown
                else:
                    out[touched, :, k] = shown[touched]
        return out

    def _by_channel(self, histories: Array) -> Mapping[str, Array]:
        shown = histories if self.value is None else histories @ self.value
        return MappingProxyType(
            {
                name: _times(shown[:, :, k], self._unit(k, shown.ndim - 1))
                for k, name in enumerate(CHANNELS)
            }
        )

    def _unit(self, channel: int, dimensions: int) -> float | Array:
        """Unit of a channel over the one in which the group has it, in each run."""
        if self.value is None:
            return self.ship.L if CHANNELS[channel] == "N" else 1.0
        return self.group.units[:, channel].reshape(-1, *(1,) * (dimensions - 1))


def _times(force: Array, unit: float | Array) -> Array:
    return force if isinstance(unit, float) and unit == 1.0 else force * unit


def _over(force: Array, unit: float | Array) -> Array:
    return force if isinstance(unit, float) and unit == 1.0 else force / unit


def _each(of_runs: object) -> Array:
    """What is told of runs, of each of their 32 phases."""
    return np.repeat(np.asarray(of_runs), PHASES)


# What may be wrong with a run or with all: the faults of the catalogue, as checks ask for them.


@dataclass(frozen=True, kw_only=True)
class Suspected(Suspect):
    """A suspect with the fault that it is a form of.

    `effect`: what it does to records.
    """

    effect: Effect

    @property
    def cause(self) -> str:
        """The word by which findings know it: that of the fault, or of the slip itself."""
        return self.name if self.slip else self.effect.name

    def concerns(self, run: Run) -> bool:
        """Whether it can be asked of a run."""
        return bool(run.test) and self.applies(run.kind_of_test)

    def histories(self, records: Records, value: float) -> Array:
        """What each parameter would multiply in the records, (n, 32, 3, p), as told if nothing."""
        told = records.histories
        if self.unknown:
            return told
        shown = self.effect.shown(records, self.at(value))
        return records.as_histories(shown, told, self._touched(records.group))

    def column(self, valued: Records, value: float) -> Array:
        """Harmonics (n, 3, 7) of what its unknown size multiplies, over its standard deviation."""
        slope = self.effect.slopes(valued, self.at(value), [self.unknown])
        shown = valued.as_histories(
            {name: self.spread(value) * own for name, (own,) in slope.items()},
            np.zeros(valued.histories.shape[:-1]),
            self._touched(valued.group),
        )
        return valued.group.design(shown[..., None])[..., 0]

    def _touched(self, group: RunGroup) -> NDArray[np.bool_]:
        return np.array([self.concerns(item.run) for item in group.summaries])


def suspects(effects: Iterable[Effect] | None = None) -> tuple[Suspected, ...]:
    """All forms of the faults of the catalogue, or of some effects, for which the checks ask.

    Examples
    --------
    >>> [item.name for item in suspects([CATALOGUE["fault_misalignment"]])]
    ['drift', 'drift as set']
    """
    every = CATALOGUE.values() if effects is None else effects
    return tuple(
        Suspected(**{part.name: getattr(form, part.name) for part in fields(Suspect)}, effect=own)
        for own in every
        for form in own.suspects
    )


def record_of(run: Run, reference_x: float) -> Suspected:
    """That a record is that of another run, or of one with its settings.

    reference_x [m].
    """
    form = Suspect(
        name="record of another run",
        says=lambda _: (
            f"its file is the record of {run.id} ({', '.join(run.settings.words)}), or of a run "
            f"with those settings: files or settings are exchanged"
        ),
        remedy="Look which file belongs to which run.",
        scope="one",
        slip=True,
    )

    own = Effect(
        name="slip_exchanged_records",
        family="slips",
        kind="fault",
        summary="The record of another run.",
        acts=lambda records, _: records.along(run.motion_at_phase(phases()).moved_aft(reference_x)),
        suspects=(form,),
        remark="a slip that files hold, no formula of a source",
    )
    return suspects([own])[0]


FINER: Final = 4
"""Halvings of the grid about the best value."""
TAILS: Final = ((1.0, 0.9), (2.0, 0.08), (4.0, 0.02))
"""A run may scatter more than its sisters: so many times, with such a chance."""
OCCAM: Final = 2.0
"""Logarithm of what a suspect pays for its freedom, beside its grid."""
STRANGE: Final = 4.0
"""A cause that only the size of derivatives tells must leave none so many deviations from usual."""
REFINED: Final = 5
"""Suspects that are looked at more closely."""
SAME_PERIOD: Final = 0.02

Judge = Callable[[Suspected, float], tuple[float, float]]


@dataclass(frozen=True, kw_only=True)
class Answer:
    """What a suspect explains.

    `suspect`: what may be wrong. `value`: how much of it. `gain`: logarithm of the evidence
    against nothing wrong. `left`: squared misfit that is left over its expected value.
    """

    suspect: Suspected
    value: float
    gain: float
    left: float

    @property
    def words(self) -> str:
        """What would be wrong."""
        return self.suspect.says(self.value)


def of_one(found: Agreement, place: int, suspects: Iterable[Suspected]) -> list[Answer]:
    """What may be wrong with one run, the best explanation first."""
    group = found.group.only([place])
    mean, covariance = found.without(place)
    known = found.group.known[place]
    white = [found.white.whitener[place, c][known[c]] for c in range(3)]
    rows = np.concatenate([found.white.rows[place, c][known[c]] for c in range(3)])
    noise = np.diag(np.concatenate([np.full(known[c].sum(), found.excess[c]) for c in range(3)]))
    told = Records(group=group, histories=group.histories())
    valued = replace(told, value=mean)

    def over(harmonics: Array) -> Array:
        return np.concatenate([white[c] @ harmonics[c] for c in range(3)])

    def judged(suspect: Suspected, value: float) -> tuple[float, float]:
        design = over(group.design(suspect.histories(told, value))[0])
        rest, spread = rows - design @ mean, noise + design @ covariance @ design.T
        if suspect.unknown:
            along = over(suspect.column(valued, value)[0])
            spread = spread + np.outer(along, along)
        left = float(rest @ np.linalg.solve(spread, rest)) / max(len(rest), 1)
        return log_normal(rest, spread), left

    design = over(group.design(told.histories)[0])
    rest, spread = rows - design @ mean, design @ covariance @ design.T
    none = np.logaddexp.reduce(
        [math.log(chance) + log_normal(rest, times**2 * noise + spread) for times, chance in TAILS]
    )
    run = found.group.summaries[place].run
    asked = [
        suspect
        for suspect in (*suspects, *_records_of_others(found, place))
        if suspect.scope != "all" and suspect.concerns(run)
    ]
    return _answers(asked, judged, float(none))


def of_all(
    agreements: Sequence[Agreement], kept: Sequence[Array], suspects: Iterable[Suspected]
) -> list[Answer]:
    """What may be wrong with all runs at all speeds, the best explanation first."""
    groups = [found.group for found in agreements]
    told = [Records(group=group, histories=group.histories()) for group in groups]
    valued = [replace(own, value=found.value) for own, found in zip(told, agreements, strict=True)]

    def judged(suspect: Suspected, value: float) -> tuple[float, float]:
        gains, left = [], []
        for place, (found, group) in enumerate(zip(agreements, groups, strict=True)):
            design = group.design(suspect.histories(told[place], value))
            mean, covariance = group.usual.mean, group.usual.covariance
            scatter = None
            if suspect.unknown:
                column = suspect.column(valued[place], value)
                if suspect.each_run:
                    scatter = column
                else:
                    design = np.concatenate([design, column[..., None]], axis=-1)
                    mean = np.append(mean, 0.0)
                    covariance = np.pad(covariance, (0, 1))
                    covariance[-1, -1] = 1.0
            own, misfit, value_of = evidence(found, design, mean, covariance, kept[place], scatter)
            if suspect.by_size:
                at = [group.usual.names.index(name) for name in MAIN]
                strange = float(np.abs(value_of[at] - group.usual.mean[at]).max())
                misfit = math.inf if strange > STRANGE else misfit
            gains.append(own - nothing[place])
            left.append(misfit)
        return sum(gains) / (len(gains) if suspect.by_size else 1), max(left)

    nothing = []
    for found, own, which in zip(agreements, told, kept, strict=True):
        usual, design = found.group.usual, found.group.design(own.histories)
        nothing.append(evidence(found, design, usual.mean, usual.covariance, which)[0])
    asked = [
        suspect
        for suspect in suspects
        if suspect.scope != "one"
        and any(suspect.concerns(item.run) for group in groups for item in group.summaries)
    ]
    return _answers(asked, judged, 0.0)


def _answers(asked: Sequence[Suspected], judged: Judge, none: float) -> list[Answer]:
    """The suspects that explain most, each at its best value."""
    tried = [{value: judged(suspect, value) for value in suspect.grid} for suspect in asked]
    order = sorted(range(len(asked)), key=lambda k: -max(x for x, _ in tried[k].values()))
    answers = []
    for k in order[:REFINED]:
        suspect = asked[k]
        value, (best, left) = _refined(suspect, tried[k], judged)
        price = OCCAM * suspect.continuous + math.log(len(suspect.grid))
        answers.append(Answer(suspect=suspect, value=value, gain=best - price - none, left=left))
    return sorted(answers, key=lambda answer: -answer.gain)


def _refined(
    suspect: Suspected, given: dict[float, tuple[float, float]], judged: Judge
) -> tuple[float, tuple[float, float]]:
    """The value that explains most, between those of the grid where it may be."""
    tried = dict(given)
    for _ in range(FINER if suspect.continuous else 0):
        order = sorted(tried)
        at = order.index(max(tried, key=lambda value: tried[value][0]))
        for other in (at - 1, at + 1):
            if 0 <= other < len(order):
                middle = 0.5 * (order[at] + order[other])
                tried[middle] = judged(suspect, middle)
    value = max(tried, key=lambda value: tried[value][0])
    return value, tried[value]


def _records_of_others(found: Agreement, place: int) -> list[Suspected]:
    """That the record is that of another run of the group, by its settings."""
    own = found.group.summaries[place]
    return [
        record_of(other.run, found.group.campaign.motion_reference_x)
        for other in found.group.summaries
        if other is not own and other.run.has_nominal and _may_be(own, other)
    ]


def _may_be(one: Summary, other: Summary) -> bool:
    """Whether a record of one may be taken for one of the other: alike in length and period."""
    a, b = one.run.settings.omega or 0.0, other.run.settings.omega or 0.0
    if one.run.dynamic != other.run.dynamic or abs(a - b) > SAME_PERIOD * max(a, b):
        return False
    return one.run.settings != other.run.settings or one.run.test != other.run.test
