"""Where a model fails, and which effect or fault is missing."""

from pmmkit.diagnosis.candidate import Candidate, polynomial
from pmmkit.diagnosis.coverage import Visible
from pmmkit.diagnosis.diagnose import diagnose, diagnose_captive
from pmmkit.diagnosis.findings import Diagnosis, Finding

__all__ = [
    "Candidate",
    "Diagnosis",
    "Finding",
    "Visible",
    "diagnose",
    "diagnose_captive",
    "polynomial",
]
