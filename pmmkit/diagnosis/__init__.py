"""Where a model fails, and which effect or fault is missing."""

from typing import TYPE_CHECKING

from pmmkit.base import lazy

if TYPE_CHECKING:
    from pmmkit.diagnosis.any_campaign import complete_model, diagnose
    from pmmkit.diagnosis.captive.adequacy import blocks_of
    from pmmkit.diagnosis.captive.candidate import candidate_of
    from pmmkit.diagnosis.captive.held_out import held_out
    from pmmkit.diagnosis.captive.least_squares import Stack, sizes_of, solved, stacked
    from pmmkit.diagnosis.captive.refit import asked_in_captive, excited
    from pmmkit.diagnosis.captive.signature import standard_tests
    from pmmkit.diagnosis.captive.system import CandidateColumns, System
    from pmmkit.diagnosis.captive.verdict import taken_as_given
    from pmmkit.diagnosis.evidence import RankedSet, Visible
    from pmmkit.diagnosis.findings import AS_LIKELY, UNITS, VERDICTS, Diagnosis, Finding
    from pmmkit.diagnosis.free_running.alone import MOTION, alone, errors_of, taken_away, whole_path
    from pmmkit.diagnosis.free_running.candidates import asked_in_free_running, free_candidate_of
    from pmmkit.diagnosis.free_running.contest import Contest
    from pmmkit.diagnosis.free_running.fits import SetFit
    from pmmkit.diagnosis.joint.captive_vote import of_ship
    from pmmkit.diagnosis.joint.result import JointEntry, Together
    from pmmkit.diagnosis.joint.together import carried, joint_diagnosis
    from pmmkit.diagnosis.loop.captive import CaptiveTests
    from pmmkit.diagnosis.loop.fall import Fall
    from pmmkit.diagnosis.loop.records import FreeRecords
    from pmmkit.diagnosis.loop.session import Session, begin, fit, read_session, replay, undone
    from pmmkit.diagnosis.loop.several import SeveralCampaigns
    from pmmkit.diagnosis.planning.advice import Advice
    from pmmkit.diagnosis.planning.manoeuvres import limits_of_records, next_manoeuvres
    from pmmkit.diagnosis.planning.next_run import next_runs
    from pmmkit.diagnosis.planning.options import Limits, Option, limits_of
    from pmmkit.diagnosis.planning.plan_file import entries_text, read_plan_file
    from pmmkit.diagnosis.planning.programme import TestPlan, plan
    from pmmkit.diagnosis.record_figures import before_and_after

__all__ = [
    "AS_LIKELY",
    "MOTION",
    "UNITS",
    "VERDICTS",
    "Advice",
    "CandidateColumns",
    "CaptiveTests",
    "Contest",
    "Diagnosis",
    "Fall",
    "Finding",
    "FreeRecords",
    "JointEntry",
    "Limits",
    "Option",
    "RankedSet",
    "Session",
    "SetFit",
    "SeveralCampaigns",
    "Stack",
    "System",
    "TestPlan",
    "Together",
    "Visible",
    "alone",
    "asked_in_captive",
    "asked_in_free_running",
    "before_and_after",
    "begin",
    "blocks_of",
    "candidate_of",
    "carried",
    "complete_model",
    "diagnose",
    "entries_text",
    "errors_of",
    "excited",
    "fit",
    "free_candidate_of",
    "held_out",
    "joint_diagnosis",
    "limits_of",
    "limits_of_records",
    "next_manoeuvres",
    "next_runs",
    "of_ship",
    "plan",
    "read_plan_file",
    "read_session",
    "replay",
    "sizes_of",
    "solved",
    "stacked",
    "standard_tests",
    "taken_as_given",
    "taken_away",
    "undone",
    "whole_path",
]

lazy(__name__)
