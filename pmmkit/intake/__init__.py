"""What measured files hold: looks, drafts of a campaign file, and checks of what was read."""

from typing import TYPE_CHECKING

from pmmkit.base import lazy

if TYPE_CHECKING:
    from pmmkit.intake.checks import examine
    from pmmkit.intake.checks.finding import CheckFinding, loudest_first, name_runs, refuse
    from pmmkit.intake.checks.positions import digits, position_jumps
    from pmmkit.intake.checks.reading import KnownHistory, summarise
    from pmmkit.intake.checks.record import FLAT_SAMPLES
    from pmmkit.intake.checks.summary import Summary
    from pmmkit.intake.checks.untold import untold
    from pmmkit.intake.checks.zeros import zero_channels, zeros_grid
    from pmmkit.intake.content import columns_csv, look_content
    from pmmkit.intake.drafting import DraftAnswers, Drafted, Field, basis_of, drafted, stamp_of
    from pmmkit.intake.drafts.choosing import ColumnChoice
    from pmmkit.intake.drafts.draft import Draft, draft_of
    from pmmkit.intake.drafts.propose import proposed
    from pmmkit.intake.drafts.questions import Question, questions_of
    from pmmkit.intake.drafts.write import written
    from pmmkit.intake.file import LARGE, sample_of
    from pmmkit.intake.folder import CampaignLook, FileGroup, Look, look
    from pmmkit.intake.seen import ColumnLook, FileLook
    from pmmkit.intake.values import values_of
    from pmmkit.intake.words import clock_words, file_words, look_lines

__all__ = [
    "FLAT_SAMPLES",
    "LARGE",
    "CampaignLook",
    "CheckFinding",
    "ColumnChoice",
    "ColumnLook",
    "Draft",
    "DraftAnswers",
    "Drafted",
    "Field",
    "FileGroup",
    "FileLook",
    "KnownHistory",
    "Look",
    "Question",
    "Summary",
    "basis_of",
    "clock_words",
    "columns_csv",
    "digits",
    "draft_of",
    "drafted",
    "examine",
    "file_words",
    "look",
    "look_content",
    "look_lines",
    "loudest_first",
    "name_runs",
    "position_jumps",
    "proposed",
    "questions_of",
    "refuse",
    "sample_of",
    "stamp_of",
    "summarise",
    "untold",
    "values_of",
    "written",
    "zero_channels",
    "zeros_grid",
]

lazy(__name__)
