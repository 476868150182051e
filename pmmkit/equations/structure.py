"""The structure of a model: which effects and terms, without their values."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any, Final

from pmmkit.base import MissingPartError, ModelError, Problem
from pmmkit.conventions import CHANNELS, Convention, Ship, Water, parse_derivative
from pmmkit.effects import CATALOGUE, HULL, Effect, written_effect
from pmmkit.equations.layouts import ROLLING, STATES, Constant
from pmmkit.models import Model

# A hull polynomial as monomials with dimensional coefficients.


FACTOR_PLACES: Final = ("0", "u", "v", "r", "p", "phi", "d", "|u|", "|v|", "|r|", "|p|", "|d|")
"""Factors in the order by which a `Monomial` counts them."""

Monomial = tuple[tuple[int, ...], Mapping[str, Any]]
"""Places of the factors, and by channel the coefficients of X, Y [N] and N, K [N m] at 1 m/s."""


def polynomial(
    values: Mapping[str, Any], *, ship: Ship, water: Water, convention: Convention
) -> tuple[Monomial, ...]:
    """A hull polynomial as monomials with dimensional coefficients."""
    collected: dict[tuple[int, ...], dict[str, Any]] = {}
    for name, value in values.items():
        derivative = parse_derivative(name)
        products: tuple[tuple[str, ...], ...] = (derivative.factors,)
        if convention.surge == "constant" and derivative.factors == ("u", "u"):
            products = (("u", "u"), ("v", "v")) if convention.system == "bis" else (("0",),)
        sign = 1.0
        if convention.sway == "beta":
            sign *= derivative.sign_under_flip("v")
        if convention.rudder_positive == "port":
            sign *= derivative.sign_under_flip("d")
        unit = convention.force_unit(derivative.channel, ship=ship, water=water, U=1.0)
        for factors in products:
            places = tuple(FACTOR_PLACES.index(factor) for factor in factors if factor != "0")
            entry = collected.setdefault(places, {})
            coefficient = sign * unit * value
            channel = derivative.channel
            entry[channel] = entry[channel] + coefficient if channel in entry else coefficient
    return tuple(
        (places, {channel: entry[channel] for channel in CHANNELS if channel in entry})
        for places, entry in sorted(collected.items())
    )


POLYNOMIALS: Final = (HULL, "rudder_abkowitz")
ACCELERATIONS: Final = (
    "Xudot",
    "Yvdot",
    "Yrdot",
    "Ypdot",
    "Nvdot",
    "Nrdot",
    "Npdot",
    "Kvdot",
    "Krdot",
    "Kpdot",
)
Products = tuple[tuple[tuple[int, ...], tuple[str, ...]], ...]
"""Places of the factors of each product, and the channels that it enters."""


@dataclass(frozen=True, kw_only=True)
class Used:
    """One effect as a model uses it.

    Parameters
    ----------
    effect : str
        Its name.
    options, tables : tuple of (str, int)
        Options with the index of what is chosen, tables with their lengths.
    text : str
        That of the user who made the effect, where it is none of the catalogue.
    edition : int
        Tells effects apart that were registered one after another under one name.
    """

    effect: str
    options: tuple[tuple[str, int], ...] = ()
    tables: tuple[tuple[str, int], ...] = ()
    text: str = ""
    edition: int = 0

    @property
    def known(self) -> Effect:
        """What the catalogue says of it."""
        return written_effect(self.effect, self.text) if self.text else CATALOGUE[self.effect]

    @property
    def arguments(self) -> tuple[str, ...]:
        """What its function asks for, by name."""
        return self.known.arguments

    @property
    def own(self) -> tuple[str, ...]:
        """Parameters of its own that its function asks for, in the order of the constants."""
        parameters = {item.name for item in self.known.parameters}
        return tuple(name for name in self.arguments if name in parameters)


@dataclass(frozen=True, kw_only=True)
class EquationStructure:
    """What of a model decides on the code of its equations.

    `products`: products of the hull polynomial and their channels; None for a kernel that takes
    them as data, slower but the same for all polynomials. `used`: the other effects in the
    order in which they are evaluated. `rolls`: whether roll is a degree of freedom. `follows`:
    places of the constants that follow the speed of the moment, ascending; behind the other
    constants stand a number of speeds and, for each, itself and the values of these places.
    """

    products: Products | None
    used: tuple[Used, ...]
    rolls: bool
    follows: tuple[int, ...] = ()

    @cached_property
    def states(self) -> tuple[str, ...]:
        """Names of the states, those of the effects last."""
        ship = STATES + (ROLLING if self.rolls else ())
        return ship + tuple(state for item in self.used for state in item.known.states)

    @cached_property
    def brought(self) -> tuple[str, ...]:
        """Names of the states that effects bring."""
        return tuple(name for name in self.states if name not in (*STATES, *ROLLING))

    @cached_property
    def revolutions(self) -> bool:
        """Whether revolutions of a propeller enter."""
        return any({"n", "n_order"} & set(item.arguments) for item in self.used)

    @property
    def told(self) -> tuple[str, ...]:
        """Forces and moment of all effects, and the signals that they give each other."""
        signals = (
            output
            for item in self.used
            for output in item.known.outputs
            if output not in (*CHANNELS, *ACCELERATIONS) and not output.endswith("_rate")
        )
        return (*CHANNELS, *dict.fromkeys(signals))

    @cached_property
    def width(self) -> int:
        """Number of the constants, without what follows the speed and a polynomial as data."""
        return max((at.stop for at in self.places().values()), default=self._first_place)

    @cached_property
    def _first_place(self) -> int:
        return len(Constant) + sum(len(channels) for _, channels in self.products or ())

    def places(self) -> dict[tuple[str, str], slice]:
        """Where each parameter stands in the constants: (effect, name) to a slice."""
        found: dict[tuple[str, str], slice] = {}
        place = self._first_place
        for item in self.used:
            lengths = dict(item.tables)
            for name in item.own:
                length = lengths.get(name, 1)
                found[item.effect, name] = slice(place, place + length)
                place += length
        return found


def in_order(used: Mapping[str, Used], name: str, conditions: frozenset[str]) -> tuple[Used, ...]:
    """Effects in an order in which each finds the signals it asks for."""
    makers = {
        signal: effect
        for effect, item in used.items()
        for signal in item.known.outputs
        if signal not in CHANNELS and signal not in ACCELERATIONS and not signal.endswith("_rate")
    }
    states = {state for item in used.values() for state in item.known.states}
    waiting, done, order = dict(used), set(conditions | states), []
    for effect, item in used.items():
        own = {*item.own, *item.known.options}
        lost = [x for x in item.arguments if x not in own | conditions | states | set(makers)]
        if lost:
            givers = sorted(
                other.name
                for other in CATALOGUE.values()
                if any(signal in other.outputs for signal in lost)
            )
            raise MissingPartError(
                Problem(
                    message=f"{effect} of model {name!r} needs {', '.join(lost)}: it has no part "
                    f"{' or '.join(givers) or 'that gives it'}.",
                    remedy=Model.TAKE_PARTS,
                )
            )
    while waiting:
        ready = [
            effect
            for effect, item in waiting.items()
            if all(x in done or x in item.own or x in item.known.options for x in item.arguments)
        ]
        if not ready:
            raise ModelError(
                f"The effects {', '.join(waiting)} of model {name!r} ask for each other's signals."
            )
        chosen = waiting.pop(ready[0])
        order.append(chosen)
        done |= set(chosen.known.outputs)
    return tuple(order)
