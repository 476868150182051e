"""Exports of monitors and plots of Simcenter STAR-CCM+ (.csv): one file, or several of one run.

The header of an export is quoted; its first column is what the plot goes by (physical time or
iterations, in the language of the program), the others are named after monitors:
``"Fx Monitor: Force (N)"``, ``"Drag Monitor: Drag Monitor (N)"``, ``"Fx Monitor 2: Force (N)"`` for
a copy, ``"Continuity: Residual"``. Every column is offered as ``name [unit]``, without "Monitor".
"""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from pathlib import Path
from typing import Final

import numpy as np
from numpy.typing import NDArray

from pmmkit.base import DataError, Problem
from pmmkit.conventions import is_unit, split_unit, unit_factor
from pmmkit.files import matching
from pmmkit.numerics import Array
from pmmkit.readers.base import Choose, Columns, Request, head_of
from pmmkit.readers.text.csv import numbers
from pmmkit.readers.text.heading import fields_of
from pmmkit.readers.text.splitting import Text, surely_whole, take_apart

# Several files of one run put together on their time, without any interpolation.
#
# Files with other columns stand side by side: the times of each must be among those of the
# longest, and rows are kept at the times that all have. Files with the same columns follow each
# other in time: where they overlap they must agree, unless the campaign file states in which order
# they were computed; then a later one counts from its first time step on.


Mask = NDArray[np.bool_]
Places = NDArray[np.intp]

SAME_STEP: Final = 1e-2
"""Times that differ by less than this share of a time step are the same."""
_AGREE: Final = 1e-6
"""Numbers of two files agree within this share of the largest of their column."""


@dataclass(frozen=True, kw_only=True)
class ColumnPart:
    """Columns over time of one file or of several put together.

    `notes`: what was left out.
    """

    files: tuple[str, ...]
    times: Array
    values: Mapping[str, Array]
    notes: tuple[str, ...] = ()

    @property
    def name(self) -> str:
        """The files, for messages."""
        return " + ".join(self.files)

    def taken(self, rows: Mask) -> ColumnPart:
        """Some rows."""
        return replace(
            self,
            times=self.times[rows],
            values={header: numbers[rows] for header, numbers in self.values.items()},
        )


def steps(name: str, times: Array, values: Mapping[str, Array], request: Request) -> ColumnPart:
    """The last row of each time step.

    Examples
    --------
    >>> from pathlib import Path
    >>> request = Request(path=Path("a.csv"), shown="a.csv")
    >>> inner = {"Fx": np.array([3.0, 2.5, 2.4, 2.2])}
    >>> part = steps("a.csv", np.array([0.1, 0.1, 0.2, 0.2]), inner, request)
    >>> part.times, part.values["Fx"]
    (array([0.1, 0.2]), array([2.5, 2.2]))
    """
    back = np.flatnonzero(np.diff(times) < 0)
    if len(back):
        before, after = times[back[0]], times[back[0] + 1]
        raise request.error(
            f"time goes back from {before:.10g} to {after:.10g} after "
            f"{back[0] + 1} rows of numbers.",
            remedy="Make a file of each part; state their order in [source] if they overlap.",
        )
    last = np.append(np.diff(times) > 0, True)
    part = ColumnPart(files=(name,), times=times, values=values)
    if last.all():
        return part
    inner = len(last) - np.count_nonzero(last)
    said = f"{name}: {inner} rows of inner iterations left out, the last of each time step kept"
    return replace(part.taken(last), notes=(said,))


def merged(parts: Sequence[ColumnPart], request: Request) -> ColumnPart:
    """All files of a run as one."""
    groups: dict[frozenset[str], list[ColumnPart]] = {}
    for part in parts:
        groups.setdefault(frozenset(part.values), []).append(part)
    shared = [
        request.problem(
            f"{', '.join(sorted(one & other))} stands in {groups[one][0].name} and in "
            f"{groups[other][0].name}, which have different columns.",
            remedy="Leave one of them out by the pattern in file, or export each column once.",
        )
        for index, one in enumerate(groups)
        for other in list(groups)[:index]
        if one & other
    ]
    if shared:
        raise request.error(*shared)
    unknown = set(request.options.order) - {part.name for part in parts}
    if unknown:
        raise request.error(
            f"order in [source] names {', '.join(sorted(unknown))}; the files are "
            f"{', '.join(part.name for part in parts)}."
        )
    return _side_by_side([_in_sequence(listed, request) for listed in groups.values()], request)


