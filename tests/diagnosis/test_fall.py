"""The fall of the error: one long table of captive tests, of records, or of several campaigns."""

from __future__ import annotations

import io
import json
import math
from dataclasses import replace

import numpy as np
import pandas as pd
import pytest
from hidden_effects import hidden_campaign

import pmmkit as pk
from pmmkit.diagnosis import Fall
from pmmkit.diagnosis.captive.held_out import held_out
from pmmkit.diagnosis.loop.captive import TOLD as CAPTIVE
from pmmkit.diagnosis.loop.fall import FallRow
from pmmkit.diagnosis.loop.records import TOLD as RECORDS
from pmmkit.models import Step
from pmmkit.plotting.marks import BarSeries
from pmmkit.views import page_of
from tests.support.uncoupled import uncoupled

UNITS = {"position": "m", "heading": "deg", "speed": "m/s", "yaw_rate": "deg/s"}


def rows(campaign, errors, level=math.nan):
    """Of records: by step the errors of each quantity."""
    return tuple(
        FallRow(
            step=step,
            campaign=campaign,
            group="all",
            quantity=name,
            error=error,
            level=level,
            unit=UNITS[name],
        )
        for step, own in errors.items()
        for name, error in own.items()
    )


def effect(name, campaign=""):
    action = "fault_corrected" if campaign else "effect_added"
    return Step(action=action, effect=name, campaign=campaign)


def of_records(errors, campaign="sea", level=math.nan):
    added = tuple(effect(step) for step in errors if step != "base")
    return Fall(added=added, rows=rows(campaign, errors, level), told={campaign: RECORDS})


def test_a_step_that_lowers_nothing_is_said_so():
    """Numbers by hand: the second step makes everything worse by a tenth."""
    table = [(0.3, 2.0, 0.01, 0.2), (0.2, 1.0, 0.01, 0.1), (0.22, 1.1, 0.011, 0.11)]
    errors = [dict(zip(UNITS, row, strict=True)) for row in table]
    fall = of_records(dict(zip(("base", "asymmetry", "wake"), errors, strict=True)))
    assert fall.useless == ("wake",)
    assert fall.remarks() == [
        "asymmetry: position -33 %, heading -50 %, speed +0 %, yaw rate -50 %.",
        "wake: position +10 %, heading +10 %, speed +10 %, yaw rate +10 %.",
        "wake lowers no error of left-out records.",
    ]
    figure = fall.plot()
    assert [axis.ylabel.text for axis in figure.shown] == [
        f"error [{unit}]" for unit in ("m", "deg", "m/s", "deg/s")
    ]
    (bars,) = (mark for mark in figure.shown[1].marks if isinstance(mark, BarSeries))
    assert bars.length.tolist() == [2.0, 1.0, 1.1]


def test_what_was_not_measured_is_not_told():
    fall = of_records({"base": {"heading": 1.0}})
    assert fall.quantities() == ("heading",)
    assert len(fall.plot().shown) == 1
    assert list(page_of(fall)["steps"][0]["channels"]) == ["heading"]
    told = fall.to_pandas()
    assert told["heading"][0] == 1.0
    assert math.isnan(told["yaw_rate"][0]), "a column of the file, whatever was measured"


def joint():
    """Two seas with the same fault, each its own; the second has no yaw rate."""
    one = {
        "base": {"position": 4.0, "heading": 3.0, "yaw_rate": 0.3},
        "wake": {"position": 2.0, "heading": 2.0, "yaw_rate": 0.2},
        "current": {"position": 1.0, "heading": 2.0, "yaw_rate": 0.2},
    }
    two = {
        "base": {"position": 8.0, "heading": 5.0},
        "wake": {"position": 8.0, "heading": 5.0},
        "current": {"position": 8.0, "heading": 6.0},
    }
    return Fall(
        added=(effect("wake"), effect("current", "one"), effect("current", "two")),
        rows=(*rows("one", one, 0.5), *rows("two", two)),
        told={"one": RECORDS, "two": RECORDS},
    )


