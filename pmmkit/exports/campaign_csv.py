"""A campaign as CSV files, one a history, with the campaign file that reads them back."""

from __future__ import annotations

import csv
import io
import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from datetime import datetime
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from pmmkit.base import CampaignError, DataError, FileExists, Problem
from pmmkit.campaigns import RUN_SETTINGS, Campaign, Run, TypeB, open_campaign
from pmmkit.conventions import CHANNEL_UNITS, FORCE_CHANNELS
from pmmkit.exports.text import written_by
from pmmkit.files import CAMPAIGN, atomic_folder, toml_text
from pmmkit.numerics import ABSURD
from pmmkit.presentation import safe_cell
from pmmkit.readers import safe_names
from pmmkit.syntax import comment, plain

if TYPE_CHECKING:
    import xarray as xr


# The campaign file that reads an exported campaign back: settings, particulars, uncertainties.


_ZERO: Final = ("drift", "heel", "rudder", "phase")
"""Settings that are zero where nothing is stated, and are written first."""
_NEXT: Final = ("yaw_amplitude", "rudder_amplitude", "switch", "amplitude", "period")
"""Those that are written next; the others follow in the order of their keys."""
_SHIP: Final = {
    "name": "name",
    "L": "L",
    "B": "B",
    "d": "d",
    "volume": "volume",
    "mass": "mass",
    "Izz": "Izz",
    "xG": "xG",
    "zG": "zG",
    "GM": "GM",
    "Ixx": "Ix",
    "balance_mass": "balance_mass",
    "balance_Izz": "balance_Izz",
    "balance_xG": "balance_xG",
    "block_stated": "CB",
}
_WATER: Final = ("rho", "g", "nu", "depth", "tank_width", "tank_depth")


def campaign_text(campaign: Campaign, entries: Mapping[str, Mapping[str, Any]]) -> str:
    """The text of ``campaign.toml`` for runs whose data are SI, in ship axes, corrected."""
    every = _every(campaign)
    kept = [run for run in every if run.id in entries]
    known = campaign_tables(campaign)
    data: dict[str, Any] = {
        **{name: known[name] for name in ("campaign", "ship", "water")},
        "struts": strut_table(campaign, kept),
        **known,
        "corrections": _corrections(campaign, kept),
        "runs": [
            {
                "id": run.id,
                "test": run.test,
                **({"started": datetime.fromisoformat(run.started)} if run.started else {}),
                **settings_of(run),
                **entries[run.id],
            }
            for run in kept
        ],
    }
    lines = [
        *written_by("#"),
        *comment(
            "Data are SI, in ship axes and signs of pmmkit; conversions and corrections of samples "
            "have been applied.",
            "#",
        ),
        *(
            line
            for key, value in campaign.provenance.items()
            for line in comment(f"Source, {key}: {value}", "#")
        ),
        *(line for told in _applied(kept) for line in comment(told, "#")),
        *(
            line
            for run, reason in campaign.excluded
            if run.id not in entries
            for line in comment(f"Run {run.id} is not here: {reason}; it cannot be read.", "#")
        ),
    ]
    data = {key: value for key, value in data.items() if value} | {"end": {}}
    try:
        text = toml_text({key: listed(value) for key, value in data.items()})
    except TypeError as error:
        raise CampaignError(
            f"{error}.", remedy="Export the campaign as netcdf, which keeps it."
        ) from error
    return "\n".join(lines) + "\n\n" + text


def _every(campaign: Campaign) -> list[Run]:
    """Runs, check loads, and what is excluded."""
    return [*campaign.runs, *campaign.check_loads, *(run for run, _ in campaign.excluded)]


def campaign_tables(campaign: Campaign) -> dict[str, Any]:
    """The tables of a campaign file that are of no run: head, ship, water, parts, uncertainties."""
    return {
        "campaign": {
            "title": campaign.title,
            "kind": campaign.kind,
            "closed": True,
            "forces": campaign.forces,
            "moment_reference_x": campaign.moment_reference_x,
            "moment_reference_z": campaign.moment_reference_z,
            "motion_reference_x": campaign.motion_reference_x,
            "free": list(campaign.free),
        },
        "ship": _given({key: getattr(campaign.ship, name) for name, key in _SHIP.items()}),
        "water": _given({name: getattr(campaign.water, name) for name in _WATER}),
        "cfd": _cfd(campaign),
        "propeller": campaign.propeller,
        "rudder": campaign.rudder,
        "trial": _trial(campaign),
        "imo": dict(campaign.imo),
        "report": campaign.report,
        "uncertainty": _uncertainty(campaign.uncertainty),
    }


