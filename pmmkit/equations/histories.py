"""Forces of the water over whole histories of a prescribed or measured motion, by arrays."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from functools import cache
from types import ModuleType
from typing import Any, Final

import numpy as np

from pmmkit.base import ModelError
from pmmkit.conventions import CHANNELS
from pmmkit.equations.code_generation import CONTROLS, MOTION, summed
from pmmkit.equations.layouts import Constant
from pmmkit.equations.structure import ACCELERATIONS, EquationStructure
from pmmkit.numerics import Array

HISTORY: Final = ("u", "v", "r", "p", "phi", "psi", "udot", "vdot", "rdot", "pdot", *CONTROLS)
"""What a history of motion may hold; what it lacks is zero."""
PLANE: Final = ("X", "Y", "N")
"""Forces and moment in the plane of the water."""
DERIVATIVES: Final = "derivatives"
"""The polynomial among the effects: the hull, and the rudder where its derivatives are in it."""
AROUND: Final = ("wind_speed", "wind_direction", "wave_height", "wave_direction")


def water_forces(
    structure: EquationStructure, k: Sequence[Any], motion: Mapping[str, Array]
) -> dict[str, Array]:
    """Forces of the water on the ship along a history: `Prepared.water_forces`."""
    return dict(zip(CHANNELS, _along(structure, k, motion), strict=True))


def forces_by_effect(
    structure: EquationStructure, k: Sequence[Any], motion: Mapping[str, Array]
) -> dict[str, Array]:
    """X, Y, N (3, n) of each effect that pushes the ship: `DenseHistory.forces`."""
    names = (DERIVATIVES, *(item.effect for item in structure.used))
    rows = np.stack(_along(structure, k, motion, apart=True))
    every = zip(names, rows.reshape(len(names), len(PLANE), -1), strict=True)
    return {name: own for name, own in every if np.any(own)}


def _along(
    structure: EquationStructure,
    k: Sequence[Any],
    motion: Mapping[str, Array],
    *,
    apart: bool = False,
) -> list[Array]:
    """X, Y, N, K along a history; apart X, Y, N of the derivatives and of each effect in turn."""
    size = max((len(values) for values in motion.values()), default=1)
    zero = np.zeros(size)
    given = {name: np.asarray(motion.get(name, zero), float) for name in HISTORY}
    constants = list(k)
    for name in AROUND:
        if name in motion:
            constants[Constant[name]] = np.asarray(motion[name], float)
    states = [name for name in structure.brought if name != "n"]
    given |= {name: np.asarray(motion[name], float) for name in states if name in motion}
    with np.errstate(divide="ignore", invalid="ignore"):
        lacking = [name for name in states if name not in motion]
        if lacking:
            given |= _followed(structure, constants, given, lacking, motion.get("t"))
        found, _ = _function(structure, apart=apart)(constants, **given)
    return [np.broadcast_to(x, (size,)).copy() for x in found]


def repeating_states(
    structure: EquationStructure, k: Sequence[Any], motion: Mapping[str, Array], t: Array
) -> dict[str, Array]:
    """States that effects bring, along a motion that repeats itself: `Prepared.repeating_states`.

    ds/dt = a(t) - b(t) s by the trapezoidal rule, closed over the cycles.
    """
    names = [name for name in structure.brought if name != "n"]
    if not names:
        return {}
    size = len(t)
    given = {name: np.asarray(motion.get(name, np.zeros(size)), float) for name in HISTORY}
    function = _function(structure)

    def rates(level: float) -> dict[str, Array]:
        _, found = function(list(k), **given, **{name: np.full(size, level) for name in names})
        return {name: np.broadcast_to(found[name], (size,)) for name in names}

    zero, one, two = rates(0.0), rates(1.0), rates(2.0)
    states = {}
    for name in names:
        fading = zero[name] - one[name]
        if not np.allclose(zero[name] - two[name], 2.0 * fading, rtol=1e-6):
            raise ModelError(
                f"The state {name!r} follows no linear equation of its own: it cannot be told from "
                f"a history. Simulate instead."
            )
        states[name] = _repeating(zero[name], fading, t)
    return states


def _repeating(forcing: Array, fading: Array, t: Array) -> Array:
    """The solution of ds/dt = forcing - fading s that ends where it begins."""
    from scipy.linalg import solve_banded

    if len(t) == 1 or np.ptp(t) == 0.0:
        return np.asarray(forcing / fading)
    half = 0.5 * np.append(np.diff(t), np.mean(np.diff(t)))
    after = np.roll(fading, -1)
    ahead, behind = 1.0 + half * after, 1.0 - half * fading
    pushed = half * (forcing + np.roll(forcing, -1))
    n = len(t)
    band = np.zeros((2, n + 1))
    band[0] = np.append(1.0, ahead)
    band[1, :-1] = -behind
    right = np.zeros((n + 1, 2))
    right[1:, 0], right[0, 1] = pushed, 1.0
    own, free = solve_banded((1, 0), band, right).T
    return np.asarray((own + free * own[-1] / (1.0 - free[-1]))[:-1])


def _followed(
    structure: EquationStructure,
    constants: Sequence[Any],
    given: Mapping[str, Array],
    names: Sequence[str],
    t: Array | None,
) -> dict[str, Array]:
    """States that follow the motion, ds/dt = λ (q - s): q without time, else s settled at first.

    Between two instants q is a straight line and λ constant.
    """
    from scipy.linalg import solve_banded

    size = len(given["u"])
    function = _function(structure)
    _, at_zero = function(constants, **given, **dict.fromkeys(names, np.zeros(size)))
    _, at_one = function(constants, **given, **dict.fromkeys(names, np.ones(size)))
    found = {}
    for name in names:
        begin = np.broadcast_to(at_zero[name], (size,))
        rate = begin - at_one[name]
        settled = begin / rate
        if t is None:
            found[name] = settled
            continue
        step = np.diff(np.asarray(t, float)) * 0.5 * (rate[1:] + rate[:-1])
        fading = np.exp(-step)
        share = -np.expm1(-step) / np.maximum(step, 1e-12)
        driven = settled[1:] * (1.0 - share) + settled[:-1] * (share - fading)
        bands = np.stack([np.ones(size), np.append(-fading, 0.0)])
        found[name] = solve_banded((1, 0), bands, np.concatenate([settled[:1], driven]))
    return found


@cache
def _function(
    structure: EquationStructure, *, apart: bool = False
) -> Callable[..., tuple[tuple[Array, ...], dict[str, Array]]]:
    module = ModuleType("pmmkit_histories")
    module.__dict__.update(
        sqrt=np.sqrt,
        fabs=np.abs,
        atan2=np.arctan2,
        maximum=np.maximum,
        **{
            f"effect_{item.effect}": item.known.force_over_arrays
            for item in structure.used
            if item.known.force is not None
        },
    )
    exec(compile(_text(structure, apart), "<forces of a model>", "exec"), module.__dict__)
    made: Callable[..., tuple[tuple[Array, ...], dict[str, Array]]] = module.__dict__["forces"]
    return made


def _text(structure: EquationStructure, apart: bool) -> str:
    """Python text of a function of arrays, from the same lines as the equations of motion."""
    lines, extra_mass, rates = summed(structure)
    body = ["U = maximum(sqrt(u * u + v * v), 1e-9)", *lines]
    if apart:
        body.append(f"parts = {_parts(structure)}")
    body += [
        f"X = X + k[{Constant.coriolis_x}] * v * r",
        f"Y = Y + k[{Constant.coriolis_y}] * u * r",
        f"K = K + k[{Constant.coriolis_k}] * u * r",
    ]
    for name in ACCELERATIONS:
        shares = " + ".join([f"k[{Constant[name]}]", *extra_mass.get(name, ())])
        body.append(f"{name[0]} = {name[0]} + ({shares}) * {name[1:]}")
    assert set(MOTION) - {"U", "beta", "Fn"} <= set(HISTORY)
    arguments = ", ".join((*HISTORY, *(name for name in structure.brought if name not in HISTORY)))
    told, left = "parts" if apart else "(X, Y, N, K)", [f"{n!r}: {x}" for n, x in rates.items()]
    body.append(f"return {told}, {{{', '.join(left)}}}")
    return "\n    ".join([f"def forces(k, {arguments}):", *body]) + "\n"


def _parts(structure: EquationStructure) -> str:
    """Text of X, Y, N of each effect, behind what the derivatives' polynomial leaves of the sum."""
    written = [
        [f"{item.effect}_{x}" if x in item.known.outputs else "0.0" for x in PLANE]
        for item in structure.used
    ]
    rest = [" - ".join([x, *(own[i] for own in written)]) for i, x in enumerate(PLANE)]
    return f"({', '.join([*rest, *(x for own in written for x in own)])})"
