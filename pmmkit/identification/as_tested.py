"""Records without the faults, and in the current, that the steps of a model tell of."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
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


@dataclass(frozen=True, kw_only=True)
class RecordOffsets:
    """What records of some tests are off by, and the current that they were sailed in.

    Parameters
    ----------
    values : mapping of str to float
        By `effects.seen.OUTSIDE`: SI and radians.
    """

    values: Mapping[str, float]

    @classmethod
    def of(cls, model: Model, campaign: str) -> RecordOffsets:
        """As a model's steps tell.

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
        >>> RecordOffsets.of(ship, "trial").words, RecordOffsets.of(ship, "another").values
        ('rudder shown too little 57.3 deg', {})
        """
        found: dict[str, float] = {}
        for name, step in model.faults_of(campaign).items():
            known = {label: float(x) for label, x in step.coefficients.items()}  # type: ignore[arg-type]
            for label, move in Sailing(model, 1.0).moves(CATALOGUE[name]).items():
                for place, share in move.values.items() if label in known else ():
                    found[place] = found.get(place, 0.0) + share * known[label]
        return cls(values=found)

    @property
    def current(self) -> tuple[float, float]:
        """To north and east [m/s]."""
        return self.values.get(CURRENT[0], 0.0), self.values.get(CURRENT[1], 0.0)

    @property
    def words(self) -> str:
        """For people."""
        said = [(*WORDS[name], x) for name, x in self.values.items()]
        return ", ".join(f"{words} {factor * x:.3g} {unit}" for words, unit, factor, x in said)

    def taken_off(self, campaign: Campaign) -> Campaign:
        """Free-running tests without what their columns are off by."""
        if not self.values:
            return campaign
        return campaign.with_(
            runs=tuple(
                run.with_(loader=partial(_data_without, run, self.values)) for run in campaign.runs
            )
        )


def without(record: FreeRecord, found: Mapping[str, float]) -> FreeRecord:
    """A record without what it is off by, in the current that there was."""
    columns = _columns(record.t, {**record.measured, "delta": record.delta}, found)
    delta = columns.pop("delta")
    north, east = (found.get(*known) for known in zip(CURRENT, record.current, strict=True))
    return record.with_(measured=columns, delta=delta, current=(north, east))


def _data_without(run: Run, found: Mapping[str, float]) -> xr.Dataset:
    """The data of a run without what its columns are off by."""
    data = run.data
    columns = {str(name): np.asarray(data[name].values) for name in data.data_vars}
    right = _columns(np.asarray(data["t"].values, float), columns, found)
    return data.assign({name: data[name].copy(data=x) for name, x in right.items()})


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
