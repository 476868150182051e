"""Sessions of jobs: a model and the campaigns that were named."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

from pmmkit.actions.outcome import say
from pmmkit.actions.setting import stated

if TYPE_CHECKING:
    from pmmkit.actions.records import RecordSettings
    from pmmkit.campaigns import Campaign
    from pmmkit.diagnosis import Session
    from pmmkit.effects import Effect
    from pmmkit.models import Model


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

    one = max(campaigns.values(), key=lambda item: item.kind == "free-running")
    names = [name.partition("@")[0] for name in effects]
    if one.kind != "free-running":
        if stated(asked):
            raise DataError("Options of free-running records are of no use for captive tests.")
        tests = campaigns if len(campaigns) > 1 else one
        return begin(model, tests, floor=floor, noise=noise, own=own)
    if len(campaigns) > 1:
        return begin(
            model,
            campaigns,
            floor=floor,
            noise=noise,
            own=own,
            candidates=names,
            progress=say,
            **asked.several(),
        )
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
