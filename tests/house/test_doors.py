"""A room has a door: other rooms enter by it, and it lists what they ask for."""

from __future__ import annotations

import ast
from collections import Counter, defaultdict
from collections.abc import Iterator
from pathlib import Path

import pytest
from doors import NARROW, WIDE

PACKAGE = Path(__file__).parents[2] / "pmmkit"
FILES = sorted(PACKAGE.rglob("*.py"))
NO_DOOR = {"cli", "testing"}
"""Nobody enters the command line; contracts are taken from the file of their registry."""
DOORS = sorted(path for path in PACKAGE.glob("*/__init__.py") if path.parent.name not in NO_DOOR)


def room(path: Path) -> str:
    return path.relative_to(PACKAGE).parts[0].removesuffix(".py")


def imports(path: Path) -> Iterator[tuple[str, str]]:
    """Modules of pmmkit that a file imports from, each with the name that it takes."""
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.ImportFrom) and node.module:
            yield from ((node.module, item.name) for item in node.names)
        elif isinstance(node, ast.Import):
            yield from ((item.name, "") for item in node.names)


def listed(door: Path) -> tuple[list[str], list[str]]:
    """What a door lists, and what it imports."""
    tree = ast.parse(door.read_text(encoding="utf-8"))
    (names,) = (
        ast.literal_eval(node.value)
        for node in tree.body
        if isinstance(node, ast.Assign) and ast.unparse(node.targets[0]) == "__all__"
    )
    taken = [
        item.asname or item.name
        for block in tree.body
        if isinstance(block, ast.If)
        for node in block.body
        if isinstance(node, ast.ImportFrom)
        for item in node.names
    ]
    return names, taken


def asked() -> dict[str, set[str]]:
    """The names that each room is asked for by others, the words of the package among them."""
    names = defaultdict(set)
    for path in FILES:
        for module, name in imports(path):
            parts = module.split(".")
            if parts[0] == "pmmkit" and len(parts) == 2 and parts[1] != room(path):
                names[parts[1]].add(name)
    return names


def test_rooms_are_entered_by_their_doors():
    past = [
        f"{path.relative_to(PACKAGE)}: {module}"
        for path in FILES
        for module, _ in imports(path)
        if module.startswith("pmmkit.")
        and (parts := module.split("."))[1] != room(path)
        and len(parts) > 2
    ]
    assert past == []


@pytest.mark.parametrize("door", DOORS, ids=lambda door: door.parent.name)
def test_a_door_lists_what_it_gives_and_what_others_ask_for(door):
    names, taken = listed(door)
    assert sorted(set(names) - {"lazy"}) == sorted(taken)
    modules = {path.stem for path in door.parent.glob("*.py")}
    modules |= {path.parent.name for path in door.parent.glob("*/__init__.py")}
    assert modules & set(names) == set(), "a module would hide what has its name"
    assert set(names) - asked()[door.parent.name] == set(), "nobody asks for these"


@pytest.mark.parametrize("door", DOORS, ids=lambda door: door.parent.name)
def test_a_door_is_narrow(door):
    names, _ = listed(door)
    assert len(names) <= WIDE.get(door.parent.name, NARROW)


def test_doors_that_were_too_wide_do_not_grow():
    sizes = {door.parent.name: len(listed(door)[0]) for door in DOORS}
    assert {name: sizes[name] for name in WIDE} == WIDE
    assert all(size > NARROW for size in WIDE.values())


def test_a_class_name_has_one_meaning():
    names = Counter(
        node.name
        for path in FILES
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8")))
        if isinstance(node, ast.ClassDef) and not node.name.startswith("_")
    )
    assert [name for name, count in names.items() if count > 1] == []
