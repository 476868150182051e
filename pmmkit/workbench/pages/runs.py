"""The tests as they were read: each channel with its picture and what was used of it."""

from __future__ import annotations

from typing import Any, Final

import numpy as np

from pmmkit.campaigns.run import Campaign, Run
from pmmkit.campaigns.test_kinds.registry import kind_of
from pmmkit.channels import CHANNEL_UNITS
from pmmkit.diagnosis.captive.held_out import settings_in_words
from pmmkit.errors import PmmkitError
from pmmkit.validation.comparison import Comparison
from pmmkit.workbench.pages.numbers import short, thinned

AT_ONCE: Final = 60
"""Runs that are shown together."""
PIECES: Final = 60
"""Pieces of a picture of a channel: it is as wide as a thumb."""
CHANNELS: Final = ("X", "Y", "N", "K", "u", "v", "r", "psi", "x", "y", "delta")
"""Channels of which there is a picture, in their order."""
MOST: Final = 6
"""Pictures of a run."""


def runs_page(
    campaign: Campaign, comparison: Comparison | None, first: int, findings: list[dict[str, Any]]
) -> dict[str, Any]:
    """Some of the runs of a campaign.

    Parameters
    ----------
    campaign : Campaign
        The tests.
    comparison : Comparison, optional
        Of captive tests: it knows what was used of each record.
    first : int
        Place of the first run.
    findings : list of dict
        What the checks said.

    Returns
    -------
    dict
        ``total``, ``first``, ``excluded`` (run and reason), and ``runs``: title, settings, source,
        what the checks say of it, ``channels`` with unit and picture, ``window`` of the record
        that counts, or the ``error`` for which it cannot be read.
    """
    used = {} if comparison is None else {x.view.run.id: x.view for x in comparison.captive}
    chosen = campaign.runs[first : first + AT_ONCE]
    return {
        "total": len(campaign.runs),
        "first": first,
        "excluded": [{"run": run.id, "reason": reason} for run, reason in campaign.excluded],
        "runs": [
            {
                **_shown(run, used.get(run.id)),
                "findings": [
                    {"severity": item["severity"], "message": item["message"]}
                    for item in findings
                    if run.id in item.get("runs", ())
                ],
            }
            for run in chosen
        ],
    }


def _shown(run: Run, view: Any) -> dict[str, Any]:
    page: dict[str, Any] = {
        "run": run.id,
        "title": kind_of(run.test).title,
        "words": settings_in_words(run),
        "source": run.source,
        "kind": run.kind,
        "corrections": [f"{item.action}: {item.reason}" for item in run.corrections],
        "channels": [],
        "window": None,
        "error": "",
    }
    if run.kind != "history":
        return page
    try:
        data = run.data
    except PmmkitError as error:
        return page | {"error": str(error)}
    t = np.asarray(data["t"].values, float)
    for name in [name for name in CHANNELS if name in data][:MOST]:
        values = np.asarray(data[name].values, float)
        if values.shape != t.shape:
            continue
        kept = thinned({name: values}, PIECES)
        page["channels"].append(
            {
                "name": name,
                "unit": CHANNEL_UNITS.get(name, ""),
                "t": short(t[kept] - t[0]),
                "values": short(values[kept]),
                "low": short(np.nanmin(values)),
                "high": short(np.nanmax(values)),
            }
        )
    page["seconds"] = short(t[-1] - t[0])
    if view is not None and len(view.t):
        page["window"] = [short(view.t[0]), short(view.t[-1])]
    return page
