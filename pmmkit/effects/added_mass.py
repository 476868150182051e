"""Added mass: linear acceleration derivatives, and where their Coriolis terms are."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Final, NamedTuple

from pmmkit.conventions import Convention, Ship, Water, parse_derivative
from pmmkit.effects.definition import Effect, Parameter

INERTIA: Final = "added_mass"
ADDED_MASS: Final = Effect(
    name=INERTIA,
    family="added_mass",
    kind="mass",
    roles=("inertia",),
    summary="Forces of the water in proportion to the ship's accelerations.",
    parameters=(
        Parameter(
            name="lx",
            text="lever of the longitudinal added mass below the origin over L, for the roll "
            "moment of the turn (separate Coriolis terms only)",
            default=0.0,
        ),
    ),
    derivatives=True,
    sources=("son_nomoto_1981", "yasukawa_yoshimura_2015"),
)
EFFECTS: Final = (ADDED_MASS,)


class AddedMass(NamedTuple):
    """Force per acceleration, SI: [N/(m/s²)] and so on.

    Parameters
    ----------
    Xudot, Yvdot, Yrdot, Ypdot, Nvdot, Nrdot, Npdot, Kvdot, Krdot, Kpdot : float
        Force or moment per unit of an acceleration.
    coriolis_x, coriolis_y, coriolis_k : float
        Masses of the Coriolis terms, zero when these are inside the hull derivatives.
    """

    Xudot: float = 0.0
    Yvdot: float = 0.0
    Yrdot: float = 0.0
    Ypdot: float = 0.0
    Nvdot: float = 0.0
    Nrdot: float = 0.0
    Npdot: float = 0.0
    Kvdot: float = 0.0
    Krdot: float = 0.0
    Kpdot: float = 0.0
    coriolis_x: float = 0.0
    coriolis_y: float = 0.0
    coriolis_k: float = 0.0

    @staticmethod
    def unit(name: str, *, ship: Ship, water: Water, convention: Convention) -> float:
        """Force [N, N m] per unit of an acceleration derivative and SI acceleration.

        It does not depend on the speed: the squares of the speed cancel.

        Examples
        --------
        >>> ship = Ship(name="m", L=4.0, B=1.0, d=.25, volume=.5, mass=500., Izz=500.)
        >>> AddedMass.unit("Yvdot", ship=ship, water=Water(rho=1000.0), convention=Convention())
        32000.0
        """
        derivative = parse_derivative(name)
        force = convention.force_unit(derivative.channel, ship=ship, water=water, U=1.0)
        speed = convention.speed_unit(ship=ship, water=water, U=1.0)
        sign = -1.0 if convention.sway == "beta" and "vdot" in derivative.factors else 1.0
        return sign * force * ship.L**derivative.length_power / speed**2

    @classmethod
    def of(
        cls, values: Mapping[str, float], *, ship: Ship, water: Water, convention: Convention
    ) -> AddedMass:
        """The added mass of a ship in SI units.

        Parameters
        ----------
        values : mapping
            Acceleration derivatives by canonical name, and ``lx``; absent ones are zero.
        ship, water, convention
            The non-dimensional system. With ``coriolis = "separate"`` the terms my v r in X,
            -mx u r in Y and mx lx u r in K stand in the equations, otherwise in the hull
            derivatives.

        Returns
        -------
        AddedMass
        """
        given = {
            name: values[name] * cls.unit(name, ship=ship, water=water, convention=convention)
            for name in cls.places()
            if name in values
        }
        if convention.coriolis == "in-derivatives":
            return cls(**given)
        along, across = -given.get("Xudot", 0.0), -given.get("Yvdot", 0.0)
        lever = values.get("lx", 0.0) * ship.L
        return cls(**given, coriolis_x=across, coriolis_y=-along, coriolis_k=along * lever)

    @classmethod
    def places(cls) -> tuple[str, ...]:
        """The acceleration derivatives that the equations of motion have a place for."""
        return tuple(name for name in cls._fields if name.endswith("dot"))
