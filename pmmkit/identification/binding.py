"""How the constants of a model's equations depend on the parameters that are looked for."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from types import MappingProxyType, ModuleType
from typing import Any, ClassVar, Final

import numpy as np
from numpy.typing import NDArray

from pmmkit.base import DataError, UnknownNameError
from pmmkit.effects import CURRENT
from pmmkit.equations import Conditions, Prepared, prepare
from pmmkit.models import Model
from pmmkit.numerics import Array

# Values of a model as a flat list of numbers, by name, and back.


Place = tuple[str, str]
PartValues = Mapping[str, Mapping[str, Any]]
"""Effect and name of a value."""


def places(model: Model, names: Sequence[str]) -> tuple[Place, ...]:
    """Where the values of names stand: ``Yv``, or ``rudder_mmg.aH`` for a parameter of an effect.

    Parameters
    ----------
    model : Model
        That has them.
    names : sequence of str
        Of derivatives and parameters.

    Returns
    -------
    tuple of (str, str)
        Effect and name.

    Raises
    ------
    UnknownNameError
        With all names of which the model has no number.

    Examples
    --------
    >>> from pmmkit.models import load_model
    >>> places(load_model("kvlcc2"), ["Yv", "rudder_mmg.aH"])
    (('hull_polynomial', 'Yv'), ('rudder_mmg', 'aH'))
    """
    found, lost = [], []
    for name in names:
        effect, dot, own = name.partition(".")
        if dot:
            part = model.parts.get(effect)
            parameter = part.known.parameter(own) if part is not None else None
            there = part is not None and (
                (parameter is not None and not parameter.table) or own in part.values
            )
            found.append((effect, own)) if there else lost.append(name)
            continue
        home = [part for part in model.derivative_parts if name in _values(model, part)]
        found.append((home[0], name)) if home else lost.append(name)
    if lost:
        raise UnknownNameError(
            f"Model {model.name!r} has no value {', '.join(lost)} that could be fitted. Write a "
            f"derivative as Yv, a parameter with its effect as rudder_mmg.aH, and give it a start "
            f"value in the model."
        )
    return tuple(found)


def _values(model: Model, effect: str) -> dict[str, object]:
    return dict(model.parts[effect].values) if effect in model.parts else {}


def replaced(numbers: PartValues, at: Sequence[Place], values: Array) -> PartValues:
    """Values by effect and name with some of them changed."""
    changed = {effect: dict(own) for effect, own in numbers.items()}
    for (effect, name), value in zip(at, values.tolist(), strict=True):
        changed[effect][name] = value
    return changed


def with_parameters(model: Model, at: Sequence[Place], values: Array) -> Model:
    """The model with other values, the same at all of its Froude numbers."""
    made = model
    for effect in dict.fromkeys(effect for effect, _ in at):
        own = {
            name: value
            for (other, name), value in zip(at, values.tolist(), strict=True)
            if other == effect
        }
        made = made.with_values(effect, **own)
    return made


FORCES: Final = ("more_X", "more_Y", "more_N", "more_K")


@dataclass(frozen=True, kw_only=True, eq=False)
class Binding:
    """Constants as straight lines over parameters: ``base + Σ slope (θ - mean)``.

    Parameters
    ----------
    equations : Prepared
        The equations with the values of the model.
    names : tuple of str
        Parameters.
    mean : array (m,)
        Where the lines begin: the values of the model.
    base : array (k,)
        Constants there.
    starts, places, slopes : array
        A sparse matrix by rows: the constants that each parameter touches.
    """

    STEP: ClassVar[float] = 0.05
    """Longest step of the integration in ship lengths over the speed of the approach."""

    equations: Prepared
    names: tuple[str, ...]
    mean: Array
    base: Array
    starts: NDArray[np.int64]
    places: NDArray[np.int64]
    slopes: Array

    @classmethod
    def of(
        cls,
        model: Model,
        names: Sequence[str],
        speed: float,
        *,
        conditions: Conditions | None = None,
        extrapolate: bool = False,
    ) -> Binding:
        """How the equations of a model at a speed depend on some of its values.

        Parameters
        ----------
        model : Model
            With values of all parts.
        names : sequence of str
            Derivatives (``Yv``), parameters with their effect (``rudder_mmg.aH``), and
            ``current_x``, ``current_y`` [m/s].
        speed : float
            Speed of the approach [m/s].
        conditions : Conditions, optional
            Wind, current and depth.
        extrapolate : bool
            Allow a speed outside the range of the model's values.

        Raises
        ------
        DataError
            If the equations are not straight lines over a parameter.

        Examples
        --------
        >>> from pmmkit.models import load_model
        >>> found = Binding.of(load_model("kvlcc2-l7"), ["Yv", "rudder_mmg.aH"], 1.179)
        >>> found.mean.round(3)
        array([-0.315,  0.312])
        """
        ready = driven(model)
        numbers = ready.values_at(speed, extrapolate=extrapolate)
        own = [name for name in names if name not in (*CURRENT, *FORCES)]
        at = dict(zip(own, places(ready, own), strict=True))
        equations = prepare(ready, speed, values=numbers, conditions=conditions, heeled=True)
        base = np.array(equations.k, float)
        mean, starts, places_of, slopes = [], [0], [], []
        for name in names:
            if name in at:
                start, touched, slope = _line(ready, numbers, speed, conditions, at[name], base)
            else:
                place = equations.place(name)
                start, touched, slope = float(base[place]), [place], [1.0]
            mean.append(start)
            places_of += touched
            slopes += slope
            starts.append(len(places_of))
        return cls(
            equations=equations,
            names=tuple(names),
            mean=np.array(mean),
            base=base,
            starts=np.array(starts, np.int64),
            places=np.array(places_of, np.int64),
            slopes=np.array(slopes),
        )

    @property
    def states(self) -> tuple[str, ...]:
        """Names of the states."""
        return self.equations.structure.states

    @property
    def functions(self) -> ModuleType:
        """The functions of filters and smoothers."""
        return self.equations.estimators

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
            equations=self.equations,
            names=(),
            mean=np.zeros(0),
            base=self.constants(values),
            starts=np.zeros(1, np.int64),
            places=np.zeros(0, np.int64),
            slopes=np.zeros(0),
        )


def driven(model: Model) -> Model:
    """The model without the parts that move its revolutions: these are measured."""
    shafts = model.in_role("shaft")
    if not shafts:
        return model
    kept = {name: part for name, part in model.parts.items() if name not in shafts}
    return replace(model, parts=MappingProxyType(kept))


def _line(
    model: Model,
    numbers: PartValues,
    speed: float,
    conditions: Conditions | None,
    at: Place,
    base: Array,
) -> tuple[float, list[int], list[float]]:
    """Start, places and slopes of one parameter."""
    effect, name = at
    start = float(numbers[effect][name])
    step = 0.01 * abs(start) or 0.01

    def moved(value: float) -> Array:
        changed = replaced(numbers, [at], np.array([value]))
        other = prepare(model, speed, values=changed, conditions=conditions, heeled=True)
        k = np.array(other.k, float)
        return np.where(np.isfinite(base), np.nan_to_num(k) - np.nan_to_num(base), 0.0)

    once, twice = moved(start + step), moved(start + 2.0 * step)
    touched = np.flatnonzero(once)
    if np.max(np.abs(twice - 2.0 * once), initial=0.0) > 1e-9 * np.max(np.abs(twice), initial=0.0):
        raise DataError(
            f"{effect}.{name} enters the equations in a way that is no straight line; it cannot be "
            f"followed by a filter. Fit it with fit_to_forces, or leave it out."
        )
    return start, touched.tolist(), (once[touched] / step).tolist()
