"""The fields of the form: from the ship, and from what the table ``[imo]`` states."""

from __future__ import annotations

import math
from collections.abc import Mapping
from pathlib import Path
from typing import Any, Final

from pmmkit.errors import DataError
from pmmkit.report.imo_form.form import Entry
from pmmkit.ship import Ship
from pmmkit.simulation.imo.conditions import draught_condition
from pmmkit.trials.conditions import mean_draught

TABLE: Final = "imo"
SAME: Final = 0.005
"""Share by which two draughts may differ and be taken for one."""


def read_stated(file: Path) -> dict[str, Any]:
    """The table ``[imo]`` of a file.

    Parameters
    ----------
    file : Path
        TOML; a campaign file is one too.

    Raises
    ------
    DataError
        If the file has no such table, or with everything that is wrong in it.
    """
    from pmmkit.campaigns.file.imo_table import ImoEntry
    from pmmkit.campaigns.file.schema import read_entry
    from pmmkit.errors import Problem
    from pmmkit.toml_files import read_toml

    content = read_toml(file)
    if not isinstance(content.get(TABLE), Mapping):
        raise DataError(f"{file} has no table [{TABLE}]; docs/imo.md lists its keys.")
    problems: list[Problem] = []
    found = read_entry(
        ImoEntry, content[TABLE], file=str(file), entry=f"[{TABLE}]", problems=problems
    )
    if problems or found is None:
        raise DataError(problems, title=f"{file} cannot be read")
    return {name: value for name, value in found if value is not None}


def ship_entries(stated: Mapping[str, Any], ship: Ship, speed: float) -> tuple[Entry, ...]:
    """The ship at full load, in the order of the form.

    Parameters
    ----------
    stated : mapping
        The table ``[imo]``.
    ship : Ship
        Of the model or the trial.
    speed : float
        Test speed [m/s].
    """
    full = stated.get("full_load_draught")
    same = full is not None and abs(ship.d / full - 1.0) <= SAME
    draught = ship.d if full is None else full
    note = f"at {ship.d:.4g} m, loading not supplied" if full is None else ""
    block = stated.get("full_load_block", ship.block if same or full is None else None)
    area = stated.get("rudder_area")
    return (
        _words("ship_type", "ship type", stated),
        Entry(name="L", title="length L", value=ship.L, unit="m"),
        Entry(name="L_over_V", title="L/V", value=ship.L / speed, unit="s"),
        Entry(name="L_over_B", title="L/B", value=ship.L / ship.B),
        Entry(name="B_over_T", title="B/T", value=ship.B / draught, note=note),
        Entry(name="block", title="block coefficient CB", value=block, note=note),
        Entry(name="full_load_draught", title="full load draught T", value=full, unit="m"),
        Entry(
            name="full_load_trim",
            title="trim of full load, by the stern",
            value=stated.get("full_load_trim"),
            unit="m",
        ),
        _words("rudder_type", "rudder type", stated),
        _words("rudders", "number of rudders", stated),
        Entry(
            name="rudder_area_over_LT",
            title="total rudder area/(L T)",
            value=None if area is None else area / (ship.L * draught),
        ),
        _words("propeller_type", "propeller type", stated),
        _words("propellers", "number of propellers", stated),
        _words("engine_type", "engine type", stated),
        _words("ballast", "ballast condition", stated),
    )


def head_entries(stated: Mapping[str, Any]) -> tuple[Entry, ...]:
    """To whom the form goes."""
    return (
        _words("administration", "administration", stated),
        _words("reference", "reference number", stated),
    )


def loading_entries(
    stated: Mapping[str, Any], ship: Ship, loading: str | None
) -> tuple[Entry, ...]:
    """The loading as tried.

    Parameters
    ----------
    stated : mapping
        The table ``[imo]``.
    ship : Ship
        As tried.
    loading : str or None
        Whether that was full load, in words.
    """
    fore, aft = stated.get("draught_fore"), stated.get("draught_aft")
    trim = None if fore is None or aft is None else aft - fore
    return (
        Entry(name="loading", title="loading condition", value=loading),
        Entry(name="draught", title="mean draught", value=mean_draught(stated, ship.d), unit="m"),
        Entry(name="trim", title="trim, by the stern", value=trim, unit="m"),
    )


def sailed_entries(
    *, speed: str | float | None, rudder: str | float | None, revolutions: float
) -> tuple[Entry, ...]:
    """How the tests were sailed: approach speed [m/s], rudder [deg], revolutions [1/s]."""
    turns = 60.0 * revolutions if math.isfinite(revolutions) else None
    return (
        Entry(name="speed", title="approach speed", value=speed, unit="m/s"),
        Entry(name="rudder", title="rudder of the turning circle", value=rudder),
        Entry(name="revolutions", title="revolutions of the approach", value=turns, unit="1/min"),
    )


def place_entries(stated: Mapping[str, Any]) -> tuple[Entry, ...]:
    """Where and when."""
    return (_words("place", "place", stated), _words("date", "date", stated))


def loading_words(draught: float, full: float | None, *, corrected: bool) -> str | None:
    """Whether tests were made at full load; None where that is not known.

    Parameters
    ----------
    draught : float
        Mean draught as tried [m].
    full : float or None
        That of full load [m].
    corrected : bool
        Whether the results are carried there.

    Examples
    --------
    >>> loading_words(20.5, 20.8, corrected=False)
    'tested at full load'
    >>> loading_words(11.0, 20.8, corrected=True)
    'tested at partial load and corrected'
    """
    met = draught_condition(draught, full).met
    if corrected:
        return "tested at partial load and corrected"
    if met is None:
        return None
    return "tested at full load" if met else "tested at partial load, not corrected"


def _words(name: str, title: str, stated: Mapping[str, Any]) -> Entry:
    return Entry(name=name, title=title, value=stated.get(name))
