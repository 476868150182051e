"""Records without the faults, and in the current, that the steps of a model tell of."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from functools import partial
from typing import TYPE_CHECKING

import numpy as np

from pmmkit.campaigns import Campaign, Run
from pmmkit.effects import CATALOGUE, CURRENT
from pmmkit.identification.record import FreeRecord
from pmmkit.models import Model, Sailing
from pmmkit.numerics import Array

if TYPE_CHECKING:
    import xarray as xr

WORDS: Mapping[str, tuple[str, str, float]] = {
    CURRENT[0]: ("current to north", "m/s", 1.0),
    CURRENT[1]: ("current to east", "m/s", 1.0),
    "rudder_zero": ("rudder shown too little", "deg", math.degrees(1.0)),
    "clock_lag": ("positions late", "s", 1.0),
    "antenna_x": ("antenna forward", "m", 1.0),
    "antenna_y": ("antenna starboard", "m", 1.0),
    "heading_offset": ("heading shown too much", "deg", math.degrees(1.0)),
    "log_gain": ("log shown too much", "%", 100.0),
}
"""What records are off by: words, unit, and factor from SI to it."""


def known_faults(model: Model, records: Sequence[FreeRecord]) -> tuple[str, ...]:
    """Names of the faults that a model's steps tell of records, each once.

    Parameters
    ----------
    model : Model
        With its steps.
    records : sequence of FreeRecord
        Each with the title of its tests.
    """
    titles = dict.fromkeys(record.campaign for record in records)
    return tuple(dict.fromkeys(name for x in titles for name in model.faults_of(x)))


def offsets(model: Model, campaign: str) -> dict[str, float]:
    """What records of some tests are off by, as a model's steps tell, by `effects.seen.OUTSIDE`.

    Parameters
    ----------
    model : Model
        With its steps.
    campaign : str
        Title of the tests.

    Examples
    --------
    >>> from pmmkit.models import load_model
    >>> from pmmkit.models import Step
    >>> found = Step(action="fault_corrected", effect="fault_rudder_zero", campaign="trial",
    ...              coefficients={"angle": 180.0 / math.pi})
    >>> ship = load_model("kvlcc2-l7").stepped(found)
    >>> offsets(ship, "trial"), offsets(ship, "another")
    ({'rudder_zero': 1.0}, {})
    """
    found: dict[str, float] = {}
    for name, step in model.faults_of(campaign).items():
        known = {label: float(x) for label, x in step.coefficients.items()}  # type: ignore[arg-type]
        for label, move in Sailing(model, 1.0).moves(CATALOGUE[name]).items():
            for place, share in move.values.items() if label in known else ():
                found[place] = found.get(place, 0.0) + share * known[label]
    return found


def in_words(found: Mapping[str, float]) -> str:
    """What records are off by, for people.

    Examples
    --------
    >>> in_words({"rudder_zero": 0.0174533, "current_x": -0.2})
    'rudder shown too little 1 deg, current to north -0.2 m/s'
    """
    said = [(*WORDS[name], x) for name, x in found.items()]
    return ", ".join(f"{words} {factor * x:.3g} {unit}" for words, unit, factor, x in said)


def without(record: FreeRecord, found: Mapping[str, float]) -> FreeRecord:
    """A record without what it is off by, in the current that there was."""
    columns = _columns(record.t, {**record.measured, "delta": record.delta}, found)
    delta = columns.pop("delta")
    north, east = (found.get(*known) for known in zip(CURRENT, record.current, strict=True))
    return record.with_(measured=columns, delta=delta, current=(north, east))


def campaign_without(campaign: Campaign, found: Mapping[str, float]) -> Campaign:
    """Free-running tests without what their columns are off by; `current_of` is their current.

    Parameters
    ----------
    campaign : Campaign
        As measured.
    found : mapping of str to float
        By `effects.seen.OUTSIDE`: SI and radians.
    """
    if not found:
        return campaign
    return campaign.with_(
        runs=tuple(run.with_(loader=partial(_data_without, run, found)) for run in campaign.runs)
    )


def _data_without(run: Run, found: Mapping[str, float]) -> xr.Dataset:
    """The data of a run without what its columns are off by."""
    data = run.data
    columns = {str(name): np.asarray(data[name].values) for name in data.data_vars}
    right = _columns(np.asarray(data["t"].values, float), columns, found)
    return data.assign({name: data[name].copy(data=x) for name, x in right.items()})


def current_of(found: Mapping[str, float]) -> tuple[float, float]:
    """The current to north and east [m/s] among what records are off by."""
    return found.get(CURRENT[0], 0.0), found.get(CURRENT[1], 0.0)


def _columns(
    t: Array, columns: Mapping[str, Array], found: Mapping[str, float]
) -> dict[str, Array]:
    """Columns without what they are off by."""
    made = dict(columns)
    if "delta" in made and "rudder_zero" in found:
        made["delta"] = made["delta"] + found["rudder_zero"]
    if "psi" in made and "heading_offset" in found:
        made["psi"] = made["psi"] - found["heading_offset"]
    for name in {"u", "v"} & set(made) if "log_gain" in found else ():
        made[name] = made[name] / (1.0 + found["log_gain"])
    for name in {"x", "y"} & set(made) if "clock_lag" in found else ():
        made[name] = np.interp(t + found["clock_lag"], t, made[name], left=math.nan, right=math.nan)
    if {"x", "y", "psi"} <= set(made) and {"antenna_x", "antenna_y"} & set(found):
        ahead, aside = _direction(t, made["psi"])
        forward, starboard = (found.get(name, 0.0) for name in ("antenna_x", "antenna_y"))
        made["x"] = made["x"] - (forward * ahead - starboard * aside)
        made["y"] = made["y"] - (forward * aside + starboard * ahead)
    return made


def _direction(t: Array, psi: Array) -> tuple[Array, Array]:
    """Cosine and sine of a heading at all instants."""
    there = np.isfinite(psi)
    filled = np.interp(t, t[there], psi[there]) if there.any() else np.zeros(len(t))
    return np.cos(filled), np.sin(filled)