def _in_sequence(parts: Sequence[ColumnPart], request: Request) -> ColumnPart:
    """Files with the same columns, one after the other in time."""
    order = request.options.order
    stated = all(part.name in order for part in parts)
    whole, *others = sorted(
        parts, key=lambda part: order.index(part.name) if stated else float(part.times[0])
    )
    for part in others:
        whole = _later_counts(whole, part) if stated else _agreeing(whole, part, request)
    return whole


def _later_counts(earlier: ColumnPart, later: ColumnPart) -> ColumnPart:
    kept = earlier.taken(earlier.times < later.times[0] - _tolerance(earlier.times))
    lost = len(earlier.times) - len(kept.times)
    said = (
        f"{later.name} counts from {later.times[0]:.10g} on: {lost} rows of {earlier.name} left out"
    )
    return _joined(kept, later, said)


def _agreeing(earlier: ColumnPart, later: ColumnPart, request: Request) -> ColumnPart:
    """Two files that overlap only where both have the same numbers."""
    tolerance = _tolerance(earlier.times)
    first, last = later.times[0], earlier.times[-1]
    if first > last + tolerance:
        said = f"{later.name} ({len(later.times)} rows) follows {earlier.name}"
        return _joined(earlier, later, said)
    end = min(last, later.times[-1]) + tolerance
    one = earlier.taken((earlier.times >= first - tolerance) & (earlier.times <= end))
    other = later.taken(later.times <= end)
    fault = _disagreement(one, other, tolerance)
    if fault is not None:
        listed = ", ".join(f'"{name}"' for name in (*earlier.files, *later.files))
        raise request.error(
            f"{earlier.name} and {later.name} overlap from {first:.10g} to "
            f"{end - tolerance:.10g} and disagree there: {fault}.",
            remedy="State in [source] in which order they were computed, and each counts "
            f"from its first time step on: order = [{listed}].",
        )
    said = f"{later.name} and {earlier.name} agree where they overlap ({len(other.times)} rows)"
    return _joined(earlier, later.taken(later.times > end), said)


def _joined(earlier: ColumnPart, later: ColumnPart, said: str) -> ColumnPart:
    return ColumnPart(
        files=(*earlier.files, *later.files),
        times=np.concatenate([earlier.times, later.times]),
        values={
            header: np.concatenate([numbers, later.values[header]])
            for header, numbers in earlier.values.items()
        },
        notes=(*earlier.notes, *later.notes, said),
    )


def _disagreement(one: ColumnPart, other: ColumnPart, tolerance: float) -> str | None:
    """The first place where two files over the same span differ, in words."""
    if len(one.times) != len(other.times) or np.any(np.abs(one.times - other.times) > tolerance):
        return f"{len(one.times)} and {len(other.times)} rows, not at the same times"
    for header, values in one.values.items():
        apart = np.abs(values - other.values[header])
        wrong = np.flatnonzero(apart > _AGREE * np.max(np.abs(values)))
        if len(wrong):
            row = wrong[0]
            return (
                f"{header} at {one.times[row]:.10g} is {values[row]:.10g} and "
                f"{other.values[header][row]:.10g}"
            )
    return None


def _side_by_side(parts: Sequence[ColumnPart], request: Request) -> ColumnPart:
    """Files with different columns at the times that all of them have."""
    base = max(parts, key=lambda part: len(part.times))
    tolerance = _tolerance(base.times)
    common = np.ones(len(base.times), dtype=bool)
    places: dict[str, Places] = {}
    problems = []
    for part in parts:
        rows, there = _found(part.times, base.times, tolerance)
        if there.all():
            common &= np.isin(np.arange(len(base.times)), rows)
            places[part.name] = rows
            continue
        missing = np.count_nonzero(~there)
        problems.append(
            request.problem(
                f"{part.name} has a row at {part.times[~there][0]:.10g}, {base.name} has none "
                f"there; so it is with {missing} of the {len(part.times)} rows of {part.name}.",
                remedy="Export them with the same trigger and over the same time; nothing is "
                "interpolated.",
            )
        )
    if problems:
        raise request.error(*problems)
    if not common.any():
        listed = ", ".join(f"{part.name} ({len(part.times)} rows)" for part in parts)
        raise request.error(f"no time is common to all of {listed}.")
    notes = [note for part in parts for note in part.notes]
    if not common.all():
        listed = ", ".join(f"{part.name} {len(part.times)}" for part in parts)
        notes.append(f"{np.count_nonzero(common)} common times kept; rows: {listed}")
    values: dict[str, Array] = {}
    for part in parts:
        kept = common[places[part.name]]
        values |= {header: numbers[kept] for header, numbers in part.values.items()}
    return ColumnPart(
        files=tuple(name for part in parts for name in part.files),
        times=base.times[common],
        values=values,
        notes=tuple(notes),
    )


