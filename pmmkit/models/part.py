"""Parts of a model: effects by name with their values."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from types import MappingProxyType
from typing import Any, Final

from pmmkit.base import UnknownNameError
from pmmkit.conventions import parse_derivative
from pmmkit.effects import CATALOGUE, HULL, INERTIA, AddedMass, Effect, written_effect
from pmmkit.models.step import Value

DERIVATIVE_PARTS: Final = (HULL, "rudder_abkowitz", INERTIA)


def _frozen() -> Mapping[str, Any]:
    return MappingProxyType({})


@dataclass(frozen=True, kw_only=True)
class Part:
    """One effect of a model with its values.

    Parameters
    ----------
    effect : str
        Name in the catalogue.
    values : mapping of str to float or tuple of float
        Parameters and derivatives; a tuple holds a value per Froude number of the model.
    options : mapping of str to str
        Words that choose a form of the effect.
    source : str
        Where the values come from: ``measured: …``, ``library: …``, ``empirical: …``.
    references : tuple of str
        The same as keys of the bibliography, where it stands there.
    sources : mapping of str to str
        In words for single values, where it differs.
    std : mapping of str to float
        Standard uncertainties of single values, such as estimates, independent of each other and
        of the model's covariance; the same share of the value at all Froude numbers.
    text : str
        The words of a user that the effect was made from; empty for one of the catalogue.
    """

    effect: str
    values: Mapping[str, Value] = field(default_factory=_frozen)
    options: Mapping[str, str] = field(default_factory=_frozen)
    source: str = ""
    references: tuple[str, ...] = ()
    sources: Mapping[str, str] = field(default_factory=_frozen)
    std: Mapping[str, float] = field(default_factory=_frozen)
    text: str = ""

    @property
    def known(self) -> Effect:
        """What the catalogue, or the user's text, says of the effect."""
        return written_effect(self.effect, self.text) if self.text else CATALOGUE[self.effect]

    def source_of(self, name: str) -> str:
        """Where one value comes from."""
        return self.sources.get(name, self.source)

    def place(self, name: str) -> str:
        """One of its values by one name: ``Yv``, or ``rudder_mmg.aH`` where it is no derivative."""
        return place_name(self.effect, name)

    @property
    def estimated(self) -> list[str]:
        """Names of the values that are estimates from particulars."""
        return [name for name in self.values if self.source_of(name).startswith("empirical")]

    def assumed(self, name: str = "") -> bool:
        """Whether a value, or the part, is a usual one that stands for what nobody states."""
        return self.source_of(name).startswith("assumed")

    def problems(self, rows: int) -> list[str]:
        """Everything that is wrong with it, in a model of so many Froude numbers."""
        if not self.text and self.effect not in CATALOGUE:
            return [f"There is no effect {self.effect!r}; there are: {', '.join(CATALOGUE)}."]
        known = self.known
        found = known.problems(self.values, self.options)
        lost = [x for x in self.values if x not in (*AddedMass.places(), "lx")]
        if self.effect == INERTIA and lost:
            found.append(f"The equations of motion have no place for {', '.join(lost)}.")
        for name, value in self.values.items():
            place = f"{self.effect}.{name}"
            numbers = value if isinstance(value, tuple) else (value,)
            if name in known.tables:
                if len(numbers) < 2:
                    found.append(f"{place} must be a list of two numbers or more.")
            elif isinstance(value, tuple) and len(value) != rows:
                found.append(f"{place} has {len(value)} values for {rows} Froude numbers.")
            if not all(math.isfinite(x) for x in numbers):
                found.append(f"{place} must be finite: {value}.")
                continue
            parameter = known.parameter(name)
            if parameter is None:
                if known.accepts(name) and parse_derivative(name).name != name:
                    found.append(f"{place} is spelled {parse_derivative(name).name}.")
                elif known.accepts(name) and "T" in parse_derivative(name).factors:
                    found.append(f"{place}: factors of the thrust are not simulated.")
            elif not all(parameter.low <= x <= parameter.high for x in numbers):
                found.append(
                    f"{place} = {value} is outside {parameter.low:g} to {parameter.high:g} "
                    f"[{parameter.unit}]."
                )
        stray = [name for name in self.sources if name not in self.values]
        if stray:
            found.append(f"{self.effect} states a source of {', '.join(stray)} but no value.")
        stray = [name for name in self.std if name not in self.values]
        if stray:
            found.append(
                f"{self.effect} states the uncertainty of {', '.join(stray)} but no value."
            )
        wrong = [name for name, x in self.std.items() if not (math.isfinite(x) and x >= 0)]
        if wrong:
            found.append(f"{self.effect}: uncertainties of {', '.join(wrong)} must be 0 or more.")
        return found


def place_name(effect: str, name: str) -> str:
    """A value of a model by one name: ``Yv``, or ``rudder_mmg.aH`` where it is no derivative.

    Examples
    --------
    >>> place_name("hull_polynomial", "Yv"), place_name("rudder_mmg", "aH")
    ('Yv', 'rudder_mmg.aH')
    """
    return name if effect in DERIVATIVE_PARTS else f"{effect}.{name}"


def needs_roll(name: str) -> bool:
    """Whether a value is a derivative that belongs to roll.

    Examples
    --------
    >>> [needs_roll(name) for name in ("Kv", "Nvvphi", "Yp", "Ypdot", "Yv", "lx")]
    [True, True, True, True, False, False]
    """
    try:
        return name != "lx" and parse_derivative(name).rolls
    except UnknownNameError:
        return False
