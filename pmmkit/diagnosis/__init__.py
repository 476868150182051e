"""Where a model fails, and which effect or fault is missing."""

from pmmkit.diagnosis.candidate import Candidate, polynomial
from pmmkit.diagnosis.coverage import Visible
from pmmkit.diagnosis.diagnose import Diagnosis, Finding, diagnose, diagnose_captive

__all__ = [
    "Candidate",
    "Diagnosis",
    "Finding",
    "Visible",
    "diagnose",
    "diagnose_captive",
    "polynomial",
]