def _found(times: Array, among: Array, tolerance: float) -> tuple[Places, Mask]:
    """Index of the nearest of other times for each time, and whether it is the same time."""
    middles = (among[1:] + among[:-1]) / 2
    nearest = np.searchsorted(middles, times)
    return nearest, np.abs(among[nearest] - times) <= tolerance


def _tolerance(times: Array) -> float:
    """Difference up to which two times are the same."""
    if len(times) < 2:
        return 1e-9 * max(1.0, float(np.max(np.abs(times))))
    return SAME_STEP * float(np.min(np.diff(times)))


# Which files are exports, and which of them belong to one run.


_QUOTED: Final = re.compile(r'"[^"]*(?: Monitor[":\s]|: Residual")|"Physical Time')
_FEW: Final = 40
"""Lines from which the beginning of an export is told."""


def recognises(path: Path, head: bytes) -> bool:
    """Whether a file begins with a header of monitors, or a folder holds such a file."""
    if not head and path.is_dir():
        return any(recognises(file, _head(file)) for file in _exports_in(path)[:20])
    line = head.removeprefix(b"\xef\xbb\xbf").lstrip().split(b"\n", 1)[0].decode("utf-8", "replace")
    return line.startswith('"') and _QUOTED.search(line) is not None


def files(request: Request) -> list[Path]:
    """The file itself, those that a pattern fits, or the .csv files of a folder."""
    path = request.path
    found = _exports_in(path) if path.is_dir() else list(matching(path))
    if path.is_dir() and not found:
        raise request.error("the folder holds no .csv file.")
    return found or [path]


def are_one_run(folder: Path) -> bool:
    """Whether the exports of a folder differ in their columns, or one begins well after another."""
    heads = [_head(file).split(b"\n") for file in _exports_in(folder)]
    tops = {lines[0] for lines in heads}
    return len(heads) > 1 and (len(tops) == len(heads) or _follow(heads))


def _follow(heads: Sequence[Sequence[bytes]]) -> bool:
    """Whether files with the same columns begin at different times, as restarts do."""
    if len({lines[0] for lines in heads}) > 1:
        return False
    try:
        times = [[float(line.split(b",")[0]) for line in lines[1:_FEW]] for lines in heads]
    except ValueError:
        return False
    begins = sorted(own[0] for own in times if own)
    usual = max((own[-1] - own[0] for own in times if own), default=0.0)
    return len(begins) == len(heads) and all(b - a > usual for a, b in pairwise(begins))


def _exports_in(folder: Path) -> list[Path]:
    try:
        return sorted(
            file for file in folder.iterdir() if file.suffix.lower() == ".csv" and file.is_file()
        )
    except OSError:
        return []


def _head(file: Path) -> bytes:
    try:
        return head_of(file)
    except OSError:
        return b""


TIME: Final = "Physical Time"
"""Name under which the time of an export is offered, whatever its language."""

_HEADER: Final = re.compile(
    r"(?P<name>.*?)(?: Monitor(?: (?P<copy>\d+))?)?(?:: (?P<kind>.*?))?(?: \((?P<unit>[^()]*)\))?"
)
_TIMES: Final = frozenset(
    {
        "physical time",
        "time",
        "solution time",
        "物理时间",
        "时间",
        "物理時間",
        "時間",
        "물리적 시간",
        "시간",
        "physikalische zeit",
        "zeit",
        "temps physique",
        "temps",
        "tiempo físico",
        "tiempo",
        "tempo fisico",
        "tempo físico",
        "tempo",
        "физическое время",
        "время",
    }
)
"""Words for time in the languages of the program; a first column in seconds is time too."""
_UNITS: Final[Mapping[str, str]] = {
    "radian": "rad",
    "radian/s": "rad/s",
    "radian/s^2": "rad/s2",
    "m/s^2": "m/s2",
    "/s": "1/s",
}
"""Spellings of units in the program that pmmkit has not."""
_USUAL: Final[Mapping[str, frozenset[str]]] = {
    "t": frozenset({TIME.lower()}),
    "X": frozenset({"fx", "force x", "force_x", "x force"}),
    "Y": frozenset({"fy", "force y", "force_y", "y force"}),
    "N": frozenset({"mz", "moment z", "moment_z", "z moment"}),
    "K": frozenset({"mx", "moment x", "moment_x", "x moment"}),
}
"""Names, in lower case, that say which channel they are; all others must be mapped."""


