"""What is known of parameters before a record is looked at."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from types import MappingProxyType
from typing import Final

import numpy as np

from pmmkit.base import DataError
from pmmkit.effects import CURRENT, HULL
from pmmkit.identification.binding import places, with_parameters
from pmmkit.models import Model, Step
from pmmkit.numerics import Array, precision_over
from pmmkit.simulation import Spread

SPREAD: Final = 0.3
"""Relative standard deviation of a derivative of which nothing else is known."""
DRIFTS: Final = 0.1
"""Standard deviation of the current over the speed of the approach."""
ALIKE: Final = 0.95
"""Cosine between two columns from which they are named as a pair."""
DRAWN: Final = 0.5
"""Share of bias in the variance of a value from which it is said to be drawn to its prior."""
ENDED: Final = 0.1
"""Share of bias at which that has ended."""
LONGEST: Final = 1000.0
"""Times the length of records beyond which more of the same is no advice."""


@dataclass(frozen=True, kw_only=True)
class RidgeBias:
    """A value that stands on its prior more than on the records.

    `share`: of bias in its variance. `like`: the parameter whose rows are most like its own, and
    `cosine` of the angle between them; empty where it is alone. `longer`: times that records of
    the same kind would have to be longer until the share is 10 %; infinite where no length helps.
    """

    name: str
    share: float
    like: str
    cosine: float
    longer: float


@dataclass(frozen=True, kw_only=True, eq=False)
class Prior:
    """Parameters with mean and covariance.

    Parameters
    ----------
    names : tuple of str
        Derivatives, parameters with their effect, ``current_x`` and ``current_y``.
    mean : array (m,)
        Start values.
    covariance : array (m, m)
        How well they are known.
    origin : str
        Where that comes from, in words.
    """

    names: tuple[str, ...]
    mean: Array
    covariance: Array
    origin: str = ""

    @classmethod
    def of(
        cls,
        model: Model,
        names: Sequence[str],
        speed: float,
        *,
        spread: float | Mapping[str, float] | None = None,
        extrapolate: bool = False,
    ) -> Prior:
        """The prior of parameters: what the model says of its values, or a spread about them.

        Parameters
        ----------
        model : Model
            Its values are the means.
        names : sequence of str
            Parameters.
        speed : float
            Speed of the approach [m/s].
        spread : float or mapping, optional
            Relative standard deviation, for all or by name; it counts before the covariance. A
            value of zero takes the size of the smallest of its channel.
        extrapolate : bool
            Allow a speed outside the range of the model's values.

        Examples
        --------
        >>> from pmmkit.models import load_model
        >>> Prior.of(load_model("kvlcc2-l7"), ["Yv", "Nr"], 1.179, spread=0.1).std.round(4)
        array([0.0315, 0.0049])
        """
        if not names:
            raise DataError("Name at least one parameter.")
        own = [name for name in names if name not in CURRENT]
        numbers = model.values_at(speed, extrapolate=extrapolate)
        values = {
            name: float(numbers[effect][item])
            for name, (effect, item) in zip(own, places(model, own), strict=True)
        }
        mean = np.array([values.get(name, 0.0) for name in names])
        relative = spread if isinstance(spread, Mapping) else {}
        default = None if spread is None or isinstance(spread, Mapping) else float(spread)
        std = np.array(
            [
                DRIFTS * speed
                if name in CURRENT
                else (relative.get(name, default) or SPREAD)
                * _size(name, values, {x: numbers.get(x, {}) for x in model.derivative_parts})
                for name in names
            ]
        )
        covariance = np.diag(std**2)
        measured = (
            stated_covariance(model, speed, extrapolate=extrapolate) if default is None else {}
        )
        known = [
            i for i, name in enumerate(names) if (name, name) in measured and name not in relative
        ]
        for i in known:
            for j in known:
                covariance[i, j] = measured.get((names[i], names[j]), 0.0)
        told = f"{100 * (default or SPREAD):g} % of each value"
        origin = (
            f"the uncertainty that the model states for {len(known)} of {len(names)}, else {told}"
            if known
            else told
        )
        return cls(names=tuple(names), mean=mean, covariance=covariance, origin=origin)

    @property
    def std(self) -> Array:
        """Standard deviations (m,)."""
        return np.sqrt(np.diagonal(self.covariance))

    @property
    def precision(self) -> Array:
        """Inverse of the covariance over the standard deviations (m, m)."""
        return precision_over(self.covariance, self.std)

    def ridge_biases(self, covariance: Array) -> tuple[RidgeBias, ...]:
        """The values of an estimate of that covariance (m, m) that its prior draws to itself.

        Notes
        -----
        A normal prior is a ridge (Hoerl and Kennard 1970): with precision K before and information
        Λ of the records, C = (K + Λ)⁻¹, the estimate is off by C K (mean - truth), of variance
        C K C where the prior is right; noise has the rest, C Λ C. Records n times as long have nΛ.

        Examples
        --------
        Two records' worth of rows in which Yv and Yr move together:

        >>> prior = Prior(names=("Yv", "Yr"), mean=np.zeros(2), covariance=np.eye(2))
        >>> told = 50.0 * np.array([[1.0, 0.99], [0.99, 1.0]])
        >>> [(x.name, round(x.share, 2), x.like, round(x.longer)) for x in
        ...  prior.ridge_biases(np.linalg.inv(np.eye(2) + told))]
        [('Yv', 0.66, 'Yr', 18), ('Yr', 0.66, 'Yv', 18)]
        """
        from scipy.optimize import brentq

        scale, known = np.outer(self.std, self.std), self.precision
        sizes, axes = np.linalg.eigh(np.linalg.inv(covariance / scale) - known)
        told = (axes * np.maximum(sizes, 0.0)) @ axes.T
        length = np.sqrt(np.maximum(np.diagonal(told), 1e-300))
        alike = told / np.outer(length, length)
        np.fill_diagonal(alike, 0.0)

        def share(longer: float) -> Array:
            narrow = np.linalg.inv(known + longer * told)
            found: Array = np.diagonal(narrow @ known @ narrow) / np.diagonal(narrow)
            return found

        found = []
        for i in np.flatnonzero(share(1.0) > DRAWN).tolist():

            def above(log: float, i: int = i) -> float:
                return float(share(math.exp(log))[i]) - ENDED

            ends = above(math.log(LONGEST)) < 0.0
            longer = math.exp(brentq(above, 0.0, math.log(LONGEST))) if ends else math.inf
            other = int(np.argmax(np.abs(alike[i])))
            alone = len(self.names) < 2 or abs(alike[i, other]) < ALIKE
            found.append(
                RidgeBias(
                    name=self.names[i],
                    share=float(share(1.0)[i]),
                    like="" if alone else self.names[other],
                    cosine=0.0 if alone else float(alike[i, other]),
                    longer=longer,
                )
            )
        return tuple(found)

    def carried_by(self, model: Model, how: str, *, measured: bool = True) -> Model:
        """The model with these values, their source and their covariance.

        Parameters
        ----------
        model : Model
            Has all of them but currents.
        how : str
            How they were found.
        measured : bool
            Whether they stand on measurements; else a value stays what it was, such as an
            estimate, of which the source says that it was moved.

        Examples
        --------
        >>> from pmmkit.models import load_model
        >>> known = Prior(names=("Yv",), mean=np.array([-0.3]), covariance=np.array([[1e-4]]))
        >>> made = known.carried_by(load_model("kvlcc2"), "a guess")
        >>> made.std["Yv"], made.parts[HULL].source_of("Yv")
        ((0.01,), 'identified: a guess')
        """
        own = [name for name in self.names if name not in CURRENT]
        at = places(model, own)
        number = [self.names.index(name) for name in own]
        made = with_parameters(model, at, self.mean[number])
        block = self.covariance[np.ix_(number, number)]
        parts = dict(made.parts)
        for (effect, name), variance in zip(at, np.diagonal(block).tolist(), strict=True):
            part = parts[effect]
            std = {known: x for known, x in part.std.items() if known != name}
            if model.Fn and effect not in made.derivative_parts:
                std[name] = math.sqrt(variance)
            source = f"identified: {how}" if measured else f"{part.source_of(name)}; {how}"
            parts[effect] = replace(
                part,
                sources=MappingProxyType({**part.sources, name: source}),
                std=MappingProxyType(std),
            )
        named = () if model.Fn else tuple(parts[effect].place(name) for effect, name in at)
        return replace(
            made,
            parts=MappingProxyType(parts),
            covariance=0.5 * (block + block.T) if named else None,
            covariance_names=named,
            steps=(*model.steps, Step(action="identified", names=tuple(own), method=how)),
        )


def asked_names(model: Model, names: Sequence[str] | None) -> tuple[str, ...]:
    """The names asked for; all derivatives of the hull where none are."""
    return tuple(model.parts[HULL].values if names is None else names)


def _size(
    name: str, values: Mapping[str, float], numbers: Mapping[str, Mapping[str, object]]
) -> float:
    if values[name] != 0.0:
        return abs(values[name])
    others = [
        abs(x)
        for own in numbers.values()
        for other, x in own.items()
        if isinstance(x, float) and x != 0.0 and other[0] == name[0]
    ]
    return min(others, default=0.1)


def stated_covariance(
    model: Model, speed: float, *, extrapolate: bool = False
) -> dict[tuple[str, str], float]:
    """The covariance of a model's values at a speed, by pairs of names.

    speed [m/s].
    """
    if not model.is_uncertain:
        return {}
    known = Spread.of(model, speed, extrapolate=extrapolate)
    C = known.covariance
    return {
        (a, b): float(C[i, j])
        for i, a in enumerate(known.names)
        for j, b in enumerate(known.names)
        if C[i, i] > 0 and C[j, j] > 0
    }
