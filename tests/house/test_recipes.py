"""The recipes of CONTRIBUTING.md work: their files make a package, their code and commands run."""

from __future__ import annotations

import hashlib
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
FILE = re.compile(r"^```\w+ file=(\S+)[^\n]*\n(.*?)^```", re.S | re.M)
OWN = re.compile(r"^```python (?:file=\S+ )?own=(\S+)\n(.*?)^```", re.S | re.M)
CHANGE = re.compile(r"^```diff change=(\S+)\n(.*?)^```", re.S | re.M)
END = re.compile(r"^```python own-end\n(.*?)^```", re.S | re.M)
TEST = re.compile(r"^```python test=(\S+)\n(.*?)^```", re.S | re.M)
PAGES_CHANGED = re.compile(r"It changes\s+`(docs/[a-z_.]+)`")
CODE = re.compile(r"^```python\n(.*?)^```", re.S | re.M)
COMMAND = re.compile(r"^    pmmkit (.*)$", re.M)
TYPED = """
import sys
from pmmkit.cli import main
sys.exit(main(sys.argv[1:]))
"""
"""A command as it is typed."""


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
@pytest.mark.parametrize("recipe", [name for name, text in RECIPES.items() if FILE.search(text)])
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


# The same in pmmkit itself: in a copy, each recipe's own file is all that a person adds.

ADDED = {
    "Add an effect": ("effects/test_contract.py::test_every_effect_of_the_catalogue[skeg]",),
    "Add a reader": (
        "readers/test_reader_contract.py::test_every_reader_keeps_its_word[harbour-logger]",
        "readers/test_reader_contract.py::test_no_reader_is_left_out",
        "readers/test_reader_contract.py::test_the_documentation_lists_all_formats",
        "readers/test_reader_contract.py::"
        "test_a_format_that_is_not_there_is_refused_with_those_that_are",
    ),
    "Add a manoeuvre": (
        "simulation/test_manoeuvre_contract.py::test_every_manoeuvre_holds_its_contract[kick]",
    ),
    "Add a kind of test": (
        "campaigns/test_test_kinds.py::test_every_kind_holds_the_contract[heeled_drift]",
    ),
    "Add a kind of test with a setting of its own": (
        "campaigns/test_test_kinds.py::test_every_kind_holds_the_contract[forced_roll]",
        "campaigns/test_run_settings.py",
        "campaigns/test_settings_in_words.py",
        "campaigns/test_repeats.py",
    ),
    "Add a check": ("intake/test_checks_ship.py",),
    "Add a statistic of the comparison": (
        "validation/test_statistics.py",
        "workbench/test_pages.py::test_console_file_and_page_tell_the_same_statistics",
    ),
    "Add a setting of a command": (
        "actions/test_settings.py",
        "cli/test_help_and_examples.py::test_a_shell_completes_commands_and_options",
    ),
}
"""Tests over the registry of each recipe, which must hold with the entry in it."""
OF_ALL = (
    "house/test_docs.py::"
    "test_every_key_of_the_campaign_file_says_what_it_means_and_stands_in_its_page",
    "house/test_names.py",
)


@pytest.fixture(scope="module")
def copy(tmp_path_factory):
    """A copy of the repository to which every recipe has added its file, and what changed in it."""
    place = tmp_path_factory.mktemp("copy")
    for name in ("pmmkit", "tests", "docs", "scripts", "datasets"):
        without = shutil.ignore_patterns("__pycache__", "kept", "images")
        shutil.copytree(ROOT / name, place / name, ignore=without)
    for name in ("pyproject.toml", "README.md", "CONTRIBUTING.md"):
        shutil.copy(ROOT / name, place / name)
    before = digests(place)
    for recipe in ADDED:
        for name, content in own_files(RECIPES[recipe]).items():
            assert not (place / name).exists()
            (place / name).write_text(content, encoding="utf-8")
        for name, lines in CHANGE.findall(RECIPES[recipe]):
            text = (place / name).read_text(encoding="utf-8")
            (place / name).write_text(changed_by(lines, text), encoding="utf-8")
    run(place, "-c", PAGES)
    after = digests(place)
    return place, {name for name, digest in after.items() if before.get(name) != digest}


PAGES = """
from scripts.documentation.make_docs import DOCS, pages
for name, text in pages().items():
    (DOCS / name).write_text(text, encoding="utf-8")
"""


def own_files(text: str) -> dict[str, str]:
    """The files that a recipe adds to pmmkit itself: its own, and its test where it shows one."""
    end = "".join(f"\n\n{end}" for end in END.findall(text))
    return {name: content + end for name, content in OWN.findall(text)} | dict(TEST.findall(text))


def changed_by(lines: str, text: str) -> str:
    """A text after a change, of which each line begins with a blank, ``-`` or ``+``."""
    listed = lines.splitlines(keepends=True)
    before, after = ("".join(x[1:] for x in listed if x[0] in kept) for kept in (" -", " +"))
    assert text.count(before) == 1, before
    return text.replace(before, after)


def digests(folder: Path) -> dict[str, str]:
    return {
        path.relative_to(folder).as_posix(): hashlib.sha256(path.read_bytes()).hexdigest()
        for path in folder.rglob("*")
        if path.is_file() and path.suffix not in (".pyc", ".nbi", ".nbc")
    }


def run(place: Path, *command: str) -> None:
    environment = {**os.environ, "PYTHONPATH": str(place), "PYTHONDONTWRITEBYTECODE": "1"}
    done = subprocess.run(
        [sys.executable, *command],
        cwd=place,
        env=environment,
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stdout[-4000:] + done.stderr[-4000:]


@pytest.mark.slow
def test_an_entry_of_pmmkit_is_one_file(copy):
    _, changed = copy
    followed = [RECIPES[recipe] for recipe in ADDED]
    files = {name for text in followed for name in (*own_files(text), *dict(CHANGE.findall(text)))}
    assert changed == files | {page for text in followed for page in PAGES_CHANGED.findall(text)}


@pytest.mark.slow
def test_the_contracts_hold_with_the_entries_of_all_recipes(copy):
    place, _ = copy
    chosen = dict.fromkeys(name for names in (*ADDED.values(), OF_ALL) for name in names)
    quiet = ("-q", "-p", "no:cacheprovider", "-p", "no:xdist", "--tb=short")
    run(place, "-m", "pytest", *quiet, *(f"tests/{name}" for name in chosen))


@pytest.mark.slow
@pytest.mark.parametrize(
    "recipe", [name for name, text in RECIPES.items() if not FILE.search(text)]
)
def test_a_change_of_pmmkit_itself_shows_where_its_recipe_says(recipe, copy):
    place, _ = copy
    code = CODE.findall(RECIPES[recipe])
    assert code
    run(place, "-c", "\n".join(code))
    for typed in COMMAND.findall(RECIPES[recipe]):
        run(place, "-c", TYPED, *typed.split())