@dataclass(frozen=True)
class _Export:
    """One file, not yet parsed: what its columns are offered as, and which one it goes by."""

    request: Request
    text: Text
    headers: tuple[str, ...]
    key: int
    timed: bool
    notes: tuple[str, ...]

    @property
    def key_header(self) -> str:
        return self.headers[self.key]


def names(request: Request) -> tuple[str, ...]:
    """Headers of all files, each once: ``name [unit]``, ``[-]`` without a unit."""
    return _listed(_opened(request))


def columns(request: Request, choose: Choose) -> Columns:
    """Some columns of one export or of several, merged on time.

    Files none of whose columns are chosen are not read. Of rows with the same time (inner
    iterations) the last is kept. See `pmmkit.readers.starccm.reader` for how files go together.
    """
    exports = _opened(request)
    headers = _listed(exports)
    positions = tuple(choose(headers, len(headers)))
    chosen = list(dict.fromkeys(headers[place] for place in positions))
    keys = {export.key_header for export in exports}
    used = [export for export in exports if set(export.headers) & set(chosen) - keys]
    used = used or [export for export in exports if export.key_header in chosen][:1] or exports[:1]
    _check_keys(used, [header for header in chosen if header in keys], exports, request)
    parts, dropped = _parts(used, chosen, request)
    notes = [note for export in used for note in export.notes]
    left = [export.request.path.name for export in exports if export not in used]
    if left:
        notes.append(f"no column used of {', '.join(left)}")
    whole = merged(parts, request)
    values = {used[0].key_header: whole.times, **whole.values}
    return Columns(
        headers=headers,
        positions=positions,
        values=tuple(values[headers[place]] for place in positions),
        dropped=dropped,
        notes=(*notes, *whole.notes),
    )


def usual(headers: Sequence[str]) -> dict[str, str]:
    """Our names of columns whose own names leave no doubt, where exactly one column has one.

    These are, in capitals or not: Physical Time; Fx, Force X, Force_X, X Force; the same of Fy
    and with Moment of Mz and Mx.

    Examples
    --------
    >>> usual(["Physical Time [s]", "fx [N]", "Drag [N]", "Mz [N m]", "Moment Z [N m]"])
    {'t': 'Physical Time', 'X': 'fx'}
    """
    bare = [split_unit(header)[0] for header in headers]
    found = {
        name: [title for title in bare if title.lower() in spellings]
        for name, spellings in _USUAL.items()
    }
    return {name: listed[0] for name, listed in found.items() if len(listed) == 1}


def clean_headers(headers: Sequence[str]) -> tuple[str, ...]:
    """Headers of an export as they are offered: name and unit, each name once.

    A copy of a monitor keeps its number. Names that are the same without the kind of report get
    it back. What has no unit is without dimension, ``[-]``.

    Examples
    --------
    >>> clean_headers(["Fx Monitor: Force (N)", "Mz  Monitor 2: Moment (N-m)", "Cd Monitor"])
    ('Fx [N]', 'Mz 2 [N m]', 'Cd [-]')
    >>> clean_headers(["Hull Monitor: Force (kN)", "Hull Monitor: Moment (N-m)"])
    ('Hull: Force [kN]', 'Hull: Moment [N m]')
    """
    parsed = [_grammar(header) for header in headers]
    short = [" ".join(filter(None, (found["name"], found["copy"]))) for found in parsed]
    long = [
        f"{name}: {found['kind']}" if found["kind"] else name
        for name, found in zip(short, parsed, strict=True)
    ]
    full = [split_unit(" ".join(header.split()))[0] for header in headers]
    once, twice = Counter(short), Counter(long)
    titles = [
        first if once[first] == 1 else second if twice[second] == 1 else third
        for first, second, third in zip(short, long, full, strict=True)
    ]
    earlier = [titles[:place].count(title) for place, title in enumerate(titles)]
    return tuple(
        f"{title}{f' #{before + 1}' if before else ''} [{_unit(found['unit'])}]"
        for title, before, found in zip(titles, earlier, parsed, strict=True)
    )


def _grammar(header: str) -> re.Match[str]:
    found = _HEADER.fullmatch(" ".join(header.split()))
    assert found is not None
    return found


def _unit(unit: str | None) -> str:
    """A unit as pmmkit spells it where it knows it, else as it stands."""
    if unit is None or not unit.strip():
        return "-"
    spelt = _UNITS.get(unit, unit)
    spaced = spelt.replace("-", " ")
    return spaced if is_unit(spaced) else spelt


