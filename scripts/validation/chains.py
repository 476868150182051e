"""The list: every published figure, by chain."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Final

from scripts.validation import (
    abkowitz,
    derivatives,
    empirical,
    filters,
    four_degrees,
    harmonics,
    imo,
    mmg,
    trials,
    waves,
)
from scripts.validation.published import Published

CHAINS: Final[Mapping[str, tuple[Published, ...]]] = {
    "Motions and harmonics": harmonics.FIGURES,
    "Derivatives from captive tests": derivatives.FIGURES,
    "Filters and sparse regression": filters.FIGURES,
    "MMG model": mmg.FIGURES,
    "Abkowitz's polynomial": abkowitz.FIGURES,
    "Four degrees of freedom": four_degrees.FIGURES,
    "Sea trials": trials.FIGURES,
    "IMO criteria": imo.FIGURES,
    "Formulas from particulars": empirical.FIGURES,
    "Waves": waves.FIGURES,
}
"""Figures by what they are about."""
