"""What every reader must hold."""

from __future__ import annotations

import shutil
import tempfile
import tracemalloc
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass, field, fields, replace
from pathlib import Path
from typing import Final

import numpy as np
from numpy.typing import ArrayLike

from pmmkit.base import CampaignError, PmmkitError
from pmmkit.conventions import CHANNEL_UNITS, split_unit
from pmmkit.files import sha256
from pmmkit.numerics import Array
from pmmkit.readers import READERS, Choose, Columns, Options, Reader, Request, head_of, to_number
from pmmkit.testing import hold

_CUTS: Final = 24
"""Places at which a file is cut short."""
_LARGE: Final = 1 << 26
"""Size of a file by which it is told whether recognising reads all of it [bytes]."""
_SOON: Final = 1 << 23
"""Memory that recognising may take [bytes]."""
_ODD: Final[Mapping[str, object]] = {
    "format": "nowhere",
    "skip_rows": 1,
    "last_row": 2,
    "encoding": "utf-16",
    "delimiter": "|",
    "decimal": ",",
    "header": False,
    "units_row": True,
    "comment": "0",
    "widths": (1, 2),
    "where": (("Run", 7),),
    "order": ("nowhere.dat",),
    "sheet": "nowhere",
    "group": "nowhere",
    "sample_rate": 7.0,
    "missing": "drop",
    "nondimensional": "prime",
    "in_phase_with": "velocity",
}
"""A value of each key of ``[source]`` that is not the usual one."""
_FOREIGN: Final[Mapping[str, bytes]] = {
    "an empty file": b"",
    "zeros": bytes(5000),
    "random bytes": np.random.default_rng(0).bytes(5000),
    "a text": b"Ran well.\nNo numbers.\n",
    "columns of text": b"t,X,Y,N\n" + b"0.10,1.5,-2.5,3.5\n" * 30,
    "blanks and numbers": b"# t X\n" + b"  0.10   1.5\n" * 30,
    "a picture": b"\x89PNG\r\n\x1a\n\0\0\0\rIHDR" + bytes(range(256)) * 4,
    "an archive": b"PK\x03\x04" + bytes(60) + b"notes.txt",
    "HDF5": b"\x89HDF\r\n\x1a\n" + bytes(800),
    "JSON": b'{"t": [0.0, 0.1], "X": [1.0, 2.0]}\n',
    "a page": b"<!DOCTYPE html><html><body>1 2 3</body></html>\n",
}
"""Beginnings of files that are of no format of columns, or of a general one."""


@dataclass(frozen=True, kw_only=True)
class _Case:
    """A reader, a good file of its format, and what the file holds in some columns."""

    reader: Reader
    request: Request
    places: tuple[int, ...] = ()
    headers: tuple[str, ...] = ()
    whole: tuple[Array, ...] = ()
    stated: Mapping[str, Array] = field(default_factory=dict)

    def choice(self, request: Request) -> Choose:
        """Asks for the columns; refused where they are not those of the good file."""

        def choose(headers: tuple[str, ...], count: int) -> Sequence[int]:
            there = tuple(
                headers[place] for place in self.places if place < min(count, len(headers))
            )
            if there != tuple(self.headers[place] for place in self.places):
                raise request.error("the columns are not those that were asked.")
            return self.places

        return choose

    def read(self, request: Request | None = None) -> Columns:
        """The columns, of the good file if no other is given."""
        request = self.request if request is None else request
        return self.reader.columns(request, self.choice(request))


