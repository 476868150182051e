"""What is run: the three programmes of `sizes.toml`, run by run."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Literal

from pmmkit import Limits
from pmmkit.campaigns import Settings
from pmmkit.diagnosis import Option
from pmmkit.diagnosis.planning.options import timed

from .sizes import FIGURES, MIDDLE_SPEED, SHIP

Sided = Literal["both", "one"]
HIGHEST_TAU = 0.25
"""Above ωU/g = 1/4 waves no longer leave the model behind; the rig slows to omega' 2.6 there."""


@dataclass(frozen=True, kw_only=True)
class Plan:
    """One run as it is asked for, SI and radians; all that the user of the data is told."""

    id: str
    test: str
    speed: float
    drift: float = 0.0
    rudder: float = 0.0
    omega: float = 0.0
    sway: float = 0.0
    """Amplitude of the sway displacement [m]."""
    yaw: float = 0.0
    """Amplitude of the heading [rad]."""
    repeat_of: str | None = None

    @property
    def dynamic(self) -> bool:
        return self.omega > 0


def plans(programme: str, sided: Sided = "both") -> tuple[Plan, ...]:
    """The runs of a programme.

    With `sided` "one", settings to port are replaced by three quarters of the same to starboard:
    as many runs, none to port.
    """
    spec = FIGURES["programmes"][programme]
    made = [
        plan
        for speed in spec["speeds"]
        for plan in (*_hull(spec, speed, sided), *_rudder(spec, speed, sided))
    ]
    for words in spec.get("repeats_at_1_5", ()):
        original = next(plan for plan in made if _is(plan, words))
        made.append(replace(original, id=original.id + "_again", repeat_of=original.id))
    return tuple(made)


def asked(option: Option, number: int = 0) -> Plan:
    """A run that a plan of the package asks for; `number` tells repeats apart."""
    s = option.settings
    return Plan(
        id=f"{option.id}_{number}",
        test=option.test,
        speed=s.speed,
        drift=s.drift,
        rudder=s.rudder,
        omega=s.omega or 0.0,
        sway=s.amplitude or 0.0,
        yaw=s.yaw_amplitude or 0.0,
    )


def options(programme: str, limits: Limits) -> tuple[Option, ...]:
    """The runs of a programme as options of a plan."""
    found = []
    for plan in plans(programme):
        settings = Settings(
            speed=plan.speed,
            drift=plan.drift,
            rudder=plan.rudder,
            amplitude=plan.sway or None,
            yaw_amplitude=plan.yaw or None,
            period=2 * math.pi / plan.omega if plan.dynamic else None,
        )
        option = timed(plan.test, settings, limits, SHIP)
        assert option is not None
        found.append(option)
    return tuple(found)


def _is(plan: Plan, words: str) -> bool:
    test, value = words.split()
    start = {"static_drift": "SD", "pure_sway": "SW", "pure_yaw": "YW"}[test]
    return plan.id.startswith(f"{start}_{MIDDLE_SPEED:.1f}_{float(value):g}_".removesuffix("_"))


def _fold(degrees: float, sided: Sided) -> float:
    return -0.75 * degrees if sided == "one" and degrees < 0 else degrees


def _hull(spec: dict, speed: float, sided: Sided) -> Iterator[Plan]:
    for given in spec["static_drift_deg"]:
        beta = _fold(given, sided)
        name = f"SD_{speed:.1f}_{beta:g}"
        yield Plan(id=name, test="static_drift", speed=speed, drift=math.radians(beta))
    for v, w in spec["pure_sway"]:
        omega = frequency(w, speed)
        yield Plan(
            id=f"SW_{speed:.1f}_{v:g}",
            test="pure_sway",
            speed=speed,
            omega=omega,
            sway=v * speed / omega,
        )
    for r, w in spec["pure_yaw"]:
        omega = frequency(w, speed)
        yield Plan(
            id=f"YW_{speed:.1f}_{r:g}",
            test="pure_yaw",
            speed=speed,
            omega=omega,
            yaw=r * speed / SHIP.L / omega,
        )
    for r, w, beta in spec.get("yaw_drift", ()):
        omega = frequency(w, speed)
        yield Plan(
            id=f"YD_{speed:.1f}_{r:g}_{beta:g}",
            test="yaw_drift",
            speed=speed,
            omega=omega,
            yaw=r * speed / SHIP.L / omega,
            drift=math.radians(beta),
        )
    for v, r, w in spec.get("sway_yaw", ()):
        omega = frequency(w, speed)
        yaw = r * speed / SHIP.L / omega
        # The heading leads the sway (negative amplitude): v = (aω cos ψ - U sin ψ) at ψ = yaw.
        sway = (v + math.sin(yaw)) / math.cos(yaw) * speed / omega
        yield Plan(
            id=f"SY_{speed:.1f}_{v:g}_{r:g}",
            test="sway_yaw",
            speed=speed,
            omega=omega,
            sway=sway,
            yaw=-yaw,
        )


def _rudder(spec: dict, speed: float, sided: Sided) -> Iterator[Plan]:
    middle = speed == MIDDLE_SPEED
    alone = [*spec.get("static_rudder_deg", ())]
    combined = [*spec.get("drift_rudder_deg", ())]
    if middle:
        alone += spec.get("static_rudder_deg_at_1_5", ())
        combined += spec.get("drift_rudder_deg_at_1_5", ())
    for given in alone:
        delta = _fold(given, sided)
        yield Plan(
            id=f"RS_{speed:.1f}_{delta:g}",
            test="static_rudder",
            speed=speed,
            rudder=math.radians(delta),
        )
    for beta, given in combined:
        delta = _fold(given, sided)
        yield Plan(
            id=f"DR_{speed:.1f}_{beta:g}_{delta:g}",
            test="drift_rudder",
            speed=speed,
            drift=math.radians(beta),
            rudder=math.radians(delta),
        )


def frequency(omega_prime: float, speed: float, g: float = 9.81) -> float:
    """Angular frequency [rad/s]; omega' 2.6 where the asked one passes ωU/g = 1/4."""
    omega = omega_prime * speed / SHIP.L
    if omega * speed / g > HIGHEST_TAU:
        omega = 2.6 * speed / SHIP.L
    return omega
