"""Runs that stand below each other in one text, told apart by a column."""

from __future__ import annotations

import itertools
import re
from typing import Final

from pmmkit.base import CampaignError
from pmmkit.intake.seen import FileLook
from pmmkit.readers import READERS, Cell, to_number

_TITLE: Final = re.compile(
    r"(?:run|test|trial|case|record|tow|man(?:oeuv|euv)re|versuch|messung|fahrt|lauf)s?"
    r"(?:[ _.]*(?:no|nr|id|number|name|key))?\.?",
    re.IGNORECASE,
)
"""Names of a column that says of each row to which run it belongs."""
_LARGEST: Final = 32_000_000
"""Size of a file beyond which its rows are not looked through [bytes]."""
_FEWEST: Final = 20
"""Rows of a run, at least."""


def runs_in(look: FileLook) -> tuple[tuple[tuple[str, str | int], ...], ...]:
    """Column and value of each run of a history; nothing where its rows are those of one run."""
    place = next((x.position for x in look.columns if _TITLE.fullmatch(x.header)), None)
    if place is None or look.kind != "history" or look.size > _LARGEST:
        return ()
    title = look.columns[place].title
    if "t" not in look.known or look.known["t"].position == place:
        return ()
    try:
        rows = READERS[look.format].cells(look.request).rows
    except CampaignError:
        return ()
    blocks = [(label, len([*own])) for label, own in itertools.groupby(row[place] for row in rows)]
    labels = [label for label, _ in blocks]
    apart = len({*labels}) == len(labels) > 1
    if not apart or min(count for _, count in blocks) < _FEWEST:
        return ()
    return tuple(((title, _plain(label)),) for label in labels)


def _plain(label: Cell) -> str | int:
    """A whole number as such."""
    number = to_number(label)
    whole = number is not None and number == int(number) and str(label).strip() == str(int(number))
    return int(number) if whole and number is not None else str(label).strip()
