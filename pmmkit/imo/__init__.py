"""Criteria of IMO resolution MSC.137(76): what each asks, whether a ship meets it, and where."""

from typing import TYPE_CHECKING

from pmmkit.base import lazy

if TYPE_CHECKING:
    from pmmkit.imo.conditions import LOADED, Condition, simulated_conditions
    from pmmkit.imo.judged import imo_turning, imo_verdicts, metrics_of, sided_tests
    from pmmkit.imo.verdict import FullAstern, Verdict, judge, manoeuvre_words, verdict_sections

__all__ = [
    "LOADED",
    "Condition",
    "FullAstern",
    "Verdict",
    "imo_turning",
    "imo_verdicts",
    "judge",
    "manoeuvre_words",
    "metrics_of",
    "sided_tests",
    "simulated_conditions",
    "verdict_sections",
]

lazy(__name__)
