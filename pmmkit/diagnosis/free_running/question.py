"""Records, a model and what it may lack, made into one linear problem about any values."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Final

import numpy as np
from numpy.typing import NDArray

from pmmkit.base import DataError
from pmmkit.campaigns import Campaign
from pmmkit.diagnosis.free_running.base import FreeBase, usual_forces
from pmmkit.diagnosis.free_running.hypotheses import FreeCandidate, Numbers, numbers_of
from pmmkit.diagnosis.free_running.information import Forces, Information, information_of
from pmmkit.diagnosis.free_running.settling import follow, moved_along, settled, told_anew
from pmmkit.diagnosis.free_running.slopes import Sheet, sheets_of
from pmmkit.diagnosis.free_running.windows import (
    SHORT,
    WINDOW,
    RecordWindows,
    joined,
    sailed,
    stretches_of,
)
from pmmkit.equations import State
from pmmkit.identification import FreeRecord, free_records
from pmmkit.models import Model
from pmmkit.numerics import Array

PACE: Final = 0.04
"""Time between the instants of a record in ship lengths over the speed; finer ones are averaged."""
ROUND: Final = 1.5
"""Error of heading [rad] from which a motion is lost."""


def records_of(records: Sequence[FreeRecord] | Campaign, model: Model) -> Sequence[FreeRecord]:
    """Records as they are given, or those of a campaign."""
    listed = (
        [
            record
            for run in records.runs
            for record in free_records(
                run, model, depth=records.depth_of(run), campaign=records.title
            )
        ]
        if isinstance(records, Campaign)
        else records
    )
    if not listed:
        raise DataError("There is no record: give free-running tests that have a usable segment.")
    return [item.measured_once for item in listed]


@dataclass(frozen=True, kw_only=True, eq=False)
class RecordQuestion:
    """What is asked of records.

    `model`: with a place for every candidate. `numbers`: all that may move. `stretches`: the
    records in windows. `short`: the same in short windows, from which the sensors tell how the
    ship went. `sensors`: standard deviation of each channel, at an instant
    of the record whose instants are means of the fewest samples. `stated`: of those that are known.
    `least (f,)`: what unknown forces may not fall below, over ½ρLdU² (½ρL²dU²). `outliers`:
    averages that were left out.
    """

    model: Model
    numbers: Numbers
    stretches: tuple[RecordWindows, ...]
    short: tuple[RecordWindows, ...]
    sensors: Mapping[str, float]
    stated: Mapping[str, float]
    least: Array
    outliers: int

    def sheets(self, z: Array, columns: NDArray[np.intp]) -> list[list[Sheet]]:
        """The linear problem about some numbers, with the slopes of some columns."""
        steps = self.numbers.steps(columns)
        change = self.numbers.T @ z
        return [sheets_of(item, change, steps) for item in self.stretches]

    def information(self, sheets: Sequence[Sequence[Sheet]], z: Array) -> Information:
        """What the records say of the numbers, by slopes about some of them."""
        found = information_of(
            sheets, [item.channels for item in self.stretches], self.sensors, self.numbers.T @ z
        )
        return found.of_columns(self.numbers.T)

    def sails(self, z: Array) -> bool:
        """Whether no motion is lost with some numbers: none turns the other way."""
        return next(self.lost(z), None) is None

    def lost(self, z: Array) -> Iterator[int]:
        """Numbers of the records whose motion is lost with some numbers."""
        change = self.numbers.T @ z
        for number, item in enumerate(self.stretches):
            heading = sailed(item, change)[:, State.psi]
            turned = np.abs(heading - np.interp(item.record.t, *_measured(item)))
            if not np.all(turned < ROUND):
                yield number

    def followed(self, z: Array) -> RecordQuestion:
        """The same along the path that the sensors tell, as they are read with some numbers."""
        change = self.numbers.T @ z
        short = (follow(item, change, self.sensors) for item in self.short)
        return replace(
            self, stretches=tuple(follow(joined(x), change, self.sensors) for x in short)
        )

    def told(self, z: Array) -> Mapping[str, float]:
        """Noise of the sensors, as the records tell it that are read with some numbers."""
        return told_anew(
            self.short, self.numbers.T @ z, self.sensors, self.stated, self.model.ship.L
        )

    def read_by(self, sensors: Mapping[str, float]) -> RecordQuestion:
        """The same with some noise of the sensors."""
        return self if sensors is self.sensors else replace(self, sensors=sensors)

    def moved(
        self, sheets: Sequence[Sequence[Sheet]], step: Array, forces: Forces
    ) -> RecordQuestion:
        """The same along the most probable path after a step in the numbers, by sheets from before
        it and with unknown forces."""
        change = self.numbers.T @ step
        return replace(
            self,
            stretches=tuple(
                moved_along(item, own, self.sensors, change, forces)
                for item, own in zip(self.stretches, sheets, strict=True)
            ),
        )


def _measured(stretch: RecordWindows) -> tuple[Array, Array]:
    """Instants at which the heading was measured, and headings."""
    psi = stretch.record.measured["psi"]
    there = np.isfinite(psi)
    return stretch.record.t[there], psi[there]


def paced(record: FreeRecord, L: float) -> tuple[FreeRecord, int]:
    """A record at instants `PACE` apart, its measurements averaged about each of them, and of how
    many samples.

    L [m].
    """
    step = float(np.median(np.diff(record.t)))
    # An odd number: an average over an even one lies between two instants.
    every = max(2 * round((PACE * L / record.speed / step - 1.0) / 2.0) + 1, 1)
    if every == 1:
        return record, every
    kernel = np.ones(every)
    means = {}
    for name, x in record.measured.items():
        there = np.isfinite(x)
        count = np.convolve(there.astype(float), kernel, mode="same")
        total = np.convolve(np.where(there, x, 0.0), kernel, mode="same")
        # Next to a gap or an end the average is not one about its instant.
        means[name] = np.where(count == every, total / every, np.nan)
    return record.with_(measured=means).at(slice(every, len(record) - every, every)), every


def question_of(
    model: Model,
    records: Sequence[FreeRecord],
    candidates: Sequence[FreeCandidate],
    base: FreeBase,
    *,
    floor: float,
    window: float | None,
    sensors: Mapping[str, float] | None,
    extrapolate: bool,
    tell: Callable[[str], None],
) -> RecordQuestion:
    """The question that records are asked."""
    if len(records) < 2:
        raise DataError(
            "A diagnosis leaves out one record after another: give at least two of them."
        )
    large = model
    for item in candidates:
        large = item.added_to(large)
    numbers = numbers_of(base, candidates)
    tell(f"Starts and noise of {len(records)} records")
    length = (WINDOW if window is None else window * records[0].speed / model.ship.L) / SHORT

    def cut(chosen: Sequence[FreeRecord], noise: Mapping[str, float]) -> tuple[RecordWindows, ...]:
        return stretches_of(
            large,
            chosen,
            numbers.values,
            sensors=noise,
            samples=samples,
            window=length,
            extrapolate=extrapolate,
        )

    at_pace = [paced(item, large.ship.L) for item in records]
    fewest = min(count for _, count in at_pace)
    samples = [count / fewest for _, count in at_pace]
    short, noise, outliers = settled(
        large, [record for record, _ in at_pace], samples, cut, sensors or {}
    )
    still = np.zeros(len(numbers.values))
    longer = [follow(joined(item), still, noise) for item in short]
    return RecordQuestion(
        model=large,
        numbers=numbers,
        stretches=tuple(longer),
        short=short,
        sensors=noise,
        stated=sensors or {},
        least=floor * usual_forces(large, records),
        outliers=outliers,
    )
