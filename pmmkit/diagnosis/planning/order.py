"""The order in which the runs of a programme are made: drawn, in blocks of one set-up of the rig.

What changes through a day beside the settings (the zero of a gauge, the temperature of the water)
must not look like one of them. Runs are therefore made in a drawn order; what is costly to change
stays the same in a block, as in a split-plot design. A drawn order may by chance go with a setting,
so that the one is taken of many whose settings go least with the time of the day: what an order is
judged by is said before it is drawn (Morgan and Rubin 2012). A run that is made twice is made early
and late in its block.

One run of each set-up, the reference run, is made again at the begin, in the middle and at the end
of each day: what it shows otherwise is the day, whatever the order of the settings is.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from itertools import combinations, groupby
from types import MappingProxyType
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from pmmkit.campaigns import RUN_SETTINGS, Settings
from pmmkit.diagnosis.planning.options import Option
from pmmkit.diagnosis.planning.plan_file import entries_of
from pmmkit.numerics import Array
from pmmkit.presentation import counted

DRAWS: Final = 2000
"""Orders that are drawn: of 24 runs of a tanker at three speeds the best has no setting that
correlates with the time by more than 0.10; a single draw has 0.24 (median of 300)."""
APART: Final = 1.0 / 3.0
"""Share of a block by which a run and its repeat are to lie apart."""
DAY: Final = 8.0
"""Hours of work in a tank in a day."""
THREE: Final = 3
"""A reference run is made at the begin, in the middle and at the end of a day."""
FEW: Final = 3
"""Runs that show no day: a block of so few has no reference run, and a day no third one."""
SEED: Final = 1
"""Of the draws: the same programme has the same order every time."""

Places = NDArray[np.intp]


@dataclass(frozen=True, kw_only=True)
class ProgrammeRun:
    """One run of a programme.

    Parameters
    ----------
    number : int
        Its place in the order, from 1.
    option : Option
        The run.
    entry : mapping
        What a campaign file says of it, with a name of its own.
    """

    number: int
    option: Option
    entry: dict[str, Any]

    @property
    def id(self) -> str:
        """Its name."""
        return str(self.entry["id"])

    @cached_property
    def settings(self) -> Settings:
        """What it is set to: the numbers that are written, rounded as they are."""
        stated = {
            item.name: item.to_si(self.entry[item.in_file])
            for item in RUN_SETTINGS.values()
            if item.in_file in self.entry
        }
        return Settings.of(stated)


@dataclass(frozen=True, kw_only=True)
class Programme:
    """Runs in the order in which they are made.

    Parameters
    ----------
    runs : tuple of ProgrammeRun
        The runs.
    drawn : bool
        Whether the order was drawn.
    references : mapping of str to tuple of str
        Names of the runs of each reference run, the first of which is the key.
    """

    runs: tuple[ProgrammeRun, ...]
    drawn: bool = False
    references: Mapping[str, tuple[str, ...]] = field(default_factory=lambda: MappingProxyType({}))

    @classmethod
    def of(
        cls, options: Sequence[Option], *, draw: bool = False, references: bool = False
    ) -> Programme:
        """Runs as they stand, or in a drawn order.

        Parameters
        ----------
        options : sequence of Option
            The runs; one that is there several times is repeated.
        draw : bool
            Whether the order is drawn, in blocks of one set-up.
        references : bool
            Whether a reference run of each set-up is made at the begin, in the middle and at the
            end of each day.

        Examples
        --------
        >>> from pmmkit.diagnosis.planning.options import Limits, options_of
        >>> from pmmkit.models import load_model
        >>> tank = load_model("kvlcc2-l7")
        >>> limits = Limits(speeds=(0.8, 1.2), tests=("static_drift", "pure_sway"))
        >>> made = Programme.of(options_of(limits, tank.ship, tank.water), draw=True)
        >>> swung = [run.option.set_up for run in made.runs]
        >>> len(swung), sum(one != other for one, other in zip(swung, swung[1:]))
        (36, 1)
        >>> every = options_of(limits, tank.ship, tank.water)
        >>> again = Programme.of(every, draw=True, references=True)
        >>> [len(names) for names in again.references.values()]
        [3, 6]
        """
        order = drawn_order(options) if draw else range(len(options))
        kept = [options[place] for place in order]
        chosen: list[Option] = []
        if references:
            kept, chosen = _with_references(kept)
        runs = tuple(
            ProgrammeRun(number=number, option=option, entry=entry)
            for number, (option, entry) in enumerate(
                zip(kept, entries_of(kept), strict=True), start=1
            )
        )
        again = {
            item.id: tuple(run.id for run in runs if run.option.id == item.id) for item in chosen
        }
        return cls(runs=runs, drawn=draw, references=MappingProxyType(again))

    @property
    def hours(self) -> float:
        """Time that it takes [h]."""
        return sum(run.option.hours for run in self.runs)

    @property
    def reference_lines(self) -> tuple[str, ...]:
        """What is said of each reference run, with the time that it takes."""
        known = {run.id: run.option for run in self.runs}
        return tuple(
            f"Reference run {name} ({known[name].words}): at the begin, in the middle and at the "
            f"end of each day, {counted(len(names), 'time')}, {len(names) * known[name].hours:.1f} "
            f"h in all."
            for name, names in self.references.items()
        )


def _with_references(options: Sequence[Option]) -> tuple[list[Option], list[Option]]:
    """Runs in their order with the reference run of each block, and these reference runs."""
    made: list[Option] = []
    chosen = []
    for _, block in groupby(options, key=lambda option: option.set_up):
        own = list(block)
        if len(own) <= FEW:
            made += own
            continue
        reference = _reference(own)
        for _ in range(min(own.count(reference), THREE)):
            own.remove(reference)
        chosen.append(reference)
        begun = sum(option.hours for option in made) % DAY
        for day in _days(own, begun, reference.hours):
            middle = len(day) // 2
            between = [reference] if len(day) > FEW else []
            made += [reference, *day[:middle], *between, *day[middle:], reference]
    return made, chosen


def _days(options: Sequence[Option], begun: float, reference: float) -> list[list[Option]]:
    """Runs by the day on which they are made, of which some hours are gone, three reference runs in
    each."""
    days: list[list[Option]] = [[]]
    left = DAY - begun - THREE * reference
    for option in options:
        if option.hours > left and days[-1]:
            days.append([])
            left = DAY - THREE * reference
        days[-1].append(option)
        left -= option.hours
    return days


def _reference(options: Sequence[Option]) -> Option:
    """A run that is made several times anyway; else of the kind of test that is made most, at the
    speed nearest to the middle one, the run of middle size."""
    ids = Counter(option.id for option in options)
    again = [option for option in options if ids[option.id] > 1]
    counts = Counter(option.test for option in again or options)
    (test, _), *_ = counts.most_common(1)
    own = [option for option in again or options if option.test == test]
    middle = float(np.median([option.settings.speed for option in own]))
    nearest = min(own, key=lambda option: abs(option.settings.speed - middle)).settings.speed
    there = [option for option in own if option.settings.speed == nearest]
    sizes = [item.name for item in RUN_SETTINGS.values() if item.kept and not item.surroundings]
    there.sort(key=lambda x: [abs(x.settings.value(name) or 0.0) for name in sizes])
    return there[len(there) // 2]


def drawn_order(options: Sequence[Option]) -> list[int]:
    """Places of the runs in the order in which they are to be made."""
    count = len(options)
    if count < 2:
        return list(range(count))
    blocks = _numbers(option.set_up for option in options)
    rng = np.random.default_rng(SEED)
    # A place of the block and one within it for each draw: sorting by both keeps blocks together.
    of_block = np.argsort(np.argsort(rng.random((DRAWS, blocks.max() + 1)), axis=1), axis=1)
    orders = np.argsort(of_block[:, blocks] + rng.random((DRAWS, count)), axis=1)
    hours = np.array([option.hours for option in options])[orders]
    times = np.empty(orders.shape)
    np.put_along_axis(times, orders, np.cumsum(hours, axis=1) - hours / 2, axis=1)
    badness = _worst_correlation(times, _factors(options, blocks))
    badness = badness + _too_near(np.argsort(orders, axis=1), options, blocks)
    # An order and its reverse are alike but for rounding: the first of them counts everywhere.
    found: list[int] = orders[int(np.argmin(badness.round(9)))].tolist()
    return found


def _numbers(names: Iterable[str]) -> Places:
    """Each name as a number, equal names as equal numbers."""
    return np.unique(list(names), return_inverse=True)[1].astype(np.intp)


def _factors(options: Sequence[Option], blocks: Places) -> Array:
    """What varies in a programme (f, n): settings, sizes and tests within blocks; the speed."""
    settings = [
        [option.settings.value(item.name) or 0.0 for option in options]
        for item in RUN_SETTINGS.values()
        if item.kept and not item.surroundings
    ]
    tests = _numbers(option.test for option in options)
    kinds = [tests == number for number in range(tests.max() + 1)]
    plain = np.array(settings)
    every = np.vstack([plain, np.abs(plain), np.array(kinds, float)])
    member = (blocks == np.arange(blocks.max() + 1)[:, None]).astype(float)
    # Between blocks what belongs to a set-up goes with the time whatever the order within them.
    within = every - (every @ member.T / member.sum(axis=1)) @ member
    speed = np.array([[option.settings.speed for option in options]])
    rows = np.vstack([within, speed - speed.mean()])
    size = np.linalg.norm(rows, axis=1, keepdims=True)
    scale = np.linalg.norm(np.vstack([every, speed]), axis=1, keepdims=True)
    varies = (size > 1e-9 * scale)[:, 0]
    found: Array = rows[varies] / size[varies]
    return found


def _worst_correlation(times: Array, factors: Array) -> Array:
    """The largest correlation of a factor with the time of the day, of each draw."""
    if not len(factors):
        return np.zeros(len(times))
    away = times - times.mean(axis=1, keepdims=True)
    away /= np.linalg.norm(away, axis=1, keepdims=True)
    found: Array = np.abs(away @ factors.T).max(axis=1)
    return found


def _too_near(places: Places, options: Sequence[Option], blocks: Places) -> Array:
    """By how much a run and its repeat come too near to each other, of each draw."""
    short = np.zeros(len(places))
    alike = _numbers(option.id for option in options)
    for number in range(alike.max() + 1):
        again = np.flatnonzero(alike == number)
        size = np.count_nonzero(blocks == blocks[again[0]])
        for one, other in combinations(again.tolist(), 2):
            gap = np.abs(places[:, one] - places[:, other]) / size
            short = np.maximum(short, APART / (len(again) - 1) - gap)
    return short
