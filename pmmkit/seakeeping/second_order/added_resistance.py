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
from pmmkit.seakeeping.second_order.mean_drift import drift, mean_force, radiated_force, significant
from pmmkit.seakeeping.transfer import Rao, between, nearest

if TYPE_CHECKING:
    import pandas as pd

    from pmmkit.plotting import Figure


# Added resistance by formulas: STAWAVE-2 and SNNM.


@dataclass(frozen=True, kw_only=True)
class ResistanceParticulars:
    """Particulars of a ship that formulas ask.

    `L, B, d`: length between perpendiculars, breadth, draught [m]. `kyy`: radius of gyration in
    pitch over the length [-]. `entrance, run`: lengths of entrance and run of the waterline
    [m]. `trim`: draught aft less that forward [m].
    """

    L: float
    B: float
    d: float
    block: float
    kyy: float
    entrance: float
    run: float
    trim: float = 0.0


def _peak(ratio: Array, rising: float, falling: float, low: Array, high: Array) -> Array:
    """ω̄ᵇ exp(b/d (1 - ω̄ᵈ)), with one pair of exponents below the peak and one above."""
    b = np.where(ratio < 1, rising, falling)
    d = np.where(ratio < 1, low, high)
    return np.asarray(ratio**b * np.exp(b / d * (1 - ratio**d)))


def stawave2(
    form: ResistanceParticulars, speed: Array, heading: Array, omega: Array, rho: float, g: float
) -> Array:
    """STAWAVE-2 (ITTC 2014) over the square of the amplitude [N/m²], NaN out of its range.

    rho, g [kg/m³].
    """
    from scipy.special import i1, k1

    froude = (speed / math.sqrt(g * form.L))[:, None]
    held = np.maximum(froude, 0.05)
    ratio = math.sqrt(form.L / g) * form.kyy ** (1 / 3) / (1.17 * held**-0.143) * omega
    slender = -566 * (form.L / form.B) ** -2.66
    shape = _peak(ratio, 11.0, -8.5, np.array(14.0), np.array(slender))
    strength = 60.3 * form.block**1.34 * held**1.5 * np.exp(-3.5 * held)
    moving = 4 * rho * g * form.B**2 / form.L * strength * shape
    depth = np.minimum(1.5 * omega**2 / g * form.d, 300.0)
    bow = 0.692 * (froude * math.sqrt(form.L / form.d)) ** 0.769 + 1.81 * form.block**6.95
    share = (math.pi * i1(depth)) ** 2
    reflected = 0.5 * rho * g * form.B * share / (share + k1(depth) ** 2) * bow
    off = np.abs(heading % (2 * math.pi) - math.pi)
    ahead = off <= math.radians(45.0) + 1e-9
    sized = (
        75 < form.L < 350
        and 4 < form.L / form.B < 9
        and 2.2 < form.B / form.d < 9
        and 0.39 < form.block < 0.9
    )
    fast = (froude > 0.1) & (froude < 0.3)
    holds = (fast & sized)[:, None, :] & ahead[None, :, None]
    return np.asarray(np.where(holds, (moving + reflected)[:, None, :], np.nan))


def snnm(
    form: ResistanceParticulars, speed: Array, heading: Array, omega: Array, rho: float, g: float
) -> Array:
    """SNNM (Liu and Papanikolaou 2020) over the square of the amplitude [N/m²].

    rho, g [kg/m³].
    """
    angle = np.abs((heading + math.pi) % (2 * math.pi) - math.pi)[None, :, None]
    U, w = speed[:, None, None], omega[None, None, :]
    scale = rho * g * form.B**2 / form.L
    return np.asarray(scale * (_motion(form, U, angle, w, g) + _reflection(form, U, angle, w, g)))


def _motion(form: ResistanceParticulars, U: Array, angle: Array, omega: Array, g: float) -> Array:
    froude = U / math.sqrt(g * form.L)
    length = 2 * math.pi * g / omega**2
    slender = math.log(form.B / form.d)

    def strength(course: Array | float, fn: Array, power: Array) -> Array:
        full = (0.87 / form.block) ** (-(1 + power) * np.cos(course))
        size = 60.3 * form.block**1.34 * (4 * form.kyy) ** 2 * full / slender
        fast = np.where(fn < 0.12, 0.0072 + 0.1676 * fn, fn**1.5 * np.exp(-3.5 * fn))
        return np.asarray(size * (1 - 2 * np.cos(course)) / 3 * fast)

    ahead = strength(np.maximum(angle, math.pi / 2), froude, froude)
    share = np.minimum(angle / (math.pi / 2), 1.0)
    astern = _following(form, U, omega, g, strength)
    strong = share * ahead + (1 - share) * astern
    trimmed = math.atan(abs(form.trim) / form.L)
    ratio = (
        2.142
        * form.kyy ** (1 / 3)
        * np.sqrt(form.L / length)
        * (1 - 0.111 / form.block * (slender - math.log(2.75)))
        * (form.block / 0.65) ** 0.17
        * (
            (-1.377 * froude**2 + 1.157 * froude) * np.abs(np.cos(angle))
            + 0.618 * (13 + np.cos(2 * angle)) / 14
        )
    )
    low = np.array(566 * (form.L * form.block / form.B) ** -2.66)
    high = np.array(-566 * (form.L / form.B) ** -2.66 * (4 - 125 * trimmed))
    return 4 * strong * (1 + 28.7 * trimmed) * _peak(ratio, 11.0, -8.5, low, high)


