"""What a campaign file can say, as tables of docs/formats.md."""

from __future__ import annotations

import json
from functools import partial
from types import UnionType
from typing import Annotated, Any, Literal, Union, get_args, get_origin

from pydantic import BaseModel
from pydantic.fields import FieldInfo

from pmmkit.campaigns import RUN_SETTINGS, TEST_KINDS, TestKind
from pmmkit.campaigns.file.schema import (
    CorrectionEntry,
    DefaultsEntry,
    MatrixEntry,
    RunEntry,
    SettingsEntry,
    TableEntry,
    TareEntry,
)
from pmmkit.campaigns.file.single_tables import (
    AxesEntry,
    CampaignEntry,
    CfdEntry,
    ColumnEntry,
    GaugeEntry,
    ImoEntry,
    ReportEntry,
    ShipEntry,
    SourceEntry,
    StrutsEntry,
    TrialEntry,
    UncertainEntry,
    WaterEntry,
)
from pmmkit.models import SECTIONS
from pmmkit.readers import READERS
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
    needs = ", ".join(f"`{RUN_SETTINGS.key_of(name)}`" for name in kind.needs)
    needs = needs.replace("`yaw_rate`", "`yaw_rate` or `radius`")
    takes = ", ".join(f"`{RUN_SETTINGS.key_of(name)}`" for name in kind.takes)
    settings = "; ".join([*([needs] if needs else []), *([f"may take {takes}"] if takes else [])])
    varies = ", ".join(LETTERS.get(name, name) for name in kind.varies)
    return f"`{kind.name}`", kind.title, kind.family, settings, varies


def test_table() -> str:
    """The kinds of test with their settings."""
    head = ("test", "", "", "settings besides `speed`", "varies")
    return table(head, map(_row, TEST_KINDS.own.values()))


def format_table() -> str:
    """The formats of measured files."""
    head = ("`format`", "reads", "suffixes", "keys of `[source]` that count")
    return table(
        head,
        (
            (
                f"`{reader.name}`",
                reader.reads,
                *(", ".join(f"`{x}`" for x in listed) for listed in (reader.suffixes, reader.keys)),
            )
            for reader in READERS.own.values()
        ),
    )


def stated_table(section: str) -> str:
    """What a campaign file can state of the propeller or the rudder."""
    geometry = {item.name for item in SECTIONS[section].geometry}
    numbers = sorted(SECTIONS[section].numbers.values(), key=lambda item: item.name not in geometry)
    words = [
        (f"`{name}`", " or ".join(f'`"{word}"`' for word in options), "")
        for name, options in SECTIONS[section].words.items()
        if name != "open_water"
    ]
    return table(
        ("key", "", "unit"),
        [*((f"`{item.name}`", item.text, item.unit) for item in numbers), *words],
    )


def keys_table(model: type[BaseModel], *without: type[BaseModel]) -> str:
    """The keys of a table of the campaign file, as its schema describes them.

    Keys that it shares with the tables `without` are left out.
    """
    told = {name for other in without for name in other.model_fields}
    rows = [
        (f"`{name}`", _values(item), _default(item), item.description or "")
        for name, item in model.model_fields.items()
        if name not in told
    ]
    return table(("key", "value", "if absent", "meaning"), rows)


def _values(item: FieldInfo) -> str:
    """What may stand right of the =."""
    words = _words(item.annotation)
    return " or ".join(dict.fromkeys(filter(None, words)))


def _words(kind: Any) -> list[str]:
    origin = get_origin(kind)
    if origin is Literal:
        return [
            f"`{json.dumps(value)}`" for value in get_args(kind) if not str(value).startswith("+")
        ]
    if origin is Annotated:
        return _words(get_args(kind)[0])
    if origin in (Union, UnionType):
        return [word for part in get_args(kind) for word in _words(part)]
    if origin is tuple and get_origin(get_args(kind)[0]) is tuple:
        return ["table"]
    if origin in (list, tuple):
        inner = " or ".join(dict.fromkeys(_words(get_args(kind)[0])))
        return [f"list of {inner}"]
    if origin is dict or (isinstance(kind, type) and issubclass(kind, BaseModel)):
        return ["table"]
    return [_PLAIN.get(kind, "")]


def _default(item: FieldInfo) -> str:
    if item.is_required():
        return "required"
    value = item.default
    return "" if value in (None, "", [], {}, ()) else f"`{json.dumps(value)}`"


_PLAIN = {str: "text", float: "number", int: "whole number", bool: "true or false"}
KEYS = {
    "campaign": (CampaignEntry,),
    "ship": (ShipEntry,),
    "water": (WaterEntry,),
    "source": (SourceEntry,),
    "columns": (ColumnEntry,),
    "axes": (AxesEntry,),
    "struts": (StrutsEntry,),
    "tare": (TareEntry,),
    "cfd": (CfdEntry,),
    "trial": (TrialEntry,),
    "imo": (ImoEntry,),
    "uncertainty": (UncertainEntry,),
    "report": (ReportEntry,),
    "gauges": (GaugeEntry,),
    "corrections": (CorrectionEntry, SettingsEntry),
    "runs": (RunEntry, SettingsEntry),
    "settings": (SettingsEntry,),
    "defaults": (DefaultsEntry, SettingsEntry),
    "matrix": (MatrixEntry, SettingsEntry),
    "tables": (TableEntry, RunEntry),
}
"""Tables of the campaign file: what describes their keys, and whose keys stand elsewhere."""
TABLES = {
    "formats.md": {
        **{f"keys of {name}": partial(keys_table, *models) for name, models in KEYS.items()},
        "tests": test_table,
        "formats": format_table,
        **{section: partial(stated_table, section) for section in SECTIONS},
    }
}
