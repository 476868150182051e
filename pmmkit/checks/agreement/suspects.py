"""What may be wrong with a run or with all: each in words, and as what it does to the records.

A suspect acts on the motion (the model went otherwise than stated) or on what gauges and files
show of the forces. The same description is asked of one run against the others, and of all runs
together. Where the catalogue of effects has the fault, its entry gives the words.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field, replace
from typing import Final

import numpy as np

from pmmkit.campaigns.motion.kinematics import motion_at_phase, move_motion
from pmmkit.campaigns.run import Run
from pmmkit.campaigns.settings import Settings
from pmmkit.checks.agreement.rows import CHANNELS, PHASES, Group, phases
from pmmkit.effects.state import State
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

_MOVES: Final = ("u", "v", "r", "udot", "vdot", "rdot")

Move = Callable[[Group, float], State]
Show = Callable[[Group, Array, float], Array]
Column = Callable[[Group, Array, float], Array]


def _any(run: Run) -> bool:
    return True


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
        Entry of the catalogue, where there is one.
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


def _scaled(*channels: str) -> Show:
    at = [CHANNELS.index(name) for name in channels]

    def show(group: Group, shown: Array, value: float) -> Array:
        out = shown.copy()
        out[:, :, at] *= value
        return out

    return show


def _filtered(factor: Callable[[Array, float], Array], *channels: str) -> Show:
    """Harmonics multiplied by a complex factor of n ω and the value."""
    at = [CHANNELS.index(name) for name in channels or CHANNELS]

    def show(group: Group, shown: Array, value: float) -> Array:
        out = shown.copy()
        n = np.arange(PHASES // 2 + 1)
        rate = n[None, :] * group.omega[:, None]
        gain = (
            factor(rate, value) if factor is not _turned else _turned(n[None, :] + 0 * rate, value)
        )
        for k in at:
            spectrum = np.fft.rfft(shown[:, :, k], axis=1) * gain[:, :, None]
            out[:, :, k] = np.fft.irfft(spectrum, PHASES, axis=1)
        return out

    return show


def _late(rate: Array, seconds: float) -> Array:
    return np.asarray(np.exp(-1j * rate * seconds))


def _turned(number: Array, degrees: float) -> Array:
    return np.asarray(np.exp(-1j * number * math.radians(degrees)))


def _one_pole(rate: Array, seconds: float) -> Array:
    return np.asarray(1 / (1 + 1j * rate * seconds))


def _exchanged(group: Group, shown: Array, value: float) -> Array:
    """Y and N in each other's place: newtons read as newton metres."""
    L = group.campaign.ship.L
    out = shown.copy()
    out[:, :, 1], out[:, :, 2] = L * shown[:, :, 2], shown[:, :, 1] / L
    return out


def _in_tank(group: Group, shown: Array, value: float) -> Array:
    cosine, sine = np.cos(group.heading)[..., None], np.sin(group.heading)[..., None]
    out = shown.copy()
    out[:, :, 0] = shown[:, :, 0] * cosine - shown[:, :, 1] * sine
    out[:, :, 1] = shown[:, :, 0] * sine + shown[:, :, 1] * cosine
    return out


def _moments_about(group: Group, shown: Array, value: float) -> Array:
    """Moments about a point by so many lengths forward of the one stated."""
    out = shown.copy()
    out[:, :, 2] = shown[:, :, 2] - value * shown[:, :, 1]
    return out


def _bent(channel: str) -> Column:
    """What an amplifier that bends takes off: it ends at so many times the largest force."""
    at = CHANNELS.index(channel)

    def column(group: Group, expected: Array, value: float) -> Array:
        force = expected[:, :, at]
        end = value * np.abs(force).max()
        out = np.zeros_like(expected)
        out[:, :, at] = end * np.tanh(force / end) - force
        return group.design(out[..., None])[..., 0]

    return column


