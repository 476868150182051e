"""What an effect does to standard tests, generated from its definition; and what mimics it."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any, Final

import numpy as np

from pmmkit.diagnosis import standard_tests
from pmmkit.diagnosis.captive.base import CaptiveBase
from pmmkit.diagnosis.captive.candidate import Candidate
from pmmkit.diagnosis.captive.standard import CHANNELS
from pmmkit.diagnosis.evidence import MIMICS
from pmmkit.inference import RANK_TOLERANCE
from pmmkit.numerics import Array
from pmmkit.reduction import View

LEAST: Final = 0.01
"""Share of a channel's force below which an effect is not said to act there."""
SAME: Final = 1e-6
"""Runs whose harmonics differ by no more are alike; the first stands for them."""
ABSORBED: Final = 1e-3
"""Share of its square outside the hull's terms below which an effect is absorbed by them."""


@dataclass(frozen=True, kw_only=True)
class Signature:
    """An effect of usual size in standard tests.

    `acts`: mean (C0) and harmonics in phase with the velocity (C1 …) and the displacement (S1
    …), over the rms force of the channel in these tests; what is below 1 % is left out.
    `mimics`: effects that reproduce most of it beside a cubic hull, with the share. `absorbed`:
    whether the terms of a cubic hull take it over: no residual shows it.
    """

    name: str
    acts: Mapping[str, Mapping[str, Mapping[str, float]]]
    mimics: Mapping[str, float]
    absorbed: bool


def signatures(candidates: Sequence[Candidate]) -> tuple[Signature, ...]:
    """Signatures of effects, from their columns alone.

    Examples
    --------
    >>> from pmmkit.diagnosis.captive.candidate import candidate_of
    >>> from pmmkit.effects import CATALOGUE
    >>> (found,) = signatures([candidate_of(CATALOGUE["modulus_sway_drag"])])
    >>> sway = found.acts["pure_sway"]["Y"]
    >>> sorted(sway), round(sway["C3"] / sway["C1"], 2)
    (['C1', 'C3'], 0.2)
    """
    views, base = standard_tests()
    sizes = _sizes(views, base)
    hull = {c: base.design(base.names[c], views) for c in CHANNELS}
    over = {
        c: np.concatenate([np.full(v.rows, sizes[v.speed, c]) for v in views]) for c in CHANNELS
    }
    outside = {c: _projector(hull[c] / over[c][:, None]) for c in CHANNELS}
    plain = {
        (item.name, value): [
            _stacked(item, value, c, views, base) / over[c][:, None] for c in CHANNELS
        ]
        for item in candidates
        for value in item.grid
    }
    blocks = {
        key: np.concatenate([outside[c](x) for c, x in zip(CHANNELS, own, strict=True)])
        for key, own in plain.items()
    }
    found = []
    for item in candidates:
        whole = np.concatenate(plain[item.name, _middle(item)]) @ _usual(item)
        left = blocks[item.name, _middle(item)] @ _usual(item)
        hidden = bool(left @ left <= ABSORBED * (whole @ whole))
        acts = [_acts(item, value, views, base, sizes) for value in (_middle(item), *item.grid)]
        found.append(
            Signature(
                name=item.name,
                acts=MappingProxyType(next((x for x in acts if x), {})),
                mimics=MappingProxyType({} if hidden else _mimics(item.name, left, blocks)),
                absorbed=hidden,
            )
        )
    return tuple(found)


def _middle(candidate: Candidate) -> float:
    return candidate.grid[len(candidate.grid) // 2]


def _usual(candidate: Candidate) -> Array:
    return np.array(candidate.centre or candidate.typical)


def _stacked(
    candidate: Candidate, value: float, channel: str, views: Sequence[View], base: CaptiveBase
) -> Array:
    none = np.zeros((1, candidate.size))
    return np.concatenate(
        [
            columns.get(channel, np.repeat(none, view.rows, axis=0))
            for view, columns in zip(views, candidate.columns(views, base, value), strict=True)
        ]
    )


def _acts(
    candidate: Candidate,
    value: float,
    views: Sequence[View],
    base: CaptiveBase,
    sizes: Mapping[tuple[float, str], float],
) -> dict[str, dict[str, dict[str, float]]]:
    """By test the harmonics of the run in which they are largest."""
    found: dict[str, dict[str, dict[str, float]]] = {}
    for view, by_channel in zip(views, candidate.columns(views, base, value), strict=True):
        for channel, columns in by_channel.items():
            shares = columns @ _usual(candidate) / sizes[view.speed, channel]
            own = {
                label: float(x)
                for label, x in zip(_labels(view.rows), shares, strict=True)
                if abs(x) >= max(LEAST, 0.05 * np.abs(shares).max())
            }
            before = found.setdefault(view.run.test, {}).get(channel, {})
            if _largest(own) > (1.0 + SAME) * _largest(before):
                found[view.run.test][channel] = own
    return {test: own for test, own in found.items() if own}


def _largest(shares: Mapping[str, float]) -> float:
    return max(map(abs, shares.values()), default=0.0)


def _labels(rows: int) -> list[str]:
    return ["C0", *(f"{kind}{n}" for n in range(1, rows // 2 + 1) for kind in "CS")]


def _mimics(name: str, left: Array, blocks: Mapping[tuple[str, float], Array]) -> dict[str, float]:
    """Share of a signature that each other effect reproduces at its best grid value."""
    found: dict[str, float] = {}
    for (other, _), block in blocks.items():
        if other != name:
            share = 1.0 - float(np.sum(_projector(block)(left) ** 2)) / float(left @ left)
            if share >= MIMICS:
                found[other] = max(found.get(other, 0.0), share)
    return dict(sorted(found.items(), key=lambda item: (-round(item[1], 3), item[0])))


def _projector(columns: Array) -> Any:
    """What is left of vectors outside the span of columns."""
    size = np.linalg.norm(columns, axis=0)
    U, s, _ = np.linalg.svd(columns[:, size > 0] / size[size > 0], full_matrices=False)
    Q = U[:, s > RANK_TOLERANCE * s.max(initial=0.0)]
    return lambda x: x - Q @ (Q.T @ x)


def _sizes(views: Sequence[View], base: CaptiveBase) -> dict[tuple[float, str], float]:
    """Root mean square of the base's force, by speed and channel [N, N m]."""
    found: dict[tuple[float, str], list[float]] = {}
    for view in views:
        for channel, force in base.forces(view.motion, view.speed).items():
            found.setdefault((view.speed, channel), []).append(float(np.mean(force**2)))
    return {key: math.sqrt(float(np.mean(values))) for key, values in found.items()}
