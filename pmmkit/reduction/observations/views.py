"""Runs as the diagnosis looks at them: harmonics of forces, and how to project a history."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, fields, replace
from functools import cached_property, partial
from itertools import accumulate, compress, pairwise
from types import MappingProxyType
from typing import TYPE_CHECKING, Final, Literal, Protocol

import numpy as np
from numpy.typing import NDArray

from pmmkit.base import DataError, Workers, each, opened
from pmmkit.campaigns import Campaign, Rig, Run, TankRecord
from pmmkit.conventions import CHANNELS, Ship, Water
from pmmkit.effects import State
from pmmkit.numerics import Array, one_thread
from pmmkit.reduction.observations.prepare import PreparedRun, places_of

if TYPE_CHECKING:
    import xarray as xr


Noise = Literal["record", "repeats", "stated", "numerical", "unknown"]
"""Where the noise of a channel is known from."""
RECORD: Final[Mapping[str, Noise]] = MappingProxyType({})
FLOOR: Final = 0.005
"""What is too small to matter in measured forces, over the rms force of a channel."""


@dataclass(frozen=True, kw_only=True, eq=False)
class View:
    """One piece of a run: a steady mean, the cycles that count, or an early cycle.

    Parameters
    ----------
    run : Run
        The run it comes from.
    early : bool
        Whether this is the earliest cycle that is used of an oscillating run.
    projection : array (m, n)
        From n samples to the mean (m = 1) or the harmonics C0, C1, S1 …
    motion : State
        Motion of midship at the samples.
    t : array (n,)
        Time since the record began [s].
    force : mapping of channel to array (m,)
        Force of the water at midship [N, N m].
    covariance : mapping of channel to array (m, m)
        Of its noise.
    heading : array (n,)
        Heading of the model in the tank [rad].
    labels : tuple of str (m,)
        C0, C1, S1 …
    noise : mapping of channel to str
        Where a covariance comes from that is not that of a record: the repeats of the campaign,
        what it states, the numerical uncertainty; ``unknown`` where it is zero for want of
        anything better.
    every : array (k, n), optional
        The projection onto all harmonics, where a table lacks some of them.
    kept : array of bool (k,), optional
        Which of them it has.
    expected : mapping of channel to array (k,)
        All harmonics of the forces that a fitted base predicts; empty before the fit.
    day : float
        Where the run stands between the first (0) and the last (1) of its campaign.
    repeated : mapping of channel to float
        Scatter of the campaign's repeats of this kind of run, else of the other kind [N, N m]:
        standard deviation of a mean or of each harmonic; without channels that nothing repeats.
    """

    run: Run
    early: bool
    projection: Array
    motion: State
    t: Array
    force: Mapping[str, Array]
    covariance: Mapping[str, Array]
    heading: Array
    labels: tuple[str, ...] = ()
    noise: Mapping[str, Noise] = field(default_factory=lambda: RECORD)
    every: Array | None = None
    kept: NDArray[np.bool_] | None = None
    expected: Mapping[str, Array] = field(default_factory=lambda: MappingProxyType({}))
    day: float = 0.0
    repeated: Mapping[str, float] = field(default_factory=lambda: MappingProxyType({}))

    def known(self, channel: str) -> bool:
        """Whether anything is known of the noise of a channel."""
        return self.noise.get(channel, "record") != "unknown"

    @property
    def speed(self) -> float:
        """Carriage speed [m/s]."""
        return self.run.settings.speed

    @cached_property
    def omega(self) -> float:
        """Angular frequency of the oscillation [rad/s]; 0 for a static run."""
        return (self.run.settings.omega or 0.0) if self.run.dynamic else 0.0

    @property
    def instants(self) -> Array:
        """Time of the samples [s]; one cycle where a table stands for a record."""
        if not self.omega or np.ptp(self.t) > 0.0:
            return self.t
        step = 2 * math.pi / self.omega / len(self.t)
        return step * np.arange(len(self.t), dtype=np.float64)

    @property
    def rows(self) -> int:
        """Number of harmonics."""
        return len(self.projection)

    def project(self, history: Array) -> Array:
        """Mean or harmonics of a history (n,) or (n, q)."""
        found: Array = self.projection @ history
        return found

    @property
    def whole(self) -> Array:
        """The projection onto all harmonics (k, n), those too that the forces lack."""
        return self.projection if self.every is None else self.every

    def harmonics(self, history: Array) -> Array:
        """C0, C1, S1 … of a history (n,) or (n, q), those too that the forces lack."""
        found: Array = self.whole @ history
        return found

    @cached_property
    def basis(self) -> Array:
        """From all harmonics to the samples, (n, k): what `harmonics` undoes."""
        return np.asarray(np.linalg.pinv(self.whole), float)

    def moved(self, motion: State, speed: float) -> View:
        """All its harmonics, if the model and its carriage [m/s] went otherwise."""
        run = self.run
        if speed != self.speed:
            run = replace(run, settings=replace(run.settings, speed=speed))
        return replace(self, run=run, motion=motion, projection=self.whole, every=None, kept=None)

    @property
    def places(self) -> list[int]:
        """Where its harmonics stand among C0, C1, S1, C2 …"""
        return places_of(self.labels)

    def pick(self, harmonics: Array) -> Array:
        """Of all harmonics those that the forces have."""
        return harmonics if self.kept is None else harmonics[self.kept]

    @property
    def has_mean(self) -> bool:
        """Whether the first row is a mean."""
        return self.kept is None or bool(self.kept[0])

    @classmethod
    def of(
        cls,
        campaign: Campaign,
        *,
        unknown_noise: bool = False,
        pieces: bool = True,
        executor: Workers = None,
    ) -> tuple[View, ...]:
        """All runs of a captive campaign, oscillating ones in two pieces.

        Parameters
        ----------
        campaign : Campaign
            Captive tests.
        unknown_noise : bool
            Keep the forces of tables, which state no noise. Their covariance is that of repeats in
            the campaign, else of the gauges as stated, else the numerical uncertainty; else it is
            zero, and `View.known` says so. Harmonics that a table lacks are left out.
        pieces : bool
            Whether long records are cut in two; False takes each as the reduction does.
        executor : int, str or concurrent.futures.Executor, optional
            Who reads the runs, as for `reduce_campaign`; by default this process alone.

        Returns
        -------
        tuple of View
            The first cycle is left out; of four cycles or more the second is a piece of its own: it
            shows what dies away. Noise is pooled over runs of one speed and kind, channel by
            channel.

        Raises
        ------
        DataError
            If the campaign is not captive.
        CampaignError
            If its runs were made at several depths of the water.
        """
        if campaign.kind != "captive":
            raise DataError("Forces are diagnosed in captive tests; this campaign is free-running.")
        campaign = campaign.at_one_depth()
        lean = campaign.with_(runs=(), excluded=())
        work = partial(_views, campaign=lean, rig=lean.rig, keep=unknown_noise, pieces=pieces)
        names = [f"run {run.id}" for run in campaign.runs]
        with opened(executor) as ready, one_thread():
            own = dict(each(work, campaign.runs, ready, names=names))
        found = [
            replace(view, day=day)
            for place, day in enumerate(campaign.places_in_day)
            for view in own[place]
        ]
        pooled = _pooled(found)
        return tuple(_with_noise(pooled, campaign) if unknown_noise else pooled)


def _views(run: Run, campaign: Campaign, rig: Rig, keep: bool, pieces: bool) -> list[View]:
    """The views of a run, without its samples."""
    if pieces:
        found = _pieces(run, campaign, rig, keep)
    else:
        found = [_view(PreparedRun.of(run, campaign), rig, keep)]
    return [replace(view, run=run.with_(settings=view.run.settings)) for view in found]


def _pieces(run: Run, campaign: Campaign, rig: Rig, keep: bool) -> list[View]:
    """The run as a reduction takes it; a long record in two pieces, its second cycle and the rest.

    A window that the campaign file states is one piece.

    Cycles count from where the carriage is at its speed.

    Noise is that of all cycles but the first together; that of a piece goes with the inverse of
    its cycles.
    """
    stated = any(item.action == "window" for item in run.corrections)
    if run.kind != "history" or not run.dynamic or stated:
        return [_view(PreparedRun.of(run, campaign), rig, keep)]
    data = _at_speed(run)
    run = run.with_(loader=lambda: data)
    times = np.asarray(data["t"].values, float)
    omega = run.settings.omega or 1.0
    covered = (times[-1] - times[0]) * omega / (2 * math.pi)
    for count in (int(covered + 0.5), int(covered + 0.5) - 1):
        if count < 4:
            return [_view(PreparedRun.of(run, campaign), rig, keep)]
        try:
            return _cycles(run, campaign, rig, keep, count)
        except DataError:
            continue
    return [_view(PreparedRun.of(run, campaign), rig, keep)]


def _at_speed(run: Run) -> xr.Dataset:
    """The data of a history without a ramp and a stop of the carriage."""
    data = run.data
    names = [name for name in CHANNELS if name in data]
    if not names:
        return data
    record = np.stack([np.asarray(data[name].values, float) for name in names])
    times = np.asarray(data["t"].values, float)
    travel = TankRecord(run=run, data=data, times=times, forces=record, names=names).travel
    return data.isel(t=slice(travel.start, travel.stop)) if travel.reason else data


def _cycles(run: Run, campaign: Campaign, rig: Rig, keep: bool, count: int) -> list[View]:
    whole = _view(PreparedRun.of(run, campaign, cycles=(2, count)), rig, keep)
    found = []
    for first, last, early in ((2, 2, True), (3, count, False)):
        cut = PreparedRun.of(whole.run, campaign, cycles=(first, last), noise=False)
        piece = _view(cut, rig, True)
        wider = (count - 1.0) / (last - first + 1.0)
        noise = {name: wider * x for name, x in whole.covariance.items()}
        force = {name: x for name, x in piece.force.items() if name in whole.force}
        found.append(replace(piece, force=force, covariance=noise, early=early))
    return found


def _view(prepared: PreparedRun, rig: Rig, keep: bool) -> View:
    result = prepared.result
    motion = prepared.motion_at_midship(rig)
    measured = prepared.water_force(rig)
    # A record that was smoothed has no noise of its own; the scatter between runs has it.
    smoothed = result.smoothed is not None
    rows = _there(measured) if keep or smoothed else np.full(len(result.labels), True)
    force = {name: x[rows] for name, x in measured.items() if np.isfinite(x[rows]).all()}
    nothing = np.zeros((len(rows), len(rows)))
    covariance = {
        name: item[np.ix_(rows, rows)]
        for name in force
        if (item := nothing if smoothed else result.covariance.get(name)) is not None
    }
    return View(
        run=result.run,
        early=False,
        projection=prepared.projection[rows],
        motion=motion,
        t=prepared.t - prepared.begin,
        covariance=covariance,
        force=force if keep else {name: force[name] for name in covariance},
        heading=_heading(result.run, motion),
        every=None if rows.all() else prepared.projection,
        kept=None if rows.all() else rows,
        labels=tuple(label for label, there in zip(result.labels, rows, strict=True) if there),
    )


def _there(measured: Mapping[str, Array]) -> NDArray[np.bool_]:
    """Harmonics that every channel has which has any."""
    finite = np.array([np.isfinite(values) for values in measured.values()])
    return np.asarray(finite[finite.any(axis=1)].all(axis=0), bool)


def _heading(run: Run, motion: State) -> Array:
    """Heading in the tank: drift, and the integral of a harmonic yaw rate."""
    omega = run.settings.omega if run.dynamic else None
    turned = -motion.rdot / omega**2 if omega else np.zeros_like(motion.u)
    return run.settings.drift + turned


def _pooled(views: Sequence[View]) -> list[View]:
    """Covariances averaged over pieces of one speed, frequency and kind."""
    kin: dict[tuple[object, ...], list[int]] = {}
    for place, view in enumerate(views):
        key = (
            round(math.log(view.speed), 2),
            round(view.omega / view.speed, 1),
            view.rows,
            view.early,
        )
        kin.setdefault(key, []).append(place)
    made = list(views)
    for members in kin.values():
        channels = {name for place in members for name in views[place].covariance}
        mean = {
            name: np.mean(
                [views[p].covariance[name] for p in members if name in views[p].covariance], axis=0
            )
            for name in channels
        }
        for place in members:
            own = views[place]
            made[place] = replace(own, covariance={name: mean[name] for name in own.covariance})
    return made


def _with_noise(views: Sequence[View], campaign: Campaign) -> list[View]:
    """Covariances from elsewhere for the forces that have none, and the scatter of repeats."""
    scatter = repeat_scatter(views)
    channels = {channel for channel, _ in scatter}
    made = []
    for view in views:
        kind = view.run.dynamic
        repeated = {
            channel: scatter.get((channel, kind), scatter.get((channel, not kind), 0.0))
            for channel in channels
        }
        view = replace(view, repeated=MappingProxyType(repeated))
        lacking = [name for name in view.force if name not in view.covariance]
        given = {name: _elsewhere(view, name, campaign) for name in lacking}
        made.append(
            replace(
                view,
                covariance={**view.covariance, **{name: V for name, (V, _) in given.items()}},
                noise=MappingProxyType({name: origin for name, (_, origin) in given.items()}),
            )
        )
    return made


def _elsewhere(view: View, channel: str, campaign: Campaign) -> tuple[Array, Noise]:
    one = np.eye(view.rows)
    if channel in view.repeated:
        return view.repeated[channel] ** 2 * one, "repeats"
    stated = [item for item in campaign.uncertainty if item.kind.channel == channel]
    if stated:
        variance = sum(
            (item.std * view.force[channel]) ** 2
            if item.relative
            else np.full(view.rows, item.std**2)
            for item in stated
        )
        return np.diag(variance), "stated"
    if channel in campaign.numerical:
        return campaign.numerical[channel] ** 2 * one, "numerical"
    return 0.0 * one, "unknown"


def repeat_scatter(views: Sequence[View]) -> dict[tuple[str, bool], float]:
    """How far runs that repeat each other scatter: a force, which does not shrink with the
    speed."""
    first = {view.run.id: view for view in views if not view.early}
    squares: dict[tuple[str, bool], list[tuple[float, int]]] = {}
    for group in Run.repeats([view.run for view in first.values()]):
        alike: dict[tuple[str, tuple[str, ...]], list[Array]] = {}
        for view in (first[run.id] for run in group):
            for channel, force in view.force.items():
                alike.setdefault((channel, view.labels), []).append(force)
        for (channel, _), forces in alike.items():
            if len(forces) > 1:
                rows = np.stack(forces)
                square = float(np.mean(np.sum((rows - rows.mean(axis=0)) ** 2, axis=0)))
                key = (channel, group[0].dynamic)
                squares.setdefault(key, []).append((square, len(rows) - 1))
    return {
        key: math.sqrt(sum(x for x, _ in own) / sum(n for _, n in own))
        for key, own in squares.items()
    }


def times_factors(harmonics: Array, factors: NDArray[np.complex128]) -> Array:
    """Harmonics C0, C1, S1 … (…, k) of which the n-th is multiplied by a complex factor.

    Examples
    --------
    >>> times_factors(np.array([1.0, 2.0, 0.0]), np.array([0.0, -1j])).tolist()
    [0.0, 0.0, 2.0]
    """
    found = np.empty_like(harmonics)
    found[..., 0] = factors[..., 0].real * harmonics[..., 0]
    values = (harmonics[..., 1::2] - 1j * harmonics[..., 2::2]) * factors[..., 1:]
    found[..., 1::2], found[..., 2::2] = values.real, -values.imag
    return found


# Captive runs as the faults of the catalogue see them.


SAMPLES: Final = 2048
"""Samples that are looked at together: many more of them leave the processor's cache."""


