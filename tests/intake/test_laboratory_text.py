"""Folders of laboratory text: what names, headers and records say agrees, and nobody is blamed."""

from __future__ import annotations

import re
import tomllib
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import text_tank
from text_tank import LABORATORIES, PARTICULARS, TRUTH, Course, Test, record

import pmmkit as pk
from pmmkit.cli import main
from pmmkit.conventions import Structure
from pmmkit.intake import questions_of
from pmmkit.intake.drafts.motion import motion_facts
from pmmkit.intake.guessing import suggest
from pmmkit.reduction import reduce_campaign
from pmmkit.signals import head_rest

OWN = Structure(name="little hull", derivatives=tuple(TRUTH))


def drafted(folder: Path, capsys) -> str:
    """The draft of a folder, as a person who types no option gets it."""
    assert main(["new-campaign", str(folder), "--quiet"]) == 0
    capsys.readouterr()
    return (folder / "campaign.toml").read_text(encoding="utf-8")


def filled(folder: Path, text: str) -> int:
    """What a person types: numbers of the hull, in the places that ask; how many lines."""
    lines = 0
    for key, value in PARTICULARS.items():
        text, count = re.subn(rf"(?m)^# {key} = .*$", f"{key} = {value}", text, count=1)
        lines += count
    (folder / "campaign.toml").write_text(text, encoding="utf-8")
    return lines


def settings(raw: dict, run: dict) -> dict:
    """What holds of a run: its own lines, those of its kind, those of all."""
    shared = raw["defaults"]
    plain = {key: value for key, value in shared.items() if not isinstance(value, dict)}
    return {**plain, **shared.get(run["test"], {}), **run}


@pytest.mark.parametrize("name", LABORATORIES)
def test_a_draft_says_what_was_done(name, tmp_path, capsys):
    """Kind, speed, angles, period and amplitudes of all runs; the hull is asked, not the tests."""
    tests = text_tank.write(tmp_path / "c", LABORATORIES[name])
    text = drafted(tmp_path / "c", capsys)
    raw = tomllib.loads(text)
    assert raw["campaign"]["forces"] == "balance"
    assert {x["file"] for x in raw["runs"]} == {*tests}
    for run in raw["runs"]:
        true, said = tests[run["file"]], settings(raw, run)
        assert said["test"] == ("static_drift" if true.kind == "drift" else f"pure_{true.kind}")
        assert said["speed"] == pytest.approx(true.speed, rel=0.003)
        assert said["tare"] is True
        for key, value in (
            ("drift_deg", true.drift if true.kind == "drift" else None),
            ("amplitude_m", true.sway or None),
            ("yaw_amplitude_deg", true.heading or None),
            ("period", true.period or None),
        ):
            assert said.get(key) == (value if value is None else pytest.approx(value, rel=0.001))
    needed = [item.key for item in questions_of(text) if item.kind == "needed"]
    assert needed == ["ship.L", "ship.B", "ship.d", "ship.mass", "ship.Izz"]
    asked = {item.key for item in questions_of(text)} - {*needed}
    assert asked == {"water.rho", "campaign.moment_reference_x", "campaign.free", "ship.name",
                     "ship.xG"}  # fmt: skip


LISTS = {
    "ship.csv": ("Item,Value,Unit", "{name},{value},{unit}", ".", "mm"),
    "particulars.txt": ("", "{name}\t{value} {unit}", ".", "m"),
    "Hauptdaten.csv": ("Größe;Wert;Einheit", "{name};{value};{unit}", ",", "m"),
}
"""Head, row, decimal sign and unit of length of lists of particulars."""


@pytest.mark.parametrize("file", LISTS)
def test_what_a_list_beside_the_records_states_is_not_asked(file, tmp_path, capsys):
    """Length in mm and mass in t among them; the list is no run, and a draft says its rows."""
    text_tank.write(tmp_path / "c", LABORATORIES[next(iter(LABORATORIES))])
    head, row, decimal, length = LISTS[file]
    units = {"L": length, "B": "m", "d": "m", "mass": "t", "Izz": "kgm2"}
    sizes = {"mm": 1e3, "t": 1e-3}
    names = {"L": "Lpp", "d": "Draught"}
    rows = [
        row.format(
            name=names.get(key, key),
            value=f"{PARTICULARS[key] * sizes.get(unit, 1.0):.10g}".replace(".", decimal),
            unit=unit,
        )
        for key, unit in units.items()
    ]
    (tmp_path / "c" / file).write_text("\n".join([*([head] if head else []), *rows]) + "\n")
    text = drafted(tmp_path / "c", capsys)
    raw = tomllib.loads(text)
    told = {key: raw["ship"].get(key) for key in units}
    assert told == {key: pytest.approx(PARTICULARS[key], rel=1e-3) for key in units}
    assert f"{file}: Lpp = " in text
    assert not [item.key for item in questions_of(text) if item.kind == "needed"]
    assert all(run["file"] != file for run in raw["runs"])


