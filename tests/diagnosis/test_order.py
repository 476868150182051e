"""The order of a programme: drawn, in blocks, and no setting goes with the time of the day."""

from __future__ import annotations

import math
from collections import Counter
from dataclasses import replace
from itertools import groupby

import numpy as np
import pytest

from pmmkit import Limits
from pmmkit.campaigns import Settings
from pmmkit.diagnosis import Programme
from pmmkit.diagnosis.planning.options import Option, options_of
from pmmkit.models import load_model

TANKER = load_model("kvlcc2-l7")
LIMITS = Limits(
    speeds=(0.8, 1.0, 1.2),
    drift=math.radians(12),
    rudder=math.radians(20),
    sway=0.8,
    tests=("static_drift", "static_rudder", "pure_sway", "pure_yaw", "yaw_drift"),
    frequencies=(2.0,),
)
EVERY = options_of(LIMITS, TANKER.ship, TANKER.water)


def drawn(options) -> list[Option]:
    return [run.option for run in Programme.of(options, draw=True).runs]


def middles(options) -> np.ndarray:
    """Time of the day in the middle of each run [h]."""
    hours = np.array([option.hours for option in options])
    return np.cumsum(hours) - hours / 2


def correlation(times, values) -> float:
    return abs(float(np.corrcoef(times, values)[0, 1]))


def test_the_runs_are_the_same_and_the_order_too_every_time():
    assert len(EVERY) > 40
    assert Counter(x.id for x in drawn(EVERY)) == Counter(x.id for x in EVERY)
    assert drawn(EVERY) == drawn(EVERY)
    assert drawn(EVERY) != list(EVERY)
    assert [run.option for run in Programme.of(EVERY).runs] == list(EVERY)
    numbers = [run.number for run in Programme.of(EVERY, draw=True).runs]
    assert numbers == [*range(1, len(EVERY) + 1)]


def test_a_set_up_is_made_once():
    heeled = [
        replace(option, settings=replace(option.settings, heel=math.radians(5)))
        for option in EVERY
        if option.test == "static_drift"
    ]
    order = drawn([*EVERY, *heeled])
    blocks = [name for name, _ in groupby(order, key=lambda option: option.set_up)]
    assert sorted(blocks) == ["held", "held, heel +5", "oscillating"]


def test_a_zero_that_drifts_through_the_day_does_not_look_like_a_setting():
    """Slopes over speed, drift and rudder, by least squares, of a zero that climbs by 1 a day."""

    def slopes(options):
        times = middles(options)
        zero = (times - times[0]) / (times[-1] - times[0])
        settings = np.array(
            [[s.speed, s.drift, s.rudder] for s in (option.settings for option in options)]
        ).T
        spread = settings.max(axis=1) - settings.min(axis=1)
        held = np.array([option.set_up == "held" for option in options], float)
        rows = np.vstack([np.ones(len(times)), held, (settings.T / spread).T])
        return np.abs(np.linalg.lstsq(rows.T, zero, rcond=None)[0][2:])

    assert slopes(EVERY)[0] > 0.5
    assert slopes(drawn(EVERY)).max() < 0.06


@pytest.mark.parametrize("block", ["held", "oscillating"])
def test_in_a_block_tests_and_settings_are_mixed(block):
    order = [option for option in drawn(EVERY) if option.set_up == block]
    times = middles(order)
    for name in ("speed", "drift", "rudder", "period", "amplitude", "yaw_amplitude"):
        values = np.array([option.settings.value(name) or 0.0 for option in order])
        for own in (values, np.abs(values)):
            assert np.ptp(own) == 0 or correlation(times, own) < 0.25, name
    for test in {option.test for option in order}:
        assert correlation(times, [option.test == test for option in order]) < 0.25, test


def test_a_run_that_is_made_twice_is_made_early_and_late():
    options = [option for option in EVERY if option.test == "pure_sway"]
    order = Programme.of([*options, options[0], options[3]], draw=True).runs
    place = {run.id: run.number for run in order}
    for option in (options[0], options[3]):
        assert place[f"{option.id}_2"] - place[option.id] >= len(order) / 3 - 1
    again = {run.id: run.entry.get("repeat_of") for run in order}
    assert {x: y for x, y in again.items() if y} == {
        f"{option.id}_2": option.id for option in (options[0], options[3])
    }


@pytest.mark.parametrize("count", [0, 1, 2])
def test_few_runs_have_an_order_too(count):
    made = Programme.of(EVERY[:count], draw=True)
    assert len(made.runs) == count
    assert made.hours == pytest.approx(sum(option.hours for option in EVERY[:count]))


def test_the_numbers_of_a_run_are_those_that_are_written():
    settings = Settings(speed=1.0, drift=math.radians(1.23456789), period=7.123456)
    option = replace(EVERY[0], settings=settings)
    (made,) = Programme.of([option]).runs
    assert made.settings.drift == pytest.approx(math.radians(1.2346), rel=1e-12)
    assert made.settings.period == 7.1235


def test_a_reference_run_parts_the_day_from_the_settings():
    """Each day of a set-up begins and ends with it, and has it in the middle."""
    made = Programme.of(EVERY, draw=True, references=True)
    names = [run.id for run in made.runs]
    for first, again in made.references.items():
        block = next(run.option.set_up for run in made.runs if run.id == first)
        own = [run.id for run in made.runs if run.option.set_up == block]
        assert (own[0], own[-1]) == (first, again[-1])
        assert len(again) >= 3
        middle = names.index(again[1]) - names.index(first)
        assert abs(2 * middle - (names.index(again[2]) - names.index(first))) <= 1
        assert all(run.entry["repeat_of"] == first for run in made.runs if run.id in again[1:])
    assert len(made.runs) == len(EVERY) + sum(len(x) - 1 for x in made.references.values())
    assert len(made.reference_lines) == len(made.references)


def test_so_few_runs_have_no_reference_run():
    made = Programme.of(EVERY[:3], draw=True, references=True)
    assert len(made.runs) == 3
    assert not made.references
