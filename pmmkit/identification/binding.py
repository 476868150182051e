"""How the constants of a model's equations depend on the parameters that are looked for."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from types import MappingProxyType
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from pmmkit.effects.seen import CURRENT
from pmmkit.equations import CALM, Conditions
from pmmkit.equations.layouts import Constant
from pmmkit.equations.prepared import packed, values_at
from pmmkit.equations.structure import Structure
from pmmkit.errors import DataError
from pmmkit.identification.parameters import Place, places, replaced
from pmmkit.models import Model
from pmmkit.models.roles import parts_of
from pmmkit.numerics import Array

FORCES: Final = ("more_X", "more_Y", "more_N", "more_K")


@dataclass(frozen=True, kw_only=True, eq=False)
class Binding:
    """Constants as straight lines over parameters: ``base + Σ slope (θ - mean)``.

    Parameters
    ----------
    structure : Structure
        Of the equations.
    names : tuple of str
        Parameters.
    mean : array (m,)
        Where the lines begin: the values of the model.
    base : array (k,)
        Constants there.
    starts, places, slopes : array
        A sparse matrix by rows: the constants that each parameter touches.
    """

    structure: Structure
    names: tuple[str, ...]
    mean: Array
    base: Array
    starts: NDArray[np.int64]
    places: NDArray[np.int64]
    slopes: Array

    def constants(self, values: Array) -> Array:
        """The constants with other values of the parameters, mass matrix not yet inverted."""
        k = self.base.copy()
        for j, change in enumerate(values - self.mean):
            own = slice(self.starts[j], self.starts[j + 1])
            k[self.places[own]] += self.slopes[own] * change
        return k

    def about(self, values: Array) -> Binding:
        """The same lines from other values on."""
        return replace(self, base=self.constants(values), mean=values)

    def at(self, values: Array) -> Binding:
        """With the parameters held at values, so that there are none."""
        return Binding(
            structure=self.structure,
            names=(),
            mean=np.zeros(0),
            base=self.constants(values),
            starts=np.zeros(1, np.int64),
            places=np.zeros(0, np.int64),
            slopes=np.zeros(0),
        )


def driven(model: Model) -> Model:
    """The model without the parts that move its revolutions: these are measured."""
    shafts = parts_of(model, "shaft")
    if not shafts:
        return model
    kept = {name: part for name, part in model.parts.items() if name not in shafts}
    return replace(model, parts=MappingProxyType(kept))


def bound(
    model: Model,
    names: Sequence[str],
    speed: float,
    *,
    conditions: Conditions = CALM,
    extrapolate: bool = False,
) -> Binding:
    """How the equations of a model at a speed depend on some of its values.

    Parameters
    ----------
    model : Model
        With values of all parts.
    names : sequence of str
        Derivatives (``Yv``), parameters with their effect (``rudder_mmg.aH``), and ``current_x``,
        ``current_y`` [m/s].
    speed : float
        Speed of the approach [m/s].
    conditions : Conditions
        Wind, current and depth.
    extrapolate : bool
        Allow a speed outside the range of the model's values.

    Returns
    -------
    Binding

    Raises
    ------
    DataError
        If the equations are not straight lines over a parameter.

    Examples
    --------
    >>> from pmmkit.models import load_model
    >>> found = bound(load_model("kvlcc2-l7"), ["Yv", "rudder_mmg.aH"], 1.179)
    >>> found.mean.round(3)
    array([-0.315,  0.312])
    """
    ready = driven(model)
    numbers = values_at(ready, speed, extrapolate=extrapolate)
    own = [name for name in names if name not in (*CURRENT, *FORCES)]
    at = dict(zip(own, places(ready, own), strict=True))
    structure, k = packed(ready, numbers, speed, conditions, heeled=True)
    base = np.array(k, float)
    mean, starts, places_of, slopes = [], [0], [], []
    for name in names:
        if name in at:
            start, touched, slope = _line(ready, numbers, speed, conditions, at[name], base)
        else:
            place = Constant[name]
            start, touched, slope = float(base[place]), [place], [1.0]
        mean.append(start)
        places_of += touched
        slopes += slope
        starts.append(len(places_of))
    return Binding(
        structure=structure,
        names=tuple(names),
        mean=np.array(mean),
        base=base,
        starts=np.array(starts, np.int64),
        places=np.array(places_of, np.int64),
        slopes=np.array(slopes),
    )


def _line(
    model: Model, numbers: Any, speed: float, conditions: Conditions, at: Place, base: Array
) -> tuple[float, list[int], list[float]]:
    """Start, places and slopes of one parameter."""
    effect, name = at
    start = float(numbers[effect][name])
    step = 0.01 * abs(start) or 0.01

    def moved(value: float) -> Array:
        changed = replaced(numbers, [at], np.array([value]))
        k = np.array(packed(model, changed, speed, conditions, heeled=True)[1], float)
        return np.where(np.isfinite(base), np.nan_to_num(k) - np.nan_to_num(base), 0.0)

    once, twice = moved(start + step), moved(start + 2.0 * step)
    touched = np.flatnonzero(once)
    if np.max(np.abs(twice - 2.0 * once), initial=0.0) > 1e-9 * np.max(np.abs(twice), initial=0.0):
        raise DataError(
            f"{effect}.{name} enters the equations in a way that is no straight line; it cannot be "
            f"followed by a filter. Fit it with fit_to_forces, or leave it out."
        )
    return start, touched.tolist(), (once[touched] / step).tolist()
