"""What a captive test is set to: the nominal motion of its kind, exact in every angle."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike

from pmmkit.base import CampaignError, Problem
from pmmkit.campaigns.run import Run
from pmmkit.effects import State
from pmmkit.numerics import Array


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
        rudder (a swung one at the phase of its swing) and revolutions are the settings; unknown
        revolutions and thrust are zero.

    Raises
    ------
    CampaignError
        If the run lacks a setting that its test needs, or is a free-running test.

    Examples
    --------
    >>> from pmmkit.campaigns.settings import Settings
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
    motion = run.kind_of_test.nominal(run.settings, phase)
    return State.of(len(phase), **{**beside_motion(run, phase), **motion})


def beside_motion(run: Run, theta: Array) -> dict[str, float | Array]:
    """Heel, rudder and revolutions of the test at phases θ, by their names in `State`."""
    settings, delta = run.settings, np.full_like(theta, run.settings.rudder)
    if run.kind_of_test.swings_rudder:
        delta += (settings.rudder_amplitude or 0.0) * np.sin(theta)
    return {"phi": settings.heel, "delta": delta, "rps": settings.propeller_rps or 0.0}


def as_times(run: Run, times: ArrayLike) -> Array:
    """Times (or phases) as an array (n,); a CampaignError where there are none."""
    instants = np.atleast_1d(np.asarray(times, float))
    if instants.ndim != 1 or instants.size == 0:
        raise CampaignError("there are no times at all.", run=run.id)
    return instants


def refuse_free_running(run: Run) -> None:
    """Raise a CampaignError for a free-running test."""
    if run.kind_of_test.free_running:
        raise CampaignError(
            f"a {run.test} test is free running: its motion is a result, not a setting.", run=run.id
        )


def require_settings(run: Run) -> None:
    """Raise a CampaignError naming all settings that the nominal motion lacks."""
    refuse_free_running(run)
    check_settings(run, run.kind_of_test.needs)


def has_nominal(run: Run) -> bool:
    """Whether the settings of a run say its motion, whatever its record says.

    Examples
    --------
    >>> from pmmkit.campaigns.settings import Settings
    >>> run = Run(id="CM", test="circular_motion", kind="history", loader=None,
    ...           settings=Settings(speed=1.5, radius=20.0))
    >>> has_nominal(run), has_nominal(run.with_(settings=Settings(speed=1.5)))
    (True, False)
    """
    kind = run.kind_of_test
    return not kind.free_running and not _wrong_settings(run, kind.needs)


def check_settings(run: Run, needed: Sequence[str]) -> None:
    """Raise a CampaignError naming those of some settings that are missing or impossible."""
    if wrong := _wrong_settings(run, needed):
        raise CampaignError([Problem(message=message, run=run.id) for message in wrong])


def _wrong_settings(run: Run, needed: Sequence[str]) -> list[str]:
    """What is missing or impossible among some settings, in words."""
    settings = run.settings
    wrong = [
        f"a {run.test} test needs the setting {name}."
        for name in needed
        if name != "yaw_rate" and settings.value(name) is None
    ]
    if settings.period is not None and not 0 < settings.period < math.inf and "period" in needed:
        wrong.append(f"the period must be positive, not {settings.period:g} s.")
    if "yaw_amplitude" in needed and abs(settings.yaw_amplitude or 0.0) >= math.pi / 2:
        wrong.append(
            f"the heading amplitude is {math.degrees(settings.yaw_amplitude or 0.0):g}°; it must "
            f"be below 90°."
        )
    if "yaw_rate" in needed and settings.yaw_rate is None and not settings.radius:
        wrong.append(f"a {run.test} test needs yaw_rate, or a radius that is not zero.")
    return wrong


def nominal_phase(run: Run, times: Array) -> Array:
    """Phase ωt + phase of the displacement [rad], array (n,)."""
    return (run.settings.omega or 0.0) * times + run.settings.phase
