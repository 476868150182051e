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

from pmmkit.base import DataError, Problem
from pmmkit.conventions import is_unit, split_unit, unit_factor
from pmmkit.files import matching
from pmmkit.readers.base import Choose, Columns, Request, head_of
from pmmkit.readers.starccm.merging import ColumnPart, merged, steps
from pmmkit.readers.text.csv import numbers
from pmmkit.readers.text.heading import fields_of
from pmmkit.readers.text.splitting import Text, surely_whole, take_apart

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
    iterations) the last is kept. See `pmmkit.readers.starccm.merging` for how files go together.
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
