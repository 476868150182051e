"""The fields of the form: from the ship, and from what the table ``[imo]`` states."""

from __future__ import annotations

import math
from collections.abc import Mapping
from pathlib import Path
from typing import Any, Final

from pmmkit.base import DataError
from pmmkit.conventions import Ship
from pmmkit.imo import Condition
from pmmkit.views.report.imo_form.form import FormField

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
    from pmmkit.campaigns import CampaignFile
    from pmmkit.files import read_toml

    content = read_toml(file)
    if not isinstance(content.get(TABLE), Mapping):
        raise DataError(f"{file} has no table [{TABLE}]; docs/imo.md lists its keys.")
    return CampaignFile.stated(TABLE, content[TABLE], str(file))


def ship_entries(stated: Mapping[str, Any], ship: Ship, speed: float) -> tuple[FormField, ...]:
    """The ship at full load, in the order of the form.

    speed [m/s].
    """
    full = stated.get("full_load_draught")
    same = full is not None and abs(ship.d / full - 1.0) <= SAME
    draught = ship.d if full is None else full
    note = f"at {ship.d:.4g} m, loading not supplied" if full is None else ""
    block = stated.get("full_load_block", ship.block if same or full is None else None)
    area = stated.get("rudder_area")
    return (
        _words("ship_type", "ship type", stated),
        FormField(name="L", title="length L", value=ship.L, unit="m"),
        FormField(name="L_over_V", title="L/V", value=ship.L / speed, unit="s"),
        FormField(name="L_over_B", title="L/B", value=ship.L / ship.B),
        FormField(name="B_over_T", title="B/T", value=ship.B / draught, note=note),
        FormField(name="block", title="block coefficient CB", value=block, note=note),
        FormField(name="full_load_draught", title="full load draught T", value=full, unit="m"),
        FormField(
            name="full_load_trim",
            title="trim of full load, by the stern",
            value=stated.get("full_load_trim"),
            unit="m",
        ),
        _words("rudder_type", "rudder type", stated),
        _words("rudders", "number of rudders", stated),
        FormField(
            name="rudder_area_over_LT",
            title="total rudder area/(L T)",
            value=None if area is None else area / (ship.L * draught),
        ),
        _words("propeller_type", "propeller type", stated),
        _words("propellers", "number of propellers", stated),
        _words("engine_type", "engine type", stated),
        _words("ballast", "ballast condition", stated),
    )


def head_entries(stated: Mapping[str, Any]) -> tuple[FormField, ...]:
    """To whom the form goes."""
    return (
        _words("administration", "administration", stated),
        _words("reference", "reference number", stated),
    )


def loading_entries(
    stated: Mapping[str, Any], ship: Ship, loading: str | None
) -> tuple[FormField, ...]:
    """The loading as tried."""
    fore, aft = stated.get("draught_fore"), stated.get("draught_aft")
    draught, trim = ship.d, None
    if fore is not None and aft is not None:
        draught, trim = 0.5 * (fore + aft), aft - fore
    return (
        FormField(name="loading", title="loading condition", value=loading),
        FormField(name="draught", title="mean draught", value=draught, unit="m"),
        FormField(name="trim", title="trim, by the stern", value=trim, unit="m"),
    )


def sailed_entries(
    *, speed: str | float | None, rudder: str | float | None, revolutions: float
) -> tuple[FormField, ...]:
    """How the tests were sailed: approach speed [m/s], rudder [deg], revolutions [1/s]."""
    turns = 60.0 * revolutions if math.isfinite(revolutions) else None
    return (
        FormField(name="speed", title="approach speed", value=speed, unit="m/s"),
        FormField(name="rudder", title="rudder of the turning circle", value=rudder),
        FormField(
            name="revolutions", title="revolutions of the approach", value=turns, unit="1/min"
        ),
    )


def place_entries(stated: Mapping[str, Any]) -> tuple[FormField, ...]:
    """Where and when."""
    return (_words("place", "place", stated), _words("date", "date", stated))


def loading_words(draught: float, full: float | None, *, corrected: bool) -> str | None:
    """Whether tests were made at full load; None where that is not known.

    draught [m]; full [m].

    Examples
    --------
    >>> loading_words(20.5, 20.8, corrected=False)
    'tested at full load'
    >>> loading_words(11.0, 20.8, corrected=True)
    'tested at partial load and corrected'
    """
    met = Condition.of_draught(draught, full).met
    if corrected:
        return "tested at partial load and corrected"
    if met is None:
        return None
    return "tested at full load" if met else "tested at partial load, not corrected"


def _words(name: str, title: str, stated: Mapping[str, Any]) -> FormField:
    return FormField(name=name, title=title, value=stated.get(name))
