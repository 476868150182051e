"""Sinkage and trim of straight runs: squat over the Froude number."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from pmmkit.reduction.observations.prepare import RunResult
from pmmkit.reduction.solve import froude_groups

if TYPE_CHECKING:
    import pandas as pd


@dataclass(frozen=True, kw_only=True)
class Squat:
    """Sinkage and trim at one Froude number, straight ahead.

    `sinkage, sinkage_std`: mean of the runs [m], positive down, and their standard deviation
    (NaN of a single run). `trim, trim_std`: mean of the runs [rad], as the file counts it, and
    their standard deviation.
    """

    Fn: float
    sinkage: float
    sinkage_std: float
    trim: float
    trim_std: float
    runs: int


def squat(results: Sequence[RunResult]) -> tuple[Squat, ...]:
    """Sinkage and trim by Froude number, of steady runs without drift, turn, heel and rudder."""
    straight = [item for item in results if _straight(item)]
    groups = froude_groups([item.froude for item in straight])
    return tuple(
        Squat(
            Fn=Fn,
            sinkage=_mean([x.extras.get("sinkage") for x in own]),
            sinkage_std=_deviation([x.extras.get("sinkage") for x in own]),
            trim=_mean([x.extras.get("trim") for x in own]),
            trim_std=_deviation([x.extras.get("trim") for x in own]),
            runs=len(own),
        )
        for Fn, places in groups
        for own in ([straight[place] for place in places],)
    )


def squat_frame(found: Sequence[Squat]) -> pd.DataFrame:
    """A row per Froude number: Fn, sinkage [m], trim [deg], their deviations, runs."""
    import pandas as pd

    return pd.DataFrame(
        [
            {
                "Fn": item.Fn,
                "sinkage": item.sinkage,
                "sinkage_std": item.sinkage_std,
                "trim_deg": math.degrees(item.trim),
                "trim_std_deg": math.degrees(item.trim_std),
                "runs": item.runs,
            }
            for item in found
        ]
    )


def _straight(item: RunResult) -> bool:
    settings = item.run.settings
    turned = (settings.drift, settings.rudder, settings.heel, settings.turn_rate)
    return (
        not item.run.dynamic
        and bool({"sinkage", "trim"} & set(item.extras))
        and not any(turned)
        and math.isfinite(item.froude)
    )


def _known(values: Sequence[float | None]) -> list[float]:
    return [x for x in values if x is not None and math.isfinite(x)]


def _mean(values: Sequence[float | None]) -> float:
    known = _known(values)
    return float(np.mean(known)) if known else math.nan


def _deviation(values: Sequence[float | None]) -> float:
    known = _known(values)
    return float(np.std(known, ddof=1)) if len(known) > 1 else math.nan