def test_a_step_that_a_campaign_is_not_asked_for_leaves_its_errors():
    fall = joint()
    assert fall.steps == ("base", "wake", "current (one)", "current (two)")
    assert fall.by_campaign == {"one": (3.0, 2.0, 2.0, 2.0), "two": (5.0, 5.0, 5.0, 6.0)}
    assert fall.asked("one") == (True, True, True, False)
    assert fall.asked("two") == (True, True, False, True)
    assert fall.errors("position", "one") == (4.0, 2.0, 1.0, 1.0)
    assert fall.useless == ("current (two)",)
    (group,) = fall.table().groups
    assert [row[1:] for row in group.rows] == [
        *(["3", "5"], ["2", "5"], ["2", ""], ["", "6"], ["0.5", ""])
    ]
    assert [axis.title.text for axis in fall.plot().shown] == ["one: heading", "two: heading"]
    page = page_of(fall)["campaigns"]
    assert [item["title"] for item in page] == ["one", "two"]
    assert [step["step"] for step in page[1]["steps"]] == list(fall.steps)
    assert [step["error"] for step in page[1]["steps"]] == [5.0, 5.0, 5.0, 6.0]
    assert page[1]["useless"] == ["wake", "current (two)"]
    json.dumps(page, allow_nan=False)


def test_one_of_several_is_told_as_if_it_were_alone():
    own = joint().only("one")
    alone = of_records(
        {
            "base": {"position": 4.0, "heading": 3.0, "yaw_rate": 0.3},
            "wake": {"position": 2.0, "heading": 2.0, "yaw_rate": 0.2},
            "current": {"position": 1.0, "heading": 2.0, "yaw_rate": 0.2},
        },
        "one",
        0.5,
    )
    assert own.rows == alone.rows
    assert str(own).replace(" (one)", "").split() == str(alone).split()


def test_the_long_table_comes_back_from_its_file():
    frame = joint().to_frame()
    assert list(frame.columns[:7]) == [
        *("step", "campaign", "group", "quantity", "error", "level", "unit")
    ]
    again = pd.read_csv(io.StringIO(frame.to_csv(index=False)))
    pd.testing.assert_frame_equal(again, frame)


@pytest.fixture(scope="module")
def tested():
    return uncoupled(), hidden_campaign("small", {"yaw_sway_coupling": 1.0}, seed=1)


def test_the_table_of_captive_tests_is_what_is_held_out(tested):
    """Root mean squares over conditions by numpy; a share is over the rms force of the channel."""
    model, tests = tested
    session = pk.begin(model, tests)
    fall = session.fall()
    left = held_out(session.evidence.system, ())
    rms = np.sqrt(np.nanmean(left.error**2, axis=0))
    force = np.sqrt(np.nanmean(left.force**2, axis=0))
    for name, error, whole in zip(left.channels, rms, force, strict=True):
        assert fall.errors(name) == pytest.approx((error,), rel=1e-12)
        assert fall.levels(name)[0] < error
        row = fall.to_pandas().query(f"test == 'all' and channel == '{name}'").iloc[0]
        assert (row.error, row.force) == pytest.approx((error, whole), rel=1e-12)
        assert row.share == pytest.approx(error / whole, rel=1e-12)
    assert fall.totals[0] == pytest.approx(100 * np.sqrt(np.mean((rms / force) ** 2)), rel=1e-12)
    assert fall.told[fall.campaigns[0]] is CAPTIVE
    assert list(fall.to_pandas().columns) == [
        *("step", "test", "channel", "error", "level", "force", "share", "better", "campaign")
    ]
    text = str(fall)
    for word in ("static drift [%]", "N [N m]", "noise alone"):
        assert word in text


def test_one_campaign_falls_alike_alone_and_as_one_of_several(tested):
    """To the bit, whatever name it goes by in the session: rows, words, figures and the model."""
    model, tests = tested
    alone = pk.begin(model, tests).add("yaw_sway_coupling").add("fault_misalignment")
    named = {"tank": tests}
    joint = pk.begin(model, named).add("yaw_sway_coupling").add("fault_misalignment")
    assert [replace(row, campaign="") for row in joint.fall().rows] == [
        replace(row, campaign="") for row in alone.fall().rows
    ]
    assert str(joint.fall()).replace(" (tank)", "").split() == str(alone.fall()).split()
    assert joint.model().history == alone.model().history
    np.testing.assert_array_equal(joint.model().covariance, alone.model().covariance)
    assert "fault_misalignment" not in joint.model().parts, "a fault does not sail with the ship"
