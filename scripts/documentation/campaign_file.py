"""What a campaign file can say, as tables of docs/formats.md."""

from __future__ import annotations

from functools import partial

from pmmkit.campaigns.settings import setting_key
from pmmkit.campaigns.test_kinds.kind import TestKind
from pmmkit.campaigns.test_kinds.registry import BUILT_IN
from pmmkit.models.stated_parts import GEOMETRY, OPEN_WATER, SECTIONS, numbers_of, words_of
from scripts.documentation.fences import table

LETTERS = {
    "udot": "u̇",
    "vdot": "v̇",
    "rdot": "ṙ",
    "phi": "heel",
    "delta": "rudder",
    "rps": "revolutions",
}


def _row(kind: TestKind) -> tuple[str, ...]:
    needs = ", ".join(f"`{setting_key(name)}`" for name in kind.needs)
    needs = needs.replace("`yaw_rate`", "`yaw_rate` or `radius`")
    takes = ", ".join(f"`{setting_key(name)}`" for name in kind.takes)
    settings = "; ".join([*([needs] if needs else []), *([f"may take {takes}"] if takes else [])])
    varies = ", ".join(LETTERS.get(name, name) for name in kind.varies)
    return f"`{kind.name}`", kind.title, kind.family, settings, varies


def test_table() -> str:
    """The kinds of test with their settings."""
    head = ("test", "", "", "settings besides `speed`", "varies")
    return table(head, map(_row, BUILT_IN.values()))


def stated_table(section: str) -> str:
    """What a campaign file can state of the propeller or the rudder."""
    geometry = {item.name for item in GEOMETRY[section]}
    numbers = sorted(numbers_of(section).values(), key=lambda item: item.name not in geometry)
    words = [
        (f"`{name}`", " or ".join(f'`"{word}"`' for word in options), "")
        for name, options in words_of(section).items()
        if name != OPEN_WATER
    ]
    return table(
        ("key", "", "unit"),
        [*((f"`{item.name}`", item.text, item.unit) for item in numbers), *words],
    )


TABLES = {
    "formats.md": {
        "tests": test_table,
        **{section: partial(stated_table, section) for section in SECTIONS},
    }
}
