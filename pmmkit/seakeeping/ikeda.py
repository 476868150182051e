"""Roll damping beside that of waves, by Ikeda's method in its simple form."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final, Self

import numpy as np

from pmmkit.base import DataError, Problem
from pmmkit.presentation import Described, Grid, Group, Section
from pmmkit.seakeeping.hull_forms.hull import Hull
from pmmkit.seakeeping.loading import Loading
from pmmkit.seakeeping.strips import coefficients, strips_of

_RANGES: Final = {
    "CB": (0.5, 0.85),
    "B/d": (2.5, 4.5),
    "OG/d": (-1.5, 0.2),
    "CM": (0.9, 0.99),
    "bilge keel breadth/B": (0.01, 0.06),
    "bilge keel length/L": (0.05, 0.4),
}
_NU: Final = 1.19e-6
_KEELS: Final = ("bilge keel breadth/B", "bilge keel length/L")


@dataclass(frozen=True, kw_only=True, repr=False)
class RollDamping(Described):
    """Roll damping at one speed and amplitude, over critical.

    Parameters
    ----------
    omega : float
        Natural frequency of roll [rad/s].
    amplitude_deg : float
        Of the roll [deg].
    speed : float
        [m/s].
    friction, eddies, keels, lift : float
        Shares, each over critical damping [-]; those of waves are in the theory of motions.
    roll_damping, roll_quadratic : float
        What a `Loading` takes: linear part [-], and what grows with the rate of roll [s/rad].
    """

    omega: float
    amplitude_deg: float
    speed: float
    friction: float
    eddies: float
    keels: float
    lift: float
    roll_damping: float
    roll_quadratic: float

    def _headline(self) -> str:
        total = self.friction + self.eddies + self.keels + self.lift
        return (
            f"{total:.3f} of critical at {self.amplitude_deg:g}°, {self.speed:.2f} m/s, "
            f"natural period {2 * math.pi / self.omega:.1f} s"
        )

    def _sections(self) -> Sequence[Section]:
        rows = [
            [name, f"{getattr(self, name):.4f}"] for name in ("friction", "eddies", "keels", "lift")
        ]
        return [
            Section(
                tables=[Grid(head=["", "over critical"], groups=[Group(rows=rows)])],
                points=[
                    f"roll_damping={self.roll_damping:.4f}, "
                    f"roll_quadratic={self.roll_quadratic:.4f} s/rad"
                ],
            )
        ]

    @classmethod
    def of(
        cls,
        hull: Hull,
        loading: Loading,
        *,
        speed: float = 0.0,
        amplitude_deg: float = 10.0,
        keel_breadth: float = 0.0,
        keel_length: float = 0.0,
        g: float = 9.81,
    ) -> Self:
        """Roll damping of friction, eddies, bilge keels and lift.

        Regression of Kawahara, Maekawa and Ikeda (2011) for conventional cargo ships; lift as Ikeda
        has it there. What grows with the amplitude is told apart by half of it.

        Parameters
        ----------
        hull : Hull
            The hull.
        loading : Loading
            Its mass.
        speed : float
            [m/s].
        amplitude_deg : float
            Of the roll, up to 20 or so [deg].
        keel_breadth, keel_length : float
            Of a bilge keel [m]; 0 for none.
        g : float
            Gravity [m/s²].

        Returns
        -------
        RollDamping

        Raises
        ------
        DataError
            If the ship lies outside of what the regression was made from.
        """
        B, d, L = float(hull.breadths.max()), hull.draught, hull.L
        still = hull.hydrostatics
        CB, CM = still.volume / (L * B * d), float(hull.areas.max()) / (B * d)
        OG = (d - loading.KG) / d
        shown = {"CB": CB, "B/d": B / d, "OG/d": OG, "CM": CM}
        if keel_breadth > 0.0 or keel_length > 0.0:
            shown |= dict(zip(_KEELS, (keel_breadth / B, keel_length / L), strict=True))
        wrong = [
            f"{name} = {value:.3f}, not {low:g} to {high:g}"
            for name, value in shown.items()
            for low, high in [_RANGES[name]]
            if not low <= value <= high
        ]
        if wrong:
            raise DataError(
                Problem(
                    message=f"Ikeda's formulas do not hold for this ship: {'; '.join(wrong)}.",
                    remedy="Give the loading a roll_damping of your own, such as 0.05 of critical.",
                )
            )
        omega = _natural(hull, loading, g)
        bare = omega * math.sqrt(B / (2 * g))
        # B over ρ∇B² √(2g/B), and critical damping is 2C/ω
        stiffness = g * (still.KM - loading.KG)
        unit = B**2 * math.sqrt(2 * g / B) * omega / (2 * stiffness)

        def keels(amplitude: float) -> float:
            if keel_breadth == 0.0:
                return 0.0
            return (
                unit
                * _keels(CB, CM, B / d, OG, keel_breadth / B, keel_length / L, amplitude)
                * bare
            )

        turn = math.radians(amplitude_deg)
        eddies = (
            unit * 4 * bare * turn / (3 * math.pi * CB * (B / d) ** 3) * _eddy(CB, CM, B / d, OG)
        )
        full, half = keels(amplitude_deg), keels(0.5 * amplitude_deg)
        slope = 2 * (full - half) + eddies  # what would be gone at no amplitude
        friction = unit * _friction(CB, B, d, L, OG, turn, omega, speed, g)
        lift = unit * _lift(CM, B, d, L, OG, speed) / (still.volume * B**2) * math.sqrt(B / (2 * g))
        return cls(
            omega=omega,
            amplitude_deg=amplitude_deg,
            speed=speed,
            friction=friction,
            eddies=eddies,
            keels=full,
            lift=lift,
            roll_damping=max(friction + lift + eddies + full - slope, 0.0),
            roll_quadratic=max(slope, 0.0) * 3 * math.pi / (8 * omega * turn),
        )


def _natural(hull: Hull, loading: Loading, g: float) -> float:
    """Frequency at which inertia with added inertia balances the stiffness [rad/s]."""
    still = hull.hydrostatics
    stiffness = g * still.volume * (still.KM - loading.KG)
    own = still.volume * (loading.kxx**2 + (loading.KG - hull.draught) ** 2)
    omega = math.sqrt(stiffness / own)
    strips = strips_of(hull, 2 * omega, g=g)
    for _ in range(6):
        added = coefficients(strips, np.zeros(1), np.array([omega]))[3, 3, 0].real
        omega = math.sqrt(stiffness / (own + added))
    return omega


def _eddy(CB: float, CM: float, ratio: float, OG: float) -> float:
    rise = (-0.0182 * CB + 0.0155) * (ratio - 1.8) ** 3
    shape = -79.414 * CB**4 + 215.695 * CB**3 - 215.883 * CB**2 + 93.894 * CB - 14.848
    one = (3.98 * CB - 5.1525) * (-0.2 * ratio + 1.6) * OG
    one *= (0.9717 * CB**2 - 1.55 * CB + 0.723) * OG + 0.04567 * CB + 0.9408
    two = (0.25 * OG + 0.95) * OG - 219.2 * CB**3 + 443.7 * CB**2 - 283.3 * CB + 59.6
    three = -15 * CB * ratio + 46.5 * CB + 11.2 * ratio - 28.6
    return (rise + shape) * math.exp(one + two * CM**three)


def _keels(
    CB: float, CM: float, ratio: float, OG: float, breadth: float, length: float, phi: float
) -> float:
    one = (-0.3651 * CB + 0.3907) * (ratio - 2.83) ** 2 - 2.21 * CB + 2.632
    two = 0.00255 * phi**2 + 0.122 * phi + 0.4794
    three = (-0.8913 * breadth**2 - 0.0733 * breadth) * length**2
    three += (5.2857 * breadth**2 - 0.01185 * breadth + 0.00189) * length
    raised = 5.0 * breadth + 0.3 * ratio - 0.2 * length + 0.00125 * phi**2 - 0.0425 * phi - 1.86
    full = -15.0 * breadth + 1.2 * CB - 0.1 * ratio - 0.0657 * OG**2 + 0.0586 * OG + 1.6164
    return one * two * three * math.exp(raised * OG + full * CM ** (2.5 * OG + 15.75))


def _friction(
    CB: float, B: float, d: float, L: float, OG: float, phi: float, omega: float, U: float, g: float
) -> float:
    radius = d * ((0.887 + 0.145 * CB) * (1.7 + CB * B / d) - 2.0 * OG) / math.pi
    surface = L * (1.75 * d + CB * B)
    reynolds = 3.22 * radius**2 * phi**2 * omega / (2 * math.pi * _NU)
    drag = 1.328 * reynolds**-0.5 + 0.014 * reynolds**-0.114
    still = 4 / (3 * math.pi) * surface * radius**3 * phi * omega * drag
    return float(still * (1 + 4.1 * U / (omega * L)) / (L * B**3 * d * CB) * math.sqrt(B / (2 * g)))


def _lift(CM: float, B: float, d: float, L: float, OG: float, U: float) -> float:
    """Over ρ [m⁵/s]."""
    kappa = 0.0 if CM <= 0.92 else 0.1 if CM <= 0.97 else 0.3
    slope = 2 * math.pi * d / L + kappa * (4.1 * B / L - 0.045)
    arm, centre, depth = 0.3 * d, 0.5 * d, OG * d
    shape = 1 - 1.4 * depth / centre + 0.7 * depth**2 / (arm * centre)
    return 0.5 * U * L * d * slope * arm * centre * shape
