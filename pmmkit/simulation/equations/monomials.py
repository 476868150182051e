"""A hull polynomial as monomials with dimensional coefficients."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Final

from pmmkit.conventions import CHANNELS, Convention, Ship, Water, parse_derivative

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
