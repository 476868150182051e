"""Actions: what pmmkit is asked to do, a dataclass of settings and a function each."""

from typing import TYPE_CHECKING

from pmmkit.base import lazy

if TYPE_CHECKING:
    from pmmkit.actions.catalogue import Action, about, action, by_stage, names
    from pmmkit.actions.outcome import DONE, WRONG, Outcome, say, words_of
    from pmmkit.actions.setting import JobSetting, SettingError
    from pmmkit.actions.story import first_steps

__all__ = [
    "DONE",
    "WRONG",
    "Action",
    "JobSetting",
    "Outcome",
    "SettingError",
    "about",
    "action",
    "by_stage",
    "first_steps",
    "names",
    "say",
    "words_of",
]

lazy(__name__)
