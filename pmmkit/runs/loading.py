"""Reading the samples of a run when they are asked for."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from pmmkit.errors import CampaignError, DataError, Problem
from pmmkit.files import sha256
from pmmkit.runs.channels import CHANNEL_UNITS
from pmmkit.runs.conversions import Frame, stacked_harmonics, to_ours
from pmmkit.runs.corrections import correct
from pmmkit.runs.geodesy import out_of_range, placed
from pmmkit.runs.picking import ColumnSpec, Picked, pick, required_channels
from pmmkit.runs.readers import reader_for
from pmmkit.runs.readers.base import Array, Columns, Request
from pmmkit.runs.run import Campaign, Correction, Kind
from pmmkit.ship import Ship, Water

if TYPE_CHECKING:
    import xarray as xr


@dataclass(frozen=True, kw_only=True)
class Context:
    """What the numbers of a run must be seen with to become SI.

    Parameters
    ----------
    ship, water : Ship, Water
        Particulars.
    speed : float
        Speed of the run [m/s].
    frame : Frame
        Axes, signs and system of the source.
    corrections : tuple of Correction
        Those that apply to the run.
    notes : tuple of str
        Conversions of the settings, in words.
    antenna : tuple of float
        Place of the antenna of a free-running record, forward of midship and to starboard [m].
    """

    ship: Ship
    water: Water
    speed: float
    frame: Frame
    corrections: tuple[Correction, ...] = ()
    notes: tuple[str, ...] = ()
    antenna: tuple[float, float] = (0.0, 0.0)


@dataclass(frozen=True, kw_only=True)
class HistoryLoader:
    """Reads a history each time it is called.

    Parameters
    ----------
    request : Request
        The file.
    columns : mapping of str to ColumnSpec
        Where the channels stand.
    context : Context
        How to make them SI.
    kind : str
        Kind of campaign: says which channels must be there.
    rows : int or None
        Number of rows that the campaign file says the file has.
    """

    request: Request
    columns: Mapping[str, ColumnSpec]
    context: Context
    kind: str = "captive"
    rows: int | None = None

    @property
    def path(self) -> Path:
        """The file."""
        return self.request.path

    def __call__(self) -> xr.Dataset:
        picked: list[Picked] = []
        rate = self.request.options.sample_rate

        def choose(headers: Sequence[str], width: int) -> list[int]:
            found, problems = pick(
                headers,
                width,
                self.columns,
                self.request,
                required=[
                    name for name in required_channels(self.kind) if name != "t" or rate is None
                ],
            )
            if rate is not None:
                problems += _two_times(found, self.request)
            if not found and not problems:
                problems.append(self.request.problem("no column of the file is used."))
            if problems:
                raise self.request.error(*problems)
            picked.extend(found)
            return [column.position for column in found]

        read = reader_for(self.request).columns(self.request, choose)
        count = len(read.values[0])
        check_rows(count + read.dropped, self.rows, self.request)
        notes = [*read.notes, *(column.note for column in picked if column.note)]
        if read.dropped:
            notes.append(f"{read.dropped} of {count + read.dropped} rows without a value left out")
        values = {
            column.name: column.apply(numbers)
            for column, numbers in zip(picked, read.values, strict=True)
        }
        if rate is not None:
            values["t"] = _counted_time(read, rate, self.request)
            notes.append(f"t counted from 0 at {rate:g} samples a second")
        return dataset(
            "history",
            values,
            self.context,
            notes,
            request=self.request,
            dimensional=frozenset(column.name for column in picked if column.unit is not None),
        )


@dataclass(frozen=True, kw_only=True)
class RowLoader:
    """Gives a row of a table, which was read when the campaign was opened.

    Parameters
    ----------
    request : Request
        The file the row stands in.
    kind : {"means", "harmonics"}
        What the row holds.
    values : mapping of str to float
        Channels, means and parts of harmonics after conversion of units.
    dimensional : frozenset of str
        Those whose unit was stated.
    turned : bool
        Whether the motion of the test changes sign with the axes.
    context : Context
        How to make them SI.
    notes : tuple of str
        Conversions of units.
    """

    request: Request
    kind: Kind
    values: Mapping[str, float]
    context: Context
    dimensional: frozenset[str] = frozenset()
    turned: bool = False
    notes: tuple[str, ...] = ()

    @property
    def path(self) -> Path:
        """The file."""
        return self.request.path

    def __call__(self) -> xr.Dataset:
        return dataset(
            self.kind,
            {name: np.array([value]) for name, value in self.values.items()},
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
) -> xr.Dataset:
    """Channels in SI, ship axes and our signs as a Dataset, with every conversion in ``attrs``.

    Parameters
    ----------
    kind : {"history", "means", "harmonics"}
        What the values are.
    values : mapping of str to array
        After conversion of units.
    context : Context
        How to make them SI.
    notes : sequence of str
        Conversions made before.
    request : Request
        The file, for messages.
    dimensional : frozenset of str
        Names whose unit was stated.
    turned : bool
        For harmonics: whether the motion changes sign with the axes.
    """
    import xarray as xr

    said = [*context.notes, *notes]
    wrong = out_of_range(values)
    if wrong is not None:
        raise request.error(
            request.problem(wrong, remedy="Write degrees with decimals, west and south negative.")
        )
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
    if kind == "harmonics":
        others = {name: numbers for name, numbers in converted.items() if name in CHANNEL_UNITS}
        converted = {**others, **stacked_harmonics(converted)}
    converted, corrections = correct(
        converted, context.corrections, file=request.shown, run=request.run or ""
    )
    said += [*more, *corrections]
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
        },
    )


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
            request.problem(
                f"{read.dropped} rows lack a value and would be left out; time is counted by rows.",
                remedy="Fill the gaps, or give the file a column of time.",
            )
        )
    return np.arange(len(read.values[0])) / rate


def check_rows(found: int, stated: int | None, request: Request) -> None:
    """Refuse a file that has not as many rows as the campaign file says."""
    if stated is not None and found != stated:
        raise request.error(
            request.problem(
                f"there are {found} rows of numbers; the campaign file says {stated}.",
                remedy="Copy the file again, or correct rows.",
            )
        )


def validate(campaign: Campaign) -> list[Problem]:
    """Read every run once and list what is wrong with any of their files.

    Runs that are left out by a correction are not read.

    Parameters
    ----------
    campaign : Campaign
        From `open_campaign`.

    Returns
    -------
    list of Problem
        Empty if every run can be read.
    """
    found: list[Problem] = []
    for run in campaign.runs:
        try:
            run.data  # noqa: B018
        except DataError as error:
            found += [problem for problem in error.problems if problem not in found]
    return found


def file_hashes(campaign: Campaign) -> dict[str, str]:
    """SHA-256 of every data file that the runs of a campaign come from, by the file's name.

    Parameters
    ----------
    campaign : Campaign
        From `open_campaign`. Runs that do not come from a file of their own are passed over.

    Raises
    ------
    CampaignError
        If a file cannot be read.
    """
    files: dict[str, Path] = {}
    for run in (*campaign.runs, *(run for run, _ in campaign.excluded)):
        if isinstance(run.loader, (HistoryLoader, RowLoader)):
            files.setdefault(run.loader.request.shown, run.loader.path)
    hashes: dict[str, str] = {}
    problems: list[Problem] = []
    for shown, path in files.items():
        try:
            hashes[shown] = sha256(path)
        except OSError as error:
            problems.append(Problem(message=f"cannot be read: {error.strerror}.", file=shown))
    if problems:
        raise CampaignError(problems)
    return hashes