PROSE = {
    "README.md": "# Tests\n\nTank: h/T 13.2. Ship: hull T530, Lpp {L} m, B {B}, d {d},\n"
    "CB .8, LCG +3.5 % Lpp, "
    "mass {mass} kg, Izz {Izz} kg m2 (izz/Lpp .25), n 9.9 rps. Lpp 6.1 m elsewhere.\n",
    "ship.md": "| item | value | unit |\n|---|---|---|\n| Lpp | {L} | m |\n| **B** | {B} | m |\n"
    "| T | {d} | m |\n| mass | {mass} | kg |\n| Izz | {Izz} | kg m2 |\n",
    "notes.txt": "The model has a length between perpendiculars of {L} m.\nIts breadth is {B} m "
    "and its draught {d} m;\nmodel mass = {mass} kg.\nIzz: {Izz}\n",
}


@pytest.mark.parametrize("file", PROSE)
def test_what_a_text_beside_the_records_says_is_not_asked(file, tmp_path, capsys):
    """Sentences and tables between bars; a centre of gravity in per cent is no length."""
    text_tank.write(tmp_path / "c", LABORATORIES[next(iter(LABORATORIES))])
    (tmp_path / "c" / file).write_text(PROSE[file].format(**PARTICULARS))
    text = drafted(tmp_path / "c", capsys)
    raw = tomllib.loads(text)
    told = {key: raw["ship"].get(key) for key in ("L", "B", "d", "mass", "Izz", "xG")}
    known = {key: pytest.approx(PARTICULARS[key], rel=1e-3) for key in told if key != "xG"}
    assert told == {**known, "xG": None}
    assert f"{file}: " in text
    assert ", line " in text
    assert not [item.key for item in questions_of(text) if item.kind == "needed"]


def test_a_text_in_which_letters_are_no_ship_is_not_believed(tmp_path, capsys):
    text_tank.write(tmp_path / "c", LABORATORIES[next(iter(LABORATORIES))])
    (tmp_path / "c" / "README.md").write_text("Lpp 7 m in tank B 2 of d.o.o.; T is 12 s.\n")
    needed = [x.key for x in questions_of(drafted(tmp_path / "c", capsys)) if x.kind == "needed"]
    assert "ship.L" in needed


@pytest.mark.slow
@pytest.mark.parametrize("name", LABORATORIES)
def test_no_laboratory_is_accused_and_the_truth_comes_out(name, tmp_path, capsys):
    text_tank.write(tmp_path / "c", LABORATORIES[name])
    assert filled(tmp_path / "c", drafted(tmp_path / "c", capsys)) == 6
    campaign = pk.open_campaign(tmp_path / "c")
    found = [item for item in pk.examine(campaign) if item.severity != "info"]
    assert not found, [item.message for item in found]
    table = reduce_campaign(campaign, structure=OWN, fn="pooled", check=False).table
    off = [(table[x][0] - TRUTH[x]) / table.std[0][table.index(x)] for x in TRUTH]
    off = [float(size) for size in off if np.isfinite(size)]
    assert len(off) >= 16
    assert max(map(abs, off)) < 4.0
    assert np.sqrt(np.mean(np.square(off))) < 1.7


def test_the_ramp_is_told_beside_what_comes_after_it(tmp_path, capsys):
    """0.25 m stand in the name; fitted over the ramps the record shows 0.17 m."""
    text_tank.write(tmp_path / "c", LABORATORIES["froude"])
    text = drafted(tmp_path / "c", capsys)
    (line,) = re.findall(r"amplitude_m = 0.25 .*", text)
    said = re.search(
        r"a0.25m in the name; recorded y after the ramp, ([.0-9]+) over it: ([.0-9]+)", line
    )
    assert said is not None, line
    assert float(said[1]) < 0.2
    assert float(said[2]) == pytest.approx(0.25, rel=1e-3)
    assert "which is right" not in text


def test_a_header_that_contradicts_its_record_is_asked(tmp_path, capsys):
    """One file says 0.3 m above its columns and swings by 0.25 m; all else agrees."""
    tests = text_tank.write(tmp_path / "c", LABORATORIES["headed"])
    (file,) = (name for name, test in tests.items() if test.sway == 0.25)
    path = tmp_path / "c" / file
    path.write_text(path.read_text().replace("# Sway amplitude: 0.25 m", "# Sway amplitude: 0.3 m"))
    asked = re.findall(r"TODO (.*which is right.*)", drafted(tmp_path / "c", capsys))
    assert asked == ["the header says 0.3, the record (recorded y) 0.25: which is right?"]


