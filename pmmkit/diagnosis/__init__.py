"""Where a model fails, and which effect or fault is missing."""

from pmmkit.diagnosis.candidate import Candidate, polynomial
from pmmkit.diagnosis.coverage import Visible
from pmmkit.diagnosis.diagnose import diagnose, diagnose_captive
from pmmkit.diagnosis.findings import Diagnosis, Finding
from pmmkit.diagnosis.session import ErrorFall, Session, begin, fit, replay

__all__ = [
    "Candidate",
    "Diagnosis",
    "ErrorFall",
    "Finding",
    "Session",
    "Visible",
    "begin",
    "diagnose",
    "diagnose_captive",
    "fit",
    "polynomial",
    "replay",
]
