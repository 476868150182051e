"""Reduce the synthetic S175 programme, compare it with Son and Nomoto, turn the ship."""

from __future__ import annotations

from pathlib import Path
from typing import Final

from pmmkit.actions.jobs.reduce import ReduceSettings, reduced
from pmmkit.actions.jobs.trial import TrialSettings, trial
from pmmkit.actions.outcome import Outcome
from pmmkit.actions.places import results_folder
from pmmkit.actions.setting import SettingError, setting, settings
from pmmkit.actions.shared import Out

EXAMPLE: Final = "pmmkit demo --out my-demo"


@settings
class DemoSettings:
    """What is asked."""

    my_data: Path | None = setting(
        "Your own folder or file instead: as far as it goes towards a turn, and what is "
        "missing. Nothing is written there.",
        default=None,
    )
    ship: str | None = setting(
        "Ship of the library (pmmkit ships) that was tested, with --my-data.", default=None
    )
    out: Out = None


def demo(job: DemoSettings) -> Outcome:
    """Do what is asked."""
    from pmmkit.actions.my_data import as_far_as_it_goes
    from pmmkit.files import datasets_folder

    if job.my_data is not None:
        return as_far_as_it_goes(
            job.my_data, reduce=_reduced, measure=_measured, ship=job.ship, out=job.out
        )
    if job.ship is not None:
        raise SettingError("--ship goes with --my-data FOLDER.")
    ship = "s175-3dof"
    return reduced(
        ReduceSettings(campaign=datasets_folder() / "s175", parts=ship, reference=ship),
        results_folder(job.out, "pmmkit-demo"),
        reference_name="Son and Nomoto 1981",
        lacking="cubic",
    )


def _reduced(campaign: Path, out: Path, title: str) -> Outcome:
    """Captive tests by the largest structure that they determine."""
    return reduced(ReduceSettings(campaign=campaign, structure="auto"), out, title=title)


def _measured(campaign: Path, out: Path) -> Outcome:
    """The manoeuvres of free-running records."""
    return trial(TrialSettings(campaign=campaign, out=out))
