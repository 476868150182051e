"""Motions at the frequency of the waves, superposed on a manoeuvre."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType
from typing import TYPE_CHECKING, Final

import numpy as np
from numpy.typing import NDArray

from pmmkit.base import DataError
from pmmkit.numerics import Array
from pmmkit.presentation import Described, Grid, Group, Section, number
from pmmkit.seakeeping.lengthwise import Complex
from pmmkit.seakeeping.seas import Sea
from pmmkit.seakeeping.transfer import Rao
from pmmkit.simulation import Track

if TYPE_CHECKING:
    import pandas as pd

    from pmmkit.plotting import Figure

CHANNELS: Final[Mapping[str, tuple[str, str]]] = MappingProxyType(
    {
        "x": ("m", "path in the direction of the approach"),
        "y": ("m", "path to starboard of the approach"),
        "psi": ("rad", "heading, positive to starboard"),
        "phi": ("rad", "heel, positive to starboard down"),
        "heave": ("m", "of the centre of gravity, upward"),
        "pitch": ("rad", "positive with the bow down"),
        "elevation": ("m", "of the wave at the centre of gravity"),
    }
)
_COMPONENTS: Final = 200
_SAMPLES: Final = 20  # in a peak period
_BLOCK: Final = 500
_MIRRORED: Final = np.array([1.0, -1.0, 1.0, -1.0, 1.0, -1.0])  # modes, waves that meet starboard


@dataclass(frozen=True, kw_only=True, eq=False, repr=False)
class MotionInWaves(Described):
    """A manoeuvre with the motions at the frequency of the waves.

    Parameters
    ----------
    name : str
        Of the ship.
    sea : Sea
        What it sails in.
    from_deg : float
        Where the waves come from, from the heading of the approach, to starboard [deg].
    seed : int
        Of the phases.
    t : array
        [s]
    values : mapping of str to array
        `CHANNELS`: those of the track with the first-order motions on them, and heave, pitch and
        the wave.
    waves : mapping of str to array
        The first-order part of the same channels alone.
    """

    name: str
    sea: Sea
    from_deg: float
    seed: int
    t: Array
    values: Mapping[str, Array]
    waves: Mapping[str, Array]

    def to_pandas(self) -> pd.DataFrame:
        """The channels in columns, t first [SI and radians]."""
        import pandas as pd

        return pd.DataFrame({"t": self.t, **self.values})

    def plot(self) -> Figure:
        """Heading, heel, heave and pitch over time."""
        from pmmkit.seakeeping.figures import over_time

        shown = {
            "heading [deg]": np.degrees(self.values["psi"]),
            "heel [deg]": np.degrees(self.values["phi"]),
            "heave [m]": self.values["heave"],
            "pitch [deg]": np.degrees(self.values["pitch"]),
        }
        return over_time(self.t, shown)

    def _headline(self) -> str:
        return (
            f"{self.name} in waves from {self.from_deg:g}°: {self.sea.words}, seed {self.seed}, "
            f"{self.t[-1] - self.t[0]:.0f} s"
        )

    def _sections(self) -> Sequence[Section]:
        rows = []
        for name, (unit, _) in CHANNELS.items():
            scale, shown = (math.degrees(1.0), "deg") if unit == "rad" else (1.0, unit)
            part = self.waves[name] * scale
            rows.append([name, shown, number(2 * float(np.std(part)), 3), number(np.ptp(part), 3)])
        head = ["", "unit", "significant amplitude 2σ", "largest less least"]
        table = Grid(head=head, groups=[Group(rows=rows)], texts=(1,))
        points = [f"{name}: {text}" for name, (_, text) in CHANNELS.items()]
        return [Section(title="First-order motions", tables=[table], points=points)]


def superposed(
    track: Track, found: Rao, sea: Sea, *, from_deg: float = 0.0, seed: int = 0
) -> MotionInWaves:
    """First-order motions of a ship in random waves along the path of a manoeuvre.

    The sea is a sum of long-crested waves with random phases. Each moves the ship by its transfer
    function at the heading and speed of the instant, at the place where the ship is, so that the
    frequency of encounter follows from the path. The manoeuvre does not feel these motions.

    Parameters
    ----------
    track : Track
        What the ship does without waves, or with their mean drift.
    found : Rao
        Motions at headings from 0 to 180° and at one speed, or several in rising order between
        which they are interpolated.
    sea : Sea
        Long-crested.
    from_deg : float
        Where the waves come from, from the heading of the approach, to starboard [deg].
    seed : int
        Of the phases: the same seed gives the same waves.

    Returns
    -------
    MotionInWaves

    Raises
    ------
    DataError
        If the headings do not reach from 0 to 180°, the sea is short-crested, or the frequencies
        leave out a tenth of its energy.

    Examples
    --------
    >>> from pmmkit.seakeeping.hull_forms.particulars import hull_from_particulars
    >>> from pmmkit.seakeeping.motions import rao
    >>> from pmmkit.simulation import simulate
    >>> track = simulate("kcs", rudder_deg=20, speed=8.0, duration=100.0, compiled=False)
    >>> hull = hull_from_particulars(name="KCS", L=230.0, B=32.2, d=10.8, block=0.65)
    >>> found = rao(hull, speeds=8.0, headings_deg=[0, 90, 180], omega=[0.3, 0.5, 0.7, 0.9, 1.1])
    >>> rolled = superposed(track, found, Sea(Hs=3.0, Tp=11.0), seed=1)
    >>> f"{2 * np.std(rolled.values['elevation']):.1f} m"
    '1.4 m'
    """
    headings = np.degrees(found.heading)
    if sea.spreading is not None:
        raise DataError("Motions are superposed in a long-crested sea: leave out spreading.")
    if (
        (np.diff(headings) <= 0.0).any()
        or headings[0] > 1e-6
        or abs(headings[-1] - 180.0) > 1e-6
        or (np.diff(found.speed) <= 0.0).any()
    ):
        raise DataError("Give motions at rising headings from 0 to 180° and at rising speeds.")
    found.share_of(sea)
    step = sea.Tp / _SAMPLES
    t = np.arange(track.t[0], track.t[-1], step)
    path = {name: np.interp(t, track.t, getattr(track, name)) for name in ("x", "y", "psi", "phi")}
    pace = np.interp(t, track.t, np.hypot(track.u, track.v))
    omega, amplitude, phase = _components(found, sea, seed)
    transfer = _at(found, omega)
    runs_to = math.radians(from_deg + 180.0)
    moved = np.concatenate(
        [
            _moved(
                found,
                transfer,
                runs_to - path["psi"][part],
                pace[part],
                (path["x"] + found.x * np.cos(path["psi"]))[part] * math.cos(runs_to)
                + (path["y"] + found.x * np.sin(path["psi"]))[part] * math.sin(runs_to),
                t[part],
                (omega, amplitude, phase),
            )
            for part in (slice(i, i + _BLOCK) for i in range(0, t.size, _BLOCK))
        ],
        axis=1,
    )
    ahead, aside = np.cos(path["psi"]), np.sin(path["psi"])
    surge, sway, heave, roll, pitch, yaw, elevation = moved
    waves = {
        "x": surge * ahead + sway * aside,
        "y": surge * aside - sway * ahead,
        "psi": -yaw,
        "phi": roll,
        "heave": heave,
        "pitch": pitch,
        "elevation": elevation,
    }
    values = {name: part + path[name] if name in path else part for name, part in waves.items()}
    return MotionInWaves(
        name=track.name,
        sea=sea,
        from_deg=from_deg,
        seed=seed,
        t=t,
        values=MappingProxyType(values),
        waves=MappingProxyType(waves),
    )


def _components(found: Rao, sea: Sea, seed: int) -> tuple[Array, Array, Array]:
    """Frequencies, amplitudes and phases of the waves that a sea is made of.

    One frequency at random within each of equal steps, so that the sea does not repeat itself.
    """
    drawn = np.random.default_rng(seed)
    edges = np.linspace(found.omega[0], found.omega[-1], _COMPONENTS + 1)
    omega = edges[:-1] + drawn.random(_COMPONENTS) * np.diff(edges)
    amplitude = np.sqrt(2 * sea.spectrum(omega) * np.diff(edges))
    return omega, amplitude, drawn.uniform(0.0, 2 * math.pi, _COMPONENTS)


def _at(found: Rao, omega: Array) -> Complex:
    """Motions at frequencies: (speeds, headings, 6, frequencies); what is not known is none."""
    place = np.clip(np.searchsorted(found.omega, omega) - 1, 0, found.omega.size - 2)
    share = (omega - found.omega[place]) / (found.omega[place + 1] - found.omega[place])
    known = np.nan_to_num(found.motion)
    return np.moveaxis(known[..., place] * (1 - share) + known[..., place + 1] * share, 0, 2)


def _moved(
    found: Rao,
    transfer: Complex,
    heading: Array,
    speed: Array,
    along: Array,
    t: Array,
    components: tuple[Array, Array, Array],
) -> Array:
    """The six motions and the wave, (7, instants), at headings, speeds and places."""
    omega, amplitude, phase = components
    turned = np.angle(np.exp(1j * heading))
    wave = amplitude * np.exp(
        1j * (np.multiply.outer(t, omega) - np.multiply.outer(along, omega**2 / found.g) + phase)
    )
    sums = np.zeros((6, t.size))
    for a, first in zip(*_between(found.speed, speed), strict=True):
        for b, second in zip(*_between(found.heading, np.abs(turned)), strict=True):
            sums += (first * second) * np.einsum("tmw,tw->mt", transfer[a, b], wave).real
    sums[:, turned < 0.0] *= _MIRRORED[:, None]
    return np.concatenate([sums, wave.sum(axis=1).real[None]])


def _between(there: Array, wanted: Array) -> tuple[list[NDArray[np.intp]], list[Array]]:
    """Indices of the two values beside each, and their shares; held at both ends."""
    if there.size == 1:
        return [np.zeros(wanted.size, dtype=np.intp)], [np.ones(wanted.size)]
    low = np.clip(np.searchsorted(there, wanted, side="right") - 1, 0, there.size - 2)
    share = np.clip((wanted - there[low]) / (there[low + 1] - there[low]), 0.0, 1.0)
    return [low, low + 1], [1 - share, share]
