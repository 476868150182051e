"""The page as one HTML file, which opens from disk without a server, and what it has room for."""

from __future__ import annotations

import base64
import hashlib
import html
import json
import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from functools import cache, partial
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

from pmmkit.base import __version__
from pmmkit.effects import CATALOGUE
from pmmkit.files import plain
from pmmkit.presentation import printable

if TYPE_CHECKING:
    from jinja2 import Environment


# What a page in one file has room for: 3 MB, the runs with the largest errors first.


MOST: Final = 2_700_000
"""Bytes of data: with the scripts a file stays below 3 MB."""
BUCKETS: Final = (200, 100, 50, 25)
"""Pieces of a record, as many as the file has room for."""
MAP_SHARE: Final = 0.5
"""Part of the data that one map of runs may take."""
DRAWN_SHARE: Final = 0.3
"""Part that candidates drawn over runs may take."""

Answers = dict[str, Any]
"""What the page asks, by the words it asks with."""


def asked_of(asked: str, of: int) -> str:
    """The words by which a page asks of a campaign; of the first it asks as if there were one.

    Parameters
    ----------
    asked : str
        The words without it.
    of : int
        Its place.
    """
    return f"{asked} {of}" if of else asked


def with_runs(
    answers: Answers,
    rows: Iterable[str],
    give: Callable[[str, int], Any],
    asked: Callable[[str], str],
    *,
    share: float = 1.0,
) -> Answers:
    """The answers with runs and their histories, as finely as there is room for."""
    runs = list(rows)
    room = share * (MOST - size_of(answers))
    fits = (x for x in BUCKETS if runs and size_of(give(runs[0], x)) * len(runs) <= room)
    buckets = next(fits, BUCKETS[-1])
    kept: Answers = {}
    for name in runs:
        page = give(name, buckets)
        room -= size_of(page)
        if room < 0:
            break
        kept[asked(name)] = page
    return {**answers, **kept}


def with_histories(
    answers: Answers, steps: int, campaigns: int, give: Callable[..., Any]
) -> Answers:
    """The answers that have room in a file, with the runs of each campaign, the worst first.

    Parameters
    ----------
    answers : dict
        What is known besides, a map of the runs with the model after each step among it.
    steps, campaigns : int
        How many there are.
    give : callable
        The page of a run of a campaign: its name, the `buckets` of its record and the place `of`
        the campaign.
    """
    found = fitted(answers)
    for of in range(campaigns):
        found = with_runs(
            found,
            worst_first(found[asked_of(f"misfit {steps}", of)]),
            partial(_given, give, of),
            partial(_asks_run, steps, of),
            share=1.0 / (campaigns - of),
        )
    return found


def _given(give: Callable[..., Any], of: int, run: str, buckets: int) -> Any:
    return give(run, buckets=buckets, of=of)


def _asks_run(steps: int, of: int, run: str) -> str:
    return asked_of(f"run {run} {steps}", of)


def worst_first(misfit: Mapping[str, Any]) -> list[str]:
    """The runs of a map, the one with the largest error over its uncertainty first."""
    rows = [row for group in misfit["groups"] for row in group["rows"]]
    return [row["run"] for row in sorted(rows, key=_size, reverse=True)]


def _size(row: Mapping[str, Any]) -> float:
    return max((cell["ratio"] or 0.0 for cell in row["cells"].values()), default=0.0)


def fitted(answers: Answers) -> Answers:
    """The answers, without what a file of 3 MB has no room for; each place says what it lacks."""
    own = {
        name: _shorter(page) if name.startswith("misfit ") else page
        for name, page in answers.items()
    }
    if own.get("missing") and size_of(own) > MOST:
        own["missing"] = _drawn_over_fewer(own["missing"], answers)
    places = [name for name in own if name.startswith("told ")]
    sizes = sorted(
        (len(item["svg"]) for name in places for item in figures_of(own[name])), reverse=True
    )
    over = size_of(own) - MOST
    largest = float("inf")
    for size in sizes:
        if over <= 0:
            break
        largest, over = size, over - size
    if largest < float("inf"):
        own |= {name: _without_pictures(own[name], largest) for name in places}
    return own


