"""The errors that each run of a laboratory draws for itself, and how large they are.

For a run and a channel: y = Xθ + (s₁ F + s₂ ŷ + s₃ ∂ŷ/∂β + s₄ F) z + noise, each part with its
own z and F the rms force of the channel. The offset s₁ acts on means, s₄ on each harmonic of an
oscillating run by itself: both are forces that do not shrink with the speed. s₂ is a gain, s₃ the
setting of the drift angle.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import combinations
from types import MappingProxyType
from typing import ClassVar, Final

import numpy as np
from numpy.typing import NDArray

from pmmkit.inference.linear_fit import RANK_TOLERANCE
from pmmkit.numerics import Array

# Restricted likelihood of the sizes of random effects that act within runs.
#
# The rows of run i are y_i = X_i θ + Σ_j s_j D_ij z_ij + e_i with z_ij ~ N(0, 1) and e_i ~ N(0,
# V_i). Whitened by V_i, the covariance of a run is C_i = 1 + Σ_j s_j² G_ij with G_ij = D_ij D_ij'.
# It is taken apart as it stands: a difference of products (Woodbury) loses digits of quiet records.
# Some columns of X may have a unit normal prior: they are random effects that all runs share.


Places = NDArray[np.intp]

CELLS: Final = 4_000_000
"""Numbers that stand in memory at a time where several sizes are tried at once: 32 MB."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Restricted:
    """Restricted likelihood of the sizes of kinds of effects in one set of rows.

    Parameters
    ----------
    groups : tuple of (array (r, m, q), array (r, m, d), array of int (d,))
        Of runs of m rows each, whitened by their noise: all columns (model, columns with a prior,
        data), what a run draws at size one, and the kind of each of these.
    model, shared : int
        How many columns the model has, and how many have a unit prior.
    back : array (p, model)
        From the orthonormal basis of the model to its p coefficients.
    """

    groups: tuple[tuple[Array, Array, Places], ...]
    model: int
    shared: int
    back: Array

    @classmethod
    def of(
        cls, groups: Sequence[tuple[Array, Array, Places]], model: int, shared: int = 0
    ) -> Restricted:
        """From whitened columns (r, m, q) of runs of equal length, and what each draws (r, m, d).

        Parameters
        ----------
        groups : sequence of (array, array, array)
            The last column is the data; the first `model` are the model, then `shared` others. The
            third array has the kind (d,) of each column that is drawn.
        model, shared : int
            How many columns.
        """
        if not model:
            return cls(groups=tuple(groups), model=0, shared=shared, back=np.zeros((0, 0)))
        rows = np.concatenate([x[..., :model].reshape(-1, model) for x, *_ in groups])
        length = np.linalg.norm(rows, axis=0)
        unit = np.where(length > 0, length, 1.0)
        _, s, Vt = np.linalg.svd(np.linalg.qr(rows / unit, mode="r"), full_matrices=False)
        keep = s > RANK_TOLERANCE * (s[0] if len(s) else 1.0)
        turn = (Vt[keep].T / s[keep]) / unit[:, None]
        made = [
            (np.concatenate([x[..., :model] @ turn, x[..., model:]], axis=2), drawn, kinds)
            for x, drawn, kinds in groups
        ]
        return cls(groups=tuple(made), model=int(keep.sum()), shared=shared, back=turn)

    def given(self, kind: int, size: float) -> Restricted:
        """With one kind of known size, which is noise then."""
        groups = []
        for columns, drawn, kinds in self.groups:
            known = size * drawn[..., kinds == kind]
            root = np.linalg.cholesky(np.eye(columns.shape[1]) + known @ _turned(known))
            white = np.linalg.inv(root)
            rest = kinds != kind
            groups.append((white @ columns, white @ drawn[..., rest], kinds[rest]))
        return replace(self, groups=tuple(groups))

    def acts(self, kind: int) -> bool:
        """Whether a kind acts in any row."""
        return any(bool(np.any(drawn[..., kinds == kind])) for _, drawn, kinds in self.groups)

    def log_likelihoods(self, logs: Array) -> Array:
        """At logarithms of sizes (g, k), array (g,), without their slopes."""
        return np.concatenate([at.value for at in self._each(logs)])

    def slope(self, logs: Array) -> tuple[float, Array, Array]:
        """Value, gradient (k,) and average information (k, k) at logarithms of sizes (k,).

        The value is minus infinity where the covariance is not positive.

        Notes
        -----
        With P = C⁻¹ - C⁻¹X (X'C⁻¹X)⁻¹ X'C⁻¹ and z = P y the derivative by s_j² is
        (z' G_j z - tr P G_j) / 2, the average information z' G_j P G_k z / 2 (Gilmour, Thompson
        and Cullis 1995, Biometrics 51). By the logarithm of a size the curvature has twice the
        gradient besides, which alone is left where a size is near zero; it is taken where it makes
        the curvature larger.
        """
        k = len(logs)
        try:
            at = self._solved(logs)
        except np.linalg.LinAlgError:
            return -np.inf, np.zeros(k), np.zeros((k, k))
        gradient, plain = np.zeros(k), np.zeros((k, k))
        across = np.zeros((k, at.inverse.shape[0]))
        for (*_, kinds), (white, drawn) in zip(self.groups, at.parts, strict=True):
            fitted, back = white[..., :-1], _turned(drawn)
            left = white[..., -1] - fitted @ at.solution
            pulled = (back @ left[..., None])[..., 0]  # D'z
            half = (back @ fitted) @ at.inverse
            own = back @ drawn  # D'C⁻¹D
            of_kind = np.eye(k)[kinds]
            traces = np.einsum("rdd->d", own) - np.einsum("rdp,rdp->d", half, half)
            gradient += (np.sum(pulled**2, axis=0) - traces) @ of_kind
            both = np.einsum("ra,rab,rb->ab", pulled, own, pulled)
            plain += of_kind.T @ both @ of_kind
            across += of_kind.T @ np.einsum("rd,rdp->dp", pulled, half)
        square = np.exp(2.0 * logs)
        gradient = square * gradient
        information = 2.0 * square[:, None] * square * (plain - across @ across.T)
        information += np.diag(np.maximum(-2.0 * gradient, 0.0))
        return float(at.value), gradient, information

    def estimates(self, sizes: Array) -> tuple[Array, Array]:
        """Coefficients and their variances by generalised least squares, arrays (g, p) each.

        Parameters
        ----------
        sizes : array (g, k)
            Of the effects, not their logarithms.
        """
        values, variances = [], []
        with np.errstate(divide="ignore"):
            for at in self._each(np.log(sizes)):
                turn = self.back @ at.inverse[:, : self.model]
                values.append(at.solution[:, : self.model] @ self.back.T)
                variances.append(np.sum(turn**2, axis=2))
        return np.concatenate(values), np.concatenate(variances)

    def misfits(self, sizes: Array) -> Array:
        """What generalised least squares leave, over the covariance: χ² at sizes (g, k), (g,)."""
        with np.errstate(divide="ignore"):
            return np.concatenate([at.misfit for at in self._each(np.log(sizes))])

    def _each(self, logs: Array) -> Iterator[_Solved]:
        """Generalised least squares at several sizes (g, k), as many at a time as `CELLS` hold."""
        cells = sum(x.size + own.size + x.shape[0] * x.shape[1] ** 2 for x, own, _ in self.groups)
        for some in np.array_split(logs, min(len(logs), 1 + len(logs) * cells // CELLS)):
            try:
                yield self._solved(some)
            except np.linalg.LinAlgError:
                if len(some) > 1:
                    yield from (at for one in some for at in self._each(one[None]))
                else:
                    yield _nowhere(self.model + self.shared)

    def _solved(self, logs: Array) -> _Solved:
        """Generalised least squares at sizes (…, k)."""
        q, several = self.model + self.shared, logs.shape[:-1]
        sizes = np.exp(logs)
        gram, determinant = np.zeros((*several, q + 1, q + 1)), np.zeros(several)
        parts = []
        for columns, drawn, kinds in self.groups:
            sized = drawn * sizes[..., None, None, kinds]
            root = np.linalg.cholesky(np.eye(columns.shape[1]) + sized @ _turned(sized))
            inverse = np.linalg.inv(root)
            white = inverse @ columns
            determinant += np.log(np.diagonal(root, axis1=-2, axis2=-1)).sum(axis=(-2, -1))
            flat = np.asarray(white, float).reshape(*several, -1, q + 1)
            gram += _turned(flat) @ flat
            parts.append((white, inverse @ drawn))
        normal = gram[..., :q, :q].copy()
        prior = np.arange(self.model, q)
        normal[..., prior, prior] += 1.0
        root = np.linalg.cholesky(normal)
        back = np.asarray(np.linalg.inv(root), float)
        pulled = (back @ gram[..., :q, q:])[..., 0]
        determinant += np.log(np.diagonal(root, axis1=-2, axis2=-1)).sum(axis=-1)
        misfit = np.maximum(gram[..., q, q] - np.sum(pulled**2, axis=-1), 0.0)
        return _Solved(
            value=-determinant - 0.5 * misfit,
            misfit=misfit,
            solution=(pulled[..., None, :] @ back)[..., 0, :],
            inverse=_turned(back),
            parts=tuple(parts),
        )


def _turned(arrays: Array) -> Array:
    """Each of several arrays turned (…, n, m)."""
    return np.swapaxes(arrays, -1, -2)


@dataclass(frozen=True, kw_only=True, eq=False)
class _Solved:
    """Generalised least squares at sizes (…, k): `value` (…), `misfit` (…), `solution` (…, q);
    R R' of `inverse` (…, q, q) is (X'C⁻¹X)⁻¹; `parts` are columns and what is drawn, whitened."""

    value: Array
    misfit: Array
    solution: Array
    inverse: Array
    parts: tuple[tuple[Array, Array], ...]


def _nowhere(q: int) -> _Solved:
    """What sizes get of which the covariance is not positive."""
    return _Solved(
        value=np.array([-np.inf]),
        misfit=np.array([np.inf]),
        solution=np.zeros((1, q)),
        inverse=np.zeros((1, q, q)),
        parts=(),
    )


MEDIANS: Final[Mapping[str, float]] = MappingProxyType(
    {"offset": 0.003, "gain": 0.004, "drift": 0.03, "harmonics": 0.003}
)
"""Medians of a laboratory that is not known: offset over the channel's rms force, gain, drift
setting [deg], each harmonic of an oscillating run over the rms force. Those of HMRI's and the
S175 programme's repeats (scripts/studies/run_scatter.py)."""
SHARED: Final = tuple(MEDIANS).index("drift")
"""The kind that a run draws once for all channels: how it was set."""
BETWEEN_LABORATORIES: Final = 0.8
"""Standard deviation of the logarithm of a size from one laboratory to another. Flanders
Hydraulics' tests of KCS (WL2012R00_066, tables 22 to 25) lie at 2.3 of it in Y."""
BETWEEN_CHANNELS: Final = 0.7
"""The same from one channel to another of one laboratory."""
STEPS: Final = 100
"""Newton steps after which the search ends, converged or not."""
LONGEST: Final = 2.0
"""Change of a logarithm in one step at most."""
CONVERGED: Final = 1e-9
"""Gain of log likelihood that a step promises from which the mode counts as found: a size is then
known to some 1e-5 of its uncertainty."""
SHORTEST: Final = 1e-4
"""Share of a step below which none is taken: rounding decides there."""
SLOW: Final = 0.3
"""Share of the gain that the step before promised from which steps are too short or too long: the
curvature is then taken along the last step as it was seen there (the formula of Broyden, Fletcher,
Goldfarb and Shanno). Where little tells a size, 37 steps become 16."""
SOON: Final = 1e-4
"""Share of the promised gain of likelihood that a step must bring (Armijo)."""


@dataclass(frozen=True, kw_only=True, eq=False)
class RunEffects:
    """Sizes of what runs draw for themselves with their weights, channel by channel.

    Parameters
    ----------
    nodes : mapping of channel to array (g, 4)
        Sizes of each of `KINDS`.
    weights : mapping of channel to array (g,)
        Posterior weight of each; they sum to one.
    scale : mapping of channel to float
        Rms force of a channel, by which offset and harmonics are measured [N, N m].
    informed : mapping of channel to tuple of str
        The kinds of which the runs of a channel say anything.

    Examples
    --------
    >>> RunEffects.usual({"Y": 100.0}).sizes("Y").round(4)
    array([0.0081, 0.0108, 0.0548, 0.0081])
    """

    KINDS: ClassVar[tuple[str, ...]] = tuple(MEDIANS)

    nodes: Mapping[str, Array]
    weights: Mapping[str, Array]
    scale: Mapping[str, float]
    informed: Mapping[str, tuple[str, ...]]

    @classmethod
    def usual(cls, scale: Mapping[str, float]) -> RunEffects:
        """Those of a laboratory that is not known, before any run is looked at."""
        return cls.of(dict.fromkeys(scale, ()), scale)

    @classmethod
    def of(
        cls,
        likelihoods: Mapping[str, Sequence[Restricted]],
        scale: Mapping[str, float],
        begin: Sequence[RunEffects] = (),
    ) -> RunEffects:
        """Sizes by restricted likelihood and a laboratory's prior.

        Parameters
        ----------
        likelihoods : mapping of channel to sequence of Restricted
            Those of a channel, such as one for each Froude number; their runs draw alike.
        scale : mapping of channel to float
            Rms force of each channel [N, N m].
        begin : sequence of RunEffects
            Where the search begins, of these channels at least; by default at the prior's medians.
            Of several modes the highest is taken.

        Notes
        -----
        The logarithms of the sizes have the prior N(log median, 1²) for the laboratory and N(that,
        0.4²) for each channel; the drift setting of a run is one for its channels. Their posterior
        has no edge: its mode is found by Newton steps with the average information, and its spread
        is summed over the 25 nodes of a rule of the fifth degree (McNamee and Stenger 1967, Numer.
        Math. 10) with the weights that the likelihood itself has there. Nothing is random, and no
        maximum at zero can stand for certainty. See Gelman (2006), Bayesian Anal. 1(3), on such
        priors.
        """
        places = dict(zip(likelihoods, _places(len(likelihoods)), strict=True))
        at, information = _mode(
            list(likelihoods.values()), [one._mode(likelihoods) for one in begin]
        )
        covariance = np.linalg.inv(information)
        nodes, weights, informed = {}, {}, {}
        for channel, items in likelihoods.items():
            own = places[channel]
            root = np.linalg.cholesky(covariance[np.ix_(own, own)])
            points, weight = _rule(len(cls.KINDS))
            away = points @ root.T
            logs = at[own] + away
            if items:
                slopes = [item.slope(at[own]) for item in items]
                value, gradient, curved = (sum(each) for each in zip(*slopes, strict=True))
                told = np.sum([item.log_likelihoods(logs) for item in items], axis=0)
                promised = value + away @ gradient - 0.5 * np.sum(away @ curved * away, axis=1)
                weight = weight * np.exp(told - promised - np.max(told - promised))
            nodes[channel], weights[channel] = np.exp(logs), weight / weight.sum()
            informed[channel] = tuple(
                name
                for kind, name in enumerate(cls.KINDS)
                if not items or any(item.acts(kind) for item in items)
            )
        return cls(nodes=nodes, weights=weights, scale=dict(scale), informed=informed)

    @staticmethod
    def most_probable(likelihoods: Mapping[str, Sequence[Restricted]]) -> dict[str, Array]:
        """Sizes (4,) of each channel at which the posterior of `of` is largest.

        Examples
        --------
        >>> RunEffects.most_probable({"Y": ()})["Y"].round(4)
        array([0.003, 0.004, 0.03 , 0.003])
        """
        at, _ = _mode(list(likelihoods.values()))
        return {
            channel: np.exp(at[own])
            for channel, own in zip(likelihoods, _places(len(likelihoods)), strict=True)
        }

    @classmethod
    def likelihood(
        cls, groups: Iterable[tuple[Array, Array]], model: int, shared: int = 0
    ) -> Restricted:
        """The restricted likelihood of the sizes by whitened rows of runs.

        Parameters
        ----------
        groups : iterable of (array (r, m, q), array (r, m, 3 + k))
            Columns of r runs of equal length, as `Restricted.of` takes them, and what each draws at
            size one: offset, gain, setting, harmonics.
        model, shared : int
            How many of the columns are the model's, and how many have a unit prior.
        """
        last = len(cls.KINDS) - 1
        made = [
            (columns, drawn, np.minimum(np.arange(drawn.shape[-1]), last))
            for columns, drawn in groups
        ]
        return Restricted.of(made, model, shared)

    @classmethod
    def repeatability(cls, conditions: Iterable[tuple[Array, Array, Array]]) -> Restricted | None:
        """The likelihood of the sizes by runs that repeat each other, whatever the model.

        Runs of one condition have one force. Their orthonormal contrasts have none, and draw as
        each of them. None where no run was repeated.

        Parameters
        ----------
        conditions : iterable of (array (r, m), array (m, 3 + k), array (m, m))
            What r runs measured, what each draws for itself at size one, and the covariance of
            their noise. A single run says nothing.
        """
        from scipy.linalg import helmert

        groups: dict[int, list[tuple[Array, Array]]] = {}
        for rows, drawn, noise in conditions:
            if len(rows) < 2:
                continue
            white = np.linalg.inv(np.linalg.cholesky(noise))
            own = white @ drawn
            groups.setdefault(rows.shape[1], []).extend(
                (white @ x, own) for x in helmert(len(rows)) @ rows
            )
        made = [
            (np.stack([x for x, _ in pairs])[..., None], np.stack([own for _, own in pairs]))
            for pairs in groups.values()
        ]
        return cls.likelihood(made, 0) if made else None

    def _mode(self, channels: Iterable[str]) -> Array:
        """Most probable logarithms of the sizes of channels, in the order of `_places`: the first
        node of each."""
        logs = [np.log(self.nodes[channel][0]) for channel in channels]
        return np.concatenate([logs[0][[SHARED]], *(np.delete(own, SHARED) for own in logs)])

    def sizes(self, channel: str) -> Array:
        """Root of the mean squares of the sizes in a channel, array (4,)."""
        found: Array = np.sqrt(self.weights[channel] @ self.nodes[channel] ** 2)
        return found

    @staticmethod
    def per_column(sizes: Array, rows: int) -> Array:
        """Sizes of `KINDS` for the columns of what a run draws, which has one for each harmonic.

        Parameters
        ----------
        sizes : array (…, 4)
            Of the kinds.
        rows : int
            Columns of the last kind.

        Returns
        -------
        array (…, 3 + rows)

        Examples
        --------
        >>> RunEffects.per_column(np.array([1.0, 2.0, 3.0, 4.0]), 2)
        array([1., 2., 3., 4., 4.])
        """
        return np.concatenate([sizes[..., :-1], np.repeat(sizes[..., -1:], rows, axis=-1)], axis=-1)

    def in_units(self, channel: str) -> dict[str, float]:
        """The sizes of which the runs say anything: offset and harmonics [N, N m], gain, drift
        [deg]."""
        unit = {"offset": self.scale[channel], "harmonics": self.scale[channel]}
        return {
            kind: float(size) * unit.get(kind, 1.0)
            for kind, size in zip(self.KINDS, self.sizes(channel), strict=True)
            if kind in self.informed[channel]
        }


def _places(count: int) -> list[list[int]]:
    """Where the sizes of each channel stand among all; the shared kind has one place."""
    return [
        [0 if kind == SHARED else 1 + channel * (len(MEDIANS) - 1) + (kind - (kind > SHARED))
         for kind in range(len(MEDIANS))]
        for channel in range(count)
    ]  # fmt: skip


def _prior(count: int) -> tuple[Array, Array]:
    """Mean and precision of the logarithms of all sizes."""
    places = _places(count)
    total = 1 + count * (len(MEDIANS) - 1)
    mean: Array = np.zeros(total)
    covariance: Array = np.zeros((total, total))
    for kind, name in enumerate(MEDIANS):
        own = sorted({places[channel][kind] for channel in range(count)})
        mean[own] = np.log(MEDIANS[name])
        covariance[np.ix_(own, own)] = BETWEEN_LABORATORIES**2
        covariance[own, own] += 0.0 if kind == SHARED else BETWEEN_CHANNELS**2
    return mean, np.asarray(np.linalg.inv(covariance), float)


def _mode(
    likelihoods: Sequence[Sequence[Restricted]], begin: Sequence[Array] = ()
) -> tuple[Array, Array]:
    """The most probable logarithms and the information there, by damped Newton steps from each
    beginning."""
    places = _places(len(likelihoods))
    mean, precision = _prior(len(likelihoods))

    def slope(at: Array) -> tuple[float, Array, Array]:
        away = at - mean
        value, gradient = -0.5 * float(away @ precision @ away), -precision @ away
        information = precision.copy()
        for items, own in zip(likelihoods, places, strict=True):
            for item in items:
                found, pull, curved = item.slope(at[own])
                value += found
                gradient[own] += pull
                information[np.ix_(own, own)] += curved
        return value, gradient, information

    found = [_climbed(slope, at) for at in (begin or [mean])]
    _, at, information = max(found, key=lambda one: one[0])
    return at, information


def _climbed(
    slope: Callable[[Array], tuple[float, Array, Array]], at: Array
) -> tuple[float, Array, Array]:
    """The value, place and information of the mode that Newton steps reach from a place."""
    last = np.inf
    value, gradient, information = slope(at)
    curved = information
    for _ in range(STEPS):
        step = np.linalg.solve(curved, gradient)
        if float(gradient @ step) < CONVERGED:
            break
        step *= min(1.0, LONGEST / float(np.max(np.abs(step))))
        share, promised = 1.0, float(gradient @ step)
        new = slope(at + step)
        while not new[0] >= value + SOON * share * promised and share > SHORTEST:
            share *= 0.5
            new = slope(at + share * step)
        if share <= SHORTEST:
            break
        moved, bent = share * step, gradient - new[1]
        at, (value, gradient, information) = at + moved, new
        curved = information
        if promised > SLOW * last and bent @ moved > 0.0:
            own = curved @ moved
            curved = curved - np.outer(own, own) / (moved @ own)
            curved += np.outer(bent, bent) / (bent @ moved)
        last = promised
    return value, at, information


def _rule(d: int) -> tuple[Array, Array]:
    """Points (g, d) and weights of a rule for the standard normal density, exact to degree 5."""
    pairs: Array = np.zeros((4 * (d * (d - 1) // 2), d))
    for number, (i, j) in enumerate(combinations(range(d), 2)):
        for place, (a, b) in enumerate(((1, 1), (1, -1), (-1, 1), (-1, -1))):
            pairs[4 * number + place, [i, j]] = np.sqrt(3.0) * np.array([a, b])
    # The weight of points on the axes, (4 - d) / 18, is zero in four dimensions.
    points: Array = np.concatenate([np.zeros((1, d)), pairs])
    weights: Array = np.full(len(points), 1.0 / 36.0)
    weights[0] = 1.0 / 3.0
    return points, weights
