"""A model as the effects of the catalogue see it, and how they move its values."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from types import MappingProxyType

from pmmkit.conventions import Convention, Ship, Water, parse_derivative
from pmmkit.effects import HULL, INERTIA, Effect, Move
from pmmkit.models.model import Model


@dataclass(frozen=True)
class Sailing:
    """A model at a speed; `effects.seen.Vessel` says what each word is."""

    model: Model
    speed: float

    @property
    def ship(self) -> Ship:
        """Particulars."""
        return self.model.ship

    @property
    def water(self) -> Water:
        """The water it sails in."""
        return self.model.water

    def derivatives(self) -> Mapping[str, float]:
        """Derivatives of hull and added mass; of several Froude numbers those in the middle."""
        found: dict[str, float] = {}
        for part in (HULL, INERTIA):
            for name, value in self.model.parts[part].values.items():
                found[name] = value[len(value) // 2] if isinstance(value, tuple) else float(value)
        return found

    def holds(self, part: str, value: str) -> bool:
        """Whether a part of the model uses a value, with the options it has."""
        if part not in self.model.parts:
            return False
        own = self.model.parts[part]
        known = own.known
        parameter = known.parameter(value)
        return parameter is not None and (
            parameter.form is None
            or known.chosen(own.options)[parameter.form[0]] in parameter.form[1:]
        )

    def moves(self, effect: Effect) -> Mapping[str, Move]:
        """How the coefficients of an effect move the values of the model.

        Coefficients of derivatives are those of the catalogue, in the prime system.
        """
        if effect.moves is not None:
            found = effect.moves(self)
            if effect.kind != "terms":
                return found
            if found:
                return {label: _in_the_system_of(self.model, move) for label, move in found.items()}
        if effect.kind == "terms":
            return {
                label: Move(
                    values={
                        name: share * _from_prime(self.model, name)
                        for name, share in effect.derivatives_of(label).items()
                    },
                    typical=size,
                )
                for label, size in effect.typical.items()
            }
        part = effect.frees or effect.name
        held = [
            label
            for label in effect.typical
            if (effect.enters and part not in self.model.parts) or self.holds(part, label)
        ]
        return {
            label: Move(values={f"{part}.{label}": 1.0}, typical=effect.typical[label])
            for label in held
        }

    def told(self, options: Mapping[str, Mapping[str, str]], begins: Mapping[str, float]) -> Model:
        """The model with its parts told to use values, which act as little as before.

        Parameters
        ----------
        options : mapping of str to (mapping of str to str)
            By part: the words that it is told; those that it has by default need not be said.
        begins : mapping of str to float
            What values become that the part did not use before.

        Examples
        --------
        >>> from pmmkit.models.store import load_model
        >>> ship = load_model("s175")
        >>> begins = {"rudder_mmg.stall_deg": 20.0, "rudder_mmg.stall_loss": 0.0}
        >>> stalls = Sailing(ship, 1.0).told({"rudder_mmg": {"stall": "smooth"}}, begins)
        >>> Sailing(stalls, 1.0).told({"rudder_mmg": {"stall": "smooth"}}, begins) is stalls
        True
        """
        model, parts = self.model, dict(self.model.parts)
        for name, words in options.items():
            part = parts[name]
            chosen = part.known.chosen(part.options)
            new = {option: word for option, word in words.items() if chosen[option] != word}
            parts[name] = replace(part, options=MappingProxyType({**part.options, **new}))
        for place, value in begins.items():
            name, _, own = place.partition(".")
            if not self.holds(name, own) or own not in parts[name].values:
                values = MappingProxyType({**parts[name].values, own: value})
                parts[name] = replace(parts[name], values=values)
        same = all(parts[name] == model.parts[name] for name in parts)
        return model if same else replace(model, parts=MappingProxyType(parts))


def _in_the_system_of(model: Model, move: Move) -> Move:
    """A move whose derivatives are of the prime system, in the system and signs of a model."""
    values = {
        name: share if "." in name else share * _from_prime(model, name)
        for name, share in move.values.items()
    }
    return replace(move, values=MappingProxyType(values))


def _from_prime(model: Model, name: str) -> float:
    """A derivative of the prime system in the system and signs of a model, per unit."""
    convention, ship, water = model.convention, model.ship, model.water
    U = convention.speed_unit(ship=ship, water=water, U=1.0)
    prime = Convention(system="prime").force_unit(name[0], ship=ship, water=water, U=U)
    ratio = prime / convention.force_unit(name[0], ship=ship, water=water, U=1.0)
    derivative, sign = parse_derivative(name), 1.0
    if convention.sway == "beta":
        sign *= derivative.sign_under_flip("v")
    if convention.rudder_positive == "port":
        sign *= derivative.sign_under_flip("d")
    return sign * ratio
