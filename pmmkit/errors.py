"""The error family: each error says what was wrong, where, and what to do."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass


@dataclass(frozen=True, kw_only=True)
class Problem:
    """One thing that is wrong, with its place and its remedy.

    Parameters
    ----------
    message : str
        What is wrong, with the numbers that show it.
    file, run, column, row
        Where: as far as known. Rows count from 1 as in the file, header included.
    entry : str, optional
        Table and key of a TOML file, e.g. ``[[runs]] #2 (id 'SD_2'), key 'speed'``.
    remedy : str
        What the user can do about it.
    """

    message: str
    file: str | None = None
    run: str | None = None
    column: str | None = None
    row: int | str | None = None
    remedy: str | None = None
    entry: str | None = None

    @property
    def place(self) -> str:
        """The place in words, e.g. ``runs/SD.csv, run SD_1, column Y, row 17``."""
        parts = [
            self.file,
            self.entry,
            f"run {self.run}" if self.run is not None else None,
            f"column {self.column}" if self.column is not None else None,
            f"row {self.row}" if self.row is not None else None,
        ]
        return ", ".join(part for part in parts if part)

    def __str__(self) -> str:
        text = f"{self.place}: {self.message}" if self.place else self.message
        return f"{text} {self.remedy}" if self.remedy else text


class PmmkitError(Exception):
    """Base of every error that pmmkit raises on purpose."""


class DataError(PmmkitError, ValueError):
    """Something in the user's data or request is wrong; lists every problem at once.

    Parameters
    ----------
    problems : Problem or str or iterable of them
        All problems found.
    title : str, optional
        One line that stands above the list.

    Examples
    --------
    >>> found = [Problem(message="no samples", file="a.csv"), "b is missing"]
    >>> print(DataError(found, title="Not read"))
    Not read (2 problems):
      1. a.csv: no samples
      2. b is missing
    """

    def __init__(
        self, problems: Problem | str | Iterable[Problem | str], *, title: str | None = None
    ) -> None:
        listed = [problems] if isinstance(problems, (str, Problem)) else list(problems)
        self.problems: tuple[Problem, ...] = tuple(
            Problem(message=item) if isinstance(item, str) else item for item in listed
        )
        self.title = title
        super().__init__(self._text())

    def _text(self) -> str:
        if len(self.problems) == 1:
            only = str(self.problems[0])
            return f"{self.title}: {only}" if self.title else only
        head = f"{self.title or type(self).__name__} ({len(self.problems)} problems):"
        lines = [f"  {number}. {item}" for number, item in enumerate(self.problems, start=1)]
        return "\n".join([head, *lines])


class CampaignError(DataError):
    """The campaign file, or a file it names, cannot be read as stated."""


class ContradictionError(DataError):
    """The data contradict themselves or what the campaign file says of them."""


class TableError(DataError):
    """A derivative table cannot be read, converted or combined as asked."""


class ExtrapolationError(TableError):
    """A value outside the range of the data was asked for."""


class ModelError(DataError):
    """A model file or a model is not usable as asked."""


class MissingPartError(ModelError, LookupError):
    """The model lacks a part that the request needs."""


class UnknownNameError(DataError, KeyError):
    """A name is not known; the message lists what is."""

    def __str__(self) -> str:
        return self._text()


class SimulationError(PmmkitError, RuntimeError):
    """A simulation could not be carried through."""


class FileExists(PmmkitError, FileExistsError):
    """A file is in the way and was not replaced."""