def settings_of(run: Run) -> dict[str, Any]:
    """The settings of a run as a campaign file states them."""
    given, stated = run.settings, run.stated
    found: dict[str, Any] = {} if run.kind_of_test.at_rest else {"speed": given.speed}
    for item in RUN_SETTINGS.ordered(*_ZERO, *_NEXT):
        value = given.value(item.name) if item.kept and item.name != "speed" else None
        key, zero = item.in_file, item.name in _ZERO
        if value is None or (
            zero and not (value or key in stated or (not stated and item.name != "phase"))
        ):
            continue
        found[key] = _before(item.to_si, value, item.to_file(value)) if item.angle else value
    if given.repeat_of is not None:
        found["repeat_of"] = given.repeat_of
    if given.strut_spacing is not None:
        for key in ("amplitude_m", "yaw_amplitude_deg"):
            found.pop(key, None)
        amplitude, lead = run.strut_swing
        found |= {"strut_amplitude_m": amplitude, "strut_phase_deg": math.degrees(lead)}
    return found


def strut_table(campaign: Campaign, runs: Sequence[Run]) -> dict[str, Any]:
    """``[struts]``, the same for all runs that state theirs."""
    found = [run.settings for run in runs if run.settings.strut_spacing is not None]
    if not found:
        return {}
    spacing = found[0].strut_spacing or 0.0
    return {
        "spacing": abs(spacing),
        "centre_x": found[0].strut_centre + campaign.motion_reference_x,
        "slides": "aft" if spacing > 0 else "forward",
    }


def _before(forward: Callable[[float], float], value: float, guess: float) -> float:
    """A number near a guess that becomes a value; the guess itself where there is none."""
    near = [round(guess, 12), guess]
    for toward in (math.inf, -math.inf):
        step = guess
        for _ in range(4):
            step = math.nextafter(step, toward)
            near.append(step)
    return next((item for item in near if forward(item) == value), guess)


def _applied(runs: list[Run]) -> list[str]:
    """Corrections that changed samples, each once."""
    every = (item for run in runs for item in run.corrections if item.changes_samples)
    return list(
        dict.fromkeys(
            f"Correction applied to {', '.join(item.runs)}: {item.action} ({item.reason})"
            for item in every
        )
    )


def _given(values: Mapping[str, Any]) -> dict[str, Any]:
    return {name: value for name, value in values.items() if value is not None}


def listed(value: Any) -> Any:
    """Tuples as lists, so that only what TOML knows is left."""
    if isinstance(value, Mapping):
        return {str(key): listed(item) for key, item in value.items() if item is not None}
    return [listed(item) for item in value] if isinstance(value, list | tuple) else value


def _cfd(campaign: Campaign) -> dict[str, Any]:
    """``[cfd]`` with nothing left to do: factors, axes and start-up have been applied."""
    done = {
        "rho_inf": campaign.water.rho,
        "symmetry_factor": 1.0,
        "forces_in": "body",
        "moment_centre_moves": True,
        "ramp_s": 0.0,
    }
    found = {key: done.get(key, value) for key, value in campaign.cfd.items() if key != "U_SN"}
    return found | ({"U_SN": dict(campaign.numerical)} if campaign.numerical else {})


def _trial(campaign: Campaign) -> dict[str, Any]:
    """``[trial]`` with the antenna at midship, to which the positions have been moved."""
    if campaign.kind == "captive":
        return {}
    return {
        key: value for key, value in campaign.trial.items() if key not in ("antenna_x", "antenna_y")
    }


def _uncertainty(stated: tuple[TypeB, ...]) -> dict[str, Any]:
    found: dict[str, list[dict[str, Any]]] = {}
    for item in stated:
        std: float = item.std
        if item.relative:
            std = _before(lambda percent: percent / 100, std, 100 * std)
        elif item.kind.unit == "deg":
            std = _before(lambda degrees: degrees * (math.pi / 180), std, math.degrees(std))
        unit = {"unit": "%"} if item.relative else {}
        cause = {"common": item.common} if item.common else {}
        entry = {"std": std, **unit, "shared": item.shared, **cause}
        found.setdefault(item.kind.key, []).append(entry)
    return {name: items[0] if len(items) == 1 else items for name, items in found.items()}