def test_a_point_that_a_name_leaves_out_is_put_where_the_record_has_it(tmp_path, capsys):
    """U12 and A025 are 1.2 m/s and 0.25 m; an angle ten times another one is asked."""
    tests = text_tank.write(tmp_path / "c", LABORATORIES["numbered"])
    for file in tests:
        (tmp_path / "c" / file).rename(tmp_path / "c" / re.sub(r"(?<=[AU]\d)\.", "", file))
    text = drafted(tmp_path / "c", capsys)
    assert "which is right" not in text
    assert tomllib.loads(text)["defaults"]["speed"] == 1.2
    assert re.search(r"amplitude_m = 0.25 +# A025 in the name", text)
    (tmp_path / "c" / "V416_drift_6deg_U12.txt").rename(tmp_path / "c" / "V416_drift_60deg_U12.txt")
    (tmp_path / "c" / "campaign.toml").unlink()
    assert "the name says 60, the record" in drafted(tmp_path / "c", capsys)


def test_a_title_that_names_all_tests_names_none(tmp_path, capsys):
    """The record says what was done, though each file speaks of sway above its columns."""
    lab = replace(LABORATORIES["headed"], head=lambda _: ["Tank 2, sway tests", "Test no.: 4"])
    tests = text_tank.write(tmp_path / "c", lab)
    raw = tomllib.loads(drafted(tmp_path / "c", capsys))
    for run in raw["runs"]:
        kind = tests[run["file"]].kind
        assert run["test"] == ("static_drift" if kind == "drift" else f"pure_{kind}")


def test_a_phase_that_nobody_recorded_is_asked_before_a_run_is_blamed(tmp_path, capsys):
    """Amplitude and period stand in the name, but when the swing began stands nowhere."""
    text_tank.write(tmp_path / "c", LABORATORIES["numbered"], without=("y", "psi"))
    text = drafted(tmp_path / "c", capsys)
    (phase,) = (item for item in questions_of(text) if item.key == "runs.phase_deg")
    assert (phase.kind, len(phase.lines)) == ("needed", 6)
    assert "not recorded" in phase.text


def test_a_name_that_contradicts_its_header_is_asked(tmp_path, capsys):
    tests = text_tank.write(tmp_path / "c", LABORATORIES["headed"])
    (file,) = (name for name, test in tests.items() if test.drift == 8)
    (tmp_path / "c" / file).rename(tmp_path / "c" / "drift_b+06.csv")
    (asked,) = re.findall(r"TODO (the name says.*)", drafted(tmp_path / "c", capsys))
    assert "the name says 6, the header ('Drift angle: 8 deg' in the header) 8, the record" in asked


@pytest.mark.parametrize("carriage", [True, False])
@pytest.mark.parametrize("late", [0.0, 3.0])
@pytest.mark.parametrize("rise", [4.0, 9.0])
@pytest.mark.parametrize("period", [9.0, 13.0])
@pytest.mark.parametrize("cycles", [2.5, 3.5])
def test_ramps_and_rest_do_not_enter_amplitude_and_period(cycles, period, rise, late, carriage):
    for test, key, size in (
        (Test(kind="sway", speed=1.2, sway=0.25, period=period), "amplitude_m", 0.25),
        (Test(kind="yaw", speed=1.2, heading=15.0, period=period), "yaw_amplitude_deg", 15.0),
    ):
        made = record(test, Course(cycles=cycles, rise=rise, late=late), finer=1)
        seen = {"y": made["y"], "psi": made["psi"]}
        if carriage:
            seen["U_carriage"] = made["carriage"]
        found = motion_facts(made["t"], seen, None)
        assert found.test == f"pure_{test.kind}"
        assert found.settings[key][0] == pytest.approx(size, rel=0.005)
        assert found.settings["period"][0] == pytest.approx(period, rel=0.005)


def test_the_path_of_a_yaw_test_gives_its_speed():
    """The hull points along its path: what it goes aside is the carriage's speed times tan ψ."""
    made = record(Test(kind="yaw", speed=1.37, heading=12.0, period=9.0), Course())
    found = motion_facts(made["t"], {"y": made["y"], "psi": made["psi"]}, "pure_yaw")
    assert found.settings["speed"][0] == pytest.approx(1.37, rel=0.002)
    other = motion_facts(made["t"], {"y": made["y"][::-1], "psi": made["psi"]}, "pure_yaw")
    assert "speed" not in other.settings, "a path that does not follow the heading"


