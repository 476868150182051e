"""What each candidate alone would do to free-running records, before anything is added."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any, Final

import numpy as np

from pmmkit.diagnosis import MOTION, Contest, SetFit, alone, errors_of, taken_away, whole_path
from pmmkit.numerics import Array
from pmmkit.views.pages.numbers import short
from pmmkit.views.pages.records import MOTIONS

NUMBERS: Final = 120_000
"""Of all paths together, where a page holds one campaign: it stays small enough for one file."""
SAMPLES: Final = (40, 200)
"""Least and most samples of a path."""
WORSE: Final = -10.0
"""A share below which the motion of some record is lost: it is none."""

Paths = dict[str, dict[str, list[float]]]
"""By record its motion in the units of the screen."""


def record_effects(
    contest: Contest, names: Sequence[str], heard: Callable[[int, str], None], numbers: int
) -> tuple[dict[str, dict[str, Any]], dict[str, Paths], Paths]:
    """By candidate its share of the misfit and its paths, and the paths of the base alone."""
    null = alone(contest)
    records = [item.record for item in null.followed.stretches]
    wanted = numbers // (len(records) * (len(names) + 1) * len(MOTION))
    count = min(max(wanted, SAMPLES[0]), SAMPLES[1])
    length = null.place.question.model.ship.L

    def paths(fit: SetFit) -> Paths:
        return {
            record.name: _path(whole_path(fit, number), count, length)
            for number, record in enumerate(records)
        }

    before = errors_of(null)
    shares, overlays = {}, {}
    for number, name in enumerate(names):
        heard(number, name)
        fit = alone(contest, name)
        after = errors_of(fit)
        whole = taken_away(fit, before, after)
        if whole < WORSE:
            continue
        shares[name] = {
            "all": short(whole),
            "channels": {
                kind: short(1.0 - (after[kind] / x) ** 2 if x > 0.0 else 0.0)
                for kind, x in before.items()
            },
        }
        overlays[name] = {
            record: {motion: values for motion, values in own.items() if motion in MOTION}
            for record, own in paths(fit).items()
        }
    return shares, overlays, paths(null)


def _path(motion: Mapping[str, Array], count: int, length: float) -> dict[str, list[float]]:
    size = len(motion["t"])
    kept = np.unique(np.linspace(0, size - 1, count).round().astype(int))
    factors = {name: MOTIONS[name][1] for name in MOTION} | {"x": 1.0 / length, "y": 1.0 / length}
    return {name: short(factors.get(name, 1.0) * values[kept]) for name, values in motion.items()}
