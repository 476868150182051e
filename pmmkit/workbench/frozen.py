"""The page with its state in one HTML file, which opens from disk without a server."""

from __future__ import annotations

import base64
import hashlib
import json
import re
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any, Final

from pmmkit.errors import PmmkitError
from pmmkit.escaping import html_text
from pmmkit.json_text import plain
from pmmkit.workbench.desk import Desk

STATIC: Final = Path(__file__).parent / "static"
MOST: Final = 2_400_000
"""Bytes of data: with the scripts a file stays below 3 MB."""
BUCKETS: Final = (200, 100, 50, 25)
"""Pieces of a record, as many as the file has room for."""
IMPORT: Final = re.compile(r'^import (\{[^}]*\}) from "\./(\w+)\.js";\n', re.M)
EXPORT: Final = re.compile(r"^export ((?:async )?(?:function|const|class) (\w+))", re.M)


def frozen_page(desk: Desk) -> str:
    """The page of a workbench as one file.

    Parameters
    ----------
    desk : Desk
        With something open. What was not asked yet is not in the file.

    Returns
    -------
    str
        HTML with scripts, styles and data inside, at most 3 MB. Its policy lets nothing else run:
        scripts and styles are named by their hashes.
    """
    words = {
        path.stem: json.loads(path.read_text("utf-8")) for path in (STATIC / "words").glob("*.json")
    }
    held = {"answers": answers(desk), "words": words}
    # No text that is held can end the element it stands in.
    data = json.dumps(plain(held), allow_nan=False, separators=(",", ":")).replace("<", "\\u003c")
    styles = "".join(_read(name) for name in ("vendor/uPlot.min.css", "style.css"))
    plots, page = _read("vendor/uPlot.iife.min.js"), bundle()
    policy = "; ".join(
        (
            "default-src 'none'",
            f"script-src {_hash(plots)} {_hash(page)}",
            f"style-src {_hash(styles)}",
            "img-src data:",
            "base-uri 'none'",
            "form-action 'none'",
        )
    )
    title = html_text(str(held["answers"]["state"].get("title", "pmmkit")))
    return (
        '<!doctype html>\n<html lang="en">\n<head>\n<meta charset="utf-8">\n'
        f'<meta http-equiv="content-security-policy" content="{policy}">\n'
        '<meta name="viewport" content="width=device-width, initial-scale=1">\n'
        '<meta name="color-scheme" content="light dark">\n'
        f"<title>{title}</title>\n<style>{styles}</style>\n</head>\n<body>\n"
        f'<div id="page"></div>\n<script type="application/json" id="frozen">{data}</script>\n'
        f'<script>{plots}</script>\n<script type="module">{page}</script>\n</body>\n</html>\n'
    )


def answers(desk: Desk) -> dict[str, Any]:
    """What the page asks, by the words it asks with."""
    state = desk.page()
    count = len(state.get("steps", ()))
    found: dict[str, Any] = {"state": {**state, "job": {**state["job"], "stand": "idle"}}}
    for number in range(count + 1):
        found[f"misfit {number}"] = desk.misfit(number)
    asked: Mapping[str, Callable[[], Any]] = {
        "missing": desk.missing,
        "fall": desk.fall,
        "turns": desk.turns,
        "checks": desk.checks,
        "derivatives": desk.derivatives,
        "runs 0": lambda: desk.runs(0),
    }
    for name, give in asked.items():
        try:
            found[name] = give()
        except PmmkitError:
            found[name] = None
    return {**found, **_histories(desk, found, count)}


def _histories(desk: Desk, found: Mapping[str, Any], count: int) -> dict[str, Any]:
    """Runs with the present model, the worst first, as finely as there is room for."""
    rows = [row for group in found[f"misfit {count}"]["groups"] for row in group["rows"]]
    rows.sort(key=lambda row: -max((x["ratio"] or 0.0 for x in row["cells"].values()), default=0.0))
    room = MOST - _size(found)
    for buckets in BUCKETS:
        first = _size(desk.history(rows[0]["run"], buckets=buckets)) if rows else 0
        if first * len(rows) <= room:
            break
    kept: dict[str, Any] = {}
    for row in rows:
        page = desk.history(row["run"], buckets=buckets)
        room -= _size(page)
        if room < 0:
            break
        kept[f"run {row['run']} {count}"] = page
    return kept


def _size(content: Any) -> int:
    return len(json.dumps(plain(content), separators=(",", ":")))


def bundle() -> str:
    """All modules as one script, each in a function of its own, those that others need first."""
    placed: dict[str, str] = {}

    def place(name: str) -> None:
        text = _read(f"js/{name}.js")
        for _, needed in IMPORT.findall(text):
            if needed not in placed:
                place(needed)
        given = ", ".join(own for _, own in EXPORT.findall(text))
        body = EXPORT.sub(r"\1", IMPORT.sub(r"const \1 = from_\2;\n", text))
        placed[name] = f"const from_{name} = (() => {{\n{body}\nreturn {{ {given} }};\n}})();\n"

    place("main")
    return "".join(placed.values())


def _read(name: str) -> str:
    return (STATIC / name).read_text("utf-8")


def _hash(text: str) -> str:
    return f"'sha256-{base64.b64encode(hashlib.sha256(text.encode()).digest()).decode()}'"
