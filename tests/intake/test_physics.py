"""What the forces of a hull say of axes and inertia, without knowing the ship."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from pmmkit import open_campaign
from pmmkit.intake import summarise
from pmmkit.intake.checks.physics import along_tank, asked_signs, inertia_inside
from tests.support.small_campaign import write_campaign

MASS = 454.476


@pytest.fixture(scope="module")
def campaign(tmp_path_factory):
    return open_campaign(write_campaign(tmp_path_factory.mktemp("physics") / "small"))


@pytest.fixture(scope="module")
def summaries(campaign):
    return tuple(summarise(run, campaign) for run in campaign)


def weighed(item, mass=MASS):
    """The run as a balance shows it: with m(v̇ + r u) of the model taken from Y."""
    if not item.run.dynamic:
        return item
    cos, sin = dict(item.cos), dict(item.sin)
    cos["Y"] = cos["Y"] - mass * (item.cos["vdot"] + item.cos["u"][0] * item.cos["r"])
    sin["Y"] = sin["Y"] - mass * (item.sin["vdot"] + item.cos["u"][0] * item.sin["r"])
    return replace(item, cos=cos, sin=sin)


def along(item):
    """A static run whose forces stay along the tank."""
    beta = item.run.settings.drift
    X, Y = item.means["X"], item.means["Y"]
    turned = {"X": X * np.cos(beta) - Y * np.sin(beta), "Y": X * np.sin(beta) + Y * np.cos(beta)}
    return item if item.run.dynamic else replace(item, means={**item.means, **turned})


def test_all_signs_of_a_hull_are_as_they_should_be(campaign, summaries):
    found = asked_signs(campaign, summaries)
    assert {(sign.channel, sign.motion) for sign in found} == {
        ("X", "ahead"),
        *((channel, motion) for channel in "YN" for motion in ("drift", "sway")),
        ("N", "yaw"),
    }
    assert all(sign.verdict == 1 for sign in found if sign.channel != "X")
    assert all(sign.verdict >= 0 for sign in found)


def test_inertia_shows_without_the_mass(summaries):
    """(Yr - m)/(Yv̇ - m) and Yr/Yv̇ of the S175: .38 and -.31."""
    inside, ratio = inertia_inside([weighed(item) for item in summaries])
    assert inside
    assert ratio == pytest.approx((2.182 - 7.92) / (-7.049 - 7.92), abs=0.08)
    inside, ratio = inertia_inside(summaries)
    assert not inside
    assert ratio == pytest.approx(2.182 / -7.049, abs=0.08)


def test_half_of_the_inertia_says_nothing(summaries):
    assert inertia_inside([weighed(item, 0.5 * MASS) for item in summaries]) is None


def test_forces_along_the_tank_show_by_the_drag_of_the_side_force(campaign, summaries):
    hull, ratio = along_tank(campaign, summaries)
    assert not hull
    tank, turned = along_tank(campaign, [along(item) for item in summaries])
    assert tank
    assert turned == pytest.approx(ratio - 1, abs=0.3)


def test_two_angles_say_nothing_of_the_axes(campaign, summaries):
    few = [item for item in summaries if abs(item.run.settings.drift) < 0.1]
    assert along_tank(campaign, few) is None