def check_reader(
    reader: Reader,
    file: str | Path,
    stated: Mapping[str, ArrayLike] | None = None,
    *,
    options: Options | None = None,
    run: str | None = None,
) -> None:
    """Whether a reader can stand beside those of pmmkit.

    It says what it is, and nobody else says the same; its methods agree with each other; columns
    come in the order asked, all rows of them, twice the same; foreign files are told soon and
    refused; a file that is cut short is refused or gives the rows that are left; files are not
    touched.

    Parameters
    ----------
    reader : Reader
        An entry, yours or pmmkit's.
    file : path
        A good file of the format, or a folder, with at least ten rows. Small: it is read some
        hundred times.
    stated : mapping of str to array_like, optional
        Columns that it holds, by header with or without unit, and their numbers. By default all
        columns are asked for, and nothing is known of their numbers.
    options : Options, optional
        What ``[source]`` must state for it.
    run : str, optional
        The run it is read for.

    Raises
    ------
    AssertionError
        With everything that does not hold.

    Examples
    --------
    >>> import tempfile
    >>> file = Path(tempfile.mkdtemp()) / "run.csv"
    >>> rows = [f"{place / 8:.3f},{place / 4:.3f}" for place in range(20)]
    >>> _ = file.write_text("\\n".join(["t,X [N]", *rows, ""]))
    >>> check_reader(READERS["csv"], file, {"t": np.arange(20) / 8, "X": np.arange(20) / 4})
    >>> check_reader(READERS["csv"], file, {"X": np.arange(20) / 5})
    Traceback (most recent call last):
    AssertionError: Reader 'csv':
    - nothing is lost: column 'X' is not as stated: 0.25 is read for 0.2 in row 2
    """
    path = Path(file)
    request = Request(path=path, shown=path.name, run=run, options=options or Options())
    case = _Case(reader=reader, request=request)
    found = [f"declarations: {fault}" for fault in _declared(reader)]
    try:
        case = _filled(case, {name: np.asarray(x, float) for name, x in (stated or {}).items()})
    except Exception as error:
        found.append(f"a good file is read: {_told(error)}")
    else:
        found += [f"{rule}: {fault}" for rule in RULES for fault in _faults(rule, case)]
    hold(f"Reader {getattr(reader, 'name', type(reader).__name__)!r}", found)


def _faults(rule: str, case: _Case) -> list[str]:
    try:
        return list(RULES[rule](case))
    except Exception as error:
        return [_told(error)]


def _told(error: Exception) -> str:
    return f"{type(error).__name__}: {error}"


def _filled(case: _Case, stated: Mapping[str, Array]) -> _Case:
    """With the columns of the good file that are stated, or all, and what is read of them."""
    headers = case.reader.names(case.request)
    bare = [split_unit(header)[0] for header in headers]
    for name in stated:
        if [*headers, *bare].count(name) - (name in headers and name in bare) != 1:
            raise LookupError(f"there is not exactly one column {name!r} among {headers}")
    places = tuple(
        (headers.index(name) if name in headers else bare.index(name)) for name in stated
    ) or tuple(range(len(headers)))
    case = replace(case, places=places, headers=headers, stated=stated)
    return replace(case, whole=case.reader.columns(case.request, lambda *_: places).values)


def _declared(reader: Reader) -> Iterator[str]:
    kind = type(reader)
    if Reader not in kind.__mro__:
        yield f"{kind.__name__} is not derived from Reader"
        return
    for said in ("name", "words", "reads"):
        text = getattr(reader, said, None)
        if not isinstance(text, str) or text != text.strip() or not text:
            yield f"{said} is {text!r}, not a text"
    others = [other for other in READERS.values() if type(other) is not kind]
    if getattr(reader, "name", None) in [other.name for other in others]:
        yield f"the name {reader.name!r} is taken"
    for suffix in reader.suffixes:
        if suffix != suffix.lower() or not suffix.startswith(".") or suffix == ".":
            yield f"the suffix {suffix!r} is not a dot and small letters"
        yield from (
            f"the suffix {suffix!r} is that of {other.name!r}"
            for other in others
            if suffix in other.suffixes
        )
    if len(set(reader.suffixes)) < len(reader.suffixes):
        yield "a suffix comes twice"
    if reader.container and not reader.suffixes:
        yield "it is a container and has no suffixes"
    if reader.fallback is not None:
        yield from (
            f"{other.name!r} is read if nothing tells the format of a {reader.fallback}"
            for other in others
            if other.fallback == reader.fallback
        )
    unknown = set(reader.keys) - {item.name for item in fields(Options)}
    if unknown:
        yield f"there are no keys {', '.join(sorted(unknown))} of [source]"


