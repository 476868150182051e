"""Which samples of a record count: with the carriage at its speed, and of whole cycles."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING, ClassVar, Final, TypeVar

import numpy as np

from pmmkit.base import CampaignError
from pmmkit.campaigns.motion.kinematics import displacement_basis
from pmmkit.campaigns.stated_run import StatedRun
from pmmkit.numerics import Array
from pmmkit.signals import (
    FEWEST,
    Cycles,
    CycleSums,
    FourierBasis,
    Travel,
    Window,
    at_size,
    at_speed,
    in_step,
    steady_window,
    whole_cycles,
)

if TYPE_CHECKING:
    import xarray as xr

P = TypeVar("P", Window, Cycles)
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
    ORDER: ClassVar[int] = 5
    """Highest harmonic that is fitted."""

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
        """Harmonics 0 to `ORDER` at the samples that count."""
        return self.basis.up_to(self.ORDER).within(self.cut)

    @property
    def kept_sums(self) -> CycleSums:
        """Those over the cycles that count."""
        first = self.cycles.first
        return self.sums.within(first, first + self.cycles.count)


@dataclass(frozen=True, kw_only=True, eq=False)
class TankRecord:
    """The forces of a captive test over time, of which not all samples count.

    Parameters
    ----------
    run : StatedRun
        The test.
    data : Dataset
        Its data.
    times : array (n,)
        Of the samples [s].
    forces : array (c, n)
        Forces.
    names : sequence of str
        Their channels.
    """

    run: StatedRun
    data: xr.Dataset
    times: Array
    forces: Array
    names: Sequence[str]

    @cached_property
    def stated(self) -> Travel | None:
        """The samples that the campaign file says count, with its reason; None if it is silent."""
        run, times = self.run, self.times
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

    @cached_property
    def travel(self) -> Travel:
        """Where the carriage is at its speed and what swings at its size.

        Of the carriage its recorded speed tells, else that of the hull, of an oscillating run
        without either the forces; of a static one `steady_window` finds the ramp. Of what swings
        its recorded motion tells. Where the campaign file states a window, that.
        """
        if self.stated is not None:
            return self.stated
        run, times = self.run, self.times
        speed = _speed(self.data)
        found = Travel(0, times.size)
        if speed is not None:
            found = at_speed(times, speed)
        elif run.dynamic and run.settings.period and "X" in self.names:
            place = list(self.names).index("X")
            found = in_step(times, run.nominal_phase(times), self.forces, place)
        moved = _recorded(self.data, [item.channel for item in run.kind_of_test.phase_channels])
        if run.dynamic and run.settings.omega and moved is not None:
            return found.within(at_size(times, moved, run.settings.omega))
        return found

    def window(self) -> Window:
        """The steady part of a static record while the carriage is at its speed, or what is stated.

        Raises
        ------
        DataError
            If too little is left, or the record is damaged.
        """
        travel = self.travel
        if not travel.reason:
            return steady_window(self.times, self.forces)
        if self.stated is not None:
            return Window(travel.start, travel.stop, f"left out {travel.reason}")
        cut = slice(travel.start, travel.stop)
        return _moved(steady_window(self.times[cut], self.forces[:, cut]), travel)

    def cycles(self, asked: int | tuple[int, int] | None = None) -> Counted:
        """Whole cycles while the carriage is at its speed, or those stated.

        Parameters
        ----------
        asked : int or (int, int), optional
            Only these, counted from 1 at the start of the record, whatever the carriage does.

        Raises
        ------
        DataError
            If there are too few whole cycles, or the record is damaged.
        """
        run, data, times = self.run, self.data, self.times
        travel = Travel(0, times.size) if asked is not None else self.travel
        if not travel.reason:
            basis = displacement_basis(run, data, times, HIGHEST)
            sums = CycleSums.over(times, basis, self.forces)
            found = whole_cycles(times, basis, self.forces, cycles=asked, sums=sums)
            told = tuple(self.names) if asked is None else ()
            return Counted(basis=basis, cycles=found, travel=travel, sums=sums, channels=told)
        cut = slice(travel.start, travel.stop)
        basis = displacement_basis(run, data, times, HIGHEST, within=cut)
        stated = self.stated is not None
        part = basis.within(cut)
        every = (1, part.cycles) if stated else None
        sums = CycleSums.over(times[cut], part, self.forces[:, cut])
        found = whole_cycles(times[cut], part, self.forces[:, cut], cycles=every, sums=sums)
        own = replace(travel, reason="") if stated else travel
        return Counted(
            basis=basis,
            cycles=_moved(found, travel),
            travel=own,
            sums=sums,
            channels=tuple(self.names),
        )


def _moved(found: P, travel: Travel) -> P:
    """A part of what lies within the travel, seen from the begin of the record."""
    return replace(
        found,
        start=found.start + travel.start,
        stop=found.stop + travel.start,
        reason=f"left out {travel.reason}; {found.reason}",
    )


def _speed(data: xr.Dataset) -> Array | None:
    """The recorded speed of the carriage, or of the hull; None where there is none without gaps."""
    found = _whole(data, ("U_carriage", "u", "v"))
    if "U_carriage" in found:
        return found["U_carriage"]
    return np.hypot(found["u"], found.get("v", 0.0)) if "u" in found else None


def _recorded(data: xr.Dataset, names: Sequence[str]) -> Array | None:
    """The first of some recorded motions without gaps; None where there is none."""
    return next(iter(_whole(data, names).values()), None)


def _whole(data: xr.Dataset, names: Sequence[str]) -> dict[str, Array]:
    return {
        name: np.asarray(series.values, float)
        for name in names
        if name in data
        and (series := data.variables[name]).dims == ("t",)
        and np.isfinite(series.values).all()
    }
