"""The numbers of a file that was looked at, as far as it can be read."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from pmmkit.base import CampaignError, Problem
from pmmkit.intake.seen import FileLook
from pmmkit.numerics import ABSURD, Array
from pmmkit.readers import READERS, Request, TextLayout, to_number


@dataclass(frozen=True, kw_only=True)
class Values:
    """Numbers of a file by position, how many rows there are, and what was wrong."""

    numbers: Mapping[int, Array] = field(default_factory=dict)
    problems: tuple[Problem, ...] = ()
    notes: tuple[str, ...] = ()


def values_of(look: FileLook, positions: Sequence[int] | None = None) -> Values:
    """Numbers of the columns of a file, NaN where they are damaged, and the problems."""
    wanted = tuple(positions if positions is not None else _numeric(look))
    request = look.request
    reader = READERS[look.format]
    if look.blocks.mixed:
        return _of_runs(look, wanted)
    try:
        read = reader.columns(request, lambda _, width: [p for p in wanted if p < width])
    except CampaignError as error:
        return Values(numbers=_lenient(look, wanted), problems=_few(error.problems, request))
    return Values(numbers=dict(zip(read.positions, read.values, strict=True)), notes=read.notes)


def _of_runs(look: FileLook, positions: Sequence[int]) -> Values:
    """The numbers of the rows that are runs or samples of them; the others are no damage."""
    cells = READERS[look.format].cells(look.request)
    taken = {line for block in look.blocks.runs for line in block.lines}
    kept = [place for place, line in enumerate(cells.lines) if line in taken]
    own = replace(
        cells,
        rows=tuple(cells.rows[place] for place in kept),
        lines=tuple(cells.lines[place] for place in kept),
    )
    _, _, problems = own.numbers(positions, look.request)
    numbers = {
        place: np.array([to_number(row[place], cells.decimal) for row in own.rows], dtype=float)
        for place in positions
    }
    return Values(numbers=numbers, problems=_few(problems, look.request), notes=cells.notes)


def _numeric(look: FileLook) -> list[int]:
    if look.layout is not None:
        return [place for place, numeric in enumerate(look.layout.numeric) if numeric]
    return [column.position for column in look.columns if column.numbers]


def _few(problems: Sequence[Problem], request: Request) -> tuple[Problem, ...]:
    """The first problems of a file, and how many more there are."""
    if len(problems) <= 3:
        return tuple(problems)
    return (*problems[:2], request.problem(f"and {len(problems) - 2} more problems."))


def _lenient(look: FileLook, positions: Sequence[int]) -> dict[int, Array]:
    """Columns of a damaged text file or sheet, NaN where there is no number; else nothing."""
    if look.has_sheets:
        cells = READERS[look.format].cells(look.request)
        found = {
            place: np.array([to_number(row[place]) for row in cells.rows], dtype=float)
            for place in positions
        }
    elif look.layout is not None:
        found = _lenient_text(look, look.layout, positions)
    else:
        return {}
    return {
        place: np.where(np.abs(numbers) < ABSURD, numbers, np.nan)
        for place, numbers in found.items()
    }


def _lenient_text(look: FileLook, layout: TextLayout, positions: Sequence[int]) -> dict[int, Array]:
    import pandas as pd

    try:
        table = pd.read_csv(
            look.path,
            header=None,
            names=list(range(len(layout.headers))),
            skiprows=layout.first_row - 1,
            sep=r"\s+" if layout.delimiter == " " else layout.delimiter,
            encoding=layout.encoding,
            encoding_errors="replace",
            on_bad_lines="skip",
            dtype=str,
        )
    except (ValueError, OSError, pd.errors.ParserError):
        return {}
    found = {}
    for place in positions:
        cells = table[place].astype(str)
        if layout.decimal != ".":
            cells = cells.str.replace(layout.decimal, ".", regex=False)
        found[place] = pd.to_numeric(cells, errors="coerce").to_numpy(dtype=float)
    return found
