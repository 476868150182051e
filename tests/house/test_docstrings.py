"""Everything public says what it does; the words of the rooms say what each parameter is."""

from __future__ import annotations

import ast
import importlib
import inspect
import pkgutil
import re
from enum import Enum
from pathlib import Path

import pytest
from doors import WIDE

import pmmkit

PACKAGE = Path(__file__).parents[2] / "pmmkit"
MODULES = sorted(
    path for path in PACKAGE.rglob("*.py") if "datasets" not in path.relative_to(PACKAGE).parts
)


def public_functions(path: Path):
    """Public functions and methods of a module, with the name of their class; what a function takes
    and gives in one of its forms alone is said by the function."""
    for node in ast.parse(path.read_text(encoding="utf-8")).body:
        form = isinstance(node, ast.FunctionDef) and "overload" in map(
            ast.unparse, node.decorator_list
        )
        if isinstance(node, ast.FunctionDef) and not node.name.startswith("_") and not form:
            yield "", node
        if isinstance(node, ast.ClassDef) and not node.name.startswith("_"):
            for part in node.body:
                if isinstance(part, ast.FunctionDef) and not part.name.startswith("_"):
                    yield f"{node.name}.", part


def words():
    """What the package and the doors of its rooms offer by name (`__all__`), each once; a door that
    is too wide (tests/support/doors.py) is no door yet."""
    rooms = [item.name for item in pkgutil.iter_modules(pmmkit.__path__) if item.name not in WIDE]
    rooms = ["pmmkit", *(f"pmmkit.{name}" for name in rooms)]
    for room in rooms:
        module = importlib.import_module(room)
        for name in getattr(module, "__all__", ()):
            thing = getattr(module, name)
            if inspect.isfunction(thing) or inspect.isclass(thing):
                yield thing


def parameters(thing) -> list[str]:
    """Names of the parameters that a user gives; the members of a list of kinds are there."""
    if inspect.isclass(thing) and issubclass(thing, (Exception, Enum)):
        return []
    try:
        return list(inspect.signature(thing).parameters)
    except ValueError:
        return []


def described(text: str) -> set[str]:
    """Entries of the section Parameters or Attributes, and names in back quotes."""
    listed: set[str] = set()
    for section in re.findall(
        r"^(?:Parameters|Attributes)\n-+\n(.*?)(?=^\w[\w ]*\n-+$|\Z)", text, re.S | re.M
    ):
        for entry in re.findall(r"^(\S.*?)(?: :.*)?$", section, re.M):
            listed |= {name.strip(" *") for name in entry.split(",")}
    return listed | set(re.findall(r"`(\w+)`", text))


@pytest.mark.slow
@pytest.mark.parametrize("path", MODULES, ids=lambda path: str(path.relative_to(PACKAGE)))
def test_modules_and_their_public_functions_say_what_they_do(path):
    text = path.read_text(encoding="utf-8")
    assert ast.get_docstring(ast.parse(text)), "no module docstring"
    silent = [
        owner + function.name
        for owner, function in public_functions(path)
        if not ast.get_docstring(function)
    ]
    assert silent == []


@pytest.mark.parametrize("path", MODULES, ids=lambda path: str(path.relative_to(PACKAGE)))
def test_no_file_outgrows_its_room(path):
    assert len(path.read_text(encoding="utf-8").splitlines()) <= 800


@pytest.mark.parametrize(
    "thing", {id(thing): thing for thing in words()}.values(), ids=lambda thing: thing.__qualname__
)
def test_each_parameter_of_a_public_word_is_described(thing):
    text = inspect.getdoc(thing) or ""
    assert text, "no docstring"
    assert [name for name in parameters(thing) if name not in described(text)] == []


def test_a_parameter_without_a_description_is_noticed():
    section = "Parameters\n----------\na, b : float\n    Two, and `e`.\n\n"
    names = described(f"Does.\n\n{section}Returns\n-------\nc : int")
    assert names >= {"a", "b", "e"}
    assert "c" not in names
