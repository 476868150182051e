"""How the values of a model differ between ships: what is known of their uncertainty, drawn."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from types import MappingProxyType
from typing import Any, Final

import numpy as np

from pmmkit.base import DataError, ModelError, Problem, Remedy, Way
from pmmkit.effects import CATALOGUE
from pmmkit.inference import root
from pmmkit.models import Model
from pmmkit.numerics import Array
from pmmkit.presentation import listed
from pmmkit.simulation.froude import Follow

CHUNK: Final = 10_000
"""Ships whose constants are held at a time."""


KEEPS: Final = 0.9
"""A value whose standard uncertainty is a larger share of it may have the other sign."""
TOGETHER: Final = MappingProxyType({("rudder_mmg.epsilon", "rudder_mmg.kappa"): -0.4})
"""Correlation of estimates that make up for each other: by its definition κ is kx/ε (Yasukawa and
Yoshimura 2015) and kx knows nothing of ε, which gives -σ(ε)/σ(κ). The three ships have -0.8."""


@dataclass(frozen=True, kw_only=True)
class Spread:
    """Values that differ between ships: a mean and a root of their covariance.

    Parameters
    ----------
    names : tuple of str
        Derivatives, and values of other parts as ``rudder_mmg.aH``.
    mean : array (speeds m,)
        Their values at each speed, all names of one speed after another.
    root : array (speeds m, q)
        ``root @ root.T`` is the covariance, of the logarithm times the mean where a value differs
        by factors.
    origin : str
        Where it comes from, in words.
    speeds : int
        1 for the approach alone.
    """

    names: tuple[str, ...]
    mean: Array
    root: Array
    origin: str
    speeds: int = 1

    @classmethod
    def of(
        cls,
        model: Model,
        speed: float,
        spread: float | None = None,
        *,
        extrapolate: bool = False,
        fn: Follow = "approach",
        beside: Sequence[str] = (),
    ) -> Spread:
        """How the derivatives of a model differ between ships at a speed.

        Parameters
        ----------
        model : Model
            With a covariance, or without.
        speed : float
            Approach speed [m/s].
        spread : float, optional
            Relative standard deviation of each derivative of hull and added mass, independent; by
            default the covariance of the model counts. Values of other parts with an uncertainty
            of their own differ by that.
        extrapolate : bool
            Allow a speed outside the range of the model's values.
        fn : {"approach", "instant"}
            At the approach speed, or at all speeds that the model has values at: a relative
            standard deviation is then the same share at each, a covariance ties them together as
            it states.
        beside : sequence of str
            What ships differ in beside the values of the model, such as settings of a stop that
            nobody states: with them a model that says nothing of its uncertainty is one ship.

        Returns
        -------
        Spread

        Raises
        ------
        ModelError
            If the model has no covariance and `spread` is not given.
        """
        speeds = (model.known_speeds(speed) if fn == "instant" else ()) or (speed,)
        values = [model.values_at(each, extrapolate=extrapolate) for each in speeds]
        given = [
            {
                model.parts[effect].place(name): x
                for effect, held in own.items()
                for name, x in held.items()
            }
            for own in values
        ]
        alone = _of_estimates(model, values)
        if spread is not None:
            if not 0.0 < spread < 1.0:
                raise DataError(f"spread = {spread} must lie between 0 and 1.")
            names = tuple(
                name
                for effect in model.derivative_parts
                for name in values[0].get(effect, {})
                if CATALOGUE[effect].parameter(name) is None
            )
            means = np.array([[own[name] for name in names] for own in given])
            asked = Spread(
                names=names,
                mean=means.ravel(),
                root=_alike(means, spread * np.abs(means)),
                origin=f"{100 * spread:g} % of each derivative, independent",
                speeds=len(speeds),
            )
            return asked if alone is None else asked.beside(alone)
        if model.covariance is None:
            if alone is None and beside:
                nothing = np.zeros((0, 0))
                return Spread(
                    names=(),
                    mean=np.zeros(0),
                    root=nothing,
                    origin=listed(beside),
                    speeds=len(speeds),
                )
            if alone is None:
                raise ModelError(
                    Problem(
                        message=f"Model {model.name!r} carries no covariance.",
                        remedy=Remedy(
                            "Give the relative standard deviation of its derivatives ({}), or "
                            "reduce tests to a model.",
                            (Way.setting("spread", 0.05),),
                        ),
                    )
                )
            return alone
        froude = [model.ship.froude(each, model.water.g) for each in speeds]
        weights = [
            np.array(model.weights(each, extrapolate=extrapolate) if model.Fn else (1.0,))
            for each in froude
        ]
        size, rows = len(model.covariance_names), len(weights[0])
        full = model.covariance.reshape(rows, size, rows, size)
        measured = np.nan_to_num(full)
        covariance = np.block(
            [[np.einsum("a,aibj,b->ij", one, measured, two) for two in weights] for one in weights]
        )
        positive = (np.diagonal(covariance) > 0).reshape(-1, size).all(axis=0)
        counts = np.any(weights, axis=0)  # what is not known elsewhere does not matter here
        known = np.isfinite(np.einsum("aiai->ai", full)[counts]).all(axis=0) & positive
        known &= np.array([name in given[0] for name in model.covariance_names])
        names = tuple(
            name for name, there in zip(model.covariance_names, known, strict=True) if there
        )
        places = np.tile(known, len(speeds))
        unknown = size - len(names)
        tested = Spread(
            names=names,
            mean=np.array([float(own[name]) for own in given for name in names]),
            root=root(covariance[np.ix_(places, places)]),
            origin="the covariance of the model"
            + (f"; {unknown} derivatives without one do not differ" if unknown else ""),
            speeds=len(speeds),
        )
        return tested if alone is None else tested.beside(alone)

    @property
    def covariance(self) -> Array:
        """Covariance (m, m)."""
        product: Array = self.root @ self.root.T
        return product

    def beside(self, other: Spread) -> Spread:
        """Both, independent of each other."""
        m, n = self.root.shape[1], other.root.shape[1]
        root = np.block(
            [
                [self.root, np.zeros((len(self.mean), n))],
                [np.zeros((len(other.mean), m)), other.root],
            ]
        )
        places = np.split(np.arange(len(root)), [len(self.mean)])
        by_speed = np.concatenate([own.reshape(self.speeds, -1) for own in places], axis=1).ravel()
        return Spread(
            names=(*self.names, *other.names),
            mean=np.concatenate([self.mean, other.mean])[by_speed],
            root=root[by_speed],
            origin=f"{self.origin}; {other.origin}",
            speeds=self.speeds,
        )

    def draw(self, seed: int, first: int, count: int) -> Array:
        """Values (count, m) of the ships from number `first` on; the same whatever the chunks."""
        blocks = []
        for block in range(first // CHUNK, (first + count - 1) // CHUNK + 1):
            generator = np.random.default_rng([seed, block])
            blocks.append(generator.standard_normal((CHUNK, self.root.shape[1])))
        start = first - first // CHUNK * CHUNK
        return self.of_normal(np.concatenate(blocks)[start : start + count])

    def of_normal(self, normal: Array) -> Array:
        """Values (n, m) of ships whose errors (n, q) are standard normal."""
        values: Array = self.mean + np.einsum("ij,kj->ik", normal, self.root)
        own = self._by_factors
        values[:, own] = self.mean[own] * np.exp(values[:, own] / self.mean[own] - 1.0)
        return values

    def slopes(self, normal: Array) -> Array:
        """Change of the values (m, q) by each of the errors, where these are `normal` (q,)."""
        grown = np.where(self._by_factors, self.of_normal(normal[None])[0] / self.mean, 1.0)
        found: Array = grown[:, None] * self.root
        return found

    @property
    def independent(self) -> Spread:
        """The same standard deviations, each value by an error of its own."""
        return replace(self, root=np.diag(self.std))

    @property
    def std(self) -> Array:
        """Standard deviations (m,), of the logarithm times the mean as for `root`."""
        found: Array = np.sqrt(np.einsum("ij,ij->i", self.root, self.root))
        return found

    @property
    def _by_factors(self) -> Array:
        """Which values (m,) differ by factors (lognormal, the value as median): those of propeller,
        rudder and engine, which keep their sign, as a diameter does."""
        parts = np.tile(["." in name for name in self.names], self.speeds).astype(bool)
        return np.asarray(parts & (self.std < KEEPS * np.abs(self.mean)))


@dataclass(frozen=True, kw_only=True, eq=False)
class Draws:
    """Values that differ between ships: draws that were made of them, as from a posterior.

    Parameters
    ----------
    names : tuple of str
        Derivatives, and values of other parts as ``rudder_mmg.aH``.
    values : array (n, m)
        A row per draw.
    origin : str
        Where they come from, in words.
    """

    names: tuple[str, ...]
    values: Array
    origin: str

    @property
    def mean(self) -> Array:
        """Of the draws (m,)."""
        middle: Array = self.values.mean(axis=0)
        return middle

    @property
    def covariance(self) -> Array:
        """Of the draws (m, m)."""
        away = self.values - self.mean
        found: Array = away.T @ away / (len(away) - 1)
        return found

    def draw(self, seed: int, first: int, count: int) -> Array:
        """Values (count, m) of the ships from number `first` on; the same whatever the chunks.

        Each draw is one ship, in an order of the seed's; after the last the first comes again.

        Examples
        --------
        >>> found = Draws(names=("Yv",), values=np.arange(3.0)[:, None], origin="")
        >>> sorted(found.draw(0, 0, 3).ravel().tolist()), found.draw(0, 3, 1) == found.draw(0, 0, 1)
        ([0.0, 1.0, 2.0], array([[ True]]))
        """
        order = np.random.default_rng(seed).permutation(len(self.values))
        rows: Array = self.values[order[np.arange(first, first + count) % len(order)]]
        return rows


def in_kind(names: Sequence[str]) -> str:
    """What names are of, in a word: derivatives, or values of a ship where there are others.

    Examples
    --------
    >>> in_kind(("Yv", "Nrrr")), in_kind(("Yv", "shaft.friction")), in_kind(("turns",))
    ('derivative', 'value', 'value')
    """
    return "derivative" if all(name[0] in "XYNK" for name in names) else "value"


def drawn_of(
    model: Model, speed: float, spread: float | Draws | None = None, **how: Any
) -> Spread | Draws:
    """How ships differ: as `Spread.of` says, or by draws that were made."""
    if isinstance(spread, Draws):
        return _fitting(spread, model, speed, extrapolate=how["extrapolate"], fn=how["fn"])
    return Spread.of(model, speed, spread, **how)


def _fitting(draws: Draws, model: Model, speed: float, *, extrapolate: bool, fn: Follow) -> Draws:
    """The draws, if the model has all that they are of."""
    if fn == "instant" and model.known_speeds(speed):
        raise DataError("Draws are of one speed: let the derivatives be those of the approach.")
    values = model.values_at(speed, extrapolate=extrapolate)
    there = {model.parts[effect].place(name) for effect, own in values.items() for name in own}
    lost = [name for name in draws.names if name not in there]
    if lost:
        raise ModelError(
            f"Model {model.name!r} has no {', '.join(lost)}, which were drawn: take the model that "
            f"they were identified in."
        )
    return draws


def _alike(means: Array, std: Array) -> Array:
    """Root (speeds m, m) of values (speeds, m) that are off by the same share at all speeds."""
    side = np.where(means[0] < 0.0, -1.0, 1.0) * np.where(means < 0.0, -1.0, 1.0)
    return np.concatenate([np.diag(row) for row in side * std])


def _together(names: Sequence[str]) -> Array:
    """Root of the correlation of estimates, of which few depend on each other."""
    correlation = np.eye(len(names))
    for pair, size in TOGETHER.items():
        if all(name in names for name in pair):
            one, other = (names.index(name) for name in pair)
            correlation[one, other] = correlation[other, one] = size
    return root(correlation)


def _of_estimates(model: Model, values: Sequence[Mapping[str, Mapping[str, Any]]]) -> Spread | None:
    """Values with an uncertainty of their own, such as estimates from particulars."""
    named, means, stds = [], [], []
    for effect, part in model.parts.items():
        for name, std in part.std.items():
            first = part.values[name]
            stated = first[0] if isinstance(first, tuple) else first
            mean = [float(own[effect][name]) for own in values]
            named.append(part.place(name))
            means.append(mean)
            stds.append([std * abs(x / stated) if stated else std for x in mean])
    if not named:
        return None
    return Spread(
        names=tuple(named),
        mean=np.array(means).T.ravel(),
        root=_alike(np.array(means).T, np.array(stds).T) @ _together(named),
        origin=f"{len(named)} estimates with the spread that they have among ships",
        speeds=len(values),
    )
