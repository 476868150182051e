"""One run, brought to the steady window or the whole cycles that count."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING

import numpy as np

from pmmkit.base import DataError, Problem
from pmmkit.campaigns import Campaign, Counted, Rig, Run, TankRecord
from pmmkit.conventions import CHANNELS
from pmmkit.effects import State
from pmmkit.numerics import Array, projector
from pmmkit.presentation import WIDE
from pmmkit.signals import (
    Harmonics,
    Window,
    design_matrix,
    estimate_frequency,
    harmonics,
    steady_mean,
    time_weights,
    trapezoid_projector,
)

if TYPE_CHECKING:
    import xarray as xr

CycleChoice = int | tuple[int, int] | None
GRID = 120
"""Points of the one-cycle grid on which motions without a record are evaluated."""
SLIP = math.radians(5)
"""Phase by which record and stated period must drift apart before the record counts."""
EXTRAS = ("sinkage", "trim", "T", "Q", "FX_rudder", "FY_rudder")


@dataclass(frozen=True, kw_only=True, eq=False)
class RunResult:
    """What the reduction found in one run; small, however long the record.

    Parameters
    ----------
    run : Run
        The run, with the period that the record has.
    froude : float
        Its Froude number.
    labels : tuple of str (m,)
        ``C0`` for static runs; ``C0, C1, S1, …`` for oscillating ones.
    measured : dict of str to array (m,)
        Harmonics of the channels as they stand in the data [N, N m]; NaN where not known.
    covariance : dict of str to array (m, m) or None
        Their covariance; None where the source states none.
    dof : dict of str to float
        Degrees of freedom of the covariance.
    samples : int
        How many samples count.
    window : str
        What was left out and why, in words.
    duration : float
        How long these are [s]; NaN where there is no record.
    cycles : int or None
        Whole cycles used.
    scatter : dict of str to array (m,)
        Standard deviation over the cycles.
    frequency : float or None
        Angular frequency [rad/s].
    extras : dict of str to float
        Means of the channels that are only reported (sinkage, trim, thrust …).
    notes : tuple of str
        What a reader should know of this run.
    conversions : tuple of str
        What was done to the source's numbers when they were read.
    ramp : str
        Times left out of an oscillating record because the carriage was not at its speed.
    smoothed : int or None
        Highest harmonic to which an oscillating record was fitted before it was handed in: it says
        nothing of its own noise, nor of higher harmonics. None for one with noise of its own.
    """

    run: Run
    froude: float
    labels: tuple[str, ...]
    measured: Mapping[str, Array]
    covariance: Mapping[str, Array | None]
    dof: Mapping[str, float]
    samples: int
    window: str
    duration: float = math.nan
    cycles: int | None = None
    scatter: Mapping[str, Array] = field(default_factory=dict)
    frequency: float | None = None
    extras: Mapping[str, float] = field(default_factory=dict)
    notes: tuple[str, ...] = ()
    conversions: tuple[str, ...] = ()
    ramp: str = ""
    smoothed: int | None = None


@dataclass(frozen=True, kw_only=True, eq=False)
class PreparedRun:
    """A run cut to what counts, with the projection onto its mean or its harmonics.

    Parameters
    ----------
    result : RunResult
        The harmonics.
    projection : array (m, n)
        The linear map from n samples to the m harmonics.
    motion : State
        Motion of the motion reference point at the n samples.
    t : array (n,)
        Time of the samples [s]; zeros where there is no record.
    begin : float
        Time at which the record begins [s].
    phase : array (n,) or None
        Phase of the displacement at the samples of an oscillating record [rad].
    window : Window or None
        The steady part of a static record.
    counted : Counted or None
        The whole cycles of an oscillating record whose period the campaign states rightly.
    """

    result: RunResult
    projection: Array
    motion: State
    t: Array
    begin: float = 0.0
    phase: Array | None = None
    window: Window | None = None
    counted: Counted | None = None

    @classmethod
    def of(
        cls,
        run: Run,
        campaign: Campaign,
        *,
        cycles: CycleChoice = None,
        noise: bool = True,
        integrated: bool = False,
    ) -> PreparedRun:
        """Cut one run to its steady window or whole cycles and project it.

        Parameters
        ----------
        run : Run
            The run; its data are read once.
        campaign : Campaign
            Ship and conventions.
        cycles : int or (int, int), optional
            Only this cycle, or these; the cycle-to-cycle test decides where absent.
        noise : bool
            Whether the noise of an oscillating record is estimated; without it there are no
            covariances.
        integrated : bool
            Whether harmonics are trapezoidal integrals over the cycles, as some papers have them,
            instead of least squares.

        Raises
        ------
        DataError
            If the run holds none of X, Y, N, K, or times that cannot be (`Run.clock_problem`), or
            too little to reduce.
        """
        data = run.data
        channels = [
            name
            for name in CHANNELS
            if name in data or f"{name}_cos" in data or f"{name}_sin" in data
        ]
        if not channels:
            raise DataError(
                Problem(
                    message="holds none of the channels X, Y, N, K.",
                    file=run.source or None,
                    run=run.id,
                    remedy="Name them under [columns].",
                )
            )
        if run.kind == "history" and (
            problem := run.clock_problem(np.asarray(data["t"].values, float))
        ):
            raise DataError(problem)
        make = {"history": _from_history, "means": _from_means, "harmonics": _from_harmonics}
        if run.kind == "history" and run.dynamic:
            prepared = _from_cycles(run, campaign, data, channels, cycles, noise, integrated)
        else:
            prepared = make[run.kind](run, campaign, data, channels, cycles)
        steps = tuple(json.loads(data.attrs.get("conversions", "[]")))
        return replace(prepared, result=replace(prepared.result, conversions=steps))

    def motion_at_midship(self, rig: Rig) -> State:
        """Motion of midship at the samples."""
        return self.motion.moved_aft(rig.motion_x)

    def water_force(self, rig: Rig) -> dict[str, Array]:
        """Harmonics of the force of the water on the hull at midship [N, N m]."""
        return rig.force_of_water(
            self.result.measured,
            self.result.run,
            self.motion_at_midship(rig),
            self.projection.__matmul__,
        )


def label_harmonics(order: int) -> tuple[str, ...]:
    """Labels of harmonics in their order: C0, C1, S1, C2, S2 …

    Examples
    --------
    >>> label_harmonics(1)
    ('C0', 'C1', 'S1')
    """
    return ("C0", *(f"{kind}{n}" for n in range(1, order + 1) for kind in "CS"))


def places_of(labels: Sequence[str]) -> list[int]:
    """Where harmonics stand among C0, C1, S1, C2 …

    Examples
    --------
    >>> places_of(("C0", "S1", "C2"))
    [0, 2, 3]
    """
    every = label_harmonics(max(int(label[1:]) for label in labels))
    return [every.index(label) for label in labels]


def one_cycle() -> Array:
    """Phases of the motion on which it is evaluated where there is no record [rad]."""
    return np.arange(GRID, dtype=np.float64) * (2 * math.pi / GRID)


def _froude(run: Run, campaign: Campaign) -> float:
    return campaign.ship.froude(run.settings.speed, campaign.water.g)


def _from_history(
    run: Run, campaign: Campaign, data: xr.Dataset, channels: list[str], _: CycleChoice
) -> PreparedRun:
    times = np.asarray(data["t"].values, float)
    record = np.stack([np.asarray(data.variables[name].values, float) for name in channels])
    window = TankRecord(run=run, data=data, times=times, forces=record, names=channels).window()
    cut = slice(window.start, window.stop)
    mean = steady_mean(times[cut], record[:, cut])
    weights = time_weights(times[cut])
    weights = weights / weights.sum()
    return PreparedRun(
        result=RunResult(
            run=run,
            froude=_froude(run, campaign),
            labels=("C0",),
            measured={
                name: np.array([value]) for name, value in zip(channels, mean.value, strict=True)
            },
            covariance={
                name: np.array([[mean.covariance[place, place]]])
                for place, name in enumerate(channels)
            },
            dof=dict(zip(channels, mean.dof.tolist(), strict=True)),
            samples=window.stop - window.start,
            duration=_lasting(times[cut]),
            window=window.reason,
            extras=_extras(data, weights, cut),
            notes=() if window.steady else (f"{run.id}: {window.reason}",),
        ),
        projection=weights[None, :],
        motion=run.measured_motion(data, times[cut], within=cut),
        t=times[cut],
        begin=float(times[0]),
        window=window,
    )


def _lasting(times: Array) -> float:
    """What samples stand for [s], the last one for as long as the others."""
    return float(times[-1] - times[0]) * len(times) / max(len(times) - 1, 1)


def _from_cycles(
    run: Run,
    campaign: Campaign,
    data: xr.Dataset,
    channels: list[str],
    cycles: CycleChoice,
    noise: bool,
    integrated: bool,
) -> PreparedRun:
    times = np.asarray(data["t"].values, float)
    record = np.stack([np.asarray(data.variables[name].values, float) for name in channels])
    every = TankRecord(run=run, data=data, times=times, forces=record, names=channels)
    counted = every.cycles(cycles)
    cut = counted.cut
    notes: tuple[str, ...] = ()
    nominal = run.settings.omega
    if nominal is not None and counted.cycles.count >= 3:
        own, deviation = estimate_frequency(times[cut], record[:, cut], nominal)
        slip = abs(own - nominal) * (times[cut][-1] - times[cut][0])
        if abs(own - nominal) > max(5 * deviation, 1e-3 * nominal) and slip > SLIP:
            notes = (
                f"{run.id}: the record oscillates at {own:.5g} rad/s (± {WIDE * deviation:.1g}), "
                f"the campaign says {nominal:.5g}; the record counts.",
            )
            run = run.with_(settings=replace(run.settings, period=2 * math.pi / own))
            counted = replace(every, run=run).cycles(cycles)
            cut = counted.cut
    kept, basis = counted.cycles, counted.kept
    projection = trapezoid_projector(basis.phase, basis.order) if integrated else basis.projector
    found: Harmonics | None = (
        harmonics(basis, record[:, cut], order=basis.order, sums=counted.kept_sums)
        if noise
        else None
    )
    fitted = None if integrated or found is None else found.coefficients
    values = record[:, cut] @ projection.T if fitted is None else fitted
    scatter = None if found is None else found.scatter
    smoothed = None if found is None else found.fitted_order(record[:, cut])
    if smoothed is not None:
        values = np.where(np.arange(values.shape[1]) <= 2 * smoothed, values, np.nan)
    return PreparedRun(
        result=RunResult(
            run=run,
            froude=_froude(run, campaign),
            labels=label_harmonics(basis.order),
            measured=_without_mean(dict(zip(channels, values, strict=True)), run),
            covariance={}
            if found is None
            else dict.fromkeys(channels)
            if smoothed is not None
            else dict(zip(channels, found.covariance, strict=True)),
            dof={} if found is None else dict(zip(channels, found.dof.tolist(), strict=True)),
            smoothed=smoothed,
            samples=kept.stop - kept.start,
            duration=_lasting(times[cut]),
            window=kept.reason,
            cycles=kept.count,
            scatter={} if scatter is None else dict(zip(channels, scatter, strict=True)),
            frequency=run.settings.omega,
            extras=_extras(data, np.full(len(basis.phase), 1 / len(basis.phase)), cut),
            notes=notes,
            ramp=counted.travel.reason,
        ),
        projection=projection,
        motion=run.measured_motion(data, times[cut], basis, within=cut),
        t=times[cut],
        begin=float(times[0]),
        phase=basis.phase,
        counted=None if notes else counted,
    )


def _extras(data: xr.Dataset, weights: Array, cut: slice) -> dict[str, float]:
    there = {name: data.variables[name].values for name in EXTRAS if name in data}
    return {
        name: float(weights @ np.asarray(values[cut], float))
        for name, values in there.items()
        if values.ndim == 1
    }


def _from_means(
    run: Run, campaign: Campaign, data: xr.Dataset, channels: list[str], cycles: CycleChoice
) -> PreparedRun:
    del cycles
    covariance: dict[str, Array | None] = {
        name: np.array([[float(data[f"{name}_std"]) ** 2]]) if f"{name}_std" in data else None
        for name in channels
    }
    return PreparedRun(
        result=RunResult(
            run=run,
            froude=_froude(run, campaign),
            labels=("C0",),
            measured={name: np.array([float(data[name])]) for name in channels},
            covariance=covariance,
            dof=dict.fromkeys(channels, math.inf),
            samples=1,
            window="a mean from the source's table",
            extras={name: float(data[name]) for name in EXTRAS if name in data},
        ),
        projection=np.ones((1, 1)),
        motion=run.measured_motion(data, np.zeros(1)),
        t=np.zeros(1),
    )


def _from_harmonics(
    run: Run, campaign: Campaign, data: xr.Dataset, channels: list[str], cycles: CycleChoice
) -> PreparedRun:
    del cycles
    order = int(data["harmonic"].values.max())
    theta = one_cycle()
    basis = design_matrix(theta, order)
    omega = run.settings.omega
    if omega is None:
        raise DataError(Problem(message="has no period.", file=run.source or None, run=run.id))
    settings = run.settings
    motion = run.nominal_motion((theta - settings.phase) / omega)
    if "T_cos" in data or "T_sin" in data:
        motion = motion.with_(thrust=basis @ np.nan_to_num(_interleaved(data, "T", order)))
    measured = {name: _interleaved(data, name, order) for name in channels}
    return PreparedRun(
        result=RunResult(
            run=run,
            froude=_froude(run, campaign),
            labels=label_harmonics(order),
            measured=_without_mean(measured, run),
            covariance=dict.fromkeys(channels),
            dof=dict.fromkeys(channels, math.inf),
            samples=GRID,
            window="harmonics from the source's table"
            + ("" if run.use_means else ", without their means"),
            frequency=omega,
        ),
        projection=projector(basis),
        motion=motion,
        t=np.zeros(len(motion.u)),
    )


def _without_mean(measured: Mapping[str, Array], run: Run) -> dict[str, Array]:
    """The harmonics with NaN for a mean that is known to be wrong."""
    if run.use_means:
        return dict(measured)
    return {name: np.concatenate([[np.nan], values[1:]]) for name, values in measured.items()}


def _interleaved(data: xr.Dataset, name: str, order: int) -> Array:
    """C0, C1, S1 … of a channel from its two arrays; NaN where the source gives none."""
    missing = np.full(order + 1, np.nan)
    cosine = np.asarray(data[f"{name}_cos"].values, float) if f"{name}_cos" in data else missing
    sine = np.asarray(data[f"{name}_sin"].values, float) if f"{name}_sin" in data else missing
    pairs = np.stack([cosine[1:], sine[1:]], axis=1).ravel()
    return np.concatenate([cosine[:1], pairs])
