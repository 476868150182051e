"""What a run was set to, in words: the same list for console, report, page and conditions."""

from __future__ import annotations

from dataclasses import fields

import pytest

from pmmkit import Run
from pmmkit.campaigns import Settings
from pmmkit.diagnosis.captive.held_out import conditions

SIZES = {"phase", "strut_spacing", "strut_centre", "repeat_of", "speed", "further"}
"""Of the record, of the mechanism and of the programme: they are told elsewhere."""


def run_of(test, **settings):
    return Run(id="a", test=test, kind="means", loader=None, settings=Settings(**settings))


@pytest.mark.parametrize("name", [x.name for x in fields(Settings) if x.name not in SIZES])
def test_no_setting_is_lost_in_words(name):
    plain, other = Settings(speed=1.0), Settings(speed=1.0, **{name: 0.3})
    assert len(other.words) == len(plain.words) + 1
    assert run_of("static_drift", speed=1.0, **{name: 0.3}).setting.startswith("1 m/s, ")


def test_a_circle_is_told_by_its_rate_however_it_is_stated():
    by_rate = run_of("circular_motion", speed=1.0, yaw_rate=0.1)
    by_radius = run_of("circular_motion", speed=1.0, radius=10.0)
    assert by_rate.setting == by_radius.setting == "1 m/s, yaw rate 5.73°/s"
    assert by_rate.settings.words == by_radius.settings.words == ("r +5.73°/s",)


def test_the_amplitude_is_called_by_the_motion():
    surge, sway = (run_of(x, speed=1.0, amplitude=0.2) for x in ("pure_surge", "pure_sway"))
    assert (surge.setting, sway.setting) == ("1 m/s, surge 0.2 m", "1 m/s, sway 0.2 m")


def test_conditions_that_the_digits_do_not_tell_apart_stay_two():
    """4 mm/s are more than a carriage differs by, and less than three digits show."""
    runs = [
        Run(id=name, test="static_drift", kind="means", loader=None,
            settings=Settings(speed=speed, drift=0.1))
        for name, speed in (("a", 1.498), ("b", 1.502), ("c", 1.498))
    ]  # fmt: skip
    named = conditions(runs)
    assert named["a"] == named["c"] != named["b"]
