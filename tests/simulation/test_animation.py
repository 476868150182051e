"""Forces by effect along a manoeuvre, and the manoeuvre in motion."""

from __future__ import annotations

import stat
import sys
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from PIL import Image, ImageChops

import pmmkit as pk
from pmmkit.base import DataError
from pmmkit.cli import main
from pmmkit.plotting import Figure
from pmmkit.plotting.animation import _water


@pytest.fixture(scope="module")
def turn():
    return pk.simulate("kvlcc2-l7", rudder_deg=35, speed=1.179, duration=400.0, forces=True)


def test_forces_of_a_steady_turn_hold_the_ship_on_her_circle(turn):
    """Yasukawa and Yoshimura (2015), equations 4 with no change of u, v, r; moments about midship.

    m, xG, mx' and my' of the 7 m model are theirs, in ½ρL²d.
    """
    mass, unit = 3270.0, 0.5 * 1000.0 * 7.0**2 * 0.46
    mx, my, xG = 0.022 * unit, 0.223 * unit, 0.25
    u, v, r = turn.u[-1], turn.v[-1], turn.r[-1]
    X, Y, N = sum(turn.forces.values())[:, -1]
    assert pytest.approx(-(mass + my) * v * r - mass * xG * r**2, rel=1e-4) == X
    assert pytest.approx((mass + mx) * u * r, rel=1e-4) == Y
    assert pytest.approx(mass * xG * u * r, rel=1e-3) == N


def test_straight_ahead_the_thrust_is_the_resistance(turn):
    X, Y, N = np.stack(list(turn.forces.values()))[:, :, 0].T
    assert turn.forces["propeller"][0, 0] > 0.0
    assert sum(X) == pytest.approx(0.0, abs=1e-6 * max(X))
    assert not Y.any()
    assert not N.any()


def test_the_rudder_pushes_the_stern_away_from_the_turn(turn):
    X, Y, N = turn.forces["rudder_mmg"]
    late = turn.t > 20.0
    assert (X[late] < 0.0).all()
    assert (Y[late] < 0.0).all()
    assert (N[late] > 0.0).all()
    place = N[late] / Y[late] / turn.L
    assert ((place > -0.6) & (place < -0.3)).all()


def test_a_track_in_another_size_has_forces_of_that_size(turn):
    full = turn.resized(320.0, turn.speed * np.sqrt(320.0 / turn.L))
    ratio = full.L / turn.L
    for name, forces in turn.forces.items():
        X, Y, N = full.forces[name]
        assert np.allclose([X, Y, N / ratio], forces * ratio**3, rtol=1e-12)


def test_a_track_keeps_no_forces_unless_asked(turn):
    assert not pk.simulate("kvlcc2-l7", speed=1.179, duration=10.0).forces
    half = turn.at(turn.t < 100.0)
    assert half.forces["propeller"].shape == (3, len(half.t))


def test_forces_over_time_stand_in_a_table_and_a_figure(turn):
    table = turn.forces_to_pandas()
    assert list(table)[:4] == ["t", "X_derivatives", "Y_derivatives", "N_derivatives"]
    assert (table["N_rudder_mmg"] == turn.forces["rudder_mmg"][2]).all()
    drawn = turn.figures()["forces"].axes
    assert [axis.title.text for axis in drawn] == ["X [N]", "Y [N]", "N [N m]"]
    assert {line.label for line in drawn[0].points} >= {"sum", "Propeller", "Rudder (MMG)"}
    assert "forces" not in replace(turn, forces={}).figures()
    assert replace(turn, forces={}).forces_to_pandas().empty


def test_each_picture_shows_another_instant(turn, tmp_path):
    told = []
    file = turn.animate(
        tmp_path / "turn.gif", frames=6, fps=5, progress=lambda *said: told.append(said)
    )
    assert told[-1] == (6, 6, "frames of turn.gif")
    with Image.open(file) as film:
        assert film.n_frames == 6
        assert film.info["duration"] == 200
        seen = []
        for place in range(6):
            film.seek(place)
            seen.append(film.convert("RGB"))
    width, height = seen[0].size
    path, title = (0, 60, 530, height - 90), (0, 20, 530, 48)
    for box in (path, title):
        parts = [item.crop(box) for item in seen]
        assert all(ImageChops.difference(a, b).getbbox() for a, b in pairwise(parts))
    forces = [item.crop((600, 60, width, height - 90)) for item in seen[:2]]
    assert ImageChops.difference(*forces).getbbox()
    edges = [item.crop((0, height - 70, width, height)) for item in seen]
    assert not any(ImageChops.difference(edges[0], item).getbbox() for item in edges)


