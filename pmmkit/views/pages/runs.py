"""The tests as they were read: each channel with its picture and what counts of it."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any, Final

import numpy as np

from pmmkit.base import DataError, PmmkitError
from pmmkit.campaigns import TEST_KINDS, Campaign, Correction, Run, usable
from pmmkit.conventions import CHANNEL_UNITS
from pmmkit.intake import LARGE, Summary
from pmmkit.numerics import Array, stretches
from pmmkit.reduction import PreparedRun
from pmmkit.views.pages.numbers import BUCKETS, short, thinned

# Where in a record stands what the checks speak of.


MARKS: Final = 40
"""Marks of a record."""
GAP: Final = 1.5
"""Steps of time over the usual one that are a gap."""


def marks_of(
    t: Array,
    columns: Mapping[str, Array],
    findings: Sequence[Mapping[str, Any]],
    *,
    steady: bool = True,
) -> list[dict[str, Any]]:
    """The places of a record, [s] from its first sample, of what the checks found there.

    t [s].

    Examples
    --------
    >>> t = np.array([0.0, 0.1, 0.2, 5.0, 5.1])
    >>> found = {"check": "time stamps", "severity": "warning", "message": "1 gap"}
    >>> [(mark["from"], mark["to"]) for mark in marks_of(t, {}, [found])]
    [(0.2, 5.0)]
    """
    found = []
    for item in findings:
        for channel, start, stop in _places(t, columns, item, steady):
            found.append(
                {
                    "from": short(start - t[0]),
                    "to": short(stop - t[0]),
                    "channel": channel,
                    "text": item["message"],
                    "severity": item["severity"],
                }
            )
    return found[:MARKS]


def _places(
    t: Array, columns: Mapping[str, Array], item: Mapping[str, Any], steady: bool
) -> Iterator[tuple[str, float, float]]:
    if item["check"] == "time stamps":
        yield from _clock(t)
    for channel in item.get("channels", ()):
        values = columns.get(channel)
        if values is None:
            continue
        numbers = item.get("numbers", {})
        if item["check"] == "saturation":
            yield from ((channel, *span) for span in _flat(t, values, numbers["level"]))
        elif "step" in numbers and steady:
            at = _step(t, values)
            yield channel, at, at


def _clock(t: Array) -> Iterator[tuple[str, float, float]]:
    """Gaps, and places where time stands or goes back."""
    steps = np.diff(t)
    forward = steps[steps > 0]
    usual = float(np.median(forward)) if len(forward) else 0.0
    for place in np.flatnonzero((steps > GAP * usual) | (steps <= 0)):
        low, high = sorted((float(t[place]), float(t[place + 1])))
        yield "", low, high


def _flat(t: Array, values: Array, level: float) -> Iterator[tuple[float, float]]:
    """Stretches in which a channel stands at a level."""
    at = np.isclose(values, level, rtol=1e-9, atol=0.0)
    for start, stop in zip(*stretches(at), strict=True):
        if stop - start >= Summary.FLAT_SAMPLES:
            yield float(t[start]), float(t[stop - 1])


def _step(t: Array, values: Array) -> float:
    """Where the means before and after differ most for their number: the zero jumped there."""
    count = len(values)
    before = np.cumsum(values)[:-1]
    sizes = np.arange(1, count)
    left, right = before / sizes, (values.sum() - before) / (count - sizes)
    gain = (right - left) ** 2 * sizes * (count - sizes)
    return float(t[int(np.argmax(gain)) + 1])


AT_ONCE: Final = 60
"""Runs that are shown together."""
PIECES: Final = 60
"""Pieces of a picture of a channel: it is as wide as a thumb."""
CHANNELS: Final = ("X", "Y", "N", "K", "u", "v", "r", "psi", "x", "y", "delta", "U_carriage")
"""Channels of which there is a picture, in their order."""
MOST: Final = 6
"""Pictures of a run."""
MEMORY: Final = 4.0
"""Memory that a text file takes when it is read, over its size; 3.7 was seen."""


def runs_page(
    campaign: Campaign,
    findings: Sequence[dict[str, Any]],
    *,
    first: int = 0,
    run: str | None = None,
) -> dict[str, Any]:
    """Some of the runs of a campaign, or one in full, to look at and to draw its window."""
    if run is not None:
        found = next((x for x in campaign.runs if x.id == run), None)
        if found is None:
            raise DataError(f"There is no run {run!r}.")
        return _shown(found, campaign, findings, BUCKETS, len(CHANNELS), large=True)
    return {
        "total": len(campaign.runs),
        "first": first,
        "excluded": [{"run": run.id, "reason": reason} for run, reason in campaign.excluded],
        "runs": [
            _shown(item, campaign, findings, PIECES, MOST)
            for item in campaign.runs[first : first + AT_ONCE]
        ],
    }


def _shown(
    run: Run,
    campaign: Campaign,
    findings: Sequence[dict[str, Any]],
    pieces: int,
    most: int,
    *,
    large: bool = False,
) -> dict[str, Any]:
    own = [item for item in findings if run.id in item.get("runs", ())]
    page: dict[str, Any] = {
        "run": run.id,
        "title": TEST_KINDS[run.test].title,
        "words": run.setting,
        "source": run.source,
        "kind": run.kind,
        "oscillates": run.dynamic,
        "corrections": [f"{item.action}: {item.reason}" for item in run.corrections],
        "channels": [],
        "window": None,
        "edges": [],
        "reason": "",
        "stated": None,
        "error": "",
        "large": 0,
        "findings": [
            {"severity": x["severity"], "message": x["message"], "channels": x.get("channels", [])}
            for x in own
        ],
        "marks": [],
    }
    if run.kind != "history":
        return page
    size = _size(run)
    if size >= LARGE and not large:
        return page | {"large": size}
    if large and (short_of := _lacking(size)):
        return page | {"error": short_of}
    try:
        data = (run if campaign.kind == "captive" else run.untrimmed).data
    except PmmkitError as error:
        return page | {"error": str(error)}
    except MemoryError:
        return page | {"error": f"{run.source} does not fit into the memory of this machine."}
    t = np.asarray(data["t"].values, float)
    if not len(t):
        return page | {"error": f"{run.source} has no samples."}
    named = [name for name in CHANNELS if name in data and data[name].dims == ("t",)][:most]
    columns = {name: np.asarray(data[name].values, float) for name in named}
    page["channels"] = [_channel(name, t, values, pieces) for name, values in columns.items()]
    page |= {"begin": short(t[0]), "seconds": short(t[-1] - t[0]), "samples": len(t)}
    page["marks"] = marks_of(t, columns, own, steady=not run.dynamic)
    entry = window_entry(campaign, run.id)
    stated = next((x for x in reversed(run.corrections) if x.action == entry["action"]), None)
    page["stated"] = (
        None
        if stated is None
        else {
            "reason": stated.reason,
            "alone": stated.runs == tuple(entry["runs"]),
            "window": _ends(stated, t),
        }
    )
    try:
        counted = _counted(run.with_(loader=lambda: data), campaign, t, stated)
    except PmmkitError as error:
        return page | {"reason": str(error)}
    return page | counted | {"marks": [*page["marks"], *counted.get("marks", ())]}


def window_entry(campaign: Campaign, run_id: str) -> dict[str, Any]:
    """The correction of the campaign file that states what counts of one run alone, without ends.

    Parameters
    ----------
    campaign : Campaign
        Captive tests or records that run free.
    run_id : str
        The run; its id is written as a pattern that fits nothing else.
    """
    alone = "".join(f"[{char}]" if char in "*?[" else char for char in run_id)
    return {"runs": [alone], "action": "window" if campaign.kind == "captive" else "trim"}


def _size(run: Run) -> int:
    """Of the file that is read for this run alone [bytes]."""
    file = run.own_file
    return 0 if file is None or not file.is_file() else file.stat().st_size


def _lacking(size: int) -> str:
    """Why a file cannot be read whole; empty where it can, or nobody knows."""
    try:
        told = Path("/proc/meminfo").read_text("ascii")
    except OSError:
        return ""
    found = re.search(r"^MemAvailable:\s+(\d+) kB", told, re.MULTILINE)
    if size < LARGE or found is None or MEMORY * size < 1000 * int(found[1]):
        return ""
    return (
        f"This record takes about {MEMORY * size / 1e9:.0f} GB of memory to be read whole, and "
        f"{int(found[1]) / 1e6:.0f} GB are free. Keep fewer of its samples, or cut it in parts."
    )


def _ends(stated: Correction, t: Array) -> list[float]:
    low, high = stated.values.get("t_start", t[0]), stated.values.get("t_end", t[-1])
    return [float(low), float(high)]


def _channel(name: str, t: Array, values: Array, pieces: int) -> dict[str, Any]:
    known = np.isfinite(values)
    if not known.any():
        return {"name": name, "unit": CHANNEL_UNITS.get(name, ""), "t": [], "values": []}
    drawn = values if known.all() else np.where(known, values, np.nanmean(values))
    kept = thinned({name: drawn}, pieces)
    return {
        "name": name,
        "unit": CHANNEL_UNITS.get(name, ""),
        "t": short(t[kept] - t[0]),
        "values": short(values[kept]),
        "low": short(np.nanmin(values)),
        "high": short(np.nanmax(values)),
    }


def _counted(run: Run, campaign: Campaign, t: Array, stated: Correction | None) -> dict[str, Any]:
    """What counts of a record [s from its first sample], cycle by cycle, and why."""
    if campaign.kind != "captive":
        cuts = usable(run).cuts
        low, high = (float(t[0]), float(t[-1])) if stated is None else _ends(stated, t)
        return {
            "window": short(np.clip([low, high], t[0], t[-1]) - t[0]),
            "reason": "",
            "marks": [
                {
                    "from": short(cut.t_start - t[0]),
                    "to": short(cut.t_stop - t[0]),
                    "channel": "",
                    "text": str(cut),
                    "severity": "info",
                }
                for cut in cuts
            ],
        }
    found = PreparedRun.of(run, campaign, noise=False)
    begin, end = found.t[0] - t[0], found.t[-1] - t[0]
    period = found.result.run.settings.period if found.result.cycles else None
    edges = [] if period is None else begin + period * np.arange((found.result.cycles or 0) + 1)
    return {
        "window": short([begin, end]),
        "edges": short(edges),
        "period": short(period) if period else None,
        "reason": found.result.window,
    }
