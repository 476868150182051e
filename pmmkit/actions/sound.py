"""Campaigns that do not contradict themselves."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from pmmkit.base import Workers
    from pmmkit.campaigns import Campaign
    from pmmkit.intake import CheckFinding


def sound_campaign(
    path: Path, data: Path | None, executor: Workers = None
) -> tuple[Campaign, tuple[CheckFinding, ...]]:
    """A campaign that does not contradict itself, and what the checks say of it."""
    from pmmkit.campaigns import open_campaign
    from pmmkit.intake import examine, refuse

    campaign = open_campaign(path, data=data)
    findings = examine(campaign, executor=executor)
    refuse(findings)
    return campaign, findings


def sound_campaigns(
    paths: Sequence[Path], data: Path | None
) -> dict[str, tuple[Campaign, tuple[CheckFinding, ...]]]:
    """The same of several campaigns, by their titles as a session knows them."""
    from pmmkit.campaigns import Campaign

    sound = [sound_campaign(path, data) for path in paths]
    return dict(zip(Campaign.by_title([campaign for campaign, _ in sound]), sound, strict=True))
