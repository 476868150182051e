"""How the mass of a ship is spread, and what damps its roll."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Final, Self

from pmmkit.base import DataError
from pmmkit.seakeeping.hull_forms.hull import Hull


@dataclass(frozen=True, kw_only=True)
class Loading:
    """The mass of a ship that floats on even keel: its centre stands above that of buoyancy.

    Parameters
    ----------
    KG : float
        Centre of gravity above the base line [m].
    kxx, kyy, kzz : float
        Radii of gyration about axes through the centre of gravity [m].
    roll_damping : float
        Of viscosity, lift and bilge keels, over the critical damping of roll [-]; it is added to
        that of waves.
    roll_quadratic : float
        What grows with the rate of roll, over critical damping, per rate [s/rad]; it needs the
        height of the waves (`rao`).
    notes : tuple of str
        What was assumed.
    """

    KG: float
    kxx: float
    kyy: float
    kzz: float
    roll_damping: float = 0.05
    roll_quadratic: float = 0.0
    notes: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        wrong = [
            f"{name} = {value:g} must be a positive finite number."
            for name, value in (("kxx", self.kxx), ("kyy", self.kyy), ("kzz", self.kzz))
            if not (math.isfinite(value) and value > 0.0)
        ]
        if not (math.isfinite(self.roll_damping) and 0.0 <= self.roll_damping < 1.0):
            wrong.append(f"roll_damping = {self.roll_damping:g} must lie between 0 and 1.")
        if not (math.isfinite(self.roll_quadratic) and self.roll_quadratic >= 0.0):
            wrong.append(f"roll_quadratic = {self.roll_quadratic:g} must not be below zero.")
        if wrong:
            raise DataError(wrong, title="Loading")

    @classmethod
    def of(
        cls,
        hull: Hull,
        *,
        GM: float | None = None,
        KG: float | None = None,
        kxx: float | None = None,
        kyy: float | None = None,
        kzz: float | None = None,
        roll_damping: float | None = None,
        roll_quadratic: float = 0.0,
        mass: float | None = None,
        xG: float | None = None,
        rho: float = 1025.0,
    ) -> Self:
        """A loading from what is known; the rest is assumed and said.

        Parameters
        ----------
        hull : Hull
            What floats.
        GM, KG : float, optional
            Metacentric height, or the centre of gravity above the base line [m]; where both are
            absent, 5 % of the breadth is taken for GM.
        kxx, kyy, kzz : float, optional
            Radii of gyration [m]; 0.37 of the breadth, 0.25 of the length and that of pitch else.
        roll_damping : float, optional
            Over critical [-]; 0.05 where absent.
        roll_quadratic : float
            What grows with the rate of roll [s/rad].
        mass, xG : float, optional
            Displacement [kg] and its centre forward of midship [m] as they are known, against
            which the sections are held.
        rho : float
            Density of the water in which that floats [kg/m³].

        Returns
        -------
        Loading

        Raises
        ------
        DataError
            If what is stated contradicts the sections.
        """
        if wrong := _against(hull, mass, xG, rho):
            raise DataError(wrong, title="Hull and loading")
        breadth = float(hull.breadths.max())
        KM = hull.hydrostatics.KM
        notes = []
        if GM is not None and KG is not None and abs(KM - KG - GM) > 0.01 * breadth:
            raise DataError(
                f"GM = {GM:g} m and KG = {KG:g} m contradict the metacentre of the sections, "
                f"{KM:.3f} m above the base line: give one of them."
            )
        if GM is None and KG is None:
            notes.append("GM is assumed, 5 % of the breadth.")
        height = 0.05 * breadth if GM is None else GM
        if kxx is None:
            notes.append("The radius of gyration in roll is assumed, 0.37 of the breadth.")
        if kyy is None:
            notes.append("The radius of gyration in pitch is assumed, 0.25 of the length.")
        if roll_damping is None:
            notes.append("The roll damping beside that of waves is assumed, 5 % of critical.")
        pitch = 0.25 * hull.L if kyy is None else kyy
        return cls(
            KG=KM - height if KG is None else KG,
            kxx=0.37 * breadth if kxx is None else kxx,
            kyy=pitch,
            kzz=pitch if kzz is None else kzz,
            roll_damping=0.05 if roll_damping is None else roll_damping,
            roll_quadratic=roll_quadratic,
            notes=tuple(notes),
        )


_HEAVIER: Final = 0.03
"""Share by which a stated displacement may differ from that of the sections."""
_APART: Final = 0.01
"""Part of the length by which a stated centre may lie from that of buoyancy on even keel."""


def _against(hull: Hull, mass: float | None, xG: float | None, rho: float) -> list[str]:
    """What contradicts the sections, with what it may be."""
    found, still = [], hull.hydrostatics
    if mass is not None:
        share = mass / (rho * still.volume)
        if abs(share - 1) > _HEAVIER:
            why = (
                " Are these whole breadths in place of half ones?"
                if abs(share - 0.5) < 0.03
                else ""
            )
            found.append(
                f"The sections displace {rho * still.volume / 1e3:.5g} t, "
                f"not {mass / 1e3:.5g} t as stated.{why}"
            )
    if xG is not None and abs(xG - still.xB) > _APART * hull.L:
        why = " Does x count positive aft?" if abs(xG + still.xB) < _APART * hull.L else ""
        found.append(
            f"The centre of buoyancy of the sections lies {still.xB:.2f} m forward of midship, not "
            f"{xG:.2f} m as stated.{why}"
        )
    return found