def _own_clock(group: Group, expected: Array, seconds: float) -> Array:
    """Forces as much later as each record starts too early."""
    rate = _rate(np.moveaxis(expected, 1, 2).reshape(-1), np.repeat(group.omega, 3 * PHASES))
    late = np.moveaxis(rate.reshape(len(expected), 3, PHASES), 1, 2)
    return -seconds * group.design(late[..., None])[..., 0]


def _other_side(group: Group, value: float) -> State:
    m = group.motion
    return m.with_(v=-m.v, r=-m.r, vdot=-m.vdot, rdot=-m.rdot, delta=-m.delta)


def _drift(group: Group, degrees: float) -> State:
    m, c, s = group.motion, math.cos(math.radians(degrees)), math.sin(math.radians(degrees))
    return m.with_(
        u=c * m.u + s * m.v,
        v=c * m.v - s * m.u,
        udot=c * m.udot + s * m.vdot,
        vdot=c * m.vdot - s * m.udot,
    )


def _point(group: Group, lengths: float) -> State:
    """The recorded motion is that of a point so many lengths forward of the one stated."""
    return move_motion(group.motion, lengths * group.campaign.ship.L)


def _velocities_in_tank(group: Group, value: float) -> State:
    """The columns u and v are velocities along and across the tank."""
    m = group.motion
    psi, omega = group.heading.ravel(), np.repeat(group.omega, PHASES)
    u, v = np.cos(psi) * m.u + np.sin(psi) * m.v, np.cos(psi) * m.v - np.sin(psi) * m.u
    return m.with_(u=u, v=v, udot=_rate(u, omega), vdot=_rate(v, omega))


