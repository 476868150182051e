"""Reading the samples of a run when they are asked for."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING, Final

import numpy as np

from pmmkit.base import Problem
from pmmkit.campaigns.campaign import Campaign
from pmmkit.campaigns.motion.hull_path import PLACE, recorded_in
from pmmkit.campaigns.motion.solver_axes import Solver, seen_from_hull, without_ramp
from pmmkit.campaigns.run import Run, at_hand
from pmmkit.campaigns.samples.column_mapping import ColumnSpec, Picked, pick, unread
from pmmkit.campaigns.samples.conversions import Frame, stacked_harmonics, to_ours
from pmmkit.campaigns.samples.corrections import correct
from pmmkit.campaigns.samples.geodesy import out_of_range, placed
from pmmkit.campaigns.settings import Settings
from pmmkit.campaigns.stated_run import Correction, Kind, StatedRun
from pmmkit.campaigns.test_kinds.struts import Struts, place_on_struts
from pmmkit.conventions import CHANNEL_UNITS, Ship, Water
from pmmkit.numerics import Array
from pmmkit.readers import Columns, Request, reader_for

if TYPE_CHECKING:
    import xarray as xr


STRUT_CHANNELS: Final = frozenset({"y_forward", "y_aft"})
"""Positions of two struts across the tank, which tell place and heading of the hull."""


@dataclass(frozen=True, kw_only=True)
class Context:
    """What the numbers of a run must be seen with to become SI.

    `speed`: speed of the run [m/s]. `frame`: axes, signs and system of the source.
    `corrections`: those that apply to the run. `notes`: conversions of the settings, in words.
    `antenna`: place of the antenna of a free-running record, forward of midship and to
    starboard [m]. `solver`: what the forces of a CFD refer to. `settings`: what it was set to.
    `struts`: the mechanism that swings the model.
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
        read, picked, usual = read_columns(request, self.columns, required)
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
            motion=None if self.motion is None else _motion_of(at_hand(self.motion), self.context),
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


def _motion_of(request: Request, context: Context) -> dict[str, Array]:
    """The path of the hull from a file of its own, SI, our axes and signs."""
    read, picked, _ = read_columns(request, {}, ("t",))
    values = {
        column.name: column.apply(numbers)
        for column, numbers in zip(picked, read.values, strict=True)
        if column.name in ("t", *PLACE, "u", "v", "r")
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
    on_earth = {"lat", "lon"} <= set(values) and not {"x", "y"} & set(values)
    compass = {name: values[name] for name in ("psi", "cog") if on_earth and name in values}
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
    said += [*more, *seen, *corrections]
    variables: dict[str, tuple[object, ...]] = {}
    for name, numbers in converted.items():
        unit = {"units": CHANNEL_UNITS[_channel(name)]}
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
