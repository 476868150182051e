"""Effects of ship and water that a base model may lack, as the catalogue defines them."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import cache
from inspect import signature
from typing import Any, Final

import numpy as np

from pmmkit.diagnosis.captive.base import Base
from pmmkit.diagnosis.captive.candidate import Candidate, polynomial, spread_over
from pmmkit.effects.catalogue import effect_of
from pmmkit.effects.effect import Effect
from pmmkit.effects.memory import kept
from pmmkit.effects.primitives import over_arrays
from pmmkit.effects.speed import resistance
from pmmkit.effects.terms import BY_SPEED
from pmmkit.numerics import Array
from pmmkit.observations.views import View

CHANNELS: Final = ("X", "Y", "N")
ON_A_CARRIAGE: Final[Mapping[str, Callable[..., Any]]] = {"resistance_curve": resistance}
"""Effects that take the Froude number of the run, whose waves are those of the carriage's speed."""


def histories(
    effect: Effect, view: View, base: Base, values: Mapping[str, float]
) -> dict[str, Array]:
    """Force of an effect of the catalogue along a view, its states at rest [N, N m].

    Parameters
    ----------
    effect : Effect
        With a force or a share of the mass matrix.
    view : View
        Motion.
    base : Base
        Ship, water, and the speed at which F is zero.
    values : mapping of str to float
        Parameters; coefficients that are not named are zero, other parameters at their default.

    Returns
    -------
    dict of channel to array (n,)
    """
    motion, ship, water = view.motion, base.ship, base.water
    there: dict[str, Any] = {
        "u": motion.u,
        "v": motion.v,
        "r": motion.r,
        "U": motion.speed,
        "L": ship.L,
        "d": ship.d,
        "rho": water.rho,
        "g": water.g,
        "Fn": ship.froude(view.speed, water.g),
        "Fn0": ship.froude(base.reference, water.g),
        **dict.fromkeys(effect.states, 0.0),
        **dict.fromkeys(effect.options, 0),
    }
    for item in effect.parameters:
        if item.name in values:
            there[item.name] = values[item.name]
            if item.form:
                there[item.form[0]] = effect.options[item.form[0]].index(item.form[1])
        elif item.name not in there:
            there[item.name] = (0.0, 0.0) if item.table else item.default or 0.0
    function = ON_A_CARRIAGE.get(effect.name, effect.force)
    assert function is not None
    asked = {name: there[name] for name in _arguments(function)}
    found: dict[str, Array] = {}
    for output, force in zip(effect.outputs, over_arrays(function)(**asked), strict=True):
        if output in CHANNELS:
            found[output] = force
        elif output.endswith("dot"):
            found[output[0]] = force * getattr(motion, output[1:])
    return found


@cache
def _arguments(function: Callable[..., Any]) -> tuple[str, ...]:
    return tuple(signature(function).parameters)


def _missing(view: View, base: Base, lag: float, harmonics: Array) -> Array:
    """What a lag takes from harmonics; a static run has had the time."""
    found = np.zeros(len(harmonics))
    for n in range(1, (len(harmonics) - 1) // 2 + 1):
        lost = 1.0 - kept(n, view.omega, lag, base.ship.L, view.speed)
        late = (harmonics[2 * n - 1] - 1j * harmonics[2 * n]) * lost
        found[2 * n - 1], found[2 * n] = late.real, -late.imag
    return found


def from_catalogue(name: str) -> Candidate:
    """An effect of the catalogue as it takes part in the contest.

    Parameters
    ----------
    name : str
        Of an effect whose parameters have usual sizes.

    Examples
    --------
    >>> from_catalogue("memory").coefficients
    ('Yv_late', 'Nv_late')
    """
    effect = effect_of(name)
    sizes = {item.name: item.typical for item in effect.coefficients if item.typical is not None}
    family = effect.family.replace("_", " ")
    if effect.kind == "terms":
        return polynomial(
            name,
            family,
            effect.summary,
            sizes,
            check=effect.check,
            excites=effect.excites,
            law=_by_speed if any(label.endswith(BY_SPEED) for label in sizes) else None,
        )
    known = effect.nonlinear
    inner, grid = (known.name, known.grid) if known else ("", (0.0,))

    def columns(view: View, base: Base, value: float) -> Mapping[str, Array]:
        parts: dict[str, list[Array]] = {}
        for label in sizes:
            for channel, force in histories(effect, view, base, {label: 1.0, inner: value}).items():
                part = view.harmonics(force)
                if effect.states:
                    part = _missing(view, base, value, part)
                part = view.pick(part)
                parts.setdefault(channel, []).append(part)
        return spread_over(view, parts, len(sizes))

    return Candidate(
        name=name,
        family=family,
        kind="physics",
        summary=effect.summary,
        coefficients=tuple(sizes),
        typical=tuple(sizes.values()),
        columns=columns,
        grid=grid,
        parameter=known.text if known else "",
        continuous=known is not None,
        check=effect.check,
        excites=effect.excites,
    )


FROUDE: Final = ("froude_linear", "froude_nonlinear", "froude_coupling", "froude_surge")
"""Derivatives that change with the Froude number."""


def _by_speed(base: Base, speed: float) -> Mapping[str, float]:
    F = base.law(speed)
    return {item.name: F for name in FROUDE for item in effect_of(name).parameters}


PHYSICS: Final = tuple(
    from_catalogue(name)
    for name in (
        "cubic_hull_terms",
        "modulus_sway_drag",
        "modulus_yaw_drag",
        "crossflow_drag",
        "yaw_sway_coupling",
        "surge_yaw_coupling",
        "surge_fourth_order",
        "froude_linear",
        "froude_nonlinear",
        "froude_coupling",
        "froude_surge",
        "resistance_curve",
        "asymmetry",
        "even_hull_terms",
        "memory",
        "lagged_crossflow",
        "nonlinear_added_mass",
        "heel_coupling",
        "rudder_stall",
        "rudder_cross_terms",
    )
)
