"""Which samples of a record count: with the carriage at its speed, and of whole cycles."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING, Final

import numpy as np

from pmmkit.base import CampaignError
from pmmkit.campaigns.motion.kinematics import displacement_basis
from pmmkit.campaigns.motion.nominal import nominal_phase
from pmmkit.campaigns.run import Run
from pmmkit.numerics import Array
from pmmkit.signals import (
    FEWEST,
    Cycles,
    CycleSums,
    FourierBasis,
    Travel,
    Window,
    as_record,
    at_speed,
    cycle_count,
    cycle_edges,
    in_step,
    steady_window,
    whole_cycles,
)

if TYPE_CHECKING:
    import xarray as xr


FITTED: Final = 5
"""Highest harmonic of a record that is fitted."""
HIGHEST: Final = 6
"""Highest harmonic that is taken out before the noise of a single cycle is judged."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Counted:
    """The whole cycles of an oscillating record.

    Parameters
    ----------
    basis : FourierBasis
        Harmonics 0 to `HIGHEST` of the phase of the displacement, at all samples of the record.
    cycles : Cycles
        Those that count; samples are those of the whole record.
    travel : Travel
        Where the carriage is at its speed, with a reason where it is not throughout; or the window
        that the campaign file states.
    sums : CycleSums
        Harmonics 0 to `HIGHEST` and the forces over each whole cycle while the carriage is at its
        speed; samples are counted from there.
    channels : tuple of str
        Those whose agreement from cycle to cycle told which count; none where they were asked for.
    """

    basis: FourierBasis
    cycles: Cycles
    travel: Travel
    sums: CycleSums
    channels: tuple[str, ...] = ()

    @property
    def theta(self) -> Array:
        """Phase of the displacement at all samples of the record [rad]."""
        return self.basis.phase

    @property
    def cut(self) -> slice:
        """The samples that count."""
        return slice(self.cycles.start, self.cycles.stop)

    @cached_property
    def kept(self) -> FourierBasis:
        """Harmonics 0 to `FITTED` at the samples that count."""
        return self.basis.up_to(FITTED).within(self.cut)

    @property
    def kept_sums(self) -> CycleSums:
        """Those over the cycles that count."""
        first = self.cycles.first
        return self.sums.within(first, first + self.cycles.count)


def stated_window(run: Run, times: Array) -> Travel | None:
    """The samples that the campaign file says count, with its reason; None where it says nothing.

    times [s].
    """
    stated = [item for item in run.corrections if item.action == "window"]
    if not stated:
        return None
    low, high = (float(stated[-1].values[key]) for key in ("t_start", "t_end"))
    start = int(np.searchsorted(times, low))
    stop = int(np.searchsorted(times, high, side="right"))
    if stop - start < FEWEST:
        raise CampaignError(
            f"the window from t = {low:g} to {high:g} s holds {max(stop - start, 0)} "
            f"samples, and {FEWEST} are needed; the record runs from {times[0]:g} to "
            f"{times[-1]:g} s.",
            file=run.source or None,
            run=run.id,
            remedy='Correct t_start and t_end of the correction with action = "window".',
        )
    said = f"all but {low:g} to {high:g} s, as the campaign file says ({stated[-1].reason})"
    return Travel(start, stop, said)


def travel_of(
    run: Run, data: xr.Dataset, times: Array, record: Array, names: Sequence[str]
) -> Travel:
    """Where the carriage is at its speed: by its recorded speed, else by that of the hull.

    Where the campaign file states a window, that. Of an oscillating run without either the forces
    tell; of a static one `steady_window` finds the ramp.

    Parameters
    ----------
    run : Run
        A captive test with a history.
    data : Dataset
        Its data.
    times : array (n,)
        Of the samples [s].
    record : array (c, n)
        Forces.
    names : sequence of str
        Their channels.
    """
    stated = stated_window(run, times)
    if stated is not None:
        return stated
    speed = _speed(data)
    if speed is not None:
        return at_speed(times, speed)
    if run.dynamic and run.settings.period and "X" in names:
        return in_step(times, nominal_phase(run, times), record, list(names).index("X"))
    return Travel(0, times.size)


