"""Added resistance in regular waves, by several methods side by side.

All are mean forces of second order over the square of the amplitude of the wave [N/m²].
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType
from typing import TYPE_CHECKING, Final

import numpy as np

from pmmkit.numerics import Array
from pmmkit.presentation import Described, Grid, Group, Section, number
from pmmkit.seakeeping.figures import over_wave_length
from pmmkit.seakeeping.hull_forms.hull import Hull
from pmmkit.seakeeping.seas import Sea
from pmmkit.seakeeping.second_order.empirical_resistance import (
    ResistanceParticulars,
    snnm,
    stawave2,
)
from pmmkit.seakeeping.second_order.mean_drift import drift, mean_force, radiated_force
from pmmkit.seakeeping.transfer import Rao, between, nearest

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.figure import Figure

_PANELS: Final = 4
LEAVES_OUT: Final[Mapping[str, str]] = MappingProxyType(
    {
        "Gerritsma-Beukelman": "Gerritsma and Beukelman (1972): the energy of the waves that "
        "heave and pitch send out. Nothing of the waves that the bow reflects, so too small in "
        "short waves at speed, and too large there without; nothing of sway and roll in oblique "
        "seas; in following seas it is not to be relied on.",
        "with reflection": "The same in long waves, Faltinsen's (1980) reflection at the waterline "
        "in short ones, blended by the energy that a plate of the draught reflects. The blend is "
        "our own; the waterline is that at rest, without the wave that the bow makes.",
        "STAWAVE-2": "A formula fitted to tank tests, for waves within 45° of the bow, ships of "
        "75 to 350 m and Fn 0.1 to 0.3; no form of the hull but its block coefficient.",
        "SNNM": "Liu and Papanikolaou's (2020) formula, fitted to tank tests at all headings, as "
        "ITTC recommends; no form of the hull but its coefficients, entrance and run.",
    }
)
"""The methods, and what each leaves out."""


@dataclass(frozen=True, kw_only=True, repr=False, eq=False)
class AddedResistance(Described):
    """Added resistance in regular waves, by each method.

    Parameters
    ----------
    rao : Rao
        The motions, with speed, heading and frequency of each value.
    methods : mapping of str to array, shape (speeds, headings, frequencies)
        Resistance (against the course) over the square of the amplitude [N/m²]; NaN out of the
        range of a method.
    """

    rao: Rao
    methods: Mapping[str, Array]

    @property
    def unit(self) -> float:
        """ρ g B²/L [N/m²], by which added resistance is usually divided."""
        hull = self.rao.strips.hull
        return self.rao.rho * self.rao.g * float(hull.breadths.max()) ** 2 / hull.L

    def mean(
        self, sea: Sea, *, speed: float | None = None, heading_deg: float | None = None
    ) -> dict[str, float]:
        """Mean added resistance in a sea, 2∫S (R/ζ²) dω [N], by each method.

        Parameters
        ----------
        sea : Sea
            The sea; a short-crested one needs headings around that of its mean.
        speed, heading_deg : float, optional
            One of those that were computed [m/s, deg].
        """
        a = nearest(self.rao.speed, speed, "speed [m/s]")
        b = nearest(np.degrees(self.rao.heading), heading_deg, "heading_deg")
        found = dict.fromkeys(self.methods, 0.0)
        for heading, share in zip(
            *sea.directions(float(np.degrees(self.rao.heading[b]))), strict=True
        ):
            for c, part in zip(*between(self.rao.heading, float(heading)), strict=True):
                for name, values in self.methods.items():
                    found[name] += share * part * mean_force(values[a, c], self.rao.omega, sea)
        return {name: float(value) for name, value in found.items()}

    def to_pandas(self) -> pd.DataFrame:
        """One row for each speed, heading and frequency [SI; N/m² for the methods]."""
        import pandas as pd

        axes = (self.rao.speed, np.degrees(self.rao.heading), self.rao.omega)
        U, beta, w = np.meshgrid(*axes, indexing="ij")
        columns = {"speed": U, "heading_deg": beta, "omega": w, **self.methods}
        return pd.DataFrame({name: values.ravel() for name, values in columns.items()})

    def plot(self) -> Figure:
        """Each method over the length of the waves, a panel for each speed and heading."""
        names = self.rao.cases()[:_PANELS]
        panels = {
            f"R / ρgζ²B²/L\n{name}": {
                method: values.reshape(-1, self.rao.omega.size)[place] / self.unit
                for method, values in self.methods.items()
            }
            for place, name in enumerate(names)
        }
        return over_wave_length(2 * math.pi / self.rao.wavenumber / self.rao.L, panels)

    def _headline(self) -> str:
        return f"of {self.rao.name} by {len(self.methods)} methods"

    def _sections(self) -> Sequence[Section]:
        rows = []
        for i, speed in enumerate(self.rao.speed):
            for j, heading in enumerate(self.rao.heading):
                peaks = []
                for values in self.methods.values():
                    known = np.isfinite(values[i, j])
                    peak = float(np.max(values[i, j][known])) / self.unit if known.any() else None
                    peaks.append(None if peak is None else number(peak, 3))
                rows.append([f"{speed:.2f} m/s, {math.degrees(heading):.0f}°", *peaks])
        head = ["speed, heading", *self.methods]
        return [
            Section(
                title="Largest value over ρgζ²B²/L",
                tables=[Grid(head=head, groups=[Group(rows=rows[:30])])],
            ),
            Section(
                title="What each leaves out",
                points=[f"{name}: {LEAVES_OUT[name]}" for name in self.methods],
            ),
        ]


def added_resistance(rao: Rao) -> AddedResistance:
    """Added resistance of a ship in regular waves by every method there is.

    Parameters
    ----------
    rao : Rao
        Its motions.

    Returns
    -------
    AddedResistance

    Examples
    --------
    >>> from pmmkit.seakeeping.hull_forms.particulars import hull_from_particulars
    >>> from pmmkit.seakeeping.motions import rao
    >>> hull = hull_from_particulars(name="ship", L=100.0, B=18.0, d=6.0, block=0.7)
    >>> found = added_resistance(rao(hull, speeds=5.0, omega=[0.5, 0.7]))
    >>> sorted(found.methods)
    ['Gerritsma-Beukelman', 'SNNM', 'STAWAVE-2', 'with reflection']
    """
    along = np.cos(rao.heading)[:, None] * radiated_force(rao)
    form = form_of(rao.strips.hull, rao.loading.kyy)
    given: dict[str, Callable[..., Array]] = {"STAWAVE-2": stawave2, "SNNM": snnm}
    formulas = {
        name: method(form, rao.speed, rao.heading, rao.omega, rao.rho, rao.g)
        for name, method in given.items()
    }
    return AddedResistance(
        rao=rao,
        methods={"Gerritsma-Beukelman": -along, "with reflection": -drift(rao)[0], **formulas},
    )


def form_of(hull: Hull, kyy: float) -> ResistanceParticulars:
    """What formulas ask of a hull.

    kyy [m].
    """
    breadth = float(hull.breadths.max())
    full = hull.x[hull.breadths > 0.99 * breadth]
    return ResistanceParticulars(
        L=hull.L,
        B=breadth,
        d=hull.draught,
        block=hull.hydrostatics.volume / (hull.L * breadth * hull.draught),
        kyy=kyy / hull.L,
        entrance=max(0.5 * hull.L - float(full.max()), 0.05 * hull.L),
        run=max(0.5 * hull.L + float(full.min()), 0.05 * hull.L),
    )
