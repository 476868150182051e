"""Library of reference ships: their particulars, read from the model files that come along."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import MISSING, dataclass, fields
from pathlib import Path
from typing import Any, Final

from pmmkit.base import ModelError, Problem, Registry
from pmmkit.conventions import Ship, Water
from pmmkit.files import datasets_folder, read_toml

_POSITIVE: Final = frozenset({"L", "B", "d", "volume", "mass", "Izz", "Ixx", "rho", "g", "nu"})


@dataclass(frozen=True)
class LibraryShip:
    """A ship of the library: its name, and the model file that holds its particulars."""

    name: str
    file: Path


def _of_the_library() -> Iterator[LibraryShip]:
    for path in sorted((datasets_folder() / "ships").glob("*.toml"), key=lambda path: path.stem):
        yield LibraryShip(path.stem, path)


SHIPS: Final = Registry(
    LibraryShip,
    _of_the_library,
    what="ship",
    unknown="The library has no ship {name!r}{guess} It has {names}. For a file of your own write "
    "its path with the ending .toml.",
)
"""The ships of the library by name."""


def ships() -> list[str]:
    """Names of the ships of the library.

    Examples
    --------
    >>> "s175" in ships()
    True
    """
    return list(SHIPS)


def load_ship(name: str) -> Ship:
    """Particulars of a library ship at the scale the library holds it.

    Parameters
    ----------
    name : str
        One of `ships`.

    Returns
    -------
    Ship

    Raises
    ------
    UnknownNameError
        If the library has no such ship.

    Examples
    --------
    >>> ship = load_ship("s175")
    >>> ship.L, ship.B, round(ship.block, 4)
    (175.0, 25.4, 0.5617)
    """
    path = SHIPS[name].file
    problems: list[Problem] = []
    ship = read_ship(read_toml(path), str(path), problems)
    if ship is None:
        raise ModelError(problems, title=f"Ship {name}")
    return ship


def number(value: object) -> float | None:
    """A finite float from what TOML gives; None for anything else."""
    if isinstance(value, bool) or not isinstance(value, (int, float)):
        return None
    try:
        converted = float(value)
    except OverflowError:
        return None
    return converted if math.isfinite(converted) else None


def read_ship(data: Mapping[str, Any], file: str, problems: list[Problem]) -> Ship | None:
    """The section ``[ship]`` of a file; what is wrong is added to `problems`."""
    given = _section(data, "ship", Ship, ("name",), file, problems)
    return None if given is None else Ship(**given)


def read_water(data: Mapping[str, Any], file: str, problems: list[Problem]) -> Water | None:
    """The section ``[water]`` of a file; what is wrong is added to `problems`."""
    given = _section(data, "water", Water, (), file, problems)
    return None if given is None else Water(**given)


def _section(
    data: Mapping[str, Any],
    section: str,
    kind: type[Ship] | type[Water],
    texts: Iterable[str],
    file: str,
    problems: list[Problem],
) -> dict[str, Any] | None:
    content = data.get(section, {})
    if not isinstance(content, dict):
        problems.append(Problem(message=f"{section} must be a section.", file=file))
        return None
    before = len(problems)
    known = {field.name: field for field in fields(kind)}
    given: dict[str, Any] = {}
    for key, value in content.items():
        place = f"{section}.{key}"
        if key not in known:
            problems.append(
                Problem(
                    message=f"{place} is not known; {section} has {', '.join(known)}.", file=file
                )
            )
        elif key in texts:
            if isinstance(value, str):
                given[key] = value
            else:
                problems.append(Problem(message=f"{place} must be a text.", file=file))
        elif (read := number(value)) is None:
            problems.append(
                Problem(message=f"{place} must be a finite number, not {value!r:.40}.", file=file)
            )
        elif key in _POSITIVE and read <= 0.0:
            problems.append(Problem(message=f"{place} = {read:g} must be positive.", file=file))
        else:
            given[key] = read
    absent = [
        name for name, field in known.items() if field.default is MISSING and name not in content
    ]
    if absent:
        problems.append(Problem(message=f"{section} lacks {', '.join(absent)}.", file=file))
    return given if len(problems) == before else None