def _agree(case: _Case) -> Iterator[str]:
    """Names, columns and the files behind them."""
    asked: list[tuple[tuple[str, ...], int]] = []

    def choose(headers: tuple[str, ...], count: int) -> Sequence[int]:
        asked.append((headers, count))
        return case.places

    read = case.reader.columns(case.request, choose)
    if len(asked) != 1:
        yield f"columns asks {len(asked)} times which are wanted"
    for headers, count in asked[:1]:
        if headers != read.headers or count != len(headers):
            yield f"columns offers {count} columns {headers} and gives {read.headers}"
    if case.headers != read.headers:
        yield f"names gives {case.headers}, columns {read.headers}"
    if read.positions != case.places or len(read.values) != len(case.places):
        yield f"columns {case.places} are asked, {read.positions} come"
    for place, numbers in zip(read.positions, read.values, strict=False):
        if numbers.dtype != np.float64 or numbers.ndim != 1 or not np.all(np.isfinite(numbers)):
            yield f"column {read.headers[place]!r} is not a row of finite numbers"
    if len({len(numbers) for numbers in read.values}) != 1 or not len(read.values[0]):
        yield f"columns have {[len(numbers) for numbers in read.values]} values"
    for sheet in case.reader.sheets(case.request):
        options = replace(case.request.options, sheet=sheet)
        case.reader.names(replace(case.request, options=options))
    unknown = set(case.reader.usual(case.headers)) - set(CHANNEL_UNITS)
    if unknown:
        yield f"usual names {', '.join(sorted(unknown))}, which are no channels"
    for path in case.reader.files(case.request):
        if not path.is_file():
            yield f"files names {path}, which is none"
        case.request.inside(path)


def _in_order(case: _Case) -> Iterator[str]:
    whole = dict(zip(case.places, case.whole, strict=True))
    turned = tuple(reversed(case.places))
    for wanted in (turned, *((place,) for place in case.places)):
        read = case.reader.columns(case.request, lambda *_, wanted=wanted: wanted)
        if read.positions != wanted or any(
            not np.array_equal(numbers, whole[place])
            for place, numbers in zip(wanted, read.values, strict=True)
        ):
            yield f"columns {wanted} come as others"


def _nothing_lost(case: _Case) -> Iterator[str]:
    for (name, numbers), read in zip(case.stated.items(), case.whole, strict=False):
        if len(read) != len(numbers):
            yield f"column {name!r} has {len(read)} values, {len(numbers)} are stated"
        elif len(wrong := np.flatnonzero(read != numbers)):
            row = int(wrong[0])
            yield (
                f"column {name!r} is not as stated: {float(read[row])!r} is read for "
                f"{float(numbers[row])!r} in row {row + 1}"
            )


def _cells_agree(case: _Case) -> Iterator[str]:
    try:
        cells = case.reader.cells(case.request)
    except CampaignError:
        return  # a history that is no table
    rows = len(cells.rows)
    if len(cells.lines) != rows or list(cells.lines) != sorted(set(cells.lines)):
        yield f"{rows} rows have lines {cells.lines[:5]} …"
    if any(len(row) != len(cells.headers) for row in cells.rows):
        yield "a row is not as wide as the headers"
        return
    for place, numbers in zip(case.places, case.whole, strict=True):
        title = case.headers[place]
        column = cells.headers.index(title) if title in cells.headers else place
        found = [to_number(row[column], cells.decimal) for row in cells.rows]
        if found != numbers.tolist():
            yield f"cells has other numbers in column {title or place + 1!r} than columns"


def _twice(case: _Case) -> Iterator[str]:
    again = type(case.reader)()
    held = dict(vars(case.reader))
    for other in (case, replace(case, reader=again)):
        one, two = case.read(), other.read()
        if (one.headers, one.notes, one.dropped) != (two.headers, two.notes, two.dropped) or any(
            not np.array_equal(a, b) for a, b in zip(one.values, two.values, strict=True)
        ):
            yield "columns are others when they are read again"
    if case.reader.names(case.request) != again.names(case.request):
        yield "names are others when they are read again"
    if dict(vars(case.reader)) != held:
        yield "the reader holds something from one call to the next"


def _untouched(case: _Case) -> Iterator[str]:
    with _copy(case) as request:
        folder = request.path.parent
        before = _state(folder)
        case.reader.recognises(request.path, head_of(request.path))
        case.reader.names(request)
        case.read(request)
        with suppress(PmmkitError):
            case.reader.cells(request)
        if _state(folder) != before:
            yield "the files are others after reading"


def _state(folder: Path) -> dict[Path, str]:
    return {path: sha256(path) for path in folder.rglob("*") if path.is_file()}


def _recognised(case: _Case) -> Iterator[str]:
    with tempfile.TemporaryDirectory() as place:
        empty = Path(place) / "empty"
        empty.mkdir()
        odd = {"an empty folder": (empty, b""), "what is not there": (empty / "no", b"")}
        for number, (what, data) in enumerate(_FOREIGN.items()):
            path = Path(place) / f"{number}.bin"
            path.write_bytes(data)
            odd[what] = path, data
        for what, (path, head) in odd.items():
            try:
                claimed = case.reader.recognises(path, head)
            except Exception as error:
                yield f"recognises fails on {what}: {_told(error)}"
            else:
                if claimed and not case.reader.general:
                    yield f"recognises takes {what} for its own"


