"""A programme for a mechanism of two struts: how each of them is set in the runs of one."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace
from typing import Any

from pmmkit.campaigns import TEST_KINDS, Campaign
from pmmkit.diagnosis import Programme


def strut_settings(programme: Programme, campaign: Campaign) -> dict[str, dict[str, float]]:
    """By run, amplitude and lead of the struts as a campaign file states them.

    Empty where the tests that are made already were not swung by two struts. In pure yaw the point
    midway goes where the hull points, so that its way is ψ0 U/ω; on struts that path is a sine and
    the heading is its slope (docs/conventions.md, two struts).
    """
    known = next((x.settings for x in campaign.runs if x.settings.strut_spacing is not None), None)
    if known is None:
        return {}
    found = {}
    for run in programme.runs:
        kind, settings = TEST_KINDS[run.option.test], run.settings
        if not (kind.sways or kind.yaws):
            continue
        way = settings.amplitude
        if not kind.sways and settings.omega:
            way = math.tan(settings.yaw_amplitude or 0.0) * settings.speed / settings.omega
        swung = replace(
            settings,
            amplitude=way,
            strut_spacing=known.strut_spacing,
            strut_centre=known.strut_centre,
        )
        amplitude, lead = replace(run.option, settings=swung).run().strut_swing
        found[run.id] = {
            "strut_amplitude_m": round(amplitude, 4),
            "strut_phase_deg": round(math.degrees(lead), 4),
        }
    return found


def with_struts(entry: Mapping[str, Any], own: Mapping[str, float] | None) -> dict[str, Any]:
    """An entry that states the struts in place of the motion that they make."""
    if own is None:
        return dict(entry)
    made = ("amplitude_m", "yaw_amplitude_deg")
    return {name: x for name, x in entry.items() if name not in made} | dict(own)
