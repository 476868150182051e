"""Speeds as they are typed: 8.0, '8 m/s', '15.5 kn', 'Fn 0.2'."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Annotated, Final

from pmmkit.actions.outcome import say
from pmmkit.actions.setting import Help, SettingError
from pmmkit.conventions import is_unit, unit_factor

if TYPE_CHECKING:
    from pmmkit.conventions import Ship, Water
    from pmmkit.models import Model

WAYS: Final = "8.0 [m/s], '15.5 kn' or 'Fn 0.2'"
"""How a speed is typed."""
FROUDE: Final = "fn"
"""Sign of a Froude number, in place of a unit."""
_TYPED: Final = re.compile(
    r"(?:(?P<sign>fn)\s*[=:]?\s*)?(?P<number>[-+.\d][-+.\de]*)\s*(?P<unit>.*)"
)


@dataclass(frozen=True)
class TypedSpeed:
    """A speed as it was typed.

    `unit`: of a speed; ``fn`` for a Froude number, empty where none was typed, which are m/s.
    """

    value: float
    unit: str = ""

    def __str__(self) -> str:
        """As it is typed again."""
        return f"{self.value!r} {self.unit}".strip()

    def without_ship(self) -> float:
        """The speed [m/s], which a Froude number does not say."""
        if self.unit == FROUDE:
            raise SettingError(f"Fn {self.value:g}: write 10 [m/s] or '20 kn'.")
        return self.value * unit_factor(self.unit or "m/s")[1]

    def of(self, ship: Ship, water: Water) -> float:
        """The speed [m/s] of a ship at its own scale.

        Examples
        --------
        >>> from pmmkit.models import load_model
        >>> model = load_model("kvlcc2")
        >>> [round(typed(text).of(model.ship, model.water), 3) for text in ("15.5 kn", "Fn 0.1423")]
        [7.974, 7.973]
        """
        if self.unit == FROUDE:
            return ship.speed(self.value, water.g)
        return self.without_ship()


def typed(text: str) -> TypedSpeed:
    """A speed out of text.

    Examples
    --------
    >>> typed("8.0"), typed("8 m/s"), typed("15.5 knots"), typed("Fn=0.2")
    (TypedSpeed(value=8.0, unit=''), TypedSpeed(value=8.0, unit='m/s'), \
TypedSpeed(value=15.5, unit='knots'), TypedSpeed(value=0.2, unit='fn'))
    """
    try:
        return TypedSpeed(float(text))
    except ValueError:
        pass
    found = _TYPED.fullmatch(text.strip().lower())
    if found is None:
        raise _unreadable(text)
    unit = found["unit"] if found["sign"] is None else " ".join([FROUDE, found["unit"]]).strip()
    if unit != FROUDE and not (is_unit(unit) and unit_factor(unit)[0] == "m/s"):
        raise _unreadable(text)
    try:
        return TypedSpeed(float(found["number"]), unit)
    except ValueError:
        raise _unreadable(text) from None


def typed_list(text: str) -> tuple[TypedSpeed, ...]:
    """Speeds out of text such as ``6,9,12``, ``10,12,15 kn`` or ``Fn 0.1,0.15``.

    A unit that stands once is that of all.

    Examples
    --------
    >>> [speed.unit for speed in typed_list("10,12,15 kn")]
    ['kn', 'kn', 'kn']
    """
    apart = re.split(r"[,;]", text) if re.search(r"[,;]", text) else [text]
    parts = [part for part in apart if part.strip()]
    if len(parts) == 1 and _all_numbers(parts[0].split()):
        parts = parts[0].split()
    found = tuple(typed(part) for part in parts)
    units = {speed.unit for speed in found if speed.unit}
    bare = sum(not speed.unit for speed in found)
    if units and bare and len(found) - bare > 1:
        raise SettingError(f"{text!r}: state the unit once for all speeds, or with each.")
    return tuple(replace(speed, unit=speed.unit or "".join(units)) for speed in found)


def _flow(text: str) -> float:
    """The speed [m/s] of wind or current."""
    return typed(text).without_ship()


def _all_numbers(words: Sequence[str]) -> bool:
    try:
        return bool([float(word) for word in words])
    except ValueError:
        return False


def _unreadable(text: str) -> SettingError:
    return SettingError(f"{text!r} is no speed: write {WAYS}.")


def approach(speed: TypedSpeed | None, model: Model) -> float:
    """The speed [m/s] at which a model is to sail: the one typed, else the only one tested.

    Examples
    --------
    >>> from pmmkit.models import load_model
    >>> approach(typed("8.0"), load_model("kvlcc2"))
    8.0
    """
    if speed is not None:
        return speed.of(model.ship, model.water)
    tested = [model.ship.speed(Fn, model.water.g) for Fn in model.Fn]
    if len(tested) == 1:
        said = f"{tested[0]:.4g} m/s, Fn {model.Fn[0]:.3f}"
        say(f"Without --speed the ship sails at that of the tests: {said}.")
        return tested[0]
    there = ", ".join(f"{x:.4g}" for x in tested)
    known = f" This model was tested at {there} m/s." if tested else ""
    raise SettingError(f"State the speed of the approach: {WAYS}.{known}", option="--speed")


Speed = Annotated[
    TypedSpeed | None,
    Help(
        f"Approach speed of the ship in the model, at the model's own scale: {WAYS}; the "
        "tested one if the model was tested at one alone.",
        read=typed,
        metavar="SPEED",
        unit="m/s",
    ),
]
WindSpeed = Annotated[
    float,
    Help(
        "True wind in m/s, or such as '20 kn'.",
        read=_flow,
        metavar="SPEED",
        usual=(0.0, 30.0, 0.5),
        unit="m/s",
    ),
]
CurrentSpeed = Annotated[
    float, Help("Current in m/s, or such as '1.5 kn'.", read=_flow, metavar="SPEED", unit="m/s")
]
