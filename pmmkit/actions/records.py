"""What commands ask of free-running records and of sound campaigns, and sessions about them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from pmmkit.actions.outcome import say
from pmmkit.actions.setting import (
    SettingError,
    numbers,
    patterns,
    present,
    sensors_of,
    setting,
    settings,
    stated,
    words,
)
from pmmkit.presentation import aligned

if TYPE_CHECKING:
    from pmmkit.base import Workers
    from pmmkit.campaigns import Campaign
    from pmmkit.diagnosis import Session
    from pmmkit.effects import Effect
    from pmmkit.identification import Chosen
    from pmmkit.intake import CheckFinding
    from pmmkit.models import Model


@settings
class RecordSettings:
    """Free-running records."""

    runs: tuple[str, ...] = setting(
        "Free-running runs to diagnose, such as 'turn_*'; may be repeated.", default=()
    )
    test_runs: tuple[str, ...] = setting(
        "Free-running runs held out, to be predicted; of several campaigns captive ones too.",
        default=(),
    )
    channels: str | None = setting(
        "Channels of free-running records to use, such as x,y,psi,r where the checks find "
        "fault with the velocities; all if absent.",
        default=None,
    )
    spread: float | None = setting(
        "Largest share of their usual sizes by which the model's values may be off before "
        "free-running records are looked at; how far they move is found; 0.15 if absent.",
        default=None,
        least=0.0,
    )
    shortest: float | None = setting(
        "Leave out free-running segments shorter than this, in s; ten ship lengths if absent.",
        default=None,
        least=0.1,
    )
    sensors: str | None = setting(
        "Standard deviations of channels of free-running records, such as "
        "x=0.03,y=0.03,psi_deg=0.1; told from their noise if absent.",
        default=None,
    )
    windage: str | None = setting(
        "Frontal and lateral area above water in m2, such as 0.135,0.52.", default=None
    )
    judged: float | None = setting(
        "Length in s of the windows by which effects are judged; five ship lengths if absent.",
        default=None,
        least=0.1,
    )
    window: float = setting("Length in s of the windows of runs held out.", default=60.0, least=0.1)

    def chosen(self, campaign: Campaign, model: Model) -> tuple[Chosen, Chosen | None]:
        """The records that are used, and those held out."""
        from pmmkit.identification import Chosen

        return Chosen.of(
            campaign,
            model,
            runs=patterns(self.runs),
            test_runs=patterns(self.test_runs),
            channels=None if self.channels is None else words(self.channels),
            shortest=self.shortest,
            rudder="auto",
            wind=True,
        )

    def system(self) -> dict[str, Any]:
        """Settings of the question that the records are asked."""
        return {
            **present(spread=self.spread),
            "windage": self.areas,
            "sensors": sensors_of(self.sensors),
            "window": self.judged,
        }

    def settings(self, kept: Chosen | None) -> dict[str, Any]:
        """Settings of a session about the records, with those held out."""
        return {
            **self.system(),
            "held_out": kept.records if kept else (),
            "held_out_window": self.window if kept else None,
        }

    def several(self) -> dict[str, Any]:
        """Settings of a session about several campaigns."""
        return {
            **self.system(),
            **self.held_out(),
            **present(
                runs=patterns(self.runs),
                channels=None if self.channels is None else words(self.channels),
                shortest=self.shortest,
                held_out_window=self.window if self.test_runs else None,
            ),
        }

    def held_out(self) -> dict[str, Any]:
        """Settings of a session about several campaigns of captive tests."""
        return present(test_runs=patterns(self.test_runs))

    @property
    def areas(self) -> tuple[float, float] | None:
        """Frontal and lateral area above water [m²]."""
        found = numbers(self.windage)
        if found is None:
            return None
        if len(found) != 2 or min(found) <= 0.0:
            raise SettingError(f"{self.windage!r}: write two areas such as 0.135,0.52.")
        return found[0], found[1]


def errors_table(errors: Mapping[str, Mapping[str, float]]) -> str:
    """Errors of windows, a line for each model."""
    from pmmkit.conventions import CHANNEL_UNITS
    from pmmkit.identification import MethodComparison

    units = {"force": "%", **CHANNEL_UNITS, **MethodComparison.UNITS}
    names = [name for name in units if any(name in row for row in errors.values())]
    head = [f"{name.replace('_', ' ')} [{units[name]}]" for name in names]
    rows = [
        [what, *(f"{row[name]:.3g}" if name in row else "-" for name in names)]
        for what, row in errors.items()
    ]
    return aligned(["", *head], rows)


# Sessions of jobs: a model and the campaigns that were named.


# Campaigns that do not contradict themselves.


def sound_campaign(
    path: Path, data: Path | None, executor: Workers = None, *, model: Model | None = None
) -> tuple[Campaign, tuple[CheckFinding, ...]]:
    """A campaign that does not contradict itself, and what the checks say of it.

    Of tests at several depths those in water as deep as the model's.
    """
    from pmmkit.campaigns import open_campaign
    from pmmkit.intake import examine, refuse

    campaign = open_campaign(path, data=data)
    if model is not None and len(campaign.depths) > 1:
        part = campaign.as_deep_as(model.water.depth, model.ship.d)
        if part is not campaign:
            say(
                f"In water of {part.depth_in_words}, as the model: {len(part.runs)} of "
                f"{len(campaign.runs)} runs."
            )
        campaign = part
    findings = examine(campaign, executor=executor)
    refuse(findings)
    return campaign, findings


def sound_campaigns(
    paths: Sequence[Path], data: Path | None, model: Model | None = None
) -> dict[str, tuple[Campaign, tuple[CheckFinding, ...]]]:
    """The same of several campaigns, by their titles as a session knows them."""
    from pmmkit.campaigns import Campaign

    sound = [sound_campaign(path, data, model=model) for path in paths]
    return dict(zip(Campaign.by_title([campaign for campaign, _ in sound]), sound, strict=True))


def middle_speed(campaign: Campaign, model: Model) -> float:
    """The middle speed of the tests, at the length of a model [m/s]."""
    speeds = sorted({run.settings.speed for run in campaign.runs})
    Fn = campaign.ship.froude(speeds[len(speeds) // 2], campaign.water.g)
    return model.ship.speed(Fn, model.water.g)


def session_of_several(
    model: Model,
    campaigns: Mapping[str, Campaign],
    candidates: Sequence[str] | None,
    asked: RecordSettings,
    **settings: Any,
) -> Session[Any]:
    """A session about several campaigns; settings as for `begin`."""
    from pmmkit.base import DataError
    from pmmkit.diagnosis import begin

    if any(item.kind == "free-running" for item in campaigns.values()):
        more = {**asked.several(), "candidates": candidates, "progress": say}
        return begin(model, campaigns, **settings, **more)
    if {"test_runs"}.issuperset(stated(asked)):
        return begin(model, campaigns, **settings, **asked.held_out())
    raise DataError("Options of free-running records are of no use for captive tests.")


def session_about(
    model: Model,
    campaigns: Mapping[str, Campaign],
    effects: Sequence[str],
    asked: RecordSettings,
    floor: float | None,
    noise: float | None,
    own: Sequence[Effect],
) -> Session[Any]:
    """A session in which free-running records are asked for nothing but the effects."""
    from pmmkit.base import DataError
    from pmmkit.diagnosis import begin

    names = [name.partition("@")[0] for name in effects]
    if len(campaigns) > 1:
        return session_of_several(model, campaigns, names, asked, floor=floor, noise=noise, own=own)
    (one,) = campaigns.values()
    if one.kind != "free-running":
        if stated(asked):
            raise DataError("Options of free-running records are of no use for captive tests.")
        return begin(model, one, floor=floor, noise=noise, own=own)
    used, kept = asked.chosen(one, model)
    return begin(
        model,
        used.records,
        floor=floor,
        noise=noise,
        own=own,
        candidates=names,
        progress=say,
        **asked.settings(kept),
    )