def test_the_water_that_is_shown_holds_the_ship_wherever_she_is(turn):
    axis = Figure().subplots()
    _water(axis, turn)
    for side, own in (("x", turn.y), ("y", turn.x)):
        low, high = axis.limits(side)
        assert low <= own.min() / turn.L - 0.6
        assert high >= own.max() / turn.L + 0.6


def test_a_measured_track_is_animated_without_forces(turn, tmp_path):
    still = replace(turn, forces={}, delta=np.full(len(turn.t), np.nan))
    assert still.animate(tmp_path / "measured.gif", frames=2).is_file()


@pytest.mark.parametrize(
    ("name", "options", "word"),
    [
        ("turn.avi", {}, "gif or .mp4"),
        ("turn.gif", {"frames": 1}, "2 frames"),
        ("turn.gif", {"fps": 0}, "1 to 50"),
    ],
)
def test_what_cannot_be_an_animation_is_refused(turn, tmp_path, name, options, word):
    with pytest.raises(DataError, match=word):
        turn.animate(tmp_path / name, **options)
    assert not list(tmp_path.iterdir())


def test_mp4_without_ffmpeg_says_how_to_get_it(turn, tmp_path, monkeypatch):
    monkeypatch.setenv("PATH", str(tmp_path))
    with pytest.raises(DataError, match="Install it"):
        turn.animate(tmp_path / "turn.mp4", frames=2)


@pytest.mark.skipif(sys.platform == "win32", reason="a script stands in for ffmpeg")
def test_no_program_that_lies_beside_the_data_is_run(turn, tmp_path, monkeypatch):
    (tmp_path / "ffmpeg").write_text("#!/bin/sh\ntouch run\n")
    (tmp_path / "ffmpeg").chmod(0o755)
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("PATH", f".:{tmp_path}")
    with pytest.raises(DataError, match="Install it"):
        turn.animate("turn.mp4", frames=2)
    assert [item.name for item in tmp_path.iterdir()] == ["ffmpeg"]


@pytest.mark.skipif(sys.platform == "win32", reason="a script stands in for ffmpeg")
@pytest.mark.parametrize(("status", "reads"), [(0, True), (1, True), (1, False)])
def test_ffmpeg_gets_whole_pictures_or_its_words_are_told(
    turn, tmp_path, monkeypatch, status, reads
):
    """A stand-in counts the bytes that it is given, in place of coding them; or ends at once."""
    tool = tmp_path / "bin" / "ffmpeg"
    tool.parent.mkdir()
    tool.write_text(
        f"#!{sys.executable}\nimport sys\n"
        f"size = len(sys.stdin.buffer.read()) if {reads} else 0\n"
        "width, height = map(int, sys.argv[sys.argv.index('-s') + 1].split('x'))\n"
        "open(sys.argv[-1], 'w').write(str(size / (3 * width * height)))\n"
        f"sys.stderr.write('no such codec')\nsys.exit({status})\n"
    )
    tool.chmod(tool.stat().st_mode | stat.S_IEXEC)
    monkeypatch.setenv("PATH", str(tool.parent))
    target = tmp_path / "turn.mp4"
    if status:
        with pytest.raises(DataError, match="no such codec"):
            turn.animate(target, frames=4)
        assert not target.exists()
    else:
        assert turn.animate(target, frames=4).read_text() == "4.0"


def test_the_command_writes_it_among_the_results(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    order = ["simulate", "kvlcc2-l7", "--speed", "1.179", "--no-figures", "--out", "out"]
    assert main([*order, "--animate", "sub/turn.gif"]) == 2
    assert "name a file alone" in capsys.readouterr().err
    assert not (tmp_path / "out").exists()
    assert main([*order, "--animate", "turn.gif"]) == 0
    assert (tmp_path / "out" / "turn.gif").read_bytes()[:4] == b"GIF8"
    assert (tmp_path / "out" / "forces.csv").read_text().startswith("t,X_derivatives,")
