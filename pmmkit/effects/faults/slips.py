"""Slips of the hand: what a file or a campaign states is not what was measured at all.

They are found by the checks before anything is fitted, and have no size to be fitted.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Final

import numpy as np

from pmmkit.effects.definition import Effect, Parameter
from pmmkit.effects.faults.fault import suspicion
from pmmkit.effects.seen import Forces, Observed
from pmmkit.effects.suspect import CHANNELS, Suspect

FORCE_UNITS: Final = (("kilogram-force (kgf)", 9.80665), ("pound-force (lbf)", 4.4482216))
MOMENT_UNITS: Final = (
    ("kilogram-force metre (kgf m)", 9.80665),
    ("pound-force foot (lbf ft)", 1.3558179),
    ("pound-force (lbf m)", 4.4482216),
)
_FACTORS: Final = tuple(Parameter(name=c, text=f"{c} shown over {c}, less 1") for c in CHANNELS)


def times(run: Observed, at: Mapping[str, float]) -> Forces:
    """Channels shown larger by a factor."""
    return {c: (1.0 + at[c]) * run.forces[c] for c in CHANNELS if at[c] and c in run.forces}


def exchanged(run: Observed, at: Mapping[str, float]) -> Forces:
    """Y and N in each other's column: newtons read as newton metres."""
    del at
    return {"Y": run.forces["N"], "N": run.forces["Y"]}


def forces_in_tank(run: Observed, at: Mapping[str, float]) -> Forces:
    """Forces along and across the tank."""
    del at
    c, s = np.cos(run.heading), np.sin(run.heading)
    X, Y = run.forces["X"], run.forces["Y"]
    return {"X": run.times(X, c) - run.times(Y, s), "Y": run.times(X, s) + run.times(Y, c)}


def velocities_in_tank(run: Observed, at: Mapping[str, float]) -> Forces:
    """The columns u and v are velocities along and across the tank."""
    del at
    m, c, s = run.motion, np.cos(run.heading), np.sin(run.heading)
    u, v = c * m.u + s * m.v, c * m.v - s * m.u
    return run.along(
        m.with_(
            u=u, v=v, udot=c * m.udot + s * m.vdot + m.r * v, vdot=c * m.vdot - s * m.udot - m.r * u
        )
    )


def other_side(run: Observed, at: Mapping[str, float]) -> Forces:
    """The motion and the rudder to the other side."""
    del at
    m = run.motion
    return run.along(m.with_(v=-m.v, r=-m.r, vdot=-m.vdot, rdot=-m.rdot, delta=-m.delta))


def _in_unit(channel: str, unit: str, factor: float) -> Suspect:
    return Suspect(
        name=f"{channel} in another unit",
        says=lambda _: f"{channel} is in {unit}, not in SI",
        remedy=f"State the unit of {channel} under [columns].",
        at=lambda value: {channel: value - 1.0},
        grid=(1 / factor,),
        slip=True,
        by_size=True,
        channels=(channel,),
    )


def _units(channel: str) -> Iterator[Suspect]:
    for unit, factor in MOMENT_UNITS if channel == "N" else FORCE_UNITS:
        yield _in_unit(channel, unit, factor)


def _sign(channel: str) -> Suspect:
    return Suspect(
        name=f"sign of {channel}",
        says=lambda _: f"{channel} has the opposite sign",
        remedy=f'Turn the sign of {channel} (action = "flip"), or its axis under [axes].',
        at=lambda value: {channel: value - 1.0},
        grid=(-1.0,),
        slip=True,
        by_size=True,
        channels=(channel,),
    )


EFFECTS: Final[tuple[Effect, ...]] = (
    suspicion(
        "slip_unit",
        "slips",
        "A channel in another unit than stated.",
        times,
        tuple(suspect for channel in CHANNELS for suspect in _units(channel)),
        parameters=_FACTORS,
        in_words="Unit stated wrong",
    ),
    suspicion(
        "slip_sign",
        "slips",
        "A channel with the opposite sign.",
        times,
        tuple(map(_sign, CHANNELS)),
        parameters=_FACTORS,
        in_words="Sign stated wrong",
    ),
    suspicion(
        "slip_half_hull",
        "slips",
        "Forces of half of the hull, as a computation with a plane of symmetry gives them.",
        times,
        (
            Suspect(
                name="half of the hull",
                says=lambda _: "the forces are those of half of the hull",
                remedy="State the symmetry ([cfd] symmetry_factor = 2, or a scale of 2).",
                at=lambda value: dict.fromkeys(CHANNELS, value - 1.0),
                grid=(0.5,),
                slip=True,
                by_size=True,
            ),
        ),
        parameters=_FACTORS,
        in_words="Forces of half a hull",
    ),
    suspicion(
        "slip_exchanged_channels",
        "slips",
        "The columns of the side force and of the moment exchanged.",
        exchanged,
        (
            Suspect(
                name="Y and N exchanged",
                says=lambda _: "the columns of Y and N are exchanged",
                remedy="Exchange the two columns under [columns].",
                slip=True,
                by_size=True,
            ),
        ),
    ),
    suspicion(
        "slip_forces_in_tank_axes",
        "slips",
        "Forces along and across the tank instead of the ship.",
        forces_in_tank,
        (
            Suspect(
                name="forces in tank axes",
                says=lambda _: "X and Y are forces along and across the tank, not the ship",
                remedy='State forces_in = "carriage" under [cfd].',
                slip=True,
            ),
        ),
    ),
    suspicion(
        "slip_other_side",
        "slips",
        "Motion and rudder to the other side than stated.",
        other_side,
        (
            Suspect(
                name="other side",
                says=lambda _: (
                    "the drift, the motion and the rudder were to the other side than stated"
                ),
                remedy="Correct the sign of the setting (drift_positive, or drift_deg of the run).",
                slip=True,
                applies=lambda kind: not kind.pure,
            ),
        ),
        in_words="Side stated wrong",
    ),
    suspicion(
        "slip_velocities_in_tank_axes",
        "slips",
        "Velocities along and across the tank instead of the ship.",
        velocities_in_tank,
        (
            Suspect(
                name="velocities in tank axes",
                says=lambda _: (
                    "the columns u and v are velocities along and across the tank, not the ship"
                ),
                remedy="Call them xdot and ydot, or turn them by the heading.",
                applies=lambda kind: kind.yaws,
                slip=True,
            ),
        ),
    ),
)
