"""Hulls by name: those whose particulars come along, and the ships of the library."""

from __future__ import annotations

from pathlib import Path
from typing import Any, Final

from pmmkit.channels import did_you_mean
from pmmkit.errors import DataError, Problem, UnknownNameError
from pmmkit.files import datasets_folder
from pmmkit.seakeeping.hulls.hull import Hull
from pmmkit.seakeeping.hulls.particulars import hull_from_particulars
from pmmkit.ship import Ship
from pmmkit.ship_library import load_ship, number, ships
from pmmkit.toml_files import read_toml

_NEEDED: Final = ("L", "B", "d", "block")
_ALLOWED: Final = ("waterplane", "midship", "xB", "xF")


def hulls() -> list[str]:
    """Names of the hulls whose particulars come along.

    Examples
    --------
    >>> "tanker-320" in hulls()
    True
    """
    return sorted(path.stem for path in (datasets_folder() / "hulls").glob("*.toml"))


def load_hull(name: str | Path) -> Hull:
    """A hull of Lewis forms from particulars that have a name or a file.

    Parameters
    ----------
    name : str or path
        One of `hulls`, a ship of the library, or a file ``.toml`` with name, L, B, d, block and
        perhaps waterplane, midship, xB, xF (see `hull_from_particulars`).

    Returns
    -------
    Hull

    Raises
    ------
    UnknownNameError
        With the names there are.
    DataError
        With everything that is wrong with a file.

    Examples
    --------
    >>> load_hull("tanker-320")
    <Hull tanker-320: L 320 m, draught 20.8 m, 41 stations, volume 3.1226e+05 m³>
    """
    text = str(name)
    if text.endswith(".toml"):
        return _from_file(Path(name))
    if text in hulls():
        return _from_file(datasets_folder() / "hulls" / f"{text}.toml")
    if text in ships():
        return hull_of(load_ship(text))
    known = sorted({*hulls(), *ships()})
    meant = did_you_mean(text, known) or "."
    raise UnknownNameError(
        f"There is no hull {text!r}{meant} There are {', '.join(known)}; for offsets "
        "of your own write a path with the ending .csv or .mgf."
    )


def hull_of(ship: Ship) -> Hull:
    """A hull of Lewis forms with the particulars of a ship, at its scale.

    Parameters
    ----------
    ship : Ship
        Length, breadth, draught, volume; it floats with its centre of gravity above that of
        buoyancy.
    """
    return hull_from_particulars(
        name=ship.name, L=ship.L, B=ship.B, d=ship.d, block=ship.block, xB=ship.xG
    )


def _from_file(path: Path) -> Hull:
    data = read_toml(path)
    problems = [
        Problem(message=f"lacks {key}", file=str(path)) for key in _NEEDED if key not in data
    ]
    given: dict[str, Any] = {"name": str(data.get("name", path.stem))}
    for key, value in data.items():
        if key == "name":
            continue
        if key not in (*_NEEDED, *_ALLOWED):
            message = f"{key} is not known; there are name, {', '.join((*_NEEDED, *_ALLOWED))}"
            problems.append(Problem(message=message, file=str(path)))
        elif number(value) is None:
            problems.append(Problem(message=f"{key} must be a finite number", file=str(path)))
        else:
            given[key] = number(value)
    if problems:
        raise DataError(problems, title="Hull")
    return hull_from_particulars(**given)