def _following(
    form: ResistanceParticulars, U: Array, omega: Array, g: float, strength: Callable[..., Array]
) -> Array:
    """Strength in following seas: none at a quarter of the speed of the waves."""
    wave = g / omega
    slow = np.zeros_like(wave)
    still = strength(0.0, slow, slow)
    back = strength(math.pi, slow, slow)
    fast = np.maximum((U - wave / 2) / math.sqrt(g * form.L), 0.0)
    beyond = strength(math.pi, fast, fast)
    part = np.clip(4 * U / wave, 0.0, 2.0)  # 1 where the ship has a quarter of the wave's speed
    low = still * (1 - part)
    middle = back * (part - 1)
    return np.asarray(np.where(part < 1, low, np.where(part < 2, middle, beyond)))


def _reflection(
    form: ResistanceParticulars, U: Array, angle: Array, omega: Array, g: float
) -> Array:
    """Reflection at the bow and at the stern, over ρgB²/L."""
    froude = U / math.sqrt(g * form.L)
    length = 2 * math.pi * g / omega**2
    bow, stern = math.atan(0.495 * form.B / form.entrance), math.atan(0.495 * form.B / form.run)
    course = 2 * omega * U / g
    near = np.where(angle >= math.pi - bow, -np.cos(angle), 0.0)
    full = (0.87 / form.block) ** ((1 + 4 * np.sqrt(froude)) * near)

    def depth_share(draught: Array | float) -> Array:
        deep = 1 - np.exp(-4 * math.pi * draught * (1 / length - 1 / (2.5 * form.L)))
        return np.asarray(np.where(length <= 2.5 * form.L, deep, 0.0))

    def side(entry: float, sign: int) -> Array:
        """A straight piece of waterline at an angle to the middle line, of port or starboard."""
        met = entry + sign * angle
        return np.asarray(
            np.sin(met) ** 2 + course * (math.cos(entry) * np.cos(met) - np.cos(angle))
        )

    lean = np.sqrt(np.abs(np.cos(angle)))
    aft = form.d * np.where(form.block <= 0.75, (4 + lean) / 5, (2 + lean) / 3)
    fore_share, aft_share = depth_share(form.d), depth_share(aft)
    pieces = (
        np.where(angle >= bow, fore_share * side(bow, -1) * full, 0.0)
        + np.where(angle >= math.pi - bow, fore_share * side(bow, 1) * full, 0.0)
        - np.where(angle <= math.pi - stern, aft_share * side(stern, 1), 0.0)
        - np.where(angle <= stern, aft_share * side(stern, -1), 0.0)
    )
    return 2.25 / 4 * form.L / form.B * pieces


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
        "momentum": "Maruo (1960, 1963): the momentum of the waves that all sections send out "
        "together, and Faltinsen's reflection in short ones. Sections answer each by itself and "
        "know nothing of the speed: too small of a beamy ship that is slow; in waves from abaft "
        "the beam they answer as at rest.",
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
    drift : array, shape (3, speeds, headings, frequencies)
        Mean X, Y and N by the engine, or by momentum [N/m², N m/m²].
    """

    rao: Rao
    methods: Mapping[str, Array]
    drift: Array

    @property
    def unit(self) -> float:
        """ρ g B²/L [N/m²], by which added resistance is usually divided."""
        return self.rao.rho * self.rao.g * self.rao.B**2 / self.rao.L

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

        Raises
        ------
        DataError
            If the frequencies leave out a tenth of the energy of the sea (`Rao.share_of`).
        """
        self.rao.share_of(sea)
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
                points=[
                    f"{name}: {LEAVES_OUT.get(name, 'as the program computed it.')}"
                    for name in self.methods
                ],
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
    ['Gerritsma-Beukelman', 'SNNM', 'STAWAVE-2', 'momentum', 'with reflection']
    """
    if rao.strips is None or rao.loading is None:
        pushed = drift(rao)
        return AddedResistance(rao=rao, methods={rao.engine: -pushed[0]}, drift=pushed)
    brought = {} if rao.second_order is None else {rao.engine: -rao.second_order[0]}
    momentum = drift(rao, method="momentum")
    along = np.cos(rao.heading)[:, None] * radiated_force(rao)
    form = form_of(rao.strips.hull, rao.loading.kyy)
    given: dict[str, Callable[..., Array]] = {"STAWAVE-2": stawave2, "SNNM": snnm}
    formulas = {
        name: method(form, rao.speed, rao.heading, rao.omega, rao.rho, rao.g)
        for name, method in given.items()
    }
    return AddedResistance(
        rao=rao,
        methods={
            **brought,
            "momentum": -momentum[0],
            "Gerritsma-Beukelman": -significant(along[None])[0],
            "with reflection": -drift(rao, method="sections")[0],
            **formulas,
        },
        drift=momentum if rao.second_order is None else rao.second_order,
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
