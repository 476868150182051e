"""Faults of a measurement: one size for all runs and channels is what betrays them."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Final

import numpy as np

from pmmkit.diagnosis.captive.base import Base, Forces
from pmmkit.diagnosis.captive.candidate import Candidate, Columns, spread_over
from pmmkit.effects.catalogue import effect_of
from pmmkit.effects.state import State
from pmmkit.numerics import Array
from pmmkit.observations.views import View

STEP: Final = 1e-4


def _one(view: View, forces: Forces | Mapping[str, Array]) -> Mapping[str, Array]:
    return spread_over(view, {channel: [values] for channel, values in forces.items()}, 1)


def _turned(view: View, base: Base, value: float) -> Mapping[str, Array]:
    """The model stands turned by a degree on the carriage: its drift is larger than stated."""
    del value

    def moved(view: View) -> tuple[State, float]:
        m = view.motion
        c, s = math.cos(STEP), math.sin(STEP)
        return m.with_(
            u=c * m.u + s * m.v,
            v=c * m.v - s * m.u,
            udot=c * m.udot + s * m.vdot,
            vdot=c * m.vdot - s * m.udot,
        ), view.speed

    return _one(view, base.change(view, moved, math.degrees(STEP)))


def _drift_of_the_tank(view: View, base: Base, value: float) -> Mapping[str, Array]:
    """Water that moves across the tank to starboard [m/s]."""
    del value
    step = 1e-4

    def moved(view: View) -> tuple[State, float]:
        m, psi = view.motion, view.heading
        return m.with_(
            u=m.u - step * np.sin(psi),
            v=m.v - step * np.cos(psi),
            udot=m.udot - step * np.cos(psi) * m.r,
            vdot=m.vdot + step * np.sin(psi) * m.r,
        ), view.speed

    return _one(view, base.change(view, moved, step))


def _zero(view: View, base: Base, value: float) -> Mapping[str, Array]:
    """Constant newtons of the gauges."""
    del base, value
    constant, zero = view.project(np.ones(len(view.t))), np.zeros(view.rows)
    return spread_over(view, {"Y": [constant, zero], "N": [zero, constant]}, 2)


def _predicted(view: View, base: Base) -> Forces:
    """Harmonics of what the gauges show according to the base."""
    return {channel: view.pick(x) for channel, x in base.expected(view).items()}


def _turn(harmonics: Array, factors: list[complex]) -> Array:
    """Harmonics multiplied by complex factors (those of a filter)."""
    found = np.zeros_like(harmonics)
    found[0] = (factors[0] * harmonics[0]).real
    for n in range(1, (len(harmonics) - 1) // 2 + 1):
        value = (harmonics[2 * n - 1] - 1j * harmonics[2 * n]) * factors[n]
        found[2 * n - 1], found[2 * n] = value.real, -value.imag
    return found


def _orders(view: View) -> range:
    return range((len(view.every if view.every is not None else view.projection) - 1) // 2 + 1)


def _clock(view: View, base: Base, value: float) -> Mapping[str, Array]:
    """Forces that come a second late."""
    del value
    factors = [-1j * n * view.omega for n in _orders(view)]
    return _one(view, {c: view.pick(_turn(x, factors)) for c, x in base.expected(view).items()})


def _filter(view: View, base: Base, corner: float) -> Mapping[str, Array]:
    """A one-pole filter of a corner frequency [Hz] on the forces."""
    factors = [
        1.0 / (1.0 + 1j * n * view.omega / (2 * math.pi * corner)) - 1.0 for n in _orders(view)
    ]
    return _one(view, {c: view.pick(_turn(x, factors)) for c, x in base.expected(view).items()})


def _cross_talk(view: View, base: Base, value: float) -> Mapping[str, Array]:
    """Share of one channel in another: Y in X (0), X in Y (1)."""
    found = _predicted(view, base)
    if "X" not in found or "Y" not in found:
        return {}
    return _one(view, {"X": found["Y"]} if value == 0.0 else {"Y": found["X"]})


def _gain(view: View, base: Base, value: float) -> Mapping[str, Array]:
    del value
    found = _predicted(view, base)
    return _one(view, {"Y": found["Y"]}) if "Y" in found else {}


def _point(view: View, base: Base, value: float) -> Mapping[str, Array]:
    del value
    found = _predicted(view, base)
    return _one(view, {"N": base.ship.L * found["Y"]}) if {"Y", "N"} <= set(found) else {}


def _inertia(view: View, base: Base, value: float) -> Mapping[str, Array]:
    """A share of the ship's mass left in the forces."""
    del value
    m, mass = view.motion, base.ship.mass
    return _one(
        view,
        {
            "X": view.project(-mass * (m.udot - m.v * m.r)),
            "Y": view.project(-mass * (m.vdot + m.u * m.r)),
        },
    )


