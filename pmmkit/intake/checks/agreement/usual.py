"""What derivatives hulls usually have, and how widely they spread: the prior of the checks."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np

from pmmkit.intake.checks.expected import expected
from pmmkit.numerics import Array

if TYPE_CHECKING:
    from pmmkit.campaigns import Campaign

SPREAD: Final = {
    "Yv": (-0.92, 0.25),
    "Yr": (0.20, 0.15),
    "Yvvv": (-5.0, 5.0),
    "Yrrr": (0.0, 0.3),
    "Yv|v|": (0.0, 1.5),
    "Yr|r|": (0.0, 0.2),
    "Yvvr": (1.5, 6.0),
    "Yvrr": (-2.0, 3.0),
    "Yvdot": (-0.62, 0.11),
    "Yrdot": (0.0, 0.04),
    "Yd": (-0.25, 0.25),
    "Yddd": (0.0, 0.5),
    "Yvvd": (0.0, 5.0),
    "Yvdd": (0.0, 2.0),
    "Nv": (-0.34, 0.12),
    "Nr": (-0.155, 0.05),
    "Nvvv": (0.0, 1.5),
    "Nrrr": (-0.1, 0.2),
    "Nv|v|": (0.0, 0.4),
    "Nr|r|": (0.0, 0.15),
    "Nvvr": (-2.5, 3.0),
    "Nvrr": (0.0, 0.5),
    "Nvdot": (0.0, 0.04),
    "Nrdot": (-0.034, 0.009),
    "Nd": (0.12, 0.12),
    "Nddd": (0.0, 0.25),
    "Nvvd": (0.0, 2.5),
    "Nvdd": (0.0, 1.0),
    "Xuu": (-0.06, 0.04),
    "Xvv": (-0.25, 0.35),
    "Xvvvv": (0.0, 4.0),
    "Xrr": (0.02, 0.06),
    "Xvr": (0.45, 0.30),
    "Xudot": (-0.04, 0.025),
    "Xdd": (-0.12, 0.12),
    "X0": (0.0, 1.0),
    "Y0": (0.0, 0.03),
    "N0": (0.0, 0.015),
}
"""Mean and standard deviation over -Yv of Clarke, Gedling and Hine (1983), prime system, total
coefficients: means of the hulls of the library, and about one and a half times their scatter."""
SAME: Final = 0.02
"""By how much Yrdot and Nvdot, equal in a mass matrix, may differ with way on, over the same."""
MAIN: Final = ("Xuu", "Xudot", "Xvr", "Yv", "Yr", "Yvdot", "Nv", "Nr", "Nrdot")
"""Derivatives whose size physics tells well enough to doubt data that show another."""


@dataclass(frozen=True, kw_only=True, eq=False)
class UsualDerivatives:
    """Prior of derivatives, prime system, instantaneous speed.

    mean (p,); covariance (p, p).
    """

    names: tuple[str, ...]
    mean: Array
    covariance: Array


def usual_derivatives(
    campaign: Campaign, names: tuple[str, ...], *, propelled: bool = False
) -> UsualDerivatives:
    """What a hull of these particulars usually has.

    Examples
    --------
    >>> from pmmkit.campaigns import Campaign
    >>> from pmmkit.conventions import Ship, Water
    >>> s175 = Ship(name="S175", L=175., B=25.4, d=8.5, volume=21222., mass=2.1752e7, Izz=3.84e10)
    >>> known = usual_derivatives(
    ...     Campaign(title="", ship=s175, water=Water(rho=1025.), runs=()), ("Yv", "Nv"))
    >>> known.mean.round(4), np.sqrt(np.diagonal(known.covariance)).round(4)
    (array([-0.0114, -0.0042]), array([0.0031, 0.0015]))
    """
    size = -expected(campaign).Yv
    spread = dict(SPREAD)
    if propelled:
        spread["Xuu"] = (0.0, 0.3)
    mean, std = (size * np.array([spread[name][k] for name in names]) for k in (0, 1))
    covariance = np.diag(std**2)
    if {"Yrdot", "Nvdot"} <= set(names):
        i, j = names.index("Yrdot"), names.index("Nvdot")
        covariance[i, j] = covariance[j, i] = std[i] * std[j] - 0.5 * (SAME * size) ** 2
    return UsualDerivatives(names=names, mean=mean, covariance=covariance)
