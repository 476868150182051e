"""What every structure must hold."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Final, get_args, get_type_hints

import numpy as np

from pmmkit.base import PmmkitError
from pmmkit.conventions import (
    CHANNELS,
    Convention,
    Structure,
    Water,
    bibliography,
    parse_derivative,
)
from pmmkit.effects import Regressors, State
from pmmkit.models import converted, from_values, load_ship
from pmmkit.numerics import Array
from pmmkit.testing import hold

_INSTANTS: Final = 400
_SMALLEST: Final = 1e-6
"""Least singular value of columns of unit length: less, and no test could tell two terms apart."""


def check_structure(structure: Structure) -> None:
    """Whether a structure can stand beside those of pmmkit.

    Its derivatives are written canonically, each once, by channel; the terms of each channel can
    be told apart in some motion; a table of them converts to the other system and back; each
    source is a key of the bibliography.

    Parameters
    ----------
    structure : Structure
        An entry, yours or pmmkit's.

    Raises
    ------
    AssertionError
        With everything that does not hold.

    Examples
    --------
    >>> from pmmkit.conventions import STRUCTURES
    >>> check_structure(STRUCTURES["mmg"])
    >>> check_structure(Structure(name="My hull", derivatives=("Yvrv", "Nvvr", "Nrvv")))
    Traceback (most recent call last):
    AssertionError: Structure 'My hull':
    - its name is not of small letters, digits and hyphens
    - Yvrv is written Yvvr
    - Nrvv is written Nvvr
    - a derivative comes twice
    """
    found = list(_faults(structure)) or _unusable(structure)
    hold(f"Structure {structure.name!r}", found)


def _faults(structure: Structure) -> Iterator[str]:
    name = structure.name
    if not (name.replace("-", "").isalnum() and name.isascii() and name == name.lower()):
        yield "its name is not of small letters, digits and hyphens"
    names: list[str] = []
    for written in structure.derivatives:
        try:
            names.append(parse_derivative(written).name)
        except PmmkitError as error:
            yield str(error)
        else:
            if written != names[-1]:
                yield f"{written} is written {names[-1]}"
    if len(set(names)) < len(names):
        yield "a derivative comes twice"
    places = [CHANNELS.index(item[0]) for item in names]
    if places != sorted(places):
        yield f"its derivatives are not in the order of the channels {', '.join(CHANNELS)}"
    hints = get_type_hints(Structure)
    for field in ("system", "surge"):
        if getattr(structure, field) not in get_args(hints[field]):
            yield f"{field} is {getattr(structure, field)!r}, not {get_args(hints[field])}"
    for key in structure.sources:
        if key not in bibliography():
            yield f"its source {key!r} is no key of the bibliography"


def _unusable(structure: Structure) -> Iterator[str]:
    ship, water = load_ship("s175"), Water()
    convention = Convention(system=structure.system, surge=structure.surge)
    state, approach = _motion(ship.L)
    for channel in CHANNELS:
        names = [name for name in structure.derivatives if name[0] == channel]
        columns = Regressors.at(
            names, state, ship=ship, water=water, convention=convention, approach_speed=approach
        ).columns
        unit = columns / np.linalg.norm(columns, axis=0)
        if names and not np.linalg.svd(unit, compute_uv=False)[-1] > _SMALLEST:
            yield f"no motion tells its terms in {channel} apart"
    if structure.surge == "u":
        values = {name: 0.01 * (place + 1) for place, name in enumerate(structure.derivatives)}
        table = from_values(values, ship=ship, water=water, convention=convention)
        other = "prime" if structure.system == "prime-d" else "prime-d"
        back = converted(converted(table, system=other), system=structure.system).at()
        moved = [name for name, value in values.items() if abs(back[name] / value - 1.0) > 1e-12]
        if moved:
            yield f"{', '.join(moved)} do not come back from a conversion to {other}"


def _motion(L: float) -> tuple[State, float]:
    """All that a ship can do, at once, and its approach speed [m/s]."""
    rng = np.random.default_rng(1)
    approach = 8.0

    def spread(size: float) -> Array:
        return size * rng.uniform(-1.0, 1.0, _INSTANTS)

    state = State.of(
        u=approach * rng.uniform(0.5, 1.1, _INSTANTS),
        v=spread(3.0),
        r=spread(4.0 / L),
        p=spread(4.0 / L),
        phi=spread(0.3),
        delta=spread(0.6),
        udot=spread(0.1),
        vdot=spread(0.3),
        rdot=spread(1.0 / L),
        pdot=spread(1.0 / L),
        thrust=spread(1e6),
    )
    return state, approach
