"""What may be hidden: how much of it is usual for each ship, and which names say it rightly."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass

from .container import Container
from .hidden import NOTHING, Hidden
from .sailing import Ship
from .tanker import Tanker

Make = Callable[[float], Hidden]


@dataclass(frozen=True, kw_only=True)
class Fleet:
    """A ship under the names that her users know.

    Parameters
    ----------
    title : str
        Her name for people.
    model : str
        Library ship that is exact where nothing is hidden.
    build : callable
        The ship with what is hidden.
    step, interval : float
        Of the integration and of the record [s].
    slow, fast : (float, ...)
        Approach speeds to draw from [m/s].
    turn, zigzag : float
        Length of records [s].
    noise : mapping of channel to float
        Standard deviations.
    wind : float
        True wind, where there is one [m/s].
    """

    title: str
    model: str
    build: Callable[[Hidden], Ship]
    step: float
    interval: float
    slow: tuple[float, ...]
    fast: tuple[float, ...]
    turn: float
    zigzag: float
    noise: Mapping[str, float]
    wind: float


@dataclass(frozen=True)
class Case:
    """A hidden effect: its size for 1, by ship; names of which one each has to be said.

    Where no sign is usual, a campaign draws one (`either`). `start` is the model of a user who
    leaves out what is hidden, where that is not the ship herself. `told`: whether a catalogue could
    name it.
    """

    make: Mapping[str, Make]
    expect: tuple[tuple[str, ...], ...] = ()
    either: bool = False
    start: str | None = None
    told: bool = True

    @property
    def verdict(self) -> str:
        if not self.told:
            return "unexplained"
        return "missing_effect" if self.expect else "noise"


DEGREE = math.pi / 180.0
FLEETS: Mapping[str, Fleet] = {
    "s175": Fleet(
        title="S175", model="s175", build=Container, step=0.25, interval=0.5,
        slow=(6.5, 7.0, 7.5), fast=(9.5, 10.0, 10.5), turn=600.0, zigzag=420.0, wind=11.0,
        noise={
            "x": 0.3, "y": 0.3, "psi": 0.1 * DEGREE, "u": 0.02, "v": 0.02, "r": 0.01 * DEGREE,
            "phi": 0.1 * DEGREE, "delta": 0.05 * DEGREE, "wind_speed": 0.3,
            "wind_direction": 0.5 * DEGREE,
        },
    ),
    "kvlcc2-l7": Fleet(
        title="KVLCC2", model="kvlcc2-l7", build=Tanker, step=0.05, interval=0.1,
        slow=(0.8, 0.9, 1.0), fast=(1.1, 1.179, 1.25), turn=150.0, zigzag=120.0, wind=2.0,
        noise={
            "x": 0.01, "y": 0.01, "psi": 0.1 * DEGREE, "u": 0.004, "v": 0.004, "r": 0.05 * DEGREE,
            "delta": 0.05 * DEGREE, "wind_speed": 0.1, "wind_direction": 0.5 * DEGREE,
        },
    ),
}  # fmt: skip
"""Ships by name; the noise of ten samples a second on the model allows what half a second does on
the ship."""


def _both(make: Make) -> Mapping[str, Make]:
    return dict.fromkeys(FLEETS, make)


def _each(s175: Make, kvlcc2: Make) -> Mapping[str, Make]:
    return dict(zip(FLEETS, (s175, kvlcc2), strict=True))


CASES: Mapping[str, Case] = {
    "none": Case(_both(lambda s: NOTHING)),
    "roll": Case(
        {"s175": lambda s: Hidden(heel=s)}, (("heel_coupling", "roll"),), start="s175-3dof"
    ),
    "asymmetry": Case(
        _both(lambda s: Hidden(side=1e-4 * s, turn=-4.5e-5 * s)),
        (("asymmetry", "fault_rudder_zero"),),
        either=True,
    ),
    "rudder_zero": Case(
        _both(lambda s: Hidden(rudder_zero=0.5 * DEGREE * s)),
        (("fault_rudder_zero", "asymmetry"),),
        either=True,
    ),
    "current": Case(
        _each(
            lambda s: Hidden(current=(0.25 * s, -0.18 * s)),
            lambda s: Hidden(current=(0.03 * s, -0.025 * s)),
        ),
        (("current",),),
        either=True,
    ),
    "wind": Case(_both(lambda s: Hidden(windage=s)), (("wind",),)),
    "straightening": Case(
        _each(
            lambda s: Hidden(straightening=0.1 * s, crossing=-0.1 * s),
            lambda s: Hidden(straightening=0.15 * s, crossing=-0.2 * s),
        ),
        (("flow_straightening",),),
        either=True,
    ),
    "hull_rudder": Case(
        _both(lambda s: Hidden(hull_share=0.1 * s, hull_point=-0.15 * s, steering_drag=0.1 * s)),
        (("rudder_hull_interaction",),),
        either=True,
    ),
    "drift_wake": Case(
        _each(lambda s: Hidden(drift_wake=0.4 * s), lambda s: Hidden(drift_wake=0.3 * s)),
        (("wake_in_drift",),),
        either=True,
    ),
    "resistance": Case(
        _both(lambda s: Hidden(resistance=0.15 * s)),
        (("resistance_curve", "scale_effect", "propeller_load"),),
        either=True,
    ),
    "propulsion": Case(
        _both(lambda s: Hidden(wake=0.08 * s, deduction=0.05 * s)),
        (("propeller_load", "scale_effect", "resistance_curve"),),
        either=True,
    ),
    "coupling": Case(
        _both(lambda s: Hidden(vvr=(0.0214 * s, -0.0424 * s), vrr=(-0.0405 * s, 0.00156 * s))),
        (("yaw_sway_coupling",),),
    ),
    "sway_drag": Case(
        _both(lambda s: Hidden(plate=0.41 * s)), (("modulus_sway_drag", "crossflow_drag"),)
    ),
    "cross_flow": Case(
        _both(lambda s: Hidden(strips=0.55 * s)), (("crossflow_drag", "modulus_sway_drag"),)
    ),
    "yaw_drag": Case(
        _both(lambda s: Hidden(ends=1.1 * s)), (("modulus_yaw_drag", "crossflow_drag"),)
    ),
    "stall": Case(_both(lambda s: Hidden(stalled=s)), (("rudder_stall",),)),
    "surge_coupling": Case(_both(lambda s: Hidden(vr=0.0039 * s)), (("surge_yaw_coupling",),)),
    "bottom": Case(_both(lambda s: Hidden(bottom=0.16 * s)), (("shallow_water",),)),
    "memory": Case(
        _both(lambda s: Hidden(late_side=-0.00232 * s, late_turn=-0.00077 * s)), (("memory",),)
    ),
    "clock": Case(
        _each(lambda s: Hidden(late_positions=1.0 * s), lambda s: Hidden(late_positions=0.2 * s)),
        (("fault_clock_lag", "fault_time_lag"),),
    ),
    "antenna": Case(
        _each(lambda s: Hidden(antenna=20.0 * s), lambda s: Hidden(antenna=0.8 * s)),
        (("fault_antenna", "fault_motion_point"),),
        either=True,
    ),
    "heading": Case(
        _both(lambda s: Hidden(heading_offset=DEGREE * s)),
        (("fault_heading_offset", "fault_heading_zero", "fault_misalignment"),),
        either=True,
    ),
    "log": Case(
        _both(lambda s: Hidden(log_gain=0.03 * s)),
        (("fault_log_gain", "fault_log_calibration", "fault_log"),),
        either=True,
    ),
    "play": Case(_both(lambda s: Hidden(play=2.0 * DEGREE * s)), told=False),
    "bank": Case(_both(lambda s: Hidden(bank=0.001 * s)), told=False),
    "tether": Case(_both(lambda s: Hidden(tether=0.0002 * s)), told=False),
    "ventilation": Case(_both(lambda s: Hidden(ventilated=0.4 * s)), told=False),
}