def _amplitude(view: View, base: Base, value: float) -> Mapping[str, Array]:
    """Sway larger than stated by a share, in tests that sway."""
    del value
    if not view.run.kind_of_test.sways:
        return {}

    def moved(view: View) -> tuple[State, float]:
        m = view.motion
        return m.with_(v=m.v * (1 + STEP), vdot=m.vdot * (1 + STEP)), view.speed

    return _one(view, base.change(view, moved, STEP))


def _phase(view: View, base: Base, combined: float) -> Mapping[str, Array]:
    """Rams a degree out of step: sway follows the acceleration across the tank, ψ̇ U with v̇.

    In tests that yaw alone, or (1) in those that sway and yaw at once as well.
    """
    kind = view.run.kind_of_test
    if not kind.yaws or (kind.sways and not combined) or view.omega == 0.0:
        return {}

    def moved(view: View) -> tuple[State, float]:
        m = view.motion
        swing = m.v - np.mean(m.v)
        across = m.vdot + view.speed * m.r
        rate = view.speed * m.rdot - view.omega**2 * swing
        gain = STEP / view.omega
        return m.with_(v=m.v + gain * across, vdot=m.vdot + gain * rate), view.speed

    return _one(view, base.change(view, moved, math.degrees(STEP)))


def _carriage(view: View, base: Base, speed: float) -> Mapping[str, Array]:
    """The carriage faster than stated by a share, at one speed."""
    if speed == 0.0 or abs(view.speed / speed - 1) > 0.02:
        return {}

    def moved(view: View) -> tuple[State, float]:
        m = view.motion
        v = m.v if view.run.kind_of_test.sways else m.v * (1 + STEP)
        return m.with_(u=m.u * (1 + STEP), v=v), view.speed * (1 + STEP)

    return _one(view, base.change(view, moved, STEP))


def _creep(view: View, base: Base, value: float) -> Mapping[str, Array]:
    """Gauges that creep over a record [N/min, N m/min]."""
    del base, value
    grown, zero = view.project(view.t / 60.0), np.zeros(view.rows)
    return spread_over(view, {"Y": [grown, zero], "N": [zero, grown]}, 2)


def fault_of(
    name: str,
    columns: Columns,
    *,
    grid: tuple[float, ...] = (0.0,),
    centre: tuple[float, ...] = (),
    continuous: bool = False,
) -> Candidate:
    """A fault of the catalogue with its columns."""
    effect = effect_of(name)
    inner = [item.text for item in effect.parameters if item.typical is None]
    return Candidate(
        name=name,
        family=effect.family,
        kind="fault",
        summary=effect.summary,
        coefficients=tuple(f"{item.name} [{item.unit}]" for item in effect.coefficients),
        typical=tuple(item.typical or 0.0 for item in effect.coefficients),
        columns=columns,
        grid=grid,
        parameter="".join(inner),
        centre=centre,
        continuous=continuous,
        check=effect.check,
        excites=effect.excites,
    )


FAULTS: Final = (
    fault_of("fault_misalignment", _turned),
    fault_of("current", _drift_of_the_tank),
    fault_of("fault_gauge_zero", _zero),
    fault_of("fault_time_lag", _clock),
    fault_of(
        "fault_filter_lag",
        _filter,
        grid=(1.0, 1.4, 2.0, 2.8, 4.0, 6.0, 10.0),
        centre=(1.0,),
        continuous=True,
    ),
    fault_of("fault_cross_talk", _cross_talk, grid=(0.0, 1.0)),
    fault_of("fault_gauge_gain", _gain),
    fault_of("fault_moment_point", _point),
    fault_of("fault_inertia", _inertia),
    fault_of("fault_pmm_amplitude", _amplitude),
    fault_of("fault_pmm_phase", _phase, grid=(0.0, 1.0)),
    fault_of("fault_gauge_drift", _creep),
)


def carriage_fault(speeds: tuple[float, ...]) -> Candidate:
    """The carriage's speed wrong at one of the speeds tested."""
    return fault_of("fault_carriage_speed", _carriage, grid=speeds)
