"""Scatter between runs: what each run draws for itself, and how large that is."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from types import MappingProxyType
from typing import Final

import numpy as np

from pmmkit.numerics import Array
from pmmkit.observations.channels import Channel, Scatter
from pmmkit.observations.whitening import alike, noise_whitened, orthonormal

OFFSETS: Final = (0.0, 0.001, 0.002, 0.003, 0.005, 0.008, 0.013, 0.02, 0.03, 0.05)
GAINS: Final = (0.0, 0.002, 0.004, 0.006, 0.01, 0.02)
SETTINGS: Final = (0.0, 0.015, 0.03, 0.06)
"""Run scatter that the diagnosis tries: offset over the channel's scale, gain, drift [deg]."""
USUAL: Final[Mapping[str, float]] = MappingProxyType(
    {"offset": 0.003, "gain": 0.004, "drift": 0.03}
)
"""Medians of a good laboratory: offset over the channel's rms force, gain, drift setting [deg]."""
BETWEEN_LABORATORIES: Final = 0.8
"""Standard deviation of the logarithm of the sizes from one laboratory to another."""
BETWEEN_CHANNELS: Final = 0.4
"""The same from one channel to another of one laboratory."""
DOUBLINGS: Final[Mapping[str, tuple[int, int]]] = MappingProxyType(
    {"offset": (-6, 3), "gain": (-6, 3), "drift": (-4, 2)}
)
"""Sizes that are weighed: the usual one times these powers of two and all between. They reach
further down than up: runs of a solver may agree to rounding."""
NEGLIGIBLE: Final = 1e-4
"""Share of the greatest weight below which a node does not count."""
CHUNK: Final = 2**17
"""Numbers that one step over the nodes holds: a megabyte stays in the processor's cache."""
STEPS: Final = 60
"""Steps by which a half width is found at most: Newton's, or a bisection where those leave it."""
WIDE: Final = 32
"""Columns from which the sums of each node are faster made anew than weighed from shared ones."""


@dataclass(frozen=True, kw_only=True, eq=False)
class _Kind:
    """Products of runs that all sizes of the scatter share.

    Parameters
    ----------
    own : array (k (k + 1) / 2, runs, columns)
        Of pairs of rows of what each run draws, row by row of a lower triangle.
    products : array (k (k + 1) / 2 runs, q (q + 1) / 2)
        Of the same pairs, of the products with all columns: lower triangles of their sums.
    unit : array (k (k + 1) / 2, 1, 1)
        The unit matrix.
    """

    own: Array
    products: Array
    unit: Array

    @classmethod
    def of(cls, own: Array, across: Array) -> _Kind:
        """From what runs draw (runs, k, columns) and the products (runs, k, q) of its basis."""
        one, other = np.tril_indices(own.shape[1])
        up, down = np.tril_indices(across.shape[2])
        left, right = across[:, one].swapaxes(0, 1), across[:, other].swapaxes(0, 1)
        products = left[..., up] * right[..., down]
        apart = one != other
        products[apart] += left[apart][..., down] * right[apart][..., up]
        return cls(
            own=(own[:, one] * own[:, other]).swapaxes(0, 1),
            products=products.reshape(-1, len(up)),
            unit=np.where(apart, 0.0, 1.0)[:, None, None],
        )

    @property
    def rank(self) -> int:
        """Rows of each run's own basis."""
        return int(np.count_nonzero(self.unit))