def _corrections(campaign: Campaign, kept: list[Run]) -> list[dict[str, Any]]:
    """What is said of runs and not done to their samples."""
    written = {run.id for run in kept}
    found = [
        {"runs": [run.id], "action": "exclude", "reason": reason or "left out"}
        for run, reason in campaign.excluded
        if run.id in written
    ]
    says = {"hydrodynamic": "inertia already removed", "balance": "inertia still inside"}
    for forces, action in says.items():
        other = [run.id for run in kept if run.forces == forces != campaign.forces]
        if other:
            reason = "as in the campaign that was exported"
            found.append({"runs": other, "action": action, "reason": reason})
    wrong = [run.id for run in kept if not run.use_means]
    if wrong:
        reason = "as in the campaign that was exported"
        found.append({"runs": wrong, "action": "drop means", "reason": reason})
    alone = str.maketrans({letter: f"[{letter}]" for letter in "*?["})
    literal = [{**item, "runs": [name.translate(alone) for name in item["runs"]]} for item in found]
    accepted = {
        (item.runs, item.values["check"], item.reason): None
        for run in kept
        for item in run.corrections
        if item.action == "accept"
    }
    return literal + [
        {"runs": list(runs), "action": "accept", "check": check, "reason": reason}
        for runs, check, reason in accepted
    ]


_ROW: Final = "No."
"""Column of a table that numbers its rows."""
LONGEST: Final = 80
"""Letters of a run's id in the name of its file."""
_REMEDY: Final = "Export the campaign as netcdf, which keeps everything."


def write_campaign_csv(campaign: Campaign, folder: str | Path) -> list[str]:
    """Write ``campaign.toml`` and CSV files with ``name [unit]`` headers, all or nothing."""
    if (Path(folder) / CAMPAIGN.file).exists():
        raise FileExists(f"{folder} holds a {CAMPAIGN.file} already. Choose another folder.")
    campaign = campaign.with_open_water()
    with atomic_folder(folder) as part:
        entries = _write_runs(campaign, part)
        text = campaign_text(campaign, entries)
        (part / CAMPAIGN.file).write_text(text, encoding="utf-8", newline="\n")
        _compare(campaign, part, set(entries))
        return sorted(file.name for file in part.iterdir())


def _write_runs(campaign: Campaign, part: Path) -> dict[str, dict[str, Any]]:
    """Write the data; gives what the campaign file says of each run's file."""
    every = _every(campaign)
    left = {run.id for run, _ in campaign.excluded}
    digits = len(str(len(every)))
    names = safe_names((run.id for run in every), "run")
    entries: dict[str, dict[str, Any]] = {}
    tables: dict[tuple[str, ...], list[tuple[Run, list[float]]]] = {}
    problems: list[Problem] = []
    for count, (run, name) in enumerate(zip(every, names, strict=True), start=1):
        try:
            data = run.data
        except DataError as error:
            problems += [] if run.id in left else list(error.problems)
            continue
        found = _unfit(run, data)
        problems += found
        if found:
            continue
        if run.kind != "history":
            columns, values = _row(data, run.kind)
            tables.setdefault((run.kind, *columns), []).append((run, values))
            entries[run.id] = {}
            continue
        file = f"{count:0{digits}}_{name[:LONGEST]}.csv"
        if not problems:
            _history(data, part / file)
        wanted = campaign.REQUIRED[campaign.kind]
        absent: dict[str, Any] = {item: False for item in wanted if item not in data}
        entries[run.id] = {"file": file, "rows": data.sizes["t"]}
        entries[run.id] |= {"columns": absent} if absent else {}
    if problems:
        raise CampaignError(problems, title=f"{campaign.title!r} cannot be written as CSV")
    for file, (_, *columns), rows in _numbered(tables):
        _table(part / file, columns, rows)
        taken = {
            _bare(title): _bare(title) for title in columns if not _taken_unasked(_bare(title))
        }
        for place, (run, _) in enumerate(rows, start=1):
            entries[run.id] = {"file": file, "rows": len(rows), "row": {_ROW: place}}
            if taken:
                entries[run.id]["columns"] = taken
    return {run.id: entries[run.id] for run in every if run.id in entries}


def _numbered(
    tables: Mapping[tuple[str, ...], list[tuple[Run, list[float]]]],
) -> Iterator[tuple[str, tuple[str, ...], list[tuple[Run, list[float]]]]]:
    """Tables with a file name each: ``means.csv``, ``means_2.csv`` …"""
    count: dict[str, int] = {}
    for key, rows in tables.items():
        kind = key[0]
        count[kind] = count.get(kind, 0) + 1
        yield f"{kind}{f'_{count[kind]}' if count[kind] > 1 else ''}.csv", key, rows


