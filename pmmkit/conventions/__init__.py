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
    from pmmkit.conventions.metrics import (
        HARD_OVER,
        IN_LENGTHS,
        METRICS,
        Criterion,
        Metric,
        criteria,
        in_lengths,
        in_words,
        main_of,
        metric_of,
        metrics_named,
        told,
    )
    from pmmkit.conventions.named_structures import STRUCTURES, Structure, structure_of
    from pmmkit.conventions.ship import Ship, Water
    from pmmkit.conventions.sources import bibliography, bibtex, cite

__all__ = [
    "CHANNELS",
    "CHANNEL_UNITS",
    "DEGREE_CHANNELS",
    "FORCE_CHANNELS",
    "HARD_OVER",
    "IN_LENGTHS",
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
    "criteria",
    "factor_to",
    "harmonic_part",
    "in_lengths",
    "in_words",
    "is_unit",
    "main_of",
    "metric_of",
    "metrics_named",
    "parse_derivative",
    "split_unit",
    "structure_of",
    "told",
    "unit_factor",
    "unit_in_name",
]

lazy(__name__)
