"""What runs have in common is stated once: ``[defaults]``, its tables for kinds, ``cfd``."""

from __future__ import annotations

import math

import numpy as np
import pytest
from small_campaign import HEAD

from pmmkit import open_campaign
from pmmkit.base import CampaignError
from pmmkit.exports import export

T = np.arange(0.0, 40.0, 0.05)


def campaign(folder, text, *, files=("a", "b", "c")):
    for name in files:
        rows = np.column_stack([T, -20 + 0 * T, 10 * np.cos(0.5 * T), 5 * np.sin(0.5 * T)])
        np.savetxt(
            folder / f"{name}.csv", rows, delimiter=",", header="t,X,Y,N", comments="", fmt="%.9g"
        )
    (folder / "campaign.toml").write_text(HEAD + text, encoding="utf-8")
    return open_campaign(folder)


def test_runs_take_what_they_do_not_state_from_their_kind_and_then_from_all(tmp_path):
    found = campaign(
        tmp_path,
        """
[defaults]
speed = 1.2
period = 9.0
[defaults.pure_yaw]
period = 12.0
yaw_amplitude_deg = 10.0
[[runs]]
id = "a"
test = "pure_sway"
file = "a.csv"
amplitude_m = 0.3
[[runs]]
id = "b"
test = "pure_yaw"
file = "b.csv"
[[runs]]
id = "c"
test = "pure_yaw"
file = "c.csv"
speed = 1.5
frequency_hz = 0.1
""",
    )
    sway, yaw, own = (found[name].settings for name in "abc")
    assert (sway.speed, sway.period, sway.amplitude) == (1.2, 9.0, 0.3)
    assert sway.yaw_amplitude is None, "of yaw tests alone"
    assert (yaw.speed, yaw.period) == (1.2, 12.0)
    assert yaw.yaw_amplitude == pytest.approx(math.radians(10.0))
    assert (own.speed, own.period) == (1.5, 10.0), "its frequency, not the period of its kind"


def test_a_steady_test_takes_no_period(tmp_path):
    found = campaign(
        tmp_path,
        """
[defaults]
speed = 1.2
period = 9.0
[[runs]]
id = "a"
test = "static_drift"
file = "a.csv"
drift_deg = 4.0
""",
    )
    assert found["a"].settings.period is None


def test_columns_and_source_by_kind_are_completed_key_by_key(tmp_path):
    found = campaign(
        tmp_path,
        """
[defaults]
speed = 1.2
[defaults.static_drift]
columns = { Y = { name = "Y", scale = 2.0 }, N = { name = "N", scale = 3.0 } }
[[runs]]
id = "a"
test = "static_drift"
file = "a.csv"
drift_deg = 4.0
columns = { N = { name = "N", scale = -1.0 } }
[[runs]]
id = "b"
test = "resistance"
file = "b.csv"
""",
    )
    np.testing.assert_allclose(found["a"].data["Y"], 20 * np.cos(0.5 * T), atol=1e-7)
    np.testing.assert_allclose(found["a"].data["N"], -5 * np.sin(0.5 * T), atol=1e-7)
    np.testing.assert_allclose(found["b"].data["Y"], 10 * np.cos(0.5 * T), atol=1e-7)


def test_rotated_inflow_and_moving_mesh_in_one_campaign(tmp_path):
    """Forces along the tank are turned into the hull where the mesh moves, not where it stands."""
    found = campaign(
        tmp_path,
        """
[cfd]
forces_in = "earth"
[defaults]
speed = 1.2
drift_deg = 30.0
[defaults.static_drift.cfd]
forces_in = "body"
[[runs]]
id = "a"
test = "static_drift"
file = "a.csv"
[[runs]]
id = "b"
test = "static_drift"
file = "b.csv"
cfd = { forces_in = "earth", ramp_s = 10.0, rho_inf = 99.91, symmetry_factor = 2.0 }
""",
    )
    standing, turned = found["a"].data, found["b"].data
    np.testing.assert_allclose(standing["X"], -20.0, atol=1e-7)
    cosine, sine = math.cos(math.radians(30)), math.sin(math.radians(30))
    late = T[T >= 10.0]
    np.testing.assert_allclose(turned["t"], late)
    expected = 20 * (-20 * cosine + 10 * np.cos(0.5 * late) * sine)
    np.testing.assert_allclose(turned["X"], expected, atol=1e-6)
    export(found, tmp_path / "again")
    again = open_campaign(tmp_path / "again")
    for name in "ab":
        np.testing.assert_array_equal(again[name].data["X"], found[name].data["X"])


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("[defaults]\nsped = 1.0\n", "did you mean 'speed'"),
        ("[defaults.pure_jaw]\nperiod = 9.0\n", "did you mean 'pure_yaw'"),
        ("[defaults.pure_yaw]\nperiod = -9.0\n", "is -9 s, and tests have 0.05 to 600 s"),
        (
            "[defaults.pure_yaw.cfd]\nforces_in = 'sea'\n",
            "'sea' is not one of body, earth, carriage",
        ),
    ],
)
def test_a_wrong_default_is_said_once_beside_all_other_problems(text, said, tmp_path):
    runs = "".join(
        f'[[runs]]\nid = "{name}"\ntest = "pure_sway"\nfile = "{name}.csv"\nspeed = 1.0\n'
        for name in "ab"
    )
    with pytest.raises(CampaignError) as raised:
        campaign(tmp_path, text + runs, files=("a", "b"))
    words = str(raised.value)
    assert words.count(said) == 1
    assert words.count("the period") == 2


def test_a_yaw_test_may_be_set_by_the_amplitude_of_its_path(tmp_path):
    """The hull crosses the middle of the tank along its path: tan ψ0 = aω/U."""
    found = campaign(
        tmp_path,
        """
[defaults]
speed = 1.2
yaw_amplitude_deg = 3.0
[[runs]]
id = "a"
test = "pure_yaw"
file = "a.csv"
period = 9.0
path_amplitude_m = 0.25
""",
    )
    slope = math.tan(found["a"].settings.yaw_amplitude)
    assert slope == pytest.approx(0.25 * 2 * math.pi / 9.0 / 1.2)
