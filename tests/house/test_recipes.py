"""The recipes of CONTRIBUTING.md work: their files make a package, their code and commands run."""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
PAGE = (ROOT / "CONTRIBUTING.md").read_text(encoding="utf-8")
RECIPES = dict(re.findall(r"^## (Add .*?)\n(.*?)(?=^## |\Z)", PAGE, re.S | re.M))
FILE = re.compile(r"^```\w+ file=(\S+)\n(.*?)^```", re.S | re.M)
CODE = re.compile(r"^```python\n(.*?)^```", re.S | re.M)
COMMAND = re.compile(r"^    pmmkit (.*)$", re.M)
TYPED = """
import sys
import pmmkit.views.report.drawn
from pmmkit.cli import main
pmmkit.views.report.drawn.svg = lambda figure: "<svg></svg>"
sys.exit(main(sys.argv[1:]))
"""
"""A command as it is typed, but for the pictures of its report, at which no recipe looks."""


@pytest.fixture
def folder(tmp_path):
    """A folder with a copy of the datasets, in which a recipe is followed: of the programme that
    recipes reduce the runs of one speed."""
    shutil.copytree(ROOT / "datasets", tmp_path / "datasets")
    campaign = tmp_path / "datasets" / "s175" / "campaign.toml"
    head, *runs = re.split(r"^(?=\[\[runs\]\]$)", campaign.read_text(encoding="utf-8"), flags=re.M)
    kept = [run for run in runs if "speed = 1.5\n" in run]
    assert 0 < len(kept) < len(runs)
    campaign.write_text(head + "".join(kept), encoding="utf-8")
    return tmp_path


def install(folder: Path) -> None:
    """What ``pip install .`` leaves of a package without dependencies: its entry points."""
    project = tomllib.loads((folder / "pyproject.toml").read_text(encoding="utf-8"))
    place = folder / "harbour-1.0.dist-info"
    place.mkdir()
    (place / "METADATA").write_text("Metadata-Version: 2.1\nName: harbour\nVersion: 1.0\n")
    lines = []
    for group, entries in project["project"]["entry-points"].items():
        lines += [f"[{group}]", *(f"{name} = {target}" for name, target in entries.items())]
    (place / "entry_points.txt").write_text("\n".join(lines))


def follow(text: str, folder: Path) -> None:
    for name, content in FILE.findall(text):
        path = folder / name
        path.parent.mkdir(exist_ok=True)
        path.write_text(content, encoding="utf-8")
    install(folder)
    code = CODE.findall(text)
    assert code
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join((str(folder), str(ROOT)))}
    commands = [
        ["-c", "\n".join(code)],
        *(["-c", TYPED, *x.split()] for x in COMMAND.findall(text)),
    ]
    for command in commands:
        done = subprocess.run(
            [sys.executable, "-W", "error::UserWarning", *command],
            cwd=folder,
            env=environment,
            capture_output=True,
            text=True,
            check=False,
        )
        assert done.returncode == 0, done.stderr


@pytest.mark.slow
@pytest.mark.parametrize("recipe", RECIPES)
def test_a_recipe_works(recipe, folder):
    follow(RECIPES[recipe], folder)


def test_a_recipe_that_does_not_work_is_noticed(folder):
    spoilt = RECIPES["Add a structure"].replace('"Yr|r|"', '"Y|r|r"')
    with pytest.raises(AssertionError, match=r"is written Yr\|r\|"):
        follow(spoilt, folder)


def test_there_is_a_recipe_for_every_group_of_entry_points():
    """A group is declared where its registry is, as ``GROUP``."""
    declared = {
        group
        for path in (ROOT / "pmmkit").rglob("*.py")
        for group in re.findall(r'^GROUP: Final = "(.*)"$', path.read_text(encoding="utf-8"), re.M)
    }
    used = {
        group
        for text in RECIPES.values()
        for group in re.findall(r'^\[project\.entry-points\."(.*)"\]$', text, re.M)
    }
    assert declared == used
