"""Reading the samples of a run when they are asked for."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING, Final

import numpy as np
from numpy.typing import NDArray

from pmmkit.base import CampaignError, DataError, Problem
from pmmkit.campaigns.campaign import Campaign
from pmmkit.campaigns.motion.hull_path import PLACE, recorded_in
from pmmkit.campaigns.run import Run, at_hand, told_evenly
from pmmkit.campaigns.samples.column_mapping import GAUGES, ColumnSpec, Picked, pick, unread
from pmmkit.campaigns.samples.conversions import (
    Frame,
    Solver,
    seen_from_hull,
    stacked_harmonics,
    to_ours,
    without_ramp,
)
from pmmkit.campaigns.settings import Settings
from pmmkit.campaigns.stated_run import Correction, Kind, StatedRun
from pmmkit.campaigns.test_kinds.kind import Struts, place_on_struts
from pmmkit.conventions import (
    CHANNEL_UNITS,
    CHANNELS,
    FORCE_CHANNELS,
    Ship,
    Water,
    channel_of,
    unit_factor,
)
from pmmkit.numerics import Array, dead_reckoned
from pmmkit.presentation import listed, with_uncertainty
from pmmkit.readers import Columns, Request, reader_for
from pmmkit.signals import FEWEST, head_rest, steady_mean

if TYPE_CHECKING:
    import xarray as xr


# What the campaign file corrects in a run, and why.


OF_SAMPLES = frozenset({"scale", "shift", "flip", "trim", "drop", "tare"})
"""Actions that change the numbers of a run; the others change what is said of it."""


def correct(
    data: Mapping[str, Array], corrections: Sequence[Correction], *, file: str, run: str
) -> tuple[dict[str, Array], list[str], dict[str, tuple[float, float]]]:
    """Channels with the corrections of the campaign file, in its order.

    Values are SI, in ship axes and our signs: corrections come after all conversions. Of harmonics
    ``scale`` and ``flip`` change all parts of a channel, ``shift`` its mean; ``tare`` takes off
    what the forces show while the carriage stands.
    """
    out = dict(data)
    notes: list[str] = []
    tared: dict[str, tuple[float, float]] = {}
    problems: list[Problem] = []
    for correction in corrections:
        if correction.action not in OF_SAMPLES:
            continue
        if correction.action == "trim":
            kept = _trimmed(out, correction)
            if kept is None:
                problems.append(
                    Problem(
                        message=f"the correction {_range(correction)} leaves no samples; they are "
                        f"from t = {out['t'][0]:g} to {out['t'][-1]:g} s."
                        if "t" in out
                        else "the correction trim needs a history; this is a row of a table.",
                        file=file,
                        run=run,
                    )
                )
                continue
            out = kept
            notes.append(f"{_range(correction)} ({correction.reason})")
            continue
        if correction.action == "tare":
            try:
                out, note, zeros = _tared(out, correction)
                tared |= zeros
                notes.append(f"{note} ({correction.reason})")
            except DataError as error:
                problems += [replace(item, file=file, run=run) for item in error.problems]
            continue
        for channel in correction.values["channels"]:
            names = _names(out, channel)
            if not names:
                problems.append(
                    Problem(
                        message=f"the correction {correction.action!r} names channel {channel}, "
                        f"which this run does not have: {', '.join(out)}.",
                        file=file,
                        run=run,
                    )
                )
            out, note = _changed(out, names, channel, correction)
            notes.append(f"{note} ({correction.reason})")
    if problems:
        raise CampaignError(problems)
    return out, notes, tared


def shift_in_si(channel: str, value: float, unit: str | None) -> float | None:
    """A shift in the SI unit of its channel; None if the unit measures something else."""
    if unit is None:
        return value
    si, factor = unit_factor(unit)
    return value * factor if si == CHANNEL_UNITS[channel] else None


def _names(data: Mapping[str, Array], channel: str) -> list[str]:
    return [
        name
        for name in (channel, f"{channel}_std", f"{channel}_cos", f"{channel}_sin")
        if name in data
    ]


def _changed(
    data: dict[str, Array], names: Sequence[str], channel: str, correction: Correction
) -> tuple[dict[str, Array], str]:
    out = dict(data)
    if correction.action == "drop":
        for name in names:
            del out[name]
        return out, f"correction: {channel} dropped"
    if correction.action == "shift":
        value = float(correction.values["value"])
        for name in names:
            if name == channel:
                out[name] = out[name] + value
            elif name.endswith("_cos"):
                out[name] = out[name] + np.where(np.arange(len(out[name])) == 0, value, 0.0)
        return out, f"correction: {channel} shifted by {value:g} {CHANNEL_UNITS[channel]}"
    factor = float(correction.values["factor"]) if correction.action == "scale" else -1.0
    for name in names:
        out[name] = out[name] * (abs(factor) if name.endswith("_std") else factor)
    how = f"times {factor:g}" if correction.action == "scale" else "sign changed"
    return out, f"correction: {channel} {how}"


def _trimmed(data: dict[str, Array], correction: Correction) -> dict[str, Array] | None:
    if "t" not in data:
        return None
    start = correction.values.get("t_start", -np.inf)
    end = correction.values.get("t_end", np.inf)
    inside = (data["t"] >= start) & (data["t"] <= end)
    return {name: numbers[inside] for name, numbers in data.items()} if inside.any() else None


def _tared(
    data: Mapping[str, Array], correction: Correction
) -> tuple[dict[str, Array], str, dict[str, tuple[float, float]]]:
    """Channels without what they show at rest: from the times stated, else at the head."""
    named = correction.values.get("channels", [name for name in CHANNELS if name in data])
    absent = [name for name in named if name not in data]
    if "t" not in data or absent or not named:
        what = f"channels {', '.join(absent)}, which this run does not have" if absent else "forces"
        raise DataError(f"the correction 'tare' needs a history with {what}.")
    t, forces = data["t"], np.stack([data[name] for name in named])
    inside = _at_rest(data, correction)
    zero = steady_mean(t[inside], forces[:, inside])
    seconds = float(np.ptp(t[inside]))
    told = ", ".join(
        f"{name} {with_uncertainty(float(x), float(s))} {CHANNEL_UNITS[name]}"
        for name, x, s in zip(named, zero.value, zero.std, strict=True)
    )
    shifted = {name: data[name] - x for name, x in zip(named, zero.value, strict=True)}
    note = f"correction: tared by {seconds:.3g} s of rest: {told} taken off"
    zeros = zip(zero.value.tolist(), zero.std.tolist(), strict=True)
    return {**data, **shifted}, note, dict(zip(named, zeros, strict=True))


def _at_rest(data: Mapping[str, Array], correction: Correction) -> NDArray[np.bool_]:
    """The samples from which the zero is taken."""
    t = data["t"]
    if {"t_start", "t_end"} & set(correction.values):
        low, high = (
            correction.values.get("t_start", -np.inf),
            correction.values.get("t_end", np.inf),
        )
        inside: NDArray[np.bool_] = (t >= low) & (t <= high)
        if np.count_nonzero(inside) < FEWEST:
            raise DataError(
                f"the correction 'tare' takes the rest from t = {low:g} to {high:g} s, where there "
                f"are fewer than {FEWEST} samples: the record runs from {t[0]:g} to "
                f"{t[-1]:g} s."
            )
        return inside
    forces = [data[name] for name in CHANNELS if name in data]
    found = head_rest(t, np.stack(forces), motion=data) if "X" in data else None
    if found is None:
        raise DataError(
            "the correction 'tare' finds no rest at the head of the record: state t_start and "
            "t_end, or leave this run out of the correction (tare = false where [defaults] tare)."
        )
    return np.arange(len(t)) < found.stop


def _range(correction: Correction) -> str:
    bounds = [
        f"{word} t = {correction.values[key]:g} s"
        for word, key in (("from", "t_start"), ("to", "t_end"))
        if key in correction.values
    ]
    return f"correction: trimmed {' '.join(bounds)}"


# Latitude and longitude to metres north and east of the first fix, antenna to midship.


SEMI_MAJOR: Final = 6378137.0
"""Semi-major axis of the WGS84 ellipsoid [m]."""
ECCENTRICITY_2: Final = 6.69437999014e-3
"""Its first eccentricity squared."""
NEAR: Final = 0.5
"""The first fix that lies within so many degrees of the median of all is the origin."""
_ROUNDS: Final = 6


def local_metres(lat: Array, lon: Array, origin: tuple[float, float]) -> tuple[Array, Array]:
    """Metres north and east of a point, in the plane that touches the ellipsoid there.

    x, y [m].

    Notes
    -----
    With N = a/√(1 - e² sin²φ), the radius of curvature in the prime vertical, a fix lies at
    (N cos φ cos Δλ, N cos φ sin Δλ, N (1 - e²) sin φ); the first and the last are turned by the
    latitude of the origin. Distances come out too short by d³/6R²: 4 mm in 10 km, 4 cm in 20 km.
    The meridians converge: north at a point y metres east differs from north at the origin by
    y tan φ/R, 0.09° at 10 km and 45°.

    Examples
    --------
    >>> x, y = local_metres(np.array([52.01]), np.array([4.0]), (52.0, 4.0))
    >>> round(float(x[0]), 2), round(float(y[0]), 2)
    (1112.67, 0.0)
    """
    phi, at = np.radians(lat), math.radians(origin[0])
    east_of = np.radians((lon - origin[1] + 180.0) % 360.0 - 180.0)
    radius = SEMI_MAJOR / np.sqrt(1.0 - ECCENTRICITY_2 * np.sin(phi) ** 2)
    here = SEMI_MAJOR / math.sqrt(1.0 - ECCENTRICITY_2 * math.sin(at) ** 2)
    out = radius * np.cos(phi) * np.cos(east_of) - here * math.cos(at)
    up = (1.0 - ECCENTRICITY_2) * (radius * np.sin(phi) - here * math.sin(at))
    x: Array = -math.sin(at) * out + math.cos(at) * up
    y: Array = radius * np.cos(phi) * np.sin(east_of)
    return x, y


def geographic(x: Array, y: Array, origin: tuple[float, float]) -> tuple[Array, Array]:
    """Latitude and longitude of points so many metres north and east of an origin.

    x, y [m].

    Examples
    --------
    >>> lat, lon = geographic(np.array([1112.65]), np.array([0.0]), (52.0, 4.0))
    >>> round(float(lat[0]), 5), round(float(lon[0]), 5)
    (52.01, 4.0)
    """
    x, y = np.asarray(x, float), np.asarray(y, float)
    lat, lon = np.full_like(x, origin[0]), np.full_like(y, origin[1])
    for _ in range(_ROUNDS):
        north, east = local_metres(lat, lon, origin)
        phi = np.radians(lat)
        bend = 1.0 - ECCENTRICITY_2 * np.sin(phi) ** 2
        meridian = SEMI_MAJOR * (1.0 - ECCENTRICITY_2) / bend**1.5
        parallel = SEMI_MAJOR / np.sqrt(bend) * np.cos(phi)
        lat = lat + np.degrees((x - north) / meridian)
        lon = lon + np.degrees((y - east) / parallel)
    return lat, lon


def out_of_range(values: Mapping[str, Array]) -> str | None:
    """What is wrong with the latitudes and longitudes of a run, or None."""
    for name, limit in (("lat", 90.0), ("lon", 360.0)):
        if name in values and len(values[name]) and float(np.abs(values[name]).max()) > limit:
            return (
                f"{name} goes from {values[name].min():.10g} to {values[name].max():.10g}; "
                f"degrees lie within ±{limit:g}."
            )
    return None


def placed(
    values: Mapping[str, Array], antenna: tuple[float, float]
) -> tuple[dict[str, Array], list[str]]:
    """Channels with the position of midship as x and y [m].

    antenna [m].
    """
    out, notes = dict(values), []
    if {"lat", "lon"} <= set(out) and not {"x", "y"} & set(out):
        origin = _origin(out["lat"], out["lon"])
        out["x"], out["y"] = local_metres(out["lat"], out["lon"], origin)
        notes.append(
            f"x north and y east of {origin[0]:.7f}°, {origin[1]:.7f}° from lat and lon (WGS84)"
        )
    forward, starboard = antenna
    if (forward or starboard) and {"x", "y", "psi"} <= set(out):
        cos, sin = np.cos(out["psi"]), np.sin(out["psi"])
        out["x"] = out["x"] - (forward * cos - starboard * sin)
        out["y"] = out["y"] - (forward * sin + starboard * cos)
        notes.append(
            f"position moved to midship from an antenna {forward:g} m forward and "
            f"{starboard:g} m to starboard"
        )
    return out, notes


def _origin(lat: Array, lon: Array) -> tuple[float, float]:
    """The first fix that is no wild one."""
    middle = float(np.median(lat)), float(np.median((lon - lon[0] + 180.0) % 360.0 - 180.0))
    off = np.hypot(lat - middle[0], (lon - lon[0] + 180.0) % 360.0 - 180.0 - middle[1])
    near = np.flatnonzero(off < NEAR)
    first = int(near[0]) if len(near) else 0
    return float(lat[first]), float(lon[first])


_OF_PATH: Final = (*PLACE, "u", "v", "r")
"""Channels that a file of the motion may hold."""
STRUT_CHANNELS: Final = frozenset({"y_forward", "y_aft"})
"""Positions of two struts across the tank, which tell place and heading of the hull."""


@dataclass(frozen=True, kw_only=True)
class Context:
    """What the numbers of a run must be seen with to become SI.

    `speed`: speed of the run [m/s]. `frame`: axes, signs and system of the source.
    `corrections`: those that apply to the run. `notes`: conversions of the settings, in words.
    `antenna`: place of the antenna of a free-running record, forward of midship and to
    starboard [m]. `solver`: what the forces of a CFD refer to. `settings`: what it was set to.
    `struts`: the mechanism that swings the model. `side_gauges`: where the two gauges of the side
    force stand, forward of midship [m].
    """

    ship: Ship
    water: Water
    speed: float
    frame: Frame
    corrections: tuple[Correction, ...] = ()
    notes: tuple[str, ...] = ()
    antenna: tuple[float, float] = (0.0, 0.0)
    solver: Solver = field(default_factory=Solver)
    test: str = ""
    settings: Settings | None = None
    struts: Struts | None = None
    side_gauges: tuple[float, float] | None = None


@dataclass(frozen=True, kw_only=True)
class HistoryLoader:
    """Reads a history each time it is called.

    `columns`: where the channels stand. `context`: how to make them SI. `kind`: kind of
    campaign: says which channels must be there. `rows`: number of rows that the campaign file
    says the file has. `motion`: a further file with the path of the hull.
    """

    request: Request
    columns: Mapping[str, ColumnSpec]
    context: Context
    kind: str = "captive"
    rows: int | None = None
    motion: Request | None = None

    @property
    def path(self) -> Path:
        """The file; of one behind a URL only its name."""
        return self.request.path

    @property
    def requests(self) -> tuple[Request, ...]:
        """The file, and that of the motion where there is one."""
        return (self.request,) if self.motion is None else (self.request, self.motion)

    @property
    def untrimmed(self) -> HistoryLoader:
        """Without the corrections that cut off a part of the record."""
        left = tuple(item for item in self.context.corrections if item.action != "trim")
        return replace(self, context=replace(self.context, corrections=left))

    def __call__(self) -> xr.Dataset:
        request = at_hand(self.request)
        rate = request.options.sample_rate
        required = [x for x in Campaign.REQUIRED[self.kind] if x != "t" or rate is None]
        columns = self.columns if self.motion is None else _in_file(request, self.columns)
        read, picked, usual = read_columns(request, columns, required)
        count = len(read.values[0])
        check_rows(count + read.dropped, self.rows, request)
        notes = [*read.notes, *(column.note for column in picked if column.note)]
        notes += [
            f"{column.name} from column {column.title!r}, its usual name"
            for column in picked
            if column.name in usual and column.name not in self.columns
        ]
        notes += [
            f"{Run.DOUBTFUL}{doubt}; settle it with {key} under [cfd]"
            for key, doubt in read.unsettled.items()
            if key not in self.context.solver.stated
        ]
        notes += unread(read.headers, picked, self.columns)
        if read.dropped:
            notes.append(f"{read.dropped} of {count + read.dropped} rows without a value left out")
        values = {
            column.name: column.apply(numbers)
            for column, numbers in zip(picked, read.values, strict=True)
        }
        if rate is not None:
            values["t"] = _counted_time(read, rate, request)
            notes.append(f"t counted from 0 at {rate:g} samples a second")
        return dataset(
            "history",
            values,
            self.context,
            notes,
            request=request,
            dimensional=frozenset(column.name for column in picked if column.unit is not None),
            motion=None
            if self.motion is None
            else _motion_of(at_hand(self.motion), self.columns, self.context),
        )


def read_columns(
    request: Request, specs: Mapping[str, ColumnSpec], required: Sequence[str]
) -> tuple[Columns, list[Picked], Mapping[str, str]]:
    """The columns of a file that are used, what each of them is, and usual names of the format.

    Parameters
    ----------
    request : Request
        The file.
    specs : mapping of str to ColumnSpec
        Where the campaign file says that channels stand.
    required : sequence of str
        Channels that must be there.

    Raises
    ------
    CampaignError
        If one of them is not there, or the file cannot be read.
    """
    picked: list[Picked] = []
    usual: dict[str, str] = {}
    reader = reader_for(request)

    def choose(headers: Sequence[str], width: int) -> list[int]:
        usual.update(reader.usual(headers))
        found, problems = pick(headers, width, specs, request, required=required, usual=usual)
        if request.options.sample_rate is not None:
            problems += _two_times(found, request)
        if not found and not problems:
            problems.append(request.problem("no column of the file is used."))
        if problems:
            raise request.error(*problems)
        picked.extend(found)
        return [column.position for column in found]

    return reader.columns(request, choose), picked, usual


def _there(request: Request, specs: Mapping[str, ColumnSpec]) -> dict[str, ColumnSpec]:
    """Those of some places of channels whose header a file has; not asked where there are none."""
    titles = set(reader_for(request).names(request)) if specs else set()
    return {name: spec for name, spec in specs.items() if spec.name in titles}


def _in_file(request: Request, specs: Mapping[str, ColumnSpec]) -> dict[str, ColumnSpec]:
    """Where channels stand, without those of the path that another file holds."""
    path = {name: x for name, x in specs.items() if channel_of(name) in _OF_PATH and x.name}
    own = _there(request, path)
    return {name: spec for name, spec in specs.items() if name not in path or name in own}


def _motion_of(
    request: Request, specs: Mapping[str, ColumnSpec], context: Context
) -> dict[str, Array]:
    """The path of the hull from a file of its own, SI, our axes and signs."""
    moved = ("t", *_OF_PATH)
    own = _there(request, {name: x for name, x in specs.items() if channel_of(name) in moved})
    read, picked, _ = read_columns(request, own, ("t",))
    values = {
        column.name: column.apply(numbers)
        for column, numbers in zip(picked, read.values, strict=True)
        if column.name in moved
    }
    return to_ours(
        values, frame=context.frame, ship=context.ship, water=context.water, speed=context.speed
    )[0]


@dataclass(frozen=True, kw_only=True)
class RowLoader:
    """Gives a row of a table, or its rows that are samples, read when the campaign was opened.

    `request`: the file the row stands in. `kind`: what the row holds, or the rows. `values`:
    channels, means and parts of harmonics after conversion of units; of a history its samples.
    `dimensional`: those whose unit was stated. `turned`: whether the motion of the test changes
    sign with the axes. `context`: how to make them SI.
    """

    request: Request
    kind: Kind
    values: Mapping[str, float | tuple[float, ...]]
    context: Context
    dimensional: frozenset[str] = frozenset()
    turned: bool = False
    notes: tuple[str, ...] = ()

    @property
    def path(self) -> Path:
        """The file."""
        return self.request.path

    @property
    def requests(self) -> tuple[Request, ...]:
        """The file."""
        return (self.request,)

    def __call__(self) -> xr.Dataset:
        return dataset(
            self.kind,
            {name: np.atleast_1d(value) for name, value in self.values.items()},
            self.context,
            self.notes,
            request=self.request,
            dimensional=self.dimensional,
            turned=self.turned,
        )


def dataset(
    kind: Kind,
    values: Mapping[str, Array],
    context: Context,
    notes: Sequence[str],
    *,
    request: Request,
    dimensional: frozenset[str] = frozenset(),
    turned: bool = False,
    motion: Mapping[str, Array] | None = None,
) -> xr.Dataset:
    """Channels in SI, ship axes and our signs as a Dataset, with every conversion in ``attrs``."""
    import xarray as xr

    said = [*context.notes, *notes]
    wrong = out_of_range(values)
    if wrong is not None:
        raise request.error(wrong, remedy="Write degrees with decimals, west and south negative.")
    values, summed = _summed(values, context, request)
    if kind == "history":
        values["t"], evened = told_evenly(values["t"])
        said += evened
    said += summed
    on_earth = {"lat", "lon"} <= set(values) and not {"x", "y"} & set(values)
    compass: dict[str, Array] = {
        name: values[name] for name in ("psi", "cog") if on_earth and name in values
    }
    converted, more = to_ours(
        {name: numbers for name, numbers in values.items() if name not in compass},
        frame=context.frame,
        ship=context.ship,
        water=context.water,
        speed=context.speed,
        dimensional=dimensional,
        turn_harmonics=kind == "harmonics" and turned,
    )
    converted, moved = placed({**converted, **compass}, context.antenna)
    said += moved
    if kind == "history":
        converted, carried = _carried(converted, context, request)
        said += carried
    converted, seen = _seen(kind, converted, context, request, motion)
    if kind == "harmonics":
        others = {name: numbers for name, numbers in converted.items() if name in CHANNEL_UNITS}
        converted = {**others, **stacked_harmonics(converted)}
    converted, corrections, tared = correct(
        converted, context.corrections, file=request.shown, run=request.run or ""
    )
    reckoned = _reckoned(converted) if kind == "history" else {}
    converted = {**converted, **reckoned}
    said += [*more, *seen, *corrections]
    if reckoned:
        said.append(f"{listed([*reckoned])} by dead reckoning from the velocities: not measured")
    variables: dict[str, tuple[object, ...]] = {}
    for name, numbers in converted.items():
        unit = {"units": CHANNEL_UNITS[_channel(name)]}
        unit |= {Run.RECKONED: "from velocities"} if name in reckoned else {}
        if kind == "history":
            variables[name] = ("t", numbers, unit)
        elif len(numbers) > 1 or (name not in CHANNEL_UNITS and not name.endswith("_std")):
            variables[name] = ("harmonic", numbers, unit)
        else:
            variables[name] = ((), numbers[0], unit)
    coordinates = {}
    if kind == "history":
        coordinates["t"] = variables.pop("t")
    elif kind == "harmonics":
        size = max(len(numbers) for numbers in converted.values())
        coordinates["harmonic"] = ("harmonic", np.arange(size))
    return xr.Dataset(
        variables,
        coords=coordinates,
        attrs={
            "conversions": json.dumps(said, ensure_ascii=False),
            "source": request.shown,
            "run": request.run or "",
            **({"tared": json.dumps(tared)} if tared else {}),
        },
    )


def _reckoned(values: Mapping[str, Array]) -> dict[str, Array]:
    """The track of a ship that runs free, where only her velocities are recorded."""
    free = {"u", "v", "t"} <= set(values) and not {"x", "y", *FORCE_CHANNELS} & set(values)
    if not free or not {"psi", "r"} & set(values):
        return {}
    x, y, psi = dead_reckoned(
        values["t"], (values["u"], values["v"]), rate=values.get("r"), psi=values.get("psi")
    )
    return {"x": x, "y": y, **({} if "psi" in values else {"psi": psi})}


def _summed(
    values: Mapping[str, Array], context: Context, request: Request
) -> tuple[dict[str, Array], list[str]]:
    """Side force and yaw moment of two gauges, along the axes of the file; a column of Y or N
    stands for itself."""
    present = GAUGES & set(values)
    if not present:
        return dict(values), []
    if present != GAUGES:
        raise request.error(
            f"{', '.join(sorted(present))} is there without {', '.join(sorted(GAUGES - present))}.",
            remedy="Map both gauges under [columns], or leave out the one with = false.",
        )
    if context.side_gauges is None:
        raise request.error(
            "Y_forward and Y_aft need the places of the gauges.",
            remedy="State them: side_gauges_x = [forward, aft] under [campaign], forward of "
            "midship in metres.",
        )
    ahead = -1.0 if "x" in context.frame.reversed_axes else 1.0
    levers = [ahead * (x - context.solver.centre_x) for x in context.side_gauges]
    forces = values["Y_forward"], values["Y_aft"]
    found = {"Y": forces[0] + forces[1], "N": levers[0] * forces[0] + levers[1] * forces[1]}
    kept = {name: x for name, x in values.items() if name not in GAUGES}
    own = [name for name in found if name not in kept]
    places = " and ".join(f"{x:g}" for x in context.side_gauges)
    said = [f"{', '.join(own)} from two gauges, {places} m forward of midship"] if own else []
    return {**found, **kept}, said


def _carried(
    values: Mapping[str, Array], context: Context, request: Request
) -> tuple[dict[str, Array], list[str]]:
    """Place and heading of the hull instead of the positions of its struts."""
    present = STRUT_CHANNELS & set(values)
    if not present:
        return dict(values), []
    if present != STRUT_CHANNELS:
        raise request.error(
            f"{', '.join(sorted(present))} is there without "
            f"{', '.join(sorted(STRUT_CHANNELS - present))}.",
            remedy="Map both struts under [columns], or leave out the one with = false.",
        )
    if context.struts is None:
        raise request.error(
            "y_forward and y_aft need the distance of the struts.",
            remedy="State it: [struts] with spacing = … in metres.",
        )
    forward, aft = values["y_forward"], values["y_aft"]
    drift = 0.0 if context.settings is None else context.settings.drift
    leans = float(np.arctan(np.mean(forward - aft) / context.struts.spacing))
    turned = drift if abs(leans) <= abs(leans - drift) else 0.0
    found = place_on_struts(forward, aft, context.struts, turned)
    kept = {name: x for name, x in values.items() if name not in STRUT_CHANNELS}
    own = [name for name in found if name not in kept]
    said = f"{', '.join(own)} from two struts {context.struts.spacing:g} m apart"
    if drift:
        said += (
            f", on which the model is turned by {math.degrees(drift):.4g}°"
            if turned
            else ", whose distance across the tank holds the drift angle"
        )
    return {**found, **kept}, [said] if own else []


def _seen(
    kind: Kind,
    values: Mapping[str, Array],
    context: Context,
    request: Request,
    motion: Mapping[str, Array] | None,
) -> tuple[dict[str, Array], list[str]]:
    """Forces of a CFD as the hull feels them, without the start-up of the computation."""
    run = request.run or ""
    notes: list[str] = []
    if kind == "history":
        values, notes = without_ramp(values, context.solver.ramp, file=request.shown, run=run)
    if context.settings is None:
        return dict(values), notes
    bare = StatedRun(id=run, test=context.test, kind=kind, settings=context.settings)
    if motion is not None:
        moved = recorded_in(motion, values["t"], bare, context.solver.needed)
        values = {**values, **moved}
        notes.append(f"motion from a file of its own: {', '.join(moved)}")
    turned, more = seen_from_hull(values, context.solver, bare)
    return turned, [*notes, *more]


def _channel(name: str) -> str:
    for suffix in ("_std", "_cos", "_sin"):
        name = name.removesuffix(suffix)
    return name


def _two_times(picked: Sequence[Picked], request: Request) -> list[Problem]:
    """The problem of a column of time beside a stated sample rate."""
    return [
        request.problem(
            f"sample_rate = {request.options.sample_rate:g} is stated, and the file has a column "
            "of time.",
            column=column.title,
            remedy="Leave sample_rate out, or write t = false under [columns].",
        )
        for column in picked
        if column.name == "t"
    ]


def _counted_time(read: Columns, rate: float, request: Request) -> Array:
    """Time of each row from its place in the file."""
    if read.dropped:
        raise request.error(
            f"{read.dropped} rows lack a value and would be left out; time is counted by rows.",
            remedy="Fill the gaps, or give the file a column of time.",
        )
    return np.arange(len(read.values[0])) / rate


def check_rows(found: int, stated: int | None, request: Request) -> None:
    """Refuse a file that has not as many rows as the campaign file says."""
    if stated is not None and found != stated:
        raise request.error(
            f"there are {found} rows of numbers; the campaign file says {stated}.",
            remedy="Copy the file again, or correct rows.",
        )
