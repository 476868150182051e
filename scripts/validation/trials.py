"""Sea trials: what was measured, and fixes in metres."""

from __future__ import annotations

import math
from functools import cache

import numpy as np

from pmmkit.campaigns.samples.loading import local_metres
from scripts.studies import bulk_carrier as bulk
from scripts.studies import patrol_vessel as patrol
from scripts.validation.published import Published, Values, table
from scripts.validation.sailed import turns

PAPER = {"sources": ("sea_trial_identification",), "nature": "measured", "part": "prediction"}
ESTIMATES = (
    "The paper prints nine derivatives, which it identified from this ship's trials; propeller, "
    "rudder and resistance are estimates from the particulars, not tuned to the trial "
    "([bulk_carrier.md](bulk_carrier.md)). Its own "
    "simulation differs by 1.34 % in tactical diameter and 12.7 % in advance."
)


PARTICULARS = (
    "A planing hull at Fn 0.72 by regressions over displacement ships, jets from the engines' "
    "power and usual efficiencies; nothing is tuned to the trial "
    "([patrol_vessel.md](patrol_vessel.md))."
)


@cache
def stop_by_buckets() -> Values:
    """The stop of the patrol vessel, by what pmmkit assumes of pumps and buckets."""
    found = patrol.stopped(patrol.patrol_vessel())
    return {name: found[name] for name in patrol.STOP}


@cache
def stop() -> Values:
    """The crash stop."""
    found = bulk.stopped()
    return {name: found[name] for name in bulk.STOP}


def angle(degrees: float, minutes: float, seconds: float) -> float:
    """An angle [deg]; all three of one sign."""
    return degrees + minutes / 60 + seconds / 3600


@cache
def line() -> Values:
    """From Flinders Peak to Buninyong."""
    start = angle(-37, -57, -3.72030), angle(144, 25, 29.52440)
    x, y = local_metres(
        np.array([angle(-37, -39, -10.15610)]), np.array([angle(143, 55, 35.38390)]), start
    )
    return {
        "distance": float(np.hypot(x[0], y[0])),
        "azimuth": math.degrees(math.atan2(y[0], x[0])) % 360.0,
    }


FIGURES: tuple[Published, ...] = (
    *turns(
        "Bulk carrier of 170 m, turning circles at sea",
        bulk.NAME,
        bulk.TRIAL,
        bulk.TURNS,
        place="table 2",
        how="`bulk-carrier-170`: the paper's derivatives, the rest estimated",
        within=1.2,
        why=ESTIMATES + " The trial's transfer is unusually small beside its diameter, and its "
        "advance large, as they are of a point well aft of midship; the paper does not say whose "
        "positions they are.",
        **PAPER,
    ),
    *table(
        "Bulk carrier of 170 m, crash stop at sea",
        bulk.STOP,
        stop,
        unit={"time_to_stop": "s", "track_reach": "m"},
        place="section 2.2",
        how="`bulk-carrier-170`, engine and propeller astern as pmmkit assumes them",
        within=0.6,
        why=ESTIMATES + " The stop hangs on when the engine can be reversed, which no model of "
        "hull and propeller knows.",
        **PAPER,
    ),
    *turns(
        "Patrol vessel of 44 m, turning circles at sea",
        patrol.NAME,
        patrol.TURNING_SPEED,
        patrol.TURNS,
        place="table 1",
        how="`patrol-vessel-44`: estimates from the particulars",
        within=0.5,
        why=PARTICULARS + " The trial's transfer is 0.61 and 0.66 of its diameter, the model's "
        "0.43, and 0.55 where the course stands for the heading.",
        **PAPER,
    ),
    *table(
        "Patrol vessel of 44 m, stop by buckets at sea",
        patrol.STOP,
        stop_by_buckets,
        unit={"time_to_stop": "s", "track_reach": "m"},
        place="section 2.2",
        how="`patrol-vessel-44`, pumps at 0.7 of the revolutions, buckets down in 6 s",
        within=0.4,
        why=PARTICULARS + " The paper states neither the revolutions nor the time of the buckets: "
        "113 to 181 m over those that the page varies.",
        **PAPER,
    ),
    *table(
        "A line of 55 km between fixes",
        {"distance": 54972.271, "azimuth": angle(306, 52, 5.37)},
        line,
        unit={"distance": "m", "azimuth": "°"},
        sources=("vincenty_1975",),
        place="the line from Flinders Peak to Buninyong by his formula, as Geoscience Australia "
        "and others quote it",
        nature="printed",
        part="program",
        how="latitude and longitude of sea trials in metres about the first fix",
        within=5e-5,
    ),
)
