"""Usable segments of a free-running run: without stops, empty rows, gaps and jumps."""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, ClassVar, Final

import numpy as np
from numpy.typing import NDArray

from pmmkit.base import CampaignError
from pmmkit.campaigns.run import Run
from pmmkit.numerics import Array, last_digits, stretches, unwrapped

if TYPE_CHECKING:
    import xarray as xr

Flags = NDArray[np.bool_]
Places = NDArray[np.intp]

SLOW: Final = 2.5
"""Usual intervals of a slow record that are a gap in it."""
SHORTEST: Final = 5.0
HEADING_JUMP: Final = math.radians(2.0)
JUMP_TIME: Final = 0.3
SMALLEST: Final = 0.1
CLEAR: Final = 12.0
STILL: Final = 0.01
_AROUND: Final = 1.5


@dataclass(frozen=True, kw_only=True)
class Jump:
    """A step of a record that the motion about it does not explain.

    `place`: index of the sample after the jump. `size`: step beyond what the motion explains [m
    or rad].
    """

    place: int
    t: float
    size: float


@dataclass(frozen=True, kw_only=True, eq=False)
class Fixes:
    """Places and headings of a free-running record, one after the other.

    Parameters
    ----------
    t, x, y : array (n,)
        Time [s], increasing, and position [m], all finite.
    psi : array (n,)
        Heading, unwrapped [rad].
    speed : float
        Speed of the run [m/s].

    Examples
    --------
    >>> t = np.arange(0, 60, 0.1)
    >>> psi = 0.05 * t - np.radians(6) * (t > 30)
    >>> record = Fixes(t=t, x=0.8 * t + (t > 30) * 0.5, y=0 * t, psi=psi, speed=0.2)
    >>> [round(jump.size, 2) for jump in record.position_jumps()]
    [0.5]
    >>> (found,) = record.heading_jumps()
    >>> round(found.t, 6), round(math.degrees(found.size), 6)
    (30.1, 6.0)
    >>> held = np.where((t > 20) & (t < 21), 16.0, 0.8 * t)
    >>> Fixes(t=t, x=held, y=0 * t, psi=psi, speed=0.2).position_jumps()
    ()
    """

    t: Array
    x: Array
    y: Array
    psi: Array
    speed: float
    GAP: ClassVar[float] = 1.0
    """Time without a sample that is a gap of a usual record [s]."""
    ROUNDS: ClassVar[float] = 2.0
    """Steps of rounded positions over what their last digits are worth together, at most: one of
    the step and one of the velocity about it."""

    @property
    def fresh(self) -> Flags:
        """False where a position repeats the sample before, digit for digit.

        A receiver that has nothing new to say repeats its last position; the next new one then
        seems to jump. Positions whose digits are as coarse as the way between samples, of a ship
        that may lose half of her speed, repeat by themselves.
        """
        way = self.speed * float(np.median(np.diff(self.t))) if len(self.t) > 1 else 0.0
        return _changed(self.x, self.y) | (self.rounding > way / 2.0)

    @cached_property
    def rounding(self) -> Array:
        """`rounded` of its positions."""
        return self.rounded(self.x, self.y)

    @staticmethod
    def rounded(x: Array, y: Array) -> Array:
        """What the last digits of each position are worth together [m].

        Examples
        --------
        >>> Fixes.rounded(np.array([0.3, 12.5]), np.array([0.4, 7.1])).round(3)
        array([0.141, 0.141])
        """
        both: Array = np.hypot(last_digits(x), last_digits(y))
        return both

    @property
    def jump_limit(self) -> float:
        """Smallest step of position that is called a jump: the way of 0.3 s, at least 0.1 m."""
        return max(JUMP_TIME * self.speed, SMALLEST)

    def position_jumps(self, limit: float | None = None) -> tuple[Jump, ...]:
        """Jumps of the position, measured against the velocity about them.

        Repeated positions are passed over first, so that catching up after them is no jump.

        Parameters
        ----------
        limit : float, optional
            Smallest jump [m]; never below 12 times the usual scatter of a step, nor what their
            last digits are worth.
        """
        rows = np.stack([self.x, self.y])
        least = np.maximum(self.jump_limit if limit is None else limit, self.ROUNDS * self.rounding)
        return _jumps(self.t, rows, self.fresh, least)

    def heading_jumps(self, limit: float = HEADING_JUMP) -> tuple[Jump, ...]:
        """Jumps of the heading above a limit [rad], measured against the yaw rate about them."""
        least = np.full(len(self.t), limit)
        return _jumps(self.t, self.psi[None], _changed(self.psi, 0 * self.psi), least)

    def smooth_heading(self, jumps: Sequence[Jump]) -> Array:
        """The heading with its jumps taken out; what went before a jump is left."""
        psi, t = self.psi, self.t
        step = np.diff(psi, prepend=psi[0])
        for jump in jumps:
            around = slice(max(1, jump.place - 15), jump.place + 16)
            rates = step[around] / np.diff(t, prepend=t[0] - 1)[around]
            step[jump.place] = np.median(rates) * (t[jump.place] - t[jump.place - 1])
        smooth: Array = psi[0] + np.cumsum(step)
        return smooth

    @staticmethod
    def stop_at_end(n: Array) -> int:
        """Index from which the propeller stands until the end; the length where it does not.

        Examples
        --------
        >>> Fixes.stop_at_end(np.array([0.0, 10.0, 10.0, 0.0, 0.0]))
        3
        >>> Fixes.stop_at_end(np.array([9.0, 10.0]))
        2
        """
        size = np.abs(np.nan_to_num(n))
        turning = np.flatnonzero(size > STILL * size.max(initial=0.0))
        return int(turning[-1]) + 1 if len(turning) else len(n)


