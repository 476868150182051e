"""The kinds of test as a table: from the registry into docs/formats.md."""

from __future__ import annotations

import re
from pathlib import Path

from pmmkit.campaigns.settings import setting_key
from pmmkit.campaigns.test_kinds.kind import TestKind
from pmmkit.campaigns.test_kinds.registry import BUILT_IN

PAGE = Path(__file__).parents[2] / "docs" / "formats.md"
FENCE = re.compile(r"(<!-- tests:.*? -->\n).*(<!-- end of tests -->)", re.S)
LETTERS = {
    "udot": "u̇",
    "vdot": "v̇",
    "rdot": "ṙ",
    "phi": "heel",
    "delta": "rudder",
    "rps": "revolutions",
}


def _row(kind: TestKind) -> str:
    needs = ", ".join(f"`{setting_key(name)}`" for name in kind.needs)
    needs = needs.replace("`yaw_rate`", "`yaw_rate` or `radius`")
    takes = ", ".join(f"`{setting_key(name)}`" for name in kind.takes)
    settings = "; ".join([*([needs] if needs else []), *([f"may take {takes}"] if takes else [])])
    varies = ", ".join(LETTERS.get(name, name) for name in kind.varies)
    return f"| `{kind.name}` | {kind.title} | {kind.family} | {settings} | {varies} |"


def page() -> str:
    """docs/formats.md with the kinds of test as they stand."""
    head = ["| test | | | settings besides `speed` | varies |", "|---|---|---|---|---|"]
    table = "\n".join([*head, *map(_row, BUILT_IN.values())])
    text = PAGE.read_text(encoding="utf-8")
    made, count = FENCE.subn(lambda found: f"{found[1]}{table}\n{found[2]}", text)
    assert count == 1, f"{PAGE.name} has no place for the kinds of test"
    return made