def counted_window(
    run: Run, data: xr.Dataset, times: Array, record: Array, names: Sequence[str]
) -> Window:
    """The steady part of a static record while the carriage is at its speed, or what is stated.

    Parameters
    ----------
    run, data, times, record, names
        As for `travel_of`.

    Raises
    ------
    DataError
        If too little is left, or the record is damaged.
    """
    travel = travel_of(run, data, times, record, names)
    if not travel.reason:
        return steady_window(times, record)
    if stated_window(run, times) is not None:
        return Window(travel.start, travel.stop, f"left out {travel.reason}")
    cut = slice(travel.start, travel.stop)
    found = steady_window(times[cut], record[:, cut])
    return replace(
        found,
        start=found.start + travel.start,
        stop=found.stop + travel.start,
        reason=f"left out {travel.reason}; {found.reason}",
    )


def counted_cycles(
    run: Run,
    data: xr.Dataset,
    times: Array,
    record: Array,
    names: Sequence[str],
    *,
    cycles: int | tuple[int, int] | None = None,
) -> Counted:
    """Whole cycles of an oscillating record while the carriage is at its speed, or those stated.

    Parameters
    ----------
    run, data, times, record, names
        As for `travel_of`; the run's period counts.
    cycles : int or (int, int), optional
        Only these, counted from 1 at the start of the record, whatever the carriage does.

    Raises
    ------
    DataError
        If there are too few whole cycles, or the record is damaged.
    """
    travel = Travel(0, times.size)
    if cycles is None:
        travel = travel_of(run, data, times, record, names)
    if not travel.reason:
        basis = displacement_basis(run, data, times, HIGHEST)
        sums = _over_cycles(times, basis, record)
        found = whole_cycles(times, basis, record, cycles=cycles, sums=sums)
        told = tuple(names) if cycles is None else ()
        return Counted(basis=basis, cycles=found, travel=travel, sums=sums, channels=told)
    cut = slice(travel.start, travel.stop)
    basis = displacement_basis(run, data, times, HIGHEST, within=cut)
    stated = stated_window(run, times) is not None
    asked = (1, cycle_count(basis.phase[cut])) if stated else None
    part = basis.within(cut)
    sums = _over_cycles(times[cut], part, record[:, cut])
    found = whole_cycles(times[cut], part, record[:, cut], cycles=asked, sums=sums)
    moved = replace(
        found,
        start=found.start + travel.start,
        stop=found.stop + travel.start,
        reason=f"left out {travel.reason}; {found.reason}",
    )
    own = replace(travel, reason="") if stated else travel
    return Counted(basis=basis, cycles=moved, travel=own, sums=sums, channels=tuple(names))


def _over_cycles(times: Array, basis: FourierBasis, record: Array) -> CycleSums:
    """Sums over each whole cycle of a record, counted from its first sample."""
    _, values = as_record(times, record)
    return CycleSums.of(values, basis.rows, cycle_edges(basis.phase, cycle_count(basis.phase)))


def whole_series(data: xr.Dataset, *names: str) -> dict[str, Array]:
    """The channels among these that are there in time, without a gap.

    Parameters
    ----------
    data : Dataset
        A history.
    *names : str
        Channels that are wanted.
    """
    found = {name: data.variables[name] for name in names if name in data}
    return {
        name: np.asarray(series.values, float)
        for name, series in found.items()
        if series.dims == ("t",) and np.isfinite(series.values).all()
    }


def _speed(data: xr.Dataset) -> Array | None:
    """The recorded speed of the carriage, or of the hull; None where there is none."""
    found = whole_series(data, "U_carriage", "u", "v")
    if "U_carriage" in found:
        return found["U_carriage"]
    return np.hypot(found["u"], found.get("v", 0.0)) if "u" in found else None