@dataclass(frozen=True, kw_only=True)
class Cut:
    """Where a record is cut, and why.

    Parameters
    ----------
    t_start, t_stop : float
        What is left out [s]; a border without anything left out has the samples on both sides.
    reason : str
        Why, with numbers.
    """

    t_start: float
    t_stop: float
    reason: str

    def __str__(self) -> str:
        return f"{self.t_start:g} to {self.t_stop:g} s: {self.reason}"


@dataclass(frozen=True, kw_only=True)
class Usable:
    """The usable segments of a free-running run.

    `segments`: one run for each segment, called ``ZZ10/1``, ``ZZ10/2`` …; the run itself where
    nothing is cut keeps its name. The data have the heading unwrapped over the whole record (it
    goes on from segment to segment), and ``fresh``: False where x and y only repeat the sample
    before. `cuts`: what lies between them, in order of time.
    """

    segments: tuple[Run, ...]
    cuts: tuple[Cut, ...]


def usable(
    run: Run,
    *,
    gap: float | None = None,
    jump: float | None = None,
    heading_jump: float = HEADING_JUMP,
    shortest: float = SHORTEST,
    cut_stop: bool | None = None,
) -> Usable:
    """Cut a free-running run where its record cannot be used.

    Left out are rows without time, x, y or heading, samples whose time does not go on, the stop
    at the end (propeller at rest until the last sample), positions that stand still for longer
    than `gap` although the ship moves, and segments shorter than `shortest`. Borders are set at
    gaps and at jumps of position and heading, so that no segment contains one. Shorter repeats of
    a position stay in; they are marked in ``fresh``.

    Parameters
    ----------
    run : Run
        A free-running history.
    gap : float, optional
        Longest time without a sample, or without a new position [s]; by default 1 s, or 2.5 times
        the usual interval of a slower record.
    jump : float, optional
        Step of position that the motion does not explain [m]; default `Fixes.jump_limit`. Never
        below 12 times the usual scatter of the record.
    heading_jump : float
        The same for the heading [rad].
    shortest : float
        Segments shorter than this are left out [s].
    cut_stop : bool, optional
        Whether to cut the stop at the end. Default: yes, but not of the tests ``stopping`` and
        ``random``, of which standing propellers are a part.

    Returns
    -------
    Usable
        Segments and cuts.

    Raises
    ------
    CampaignError
        If the run is captive, or has no positions.

    Examples
    --------
    >>> import xarray as xr
    >>> from pmmkit.campaigns.settings import Settings
    >>> t = np.arange(0, 60, 0.1)
    >>> columns = {"x": 0.8 * t + np.where(t > 30, 0.5, 0.0), "y": 0 * t, "psi": 0 * t,
    ...            "n": np.where(t < 50, 10.0, 0.0)}
    >>> data = xr.Dataset({name: ("t", part) for name, part in columns.items()}, {"t": t})
    >>> run = Run(id="T", test="turning", kind="history", settings=Settings(speed=0.8),
    ...           loader=lambda: data)
    >>> found = usable(run)
    >>> [(part.id, part.data.sizes["t"]) for part in found.segments]
    [('T/1', 301), ('T/2', 199)]
    >>> for cut in found.cuts:
    ...     print(cut)
    30 to 30.1 s: the position jumps by 0.50 m
    50 to 59.9 s: the propeller stands until the end
    """
    data = run.data
    t, x, y, psi = _columns(run, data)
    cuts: list[Cut] = []
    kept = _rows(t, (x, y, psi), cuts)
    if cut_stop is None:
        cut_stop = not run.kind_of_test.propeller_stops
    if cut_stop and "n" in data:
        kept = _running(t, np.asarray(data["n"].values, float), kept, cuts)
    if not len(kept):
        return Usable(segments=(), cuts=tuple(cuts))
    time, heading = t[kept], unwrapped(psi[kept])
    if gap is None:
        gap = max(Fixes.GAP, SLOW * float(np.median(np.diff(time)))) if len(time) > 1 else Fixes.GAP
    record = Fixes(t=time, x=x[kept], y=y[kept], psi=heading, speed=run.settings.speed)
    fresh = record.fresh
    parts = _borders(record, (gap, jump, heading_jump), cuts)
    long = []
    for part in parts:
        if time[part[-1]] - time[part[0]] >= shortest:
            long.append(part)
        else:
            reason = f"shorter than {shortest:g} s"
            cuts.append(
                Cut(t_start=float(time[part[0]]), t_stop=float(time[part[-1]]), reason=reason)
            )
    whole = len(long) == 1 and len(long[0]) == len(t)
    segments = tuple(
        run.with_(
            id=run.id if whole else f"{run.id}/{number}",
            loader=_Part(run, kept[part], heading[part], fresh[part]),
        )
        for number, part in enumerate(long, start=1)
    )
    return Usable(segments=segments, cuts=tuple(sorted(cuts, key=lambda cut: cut.t_start)))


