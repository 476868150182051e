"""Hull forces as polynomials in the motion: one definition for regression and simulation."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from pmmkit.conventions import Convention, Ship, Water, parse_derivative
from pmmkit.effects.definition import Effect, Parameter
from pmmkit.effects.state import State
from pmmkit.numerics import Array

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
    in_words="Rudder (Abkowitz)",
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


@dataclass(frozen=True, kw_only=True, eq=False)
class Regressors:
    """What derivatives multiply; those that differ by their unit alone share one product.

    Parameters
    ----------
    products : array (k, n)
        The products at n instants, for a unit of 1 N or 1 N m at 1 m/s.
    place : tuple of int (p,)
        Product of each derivative.
    unit : array (p,)
        By which it is multiplied.
    """

    products: Array
    place: tuple[int, ...]
    unit: Array

    @property
    def columns(self) -> Array:
        """What each derivative multiplies at the instants, array (n, p)."""
        return self.of(self.products.T)

    def of(self, products: Array) -> Array:
        """Columns (m, p) of the derivatives from columns (m, k) of the products."""
        found: Array = products[:, list(self.place)] * self.unit
        return found

    @classmethod
    def at(
        cls,
        names: Sequence[str],
        state: State,
        *,
        ship: Ship,
        water: Water,
        convention: Convention,
        approach_speed: float | Array,
    ) -> Regressors:
        """What each derivative multiplies, in newtons (newton metres) per unit of the derivative.

        The force of a hull polynomial is ``Regressors.at(names, state, ...).columns @ values``.
        Each product is computed once whatever channels have it.

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
        Regressors
            In instantaneous-U prime units, column Yvvr holds ½ρL²U² v'²r'.

        Examples
        --------
        >>> ship = Ship(name="box", L=4.0, B=1.0, d=.25, volume=.5, mass=500., Izz=500.)
        >>> water = Water(rho=1000.0)
        >>> state = State.of(u=0.0, v=2.0)
        >>> Regressors.at(["Yv", "Yvvv"], state, ship=ship, water=water,
        ...               convention=Convention(), approach_speed=2.0).columns
        array([[32000., 32000.]])
        """
        U = (
            state.speed
            if convention.U == "instantaneous"
            else np.full_like(state.u, approach_speed)
        )
        pressure = {
            channel: convention.force_unit(channel, ship=ship, water=water, U=1.0)
            for channel in {"X", *(name[0] for name in names)}
        }
        bis = convention.system == "bis"
        speed = convention.speed_unit(ship=ship, water=water, U=1.0)
        reference = np.full_like(U, speed) if bis else U
        square = np.ones_like(U) if bis else U**2
        surge = state.u - approach_speed if convention.surge == "delta-u" else state.u
        sway = -1.0 if convention.sway == "beta" else 1.0
        rudder = 1.0 if convention.rudder_positive == "starboard" else -1.0
        along, over = ship.L / reference, ship.L / reference**2
        primed: dict[str, Callable[[], Array]] = {
            "u": lambda: surge / reference,
            "v": lambda: sway * state.v / reference,
            "r": lambda: state.r * along,
            "p": lambda: state.p * along,
            "phi": lambda: state.phi,
            "d": lambda: rudder * state.delta,
            "T": lambda: state.thrust / (pressure["X"] * square),
            "udot": lambda: state.udot * over,
            "vdot": lambda: sway * state.vdot * over,
            "rdot": lambda: state.rdot * over * ship.L,
            "pdot": lambda: state.pdot * over * ship.L,
        }
        own = [parse_derivative(name).factors for name in names]
        place = {factors: number for number, factors in enumerate(dict.fromkeys(own))}
        needed = {factor for factors in place for factor in factors if factor != "0"}
        values = {name: primed[name]() for name in {factor.strip("|") for factor in needed}}
        values |= {
            factor: np.abs(values[factor.strip("|")])
            for factor in needed
            if factor.strip("|") != factor
        }
        products = np.empty((len(place), len(U)))
        rows = dict(zip(place, products, strict=True))
        done: dict[tuple[str, ...], Array] = {(): square}
        for factors in sorted(rows, key=len):
            row = rows[factors]
            if convention.surge == "constant" and factors == ("u", "u"):
                np.multiply(square, (state.speed / reference) ** 2 if bis else 1.0, out=row)
                continue
            known = next(n for n in range(len(factors) - 1, -1, -1) if factors[:n] in done)
            part = done[factors[:known]]
            for factor in factors[known:]:
                part = np.multiply(part, values.get(factor, 1.0), out=row)
            done[factors] = row
        return cls(
            products=products,
            place=tuple(place[factors] for factors in own),
            unit=np.array([pressure[name[0]] for name in names]),
        )
