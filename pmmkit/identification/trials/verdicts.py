"""Criteria of IMO MSC.137(76) beside the measures of a trial."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace

from pmmkit.campaigns import TEST_KINDS
from pmmkit.conventions import METRICS, Criterion
from pmmkit.imo import FullAstern, Verdict, judge


def verdicts_of(
    test: str,
    metrics: Mapping[str, float],
    std: Mapping[str, float],
    *,
    L: float,
    speed: float,
    rudder_deg: float,
    switch_deg: float = math.nan,
    conditions: tuple[str, ...] = (),
    full_astern: FullAstern | None = None,
) -> tuple[Verdict, ...]:
    """Every criterion that a run of that kind is judged by.

    L, speed [m].

    Examples
    --------
    >>> found = verdicts_of("stopping", {"track_reach_L": 14.2}, {"track_reach_L": 0.1}, L=170.0,
    ...                     speed=7.25, rudder_deg=0.0)
    >>> [(item.criterion, item.limit, item.passed, round(item.probability, 6)) for item in found]
    [('track_reach', 15.0, True, 1.0)]
    """
    size = abs(rudder_deg)
    asked = [pair for pair in METRICS.criteria if _applies(pair[1], test, size, switch_deg)]
    own_first = sorted(asked, key=lambda pair: pair[1].manoeuvre != test)
    kind = TEST_KINDS[test]
    found = [
        judge(
            metric,
            criterion,
            metrics,
            std=std,
            L=L,
            speed=speed,
            scale=f"as measured, L = {L:.4g} m",
            manoeuvre=test,
            rudder_deg=rudder_deg if kind.turns_rudder else 0.0,
            switch_deg=switch_deg if kind.switches else None,
            conditions=(*conditions, *([Verdict.LARGE] if kind is TEST_KINDS["stopping"] else [])),
            alone=kind is TEST_KINDS["turning"],
            measured=True,
        )
        for metric, criterion in own_first
    ]
    return tuple(replace(verdict, full_astern=full_astern) for verdict in found)


def _applies(criterion: Criterion, test: str, rudder: float, switch: float) -> bool:
    """Whether a run is the test of a criterion: the manoeuvre, and its angles within reach."""
    if test not in (criterion.manoeuvre, *criterion.shown_by):
        return False
    if not TEST_KINDS[test].switches:
        return True
    settings = criterion.settings
    heading = settings.get("switch_deg", settings.get("heading_deg", math.nan))
    return abs(rudder - settings["rudder_deg"]) < 1.0 and abs(switch - heading) < 0.5