def _soon(case: _Case) -> Iterator[str]:
    if case.request.path.is_dir():
        return
    head = head_of(case.request.path)
    with tempfile.TemporaryDirectory() as place:
        path = Path(place) / case.request.path.name
        path.write_bytes(head)
        with path.open("r+b") as stream:
            stream.truncate(_LARGE)
        tracemalloc.start()
        try:
            case.reader.recognises(path, head)
            peak = tracemalloc.get_traced_memory()[1]
        finally:
            tracemalloc.stop()
    if peak > _SOON:
        yield f"recognises takes {peak:,} bytes for a file of {_LARGE:,}"


def _cut_short(case: _Case) -> Iterator[str]:
    for file in case.reader.files(case.request):
        good = file.read_bytes()
        with _copy(case) as request:
            path = _inside(request, case, file)
            for size in sorted(
                {len(good) * cut // _CUTS for cut in range(_CUTS)} | {len(good) - 1}
            ):
                path.write_bytes(good[:size])
                try:
                    read = case.read(request)
                except PmmkitError:
                    continue
                except Exception as error:
                    yield f"{file.name} of {size} bytes: {_told(error)}"
                    continue
                count = len(read.values[0])
                if any(
                    not np.array_equal(part, whole[:count])
                    for part, whole in zip(read.values, case.whole, strict=True)
                ):
                    yield f"{file.name} of {size} bytes gives other numbers"
                lost = len(case.whole[0]) - count
                gone = 0 if case.reader.binary else good.count(b"\n", size) + 1
                if lost > gone and not (read.notes or read.dropped):
                    yield f"{file.name} of {size} bytes: {lost} rows are lost and nothing is said"


def _refused(case: _Case) -> Iterator[str]:
    file = case.reader.files(case.request)[0]
    with _copy(case) as request:
        path = _inside(request, case, file)
        for what, data in _FOREIGN.items():
            path.write_bytes(data)
            yield from _errors(case, request, what)
        path.unlink()
        yield from _errors(case, request, "a file that is gone")


def _errors(case: _Case, request: Request, what: str) -> Iterator[str]:
    """Columns that come out of a file of another kind, and errors that are not pmmkit's."""
    for method in (case.read, case.reader.names, case.reader.cells):
        try:
            method(request)
        except PmmkitError:
            continue
        except Exception as error:
            yield f"{method.__name__} of {what} fails with {_told(error)}"
        else:
            if method == case.read and not case.reader.general:
                yield f"columns come out of {what}"


def _keys(case: _Case) -> Iterator[str]:
    for key in sorted(set(_ODD) - set(case.reader.keys)):
        options = replace(case.request.options, **{key: _ODD[key]})  # type: ignore[arg-type]
        try:
            read = case.read(replace(case.request, options=options))
        except PmmkitError:
            continue
        if any(not np.array_equal(a, b) for a, b in zip(read.values, case.whole, strict=True)):
            yield f"{key} changes what is read and is not among its keys"


@contextmanager
def _copy(case: _Case) -> Iterator[Request]:
    """A copy of the good file, or folder, for itself."""
    original = case.request.path
    with tempfile.TemporaryDirectory() as place:
        path = Path(place) / original.name
        if original.is_dir():
            shutil.copytree(original, path)
        else:
            for file in case.reader.files(case.request):
                shutil.copy(file, Path(place) / file.relative_to(original.parent))
        yield replace(case.request, path=path)


def _inside(request: Request, case: _Case, file: Path) -> Path:
    """Where the copy of a file of a case lies."""
    return request.path.parent / file.relative_to(case.request.path.parent)


RULES: Final[Mapping[str, Callable[[_Case], Iterator[str]]]] = {
    "names, columns and files agree": _agree,
    "columns come in the order asked": _in_order,
    "nothing is lost": _nothing_lost,
    "cells agree with columns": _cells_agree,
    "the same input gives the same output": _twice,
    "files are not touched": _untouched,
    "other files are not taken for its own": _recognised,
    "recognising does not read the file": _soon,
    "a file cut short is not read for a shorter one": _cut_short,
    "what is no file of the format is refused": _refused,
    "keys that count are declared": _keys,
}
"""What is tried, and how."""
