"""What a captive test is set to: the nominal motion, exact in every angle.

The tank axes are x along the rails and y to starboard; the carriage runs at Uc; heading ψ to
starboard. With θ = ωt + phase:

===========  ===============================================  =================================
test         path and heading                                 so that
===========  ===============================================  =================================
static       straight, heading β                              u = U cos β, v = -U sin β
circular     circle at speed U, drift β, r = U/radius         the same u and v, r constant
pure_surge   x = Uc t + a sin θ, heading β                    u = Uc + aω cos θ at β = 0
pure_sway    y = a sin θ, heading β (usually 0)               u = Uc, v = aω cos θ at β = 0
pure_yaw     ψ = ψ0 sin θ, dy/dt = Uc tan ψ                   v = 0, u = Uc/cos ψ
yaw_drift    the path of pure yaw, heading ψ + β              u, v = Uc/cos ψ (cos β, -sin β)
yaw_rudder   pure yaw with the rudder held                    as pure yaw
sway_yaw     y = a sin θ, ψ = -ψ0 cos θ (heading ψ + β)       r = ψ0 ω sin θ
===========  ===============================================  =================================

In ``sway_yaw`` the heading lags the sway displacement by a quarter period, so yaw rate and sway
velocity are in quadrature: r ∝ sin θ, and v = -Uc sin ψ + aω cos ψ cos θ, which is ∝ cos θ to
first order.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import ArrayLike

from pmmkit.campaigns.run import FREE_TESTS, Run, Settings
from pmmkit.effects.state import State
from pmmkit.errors import CampaignError, Problem
from pmmkit.numerics import Array

YAW_LEAD: Final = -math.pi / 2
"""Lead of the heading over the sway displacement in ``sway_yaw`` [rad]."""
YAW_TESTS: Final = ("pure_yaw", "yaw_drift", "yaw_rudder")

_NEEDS: Final = {
    "pure_surge": ("period", "amplitude"),
    "pure_sway": ("period", "amplitude"),
    **dict.fromkeys(YAW_TESTS, ("period", "yaw_amplitude")),
    "sway_yaw": ("period", "amplitude", "yaw_amplitude"),
}


@dataclass(frozen=True, kw_only=True)
class TankMotion:
    """Velocities and accelerations in tank axes, heading and its derivatives."""

    xdot: Array
    ydot: Array
    xddot: Array
    yddot: Array
    psi: Array
    r: Array
    rdot: Array


def nominal_motion(run: Run, times: ArrayLike) -> State:
    """Motion that the test was set to, exact in every angle.

    Parameters
    ----------
    run : Run
        A captive test. Its motion reference point follows the path; where that is not midship,
        see `move_motion`.
    times : array (n,)
        Times [s].

    Returns
    -------
    State
        ``udot``, ``vdot`` are the time derivatives of the ship-axes components u and v. Heel,
        rudder and revolutions are the settings; unknown revolutions and thrust are zero.

    Raises
    ------
    CampaignError
        If the run lacks a setting that its test needs, or is a free-running test.

    Examples
    --------
    >>> from pmmkit.campaigns.run import Settings
    >>> run = Run(id="PY", test="pure_yaw", kind="history", loader=None,
    ...           settings=Settings(speed=1.5, period=10.0, yaw_amplitude=0.2))
    >>> state = nominal_motion(run, [0.0, 2.5])
    >>> state.u.round(6), state.r.round(6)
    (array([1.5     , 1.530508]), array([0.125664, 0.      ]))
    """
    phase = nominal_phase(run, as_times(run, times))
    return motion_at_phase(run, phase)


def motion_at_phase(run: Run, theta: ArrayLike) -> State:
    """Nominal motion at given phases θ of the displacement; any phases for a static test.

    Parameters
    ----------
    run : Run
        A captive test.
    theta : array (n,)
        Phases [rad].

    Raises
    ------
    CampaignError
        As `nominal_motion`.
    """
    require_settings(run)
    phase = as_times(run, theta)
    settings = run.settings
    motion: Mapping[str, float | Array]
    if run.test in YAW_TESTS:
        motion = _zero_sway_path(settings, phase)
    elif run.dynamic:
        motion = ship_axes(tank_motion(run, phase))
    else:
        motion = {
            "u": settings.speed * math.cos(settings.drift),
            "v": -settings.speed * math.sin(settings.drift),
            "r": turn_rate(run),
        }
    return State.of(len(phase), **{**fixed_settings(settings), **motion})


def fixed_settings(settings: Settings) -> dict[str, float | Array]:
    """Heel, rudder and revolutions that the test holds, by their names in `State`."""
    """Heel, rudder and propeller as they were set."""
    return {"phi": settings.heel, "delta": settings.rudder, "rps": settings.propeller_rps or 0.0}


def as_times(run: Run, times: ArrayLike) -> Array:
    """Times (or phases) as an array (n,); a CampaignError where there are none."""
    """Times as finite numbers [s]."""
    instants = np.atleast_1d(np.asarray(times, float))
    if instants.ndim != 1 or instants.size == 0:
        raise CampaignError(Problem(message="there are no times at all.", run=run.id))
    return instants


def turn_rate(run: Run) -> float:
    """Yaw rate of circular motion [rad/s], the stated one before U/radius; else zero."""
    """Yaw rate of circular motion [rad/s]."""
    settings = run.settings
    if run.test != "circular_motion":
        return 0.0
    if settings.yaw_rate is not None:
        return settings.yaw_rate
    return settings.speed / (settings.radius or math.inf)


def refuse_free_running(run: Run) -> None:
    """Raise a CampaignError for a free-running test."""
    """Refuse tests whose motion nobody prescribes."""
    if run.test in FREE_TESTS:
        raise CampaignError(
            Problem(
                message=f"a {run.test} test is free running: its motion is a result, not a "
                f"setting.",
                run=run.id,
            )
        )


def require_settings(run: Run) -> None:
    """Raise a CampaignError naming all settings that the nominal motion lacks."""
    """Refuse a run that lacks what its test needs."""
    refuse_free_running(run)
    check_settings(run, _NEEDS.get(run.test, ()))


def check_settings(run: Run, needed: Sequence[str]) -> None:
    """Raise a CampaignError naming those of some settings that are missing or impossible."""
    """Refuse a run that lacks some settings, all named at once."""
    settings = run.settings
    wrong = [
        f"a {run.test} test needs the setting {name}."
        for name in needed
        if getattr(settings, name) is None
    ]
    if settings.period is not None and not 0 < settings.period < math.inf and "period" in needed:
        wrong.append(f"the period must be positive, not {settings.period:g} s.")
    if "yaw_amplitude" in needed and abs(settings.yaw_amplitude or 0.0) >= math.pi / 2:
        wrong.append(
            f"the heading amplitude is {math.degrees(settings.yaw_amplitude or 0.0):g}°; it must "
            f"be below 90°."
        )
    if run.test == "circular_motion" and settings.yaw_rate is None and not settings.radius:
        wrong.append("a circular_motion test needs yaw_rate, or a radius that is not zero.")
    if wrong:
        raise CampaignError([Problem(message=message, run=run.id) for message in wrong])


def omega_of(run: Run) -> float:
    """Angular frequency of the oscillation [rad/s]; zero without a period."""
    """Angular frequency of an oscillating run [rad/s]."""
    return 2 * math.pi / (run.settings.period or math.inf)


def nominal_phase(run: Run, times: Array) -> Array:
    """Phase ωt + phase of the displacement [rad], array (n,)."""
    """Phase ωt + phase of the displacement [rad]."""
    return omega_of(run) * times + run.settings.phase


def _zero_sway_path(settings: Settings, theta: Array) -> dict[str, Array]:
    omega, amplitude = settings.omega or 0.0, settings.yaw_amplitude or 0.0
    psi = amplitude * np.sin(theta)
    r = amplitude * omega * np.cos(theta)
    along = settings.speed / np.cos(psi)
    gain = along * np.tan(psi) * r
    ahead, aside = math.cos(settings.drift), -math.sin(settings.drift)
    return {
        "u": along * ahead,
        "v": along * aside,
        "r": r,
        "udot": gain * ahead,
        "vdot": gain * aside,
        "rdot": -amplitude * omega**2 * np.sin(theta),
    }


def tank_motion(run: Run, theta: Array) -> TankMotion:
    """Nominal motion of an oscillating test in tank axes; amplitudes not stated are zero."""
    """Motion in tank axes at the phases theta."""
    settings, omega = run.settings, omega_of(run)
    zero = np.zeros_like(theta)
    velocity = (settings.amplitude or 0.0) * omega * np.cos(theta)
    acceleration = -(settings.amplitude or 0.0) * omega**2 * np.sin(theta)
    surge = run.test == "pure_surge"
    yawing = run.test in (*YAW_TESTS, "sway_yaw")
    turn = theta + (YAW_LEAD if run.test == "sway_yaw" else 0.0)
    amplitude = (settings.yaw_amplitude or 0.0) if yawing else 0.0
    psi, r = amplitude * np.sin(turn), amplitude * omega * np.cos(turn)
    if run.test in YAW_TESTS:
        velocity = settings.speed * np.tan(psi)
        acceleration = settings.speed * r / np.cos(psi) ** 2
    return TankMotion(
        xdot=settings.speed + (velocity if surge else zero),
        ydot=zero if surge else velocity,
        xddot=acceleration if surge else zero,
        yddot=zero if surge else acceleration,
        psi=psi + settings.drift,
        r=r,
        rdot=-amplitude * omega**2 * np.sin(turn),
    )


def ship_axes(tank: TankMotion) -> dict[str, Array]:
    """Ship-axes components and their own time derivatives."""
    cosine, sine = np.cos(tank.psi), np.sin(tank.psi)
    u = tank.xdot * cosine + tank.ydot * sine
    v = -tank.xdot * sine + tank.ydot * cosine
    return {
        "u": u,
        "v": v,
        "r": tank.r,
        "udot": tank.xddot * cosine + tank.yddot * sine + tank.r * v,
        "vdot": -tank.xddot * sine + tank.yddot * cosine - tank.r * u,
        "rdot": tank.rdot,
    }
