"""Two gauges of the side force in place of side force and yaw moment."""

from __future__ import annotations

import numpy as np
import pytest

import pmmkit as pk
from pmmkit.base import CampaignError
from scripts.datasets.campaign_text import S175

T = np.arange(0.0, 10.0, 0.1)
FORWARD, AFT = 20.0 + np.sin(T), -8.0 + np.cos(3.0 * T)
PLACES = (0.55, -0.65)


def opened(tmp_path, head=f"side_gauges_x = {list(PLACES)}\n", axes="", **more):
    columns = {"t": T, "X": -1.0 + 0.0 * T, "Y_forward": FORWARD, "Y_aft": AFT, **more}
    columns = {name: values for name, values in columns.items() if values is not None}
    (tmp_path / "run.csv").write_text(
        "\n".join(
            [
                ",".join(columns),
                *(",".join(f"{x:.9f}" for x in row) for row in zip(*columns.values(), strict=True)),
            ]
        )
    )
    (tmp_path / "campaign.toml").write_text(
        f'[campaign]\ntitle = "gauges"\n{head}{axes}{S175}\n[[runs]]\nid = "a"\n'
        'test = "static_drift"\nspeed = 1.5\ndrift_deg = 6.0\nfile = "run.csv"\n'
    )
    return pk.open_campaign(tmp_path).runs[0].data


def test_two_gauges_are_a_force_and_a_moment_about_midship(tmp_path):
    data = opened(tmp_path)
    np.testing.assert_allclose(data["Y"], FORWARD + AFT, atol=1e-8)
    np.testing.assert_allclose(data["N"], PLACES[0] * FORWARD + PLACES[1] * AFT, atol=1e-8)
    assert "from two gauges, 0.55 and -0.65 m forward of midship" in data.attrs["conversions"]
    assert not {"Y_forward", "Y_aft"} & set(data)


def test_the_moment_refers_to_the_point_that_is_stated(tmp_path):
    places = f"side_gauges_x = {list(PLACES)}\nmoment_reference_x = 0.2\n"
    data = opened(tmp_path, places)
    levers = (PLACES[0] - 0.2, PLACES[1] - 0.2)
    np.testing.assert_allclose(data["N"], levers[0] * FORWARD + levers[1] * AFT, atol=1e-8)


@pytest.mark.parametrize(
    ("axes", "side"), [('x = "-x"\nz = "-z"', 1.0), ('y = "-y"\nz = "-z"', -1.0)]
)
def test_forward_is_forward_whichever_way_their_axes_point(axes, side, tmp_path):
    """With x aft and y to starboard N counts the other way there, and comes back."""
    data = opened(tmp_path, axes=f"[axes]\n{axes}\n")
    np.testing.assert_allclose(data["Y"], side * (FORWARD + AFT), atol=1e-8)
    moment = PLACES[0] * FORWARD + PLACES[1] * AFT
    np.testing.assert_allclose(data["N"], side * moment, atol=1e-8)


def test_a_measured_moment_stands_for_itself(tmp_path):
    data = opened(tmp_path, N=5.0 + 0.0 * T)
    np.testing.assert_allclose(data["N"], 5.0, atol=1e-8)
    np.testing.assert_allclose(data["Y"], FORWARD + AFT, atol=1e-8)


@pytest.mark.parametrize(
    ("head", "more", "says"),
    [
        ("", {}, r"need the places of the gauges.*side_gauges_x"),
        (None, {"Y_aft": None}, "no column Y"),
        (None, {"Y_aft": None, "Y": FORWARD, "N": AFT}, "Y_forward is there without Y_aft"),
        ("side_gauges_x = [0.5]\n", {}, "side_gauges_x"),
    ],
)
def test_half_a_balance_is_refused(head, more, says, tmp_path):
    places = f"side_gauges_x = {list(PLACES)}\n"
    with pytest.raises(CampaignError, match=says):
        opened(tmp_path, places if head is None else head, **more)
