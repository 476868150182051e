"""Columns out of a container: many named arrays in one file, of several lengths and kinds.

The length that most matters is the longest that at least two columns share. Columns of another
length stand among the headers as ``name (3 values)``, so that they are never taken unasked, yet can
be asked for; columns that are used together must be of equal length.
"""

from __future__ import annotations

import functools
from abc import abstractmethod
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from contextlib import AbstractContextManager
from dataclasses import dataclass
from typing import ClassVar, Final

import numpy as np

from pmmkit.base import CampaignError, Problem
from pmmkit.numerics import ABSURD, Array
from pmmkit.readers.base import LISTED, Cell, Cells, Choose, Columns, Reader, Request, fault

WIDEST: Final = 200
"""Matrices with more columns than this are not columns of channels."""
_SHOWN: Final = 20


@dataclass(frozen=True, kw_only=True)
class Vector:
    """A series of numbers or of texts in a container.

    `name`: its name, with its unit in square brackets where the file states one. `texts`: gives
    the texts, for a series of texts. `notes`: what was done to the numbers.
    """

    name: str
    length: int
    read: Callable[[], Array]
    texts: Callable[[], tuple[str, ...]] | None = None
    notes: tuple[str, ...] = ()


def with_unit(name: str, unit: str | None) -> str:
    """A header from a name and a unit.

    Examples
    --------
    >>> with_unit("Fx", "kN"), with_unit("beta", " "), with_unit("X [N]", "kN")
    ('Fx [kN]', 'beta', 'X [N]')
    """
    unit = (unit or "").strip()
    return name if not unit or name.endswith("]") or "]" in unit else f"{name} [{unit}]"


def matrix_columns(
    name: str,
    shape: tuple[int, int],
    read: Callable[[], Array],
    *,
    lengths: frozenset[int] = frozenset(),
    names: Sequence[str] | None = None,
    unit: str | None = None,
) -> list[Vector]:
    """A matrix as columns ``name(1)``, ``name(2)`` …, or under names of their own."""
    known = [side in lengths for side in shape]
    axis = known.index(True) if known.count(True) == 1 else int(shape[1] > shape[0])
    whole = functools.cache(read)

    def column(place: int) -> Callable[[], Array]:
        return lambda: np.take(whole(), place, axis=1 - axis)

    return [
        Vector(
            name=with_unit(names[place] if names else f"{name}({place + 1})", unit),
            length=shape[axis],
            read=column(place),
        )
        for place in range(shape[1 - axis])
    ]


def main_length(lengths: Sequence[int]) -> int:
    """The longest length that two columns share, else the longest.

    Examples
    --------
    >>> main_length([900, 900, 900, 3, 3, 5000]), main_length([7, 3])
    (900, 7)
    """
    counts = Counter(lengths)
    return max((length for length in counts if counts[length] > 1), default=max(counts, default=0))


def headers_of(vectors: Sequence[Vector]) -> tuple[str, ...]:
    """Headers of the columns; those that are not of the main length tell their own."""
    main = main_length([vector.length for vector in vectors if vector.texts is None])
    return tuple(
        vector.name if vector.length == main else f"{vector.name} ({vector.length} values)"
        for vector in vectors
    )


def numbers_only(
    vectors: Sequence[Vector], left_out: Sequence[str], request: Request
) -> list[Vector]:
    """The columns of numbers."""
    found = [vector for vector in vectors if vector.texts is None]
    if not found:
        raise request.error(
            request.problem("there are no columns of numbers."),
            *left_out_problem(left_out, request),
        )
    return found


def chosen_columns(
    vectors: Sequence[Vector], left_out: Sequence[str], request: Request, choose: Choose
) -> Columns:
    """The columns that `choose` asks for, every number checked."""
    offered = numbers_only(vectors, left_out, request)
    titles = headers_of(offered)
    try:
        positions = tuple(choose(titles, len(titles)))
    except CampaignError as error:
        raise request.error(*error.problems, *left_out_problem(left_out, request)) from error
    used = [offered[place] for place in positions]
    same_length({titles[place]: offered[place].length for place in positions}, request)
    values = [np.asarray(vector.read(), dtype=np.float64) for vector in used]
    kept, dropped = checked(values, [titles[place] for place in positions], request)
    return Columns(
        headers=titles,
        positions=positions,
        values=kept,
        dropped=dropped,
        notes=tuple(dict.fromkeys(note for vector in used for note in vector.notes)),
    )


def same_length(lengths: Mapping[str, int], request: Request) -> None:
    """Refuse columns of different lengths, telling them."""
    if len(set(lengths.values())) > 1:
        listed = ", ".join(f"{title} has {length}" for title, length in lengths.items())
        raise request.error(
            f"the columns that are used differ in their number of values: {listed}.",
            remedy='Use columns of one length, or one group of them: group = "..." in '
            "[source]; a column that is not wanted is left out by t = false under [columns].",
        )


