"""What the report says of runs that repeat each other, and of squat, by hand."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from small_campaign import write_campaign

import pmmkit as pk
from pmmkit.reduction import reduce_campaign
from pmmkit.reduction.reduce import squat
from pmmkit.views.report.captive.result_chapters import repeatability


@pytest.fixture(scope="module")
def reduced(tmp_path_factory):
    """The small programme; two drift tests of 4° at 1 m/s, and one of -4° thrice."""
    campaign = pk.open_campaign(write_campaign(tmp_path_factory.mktemp("repeats") / "tests"))
    once, other = campaign["SD_U1_b+04"], campaign["SD_U1_b-04"]
    more = [once.with_(id="again"), other.with_(id="a"), other.with_(id="b")]
    return reduce_campaign(campaign.with_(runs=(*campaign.runs, *more)), executor=1, check=False)


def with_readings(reduced, readings):
    """The reduction with side forces of some runs as given [N]."""
    runs = []
    for item in reduced.runs:
        if item.run.id in readings:
            item = replace(item, measured={**item.measured, "Y": np.array([readings[item.run.id]])})
        runs.append(item)
    return replace(reduced, runs=tuple(runs))


def test_standard_deviations_are_pooled_over_conditions_and_ranges_are_the_largest(reduced):
    """By hand: 10, 12 (squares about their mean 2) and -3, 0, 3 (18), of 1 + 2 degrees."""
    readings = {"SD_U1_b+04": 10.0, "again": 12.0, "SD_U1_b-04": -3.0, "a": 0.0, "b": 3.0}
    chapter = repeatability(with_readings(reduced, readings))
    assert chapter.items[0].value == "5 runs of 2 conditions"
    kinds, single = chapter.sections[0].tables
    (row,) = kinds.groups[0].rows
    found = dict(zip(kinds.head, row, strict=False))
    assert (row[1], row[2]) == ("2", "5")
    assert float(found["Y std [N]"]) == pytest.approx(math.sqrt(20.0 / 3.0), abs=0.005)
    place = list(kinds.head).index("Y std [N]")
    assert float(row[place + 1]) == 6.0
    first = single.groups[0].rows[0]
    at = list(single.head).index("Y mean [N]")
    assert [float(first[at]), float(first[at + 1])] == [0.0, 3.0]


def test_a_programme_without_repeats_says_none(reduced):
    alone = replace(reduced, runs=reduced.runs[:5])
    chapter = repeatability(alone)
    assert (chapter.items[0].value, chapter.sections) == ("none", [])


def test_squat_is_the_mean_of_straight_runs_by_speed(reduced):
    def sunk(place, Fn, **extras):
        straight = next(item for item in reduced.runs if item.run.id == "SD_U1_b+00")
        return replace(straight, froude=Fn, extras=extras, run=straight.run.with_(id=f"s{place}"))

    turned = next(item for item in reduced.runs if item.run.id == "SD_U1_b+08")
    frame = squat(
        [
            sunk(1, 0.2, sinkage=0.004, trim=math.radians(0.1)),
            sunk(2, 0.2005, sinkage=0.006, trim=math.radians(0.3)),
            sunk(3, 0.1, sinkage=0.001, trim=0.0),
            replace(turned, extras={"sinkage": 0.02}),
            sunk(4, 0.3),
        ]
    )
    assert frame["Fn"].round(4).tolist() == [0.1, 0.2002]
    assert frame["sinkage"].tolist() == pytest.approx([0.001, 0.005])
    assert frame["sinkage_std"][1] == pytest.approx(0.002 / math.sqrt(2.0))
    assert math.isnan(frame["sinkage_std"][0])
    assert frame["trim_deg"].tolist() == pytest.approx([0.0, 0.2])
    assert frame["runs"].tolist() == [1, 2]
