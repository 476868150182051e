"""The plan of the house on paper is the house as it stands."""

from __future__ import annotations

import pkgutil
import re
from importlib import import_module
from pathlib import Path

import pmmkit
from pmmkit import testing
from pmmkit.effects import Effect
from scripts.documentation import rooms
from scripts.studies import mutants

ROOT = Path(__file__).parents[2]
PLAN = (ROOT / "docs" / "architecture.md").read_text(encoding="utf-8")
ROWS = re.findall(r"^\| (\d+) \| `(\w+)` \| (.+) \|$", PLAN, re.M)
STANDING = {module.name for module in pkgutil.iter_modules(pmmkit.__path__)}


def test_every_room_stands_in_the_plan_once():
    names = [room for _, room, _ in ROWS]
    assert len(names) == len(set(names))
    assert set(names) == STANDING


def test_rows_are_those_that_imports_are_held_to():
    heights = {room: int(height) for height, room, _ in ROWS}
    rows = rooms.layers()
    assert [[heights[room] for room in row] for row in rows] == [
        [len(rows) - number] * len(row) for number, row in enumerate(rows)
    ]


def test_rooms_are_described_in_their_own_words():
    for _, room, told in ROWS:
        assert told == rooms.words(room)


def test_tests_stand_in_folders_of_rooms():
    """What tests one room stands in its folder; `house` holds what tests the whole."""
    folders = {item.name for item in (ROOT / "tests").iterdir() if item.is_dir()}
    others = {"data", "house", "support", "__pycache__"}
    assert folders - others <= STANDING


def test_the_modules_in_which_mistakes_are_made_on_purpose_are_there():
    assert [module for module in mutants.MODULES if not (ROOT / module).is_file()] == []


def test_the_plan_names_no_file_that_is_not_there():
    for name in re.findall(r"`((?:pmmkit|tests|scripts|docs)/[\w./]*)`", PLAN):
        assert (ROOT / name).exists(), name


def test_the_registries_are_where_the_plan_says():
    rows = re.findall(r"^\| [\w ]+ \| .*`([\w/]+(?:\.py|/))` \| (.*) \| `([\w.]+)` \|$", PLAN, re.M)
    assert len(rows) >= 4
    groups = {group for _, group, _ in rows if "`" in group}
    assert groups <= {f"`{group}`" for group in declared_groups()}
    for place, _, contract in rows:
        assert (ROOT / place).exists()
        module, _, name = contract.rpartition(".")
        assert callable(getattr(import_module(module), name))


def declared_groups() -> set[str]:
    return {
        group
        for path in (ROOT / "pmmkit").rglob("*.py")
        for group in re.findall(r'^GROUP: Final = "(.*)"$', path.read_text(encoding="utf-8"), re.M)
    }


def test_every_contract_stands_in_the_plan():
    """The plan and the recipes name what checks an entry."""
    recipes = (ROOT / "CONTRIBUTING.md").read_text(encoding="utf-8")
    for module in pkgutil.iter_modules(testing.__path__):
        assert re.search(rf"`pmmkit\.testing\.{module.name}\.check_\w+`", PLAN), module.name
        assert f"from pmmkit.testing.{module.name} import check_" in recipes, module.name


def test_the_kinds_of_effect_are_those_of_the_catalogue():
    (listed,) = re.findall(r"Its kinds:\n\n((?:- .*\n(?:  .*\n)*)+)", PLAN)
    assert tuple(re.findall(r"^- `(\w+)`", listed, re.M)) == Effect.KINDS