def checked(
    values: Sequence[Array], titles: Sequence[str], request: Request
) -> tuple[tuple[Array, ...], int]:
    """Columns of finite numbers, and how many rows were left out for want of a value."""
    if not values:
        return (), 0
    drop = request.options.missing == "drop"
    lacking = np.zeros(len(values[0]), dtype=bool)
    problems: list[Problem] = []
    more = 0
    for column, title in zip(values, titles, strict=True):
        missing = np.isnan(column)
        with np.errstate(invalid="ignore"):
            wrong = np.abs(column) > ABSURD
        lacking |= missing
        where = np.flatnonzero(wrong if drop else wrong | missing)
        listed = where[: max(0, LISTED - len(problems))]
        more += len(where) - len(listed)
        problems += [
            request.problem(
                fault(float(column[row]), float(column[row])) or "", row=int(row) + 1, column=title
            )
            for row in listed
        ]
    if more:
        problems.append(request.problem(f"and {more} more like these."))
    if problems:
        raise request.error(*problems)
    dropped = int(np.count_nonzero(lacking))
    if dropped == len(lacking):
        raise request.error("there are no rows of numbers.")
    if not dropped:
        return tuple(np.ascontiguousarray(column) for column in values), 0
    return tuple(column[~lacking] for column in values), dropped


def small_table(vectors: Sequence[Vector], left_out: Sequence[str], request: Request) -> Cells:
    """The columns of the main length as rows of cells."""
    length = main_length([vector.length for vector in numbers_only(vectors, left_out, request)])
    used = [vector for vector in vectors if vector.length == length]
    table: list[Sequence[Cell]] = [
        vector.texts()
        if vector.texts is not None
        else np.asarray(vector.read(), dtype=np.float64).tolist()
        for vector in used
    ]
    return Cells(
        headers=tuple(vector.name for vector in used),
        rows=tuple(zip(*table, strict=True)),
        lines=tuple(range(1, length + 1)),
    )


def left_out_problem(left_out: Sequence[str], request: Request) -> list[Problem]:
    """What a container holds that is no column, as a problem to be told beside others."""
    if not left_out:
        return []
    more = f" and {len(left_out) - _SHOWN} more" if len(left_out) > _SHOWN else ""
    return [request.problem(f"left out, not being columns: {', '.join(left_out[:_SHOWN])}{more}.")]


def alike(names: Sequence[str], stroke: str) -> tuple[str, ...]:
    """Groups that hold all columns of the layout that most groups share; none where each differs.

    Examples
    --------
    >>> of_two = ["a/t [s]", "a/Fx [N]", "b/t [s]", "b/Fx [N]"]
    >>> alike([*of_two, "c/t [s]", "c/Fx [N]", "c/n", "L"], "/"), alike(["a/t", "b/n"], "/")
    (('a', 'b', 'c'), ())
    """
    held: dict[str, set[str]] = {}
    for name in names:
        group, between, _ = name.partition(" [")[0].rpartition(stroke)
        if between:
            held.setdefault(group, set()).add(name.removeprefix(f"{group}{stroke}"))
    shared = Counter(frozenset(own) for own in held.values())
    layout, count = max(shared.items(), key=lambda item: item[1], default=(frozenset(), 0))
    if count < 2 or len(layout) < 2:
        return ()
    return tuple(group for group, own in held.items() if own >= layout)


class VectorReader(Reader):
    """A format of containers, of which it tells the vectors.

    `stroke`: what stands between a group and its columns in their names.
    """

    stroke: ClassVar[str] = "/"

    @abstractmethod
    def contents(self, request: Request) -> AbstractContextManager[tuple[list[Vector], list[str]]]:
        """What a file offers as columns, and what else it holds; open as long as it is used."""

    def names(self, request: Request) -> tuple[str, ...]:
        """Headers of the columns."""
        with self.contents(request) as (vectors, left_out):
            return headers_of(numbers_only(vectors, left_out, request))

    def groups(self, request: Request) -> tuple[str, ...]:
        """Groups with the same columns, a run each."""
        with self.contents(request) as (vectors, _):
            return alike([item.name for item in vectors if item.texts is None], self.stroke)

    def columns(self, request: Request, choose: Choose) -> Columns:
        """Some vectors, or columns of matrices, as numbers."""
        with self.contents(request) as (vectors, left_out):
            return chosen_columns(vectors, left_out, request, choose)

    def cells(self, request: Request) -> Cells:
        """Vectors of the main length as a table, those of texts among them."""
        with self.contents(request) as (vectors, left_out):
            return small_table(vectors, left_out, request)
