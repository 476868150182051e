"""What may be wrong with a run or with all: each in words, and as what it does to the records.

A suspect acts on the motion (the model went otherwise than stated) or on what gauges and files
show of the forces. The same description is asked of one run against the others, and of all runs
together. Where the catalogue of effects has the fault, its entry gives the words.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from typing import Final

import numpy as np

from pmmkit.campaigns.run import Run
from pmmkit.checks.agreement.actions import (
    Column,
    Move,
    Show,
    amplitude,
    bent,
    drift,
    exchanged,
    filtered,
    in_tank,
    late,
    moments_about,
    one_pole,
    other_side,
    own_clock,
    point,
    scaled,
    turned,
    velocities_in_tank,
)
from pmmkit.checks.agreement.rows import CHANNELS, Group
from pmmkit.numerics import Array

FORCE_UNITS: Final = (("kilogram-force (kgf)", 9.80665), ("pound-force (lbf)", 4.4482216))
MOMENT_UNITS: Final = (
    ("kilogram-force metre (kgf m)", 9.80665),
    ("pound-force foot (lbf ft)", 1.3558179),
    ("pound-force (lbf m)", 4.4482216),
)
ANGLES: Final = (1.0, 2.0, 3.0, 4.0, 6.0, 8.0, 12.0, 16.0, 24.0)
LAGS: Final = (0.03, 0.06, 0.12, 0.25, 0.5)
DEGREES: Final = (2.0, 5.0, 10.0, 20.0, 45.0, 90.0)
SHARES: Final = (0.8, 0.9, 0.95, 1.05, 1.1, 1.25)
POINTS: Final = (0.02, 0.05, 0.1, 0.2)


def _any(run: Run) -> bool:
    return bool(run.test)


def _dynamic(run: Run) -> bool:
    return run.dynamic


@dataclass(frozen=True, kw_only=True)
class Suspect:
    """Something that may be wrong.

    Parameters
    ----------
    name : str
        What it is called.
    says : callable
        From a value to what is wrong, in words that follow "if".
    remedy : str
        What the user can do about it.
    grid : tuple of float
        Values that are tried.
    continuous : bool
        Whether values between them have a meaning.
    move : callable, optional
        From a group and a value to how the model went.
    show : callable, optional
        From a group, histories (n, 32, 3, p) and a value to what is shown of them.
    applies : callable
        Whether it can be asked of a run.
    scope : {"both", "one", "all"}
        Whether it is asked of one run, of all, or of both.
    slip : bool
        Whether it is a slip of the hand, to be mended before anything is fitted.
    by_size : bool
        Whether of all runs it shows in the size of derivatives alone, which tells it at one speed
        as well as at many.
    effect : str
        Word by which the catalogue has it (`Effect.known_as`), where it does.
    column : callable, optional
        From a group, expected forces (n, 32, 3) and a value to a force of unknown size that is
        shown beside them, harmonics (n, 3, 7) over its standard deviation.
    each_run : bool
        Whether each run and channel draws that size anew.
    free : tuple of str
        Shares of the model's inertia that it sets free.
    channels : tuple of str
        Channels that it changes.
    """

    name: str
    says: Callable[[float], str]
    remedy: str
    grid: tuple[float, ...] = (1.0,)
    continuous: bool = False
    move: Move | None = None
    show: Show | None = None
    applies: Callable[[Run], bool] = field(default=_any)
    scope: str = "both"
    slip: bool = False
    by_size: bool = False
    effect: str = ""
    column: Column | None = None
    each_run: bool = False
    free: tuple[str, ...] = ()
    channels: tuple[str, ...] = CHANNELS

    def histories(self, group: Group, value: float, base: Array | None = None) -> Array:
        """What each parameter would multiply in the records, (n, 32, 3, p); `base` if nothing."""
        stated = group.histories() if base is None else base
        found = stated if self.move is None else group.histories(self.move(group, value))
        if self.show is not None:
            found = self.show(group, found, value)
        touched = np.array([self.applies(item.run) for item in group.summaries])
        return np.where(touched[:, None, None, None], found, stated)


def _both(sizes: tuple[float, ...]) -> tuple[float, ...]:
    return (*(-x for x in sizes[::-1]), *sizes)


def _nominal(run: Run) -> bool:
    return run.dynamic and not run.kind_of_test.surges


def _percent(share: float) -> str:
    return f"{abs(100 * (share - 1)):.1f} % {'larger' if share > 1 else 'smaller'}"


def _sooner(value: float) -> str:
    return "late" if value > 0 else "early"


def _of_channel(c: str) -> Iterator[Suspect]:
    """What may be wrong with one channel."""
    for unit, factor in MOMENT_UNITS if c == "N" else FORCE_UNITS:
        yield _in_unit(c, unit, factor)
    yield Suspect(
        name=f"sign of {c}",
        says=lambda _: f"{c} has the opposite sign",
        remedy=f'Turn the sign of {c} (action = "flip"), or its axis under [axes].',
        show=scaled(c),
        grid=(-1.0,),
        slip=True,
        by_size=True,
        channels=(c,),
    )
    yield Suspect(
        name=f"gain of {c}",
        says=lambda value: (
            f"the gauge of {c} shows {abs(100 * (value - 1)):.1f} % too "
            f"{'much' if value > 1 else 'little'} (its gain)"
        ),
        remedy=f"Look at the calibration of {c} in this run: a weight shows it.",
        show=scaled(c),
        grid=(0.3, 0.5, 0.7, *SHARES, 1.5, 2.0),
        continuous=True,
        scope="one",
        effect="gain",
        channels=(c,),
    )
    yield Suspect(
        name=f"{c} late",
        says=lambda value: f"{c} alone comes {abs(value):.2g} s {_sooner(value)}",
        remedy=f"Look at the filter and the clock of {c}: a knock shows them.",
        show=filtered(late, c),
        grid=_both(LAGS),
        continuous=True,
        applies=_dynamic,
        effect="lag",
        channels=(c,),
    )
    yield Suspect(
        name=f"{c} clipped",
        says=lambda value: (
            f"the amplifier of {c} bends at large forces: it is clipped softly, to an end of "
            f"{value:.1f} times the largest"
        ),
        remedy=f"Look at the range of the gauge and the amplifier of {c}.",
        column=bent(c),
        grid=(0.9, 1.2, 1.6, 2.2),
        channels=(c,),
    )


def _in_unit(c: str, unit: str, factor: float) -> Suspect:
    return Suspect(
        name=f"{c} in another unit",
        says=lambda _: f"{c} is in {unit}, not in SI",
        remedy=f"State the unit of {c} under [columns].",
        show=scaled(c),
        grid=(1 / factor,),
        slip=True,
        by_size=True,
        channels=(c,),
    )


def _amplitude_of(swing: str, applies: Callable[[Run], bool]) -> Suspect:
    return Suspect(
        name=f"amplitude of {swing}",
        says=lambda value: (
            f"the amplitude of the runs in {swing} was {_percent(value)} than stated"
        ),
        remedy="Measure the motion, or correct the amplitude of these runs.",
        move=amplitude,
        grid=SHARES,
        continuous=True,
        applies=lambda run: _nominal(run) and applies(run),
        scope="all",
        effect="amplitude",
    )


SUSPECTS: Final[tuple[Suspect, ...]] = (
    *(suspect for channel in CHANNELS for suspect in _of_channel(channel)),
    Suspect(
        name="clocks",
        says=lambda value: (
            f"the clock of each record starts when it likes, early or late by some {value:.1g} s"
        ),
        remedy="Record the motion beside the forces, or a mark that tells the phase.",
        column=own_clock,
        each_run=True,
        grid=(0.05, 0.15, 0.4),
        applies=_dynamic,
        scope="all",
        effect="lag",
    ),
    Suspect(
        name="half of the hull",
        says=lambda _: "the forces are those of half of the hull",
        remedy="State the symmetry ([cfd] symmetry_factor = 2, or a scale of 2).",
        show=scaled(*CHANNELS),
        grid=(0.5,),
        slip=True,
        by_size=True,
    ),
    Suspect(
        name="gain of all",
        says=lambda value: (
            f"all forces are {_percent(value)} than they should be (a gain, or the "
            f"speed of the carriage by half of it)"
        ),
        remedy="Look at the amplifier and at the speed of the carriage.",
        show=scaled(*CHANNELS),
        grid=SHARES,
        continuous=True,
        scope="one",
    ),
    Suspect(
        name="Y and N exchanged",
        says=lambda _: "the columns of Y and N are exchanged",
        remedy="Exchange the two columns under [columns].",
        show=exchanged,
        slip=True,
        by_size=True,
    ),
    Suspect(
        name="forces in tank axes",
        says=lambda _: "X and Y are forces along and across the tank, not the ship",
        remedy='State forces_in = "carriage" under [cfd].',
        show=in_tank,
        slip=True,
    ),
    Suspect(
        name="other side",
        says=lambda _: "the drift, the motion and the rudder were to the other side than stated",
        remedy="Correct the sign of the setting (drift_positive, or drift_deg of the run).",
        move=other_side,
        slip=True,
        applies=lambda run: not run.kind_of_test.pure,
    ),
    Suspect(
        name="half a cycle",
        says=lambda _: "the record starts half a cycle (180°) later than stated",
        remedy="Correct phase_deg of the run by 180°.",
        show=filtered(turned),
        grid=(180.0,),
        applies=_dynamic,
        slip=True,
    ),
    Suspect(
        name="phase",
        says=lambda value: f"the forces lag the stated motion by a phase of {value:.1f}°",
        remedy="Correct phase_deg, or record the motion.",
        show=filtered(turned),
        grid=_both(DEGREES),
        continuous=True,
        applies=_dynamic,
        effect="lag",
    ),
    Suspect(
        name="lag",
        says=lambda value: (
            f"the forces come {abs(value):.2g} s {_sooner(value)} against the motion (a clock)"
        ),
        remedy="Look at the clocks of forces and motion: a knock that both see shows it.",
        show=filtered(late),
        grid=_both(LAGS),
        continuous=True,
        applies=_dynamic,
        effect="lag",
    ),
    Suspect(
        name="filter",
        says=lambda value: (
            f"a one-pole filter of {value:.2g} s ({1 / (2 * math.pi * value):.2g} "
            f"Hz) makes the forces late"
        ),
        remedy="State the filter, or pass the motion through the same one.",
        show=filtered(one_pole),
        grid=LAGS,
        continuous=True,
        applies=_dynamic,
        effect="filter",
    ),
    Suspect(
        name="amplitude",
        says=lambda value: f"the amplitude was {_percent(value)} than stated",
        remedy="Measure the motion, or correct the amplitude of the runs.",
        move=amplitude,
        grid=SHARES,
        continuous=True,
        applies=_nominal,
        effect="amplitude",
    ),
    _amplitude_of("sway", lambda run: run.kind_of_test.pure == "v"),
    _amplitude_of("yaw", lambda run: run.kind_of_test.yaws),
    Suspect(
        name="peak to peak",
        says=lambda _: "the amplitude is stated peak to peak, twice the true one",
        remedy="State half of it: amplitude_m and yaw_amplitude_deg count from the middle.",
        move=amplitude,
        grid=(0.5,),
        applies=_nominal,
        slip=True,
    ),
    Suspect(
        name="drift",
        says=lambda value: (
            f"the model stood turned by {value:+.1f}° against the drift angle that is stated"
        ),
        remedy="Correct drift_deg (and the kind of test), or look at the mount.",
        move=drift,
        grid=_both(ANGLES),
        continuous=True,
        effect="drift",
    ),
    Suspect(
        name="drift as set",
        says=lambda value: (
            f"in runs with a drift angle the model stood turned by {value:+.1f}° "
            f"against the drift that is stated"
        ),
        remedy="Correct drift_deg of these runs, or look at the turntable.",
        move=drift,
        grid=_both(ANGLES),
        continuous=True,
        applies=lambda run: run.kind_of_test.drifts,
        scope="all",
        effect="drift",
    ),
    Suspect(
        name="motion point",
        says=lambda value: (
            f"the motion is that of a point {abs(value):.3f} L "
            f"{'forward' if value > 0 else 'aft'} of the one stated"
        ),
        remedy="Find the point that the encoders refer to and write motion_reference_x.",
        move=point,
        grid=_both(POINTS),
        continuous=True,
        applies=lambda run: run.kind_of_test.yaws or run.kind_of_test.circles,
        effect="motion point",
    ),
    Suspect(
        name="moment point",
        says=lambda value: (
            f"the moments refer to a point {abs(value):.3f} L "
            f"{'forward' if value > 0 else 'aft'} of the one stated"
        ),
        remedy="Find the point to which the moments refer and write moment_reference_x.",
        show=moments_about,
        grid=_both(POINTS),
        continuous=True,
        effect="moment point",
        channels=("N",),
    ),
    Suspect(
        name="velocities in tank axes",
        says=lambda _: "the columns u and v are velocities along and across the tank, not the ship",
        remedy="Call them xdot and ydot, or turn them by the heading.",
        move=velocities_in_tank,
        applies=lambda run: run.kind_of_test.yaws,
        slip=True,
    ),
    Suspect(
        name="mass",
        says=lambda _: (
            "the mass that is taken off as the model's inertia is not the one that oscillated"
        ),
        remedy="Weigh what hangs below the balance (balance_mass), or oscillate the dry model.",
        scope="all",
        effect="inertia",
        free=("mass",),
        by_size=True,
    ),
)
"""All suspects."""
