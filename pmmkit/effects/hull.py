"""Hull forces as polynomials in the motion: one definition for regression and simulation."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import reduce
from typing import Any, Final

import numpy as np

from pmmkit.conventions import CHANNELS, Convention, force_unit, parse_derivative, speed_unit
from pmmkit.effects.effect import Effect, Parameter
from pmmkit.effects.state import State
from pmmkit.numerics import Array
from pmmkit.ship import Ship, Water

HULL: Final = "hull_polynomial"
RUDDER_POLYNOMIAL: Final = "rudder_abkowitz"
HULL_POLYNOMIAL: Final = Effect(
    name=HULL,
    family="hull",
    kind="force",
    roles=("hull",),
    summary="Hull forces as a polynomial in the motion, term by term as the literature names them.",
    derivatives=True,
    sources=("abkowitz_1964",),
)
RUDDER_ABKOWITZ: Final = Effect(
    name=RUDDER_POLYNOMIAL,
    family="hull",
    kind="force",
    roles=("steering",),
    summary="Rudder forces as a polynomial in the rudder angle and the motion.",
    parameters=(
        Parameter(
            name="rate_deg_s",
            text="rate of the steering gear (by default the least that SOLAS allows)",
            unit="deg/s",
            default=2.32,
            low=1e-6,
        ),
        Parameter(name="max_deg", text="largest rudder angle", unit="deg", default=90.0, low=0.0),
    ),
    derivatives=True,
    needs=("delta",),
    sources=("abkowitz_1964",),
)
EFFECTS: Final = (HULL_POLYNOMIAL, RUDDER_ABKOWITZ)

FACTOR_PLACES: Final = ("0", "u", "v", "r", "p", "phi", "d", "|u|", "|v|", "|r|", "|p|", "|d|")
"""Factors in the order by which a `Monomial` counts them."""

Monomial = tuple[tuple[int, ...], Mapping[str, Any]]
"""Places of the factors, and by channel the coefficients of X, Y [N] and N, K [N m] at 1 m/s."""


def regressors(
    names: Sequence[str],
    state: State,
    *,
    ship: Ship,
    water: Water,
    convention: Convention,
    approach_speed: float | Array,
) -> Array:
    """What each derivative multiplies, in newtons (newton metres) per unit of the derivative.

    The force of a hull polynomial is ``regressors(names, state, ...) @ values``.

    Parameters
    ----------
    names : sequence of str
        Derivatives, all of one channel or of several.
    state : State
        Motion at n instants, referred to the convention's motion reference point.
    ship, water : Ship, Water
        Lengths, volume, density and gravity of the non-dimensional system.
    convention : Convention
        System, speed and meaning of the factors.
    approach_speed : float or array (n,)
        Carriage speed Uc, or the speed of the approach [m/s].

    Returns
    -------
    array (n, len(names))
        In instantaneous-U prime units, column Yvvr holds ½ρL²U² v'²r'.

    Examples
    --------
    >>> ship = Ship(name="box", L=4.0, B=1.0, d=.25, volume=.5, mass=500., Izz=500.)
    >>> water = Water(rho=1000.0)
    >>> state = State.of(u=0.0, v=2.0)
    >>> regressors(["Yv", "Yvvv"], state, ship=ship, water=water,
    ...            convention=Convention(), approach_speed=2.0)
    array([[32000., 32000.]])
    """
    U = state.speed if convention.U == "instantaneous" else np.full_like(state.u, approach_speed)
    pressure = {
        channel: force_unit(
            channel,
            convention.system,
            L=ship.L,
            d=ship.d,
            volume=ship.volume,
            rho=water.rho,
            g=water.g,
            U=1.0,
        )
        for channel in {"X", *(name[0] for name in names)}
    }
    speed = speed_unit(convention.system, L=ship.L, g=water.g, U=1.0)
    reference = U if convention.system != "bis" else np.full_like(U, speed)
    surge = state.u - approach_speed if convention.surge == "delta-u" else state.u
    sway = -1.0 if convention.sway == "beta" else 1.0
    rudder = 1.0 if convention.rudder_positive == "starboard" else -1.0
    along, over = ship.L / reference, ship.L / reference**2
    square = np.ones_like(U) if convention.system == "bis" else U**2
    primed = {
        "0": np.ones_like(U),
        "u": surge / reference,
        "v": sway * state.v / reference,
        "r": state.r * along,
        "p": state.p * along,
        "phi": state.phi,
        "d": rudder * state.delta,
        "T": state.thrust / (pressure["X"] * square),
        "udot": state.udot * over,
        "vdot": sway * state.vdot * over,
        "rdot": state.rdot * over * ship.L,
        "pdot": state.pdot * over * ship.L,
    }
    values = {f"|{name}|": np.abs(primed[name]) for name in ("u", "v", "r", "p", "d")} | primed
    columns = []
    for name in names:
        factors = parse_derivative(name).factors
        if convention.surge == "constant" and factors == ("u", "u"):
            bis = convention.system == "bis"
            product = (state.speed / reference) ** 2 if bis else values["0"]
        else:
            product = reduce(np.multiply, (values[factor] for factor in factors))
        columns.append(pressure[name[0]] * square * product)
    return np.stack(columns, axis=1) if columns else np.empty((len(U), 0))


def in_channel(names: Sequence[str], channel: str) -> list[str]:
    """The names that contribute to one channel, in their order."""
    assert channel in CHANNELS
    return [name for name in names if name[0] == channel]


def polynomial(
    values: Mapping[str, Any], *, ship: Ship, water: Water, convention: Convention
) -> tuple[Monomial, ...]:
    """A hull polynomial as monomials with dimensional coefficients.

    Parameters
    ----------
    values : mapping
        Derivatives by canonical name, none of an acceleration or of the thrust; arrays where
        ships differ.
    ship, water, convention
        The non-dimensional system.

    Returns
    -------
    tuple of Monomial
        One entry per product of factors, in a fixed order whatever the order of the values.
    """
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
        unit = force_unit(
            derivative.channel,
            convention.system,
            L=ship.L,
            d=ship.d,
            volume=ship.volume,
            rho=water.rho,
            g=water.g,
            U=1.0,
        )
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
