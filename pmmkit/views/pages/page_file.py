"""The page as one HTML file, which opens from disk without a server."""

from __future__ import annotations

import base64
import hashlib
import html
import json
import re
from pathlib import Path
from typing import Any, Final

from pmmkit.base import __version__
from pmmkit.files import plain
from pmmkit.presentation import printable
from pmmkit.views.pages.page_room import MOST, Answers, fitted

STATIC: Final = Path(__file__).parents[1] / "static"
LARGEST: Final = MOST + 50_000
"""Bytes of data with the words of all languages."""
ASKED: Final = {
    "data": "runs 0",
    "derivatives": "derivatives",
    "where": "misfit 0",
    "missing": "missing",
    "ship": "turns",
}
"""The places of the page, and without which answer each has nothing to draw."""
IMPORT: Final = re.compile(r'^import (\{[^}]*\}) from "\./(\w+)\.js";\n', re.M)
EXPORT: Final = re.compile(r"^export ((?:async )?(?:function|const|class) (\w+))", re.M)


def state_of(*, title: str, kind: str, runs: int, model: str) -> dict[str, Any]:
    """The state of a page that no server stands behind."""
    return {
        "version": __version__,
        "job": {"stand": "idle"},
        "opened": True,
        "revision": 0,
        "title": title,
        "kind": kind,
        "runs": runs,
        "model": model,
        "steps": [],
        "commands": [],
    }


def page_file(answers: Answers) -> str:
    """A page with all its answers inside.

    Parameters
    ----------
    answers : dict
        ``state`` and whatever else is known; places of which nothing is known are not shown.

    Returns
    -------
    str
        HTML with scripts, styles and data inside, at most 3 MB. Its policy lets nothing else run:
        scripts and styles are named by their hashes.
    """
    words = {
        path.stem: json.loads(path.read_text("utf-8")) for path in (STATIC / "words").glob("*.json")
    }
    drawn = {name: bool(answers.get(key)) for name, key in ASKED.items()}
    places = {name: own for name, own in drawn.items() if own or f"told {name}" in answers}
    whole = {**answers, "state": {**answers["state"], "places": places}}
    data = _data({"answers": whole, "words": words})
    if len(data) > LARGEST:
        data = _data({"answers": fitted(whole), "words": words})
    styles = "".join(_read(name) for name in ("vendor/uPlot.min.css", "style.css"))
    plots, page = _read("vendor/uPlot.iife.min.js"), bundle()
    policy = "; ".join(
        (
            "default-src 'none'",
            f"script-src {content_hash(plots)} {content_hash(page)}",
            f"style-src {content_hash(styles)}",
            "img-src data:",
            "base-uri 'none'",
            "form-action 'none'",
        )
    )
    title = html.escape(printable(str(answers["state"].get("title") or "pmmkit")))
    return (
        '<!doctype html>\n<html lang="en">\n<head>\n<meta charset="utf-8">\n'
        f'<meta http-equiv="content-security-policy" content="{policy}">\n'
        '<meta name="viewport" content="width=device-width, initial-scale=1">\n'
        '<meta name="color-scheme" content="light dark">\n'
        f'<meta name="generator" content="pmmkit {__version__}">\n'
        f"<title>{title}</title>\n<style>{styles}</style>\n</head>\n<body>\n"
        f'<div id="page"></div>\n<script type="application/json" id="frozen">{data}</script>\n'
        f'<script>{plots}</script>\n<script type="module">{page}</script>\n</body>\n</html>\n'
    )


def content_hash(text: str) -> str:
    """A script or a style sheet as a content security policy names it.

    Examples
    --------
    >>> content_hash("")
    "'sha256-47DEQpj8HBSa+/TImW+5JCeuQeRkm5NMpJWZG3hSuFU='"
    """
    return f"'sha256-{base64.b64encode(hashlib.sha256(text.encode()).digest()).decode()}'"


def _data(held: Any) -> str:
    """JSON that cannot end the element it stands in, nor begin another inside it."""
    try:
        text = json.dumps(held, default=plain, allow_nan=False, separators=(",", ":"))
    except ValueError:  # a NaN, which few answers have
        text = json.dumps(plain(held), allow_nan=False, separators=(",", ":"))
    return re.sub("<(?=[!sS])", r"\\u003c", text.replace("</", r"<\/"))


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
