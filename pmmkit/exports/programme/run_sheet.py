"""The sheet of a programme, what each run is set to; and the columns of its records."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, Final

from pmmkit.campaigns import RUN_SETTINGS
from pmmkit.conventions import CHANNEL_UNITS
from pmmkit.diagnosis import Programme
from pmmkit.exports.programme.towed_path import TowedPath

if TYPE_CHECKING:
    import pandas as pd

ALWAYS: Final = ("speed", "drift", "rudder", "heel")
"""Settings that have a column where no run has them too: their zero is an order."""
RECORDED: Final = {
    "t": "time of the sample",
    "X": "force on the model forward, of the balance",
    "Y": "force on the model to starboard",
    "N": "moment that turns the bow to starboard",
    "K": "moment that presses the starboard side down; may be absent",
    "y": "of an oscillating run: where the model is, to starboard of its mean",
    "psi": "of an oscillating run: heading, bow to starboard, the drift angle included",
    "y_forward": "of an oscillating run: the forward strut, to starboard of the middle of the tank",
    "y_aft": "of an oscillating run: the aft strut, likewise",
    "delta": "rudder angle, positive where it turns the model to starboard; may be absent",
    "n": "revolutions of the propeller; may be absent",
    "U_carriage": "speed of the carriage; may be absent",
}
"""What is agreed of the columns of a record."""
_OF_HULL: Final = ("y", "psi")
_OF_STRUTS: Final = ("y_forward", "y_aft")
_DEGREES: Final = frozenset({"psi", "delta"})


def run_sheet(
    programme: Programme,
    *,
    files: Mapping[str, str],
    paths: Mapping[str, TowedPath] | None = None,
    rate: float | None = None,
    struts: Mapping[str, Mapping[str, float]] = MappingProxyType({}),
) -> pd.DataFrame:
    """A row a run in the order of the programme, with units in the heads.

    files: where the record of each run is expected. paths: of a solver, the path of each run; else
    what a carriage asks is told. rate: samples a second. struts: by run, how the two are set.
    """
    import pandas as pd

    rows, waited = [], 0.0
    for run in programme.runs:
        option = run.option
        row: dict[str, Any] = {"number": run.number, "id": run.id, "file": files[run.id]}
        row |= {"test": option.test.replace("_", " ")}
        row |= _settings(run.entry, run.settings.omega)
        if (own := struts.get(run.id)) is not None:
            row["strut amplitude [m]"] = own["strut_amplitude_m"]
            row["lead of the forward strut [deg]"] = own["strut_phase_deg"]
        row |= {"cycles": option.cycles or None, "record [s]": round(option.record, 2)}
        if paths is not None:
            path = paths[run.id]
            row |= {"run-up [s]": path.run_up, "end time [s]": path.end}
        else:
            row = {"number": run.number, "set-up": option.set_up, **row}
            row |= {
                "samples": None if rate is None else round(rate * option.record),
                "tank length at speed [m]": round(run.settings.speed * option.record, 2),
                "wait before the next [min]": round(60 * option.hours - option.record / 60, 2),
                "starts after [h]": round(waited, 3),
            }
        waited += option.hours
        rows.append(row)
    whole = dict.fromkeys(("cycles", "samples"), "Int64")
    table = pd.DataFrame(rows).dropna(axis="columns", how="all")
    return table.astype({name: kind for name, kind in whole.items() if name in table})


def _settings(entry: Mapping[str, Any], omega: float | None) -> dict[str, Any]:
    """What the campaign file says of a run, by heads with units."""
    found: dict[str, Any] = {"repeat of": entry.get("repeat_of")}
    for item in RUN_SETTINGS.ordered(*ALWAYS, "period"):
        if not item.kept or item.surroundings:
            continue
        zero = 0.0 if item.name in ALWAYS else None
        found[f"{item.word or item.in_file} [{item.unit}]"] = entry.get(item.in_file, zero)
        if item.name == "period":
            found["omega [rad/s]"] = None if omega is None else round(omega, 5)
    return found


def record_columns(*, struts: bool = False) -> pd.DataFrame:
    """The heads that the columns of a record have, and what stands in them."""
    import pandas as pd

    left = _OF_HULL if struts else _OF_STRUTS
    names = [name for name in RECORDED if name not in left]
    units = {name: "deg" if name in _DEGREES else CHANNEL_UNITS[name] for name in names}
    return pd.DataFrame(
        {
            "head": [f"{name} [{units[name]}]" for name in names],
            "what": [RECORDED[name] for name in names],
        }
    )
