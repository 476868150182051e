"""What pmmkit says before anything is computed: first words, help, examples, completion, quiet."""

from __future__ import annotations

import json
import math
import os
import re
import shlex
import shutil
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import typer
from commands import said
from small_campaign import write_campaign

import pmmkit as pk
from pmmkit.actions import about, action, by_stage, jobs, names
from pmmkit.cli import app, main
from pmmkit.files import datasets_folder

NAMES = sorted(file.stem for file in Path(jobs.__path__[0]).glob("*.py") if file.stem != "__init__")
DEMO = "demo"
"""Its example is the command itself, which a test of its own runs."""
ZIGZAG = """
[[runs]]
id = "{name}"
test = "zigzag"
file = "{name}.csv"
speed = 1.179
rudder_deg = {rudder}
switch_deg = 10
"""


def example_of(name):
    return action(name.replace("_", "-")).example


def write_zigzags(folder):
    """Zigzags of the library's 7 m model, with the noise of sensors."""
    ship = pk.load_model("kvlcc2-l7").ship
    particulars = "".join(
        f"{key} = {getattr(ship, key)}\n" for key in ("L", "B", "d", "volume", "mass", "Izz", "xG")
    )
    text = f'[campaign]\nkind = "free-running"\n[ship]\nname = "model"\n{particulars}'
    text += "[water]\nrho = 1000.0\n"
    noise = {"x": 0.02, "y": 0.02, "psi": math.radians(0.1), "r": math.radians(0.05)}
    rng = np.random.default_rng(7)
    folder.mkdir()
    for rudder in (10, 20):
        track = pk.simulate("kvlcc2-l7", "zigzag", rudder_deg=rudder, speed=1.179, dt=0.5)
        columns = {key: getattr(track, key) + s * rng.normal(size=len(track))
                   for key, s in noise.items()}  # fmt: skip
        columns = {"t": track.t, **columns, "delta": track.delta, "n": track.n}
        table = np.column_stack(list(columns.values()))
        name = f"ZZ{rudder}"
        np.savetxt(folder / f"{name}.csv", table, delimiter=",", header=",".join(columns),
                   comments="")  # fmt: skip
        text += ZIGZAG.format(name=name, rudder=rudder)
    (folder / "campaign.toml").write_text(text, encoding="utf-8")


@pytest.fixture(scope="module")
def desk(tmp_path_factory):
    """A folder with what the examples name."""
    folder = tmp_path_factory.mktemp("desk")
    write_campaign(folder / "my-campaign")
    write_campaign(folder / "my-files")
    (folder / "my-files" / "campaign.toml").unlink()
    write_zigzags(folder / "my-zigzags")
    model = pk.load_model("s175-3dof")
    pk.save_model(model, folder / "model.toml")
    table = pk.reduce(pk.open_campaign(folder / "my-campaign"), structure="linear")
    pk.write_table(table, folder / "derivatives.csv")
    card = pk.Card.of("kcs", 12.35)
    turn = replace(card, tests=card.tests[:1])
    (folder / "card.toml").write_text(turn.text(), encoding="utf-8")
    return folder


@pytest.mark.slow
@pytest.mark.parametrize("name", [name for name in NAMES if name != DEMO])
def test_the_example_of_a_command_runs_as_it_is_typed(name, desk, monkeypatch, capsys):
    monkeypatch.chdir(desk)
    program, command, *arguments = shlex.split(example_of(name))
    assert (program, command) == ("pmmkit", name.replace("_", "-"))
    assert main([command, *arguments]) == 0, capsys.readouterr().err


def test_the_example_stands_in_the_help(capsys):
    for name in NAMES:
        assert main([name.replace("_", "-"), "--help"]) == 0
        text = " ".join(capsys.readouterr().out.split())
        assert f"Example: {example_of(name)}" in text
    assert example_of(DEMO).startswith("pmmkit demo")


def proposed(capsys):
    """The command that `pmmkit` alone proposes for the folder, if any."""
    assert main([]) == 2
    words = capsys.readouterr().err
    listed = set(typer.main.get_command(app.application()).commands)
    assert set(re.findall(r"^ .*?pmmkit ([a-z][a-z-]*)", words, re.MULTILINE)) <= listed
    found = re.search(r"^Here: .* Type:\n\n  (pmmkit .*)$", words, re.MULTILINE)
    return found[1] if found else None


