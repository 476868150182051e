"""Hull forces as polynomials in the motion: one definition for regression and simulation."""

from __future__ import annotations

from collections.abc import Sequence
from functools import reduce

import numpy as np

from pmmkit.conventions import CHANNELS, Convention, force_unit, parse_derivative, speed_unit
from pmmkit.effects.state import Array, State
from pmmkit.ship import Ship, Water


def regressors(
    names: Sequence[str],
    state: State,
    *,
    ship: Ship,
    water: Water,
    convention: Convention,
    approach_speed: float,
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
    approach_speed : float
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
            channel, convention.system, L=ship.L, d=ship.d, volume=ship.volume,
            rho=water.rho, g=water.g, U=1.0,
        )
        for channel in {name[0] for name in names}
    }  # fmt: skip
    speed = speed_unit(convention.system, L=ship.L, g=water.g, U=1.0)
    reference = U if convention.system != "bis" else np.full_like(U, speed)
    surge = state.u - approach_speed if convention.surge == "delta-u" else state.u
    sway = -1.0 if convention.sway == "beta" else 1.0
    rudder = 1.0 if convention.rudder_positive == "starboard" else -1.0
    along, over = ship.L / reference, ship.L / reference**2
    thrust_unit = force_unit(
        "X", convention.system, L=ship.L, d=ship.d, volume=ship.volume,
        rho=water.rho, g=water.g, U=1.0,
    )  # fmt: skip
    square = np.ones_like(U) if convention.system == "bis" else U**2
    primed = {
        "0": np.ones_like(U),
        "u": surge / reference,
        "v": sway * state.v / reference,
        "r": state.r * along,
        "p": state.p * along,
        "phi": state.phi,
        "d": rudder * state.delta,
        "T": state.thrust / (thrust_unit * square),
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
            factors = ("0",)
        product = reduce(np.multiply, (values[factor] for factor in factors))
        columns.append(pressure[name[0]] * square * product)
    return np.stack(columns, axis=1) if columns else np.empty((len(U), 0))


def in_channel(names: Sequence[str], channel: str) -> list[str]:
    """The names that contribute to one channel, in their order."""
    assert channel in CHANNELS
    return [name for name in names if name[0] == channel]
