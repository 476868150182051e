"""Speeds as people type them, and of which ship they are."""

from __future__ import annotations

import itertools
import math

import pytest
from commands import said
from hypothesis import given
from hypothesis import strategies as st

from pmmkit.actions import SettingError
from pmmkit.actions.speeds import typed, typed_list
from pmmkit.cli import main
from pmmkit.models import load_model, save_model

KNOT = 1852 / 3600
"""International knot [m/s]."""
L7, G = 7.0, 9.81


def metres(text):
    model = load_model("kvlcc2-l7")
    return typed(text).of(model.ship, model.water)


@pytest.mark.parametrize(
    ("text", "speed"),
    [
        *((text, 8.0) for text in ("8", "8.0", "8 m/s", "8m/s", "8.0 M/S", "8e0")),
        *((text, 15.5 * KNOT) for text in ("15.5 kn", "15.5kn", "15.5 knots", "15.5 kN")),
        ("1 knot", KNOT),
        ("18 km/h", 5.0),
        *((text, 0.2 * math.sqrt(G * L7))
          for text in ("Fn 0.2", "Fn=0.2", "fn = .2", "FN0.2", "0.2 Fn")),
    ],
)  # fmt: skip
def test_a_speed_is_read_as_it_is_typed(text, speed):
    assert metres(text) == pytest.approx(speed, rel=1e-12)


@given(st.floats(0.01, 30.0), st.sampled_from(["{} kn", "{}knots", "{} m/s", "Fn {}", "fn={}"]))
def test_any_number_goes_through_every_way(number, way):
    assert typed(way.format(number)).value == number


@pytest.mark.parametrize("text", ["fast", "8 kg", "8 kn/h", "15,5 kn", "Fn 0.2 kn", "", "kn"])
def test_what_is_no_speed_is_said_with_what_is(text):
    with pytest.raises(SettingError, match=r"'15\.5 kn' or 'Fn 0\.2'"):
        typed(text)


@pytest.mark.parametrize(
    ("text", "units"),
    [("6,9,12", ["", "", ""]), ("6 9", ["", ""]), ("10,12,15 kn", ["kn"] * 3),
     ("Fn 0.1, 0.15", ["fn", "fn"]), ("8 m/s;15 kn", ["m/s", "kn"])],
)  # fmt: skip
def test_a_unit_that_stands_once_is_that_of_all(text, units):
    assert [speed.unit for speed in typed_list(text)] == units


def test_some_speeds_without_a_unit_are_refused():
    with pytest.raises(SettingError, match="once for all"):
        typed_list("10 kn, 12 kn, 6")


COMMANDS = {
    "simulate": ("simulate", "{model}", "--no-figures"),
    "stability": ("stability", "{model}"),
    "imo": ("imo", "{model}", "--ships", "0"),
    "uncertainty": ("uncertainty", "{model}", "--spread", "0.05", "--ships", "2"),
    "export": ("export", "{model}", "--to", "mss"),
    "sweep": ("sweep", "{model}"),
}
WAYS = ("1.1702", "1.1702 m/s", "2.2747 kn", "Fn 0.1423", "Fn=0.14122")


@pytest.fixture
def at_one_speed(tmp_path, monkeypatch):
    """A model whose tests were made at one Froude number."""
    monkeypatch.chdir(tmp_path)
    model = load_model("kvlcc2-l7")
    hull = {name: (value,) for name, value in model.part("hull_polynomial").values.items()}
    save_model(model.with_(Fn=(0.1423,)).with_values("hull_polynomial", **hull), "one.toml")
    return "one.toml"


@pytest.mark.parametrize("command", COMMANDS)
def test_a_model_of_one_froude_number_sails_there_however_it_is_typed(
    command, at_one_speed, capsys
):
    option = "--speeds" if command == "sweep" else "--speed"
    order = [part.format(model=at_one_speed) for part in COMMANDS[command]]
    for way in WAYS if command == "simulate" else WAYS[-2:]:
        assert main([*order, option, way, "--quiet"]) == 0, capsys.readouterr().err
    assert main([*order, option, "Fn 0.16"]) == 1
    words = capsys.readouterr().err
    assert "Fn 0.16 (1.326 m/s) is outside" in words


def test_the_speed_in_json_stays_a_number_in_metres_per_second(tmp_path, capsys):
    found = [
        said(capsys, "simulate", "kvlcc2", "--speed", way, "--no-figures", "--out", tmp_path / "t")[
            1
        ]
        for way in ("7.97", "7.97 m/s")
    ]
    assert found[0] == found[1]
    assert found[0]["speed"] == 7.97


def test_scale_takes_the_froude_number_of_the_ship_at_its_new_length(tmp_path, capsys):
    speed = 0.1423 * math.sqrt(9.81 * 320.0)
    texts = []
    for name, way in (("a", repr(speed)), ("b", "Fn 0.1423")):
        out = tmp_path / name
        assert (
            main(["scale", "kvlcc2-l7", "--length", "320", "--speed", way, "--out", str(out)]) == 0
        )
        texts.append((out / "model.toml").read_text())
    capsys.readouterr()
    assert texts[0] == texts[1]


def test_wind_takes_knots_and_no_froude_number(tmp_path, capsys):
    order = ["simulate", "kvlcc2", "--speed", "8", "--no-figures", "--out", tmp_path / "w"]
    by_knots, by_metres = (
        said(capsys, *order, "--current-speed", way)[1] for way in ("1 kn", repr(KNOT))
    )
    assert by_knots == by_metres
    assert main([*map(str, order), "--current-speed", "Fn 0.1"]) == 2


def test_help_and_words_say_of_which_ship_and_scale_the_speed_is(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    for command, order in itertools.islice(COMMANDS.items(), 4):
        assert main([command, "--help"]) == 0
        assert "at the model's own scale" in " ".join(capsys.readouterr().out.split())
        parts = [part.format(model="kvlcc2-l7") for part in order]
        assert main([*parts, "--speed", "1.179"]) == 0
        assert "model scale, L = 7 m" in capsys.readouterr().out