def test_a_speed_that_follows_from_the_yaw_tests_is_not_asked(tmp_path, capsys):
    tests = text_tank.write(tmp_path / "c", LABORATORIES["numbered"], without=("carriage",))
    for file in tests:
        (tmp_path / "c" / file).rename(tmp_path / "c" / file.replace("_U1.2", ""))
    text = drafted(tmp_path / "c", capsys)
    raw = tomllib.loads(text)
    assert raw["defaults"]["speed"] == pytest.approx(1.2, rel=0.002)
    assert raw["campaign"]["forces"] == "balance"
    (speed,) = (item for item in questions_of(text) if item.key == "defaults.speed")
    assert (speed.kind, speed.why) == ("guessed", "path and heading of yaw, 3 runs")


@pytest.mark.parametrize("seconds", [0.8, 1.0, 2.0])
@pytest.mark.parametrize("kind", ["drift", "sway", "yaw"])
def test_a_short_rest_is_the_rest_of_a_carriage_that_is_recorded(kind, seconds):
    """Without the carriage's speed a second is too short to be told from a slow swing."""
    test = Test(kind=kind, speed=1.2, **{
        "drift": {"drift": -8.0}, "sway": {"sway": 0.25, "period": 9.0},
        "yaw": {"heading": 15.0, "period": 9.0},
    }[kind])  # fmt: skip
    made = record(test, Course(rest=seconds, rate=100.0), finer=1)
    dice = np.random.default_rng(4)
    zero = np.array([1.7, -2.3, 0.9])
    noise = np.array([0.15, 0.4, 0.5])[:, None] * dice.standard_normal((3, made["t"].size))
    shown = np.stack([made[name] for name in "XYN"]) + zero[:, None] + noise
    motion = {"U_carriage": made["carriage"], "y": made["y"], "psi": made["psi"]}
    found = head_rest(made["t"], shown, motion=motion)
    assert found is not None
    assert 0.6 * seconds < found.duration <= seconds
    assert np.all(np.abs(found.value - zero) < 4 * found.std)
    late = slice(round(100 * seconds), None)
    moving = {name: values[late] for name, values in motion.items()}
    assert head_rest(made["t"][late], shown[:, late], motion=moving) is None


def test_a_tare_is_not_advised_where_a_record_begins_on_the_way(tmp_path, capsys):
    """Of one file the rest was cut off: it is not tared, and what is advised is not refused."""
    tests = text_tank.write(tmp_path / "c", LABORATORIES["numbered"])
    file = next(iter(tests))
    path = tmp_path / "c" / file
    lines = path.read_text().splitlines()
    path.write_text("\n".join([*lines[:2], *lines[2 + 20 * 10 :]]) + "\n")
    text = drafted(tmp_path / "c", capsys)
    filled(tmp_path / "c", text)
    campaign = pk.open_campaign(tmp_path / "c")
    tared = {run.id for run in campaign if "tared" in run.data.attrs}
    assert tared == {run.id for run in campaign} - {Path(file).stem}
    (tmp_path / "c" / "campaign.toml").write_text(
        re.sub("(?m)^tare = .*$", "", (tmp_path / "c" / "campaign.toml").read_text())
    )
    (rest,) = (x for x in pk.examine(pk.open_campaign(tmp_path / "c")) if x.check == "rest")
    assert "tare = true of each of these runs" in rest.remedy
    assert set(rest.runs) == tared


@pytest.mark.parametrize(
    "header",
    ["carriage", "V_carriage", "v_Schlepp", "Vc", "Schleppwagen", "Tow speed", "U_tow", "vWagen"],
)
def test_the_speed_of_the_carriage_has_many_names(header):
    (found,) = suggest([header], ["m/s"], {})
    assert found is not None
    assert (found.name, found.certainty) == ("U_carriage", "probably")


def test_a_letter_alone_that_stays_at_one_value_is_the_carriage():
    t = np.arange(0.0, 60.0, 0.1)
    towed, swung = 1.2 * np.clip((t - 3.0) / 5.0, 0.0, 1.0), 0.2 * np.sin(t)

    def names(**columns: np.ndarray) -> list[str | None]:
        values = dict(enumerate(columns.values()))
        found = suggest(list(columns), ["m/s"] * len(columns), values)
        return [item.name if item else None for item in found]

    assert names(V=towed) == names(U=towed) == names(Vm=towed) == ["U_carriage"]
    assert names(V=swung) == ["v"]
    assert names(u=towed) == ["u"]
    assert names(U=towed, V=swung) == ["u", "v"]
