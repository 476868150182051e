"""Where a model fails, and which effect or fault is missing."""

from pmmkit.diagnosis.captive.asked import captive_candidates
from pmmkit.diagnosis.captive.candidate import Candidate, polynomial
from pmmkit.diagnosis.captive.diagnose import diagnose_captive
from pmmkit.diagnosis.diagnose import diagnose
from pmmkit.diagnosis.evidence import Visible
from pmmkit.diagnosis.findings import Diagnosis, Finding
from pmmkit.diagnosis.free_running.diagnose import diagnose_free
from pmmkit.diagnosis.together.result import Together
from pmmkit.diagnosis.together.together import together

__all__ = [
    "Candidate",
    "Diagnosis",
    "Finding",
    "Together",
    "Visible",
    "captive_candidates",
    "diagnose",
    "diagnose_captive",
    "diagnose_free",
    "polynomial",
    "together",
]
