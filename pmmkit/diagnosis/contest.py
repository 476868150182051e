"""Building the system, and the evidence for effects, one or several at once."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import combinations
from typing import Final

import numpy as np
from numpy.typing import NDArray

from pmmkit.diagnosis.base import Base
from pmmkit.diagnosis.candidate import Candidate
from pmmkit.diagnosis.system import (
    GAINS,
    OFFSETS,
    SETTINGS,
    TRANSIENT,
    TYPICAL_TRANSIENT,
    WIDER,
    Block,
    Channel,
    Scatter,
    System,
    candidate_columns,
    channels_of,
    floor_features,
    log_likelihood,
    noise,
    random_effects,
    transient_columns,
    whitened,
)
from pmmkit.diagnosis.views import View

Array = NDArray[np.float64]
Places = NDArray[np.intp]
MOST: Final = 3
"""Effects in a set."""
AHEAD: Final = 8
"""Best single effects that are combined with all others."""


def fitted(base: Base, channels: Sequence[Channel], views: Sequence[View]) -> Base:
    """The base with values by weighted least squares, run scatter at usual sizes."""
    values: dict[str, float] = dict(base.values)
    for channel in channels:
        V = noise(channel, views)
        rough = np.diag(np.diagonal(V)) + 1e-30 * np.eye(len(V))
        spread = 0.004 * channel.scale * base.reference**2
        X, z = whitened(rough + spread**2 * np.eye(len(V)), channel.design, channel.y)
        size = np.linalg.norm(X, axis=0)
        size = np.where(size > 0, size, 1.0)
        found = np.linalg.lstsq(X / size, z, rcond=1e-10)[0] / size
        values |= dict(zip(base.names[channel.name], found.tolist(), strict=True))
    return replace(base, values=values)


def build(
    views: Sequence[View], base: Base, candidates: Sequence[Candidate], *, floor: float = 0.005
) -> System:
    """The system of a campaign.

    Parameters
    ----------
    views : sequence of View
        Runs.
    base : Base
        Names of the derivatives; values are fitted.
    candidates : sequence of Candidate
        All that take part.
    floor : float
        Size of what is too small to matter, over the largest force of a channel: the user's
        uncertainty of everything that is smooth in the motion.
    """
    channels = channels_of(views, base)
    base = fitted(base, channels, views)
    predicted = {
        c.name: c.design @ [base.values[name] for name in base.names[c.name]] for c in channels
    }
    raw = [
        (candidate, value, candidate_columns(candidate, value, channels, views, base))
        for candidate in candidates
        for value in candidate.grid
    ]
    effects = {c.name: random_effects(c, views, base, predicted[c.name]) for c in channels}
    features = {c.name: floor_features(c, views, base) for c in channels}
    parts = {
        c.name: _Parts(
            noise=noise(c, views) + floor**2 * (features[c.name] @ features[c.name].T),
            scatter={name: own @ own.T for name, own in effects[c.name].items()},
        )
        for c in channels
    }
    scatter = _scatter(channels, parts, raw)
    wide = WIDER * TYPICAL_TRANSIENT
    pieces = [
        _projected(
            c, _total(parts[c.name], scatter),
            {
                **{(number, 0): item[2][c.name] * _sizes(item[0])
                   for number, item in enumerate(raw) if c.name in item[2]},
                **{(len(raw) + number, place): wide * transient_columns(
                       c, views, base, predicted[c.name], decay)
                   for number, decay in enumerate(TRANSIENT)},
                (len(raw) + len(TRANSIENT), place): floor * features[c.name],
            },
        )
        for place, c in enumerate(channels)
    ]  # fmt: skip
    return _assembled(tuple(views), base, channels, scatter, raw, pieces)


def _sizes(candidate: Candidate) -> Array:
    return np.array([WIDER * abs(size) for size in candidate.typical])


@dataclass(frozen=True, kw_only=True, eq=False)
class _Piece:
    """One channel whitened, the base projected off: columns by (block, place), and the data."""

    columns: Mapping[tuple[int, int], Array]
    data: Array
    freedom: int


def _projected(c: Channel, V: Array, columns: Mapping[tuple[int, int], Array]) -> _Piece:
    keys = list(columns)
    stacked = np.concatenate([c.design, *(columns[key] for key in keys)], axis=1)
    W, z = whitened(V, stacked, c.y)
    p = c.design.shape[1]
    size = np.linalg.norm(W[:, :p], axis=0)
    U, s, _ = np.linalg.svd(W[:, :p] / np.where(size > 0, size, 1.0), full_matrices=False)
    Q = U[:, s > 1e-9 * s[0]]
    E = W[:, p:] - Q @ (Q.T @ W[:, p:])
    edges = np.cumsum([columns[key].shape[1] for key in keys])[:-1]
    return _Piece(
        columns=dict(zip(keys, np.split(E, edges, axis=1), strict=True)),
        data=z - Q @ (Q.T @ z), freedom=len(c.y) - Q.shape[1],
    )  # fmt: skip


@dataclass(frozen=True, kw_only=True, eq=False)
class _Parts:
    """Covariance of a channel: noise with the floor, and what each source of scatter adds."""

    noise: Array
    scatter: Mapping[str, Array]


def _total(parts: _Parts, scatter: Scatter) -> Array:
    V = parts.noise
    for name, size in (
        ("offset", scatter.offset), ("gain", scatter.gain), ("drift", scatter.drift)
    ):  # fmt: skip
        if size > 0:
            V = V + size**2 * parts.scatter[name]
    return V + 1e-12 * np.mean(np.diagonal(V)) * np.eye(len(V))


def _scatter(
    channels: Sequence[Channel], parts: Mapping[str, _Parts],
    raw: Sequence[tuple[Candidate, float, Mapping[str, Array]]],
) -> Scatter:  # fmt: skip
    """Run scatter of the greatest restricted likelihood under the largest model."""
    designs = {}
    for c in channels:
        seen: dict[str, Array] = {}
        for candidate, _, columns in raw:
            if c.name in columns and candidate.name not in seen:
                seen[candidate.name] = columns[c.name]
        full = np.concatenate([c.design, *seen.values()], axis=1)
        size = np.linalg.norm(full, axis=0)
        full = full[:, size > 0] / size[size > 0]
        U, s, _ = np.linalg.svd(full, full_matrices=False)
        designs[c.name] = U[:, s > 1e-8 * s[0]]

    def value(scatter: Scatter) -> float:
        return sum(
            log_likelihood(_total(parts[c.name], scatter), designs[c.name], c.y) for c in channels
        )

    best = Scatter(offset=0.003, gain=0.004, drift=0.0)
    for field, tried in (("offset", OFFSETS), ("gain", GAINS), ("drift", SETTINGS),
                         ("offset", OFFSETS)):  # fmt: skip
        best = max((replace(best, **{field: x}) for x in tried), key=value)
    return best


def _assembled(
    views: tuple[View, ...], base: Base, channels: tuple[Channel, ...], scatter: Scatter,
    raw: Sequence[tuple[Candidate, float, Mapping[str, Array]]], pieces: Sequence[_Piece],
) -> System:  # fmt: skip
    """One Gram matrix over all channels from the columns of each."""
    blocks: list[Block] = []
    widths: dict[tuple[int, int], int] = {}
    for piece in pieces:
        for key, own in piece.columns.items():
            widths[key] = max(widths.get(key, 0), own.shape[1])
    for number, (candidate, _, _) in enumerate(raw):
        widths[number, 0] = candidate.size
    starts, at = {}, 0
    for key in sorted(widths):
        starts[key] = at
        at += widths[key]
    ends = {number: max(starts[k] + widths[k] for k in widths if k[0] == number)
            for number in {key[0] for key in widths}}  # fmt: skip
    begins = {number: min(starts[k] for k in widths if k[0] == number) for number in ends}
    for number, (candidate, value, _) in enumerate(raw):
        blocks.append(
            Block(candidate=candidate, value=value, columns=slice(begins[number], ends[number]))
        )
    for place, decay in enumerate(TRANSIENT):
        number = len(raw) + place
        if number in ends:
            blocks.append(
                Block(
                    candidate=TRANSIENT_FAULT, value=decay,
                    columns=slice(begins[number], ends[number]),
                )
            )  # fmt: skip
    gram, score = np.zeros((at, at)), np.zeros(at)
    for piece in pieces:
        places: Places = np.concatenate(
            [np.arange(starts[key], starts[key] + x.shape[1]) for key, x in piece.columns.items()]
        )
        E = np.concatenate(list(piece.columns.values()), axis=1)
        gram[np.ix_(places, places)] += E.T @ E
        score[places] += E.T @ piece.data
    prior, centre = np.ones(at), np.zeros(at)
    for block in blocks[: len(raw)]:
        prior[block.columns] = _sizes(block.candidate)
        if block.candidate.centre:
            centre[block.columns] = np.array(block.candidate.centre) / prior[block.columns]
    last = len(raw) + len(TRANSIENT)
    return System(
        views=views, base=base, channels=channels, scatter=scatter, blocks=tuple(blocks),
        gram=gram, score=score, square=float(sum(x.data @ x.data for x in pieces)),
        rows=sum(x.freedom for x in pieces), floor_columns=slice(begins[last], ends[last]),
        prior=prior, centre=centre,
    )  # fmt: skip


def _no_columns(view: View, base: Base, value: float) -> Mapping[str, Array]:
    del view, base, value
    return {}


TRANSIENT_FAULT: Final = Candidate(
    name="fault_transient", family="rig", kind="fault",
    summary="Forces of the start that have not died away.", coefficients=("share [-]",),
    typical=(TYPICAL_TRANSIENT,), columns=_no_columns, grid=TRANSIENT,
    parameter="decay in L/U", check="leave out more cycles",
)  # fmt: skip


def log_evidence(gram: Array, score: Array, centre: Array) -> float:
    """ln of how much better the data are explained with columns than without.

    Parameters
    ----------
    gram, score : array (q, q), (q,)
        Of the columns, in units of their prior standard deviation.
    centre : array (q,)
        Expected coefficients, in the same.

    Returns
    -------
    float
        For z ~ N(E c, I + E E') against N(0, I).
    """
    shifted = score - gram @ centre
    root = np.linalg.cholesky(gram + np.eye(len(centre)))
    half = np.linalg.solve(root, shifted)
    gained = float(score @ centre - 0.5 * centre @ gram @ centre)
    return gained + float(0.5 * half @ half - np.sum(np.log(np.diagonal(root))))


def evidence_at(system: System, at: Places, size: Array | None = None) -> float:
    """`log_evidence` of some columns of a system, of other size where asked for."""
    scale = np.ones(len(at)) if size is None else size
    return log_evidence(
        system.gram[np.ix_(at, at)] * np.outer(scale, scale), system.score[at] * scale,
        system.centre[at] / scale,
    )  # fmt: skip


@dataclass(frozen=True, kw_only=True)
class Entry:
    """A set of effects with its evidence.

    Parameters
    ----------
    names : tuple of str
        Effects.
    log_evidence : float
        Against no effect, averaged over the grids, with the price of the catalogue's size.
    values : tuple of float
        Best grid value of each.
    """

    names: tuple[str, ...]
    log_evidence: float
    values: tuple[float, ...]


def contest(system: System, *, most: int = MOST) -> list[Entry]:
    """All single effects, and the sets that deserve it, best first."""
    by_name: dict[str, list[Block]] = {}
    for block in system.blocks:
        by_name.setdefault(block.candidate.name, []).append(block)
    price = math.log(2.0 * len(by_name))
    index = {id(block): np.arange(block.columns.start, block.columns.stop)
             for block in system.blocks}  # fmt: skip

    near = {name: _near(system, index, own) for name, own in by_name.items()}

    def entry(names: Sequence[str]) -> Entry:
        grids = [by_name[name] for name in names]
        if len(names) > 1:
            grids = [near[name] for name in names]
        found = []
        for blocks in _product(grids):
            at = np.concatenate([index[id(block)] for block in blocks])
            value = evidence_at(system, at)
            found.append((value, tuple(block.value for block in blocks)))
        top = max(found)
        total = sum(math.exp(value - top[0]) for value, _ in found)
        share = math.prod(len(by_name[name]) for name in names)
        return Entry(
            names=tuple(names), values=top[1],
            log_evidence=top[0] + math.log(total / share) - price * len(names),
        )  # fmt: skip

    singles = sorted((entry([name]) for name in by_name), key=lambda x: -x.log_evidence)
    found = list(singles)
    best = [x.names[0] for x in singles[:AHEAD]]
    pairs: list[Entry] = []
    if most > 1:
        wanted = {tuple(sorted(pair)) for pair in combinations(best, 2)}
        wanted |= {tuple(sorted((a, b))) for a in best[:4] for b in by_name if b != a}
        pairs = sorted((entry(pair) for pair in sorted(wanted)), key=lambda x: -x.log_evidence)
        found += pairs
    if most > 2 and pairs:
        triples = {
            tuple(sorted((*pair.names, name)))
            for pair in pairs[:3]
            for name in by_name
            if name not in pair.names
        }
        found += [entry(names) for names in sorted(triples)]
    return sorted(found, key=lambda x: -x.log_evidence)


def _near(system: System, index: Mapping[int, Places], own: Sequence[Block]) -> list[Block]:
    """The two grid points of an effect that explain most by themselves."""
    ranked = sorted(own, key=lambda b: -evidence_at(system, index[id(b)]))
    return ranked[:2]


def _product(grids: Sequence[Sequence[Block]]) -> list[tuple[Block, ...]]:
    found: list[tuple[Block, ...]] = [()]
    for own in grids:
        found = [(*blocks, block) for blocks in found for block in own]
    return found


def gate(system: System, best: float, *, draws: int = 400, seed: int = 0) -> float:
    """Probability that no effect at all gives a single effect as good as the best.

    Scores of the null are drawn from their own covariance, the Gram matrix; the largest evidence
    over the whole catalogue and its grids is kept of each draw (Westfall and Young 1993).
    """
    used = system.blocks
    at = np.arange(used[-1].columns.stop)
    values, vectors = np.linalg.eigh(system.gram[np.ix_(at, at)])
    root = vectors * np.sqrt(np.maximum(values, 0.0))
    drawn = np.random.default_rng(seed).normal(size=(draws, len(at))) @ root.T
    largest = np.full(draws, -np.inf)
    by_name: dict[str, list[Array]] = {}
    for block in used:
        own = np.arange(block.columns.start, block.columns.stop)
        G, c = system.gram[np.ix_(own, own)], system.centre[own]
        L = np.linalg.cholesky(G + np.eye(len(own)))
        half = np.linalg.solve(L, (drawn[:, own] - G @ c).T)
        value = drawn[:, own] @ c - 0.5 * c @ G @ c
        value = value + 0.5 * np.sum(half**2, axis=0) - np.sum(np.log(np.diagonal(L)))
        by_name.setdefault(block.candidate.name, []).append(value)
    price = math.log(2.0 * len(by_name))
    for own_values in by_name.values():
        stacked = np.stack(own_values)
        top = stacked.max(axis=0)
        mean = top + np.log(np.mean(np.exp(stacked - top), axis=0))
        largest = np.maximum(largest, mean - price)
    return float((1 + np.sum(largest >= best)) / (draws + 1))