def figures_of(told: Mapping[str, Any]) -> list[dict[str, Any]]:
    """All figures of a place (see `told_page`)."""
    return [
        item for part in ("before", "after", "folded") for x in told[part] for item in x["figures"]
    ]


def _without_pictures(told: Mapping[str, Any], largest: float) -> dict[str, Any]:
    """A place without the pictures of this size and above."""
    return {
        name: part
        if name == "facts"
        else [
            {
                **section,
                "figures": [
                    {**item, "svg": ""} if len(item["svg"]) >= largest else item
                    for item in section["figures"]
                ],
            }
            for section in part
        ]
        for name, part in told.items()
    }


def _shorter(misfit: Mapping[str, Any]) -> Mapping[str, Any]:
    """A map of so many rows as have room."""
    whole = size_of(misfit)
    if whole <= MAP_SHARE * MOST:
        return misfit
    runs = worst_first(misfit)
    kept = set(runs[: int(len(runs) * MAP_SHARE * MOST / whole)])
    groups = [
        {**group, "rows": [row for row in group["rows"] if row["run"] in kept]}
        for group in misfit["groups"]
    ]
    return {
        **misfit,
        "groups": [group for group in groups if group["rows"]],
        "left_out": len(runs) - len(kept),
    }


def _drawn_over_fewer(missing: Mapping[str, Any], answers: Answers) -> Mapping[str, Any]:
    """A diagnosis with candidates drawn over so many runs of each campaign as have room."""
    several = missing.get("drawn")
    tables = several or [missing]
    room = DRAWN_SHARE * MOST / len(tables)
    maps = [answers.get(asked_of("misfit 0", of)) for of in range(len(tables))]
    fewer = [
        _within(table, worst_first(own), room) if own else table
        for table, own in zip(tables, maps, strict=True)
    ]
    return {**missing, "drawn": fewer} if several else fewer[0]


def _within(table: Mapping[str, Any], runs: Sequence[str], room: float) -> Mapping[str, Any]:
    overlays = table.get("overlays") or {}
    kept: set[str] = set()
    for run in runs:
        room -= sum(size_of(own[run]) for own in overlays.values() if run in own)
        if room < 0:
            break
        kept.add(run)
    if room >= 0:
        return table
    return {
        **table,
        "overlays": {
            name: {run: values for run, values in own.items() if run in kept}
            for name, own in overlays.items()
        },
    }


def size_of(content: Any) -> int:
    """Bytes of what is held, to a few per cent."""
    return len(json.dumps(content, separators=(",", ":"), default=str))


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
        "titles": CATALOGUE.titles,
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


# A page without scripts, to be printed: nothing runs in it and nothing is loaded.


def bare_page(
    template: str, *, title: str, style: str, pictures: bool = False, **content: Any
) -> str:
    """The HTML of a page."""
    page: str = (
        _templates()
        .get_template(template)
        .render(
            title=title,
            style=style,
            style_hash=content_hash(style),
            images="img-src data:; " if pictures else "",
            version=__version__,
            **content,
        )
    )
    return page


@cache
def _templates() -> Environment:
    """Templates that escape all text that is printable, and refuse names that are not given."""
    from jinja2 import Environment, FileSystemLoader, StrictUndefined
    from markupsafe import Markup

    return Environment(
        loader=FileSystemLoader(Path(__file__).parents[1] / "report"),
        autoescape=True,
        undefined=StrictUndefined,
        finalize=lambda value: (
            value if isinstance(value, Markup) else Markup(html.escape(printable(str(value))))
        ),
        trim_blocks=True,
        lstrip_blocks=True,
        keep_trailing_newline=True,
    )