def _opened(request: Request) -> list[_Export]:
    """All files of a run, with everything that is wrong with any of their headings."""
    exports: list[_Export] = []
    problems: list[Problem] = []
    for file in files(request):
        try:
            exports.append(_open(request.inside(file)))
        except DataError as error:
            problems += error.problems
    if problems:
        raise request.error(*problems)
    return exports


def _open(request: Request) -> _Export:
    options = replace(
        request.options,
        delimiter=request.options.delimiter or ",",
        decimal=request.options.decimal or ".",
        header=True,
        units_row=False,
    )
    text, torn = _without_torn_row(take_apart(replace(request, options=options)), request)
    original = text.headers
    if original is None:
        raise request.error(
            "there is no header of monitors above the rows.",
            remedy='For plain columns write format = "csv".',
        )
    headers = list(clean_headers(original))
    key, timed = _key(headers)
    notes = [*text.told, *torn]
    if timed:
        name, unit = split_unit(headers[key])
        headers[key] = TIME if unit == "-" else f"{TIME} [{unit}]"
        if name.lower() != TIME.lower():
            seconds = ", in s" if unit == "-" else ""
            notes.append(
                f"{request.path.name}: column {original[key]!r} is taken for the time{seconds}"
            )
    else:
        headers[key] = headers[key].removesuffix(" [-]")
    return _Export(request, text, tuple(headers), key, timed, tuple(notes))


def _without_torn_row(text: Text, request: Request) -> tuple[Text, list[str]]:
    """The text without a last row that is cut off or may be, and what to say of it."""
    begin = text.data.rfind(b"\n", text.start, text.stop) + 1 or text.start
    last = fields_of(text.data[begin : text.stop], text.delimiter)
    if len(last) >= text.width and surely_whole(text):
        return text, []
    if begin == text.start:
        raise request.error("there is one row of numbers, and it is cut off.")
    said = f"{request.path.name}: the last row is cut off (or its line end is missing): left out"
    return replace(text, stop=begin - 1), [said]


def _key(headers: Sequence[str]) -> tuple[int, bool]:
    """The column an export goes by, and whether it is time."""
    bare = [(name.lower(), unit) for name, unit in map(split_unit, headers)]
    times = [
        place for place, (name, unit) in enumerate(bare) if name in _TIMES and _measures_time(unit)
    ]
    unit = bare[0][1]
    if times[:1] == [0] or (unit != "-" and _measures_time(unit)):
        return 0, True
    return (times[0], True) if len(times) == 1 else (0, False)


def _measures_time(unit: str | None) -> bool:
    return unit in (None, "-") or (is_unit(unit) and unit_factor(unit)[0] == "s")


def _listed(exports: Sequence[_Export]) -> tuple[str, ...]:
    """All headers, each once: first what the files go by, time before all."""
    keys = [export.key_header for export in sorted(exports, key=lambda item: not item.timed)]
    others = [header for export in exports for header in export.headers]
    if len(exports) == 1:
        return exports[0].headers
    return tuple(dict.fromkeys([*keys, *others]))


def _check_keys(
    used: Sequence[_Export], chosen: Sequence[str], exports: Sequence[_Export], request: Request
) -> None:
    """Refuse files that go by different things, or by something else than was chosen."""
    wanted = [export for export in exports if export.key_header in chosen][:1]
    first, *others = sorted([*wanted, *used], key=lambda export: not export.timed)
    problems = [
        request.problem(
            f"{export.request.path.name} goes by {export.key_header!r}, "
            f"{first.request.path.name} by {first.key_header!r}.",
            remedy="Set the x axis of its plot to Physical Time, or trigger the monitor by time "
            "step, and export it again."
            if first.timed and not export.timed
            else "Export both with the same x axis.",
        )
        for export in others
        if export.key_header != first.key_header
    ]
    if problems:
        raise request.error(*problems)


def _parts(
    exports: Sequence[_Export], chosen: Sequence[str], request: Request
) -> tuple[list[ColumnPart], int]:
    """The chosen columns of each file by time steps, and how many rows lack a value."""
    parts: list[ColumnPart] = []
    problems: list[Problem] = []
    dropped = 0
    for export in exports:
        headers = [
            name
            for name in dict.fromkeys(export.headers)
            if name in chosen and name != export.key_header
        ]
        places = [export.key, *(export.headers.index(name) for name in headers)]
        name = export.request.path.name
        try:
            read = numbers(export.text, places, export.request)
            values = dict(zip(headers, read.values[1:], strict=True))
            parts.append(steps(name, read.values[0], values, export.request))
        except DataError as error:
            problems += error.problems
            continue
        dropped += read.dropped
    if problems:
        raise request.error(*problems)
    return parts, dropped
