"""A zero of the surge gauge: what runs at several speeds say of it."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Final

import numpy as np

from pmmkit.inference import LeastSquares
from pmmkit.intake import CheckFinding
from pmmkit.numerics import Array
from pmmkit.presentation import WIDE, plus_minus
from pmmkit.reduction.estimate import ChannelFit
from pmmkit.reduction.observations.noise import whiteners
from pmmkit.reduction.solve import Solution

APART: Final = 1e-3
"""Least part of a constant force that the other terms leave, so that it can be told from them."""
SIGMAS: Final = 4.0
"""Standard uncertainties by which a zero must differ from none."""
LEAST: Final = 3
"""Speeds with a resistance of their own from which a common zero can be told."""
EXPLAINS: Final = 0.5
"""Least part of the misfit that a zero must explain: speed changes a hull in other ways too."""
FITS: Final = 3.0
"""Mean square misfit up to which a zero explains all that differs between speeds."""


@dataclass(frozen=True)
class _Zero:
    """A zero [N] with its standard uncertainty, Xuu without and with it, and what is then left.

    The misfit that is left is a mean square in units of the noise.
    """

    value: float
    std: float
    before: float
    after: float
    left: float


def surge_zero(solution: Solution) -> tuple[CheckFinding, ...]:
    """A constant force in X, common to all runs, that would fit better.

    It is asked beside the fit and never taken into it: a resistance that does not grow as u² looks
    the same. A warning where nothing but noise is left then, else a remark.
    """
    fits = [item for _, item in solution.fits if item.channel == "X" and "Xuu" in item.fit.names]
    if not fits:
        return ()
    pooled = len(solution.groups) == 1
    found = _of_rows(fits[0]) if pooled else _of_speeds(fits, solution)
    if found is None or abs(found.value) < SIGMAS * found.std:
        return ()
    return (
        CheckFinding(
            check="surge zero",
            severity="warning" if found.left <= FITS else "info",
            message=f"A zero of the surge gauge of {plus_minus(found.value, WIDE * found.std)} N, "
            f"common to all runs, would fit better: Xuu would be {found.after:.4g} in place of "
            f"{found.before:.4g}{'' if pooled else ' (mean over the speeds)'}. A resistance that "
            "does not grow as u² looks the same.",
            remedy="A rest at the head of the records (tare = true under [defaults]) or a zero "
            "record tells, and a slow run.",
            numbers={"zero": found.value, "std": found.std, "Xuu": found.after},
        ),
    )


def _of_rows(item: ChannelFit) -> _Zero | None:
    """By the rows of runs at several speeds, which share their derivatives."""
    if item.freedom < 2:
        return None
    rows, design, zero = _white(item)
    solved = LeastSquares.of(item.fit.names, design, rows).gain @ np.stack([rows, zero], axis=1)
    misfit, own = rows - design @ solved[:, 0], zero - design @ solved[:, 1]
    power = float(own @ own)
    if power <= APART * float(zero @ zero):
        return None
    value = float(own @ misfit) / power
    before = float(misfit @ misfit)
    left = before - value**2 * power
    if left > (1.0 - EXPLAINS) * before:
        return None
    place = item.fit.names.index("Xuu")
    Xuu = float(item.fit.value[place])
    return _Zero(
        value,
        math.sqrt(max(left / (item.freedom - 1), 1.0) / power),
        Xuu,
        Xuu - value * float(solved[place, 1]),
        left / (item.freedom - 1),
    )


def _of_speeds(fits: list[ChannelFit], solution: Solution) -> _Zero | None:
    """By Xuu of each speed: one resistance and one zero against one resistance."""
    at = {label: place for place, label in enumerate(solution.joint.labels)}
    places = [at[group, "Xuu"] for group, item in solution.fits if item in fits]
    x = solution.joint.value[places]
    std = np.sqrt(np.diagonal(solution.joint.type_a)[places])
    if len(places) < LEAST or not np.all(np.isfinite(x)) or not np.all(std > 0):
        return None
    shift = np.array([_shift(item) for item in fits])
    design = np.stack([np.ones(len(x)), shift], axis=1) / std[:, None]
    found, *_ = np.linalg.lstsq(design, x / std, rcond=None)
    left = x / std - design @ found
    freedom = len(x) - 2
    scale = float(left @ left) / freedom
    covariance = np.linalg.inv(design.T @ design) * max(scale, 1.0)
    return _Zero(
        float(found[1]), math.sqrt(covariance[1, 1]), float(np.mean(x)), float(found[0]), scale
    )


def _shift(item: ChannelFit) -> float:
    """Change of Xuu with a constant force of 1 N."""
    rows, design, zero = _white(item)
    gain = LeastSquares.of(item.fit.names, design, rows).gain
    return float(gain[item.fit.names.index("Xuu")] @ zero)


def _white(item: ChannelFit) -> tuple[Array, Array, Array]:
    """Rows, design and a constant force of 1 N, in units of the noise that the records state.

    Scatter between runs stays out: it takes a zero of all runs for an offset of each.
    """
    white = whiteners(item.noise.covariances)
    pairs = list(zip(white, item.blocks, strict=True))
    columns = list(item.chosen)
    return (
        np.concatenate([white @ block.rows for white, block in pairs]),
        np.concatenate([white @ block.design[:, columns] for white, block in pairs]),
        np.concatenate([white[:, 0] * float(block.keep[0]) for white, block in pairs]),
    )
