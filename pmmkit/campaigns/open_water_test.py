"""The open-water curve of the propeller, from the campaign file or a file beside the data."""

from __future__ import annotations

import csv
from collections.abc import Mapping
from typing import Final

import numpy as np

from pmmkit.campaigns.run import Campaign
from pmmkit.numerics import Array

TENFOLD: Final = "10kq"
"""What tables often call KQ, drawn beside KT."""
_FACTORS: Final = ("KT_factor", "KQ_factor")


def open_water(campaign: Campaign) -> tuple[Array, Array, Array] | None:
    """J, KT, KQ of the campaign's propeller; None where there is no table that can be read.

    ``open_water`` of ``[propeller]`` is a table with the lists J, KT and KQ, or the name of a CSV
    file with such columns (in any case of letters) beside the data; a column ``10KQ`` is ten times
    KQ. ``KT_factor`` and ``KQ_factor`` multiply them.
    """
    source = campaign.propeller.get("open_water")
    table = _csv(campaign, source) if isinstance(source, str) else source
    if not isinstance(table, Mapping):
        return None
    columns = {str(name).strip().lower(): values for name, values in table.items()}
    try:
        if TENFOLD in columns:
            columns["kq"] = (np.asarray(columns[TENFOLD], float) / 10.0).tolist()
        J, KT, KQ = (
            np.asarray(columns[name.lower()], float) * campaign.propeller.get(f"{name}_factor", 1.0)
            for name in ("J", "KT", "KQ")
        )
    except (KeyError, ValueError, TypeError):
        return None
    return (J, KT, KQ) if len(J) == len(KT) == len(KQ) else None


def with_open_water(campaign: Campaign) -> Campaign:
    """The campaign with the curve itself in place of the name of its file, for files that travel.

    What cannot be read stays the name that it was.
    """
    curve = open_water(campaign)
    if curve is None or not isinstance(campaign.propeller.get("open_water"), str):
        return campaign
    kept = {name: x for name, x in campaign.propeller.items() if name not in _FACTORS}
    table = {name: x.tolist() for name, x in zip(("J", "KT", "KQ"), curve, strict=True)}
    return campaign.with_(propeller={**kept, "open_water": table})


def _csv(campaign: Campaign, name: str) -> Mapping[str, list[str]] | None:
    beside = [path.parent for run in campaign.runs if (path := getattr(run.loader, "path", None))]
    for folder in dict.fromkeys((*beside, campaign.folder)):
        if (folder / name).is_file():
            with (folder / name).open(encoding="utf-8-sig", newline="", errors="replace") as file:
                rows = [row for row in csv.reader(file) if row]
            if not rows:
                return None
            full = [row for row in rows[1:] if len(row) == len(rows[0])]
            return {title: [row[place] for row in full] for place, title in enumerate(rows[0])}
    return None
