"""The rooms of the package as a table: order from pyproject.toml, words from the code."""

from __future__ import annotations

import ast
import re
import tomllib
from pathlib import Path

ROOT = Path(__file__).parents[2]
PAGE = ROOT / "docs" / "architecture.md"
FENCE = re.compile(r"(<!-- rooms:.*? -->\n).*(<!-- end of rooms -->)", re.S)


def layers() -> list[list[str]]:
    """The rows of rooms, the highest first."""
    settings = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
    (contract,) = (
        item for item in settings["tool"]["importlinter"]["contracts"] if item["type"] == "layers"
    )
    return [[room.strip() for room in row.split(":")] for row in contract["layers"]]


def words(room: str) -> str:
    """The first line of a room's docstring."""
    module = ROOT / "pmmkit" / f"{room}.py"
    file = module if module.is_file() else ROOT / "pmmkit" / room / "__init__.py"
    text = ast.get_docstring(ast.parse(file.read_text(encoding="utf-8")))
    assert text, f"pmmkit.{room} has no docstring"
    return text.splitlines()[0].replace("``", "`")


def page() -> str:
    """docs/architecture.md with the rooms as they stand."""
    rows = [
        f"| {height} | `{room}` | {words(room)} |"
        for height, row in zip(range(len(layers()), 0, -1), layers(), strict=True)
        for room in row
    ]
    table = "\n".join(["| row | room | |", "|---|---|---|", *rows])
    text = PAGE.read_text(encoding="utf-8")
    return FENCE.sub(lambda found: f"{found[1]}{table}\n{found[2]}", text)