def _unfit(run: Run, data: xr.Dataset) -> list[Problem]:
    """What of a run's data cannot stand in a CSV file and be read back."""
    dimension = {"history": ("t",), "means": (), "harmonics": ("harmonic",)}[run.kind]
    problems = []
    if not _is_text(run.id):
        problems.append(Problem(message="its name is no text in UTF-8.", run=ascii(run.id)))
    for name, variable in data.variables.items():
        why = None
        if name == "harmonic":
            continue
        if _unit(str(name), run.kind) is None:
            why = "pmmkit knows no channel of that name"
        elif variable.dims not in (dimension, ()):
            why = f"it stands over {', '.join(map(str, variable.dims))}"
        elif variable.dtype.kind not in "iuf":
            why = f"it holds values of type {variable.dtype}"
        elif run.kind != "harmonics" and not np.isfinite(variable.values).all():
            why = "it has samples without a value"
        elif np.nanmax(np.abs(variable.values), initial=0.0) > ABSURD:
            why = f"it has values beyond {ABSURD:g}"
        if why is not None:
            problems.append(
                Problem(message=f"{why}.", run=run.id, column=str(name), remedy=_REMEDY)
            )
    if run.kind == "history" and "t" not in data.variables:
        problems.append(Problem(message="it has no times.", run=run.id, remedy=_REMEDY))
    return problems


def _is_text(name: str) -> bool:
    try:
        name.encode()
    except UnicodeEncodeError:
        return False
    return True


def _unit(name: str, kind: str) -> str | None:
    """Unit of a variable; None where no file of that kind can hold it."""
    suffixes = {"history": (), "means": ("_std",), "harmonics": ("_cos", "_sin")}[kind]
    for suffix in suffixes:
        name = name.removesuffix(suffix)
    return CHANNEL_UNITS.get(name)


def _history(data: xr.Dataset, path: Path) -> None:
    import pandas as pd

    names = ["t", *(str(name) for name in data.data_vars)]
    size = data.sizes["t"]
    columns = {
        f"{name} [{CHANNEL_UNITS[name]}]": np.broadcast_to(
            np.asarray(data[name].values, dtype=float), (size,)
        )
        for name in names
    }
    pd.DataFrame(columns).to_csv(path, index=False, encoding="utf-8", lineterminator="\n")


def _row(data: xr.Dataset, kind: str) -> tuple[list[str], list[float]]:
    """Headers and numbers of a row of means or harmonics."""
    headers, values = [], []
    for name, variable in data.data_vars.items():
        channel, _, part = str(name).rpartition("_")
        if part not in ("cos", "sin"):
            headers.append(f"{name} [{_unit(str(name), kind)}]")
            values.append(float(variable.values))
            continue
        for order, value in enumerate(np.asarray(variable.values, float).tolist()):
            if math.isnan(value) or (part == "sin" and order == 0):
                continue
            label = f"{channel}_{part}{order}" if order else f"{channel}_mean"
            headers.append(f"{label} [{_unit(str(name), kind)}]")
            values.append(value)
    return headers, values


def _table(path: Path, columns: list[str], rows: list[tuple[Run, list[float]]]) -> None:
    text = io.StringIO(newline="")
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow([_ROW, "run", *columns])
    for place, (run, values) in enumerate(rows, start=1):
        writer.writerow([place, safe_cell(plain(run.id)), *map(repr, values)])
    path.write_text(text.getvalue(), encoding="utf-8", newline="\n")


def _bare(title: str) -> str:
    return title.split(" [")[0]


def _taken_unasked(name: str) -> bool:
    """Whether a column of a table is taken for what its name says without being mapped."""
    channel = name.rpartition("_")[0] or name
    return name in (*FORCE_CHANNELS, "n", "sinkage", "trim") or channel in FORCE_CHANNELS


def _compare(campaign: Campaign, part: Path, written: set[str]) -> None:
    """Read what was written and refuse it where it is not the same."""
    again = open_campaign(part, data=part)
    back = {run.id: run for run in (*again.runs, *(run for run, _ in again.excluded))}
    problems = []
    for run in (*campaign.runs, *(run for run, _ in campaign.excluded)):
        if run.id in written and not _same(run.data, back[run.id].data):
            problems.append(
                Problem(
                    message="what CSV gives back is not what was written.",
                    run=run.id,
                    remedy=_REMEDY,
                )
            )
    if problems:
        raise CampaignError(problems, title=f"{campaign.title!r} cannot be written as CSV")


def _same(one: xr.Dataset, other: xr.Dataset) -> bool:
    if set(one.variables) != set(other.variables):
        return False
    return all(
        np.array_equal(
            np.broadcast_to(one[name].values, other[name].shape), other[name].values, equal_nan=True
        )
        for name in one.variables
    )
