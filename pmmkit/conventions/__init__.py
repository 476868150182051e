"""Axes, units and names: derivatives, channels, metrics, ship and water, structures, sources."""

from typing import TYPE_CHECKING

from pmmkit.base import lazy

if TYPE_CHECKING:
    from pmmkit.conventions.channels import (
        CHANNEL_UNITS,
        DEGREE_CHANNELS,
        FORCE_CHANNELS,
        channel_of,
        factor_to,
        harmonic_part,
        split_unit,
        unit_in_name,
    )
    from pmmkit.conventions.derivatives import (
        CHANNELS,
        Convention,
        Derivative,
        System,
        is_unit,
        parse_derivative,
        unit_factor,
    )
    from pmmkit.conventions.metrics import METRICS, Criterion, Metric
    from pmmkit.conventions.named_structures import STRUCTURES, Structure
    from pmmkit.conventions.ship import Ship, Water
    from pmmkit.conventions.sources import bibliography, bibtex, cite

__all__ = [
    "CHANNELS",
    "CHANNEL_UNITS",
    "DEGREE_CHANNELS",
    "FORCE_CHANNELS",
    "METRICS",
    "STRUCTURES",
    "Convention",
    "Criterion",
    "Derivative",
    "Metric",
    "Ship",
    "Structure",
    "System",
    "Water",
    "bibliography",
    "bibtex",
    "channel_of",
    "cite",
    "factor_to",
    "harmonic_part",
    "is_unit",
    "parse_derivative",
    "split_unit",
    "unit_factor",
    "unit_in_name",
]

lazy(__name__)
