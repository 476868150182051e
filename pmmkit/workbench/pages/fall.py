"""How the error of what is left out falls with each step."""

from __future__ import annotations

import math
from itertools import accumulate
from typing import Any

from pmmkit.channels import CHANNEL_UNITS
from pmmkit.diagnosis.findings import UNITS
from pmmkit.loop import ErrorFall, JointFall, RecordFall
from pmmkit.loop.evidence import Fall
from pmmkit.workbench.pages.numbers import short


def fall_page(fall: Fall) -> dict[str, Any]:
    """The waterfall: a row per step.

    Parameters
    ----------
    fall : Fall
        Of captive tests, of records, or of several campaigns.

    Returns
    -------
    dict
        ``unit``, ``of`` (``force`` or ``heading``), ``how``, ``remarks``, ``steps``: by step its
        name, ``error``, the ``level`` of noise alone where it is known, and errors by channel with
        their units. Of several campaigns ``campaigns``: these by title, with each step.
    """
    if isinstance(fall, JointFall):
        return {"campaigns": [_one_of(fall, name) for name in fall.falls]}
    return {
        "unit": fall.unit,
        "of": fall.of,
        "how": fall.how,
        "remarks": list(fall.remarks()),
        "useless": list(fall.useless),
        "steps": _captive(fall) if isinstance(fall, ErrorFall) else _records(fall),
    }


def _one_of(fall: JointFall, name: str) -> dict[str, Any]:
    """One of several campaigns: a step that it was not asked for leaves its errors as they are."""
    page = fall_page(fall.falls[name])
    rows = page["steps"]
    places = accumulate(fall.taken[name], initial=0)
    steps = [{**rows[place], "step": step} for step, place in zip(fall.steps, places, strict=True)]
    return {**page, "title": name, "steps": steps}


def _captive(fall: ErrorFall) -> list[dict[str, Any]]:
    return [
        {
            "step": name,
            "error": short(100.0 * item.share()),
            "level": short(100.0 * item.share(kind="level")),
            "channels": {
                channel: {"error": short(error), "unit": CHANNEL_UNITS[channel]}
                for channel, error in item.of_channel().items()
            },
        }
        for name, item in zip(fall.steps, fall.errors, strict=True)
    ]


def _records(fall: Fall) -> list[dict[str, Any]]:
    assert isinstance(fall, RecordFall)
    return [
        {
            "step": item.step,
            "error": short(item.heading),
            "level": short(fall.levels.get(fall.of, math.nan)),
            "channels": {
                name: {"error": short(getattr(item, name)), "unit": unit}
                for name, unit in UNITS.items()
                if hasattr(item, name)
            },
        }
        for item in fall.errors
    ]
