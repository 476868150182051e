"""The error family: each error says what was wrong, where, and what to do."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Literal

Reader = Literal["python", "command"]
"""Who reads an error: somebody who calls from Python, or who types commands."""


@dataclass(frozen=True)
class Way:
    """How something is asked for.

    Parameters
    ----------
    python : str
        In Python.
    command : str
        On the command line.
    """

    python: str
    command: str

    @classmethod
    def setting(cls, name: str, value: str | float | bool | None = None) -> Way:
        """An argument that is an option of a command by the same name.

        Parameters
        ----------
        name : str
            Of the argument.
        value : str, float or True, optional
            An example of its value; True for an option that has none.

        Examples
        --------
        >>> Way.setting("missing", "zero"), Way.setting("extrapolate", True)
        (Way(python='missing="zero"', command='--missing zero'), \
Way(python='extrapolate=True', command='--extrapolate'))
        """
        option = f"--{name.replace('_', '-')}"
        if value is None or value is True:
            return cls(f"{name}=" if value is None else f"{name}=True", option)
        written = f'"{value}"' if isinstance(value, str) else f"{value:g}"
        return cls(f"{name}={written}", f"{option} {value}")


@dataclass(frozen=True)
class Remedy:
    """What can be done, in the words of who reads it.

    Parameters
    ----------
    text : str
        With ``{}`` in the place of each way.
    ways : tuple of Way
        How it is asked for.

    Examples
    --------
    >>> remedy = Remedy("Measure there, or say {}.", (Way.setting("extrapolate", True),))
    >>> str(remedy), remedy.said("command")
    ('Measure there, or say extrapolate=True.', 'Measure there, or say --extrapolate.')
    """

    text: str
    ways: tuple[Way, ...]

    def said(self, reader: Reader) -> str:
        """The remedy in the words of who reads it."""
        return self.text.format(*(getattr(way, reader) for way in self.ways))

    def __str__(self) -> str:
        return self.said("python")


@dataclass(frozen=True)
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
    remedy : str or Remedy
        What the user can do about it.
    """

    message: str
    file: str | None = None
    run: str | None = None
    column: str | None = None
    row: int | str | None = None
    remedy: str | Remedy | None = None
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

    def advice(self, reader: Reader) -> str | None:
        """The remedy in the words of who reads it."""
        return self.remedy.said(reader) if isinstance(self.remedy, Remedy) else self.remedy

    def said(self, reader: Reader, most: int | None = None) -> str:
        """Place, message and remedy in the words of who reads them.

        Of a text that has more than `most` characters the message is cut, and the remedy stays.

        Examples
        --------
        >>> Problem(message="Y is 9.8 times too large.", remedy="State kgf.").said("python", 24)
        'Y is 9.8 tim… State kgf.'
        """
        text = f"{self.place}: {self.message}" if self.place else self.message
        advice = self.advice(reader)
        end = f" {advice}" if advice else ""
        if most is not None and len(text) + len(end) > most:
            room = max(most - len(end), most // 2)
            text = _cut(text, room)
            end = _cut(end, most - len(text))
        return f"{text}{end}"

    def __str__(self) -> str:
        return self.said("python")


def _cut(text: str, most: int) -> str:
    return text if len(text) <= most else f"{text[: max(most - 1, 0)]}…"


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
    file, run, column, row, entry, remedy
        As of a `Problem`, of those that are given as texts.

    Examples
    --------
    >>> found = [Problem(message="no samples", file="a.csv"), "b is missing"]
    >>> print(DataError(found, title="Not read"))
    Not read (2 problems):
      1. a.csv: no samples
      2. b is missing
    >>> print(DataError("no samples.", file="a.csv", remedy="Copy it again."))
    a.csv: no samples. Copy it again.
    """

    def __init__(
        self,
        problems: Problem | str | Iterable[Problem | str],
        *,
        title: str | None = None,
        file: str | None = None,
        run: str | None = None,
        column: str | None = None,
        row: int | str | None = None,
        remedy: str | Remedy | None = None,
        entry: str | None = None,
    ) -> None:
        listed = [problems] if isinstance(problems, (str, Problem)) else list(problems)
        self.problems: tuple[Problem, ...] = tuple(
            Problem(item, file, run, column, row, remedy, entry) if isinstance(item, str) else item
            for item in listed
        )
        self.title = title
        super().__init__(self.said("python"))

    def said(self, reader: Reader, most: int | None = None) -> str:
        """The text in the words of who reads it, each problem of at most so many characters."""
        each = [problem.said(reader, most) for problem in self.problems]
        if len(each) == 1:
            return f"{self.title}: {each[0]}" if self.title else each[0]
        head = f"{self.title or type(self).__name__} ({len(each)} problems):"
        return "\n".join([head, *(f"  {k}. {text}" for k, text in enumerate(each, start=1))])


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


class NotUsableError(ModelError):
    """A model was asked of derivatives that are not usable."""


class MissingPartError(ModelError, LookupError):
    """The model lacks a part that the request needs."""


class UnknownNameError(DataError, KeyError):
    """A name is not known; the message lists what is."""

    def __str__(self) -> str:
        return self.said("python")


class SimulationError(PmmkitError, RuntimeError):
    """A simulation could not be carried through."""


class FileExists(PmmkitError, FileExistsError):
    """A file is in the way and was not replaced."""