@dataclass(frozen=True, eq=False)
class _Part:
    """Loads the samples of a segment."""

    run: Run
    places: Places
    heading: Array
    fresh: Flags

    def __call__(self) -> xr.Dataset:
        data = self.run.data.isel(t=self.places)
        psi = ("t", self.heading, data["psi"].attrs)
        return data.assign(psi=psi, fresh=("t", self.fresh))


def _columns(run: Run, data: xr.Dataset) -> tuple[Array, ...]:
    missing = [name for name in ("x", "y", "psi") if name not in data]
    captive = run.kind_of_test.captive
    if captive or run.kind != "history" or missing:
        why = "it is captive" if captive else f"it has no {', '.join(missing) or 'history'}"
        raise CampaignError(
            f"a {run.test} test has no segments: {why}.",
            run=run.id,
            remedy="Segments are those of free-running histories with t, x, y and psi.",
        )
    return tuple(np.asarray(data[name].values, float) for name in ("t", "x", "y", "psi"))


def _rows(t: Array, others: Sequence[Array], cuts: list[Cut]) -> Places:
    """Rows with all values whose time goes on."""
    good = np.logical_and.reduce([np.isfinite(part) for part in (t, *others)])
    whole = np.flatnonzero(good)
    if len(whole) < len(t):
        known = t[np.isfinite(t)]
        for first, last in _runs(~good):
            times = t[first : last + 1]
            times = times[np.isfinite(times)]
            if not len(times):
                edge = t[first - 1] if first and np.isfinite(t[first - 1]) else known.max(initial=0)
                times = np.array([edge])
            cuts.append(
                Cut(
                    t_start=float(times.min()),
                    t_stop=float(times.max()),
                    reason=f"{last - first + 1} rows without time, position or heading",
                )
            )
    before = np.maximum.accumulate(t[whole])
    forward = np.ones(len(whole), dtype=bool)
    forward[1:] = t[whole][1:] > before[:-1]
    for first, last in _runs(~forward):
        span = t[whole][first : last + 1]
        cuts.append(
            Cut(
                t_start=float(span.min()),
                t_stop=float(span.max()),
                reason=f"{last - first + 1} samples whose time does not go on",
            )
        )
    return whole[forward]