def test_pmmkit_alone_says_what_to_type_next_for_what_is_there(tmp_path, monkeypatch, capsys):
    """Each command that it proposes is run, and what that leaves gets the next one."""
    monkeypatch.chdir(tmp_path)
    assert proposed(capsys) is None
    (tmp_path / "drift.csv").write_text("t,X,Y,N\n")
    assert proposed(capsys) == "pmmkit demo --my-data ."
    shutil.copytree(datasets_folder() / "s175", tmp_path / "s175")
    assert proposed(capsys) == "pmmkit check s175"
    assert main(["check", "s175"]) == 0
    (tmp_path / "s175-reduced").mkdir()
    (tmp_path / "s175-reduced" / "model.toml").write_text("")
    assert proposed(capsys) == f"pmmkit compare {Path('s175-reduced/model.toml')} s175"
    shutil.rmtree(tmp_path / "s175")
    assert proposed(capsys).startswith("pmmkit simulate")


def test_a_case_of_openfoam_is_seen(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "drift 4" / "constant").mkdir(parents=True)
    assert proposed(capsys) == 'pmmkit demo --my-data "drift 4"'


def test_the_list_of_commands_has_whole_sentences_in_the_order_of_the_work(capsys):
    assert main(["--help"]) == 0
    text = " ".join(capsys.readouterr().out.split())
    places = [text.index(f"{stage.capitalize()}: ") for stage in by_stage()]
    assert places == sorted(places)
    assert sorted(name for listed in by_stage().values() for name in listed) == sorted(names())
    for name in names():
        sentence = " ".join(about(name).split("\n\n")[0].split())
        assert sentence.endswith(".")
        assert f"{name} {sentence}" in text


@pytest.mark.parametrize(
    ("typed", "meant"), [("simulat", "simulate"), ("reduse", "reduce"), ("diagnos", "diagnose")]
)
def test_a_command_that_is_mistyped_is_guessed(typed, meant, capsys):
    assert main([typed]) == 2
    assert f"'{meant}'" in capsys.readouterr().err


def test_quiet_leaves_only_results_and_errors(tmp_path, capsys):
    order = ["simulate", "kvlcc2-l7", "--speed", "1.179", "--no-figures", "--quiet", "--out"]
    for _ in range(2):
        assert main([*order, str(tmp_path / "turn")]) == 0
    captured = capsys.readouterr()
    assert (captured.out, captured.err) == ("", "")
    assert (tmp_path / "turn" / "metrics.json").exists()
    status, content, words = said(capsys, *order, tmp_path / "turn")
    assert (status, words) == (0, "")
    assert content["files"] == ["metrics.json", "track.csv"]
    assert main(["simulate", "kvlcc3", "--speed", "1.179", "-q"]) == 1
    assert "kvlcc3" in capsys.readouterr().err


def test_every_command_can_be_quiet():
    for command in typer.main.get_command(app.application()).commands.values():
        assert "--quiet" in [name for item in command.params for name in item.opts]


def completed(**environment):
    """What the command says to a shell."""
    return subprocess.run(
        [sys.executable, "-m", "pmmkit", *environment.pop("arguments", ())],
        capture_output=True,
        text=True,
        check=True,
        env={**os.environ, **environment},
    ).stdout


@pytest.mark.slow
@pytest.mark.parametrize(
    ("shell", "sign"),
    [
        ("bash", "complete -o default -F _pmmkit_completion pmmkit"),
        ("zsh", "#compdef pmmkit"),
        ("fish", "complete --command pmmkit"),
        ("powershell", "Register-ArgumentCompleter"),
    ],
)
def test_each_shell_gets_its_completion(shell, sign):
    assert sign in completed(_PMMKIT_COMPLETE=f"source_{shell}")


@pytest.mark.slow
def test_a_shell_completes_commands_and_options():
    asked = {"_PMMKIT_COMPLETE": "complete_bash"}
    assert completed(**asked, COMP_WORDS="pmmkit sim", COMP_CWORD="1").split() == ["simulate"]
    options = completed(**asked, COMP_WORDS="pmmkit simulate kvlcc2 --sp", COMP_CWORD="3")
    assert options.split() == ["--speed"]


def test_json_stays_the_last_option_and_the_same(capsys):
    assert main(["ships", "--json"]) == 0
    assert [*json.loads(capsys.readouterr().out)] == ["ships"]
