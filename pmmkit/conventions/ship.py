"""Ship and water: the particulars that everything else refers to."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar, Final

import numpy as np

from pmmkit.numerics import Array

PROPORTIONS: Final = {"B/L": 0.03, "d/L": 0.03, "block coefficient": 0.05}
"""Shares by which two hulls of one form may differ."""


@dataclass(frozen=True, kw_only=True)
class Ship:
    """Particulars of a ship or a ship model, SI, origin midship, x forward, z down.

    Parameters
    ----------
    name : str
        Name for reports.
    L, B, d : float
        Length between perpendiculars, breadth, mean draught [m].
    volume : float
        Displaced volume [m³].
    mass : float
        Displacement mass [kg].
    xG : float
        Centre of gravity forward of midship [m].
    Izz : float
        Yaw moment of inertia about the vertical axis through midship [kg m²]
        (about the centre of gravity it is smaller by ``mass * xG**2``).
    zG, GM, Ixx : float, optional
        Centre of gravity below the origin [m], metacentric height [m], roll inertia [kg m²].
    balance_mass, balance_Izz, balance_xG : float, optional
        What oscillates below the balance where it differs from the ship:
        mass [kg], inertia about midship [kg m²], centre of gravity [m].
    block_stated : float, optional
        Block coefficient as the source states it, for cross-checks.
    """

    LONGEST_MODEL: ClassVar[float] = 20.0
    """Length below which she is a model [m]."""

    name: str
    L: float
    B: float
    d: float
    volume: float
    mass: float
    Izz: float
    xG: float = 0.0
    zG: float | None = None
    GM: float | None = None
    Ixx: float | None = None
    balance_mass: float | None = None
    balance_Izz: float | None = None
    balance_xG: float | None = None
    block_stated: float | None = None

    @property
    def block(self) -> float:
        """Block coefficient volume/(L B d) [-]."""
        return self.volume / (self.L * self.B * self.d)

    def form_apart(self, other: Ship) -> dict[str, tuple[float, float]]:
        """What of `PROPORTIONS` is another than another ship's: both, and that other one's.

        Examples
        --------
        >>> ship = Ship(name="m", L=4.0, B=1.0, d=0.25, volume=0.5, mass=500.0, Izz=500.0)
        >>> longer = Ship(name="s", L=80.0, B=19.0, d=5.0, volume=3.8e3, mass=3.8e6, Izz=1e9)
        >>> ship.form_apart(longer)
        {'B/L': (0.25, 0.2375)}
        """
        both = {
            "B/L": (self.B / self.L, other.B / other.L),
            "d/L": (self.d / self.L, other.d / other.L),
            "block coefficient": (self.block, other.block),
        }
        return {
            name: (own, there)
            for name, (own, there) in both.items()
            if abs(own / there - 1.0) > PROPORTIONS[name]
        }

    @property
    def words(self) -> str:
        """The particulars in a line.

        Examples
        --------
        >>> ship = Ship(name="m", L=4.0, B=1.0, d=0.25, volume=0.5, mass=500.0, Izz=500.0)
        >>> ship.words
        'm: L 4 m, B 1 m, d 0.25 m, 500 kg, block coefficient 0.500'
        """
        return (
            f"{self.name}: L {self.L:.4g} m, B {self.B:.4g} m, d {self.d:.4g} m, "
            f"{self.mass:.4g} kg, block coefficient {self.block:.3f}"
        )

    def rigid_body_forces(self, motion: Mapping[str, Array]) -> dict[str, Array]:
        """Forces that give the ship its accelerations: what water and wind must exert.

        Notes
        -----
        X = m(u̇ - vr - xG r²), Y = m(v̇ + ur + xG ṙ - zG ṗ), N = Izz ṙ + m xG (v̇ + ur),
        K = Ixx ṗ - m zG (v̇ + ur) about midship, in SI; products of the roll rate are left out. A
        motion holds u, v, r, udot, vdot, rdot and pdot; what it lacks is zero.
        """
        zero = np.zeros(max((len(values) for values in motion.values()), default=1))
        u, v, r, udot, vdot, rdot, pdot = (
            np.asarray(motion.get(name, zero), float)
            for name in ("u", "v", "r", "udot", "vdot", "rdot", "pdot")
        )
        m, zG = self.mass, self.zG or 0.0
        across = vdot + u * r
        return {
            "X": m * (udot - v * r - self.xG * r**2),
            "Y": m * (across + self.xG * rdot - zG * pdot),
            "N": self.Izz * rdot + m * self.xG * across,
            "K": (self.Ixx or 0.0) * pdot - m * zG * across,
        }

    def froude(self, speed: float, g: float = 9.81) -> float:
        """Froude number of a speed [m/s] on the length L.

        Examples
        --------
        >>> ship = Ship(name="m", L=4.861111, B=.7, d=.24, volume=.455, mass=454., Izz=618.)
        >>> round(ship.froude(1.5), 4)
        0.2172
        """
        return speed / math.sqrt(g * self.L)

    def speed(self, froude: float, g: float = 9.81) -> float:
        """Speed [m/s] of a Froude number on the length L."""
        return froude * math.sqrt(g * self.L)


@dataclass(frozen=True, kw_only=True)
class Water:
    """Water and tank, SI.

    Parameters
    ----------
    rho, g : float
        Density [kg/m³], gravity [m/s²].
    nu : float, optional
        Kinematic viscosity [m²/s].
    depth : float, optional
        Water depth [m]; deep where absent.
    tank_width, tank_depth : float, optional
        Cross-section of the tank [m].
    """

    rho: float = 1025.0
    g: float = 9.81
    nu: float | None = None
    depth: float | None = None
    tank_width: float | None = None
    tank_depth: float | None = None

    @property
    def viscosity(self) -> float:
        """Kinematic viscosity [m²/s]: the stated one, else that of ITTC at 15 °C, fresh or salt."""
        return self.nu or (1.1883e-6 if self.rho > 1010.0 else 1.1386e-6)
