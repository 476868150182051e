"""Where a model fails, and which effect or fault is missing."""

from typing import TYPE_CHECKING

from pmmkit.base import lazy

if TYPE_CHECKING:
    from pmmkit.diagnosis.any_campaign import complete_model, diagnose
    from pmmkit.diagnosis.captive.candidate import candidate_of
    from pmmkit.diagnosis.captive.standard import standard_tests
    from pmmkit.diagnosis.evidence import REMOVES
    from pmmkit.diagnosis.findings import Diagnosis
    from pmmkit.diagnosis.free_running.hypotheses import free_candidate_of
    from pmmkit.diagnosis.joint.result import Together
    from pmmkit.diagnosis.joint.together import carried
    from pmmkit.diagnosis.loop.fall import Fall
    from pmmkit.diagnosis.loop.session import Session, begin, fit, read_session, replay, undone
    from pmmkit.diagnosis.loop.several import SeveralCampaigns
    from pmmkit.diagnosis.planning.next_run import next_runs
    from pmmkit.diagnosis.planning.options import Limits, Option
    from pmmkit.diagnosis.planning.order import Programme
    from pmmkit.diagnosis.planning.plan_file import read_plan_file
    from pmmkit.diagnosis.planning.programme import TestPlan, plan
    from pmmkit.diagnosis.planning.ranking import Advice

__all__ = [
    "REMOVES",
    "Advice",
    "Diagnosis",
    "Fall",
    "Limits",
    "Option",
    "Programme",
    "Session",
    "SeveralCampaigns",
    "TestPlan",
    "Together",
    "begin",
    "candidate_of",
    "carried",
    "complete_model",
    "diagnose",
    "fit",
    "free_candidate_of",
    "next_runs",
    "plan",
    "read_plan_file",
    "read_session",
    "replay",
    "standard_tests",
    "undone",
]

lazy(__name__)
