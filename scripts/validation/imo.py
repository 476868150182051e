"""What the IMO asks for."""

from __future__ import annotations

from functools import cache

from pmmkit.conventions import METRICS
from pmmkit.identification.trials.evaluate import verdicts_of
from scripts.validation.published import Published, Values, table

RULES = {"sources": ("msc137",), "nature": "printed", "part": "program", "within": 1e-9}


@cache
def limits() -> Values:
    """Limits that do not depend on L/V."""
    return {
        item.name.replace("_", " "): item.limit
        for _, item in METRICS.criteria
        if not callable(item.limit)
    }


@cache
def zigzags() -> Values:
    """Limits of the 10/10 zigzag over L/V."""
    found = {}
    for time in (5.0, 20.0, 40.0):
        for _, item in METRICS.criteria:
            if item.name.endswith("overshoot_10_10"):
                word = item.name.partition("_")[0]
                limit = item.limit_for(200.0, 200.0 / time)
                found[f"{word} overshoot 10/10, L/V {time:g} s"] = limit
    return found


@cache
def of_trials() -> Values:
    """Limits in metres as the trial's tables print them."""
    metrics = {"advance_L": 3.0, "tactical_diameter_L": 3.0}
    found = {}
    for ship, L in (("bulk carrier", 170.0), ("patrol vessel", 44.0)):
        judged = verdicts_of("turning", metrics, {}, L=L, speed=7.7, rudder_deg=35.0)
        for name, verdict in zip(("advance", "tactical diameter"), judged, strict=True):
            found[f"{ship}, {name}"] = verdict.limit * L
    return found


FIGURES: tuple[Published, ...] = (
    *table(
        "Turning, initial turning, 20/20 zigzag and stopping",
        {
            "advance": 4.5, "tactical diameter": 5.0, "initial turning": 2.5,
            "first overshoot 20 20": 25.0, "track reach": 15.0,
        },
        limits,
        unit={
            "advance": "L", "tactical diameter": "L", "initial turning": "L",
            "first overshoot 20 20": "°", "track reach": "L",
        },
        place="paragraph 5.3",
        how="the limits that verdicts are given by",
        **RULES,
    ),
    *table(
        "10/10 zigzag",
        {
            "first overshoot 10/10, L/V 5 s": 10.0, "second overshoot 10/10, L/V 5 s": 25.0,
            "first overshoot 10/10, L/V 20 s": 15.0, "second overshoot 10/10, L/V 20 s": 32.5,
            "first overshoot 10/10, L/V 40 s": 20.0, "second overshoot 10/10, L/V 40 s": 40.0,
        },
        zigzags,
        unit="°",
        place="paragraph 5.3.3: 5 + L/(2V) and 17.5 + 0.75 L/V between 10 s and 30 s",
        how="the limits that verdicts are given by",
        **RULES,
    ),
    *table(
        "Limits of two trials",
        {
            "bulk carrier, advance": 765.0, "bulk carrier, tactical diameter": 850.0,
            "patrol vessel, advance": 198.0, "patrol vessel, tactical diameter": 220.0,
        },
        of_trials,
        unit="m",
        sources=("sea_trial_identification",),
        place="tables 1 and 2",
        nature="printed",
        part="program",
        how="the limits that `pmmkit trial` judges by",
        within=1e-9,
    ),
)  # fmt: skip
