"""A campaign written in other axes, angles and motions stated in them, gives the same table."""

from __future__ import annotations

import csv
import re
import shutil

import numpy as np
import pytest

from pmmkit import open_campaign, reduce_campaign
from pmmkit.reduction.solve import measured_and_fitted
from tests.support.small_campaign import write_campaign

CHANGED = {
    "yz": {"Y", "N", "drift", "sway", "yaw"},
    "xz": {"X", "N", "drift", "yaw"},
    "xy": {"X", "Y", "sway"},
}
"""What changes its sign: y to port and z up; x aft and z up; x aft and y to port. A heading, and so
a drift angle, goes from x towards y."""


@pytest.fixture(scope="module")
def ours(tmp_path_factory):
    return write_campaign(tmp_path_factory.mktemp("ours") / "small")


@pytest.fixture(scope="module")
def table(ours):
    return reduce_campaign(open_campaign(ours), check=False).table


def in_other_axes(ours, folder, axes, *, words=""):
    """The same tests as a laboratory with these axes would write them down."""
    shutil.copytree(ours, folder)
    changed = CHANGED[axes]
    for path in (folder / "runs").iterdir():
        with path.open() as stream:
            names, *rows = csv.reader(stream)
        turned = [
            [
                (cell[1:] if cell.startswith("-") else f"-{cell}") if name in changed else cell
                for name, cell in zip(names, row, strict=True)
            ]
            for row in rows
        ]
        path.write_text("\n".join(map(",".join, [names, *turned])) + "\n")
    text = (folder / "campaign.toml").read_text()
    if "drift" in changed:
        text = re.sub(
            r"drift_deg = (-?)(.*)", lambda m: f"drift_deg = {'' if m[1] else '-'}{m[2]}", text
        )
    for kind, tests in (("sway", ("pure_sway",)), ("yaw", ("pure_yaw", "yaw_drift"))):
        for test in tests if kind in changed else ():
            text = text.replace(f'test = "{test}"', f'test = "{test}"\nphase_deg = -180.0')
    lines = "\n".join(f'{axis} = "-{axis}"' for axis in axes)
    text = text.replace('"hydrodynamic"\n', f'"hydrodynamic"\n{words}\n[axes]\n{lines}\n', 1)
    (folder / "campaign.toml").write_text(text)
    return open_campaign(folder)


@pytest.mark.slow
@pytest.mark.parametrize("axes", CHANGED)
def test_stated_angles_and_motions_go_with_the_axes(ours, table, tmp_path, axes):
    theirs = in_other_axes(ours, tmp_path / "theirs", axes)
    found = reduce_campaign(theirs, check=False).table
    assert found.names == table.names
    np.testing.assert_allclose(found.value, table.value, rtol=1e-12, atol=1e-15)


def test_a_drift_angle_said_in_words_does_not_go_with_the_axes(ours, tmp_path):
    said = in_other_axes(ours, tmp_path / "said", "yz", words='drift_positive = "starboard-bow"')
    gone = in_other_axes(ours, tmp_path / "gone", "yz")
    assert said["SD_U1_b+08"].settings.drift == -gone["SD_U1_b+08"].settings.drift
    assert gone["SD_U1_b+08"].settings.drift > 0


@pytest.mark.parametrize(
    ("axes", "turn", "heel"), [("yz", -1, 1), ("xz", -1, -1), ("xy", 1, -1), ("z", 1, -1)]
)
def test_stated_turns_and_heel_go_with_the_axes(tmp_path, ours, axes, turn, heel):
    shutil.copytree(ours, tmp_path / "turning")
    path = tmp_path / "turning" / "campaign.toml"
    head = path.read_text().partition("[[runs]]")[0]
    lines = "\n".join(f'{axis} = "-{axis}"' for axis in axes)
    path.write_text(
        f"{head}[axes]\n{lines}\n"
        + "".join(
            f'[[runs]]\nid = "{name}"\ntest = "{test}"\nfile = "runs/SD_U1_b+00.csv"\nspeed = 1.0\n'
            f"{keys}\n"
            for name, test, keys in (
                ("rate", "circular_motion", "yaw_rate = 0.2"),
                ("radius", "circular_motion", "radius = 20.0"),
                ("heel", "static_heel", "heel_deg = 10.0"),
            )
        )
    )
    found = open_campaign(tmp_path / "turning")
    assert found["rate"].settings.turn_rate == turn * 0.2
    assert found["radius"].settings.turn_rate == turn * 0.05
    assert np.sign(found["heel"].settings.heel) == heel


@pytest.mark.slow
def test_a_roll_moment_that_the_structure_does_not_hold_is_passed_over(ours, tmp_path):
    """Some runs hold K and no derivative of it is asked: what the fit makes of forces has none."""
    folder = shutil.copytree(ours, tmp_path / "rolled")
    for path in (folder / "runs").glob("SD_*.csv"):
        head, *rows = path.read_text().splitlines()
        path.write_text("\n".join([f"{head},K", *(f"{row},0.5" for row in rows)]) + "\n")
    found = reduce_campaign(open_campaign(folder), structure=["Yv", "Nv", "Xuu"], check=False)
    assert set(measured_and_fitted(found.rows, found.solution)) == {"X", "Y", "N"}