def _running(t: Array, n: Array, kept: Places, cuts: list[Cut]) -> Places:
    stop = Fixes.stop_at_end(n[kept]) if len(kept) else 0
    if stop < len(kept):
        cuts.append(
            Cut(
                t_start=float(t[kept[stop]]),
                t_stop=float(t[kept[-1]]),
                reason="the propeller stands until the end",
            )
        )
    return kept[:stop]


def _borders(
    record: Fixes, limits: tuple[float, float | None, float], cuts: list[Cut]
) -> list[Places]:
    """Indices of the segments between gaps, long stands and jumps."""
    t, fresh, place = record.t, record.fresh, np.stack([record.x, record.y])
    gap, jump, heading_jump = limits
    borders = {0, len(t)}
    out = np.zeros(len(t), dtype=bool)

    def cut(first: int, last: int, reason: str) -> None:
        cuts.append(Cut(t_start=float(t[first]), t_stop=float(t[last]), reason=reason))

    for after in (np.flatnonzero(np.diff(t) > gap) + 1).tolist():
        borders.add(after)
        cut(after - 1, after, f"no sample for {t[after] - t[after - 1]:.1f} s")
    far = record.jump_limit if jump is None else jump
    for first, last in _runs(~fresh):
        ahead = min(last + 1, len(t) - 1)
        moved = float(np.hypot(*(place[:, ahead] - place[:, first - 1])))
        long = t[last] - t[first - 1] > gap
        if long and (moved > far or last + 1 == len(t)) and last > first:
            out[first : last + 1] = True
            borders |= {first, last + 1}
            cut(first, last, f"the position stands still for {t[last] - t[first - 1]:.1f} s")
    for found in record.position_jumps(far):
        borders.add(found.place)
        cut(found.place - 1, found.place, f"the position jumps by {found.size:.2f} m")
    for found in record.heading_jumps(heading_jump):
        borders.add(found.place)
        size = math.degrees(found.size)
        cut(found.place - 1, found.place, f"the heading jumps by {size:.1f}°")
    parts = [np.arange(a, b) for a, b in itertools.pairwise(sorted(borders))]
    return [part for part in parts if not out[part].any()]


def _changed(x: Array, y: Array) -> Flags:
    fresh = np.ones(len(x), dtype=bool)
    fresh[1:] = (np.diff(x) != 0) | (np.diff(y) != 0)
    return fresh


def _jumps(t: Array, rows: Array, fresh: Flags, least: Array) -> tuple[Jump, ...]:
    from scipy.ndimage import median_filter

    places = np.flatnonzero(fresh)
    if len(places) < 8:
        return ()
    span = np.diff(t[places])
    step = np.diff(rows[:, places])
    half = max(3, round(_AROUND / float(np.median(span))))
    usual_rate = median_filter(step / span, size=(1, 2 * half + 1), mode="nearest")
    rest = step - usual_rate * span
    single = np.linalg.norm(rest, axis=0)
    pairs = np.linalg.norm(rest[:, 1:] + rest[:, :-1], axis=0)
    wide = single.copy()
    wide[:-1] = np.maximum(wide[:-1], pairs)
    wide[1:] = np.maximum(wide[1:], pairs)
    limit = np.maximum(least[places[1:]], CLEAR * float(np.median(single)))
    found = []
    for first, last in _runs(wide > limit):
        inside = np.arange(first, last + 1)
        large = inside[single[inside] > limit[inside]]
        if not len(large):
            large = inside[[int(np.argmax(single[inside]))]]
        for at in large:
            size = float(single[at] if len(large) > 1 else wide[at])
            after = int(places[at + 1])
            found.append(Jump(place=after, t=float(t[after]), size=size))
    return tuple(found)


def _runs(flags: Flags) -> list[tuple[int, int]]:
    """First and last index of each stretch that is true."""
    return [(int(a), int(b) - 1) for a, b in zip(*stretches(flags), strict=True)]