@dataclass(frozen=True, kw_only=True, eq=False)
class Restricted:
    """What the restricted likelihood of run scatter needs of one channel, whitened by its noise.

    The columns of `whole` and of the sums are: the largest model, the smooth floor, the data.

    Parameters
    ----------
    whole : array (q, q)
        Products of all columns.
    own : array (runs, k, k)
        What each run draws for itself, at size one, in an orthonormal basis of that.
    across : array (runs, k, q)
        Products of that basis with all columns.
    model, floor : int
        How many columns the model and the floor have.
    back : array (p, model)
        From the orthonormal basis to the coefficients of the model.
    """

    whole: Array
    own: Array
    across: Array
    model: int
    floor: int
    back: Array

    def log_likelihood(self, sizes: Array) -> Array:
        """Of several scatters, array (g, k) of their sizes; minus infinity where singular."""
        return np.concatenate([self._likelihood(part) for part in self._parts(sizes)])

    def estimates(self, sizes: Array) -> tuple[Array, Array]:
        """Coefficients and their variances by generalised least squares, arrays (g, p) each."""
        parts = []
        for part in self._parts(sizes):
            gram, _ = self._gram(part)
            inverse = np.linalg.inv(gram[:, : self.model, : self.model])
            value = np.einsum("pm,gmn,gn->gp", self.back, inverse, gram[:, : self.model, -1])
            variance = np.einsum("pm,gmn,pn->gp", self.back, inverse, self.back)
            parts.append((value, variance))
        return np.concatenate([x for x, _ in parts]), np.concatenate([x for _, x in parts])

    def _parts(self, sizes: Array) -> list[Array]:
        runs, k, q = self.across.shape
        held = max(1, CHUNK // max(runs * k * (k + 1) // 2, q * q))
        return [sizes[begin : begin + held] for begin in range(0, len(sizes), held)]

    def _gram(self, sizes: Array) -> tuple[Array, Array]:
        """Products under the covariance of noise and scatter, and the log determinant of it.

        Each run takes its own share off the sums of all (Woodbury).
        """
        taken, logs = self._one_by_one(sizes) if len(self.whole) > WIDE else self._at_once(sizes)
        gram = self.whole - taken
        diagonal = np.arange(self.model, self.model + self.floor)
        gram[:, diagonal, diagonal] += 1.0
        return gram, logs

    def _one_by_one(self, sizes: Array) -> tuple[Array, Array]:
        """What the runs take off (g, q, q), and log determinants (g,): I - (I + D D')⁻¹ is
        D (I + D'D)⁻¹ D', a square, which is summed as one."""
        k, q = self.own.shape[-1], len(self.whole)
        taken, logs = np.empty((len(sizes), q, q)), np.empty(len(sizes))
        for place, size in enumerate(sizes):
            drawn = self.own * size
            turned = np.swapaxes(drawn, 1, 2)
            root = np.linalg.cholesky(turned @ drawn + np.eye(k))
            shares = (np.linalg.solve(root, turned) @ self.across).reshape(-1, q)
            taken[place] = shares.T @ shares
            logs[place] = np.log(np.diagonal(root, axis1=1, axis2=2)).sum()
        return taken, logs

    def _at_once(self, sizes: Array) -> tuple[Array, Array]:
        """The same where the columns are few, weighed from products that all sizes share.

        In the orthonormal basis of a run no weight of a share is above one, so that they are summed
        by one product of matrices.
        """
        q = len(self.whole)
        up, down = np.tril_indices(q)
        taken, logs = np.zeros((len(sizes), len(up))), np.zeros(len(sizes))
        for kind in self._kinds:
            inverse, own = _inverse(kind.own @ sizes.T**2, kind.rank)
            logs += own
            taken += (kind.unit - inverse).reshape(-1, len(sizes)).T @ kind.products
        square = np.empty((len(sizes), q, q))
        square[:, up, down] = square[:, down, up] = taken
        return square, logs

    @cached_property
    def _kinds(self) -> tuple[_Kind, ...]:
        """The runs by how many rows their own basis has: one where only a mean was measured."""
        ranks = np.any(self.own != 0.0, axis=2).sum(axis=1)
        kinds = [(rank, ranks == rank) for rank in np.unique(ranks[ranks > 0]).tolist()]
        return tuple(_Kind.of(self.own[runs, :k], self.across[runs, :k]) for k, runs in kinds)

    def _likelihood(self, sizes: Array) -> Array:
        gram, logs = self._gram(sizes)
        order = np.r_[self.model : self.model + self.floor, : self.model]
        square, cross = gram[:, order[:, None], order], gram[:, order, -1]
        try:
            root = np.linalg.cholesky(square)
        except np.linalg.LinAlgError:
            if len(sizes) == 1:
                return np.array([-np.inf])
            return np.concatenate([self._likelihood(one[None]) for one in sizes])
        explained = np.sum(np.linalg.solve(root, cross[:, :, None])[:, :, 0] ** 2, axis=1)
        logs = logs + np.log(np.diagonal(root, axis1=-2, axis2=-1)).sum(axis=1)
        found: Array = -logs - 0.5 * np.maximum(gram[:, -1, -1] - explained, 0.0)
        return found


def _inverse(products: Array, k: int) -> tuple[Array, Array]:
    """Inverses of I plus very many very small symmetric matrices, and half their log determinants.

    Parameters
    ----------
    products : array (k (k + 1) / 2, runs, g)
        Lower triangles, row by row.

    Returns
    -------
    inverse : array (k (k + 1) / 2, runs, g)
    logs : array (g,)
        Summed over the runs.

    Notes
    -----
    Cholesky's factors element by element over all at once: a call of LAPACK for each takes longer
    than its few products.
    """
    pairs = [(i, j) for i in range(k) for j in range(i + 1)]
    root: dict[tuple[int, int], Array] = {}
    for (i, j), product in zip(pairs, products, strict=True):
        rest = product + float(i == j)
        for n in range(j):
            rest -= root[i, n] * root[j, n]
        root[i, j] = np.sqrt(rest) if i == j else rest / root[j, j]
    back = {(i, i): 1.0 / root[i, i] for i in range(k)}
    for i, j in pairs:
        if i != j:
            found = np.zeros_like(products[0])
            for n in range(j, i):
                found -= root[i, n] * back[n, j]
            back[i, j] = found * back[i, i]
    inverse = np.zeros_like(products)
    for own, (i, j) in zip(inverse, pairs, strict=True):
        for n in range(i, k):
            own += back[n, i] * back[n, j]
    logs: Array = np.sum([np.log(root[i, i]).sum(axis=0) for i in range(k)], axis=0)
    return inverse, logs


def restricted(
    channel: Channel, own: Array, model: Array, floor: Array | None = None
) -> Restricted:
    """The restricted likelihood of what the runs of a channel draw for themselves.

    Parameters
    ----------
    channel : Channel
        Rows and noise.
    own : array (n, k)
        What each run draws for itself, at size one.
    model : array (n, p)
        The model that the runs share.
    floor : array (n, D), optional
        Features of a smooth floor at its size, which have a unit prior.
    """
    features = np.zeros((len(channel.y), 0)) if floor is None else floor
    white = noise_whitened(channel, np.column_stack([model, features, channel.y, own]))
    p, q = model.shape[1], features.shape[1]
    basis = orthonormal(white[:, :p])
    A = np.column_stack([basis, white[:, p : p + q + 1]])
    drawn = [_in_own_basis(white[at][:, :, p + q + 1 :], A[at]) for at in alike(channel)]
    length = np.linalg.norm(white[:, :p], axis=0)
    unit = np.where(length > 0, length, 1.0)
    back = np.linalg.pinv(basis.T @ (white[:, :p] / unit), rcond=1e-9) / unit[:, None]
    return Restricted(
        whole=A.T @ A,
        own=np.concatenate([x for x, _ in drawn]),
        across=np.concatenate([x for _, x in drawn]),
        model=basis.shape[1],
        floor=q,
        back=back,
    )


def _in_own_basis(own: Array, columns: Array) -> tuple[Array, Array]:
    """Columns (runs, m, k) in an orthonormal basis of them, and products of it with others."""
    basis, factor = np.linalg.qr(own)
    short = ((0, 0), (0, own.shape[2] - factor.shape[1]), (0, 0))
    return np.pad(factor, short), np.pad(np.swapaxes(basis, 1, 2) @ columns, short)


def estimated_scatter(
    channels: Sequence[Channel],
    own: Mapping[str, Array],
    models: Mapping[str, Array],
    floors: Mapping[str, Array],
) -> Scatter:
    """Run scatter of the greatest restricted likelihood, one for all channels.

    Parameters
    ----------
    channels : sequence of Channel
        Rows.
    own : mapping of channel to array (n, 3)
        What each run draws for itself, at size one.
    models : mapping of channel to array (n, p)
        The largest model, so that a missing effect is not taken for scatter.
    floors : mapping of channel to array (n, D)
        Features of the smooth floor at its size.

    Returns
    -------
    Scatter
    """
    found = [restricted(c, own[c.name], models[c.name], floors[c.name]) for c in channels]
    best = Scatter()
    for field, tried in (
        ("offset", OFFSETS),
        ("gain", GAINS),
        ("drift", SETTINGS),
        ("offset", OFFSETS),
    ):
        options = [replace(best, **{field: x}) for x in tried]
        sizes = np.stack([option.sizes for option in options])
        best = options[int(np.argmax(sum(item.log_likelihood(sizes) for item in found)))]
    return best


@dataclass(frozen=True, kw_only=True, eq=False)
class RunScatter:
    """How much runs scatter between each other: sizes with their weights, channel by channel.

    Parameters
    ----------
    nodes : array (g, 3)
        Sizes of offset (over the channel's rms force), gain, and drift setting [deg].
    weights : mapping of channel to array (g,)
        Posterior weight of each; they sum to one.

    Examples
    --------
    >>> RunScatter.usual(["Y"])
    <RunScatter Y: offset 0.61 %, gain 0.82 %, drift 0.049°>
    """

    nodes: Array
    weights: Mapping[str, Array]

    @classmethod
    def usual(cls, channels: Sequence[str]) -> RunScatter:
        """That of a good laboratory, before any run is looked at."""
        nodes, _, _ = _grid()
        return cls(nodes=nodes, weights=_weights(dict.fromkeys(channels, np.zeros(len(nodes)))))

    def sizes(self, channel: str) -> Array:
        """Root of the mean squares of the sizes in a channel, array (3,)."""
        return np.sqrt(self.weights[channel] @ self.nodes**2)

    def weighed(self, channel: str) -> tuple[Array, Array]:
        """The nodes that count in a channel and their weights, arrays (g, 3) and (g,)."""
        weight = self.weights[channel]
        counts = weight > NEGLIGIBLE * weight.max()
        return self.nodes[counts], weight[counts] / weight[counts].sum()

    def __repr__(self) -> str:
        told = [f"{channel}: {self.words(channel)}" for channel in self.weights]
        return f"<RunScatter {'; '.join(told)}>"

    def words(self, channel: str) -> str:
        """The sizes in one channel, in words."""
        offset, gain, drift = self.sizes(channel).tolist()
        return f"offset {100 * offset:.2g} %, gain {100 * gain:.2g} %, drift {drift:.2g}°"


def run_scatter(likelihoods: Mapping[str, Sequence[Restricted]]) -> RunScatter:
    """Sizes of the scatter between runs by restricted likelihood and the laboratory's prior.

    The sizes of gain and offset differ a little between the channels of one laboratory, and
    laboratories differ more; the setting of a run is one for its channels. With few runs the
    prior speaks, with many the runs' own disagreement.

    Parameters
    ----------
    likelihoods : mapping of channel to sequence of Restricted
        Those of a channel, such as one for each Froude number; their runs scatter alike.

    Returns
    -------
    RunScatter

    Notes
    -----
    Log sizes have the normal prior N(log median, 0.8²) for the laboratory and N(log of that,
    0.4²) for each channel; all integrals are sums over a grid, so nothing is random and no
    maximum at zero can stand for certainty. See Gelman (2006), Bayesian Anal. 1(3), on priors
    for the variance of few groups.
    """
    nodes, _, _ = _grid()
    return RunScatter(
        nodes=nodes,
        weights=_weights(
            {
                channel: np.sum([item.log_likelihood(nodes) for item in items], axis=0)
                for channel, items in likelihoods.items()
            }
        ),
    )


def _grid() -> tuple[Array, tuple[Array, ...], tuple[int, ...]]:
    """Sizes that are tried: all combinations (g, 3), and one by one."""
    axes: tuple[Array, ...] = tuple(
        USUAL[name] * np.exp2(np.arange(low, high + 1.0))
        for name in Scatter.names()
        for low, high in [DOUBLINGS[name]]
    )
    mesh = np.meshgrid(*axes, indexing="ij")
    nodes: Array = np.stack([x.ravel() for x in mesh], axis=1)
    return nodes, axes, tuple(len(axis) for axis in axes)


def _weights(logs: Mapping[str, Array]) -> dict[str, Array]:
    """Posterior weights of the grid in each channel, laboratory's sizes summed out."""
    _, axes, shape = _grid()
    to_channel = []
    laboratory = []
    for axis, name in zip(axes, Scatter.names(), strict=True):
        prior = np.exp(-0.5 * (np.log(axis / USUAL[name]) / BETWEEN_LABORATORIES) ** 2)
        laboratory.append(prior / prior.sum())
        near = np.exp(-0.5 * (np.log(axis[:, None] / axis) / BETWEEN_CHANNELS) ** 2)
        to_channel.append(near / near.sum(axis=1, keepdims=True))
    offset, gain, _ = to_channel
    prior = np.einsum("a,b,c->abc", *laboratory)
    likelihood = {channel: np.exp(log - log.max()).reshape(shape) for channel, log in logs.items()}
    evidence = {
        channel: np.einsum("ai,bj,ijc->abc", offset, gain, x) for channel, x in likelihood.items()
    }
    found = {}
    for channel, own in likelihood.items():
        others = prior.copy()
        for name, x in evidence.items():
            if name != channel:
                others = others * x / x.max()
        weight = own * np.einsum("ai,bj,abc->ijc", offset, gain, others)
        found[channel] = (weight / weight.sum()).ravel()
    return found


def half_width(
    value: Array, variance: Array, weight: Array, centre: Array, confidence: float
) -> Array:
    """Half width of the symmetric interval about a centre that holds a mixture of normals.

    Parameters
    ----------
    value, variance : array (g, p)
        Of each coefficient at each node.
    weight : array (g,)
        Of the nodes.
    centre : array (p,)
        Middle of the interval.
    confidence : float
        What it holds.

    Examples
    --------
    >>> one = np.ones((1, 1))
    >>> half_width(0 * one, one, np.ones(1), np.zeros(1), 0.95).round(3)
    array([1.96])
    """
    from scipy.special import ndtr

    std = np.sqrt(variance)
    away = value - centre
    low = np.zeros_like(centre)
    high: Array = np.max(np.abs(away) + 10.0 * std, axis=0)
    half: Array = 2.0 * np.sqrt(weight @ (variance + away**2))
    for _ in range(STEPS):
        right, left = (half - away) / std, (-half - away) / std
        short = weight @ (ndtr(right) - ndtr(left)) - confidence
        density = weight @ ((np.exp(-0.5 * right**2) + np.exp(-0.5 * left**2)) / std)
        low, high = np.where(short < 0, half, low), np.where(short < 0, high, half)
        with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
            newton = half - short / density * np.sqrt(2.0 * np.pi)
        before = half
        half = np.where((newton > low) & (newton < high), newton, 0.5 * (low + high))
        if np.all(np.abs(half - before) <= 1e-14 * half):
            break
    return half
