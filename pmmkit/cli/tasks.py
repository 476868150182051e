"""The work behind the commands that look, simulate, convert and list."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict
from pathlib import Path
from typing import Any

from pmmkit.campaigns.file.campaign_file import open_campaign
from pmmkit.checks import examine
from pmmkit.cli.console import Outcome, json_text
from pmmkit.cli.findings import findings_of, findings_text
from pmmkit.cli.tracks import check_folder
from pmmkit.effects.catalogue import catalogue
from pmmkit.errors import FileExists
from pmmkit.files import write_text
from pmmkit.models import load_model
from pmmkit.report.tables import meaning
from pmmkit.ship_library import ships
from pmmkit.tables import converted, read_table, write_table


def check(campaign: Path, *, data: Path | None, out: Path | None) -> Outcome:
    """What the checks find in a campaign.

    Parameters
    ----------
    campaign, data : Path
        As for `open_campaign`.
    out : Path, optional
        Folder for ``findings.json``.

    Returns
    -------
    Outcome
        With the number of errors.
    """
    if out:
        check_folder(out)
    opened = open_campaign(campaign, data=data)
    found = examine(opened)
    content = {
        "campaign": opened.title,
        "runs": len(opened),
        "errors": sum(item.severity == "error" for item in found),
        "findings": findings_of(found),
    }
    if out:
        write_text(out / "findings.json", json_text(content["findings"]) + "\n")
    return Outcome(content=content, lines=[findings_text(found)])


def convert(table: Path, out: Path, ending: str, changes: Mapping[str, Any]) -> Outcome:
    """Write a table in another convention or format.

    Parameters
    ----------
    table : Path
        The table.
    out : Path
        Folder for the new one.
    ending : str
        Its format, such as ``.nc``.
    changes : mapping
        Entries of the convention, as for `converted`.

    Returns
    -------
    Outcome
        With the path of the new file.
    """
    known = read_table(table)
    made = converted(known, **changes) if changes else known
    target = out / f"{'-'.join([table.stem, *map(str, changes.values())])}{ending}"
    if target.resolve() == table.resolve():
        raise FileExists(f"{table} is already that table: say a system, a convention or a format.")
    check_folder(out)
    write_table(made, target)
    line = f"{target}: {meaning(made)}."
    return Outcome(
        content={"file": str(target), "convention": asdict(made.convention)}, lines=[line]
    )


def ships_of_library() -> Outcome:
    """The ships of the library with their titles and scales."""
    found = [load_model(name) for name in ships()]
    entries = [
        {
            "name": item.name,
            "title": item.title,
            "L": item.ship.L,
            "scale": item.scale,
            "parts": list(item.parts),
        }
        for item in found
    ]
    width = max(len(item.name) for item in found)
    lines = [f"{item.name:<{width}}  {item.title} (L = {item.ship.L:g} m)" for item in found]
    return Outcome(content={"ships": entries}, lines=lines)


def effects() -> Outcome:
    """The catalogue of effects."""
    found = catalogue().values()
    entries = [
        {
            "name": item.name,
            "family": item.family,
            "kind": item.kind,
            "summary": item.summary,
            "source": item.source,
            "parameters": [part.name for part in item.parameters],
            "usual_sizes": {part.name: part.typical for part in item.coefficients},
            "check": item.check,
            "enters_a_model": not item.faulty,
        }
        for item in found
    ]
    width = max(len(item.name) for item in found)
    lines = []
    for title, faults in (("Effects", False), ("Faults of a measurement", True)):
        lines += [f"{title}:"] + [
            f"  {item.name:<{width}}  {item.summary}" for item in found if item.faulty is faults
        ]
    return Outcome(content={"effects": entries}, lines=lines)
