"""Errors speak of arguments in Python and of options on the console, from one description."""

from __future__ import annotations

import ast
import pickle
import re
import shutil
from pathlib import Path

import pytest
import typer
from commands import said
from small_campaign import write_campaign

import pmmkit as pk
from pmmkit.base import DataError, Problem, Remedy, Way
from pmmkit.cli import app, main

ROOT = Path(pk.__file__).parent
SOURCES = [path for path in sorted(ROOT.rglob("*.py")) if "cli" not in path.parts]
ARGUMENT = re.compile(
    r"\b(?!style)[a-z_]{3,}=(?:True|False|\"|'|…|\{|\))|\bpmmkit\.[a-z]+_[a-z_]+\b"
)


def calls(tree, name):
    return [
        node
        for node in ast.walk(tree)
        if isinstance(node, ast.Call) and ast.unparse(node.func) == name
    ]


def test_a_problem_is_said_in_the_words_of_who_reads_it():
    remedy = Remedy(
        "Say {} or {}.", (Way.setting("missing", "zero"), Way.setting("no_figures", True))
    )
    error = DataError([Problem(message="no Yv.", remedy=remedy), "no Nv."], title="Not made")
    assert 'no Yv. Say missing="zero" or no_figures=True.' in str(error)
    assert "no Yv. Say --missing zero or --no-figures." in error.said("command")
    assert pickle.loads(pickle.dumps(error.problems)) == error.problems


def test_every_option_that_an_error_names_is_one_of_a_command():
    commands = typer.main.get_command(app.application()).commands.values()
    known = {option for item in commands for part in item.params for option in part.opts}
    named = set()
    for path in SOURCES:
        text = path.read_text(encoding="utf-8")
        if "Way.setting(" not in text and "Way(" not in text:
            continue
        tree = ast.parse(text)
        for call in calls(tree, "Way.setting"):
            if isinstance(call.args[0], ast.Constant):
                named.add(f"--{call.args[0].value.replace('_', '-')}")
        for call in calls(tree, "Way"):
            named |= set(re.findall(r"--[a-z-]+", ast.unparse(call)))
    assert {"--data", "--missing", "--spread"} <= named
    assert named <= known


@pytest.mark.slow
def test_no_text_but_a_way_names_an_argument_of_python():
    """Docstrings apart: what reaches the console must not tell of Python."""
    told = []
    for path in SOURCES:
        if path.parts[-2] in ("testing", "equations"):  # not said to who types commands
            continue
        if path.name in ("html.py", "vector.py"):  # attributes of HTML and SVG look like arguments
            continue
        text = path.read_text(encoding="utf-8")
        if not ARGUMENT.search(text):
            continue
        tree = ast.parse(text)
        apart = {id(item) for call in calls(tree, "Way") for item in ast.walk(call)}
        for node in ast.walk(tree):
            if isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant):
                apart.add(id(node.value))
            texts = [node] if isinstance(node, ast.Constant) else []
            told += [
                f"{path.relative_to(ROOT)}:{item.lineno}: {item.value!r}"
                for item in texts
                if isinstance(item.value, str) and id(item) not in apart
                if " " in item.value and ">" not in item.value and ARGUMENT.search(item.value)
            ]
    assert told == []


@pytest.fixture(scope="module")
def drawer(tmp_path_factory):
    folder = tmp_path_factory.mktemp("drawer")
    write_campaign(folder / "small")
    write_campaign(folder / "torn")
    next((folder / "torn" / "runs").iterdir()).unlink()
    model = pk.load_model("s175-3dof")
    parts = {name: part for name, part in model.parts.items() if name != "propeller"}
    pk.save_model(model, folder / "ship.toml")
    pk.save_model(model.with_(parts=parts), folder / "hull.toml")
    hull = {name: (value, value) for name, value in model.part("hull_polynomial").values.items()}
    wide = model.with_(Fn=(0.1, 0.2)).with_values("hull_polynomial", **hull)
    pk.save_model(wide, folder / "wide.toml")
    pk.save_campaign(pk.open_campaign(folder / "small"), folder / "small.h5")
    shutil.copy(folder / "small.h5", folder / "odd.toml")
    return folder


@pytest.fixture
def desk(drawer, monkeypatch):
    monkeypatch.chdir(drawer)
    monkeypatch.delenv("PMMKIT_DATA", raising=False)
    return drawer


@pytest.mark.parametrize(
    ("order", "words"),
    [
        ("imo hull.toml --speed 8", "pmmkit model replace MODEL PART --from SHIP"),
        ("uncertainty ship.toml --speed 8", "(--spread 0.05)"),
        ("check torn", "--data or PMMKIT_DATA names the folder"),
        ("export wide.toml --to mss", "such as --speed 8"),
        ("simulate small/campaign.toml --speed 8", "where a command asks for a campaign"),
        ("check ship.toml", "where a command asks for a model"),
    ],
)
def test_the_console_speaks_of_options(order, words, desk, capsys):
    status, content, printed = said(capsys, *order.split())
    assert status == 1
    for text in (printed, content["error"]["message"]):
        assert words in text
        assert not ARGUMENT.search(text)
    assert any(words in (item["remedy"] or "") for item in content["error"]["problems"])


def test_python_speaks_of_arguments(desk):
    with pytest.raises(pk.PmmkitError, match=r"to_model\(table, parts="):
        pk.simulate("hull.toml", speed=8.0)
    with pytest.raises(pk.PmmkitError, match=r"spread=0\.05"):
        pk.monte_carlo("ship.toml", "turning", speed=8.0, n=2)


def test_the_wrong_kind_of_file_is_told_with_who_reads_it(desk):
    for path in ("small/campaign.toml", "small"):
        with pytest.raises(pk.PmmkitError, match=r"a campaign file\. pmmkit\.open_campaign"):
            pk.load_campaign(path)
    with pytest.raises(pk.PmmkitError, match=r"a model file\. pmmkit\.load_model"):
        pk.load_campaign("ship.toml")
    with pytest.raises(pk.PmmkitError, match=r"a model file\. pmmkit\.load_model"):
        pk.open_campaign("ship.toml")
    with pytest.raises(pk.PmmkitError, match=r"a campaign file\. pmmkit\.open_campaign"):
        pk.load_model("small/campaign.toml")
    assert len(pk.open_campaign("small.h5")) == len(pk.load_campaign("small.h5"))
    with pytest.raises(pk.PmmkitError, match=r"HDF5 file .* call it odd\.h5"):
        pk.open_campaign("odd.toml")


def test_a_damaged_toml_is_still_not_a_saved_campaign(tmp_path, capsys):
    (tmp_path / "cut.toml").write_text("[campaign\n")
    with pytest.raises(pk.PmmkitError, match="cannot be read as a campaign"):
        pk.load_campaign(tmp_path / "cut.toml")
    assert main(["check", str(tmp_path / "cut.toml")]) == 1
    assert "not valid TOML" in capsys.readouterr().err