def _rate(values: Array, omega: Array) -> Array:
    """Time derivative of a history over 32 phases of each run."""
    n = np.arange(PHASES // 2 + 1)
    spectrum = np.fft.rfft(values.reshape(-1, PHASES), axis=1) * (1j * n)
    return np.asarray(np.fft.irfft(spectrum, PHASES, axis=1).ravel() * omega)


def restated(group: Group, of: Callable[[Settings], Settings]) -> State:
    """The motion that other settings would give; where runs recorded theirs, so it changes."""
    change = {name: np.zeros(len(group.motion.u)) for name in _MOVES}
    for place, item in enumerate(group.summaries):
        settings, kind = item.run.settings, item.run.kind_of_test
        if not item.run.dynamic:
            continue
        before, after = (kind.nominal(x, phases()) for x in (settings, of(settings)))
        at = slice(place * PHASES, (place + 1) * PHASES)
        for name, values in change.items():
            values[at] = after.get(name, 0.0) - np.asarray(before.get(name, 0.0))
    return group.motion.with_(
        **{name: getattr(group.motion, name) + values for name, values in change.items()}
    )


def as_set(group: Group, run: Run) -> State:
    """The motion of another run, for a group of one."""
    return move_motion(motion_at_phase(run, phases()), group.campaign.motion_reference_x)


def _amplitude(group: Group, factor: float) -> State:
    def other(settings: Settings) -> Settings:
        sway, yaw = settings.amplitude, settings.yaw_amplitude
        return replace(
            settings,
            amplitude=sway and sway * factor,
            yaw_amplitude=yaw and min(yaw * factor, math.radians(80)),
        )

    return restated(group, other)


def _nominal(run: Run) -> bool:
    return run.dynamic and not run.kind_of_test.surges


def _percent(share: float) -> str:
    return f"{abs(100 * (share - 1)):.1f} % {'larger' if share > 1 else 'smaller'}"


def _sooner(value: float) -> str:
    return "late" if value > 0 else "early"


def _units() -> Iterator[Suspect]:
    for channel in CHANNELS:
        for unit, factor in MOMENT_UNITS if channel == "N" else FORCE_UNITS:
            yield Suspect(
                name=f"{channel} in another unit",
                says=lambda _, c=channel, u=unit: f"{c} is in {u}, not in SI",  # type: ignore[misc]
                remedy=f"State the unit of {channel} under [columns].",
                show=_scaled(channel),
                grid=(1 / factor,),
                slip=True,
                by_size=True,
                channels=(channel,),
            )
        yield Suspect(
            name=f"sign of {channel}",
            says=lambda _, c=channel: f"{c} has the opposite sign",  # type: ignore[misc]
            remedy=f'Turn the sign of {channel} (action = "flip"), or its axis under [axes].',
            show=_scaled(channel),
            grid=(-1.0,),
            slip=True,
            by_size=True,
            channels=(channel,),
        )
        yield Suspect(
            name=f"gain of {channel}",
            says=lambda value, c=channel: (  # type: ignore[misc]
                f"the gauge of {c} shows {abs(100 * (value - 1)):.1f} % too "
                f"{'much' if value > 1 else 'little'} (its gain)"
            ),
            remedy=f"Look at the calibration of {channel} in this run: a weight shows it.",
            show=_scaled(channel),
            grid=(0.3, 0.5, 0.7, *SHARES, 1.5, 2.0),
            continuous=True,
            scope="one",
            effect="fault_gauge_gain",
            channels=(channel,),
        )
        yield Suspect(
            name=f"{channel} late",
            says=lambda value, c=channel: (  # type: ignore[misc]
                f"{c} alone comes {abs(value):.2g} s {_sooner(value)}"
            ),
            remedy=f"Look at the filter and the clock of {channel}: a knock shows them.",
            show=_filtered(_late, channel),
            grid=_both(LAGS),
            continuous=True,
            applies=_dynamic,
            effect="fault_time_lag",
            channels=(channel,),
        )


SUSPECTS: Final[tuple[Suspect, ...]] = (
    *_units(),
    *(
        Suspect(
            name=f"{channel} clipped",
            says=lambda value, c=channel: (  # type: ignore[misc]
                f"the amplifier of {c} bends at large forces: it is clipped softly, to an end of "
                f"{value:.1f} times the largest"
            ),
            remedy=f"Look at the range of the gauge and the amplifier of {channel}.",
            column=_bent(channel),
            grid=(0.9, 1.2, 1.6, 2.2),
            channels=(channel,),
        )
        for channel in ("Y", "N", "X")
    ),
    Suspect(
        name="clocks",
        says=lambda value: (
            f"the clock of each record starts when it likes, early or late by some {value:.1g} s"
        ),
        remedy="Record the motion beside the forces, or a mark that tells the phase.",
        column=_own_clock,
        each_run=True,
        grid=(0.05, 0.15, 0.4),
        applies=_dynamic,
        scope="all",
        effect="fault_time_lag",
    ),
    Suspect(
        name="half of the hull",
        says=lambda _: "the forces are those of half of the hull",
        remedy="State the symmetry ([cfd] symmetry_factor = 2, or a scale of 2).",
        show=_scaled(*CHANNELS),
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
        show=_scaled(*CHANNELS),
        grid=SHARES,
        continuous=True,
        scope="one",
    ),
    Suspect(
        name="Y and N exchanged",
        says=lambda _: "the columns of Y and N are exchanged",
        remedy="Exchange the two columns under [columns].",
        show=_exchanged,
        slip=True,
        by_size=True,
    ),
    Suspect(
        name="forces in tank axes",
        says=lambda _: "X and Y are forces along and across the tank, not the ship",
        remedy="Turn the forces by the heading before they are read.",
        show=_in_tank,
        slip=True,
    ),
    Suspect(
        name="other side",
        says=lambda _: "the drift, the motion and the rudder were to the other side than stated",
        remedy="Correct the sign of the setting (drift_positive, or drift_deg of the run).",
        move=_other_side,
        slip=True,
        applies=lambda run: not run.kind_of_test.pure,
    ),
    Suspect(
        name="half a cycle",
        says=lambda _: "the record starts half a cycle (180°) later than stated",
        remedy="Correct phase_deg of the run by 180°.",
        show=_filtered(_turned),
        grid=(180.0,),
        applies=_dynamic,
        slip=True,
    ),
    Suspect(
        name="phase",
        says=lambda value: f"the forces lag the stated motion by a phase of {value:.1f}°",
        remedy="Correct phase_deg, or record the motion.",
        show=_filtered(_turned),
        grid=_both(DEGREES),
        continuous=True,
        applies=_dynamic,
        effect="fault_time_lag",
    ),
    Suspect(
        name="lag",
        says=lambda value: (
            f"the forces come {abs(value):.2g} s {_sooner(value)} against the motion (a clock)"
        ),
        remedy="Look at the clocks of forces and motion: a knock that both see shows it.",
        show=_filtered(_late),
        grid=_both(LAGS),
        continuous=True,
        applies=_dynamic,
        effect="fault_time_lag",
    ),
    Suspect(
        name="filter",
        says=lambda value: (
            f"a one-pole filter of {value:.2g} s ({1 / (2 * math.pi * value):.2g} "
            f"Hz) makes the forces late"
        ),
        remedy="State the filter, or pass the motion through the same one.",
        show=_filtered(_one_pole),
        grid=LAGS,
        continuous=True,
        applies=_dynamic,
        effect="fault_filter_lag",
    ),
    Suspect(
        name="amplitude",
        says=lambda value: f"the amplitude was {_percent(value)} than stated",
        remedy="Measure the motion, or correct the amplitude of the runs.",
        move=_amplitude,
        grid=SHARES,
        continuous=True,
        applies=_nominal,
        effect="fault_pmm_amplitude",
    ),
    *(
        Suspect(
            name=f"amplitude of {swing}",
            says=lambda value, s=swing: (  # type: ignore[misc]
                f"the amplitude of the runs in {s} was {_percent(value)} than stated"
            ),
            remedy="Measure the motion, or correct the amplitude of these runs.",
            move=_amplitude,
            grid=SHARES,
            continuous=True,
            applies=(lambda run: _nominal(run) and run.kind_of_test.pure == "v")
            if swing == "sway"
            else (lambda run: _nominal(run) and run.kind_of_test.yaws),
            scope="all",
            effect="fault_pmm_amplitude",
        )
        for swing in ("sway", "yaw")
    ),
    Suspect(
        name="peak to peak",
        says=lambda _: "the amplitude is stated peak to peak, twice the true one",
        remedy="State half of it: amplitude_m and yaw_amplitude_deg count from the middle.",
        move=_amplitude,
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
        move=_drift,
        grid=_both(ANGLES),
        continuous=True,
        effect="fault_misalignment",
    ),
    Suspect(
        name="drift as set",
        says=lambda value: (
            f"in runs with a drift angle the model stood turned by {value:+.1f}° "
            f"against the drift that is stated"
        ),
        remedy="Correct drift_deg of these runs, or look at the turntable.",
        move=_drift,
        grid=_both(ANGLES),
        continuous=True,
        applies=lambda run: run.kind_of_test.drifts,
        scope="all",
        effect="fault_misalignment",
    ),
    Suspect(
        name="motion point",
        says=lambda value: (
            f"the motion is that of a point {abs(value):.3f} L "
            f"{'forward' if value > 0 else 'aft'} of the one stated"
        ),
        remedy="Find the point that the encoders refer to and write motion_reference_x.",
        move=_point,
        grid=_both(POINTS),
        continuous=True,
        applies=lambda run: run.kind_of_test.yaws or run.kind_of_test.circles,
        effect="fault_motion_point",
    ),
    Suspect(
        name="moment point",
        says=lambda value: (
            f"the moments refer to a point {abs(value):.3f} L "
            f"{'forward' if value > 0 else 'aft'} of the one stated"
        ),
        remedy="Find the point to which the moments refer and write moment_reference_x.",
        show=_moments_about,
        grid=_both(POINTS),
        continuous=True,
        effect="fault_moment_point",
        channels=("N",),
    ),
    Suspect(
        name="velocities in tank axes",
        says=lambda _: "the columns u and v are velocities along and across the tank, not the ship",
        remedy="Call them xdot and ydot, or turn them by the heading.",
        move=_velocities_in_tank,
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
        effect="fault_inertia",
        free=("mass",),
        by_size=True,
    ),
)
"""All suspects."""
