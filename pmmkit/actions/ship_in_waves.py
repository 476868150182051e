"""What is typed of a ship in waves: hull, speeds, places, roll damping, state of the sea."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from pmmkit.actions.setting import SettingError
from pmmkit.actions.speeds import FROUDE, typed_list
from pmmkit.actions.text import numbers, words

if TYPE_CHECKING:
    from pmmkit.seakeeping import Hull, Loading, Place, RollDamping, Sea


def sea_of_code(code: int) -> Sea:
    """The sea of a state of WMO."""
    from pmmkit.seakeeping import sea_states

    states = {state.code: state for state in sea_states()}
    if code not in states:
        raise SettingError(f"--sea-state {code}: there are {', '.join(map(str, states))}.")
    return states[code].sea


def _keels(text: str) -> dict[str, float]:
    size = numbers(text) or ()
    if len(size) != 2:
        raise SettingError(f"--bilge-keels {text!r}: write breadth,length in m, or 0,0.")
    return dict(zip(("keel_breadth", "keel_length"), size, strict=True))


def typed_hull(ship: str, draught: float | None, length: float | None) -> Hull:
    """A hull from a file of offsets, or one of the library."""
    from pmmkit.seakeeping import load_hull, read_hull

    if Path(ship).suffix.lower() not in (".csv", ".mgf"):
        return load_hull(ship)
    if draught is None:
        raise SettingError("A hull from a file needs --draught [m].")
    return read_hull(ship, draught=draught, L=length)


def typed_speeds(text: str, L: float) -> list[float]:
    """Speeds [m/s] of a ship of a length."""
    from math import sqrt

    return [
        speed.value * sqrt(9.81 * L) if speed.unit == FROUDE else speed.without_ship()
        for speed in typed_list(text)
    ]


def typed_place(text: str) -> Place:
    """A place out of text such as bow,150,8,20.8."""
    from pmmkit.seakeeping import Place

    name, *rest = words(text)
    try:
        values = [float(part) for part in rest]
    except ValueError:
        values = []
    if not 1 <= len(values) <= 3:
        raise SettingError(f"--place {text!r}: write name,x[,freeboard[,draught]] in m.")
    x, freeboard, draught = [*values, None, None][:3]
    assert x is not None
    return Place(name=name, x=x, freeboard=freeboard, draught=draught)


def damped(
    text: str, hull: Hull, loading: Loading, speeds: list[float], waves: Sea | None
) -> RollDamping:
    """Roll damping with bilge keels as they were typed, for the one speed and the sea there are."""
    from pmmkit.seakeeping import RollDamping

    if waves is None or len(speeds) != 1:
        raise SettingError(
            "The damping of --bilge-keels grows with the rate of roll and the speed: state a sea "
            "(--hs, --tp) and one speed."
        )
    return RollDamping.of(hull, loading, speed=speeds[0], **_keels(text))
