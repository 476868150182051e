"""What measured files hold: looks, drafts of a campaign file, and checks of what was read."""

from typing import TYPE_CHECKING

from pmmkit.base import lazy

if TYPE_CHECKING:
    from pmmkit.intake.checks import examine
    from pmmkit.intake.checks.disagreement import Disagreement
    from pmmkit.intake.checks.finding import CheckFinding, Summary, name_runs, refuse
    from pmmkit.intake.checks.positions import digits, position_jumps
    from pmmkit.intake.checks.reading import KnownHistory, summarise
    from pmmkit.intake.checks.untold import Untold
    from pmmkit.intake.drafting import DraftAnswers, Drafted
    from pmmkit.intake.drafts.columns import ColumnChoice
    from pmmkit.intake.drafts.propose import campaign_draft
    from pmmkit.intake.drafts.questions import Question, questions_of
    from pmmkit.intake.drafts.write import written
    from pmmkit.intake.file import LARGE, seen_values
    from pmmkit.intake.folder import FileGroup, Look, look
    from pmmkit.intake.seen import ColumnLook, FileLook

__all__ = [
    "LARGE",
    "CheckFinding",
    "ColumnChoice",
    "ColumnLook",
    "Disagreement",
    "DraftAnswers",
    "Drafted",
    "FileGroup",
    "FileLook",
    "KnownHistory",
    "Look",
    "Question",
    "Summary",
    "Untold",
    "campaign_draft",
    "digits",
    "examine",
    "look",
    "name_runs",
    "position_jumps",
    "questions_of",
    "refuse",
    "seen_values",
    "summarise",
    "written",
]

lazy(__name__)
