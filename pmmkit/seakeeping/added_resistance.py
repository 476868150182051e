"""Added resistance and mean drift in regular waves, by several methods side by side.

All are mean forces of second order over the square of the amplitude of the wave [N/m²].
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType
from typing import TYPE_CHECKING, Final

import numpy as np

from pmmkit.errors import DataError
from pmmkit.numerics import Array
from pmmkit.plotting.waves import over_wave_length
from pmmkit.presentation import Described, Grid, Group, Section, number
from pmmkit.seakeeping.empirical_resistance import Form, snnm, stawave2
from pmmkit.seakeeping.hull import Hull
from pmmkit.seakeeping.responses import nearest
from pmmkit.seakeeping.seas import Sea
from pmmkit.seakeeping.sectional import HEAVE
from pmmkit.seakeeping.strips import at_frequency
from pmmkit.seakeeping.transfer import Rao

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
        """Mean added resistance in a long-crested sea, 2∫S (R/ζ²) dω [N], by each method.

        Parameters
        ----------
        sea : Sea
            The sea.
        speed, heading_deg : float, optional
            One of those that were computed [m/s, deg].
        """
        a = nearest(self.rao.speed, speed, "speed [m/s]")
        b = nearest(np.degrees(self.rao.heading), heading_deg, "heading_deg")
        return {
            name: mean_force(values[a, b], self.rao.omega, sea)
            for name, values in self.methods.items()
        }

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


def mean_force(values: Array, omega: Array, sea: Sea) -> float:
    """2∫S F/ζ² dω [N]; NaN where a method does not hold in the sea.

    Parameters
    ----------
    values, omega : array
        Force over the square of the amplitude [N/m²] at frequencies of the waves [rad/s].
    sea : Sea
        The sea.
    """
    energy = sea.spectrum(omega)
    silent = energy < 1e-4 * energy.max()
    return float(2 * np.trapezoid(np.where(silent, 0.0, energy * values), omega))


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
    >>> from pmmkit.seakeeping import hull_from_particulars, rao
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


def radiated_force(rao: Rao) -> Array:
    """Force along the waves by the energy that heave and pitch send out [N/m²].

    k/(2ωₑ) ∫ (b₃₃ - U da₃₃/dx) |V|² dx, with V the vertical velocity of a section against the
    wave, whose velocity decays with depth (Gerritsma and Beukelman 1972).

    Parameters
    ----------
    rao : Rao
        The motions.

    Returns
    -------
    array, shape (speeds, headings, frequencies)
    """
    strips, k = rao.strips, rao.wavenumber
    x = strips.x
    points, steps = strips.panels
    half = strips.hull.breadths / 2
    inside = np.sum(np.exp(-np.multiply.outer(k, points.real)) * points.imag * -steps.real, -1)
    share = 1 - k[:, None] * inside / half
    along = np.multiply.outer(np.cos(rao.heading), k)[..., None]
    wave = 1j * rao.omega[:, None] * share * np.exp(-1j * along * x)
    heave, pitch = (rao.mode(name)[..., None] for name in ("heave", "pitch"))
    encounter, speed = rao.encounter[..., None], rao.speed[:, None, None, None]
    velocity = 1j * encounter * (heave - x * pitch) + speed * pitch - wave
    local = np.abs(velocity) ** 2
    added = rao.rho * np.stack(
        [
            at_frequency(strips, strips.sections.added[HEAVE, HEAVE, :, s], np.abs(rao.encounter))
            for s in range(x.size)
        ],
        axis=-1,
    )
    damped = -added.imag * np.abs(encounter) * local
    between = 0.5 * (local[..., 1:] + local[..., :-1])
    growth = np.sum(np.diff(added.real, axis=-1) * between, axis=-1)
    energy = np.trapezoid(damped, x, axis=-1) - rao.speed[:, None, None] * growth
    slow = np.maximum(np.abs(rao.encounter), 1e-6)
    return np.asarray(np.where(rao.quasi_static, 0.0, k / (2 * slow) * energy))


def reflected_force(rao: Rao) -> Array:
    """Mean force of waves that the side of the ship reflects: X, Y (port) and N [N/m², N m/m²].

    Faltinsen's (1980) asymptote for waves that are short beside the ship, over the part of the
    waterline that the waves strike: ½ρg (c² + 2ωU/g c n_x) on the normal, with c the cosine of
    incidence; times the energy that a plate of the draught reflects (Ursell 1947).

    Parameters
    ----------
    rao : Rao
        For its hull, speed, heading and frequencies.

    Returns
    -------
    array, shape (3, speeds, headings, frequencies)
    """
    middle, normal, length = _waterline(rao.strips.hull)
    direction = np.stack([np.cos(rao.heading), -np.sin(rao.heading)], axis=-1)
    strike = np.maximum(-direction @ normal.T, 0.0)
    lever = middle[:, 0] * normal[:, 1] - middle[:, 1] * normal[:, 0]
    arms = -np.column_stack([normal, lever]) * length[:, None]
    still = (strike**2) @ arms
    moving = (strike * normal[:, 0]) @ arms
    share = plate_reflection(rao.wavenumber * rao.strips.hull.draught)
    ahead = 2 * np.multiply.outer(rao.speed, rao.omega) / rao.g
    found = still.T[:, None, :, None] + moving.T[:, None, :, None] * ahead[None, :, None, :]
    return np.asarray(0.5 * rao.rho * rao.g * found * share)


def plate_reflection(depth: Array) -> Array:
    """Energy of waves that a plate from the surface down reflects [-]: π²I₁²/(π²I₁² + K₁²).

    Parameters
    ----------
    depth : array
        Wavenumber times the depth of the plate.

    Examples
    --------
    >>> plate_reflection(np.array([0.0, 0.5, 2.0])).round(3)
    array([0.   , 0.193, 0.999])
    """
    from scipy.special import i1e, k1e

    bounded = np.maximum(depth, 1e-9)
    grown = (math.pi * i1e(bounded)) ** 2
    shrunk = (k1e(bounded) * np.exp(-2 * bounded)) ** 2
    return np.asarray(grown / (grown + shrunk))


def drift(rao: Rao) -> Array:
    """Mean drift X (forward), Y (port) and N about midship of waves [N/m², N m/m²].

    The energy that heave and pitch send out pushes along the waves, in long waves; what the sides
    reflect pushes along their normals, in short ones; the two are blended by the energy that a
    plate of the draught reflects. Sway and roll send out waves too, which is left out: in beam
    seas about half as long as the ship the force is too small by a quarter.

    Parameters
    ----------
    rao : Rao
        The motions.

    Returns
    -------
    array, shape (3, speeds, headings, frequencies)
    """
    share = plate_reflection(rao.wavenumber * rao.strips.hull.draught)
    pushed = (1 - share) * radiated_force(rao)
    beta = rao.heading[:, None]
    lever = rao.strips.hull.hydrostatics.xF
    across = -np.sin(beta) * pushed
    return np.stack([np.cos(beta) * pushed, across, lever * across]) + reflected_force(rao)


def drift_table(rao: Rao, sea: Sea, *, speed: float | None = None) -> dict[str, tuple[float, ...]]:
    """Mean drift of a sea as the table that a manoeuvring model takes.

    Parameters
    ----------
    rao : Rao
        Motions at headings from 0 to 180°.
    sea : Sea
        Its period counts; forces go with the square of its height, which the model has.
    speed : float, optional
        One of those of `rao` [m/s].

    Returns
    -------
    dict
        ``angle_deg`` from which the waves come, from the bow, to starboard; ``DX``, ``DY`` over
        ρgHs²L and ``DN`` over ρgHs²L², x forward, y to starboard.

    Raises
    ------
    DataError
        If headings do not reach from 0 to 180°.
    """
    a = nearest(rao.speed, speed, "speed [m/s]")
    headings = np.degrees(rao.heading)
    if headings.min() > 1e-6 or headings.max() < 180.0 - 1e-6 or (headings > 180.0 + 1e-6).any():
        raise DataError("A table of drift needs headings from 0 to 180°, both ends among them.")
    scale = rao.rho * rao.g * sea.Hs**2 * rao.L
    found = drift(rao)[:, a]
    order = np.argsort(-headings)
    # waves of heading β run to starboard; those from starboard are their mirror, and y turns round
    X, Y, N = (
        tuple(mean_force(values[b], rao.omega, sea) / size for b in order)
        for values, size in zip(found, (scale, scale, scale * rao.L), strict=True)
    )
    return {"angle_deg": tuple((180.0 - headings[order]).tolist()), "DX": X, "DY": Y, "DN": N}


def _waterline(hull: Hull) -> tuple[Array, Array, Array]:
    """Middles (x, y), outward normals and lengths of the pieces of the whole waterline."""
    x = np.r_[hull.x[0], hull.x, hull.x[-1]]
    y = np.r_[0.0, hull.breadths / 2, 0.0]
    step = np.column_stack([np.diff(x), np.diff(y)])
    length = np.hypot(*step.T)
    whole = length > 1e-12
    step, length = step[whole], length[whole]
    port = np.column_stack([-step[:, 1], step[:, 0]]) / length[:, None]
    middle = np.column_stack([(x[1:] + x[:-1]) / 2, (y[1:] + y[:-1]) / 2])[whole]
    mirror = np.array([1.0, -1.0])
    return (
        np.concatenate([middle, middle * mirror]),
        np.concatenate([port, port * mirror]),
        np.concatenate([length, length]),
    )


def form_of(hull: Hull, kyy: float) -> Form:
    """What formulas ask of a hull.

    Parameters
    ----------
    hull : Hull
        The hull.
    kyy : float
        Radius of gyration in pitch [m].
    """
    breadth = float(hull.breadths.max())
    full = hull.x[hull.breadths > 0.99 * breadth]
    return Form(
        L=hull.L,
        B=breadth,
        d=hull.draught,
        block=hull.hydrostatics.volume / (hull.L * breadth * hull.draught),
        kyy=kyy / hull.L,
        entrance=max(0.5 * hull.L - float(full.max()), 0.05 * hull.L),
        run=max(0.5 * hull.L + float(full.min()), 0.05 * hull.L),
    )
