"""Transfer functions of a ship in waves, as a table, a dataset and figures."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Final

import numpy as np

from pmmkit.base import DataError
from pmmkit.numerics import Array
from pmmkit.presentation import Described, Grid, Group, Section, counted
from pmmkit.seakeeping.figures import over_wave_length
from pmmkit.seakeeping.lengthwise import Complex, Flags
from pmmkit.seakeeping.loading import Loading
from pmmkit.seakeeping.strips import Strips, coefficients, excitation, mass_matrix, restoring

if TYPE_CHECKING:
    import pandas as pd
    import xarray as xr

    from pmmkit.plotting import Figure
    from pmmkit.seakeeping.seas import Sea


# Which of the computed speeds and headings is asked for.


def nearest(values: Array, wanted: float | None, name: str) -> int:
    """Index of a value that was asked, or of the only one; an error lists those there are."""
    if wanted is None and values.size == 1:
        return 0
    if wanted is None:
        raise DataError(f"Say which {name}: {', '.join(f'{x:g}' for x in values)}.")
    place = int(np.argmin(np.abs(values - wanted)))
    if abs(values[place] - wanted) > 1e-3 * max(1.0, abs(wanted)):
        there = ", ".join(f"{x:.4g}" for x in values)
        raise DataError(f"{name} {wanted:g} was not computed; there are {there}.")
    return place


def between(computed: Array, heading_deg: float) -> tuple[tuple[int, ...], tuple[float, ...]]:
    """Headings [rad] that were computed beside one, with weights; port and starboard are alike."""
    folded = abs((heading_deg + 180.0) % 360.0 - 180.0)
    there = np.abs((np.degrees(computed) + 180.0) % 360.0 - 180.0)
    gap = np.abs(there - folded)
    if gap.min() < 1e-6:
        return (int(gap.argmin()),), (1.0,)
    below, above = np.flatnonzero(there < folded), np.flatnonzero(there > folded)
    if not below.size or not above.size:
        raise DataError(
            f"A short-crested sea needs headings on both sides of {folded:.0f}°: compute them from "
            "0 to 180° in steps of 15° or so."
        )
    low, high = int(below[there[below].argmax()]), int(above[there[above].argmin()])
    if there[high] - there[low] > 31.0:
        raise DataError("A short-crested sea needs headings in steps of 30° or less.")
    part = (folded - there[low]) / (there[high] - there[low])
    return (low, high), (float(1 - part), float(part))


LEAST_SHARE: Final = 0.9
"""Least share of the energy of a sea of which something is summed."""
MIRRORED: Final = np.array([1.0, -1.0, 1.0, -1.0, 1.0, -1.0])
"""Modes in axes mirrored at the middle, as of capytaine and WAMIT."""
DRIFT: Final = ("drift_X", "drift_Y", "drift_N")
"""Columns of the mean drift in tables."""
ENGINE: Final = "strip theory"
"""What pmmkit computes motions by."""
MODES: Final = ("surge", "sway", "heave", "roll", "pitch", "yaw")
_CURVES: Final = 8


@dataclass(frozen=True, kw_only=True, repr=False, eq=False)
class Rao(Described):
    """Transfer functions of a ship in waves, per metre of wave amplitude (not of height).

    Axes are those of `pmmkit.seakeeping.strips`: x forward, y to port, z up, from the water above
    the centre of gravity; heading 180° is head sea; pitch is positive with the bow down.

    Parameters
    ----------
    name : str
        Of the ship.
    engine : str
        What computed them.
    L, B : float
        Length between perpendiculars, breadth [m].
    x : float
        Of the origin, forward of midship [m].
    speed : array, shape (speeds,)
        [m/s].
    heading : array, shape (headings,)
        [rad].
    omega : array, shape (frequencies,)
        Of the waves in a frame at rest [rad/s].
    encounter : array, shape (speeds, headings, frequencies)
        ωₑ = ω - kU cos β [rad/s]; negative where the ship overtakes the waves.
    motion : array of complex, shape (6, speeds, headings, frequencies)
        Surge, sway, heave [m/m], roll, pitch, yaw [rad/m].
    force : array of complex, of the same shape
        Of the waves [N/m], [N m/m].
    quasi_static : array of bool, shape (speeds, headings, frequencies)
        Where ωₑ is so low that heave, roll and pitch follow the wave, and surge, sway and yaw are
        not computed (NaN).
    strips : Strips, optional
        The sections, where a hull is known.
    loading : Loading, optional
        The mass, where a hull is known.
    second_order : array, shape (3, speeds, headings, frequencies), optional
        Mean drift by the engine itself: X forward, Y to port [N/m²], N about midship [N m/m²].
    roll_damping : array, shape (speeds, headings, frequencies)
        Of roll beside that of waves, as linear as it was taken [N m s]; it takes power out of them.
    rho, g : float
        Density [kg/m³], gravity [m/s²].
    notes : tuple of str
        What is assumed, and where the theory ends.
    """

    name: str
    engine: str
    L: float
    B: float
    x: float
    speed: Array
    heading: Array
    omega: Array
    encounter: Array
    motion: Complex
    force: Complex
    quasi_static: Flags
    roll_damping: Array
    rho: float
    g: float
    strips: Strips | None = None
    loading: Loading | None = None
    second_order: Array | None = None
    notes: tuple[str, ...] = ()

    @property
    def wavenumber(self) -> Array:
        """k = ω²/g [1/m]."""
        return self.omega**2 / self.g

    @property
    def moored(self) -> bool:
        """Whether strip theory computed her at rest too, so that `to_capytaine` can tell it."""
        return self.engine == ENGINE and self.loading is not None and 0.0 in self.speed

    @property
    def strip_sections(self) -> Strips:
        """The sections of the hull; a DataError where none is known."""
        if self.strips is None:
            raise DataError(
                f"The motions of {self.name} come from {self.engine} without a hull.",
                remedy="Read them with the hull: read_rao(file, hull=read_hull(...)).",
            )
        return self.strips

    def share_of(self, sea: Sea) -> float:
        """Share of the energy of a sea that the frequencies hold.

        Parameters
        ----------
        sea : Sea
            The sea.

        Raises
        ------
        DataError
            If it is less than `LEAST_SHARE`: whatever is summed over the sea would be too small.
        """
        if sea.Hs == 0.0:
            return 1.0
        share = float(np.trapezoid(sea.spectrum(self.omega), self.omega)) / sea.moment(0)
        if share < LEAST_SHARE:
            raise DataError(
                f"The frequencies {self.omega[0]:.2f} to {self.omega[-1]:.2f} rad/s hold "
                f"{100 * share:.0f} % of the energy of the sea, whose peak is at "
                f"{sea.peak:.2f} rad/s.",
                remedy="Compute the motions for this sea: rao(hull, sea=...), or state omega."
                if self.strips is not None
                else f"Let {self.engine} compute more frequencies.",
            )
        return share

    def at_speed(self, place: int) -> Rao:
        """The same at one of the speeds alone.

        Parameters
        ----------
        place : int
            Of the speed.
        """
        a = slice(place, place + 1)
        second = self.second_order
        return replace(
            self,
            speed=self.speed[a],
            encounter=self.encounter[a],
            motion=self.motion[:, a],
            force=self.force[:, a],
            quasi_static=self.quasi_static[a],
            roll_damping=self.roll_damping[a],
            second_order=None if second is None else second[:, a],
        )

    def mode(self, name: str) -> Complex:
        """The transfer function of one of `MODES`.

        Parameters
        ----------
        name : str
            Such as ``heave``.
        """
        if name not in MODES:
            raise DataError(f"There is no motion {name!r}. There are {', '.join(MODES)}.")
        return np.asarray(self.motion[MODES.index(name)])

    def at_point(self, x: float, y: float = 0.0, z: float = 0.0) -> Complex:
        """Motion of a point (x, y, z) of the ship [m/m], shape (3, speeds, headings, frequencies).

        Parameters
        ----------
        x, y, z : float
            Forward of midship, to port of the middle, above the water [m].
        """
        forward = x - self.x
        s, r = self.motion[:3], self.motion[3:]
        return np.stack(
            [
                s[0] + z * r[1] - y * r[2],
                s[1] + forward * r[2] - z * r[0],
                s[2] + y * r[0] - forward * r[1],
            ]
        )

    def case(self, speed: float | None, heading_deg: float | None) -> tuple[int, int]:
        """Places of a speed and a heading that were computed; of the only ones where not stated.

        Parameters
        ----------
        speed, heading_deg : float or None
            [m/s, deg].
        """
        return (
            nearest(self.speed, speed, "speed [m/s]"),
            nearest(np.degrees(self.heading), heading_deg, "heading_deg"),
        )

    def cases(self) -> list[str]:
        """Speeds and headings in words, in the order of the arrays."""
        return [
            f"{speed:.2f} m/s, {math.degrees(heading):.0f}°"
            for speed in self.speed
            for heading in self.heading
        ]

    def to_xarray(self) -> xr.Dataset:
        """Amplitudes and phases over speed, heading and frequency, with units and long names."""
        import xarray as xr

        axes = ("speed", "heading", "omega")
        data: dict[str, object] = {
            "encounter_frequency": (
                axes,
                self.encounter,
                {"units": "rad s-1", "long_name": "frequency of encounter"},
            ),
            "quasi_static": (
                axes,
                self.quasi_static.astype(np.int8),
                {"units": "1", "long_name": "motions follow the wave"},
            ),
        }
        for number, mode in enumerate(MODES):
            unit = "m m-1" if number < 3 else "rad m-1"
            lead = {"units": "rad", "long_name": f"lead of {mode} over the crest above the origin"}
            size = {"units": unit, "long_name": f"amplitude of {mode} per wave amplitude"}
            data[f"{mode}_amplitude"] = (axes, np.abs(self.motion[number]), size)
            data[f"{mode}_phase"] = (axes, np.angle(self.motion[number]), lead)
        for name, (values, unit) in self._loads().items():
            data[name] = (axes, values, {"units": unit, "long_name": name.replace("_", " ")})
        frequency = "sea_surface_wave_angular_frequency"
        coords = {
            "speed": (
                "speed",
                self.speed,
                {
                    "units": "m s-1",
                    "standard_name": "platform_speed_wrt_sea_water",
                    "long_name": "speed of the ship",
                },
            ),
            "heading": (
                "heading",
                np.degrees(self.heading),
                {"units": "degree", "long_name": "heading to the waves, 180 is head sea"},
            ),
            "omega": ("omega", self.omega, {"units": "rad s-1", "long_name": frequency}),
        }
        attributes = {
            "Conventions": "CF-1.8",
            "title": f"Motions of {self.name} in regular waves",
            "axes": "x forward, y to port, z up; pitch positive with the bow down",
            "name": self.name,
            "source": self.engine,
            "length_m": self.L,
            "breadth_m": self.B,
            "origin_m": self.x,
            "density_kg_m3": self.rho,
            "gravity_m_s2": self.g,
            "notes": " ".join(self.notes),
        }
        return xr.Dataset(data, coords=coords, attrs=attributes)

    def _loads(self) -> dict[str, tuple[Array, str]]:
        """Forces of the waves and mean drift, where they are known, with their units."""
        found = {}
        for mode, force in zip(MODES, self.force, strict=True):
            if np.isfinite(force).any():
                unit = "N m-1" if mode in MODES[:3] else "N"
                found[f"{mode}_force"] = np.abs(force), unit
                found[f"{mode}_force_phase"] = np.angle(force), "rad"
        if self.second_order is not None:
            for name, drift in zip(DRIFT, self.second_order, strict=True):
                found[name] = drift, "N m-1" if name == DRIFT[2] else "N m-2"
        return found

    def to_capytaine(self) -> xr.Dataset:
        """The dataset that capytaine writes, of a ship at rest, which capytaine moves by alike.

        Axes, sides and time are capytaine's: waves of 90° run to port, time goes as exp(-iωt). The
        damping of roll beside that of waves stands in `radiation_damping`.

        Returns
        -------
        xarray.Dataset
            Added mass, damping, mass, stiffness and forces of waves about the point on the water
            above the centre of gravity [SI].

        Raises
        ------
        DataError
            If it is not strip theory that computed her, at rest.
        """
        import xarray as xr

        strips, loading = self.strip_sections, self.loading
        if loading is None or not (self.speed == 0.0).any():
            raise DataError(
                "A dataset of capytaine is of a ship at rest: let 0 be among the speeds."
            )
        at = self.at_speed(int(np.flatnonzero(self.speed == 0.0)[0]))
        added = self.rho * coefficients(strips, np.zeros(1), self.omega)
        damping = -added.imag * self.omega
        damping[3, 3] += at.roll_damping[0, 0]
        incident, whole = excitation(strips, at.speed, self.heading, self.omega, at.encounter)
        sides = np.outer(MIRRORED, MIRRORED)
        forced, moved = "influenced_dof", "radiating_dof"

        def varying(values: Array) -> tuple[tuple[str, ...], Array]:
            return ("omega", moved, forced), (sides[..., None] * values).T

        def steady(values: Array) -> tuple[tuple[str, ...], Array]:
            return (forced, moved), sides * values

        def force(values: Complex) -> tuple[tuple[str, ...], Array]:
            turned = self.rho * (values[:, 0] * MIRRORED[:, None, None]).conj().T
            return ("complex", "omega", "wave_direction", forced), np.stack(
                [turned.real, turned.imag]
            )

        return xr.Dataset(
            {
                "added_mass": varying(added.real),
                "radiation_damping": varying(damping),
                "inertia_matrix": steady(mass_matrix(strips, loading, self.rho)),
                "hydrostatic_stiffness": steady(self.rho * restoring(strips, loading)),
                "Froude_Krylov_force": force(incident),
                "diffraction_force": force(whole - incident),
                "excitation_force": force(whole),
                "rho": self.rho,
                "g": self.g,
                "water_depth": np.inf,
                "forward_speed": 0.0,
            },
            coords={
                "omega": self.omega,
                "wave_direction": self.heading,
                "complex": ["re", "im"],
                "body_name": self.name,
                forced: [mode.capitalize() for mode in MODES],
                moved: [mode.capitalize() for mode in MODES],
            },
            attrs={"source": f"pmmkit, {self.engine}", "origin_m": self.x},
        )

    def to_pandas(self) -> pd.DataFrame:
        """One row for each speed, heading and frequency [SI; heading in degrees]."""
        import pandas as pd

        U, beta, w = np.meshgrid(self.speed, np.degrees(self.heading), self.omega, indexing="ij")
        columns = {
            "speed": U,
            "heading_deg": beta,
            "omega": w,
            "encounter": self.encounter,
            "wave_length_L": 2 * math.pi * self.g / w**2 / self.L,
        }
        for number, mode in enumerate(MODES):
            columns[mode] = np.abs(self.motion[number])
            columns[f"{mode}_phase"] = np.angle(self.motion[number])
        columns |= {name: values for name, (values, _) in self._loads().items()}
        return pd.DataFrame({name: values.ravel() for name, values in columns.items()})

    def plot(self) -> Figure:
        """Heave, pitch and roll over the length of the waves; angles over the slope of the wave.

        Of many speeds the least and the greatest are drawn, of many headings some evenly spread.
        """
        every = np.arange(self.speed.size * self.heading.size).reshape(self.speed.size, -1)
        speeds = every if every.size <= _CURVES else every[sorted({0, self.speed.size - 1})]
        columns = min(self.heading.size, _CURVES // len(speeds))
        spread = np.linspace(0, self.heading.size - 1, columns).round().astype(int)
        drawn = speeds[:, spread].ravel()
        names, k = self.cases(), self.wavenumber

        def curves(mode: int, over: Array) -> dict[str, Array]:
            flat = np.abs(self.motion[mode]).reshape(-1, self.omega.size) / over
            return {names[case]: flat[case] for case in drawn}

        return over_wave_length(
            2 * math.pi / k / self.L,
            {
                "heave / ζ": curves(2, np.ones_like(k)),
                "pitch / kζ": curves(4, k),
                "roll / kζ": curves(3, k),
            },
        )

    def _headline(self) -> str:
        froude = self.speed / math.sqrt(self.g * self.L)
        return (
            f"{self.name} by {self.engine}: Fn {', '.join(f'{x:.3f}' for x in froude[:6])}, "
            f"{counted(self.heading.size, 'heading')}, "
            f"{self.omega.size} frequencies"
        )

    def _sections(self) -> Sequence[Section]:
        rows = []
        for i, speed in enumerate(self.speed):
            for j, heading in enumerate(self.heading):
                size = np.abs(self.motion[:, i, j])
                peaks = [
                    f"{np.nanmax(size[m]):.3f} at {self.omega[np.nanargmax(size[m])]:.2f}"
                    if np.isfinite(size[m]).any()
                    else None
                    for m in (2, 3, 4)
                ]
                rows.append([f"{speed:.2f} m/s, {math.degrees(heading):.0f}°", *peaks])
        shown = rows[:30]
        head = ["speed, heading", "heave [m/m]", "roll [rad/m]", "pitch [rad/m]"]
        more = [f"Shown are {len(shown)} of {len(rows)} speeds and headings."]
        return [
            *self._afloat(),
            Section(
                title="Largest motions per metre of wave amplitude, at ω [rad/s]",
                paragraphs=more if len(shown) < len(rows) else [],
                tables=[Grid(head=head, groups=[Group(rows=shown)])],
            ),
            *([Section(title="Notes", points=self.notes)] if self.notes else []),
        ]

    def _afloat(self) -> Iterator[Section]:
        """The hull with its loading, where it is known."""
        if self.strips is not None and self.loading is not None:
            hull = self.strips.hull
            afloat = f"{hull.in_words} GM {hull.hydrostatics.KM - self.loading.KG:.3g} m."
            yield Section(title="The hull as it floats", paragraphs=[afloat])