class Expects(Protocol):
    """What predicts the forces of captive runs: a fitted base, or a model in the tank."""

    @property
    def ship(self) -> Ship:
        """The model that was tested."""

    @property
    def water(self) -> Water:
        """The water of the tank."""

    def along(self, runs: RunViews, motion: State, speed: Array) -> Mapping[str, Array]:
        """All harmonics of the predicted forces in views, one below the other, if the model went so
        and its carriage at these speeds (n,), by channel [N, N m]."""


@dataclass(frozen=True, kw_only=True, eq=False)
class RunViews:
    """Views of runs, one after another, beside a prediction.

    `effects.seen.Observed` says what each word is.

    Parameters
    ----------
    views : tuple of View
        The runs as measured. Their harmonics are multiplied by factors of their order only where
        all have as many.
    base : Expects
        What is expected of them.
    """

    views: tuple[View, ...]
    base: Expects

    @classmethod
    def stretches(cls, views: Sequence[View], base: Expects) -> Iterator[RunViews]:
        """Views in their order, as many in one stretch as have `SAMPLES` samples together."""
        held: list[View] = []
        count = 0
        for view in views:
            if held and count + len(view.motion.u) > SAMPLES:
                yield cls(views=tuple(held), base=base)
                held, count = [], 0
            held.append(view)
            count += len(view.motion.u)
        if held:
            yield cls(views=tuple(held), base=base)

    @cached_property
    def _edges(self) -> list[int]:
        return list(accumulate((len(view.motion.u) for view in self.views), initial=0))

    @property
    def size(self) -> int:
        """Number of samples."""
        return self._edges[-1]

    @cached_property
    def samples(self) -> list[slice]:
        """Those of each view."""
        return [slice(begin, end) for begin, end in pairwise(self._edges)]

    @cached_property
    def rows(self) -> list[slice]:
        """Harmonics of each view, of those that the forces have."""
        edges = accumulate((view.rows for view in self.views), initial=0)
        return [slice(begin, end) for begin, end in pairwise(edges)]

    def each(self, values: Sequence[float] | Sequence[bool]) -> Array:
        """A number of each view at its samples (n,)."""
        return np.repeat(values, np.diff(self._edges))

    def history(self, name: str) -> Array:
        """One of the histories of the motion (n,)."""
        return np.concatenate([getattr(view.motion, name) for view in self.views])

    def means(self, history: Array) -> Array:
        """Mean of a history (n,) in each view, at its samples."""
        found = np.add.reduceat(history, self._edges[:-1]) / np.diff(self._edges)
        return self.each(found.tolist())

    def lagging(self, history: Array, rate: Array) -> Array:
        """What follows a history (n,) with a lag of one over a rate (n,) [1/s], start forgotten.

        Where the motion is steady, it has arrived.
        """
        found, alike = history.copy(), dict[tuple[int, ...], list[int]]()
        for i, view in enumerate(self.views):
            if view.omega:
                alike.setdefault(view.whole.shape, []).append(i)
        for (k, n), numbers in alike.items():
            views = [self.views[i] for i in numbers]
            at = np.array([self._edges[i] for i in numbers])[:, None] + np.arange(n)
            ratio = np.array([view.omega for view in views])[:, None] / rate[at[:, :1]]
            factors = np.asarray(1.0 / (1.0 + 1j * np.arange((k - 1) // 2 + 1.0) * ratio), complex)
            harmonics = np.stack([view.whole for view in views]) @ history[at][..., None]
            turned = times_factors(harmonics[..., 0], factors)
            found[at] = (np.stack([view.basis for view in views]) @ turned[..., None])[..., 0]
        return found

    @property
    def ship(self) -> Ship:
        """The model that was tested."""
        return self.base.ship

    @property
    def water(self) -> Water:
        """The water of the tank."""
        return self.base.water

    @cached_property
    def motion(self) -> State:
        """Motion of midship at the samples."""
        return State.joined([view.motion for view in self.views])

    @cached_property
    def heading(self) -> Array:
        """Heading in the tank [rad]."""
        return np.concatenate([view.heading for view in self.views])

    @cached_property
    def drift(self) -> Array:
        """Heading about which the model is swung [rad]."""
        return self.each([view.run.settings.drift for view in self.views])

    @cached_property
    def t(self) -> Array:
        """Time of the samples [s]."""
        return np.concatenate([view.t for view in self.views])

    @cached_property
    def speed(self) -> Array:
        """Speed of the carriage [m/s]."""
        return self.each([view.speed for view in self.views])

    @cached_property
    def omega(self) -> Array:
        """Angular frequency of the oscillation [rad/s]; 0 for a steady run."""
        return self.each([view.omega for view in self.views])

    @cached_property
    def sways(self) -> Array:
        """Whether the rig oscillates the model across the tank."""
        return self.each([view.run.kind_of_test.sways for view in self.views])

    @cached_property
    def yaws(self) -> Array:
        """Whether the rig oscillates the heading."""
        return self.each([view.run.kind_of_test.yaws for view in self.views])

    @cached_property
    def day(self) -> Array:
        """Where the runs stand between the first (0) and the last (1) of the campaign."""
        return self.each([view.day for view in self.views])

    @cached_property
    def _expected(self) -> Mapping[str, Array]:
        known = [view.expected for view in self.views]
        if not all(known):
            return self.base.along(self, self.motion, self.speed)
        return {name: np.concatenate([own[name] for own in known]) for name in known[0]}

    def _picked(self, harmonics: Mapping[str, Array]) -> dict[str, Array]:
        """Of all harmonics, by channel, those that the forces have."""
        if all(view.kept is None for view in self.views):
            return dict(harmonics)
        kept = np.concatenate(
            [np.full(view.rows, True) if view.kept is None else view.kept for view in self.views]
        )
        return {name: x[kept] for name, x in harmonics.items()}

    @cached_property
    def forces(self) -> Mapping[str, Array]:
        """Harmonics of the predicted forces that the forces have [N, N m]."""
        return MappingProxyType(self._picked(self._expected))

    def along(self, motion: State, *, speed: float | Array | None = None) -> Mapping[str, Array]:
        """The same if the model, or its carriage, went otherwise; runs that go as they did are not
        predicted again."""
        stated = self.speed if speed is None else np.broadcast_to(speed, (self.size,))
        moved = stated != self.speed
        for field_ in fields(State):
            here, there = getattr(motion, field_.name), getattr(self.motion, field_.name)
            if here is not there:
                moved = moved | (here != there)
        changed = np.logical_or.reduceat(moved, self._edges[:-1])
        if not changed.any():
            return self.forces
        if changed.all():
            return self._picked(self.base.along(self, motion, stated))
        kept = self.each(changed.tolist())
        some = RunViews(views=tuple(compress(self.views, changed)), base=self.base)
        own = self.base.along(some, motion.at(kept), stated[kept])
        rows = np.repeat(changed, [len(view.whole) for view in self.views])
        found = {name: x.copy() for name, x in self._expected.items()}
        for name, x in own.items():
            found[name][rows] = x
        return self._picked(found)

    def project(self, history: Array) -> Array:
        """Harmonics of a history (n,)."""
        return np.concatenate(
            [view.project(history[at]) for view, at in zip(self.views, self.samples, strict=True)]
        )

    def shaped(self, force: Array, shape: Callable[[Array], Array]) -> Array:
        """Harmonics of a force of which each instant is changed by itself."""
        return self.project(shape(self._history(force)))

    def times(self, force: Array, history: Array) -> Array:
        """Harmonics of a force times a history."""
        return self.project(self._history(force) * history)

    def _history(self, force: Array) -> Array:
        """A force at the samples, from the harmonics that it has."""
        parts = []
        for view, rows in zip(self.views, self.rows, strict=True):
            kept = slice(None) if view.kept is None else view.kept
            parts.append(view.basis[:, kept] @ force[rows])
        return np.concatenate(parts)

    def filtered(
        self, factor: Callable[[Array, Array], NDArray[np.complex128]], *channels: str
    ) -> dict[str, Array]:
        """Harmonics of predicted forces, each times a factor."""
        omega = np.array([view.omega for view in self.views])[:, None]
        found = {}
        for name in channels or self._expected:
            harmonics = self._expected[name].reshape(len(self.views), -1)
            factors = factor(np.arange((harmonics.shape[1] - 1) // 2 + 1.0)[None], omega)
            found[name] = times_factors(harmonics, factors).ravel()
        return self._picked(found)
