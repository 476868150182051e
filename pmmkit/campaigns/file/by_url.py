"""A campaign that stands behind a URL: its file, its name, and the curve of its propeller."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path, PurePosixPath
from typing import Any

from pmmkit.campaigns.file.search import Search
from pmmkit.campaigns.samples.bringing import at_hand
from pmmkit.errors import CampaignError, DataError, Problem
from pmmkit.readers import reader_for
from pmmkit.readers.base import Request, to_number
from pmmkit.remote import Origin, as_url, checked, joined, look, shown_url
from pmmkit.toml_files import CAMPAIGN


def origin_of(path: str | Path, files: Sequence[str]) -> Origin | None:
    """The campaign file behind a URL; None for a path of this machine.

    Parameters
    ----------
    path : str or Path
        What is to be opened: the URL of a file, or of a folder with a campaign file.
    files : sequence of str
        Endings of files that are campaigns.

    Raises
    ------
    CampaignError
        If there is none.
    DataError
        If it cannot be looked for.
    """
    given = as_url(path)
    if given is None:
        return None
    url = checked(given)
    if not shown_url(url).lower().endswith(tuple(files)):
        url = joined(url, CAMPAIGN.file) or url
    origin = look(url)
    if origin is None:
        raise CampaignError(
            Problem(
                message="there is nothing behind this URL.",
                file=shown_url(url),
                remedy=f"Name a folder with {CAMPAIGN.file}, or a file that ends in one of "
                f"{', '.join(files)}.",
            )
        )
    return origin


def folder_of(origin: Origin | None) -> str:
    """URL of the folder of a campaign file; empty for one of this machine."""
    return "" if origin is None else origin.shown.rpartition("/")[0]


def folder_name(place: Path, origin: Origin | None) -> str:
    """Name of the folder of a campaign file."""
    return (
        place.absolute().parent.name if origin is None else PurePosixPath(origin.shown).parent.name
    )


def with_curve(
    propeller: Mapping[str, Any], search: Search, toml: str, problems: list[Problem]
) -> dict[str, Any]:
    """What a campaign file says of the propeller, with the curve that stands behind a URL.

    Parameters
    ----------
    propeller : mapping
        ``[propeller]``.
    search : Search
        Of the campaign.
    toml : str
        Name of the campaign file.
    problems : list of Problem
        Gets what keeps the curve from being read.
    """
    curve = propeller.get("open_water")
    if not isinstance(curve, str) or not (search.remote.own or as_url(curve)):
        return dict(propeller)
    found = search.find(curve)
    if found is None:
        problems.append(search.missing(curve, "[propeller], key 'open_water'", toml))
        return dict(propeller)
    try:
        table = table_of(at_hand(found))
    except DataError as error:
        problems += error.problems
        return dict(propeller)
    return {**propeller, "open_water": table}


def table_of(request: Request) -> dict[str, list[float | None]]:
    """The columns of a table of numbers by their titles, such as an open-water curve.

    Parameters
    ----------
    request : Request
        The file.
    """
    cells = reader_for(request).cells(request)
    columns = zip(*cells.rows, strict=True)
    return {
        title: [to_number(cell, cells.decimal) for cell in column]
        for title, column in zip(cells.headers, columns, strict=True)
    }
