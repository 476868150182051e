"""Criteria of IMO resolution MSC.137(76): what each asks, whether a ship meets it, and where."""

from pmmkit.simulation.imo.judged import LARGE, imo_turning, imo_verdicts
from pmmkit.simulation.imo.verdict import (
    SOURCE,
    Verdict,
    judge,
    turning_conditions,
    verdict_sections,
    zigzag_limits,
)

__all__ = [
    "LARGE",
    "SOURCE",
    "Verdict",
    "imo_turning",
    "imo_verdicts",
    "judge",
    "turning_conditions",
    "verdict_sections",
    "zigzag_limits",
]
