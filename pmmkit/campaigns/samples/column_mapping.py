"""Which columns of a file hold which channels, and by what they become SI."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType
from typing import Final

from pmmkit.base import DataError, Problem, did_you_mean
from pmmkit.campaigns.run_settings import RUN_SETTINGS, unit_of
from pmmkit.conventions import (
    CHANNEL_UNITS,
    DEGREE_CHANNELS,
    FORCE_CHANNELS,
    channel_of,
    factor_to,
    harmonic_part,
    split_unit,
    unit_in_name,
)
from pmmkit.numerics import Array
from pmmkit.readers import Request

_NONE: Final[Mapping[str, str]] = MappingProxyType({})


GAUGES: Final = frozenset({"Y_forward", "Y_aft"})
"""Side forces of two gauges, which tell side force and yaw moment."""


@dataclass(frozen=True, kw_only=True)
class ColumnSpec:
    """Where the campaign file says that a channel stands.

    `name, column`: header of the column, or its number counted from 1. `unit`: its unit where
    the header does not say. `scale, offset`: applied to the numbers before the unit: number *
    scale + offset. `absent`: true if the file has no such column (``X = false``).
    """

    name: str | None = None
    column: int | None = None
    unit: str | None = None
    scale: float = 1.0
    offset: float = 0.0
    absent: bool = False


@dataclass(frozen=True, kw_only=True)
class Picked:
    """A column of a file that is used.

    `name`: our name: a channel, a setting or a part of a harmonic. `position`: column of the
    file, counted from 0. `title`: its header, or its number counted from 1. `scale, offset`:
    applied to its numbers to make them SI (degrees for a setting named ``_deg``). `unit`: unit
    that was stated for it. `note`: the conversion in words, None if there was none.
    """

    name: str
    position: int
    title: str
    scale: float = 1.0
    offset: float = 0.0
    unit: str | None = None
    note: str | None = None

    def apply(self, numbers: Array) -> Array:
        """The column in SI."""
        if self.scale == 1.0 and self.offset == 0.0:
            return numbers
        return numbers * self.scale + self.offset


def pick(
    headers: Sequence[str],
    width: int,
    specs: Mapping[str, ColumnSpec],
    request: Request,
    *,
    table: bool = False,
    required: Iterable[str] = (),
    usual: Mapping[str, str] = _NONE,
) -> tuple[tuple[Picked, ...], list[Problem]]:
    """The columns of a file that are used, and what is wrong with them."""
    problems: list[Problem] = []
    picked: dict[str, Picked] = {}
    bare = [split_unit(header) for header in headers]
    specs = {**_usual_specs(usual, specs, bare), **specs}
    for name, spec in specs.items():
        if not spec.absent and (unit_of(name, table=table) is not None):
            position = _position(name, spec, headers, bare, width, request, problems)
            if position is not None:
                _add(picked, name, position, spec, headers, bare, request, problems, table=table)
    claimed = {column.position for column in picked.values()}
    asked = {channel_of(name) for name in specs} | set(specs)
    plain = {name for name, _ in bare}
    for position, (name, _) in enumerate(bare):
        known = unit_of(name, table=table, unasked=True) is not None
        part = harmonic_part(name) if table else None
        taken = part is None or part[1] != "in"
        channel = name if table and name in RUN_SETTINGS.units else channel_of(name)
        doubled = channel != name and name not in DEGREE_CHANNELS and channel in {*plain, *picked}
        free = position not in claimed and not {name, channel} & asked
        if known and taken and free and not doubled:
            _add(
                picked, name, position, ColumnSpec(), headers, bare, request, problems, table=table
            )
    on_earth = {"lat", "lon"} <= set(picked)
    steered = {"u", "v"} <= set(picked) and bool({"psi", "r"} & set(picked))
    gauged = set(picked) >= GAUGES
    for name in required:
        if gauged and name in ("Y", "N"):
            continue
        if (on_earth or steered) and name in ("x", "y"):
            continue
        if steered and name == "psi" and "r" in picked:
            continue
        if name not in picked and (name not in specs or (name == "t" and specs[name].absent)):
            problems.append(_not_there(name, headers, request))
    return tuple(picked.values()), problems


def unread(
    headers: Sequence[str], picked: Iterable[Picked], specs: Mapping[str, ColumnSpec]
) -> list[str]:
    """What is said of columns that begin like a channel of which nothing was read.

    Examples
    --------
    >>> unread(["t", "r_degs"], [Picked(name="t", position=0, title="t")], {})
    ["column 'r_degs' is not read, for 'degs' is no unit of r: map it under [columns], r = …"]
    """
    taken = list(picked)
    places = {column.position for column in taken}
    known = {column.name for column in taken} | {channel_of(name) for name in specs}
    found = []
    for position, header in enumerate(headers):
        name, _ = split_unit(header)
        channel, line, tail = name.partition("_")
        if position in places or not line or channel not in CHANNEL_UNITS or channel in known:
            continue
        if channel_of(name) == name and name not in CHANNEL_UNITS:
            found.append(
                f"column {header!r} is not read, for {tail!r} is no unit of {channel}: map it "
                f"under [columns], {channel} = …"
            )
    return found


def _usual_specs(
    usual: Mapping[str, str],
    specs: Mapping[str, ColumnSpec],
    bare: Sequence[tuple[str, str | None]],
) -> dict[str, ColumnSpec]:
    """Where channels usually stand, of those that nothing is said of and that are there."""
    titles = [title for title, _ in bare]
    asked = {channel_of(name) for name in specs} | set(titles)
    return {
        name: ColumnSpec(name=header)
        for name, header in usual.items()
        if name not in asked and header in titles
    }


def _add(
    picked: dict[str, Picked],
    name: str,
    position: int,
    spec: ColumnSpec,
    headers: Sequence[str],
    bare: Sequence[tuple[str, str | None]],
    request: Request,
    problems: list[Problem],
    *,
    table: bool,
) -> None:
    title = headers[position] or str(position + 1)
    channel = name if table and name in RUN_SETTINGS.units else channel_of(name)
    if channel in picked:
        problems.append(
            request.problem(
                f"{channel} stands in two columns, {picked[channel].title!r} and {title!r}.",
                column=title,
                remedy="Map the right one under [columns].",
            )
        )
        return
    unit = spec.unit if spec.unit is not None else bare[position][1]
    own = unit_of(name, table=table) or ""
    if unit is None and name not in DEGREE_CHANNELS and unit_in_name(name) is not None:
        unit = own  # it is stated, whatever the file is without dimension
    part = harmonic_part(channel)
    target = (
        own if table and name in RUN_SETTINGS.units else CHANNEL_UNITS[part[0] if part else channel]
    )
    try:
        factor = factor_to(unit if unit is not None else own, target)
    except DataError as error:
        problems.append(request.problem(str(error), column=title))
        return
    if factor is None and unit in ("", "-", "1") and (part or channel in FORCE_CHANNELS):
        if request.options.nondimensional is None:
            problems.append(
                request.problem(
                    f"{channel} is stated without dimension.",
                    column=title,
                    remedy='Say of which system in [source]: nondimensional = "prime".',
                )
            )
            return
        factor, unit = 1.0, None
    if factor is None:
        problems.append(
            request.problem(
                f"{channel} is measured in {target or 'plain numbers'}, not in {unit!r}.",
                column=title,
            )
        )
        return
    picked[channel] = Picked(
        name=channel,
        position=position,
        title=title,
        scale=spec.scale * factor,
        offset=spec.offset * factor,
        unit=unit,
        note=_note(channel, title, spec, unit if unit is not None else own, target, factor),
    )


def _note(
    channel: str, title: str, spec: ColumnSpec, unit: str, target: str, factor: float
) -> str | None:
    parts = []
    if spec.scale != 1.0 or spec.offset != 0.0:
        parts.append(f"number * {spec.scale:g} + {spec.offset:g}")
    if factor != 1.0:
        parts.append(f"{unit} to {target} (times {factor:.10g})")
    return f"{channel} from column {title!r}: {', then '.join(parts)}" if parts else None


def _position(
    name: str,
    spec: ColumnSpec,
    headers: Sequence[str],
    bare: Sequence[tuple[str, str | None]],
    width: int,
    request: Request,
    problems: list[Problem],
) -> int | None:
    if spec.column is not None:
        if spec.column <= width:
            return spec.column - 1
        problems.append(
            request.problem(
                f"{name} should stand in column {spec.column}; the file has {width} columns."
            )
        )
        return None
    wanted = spec.name or ""
    if not any(headers):
        problems.append(
            request.problem(
                f"{name} should stand in column {wanted!r}; the file has no header.",
                remedy=f"Give its number: {name} = {{ column = 1 }}.",
            )
        )
        return None
    for titles in (list(headers), [title for title, _ in bare]):
        places = [place for place, title in enumerate(titles) if title == wanted.strip()]
        if len(places) == 1:
            return places[0]
        if places:
            problems.append(
                request.problem(
                    f"{len(places)} columns are named {wanted!r}.",
                    column=wanted,
                    remedy=f"Give the number of the right one: {name} = {{ column = "
                    f"{places[0] + 1} }}.",
                )
            )
            return None
    problems.append(
        request.problem(
            f"{name} should stand in column {wanted!r}, which is not there"
            f"{did_you_mean(wanted, [title for title, _ in bare]) or '.'} {_list(headers)}"
        )
    )
    return None


_ALSO: Final[dict[str, tuple[str, ...]]] = {
    "t": ("time", "time_s", "zeit", "temps"),
    "X": ("fx", "x", "force x", "surge force", "drag", "surge"),
    "Y": ("fy", "y", "force y", "sway force", "sway"),
    "N": ("mz", "n", "moment z", "yaw moment", "yaw"),
    "psi": ("heading", "yaw"),
    "x": ("x0", "north", "x_position"),
    "y": ("y0", "east", "y_position"),
    "lat": ("latitude",),
    "lon": ("longitude", "long"),
}


def _not_there(name: str, headers: Sequence[str], request: Request) -> Problem:
    if not any(headers):
        return request.problem(
            f"where is {name}? The file has no header.",
            remedy=f"Give its number under [columns]: {name} = {{ column = 1 }}.",
        )
    bare = [(header, split_unit(header)[0].lower()) for header in headers]
    if name in ("x", "y"):
        turned = {"x": "lat", "y": "lon"}[name]
        found = [header for header, word in bare if word in (turned, *_ALSO[turned])]
        if found:
            return request.problem(
                f"there is no column {name}, nor {turned}. {_list(headers)}",
                remedy=f'Say under [columns] which it is: {turned} = "{found[0]}".',
            )
    also = _ALSO.get(name, ())
    likely = [header for header, word in bare if word in also] or [
        header for header, word in bare if set(re.split(r"[\W_]+", word)) & set(also)
    ]
    example = likely[0] if likely else "their name"
    without = (
        "or where there is none state sample_rate = 200.0 [Hz] under [source]"
        if name == "t"
        else f"or {name} = false if it was not measured"
    )
    return request.problem(
        f"there is no column {name}. {_list(headers)}",
        remedy=f'Say under [columns] which it is: {name} = "{example}" ({without}).',
    )


def _list(headers: Sequence[str]) -> str:
    shown = ", ".join(repr(header) for header in headers[:20])
    return f"The file has {shown}{' …' if len(headers) > 20 else ''}."
