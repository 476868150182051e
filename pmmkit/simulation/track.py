"""Track: a free-running history, simulated or measured."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, fields, replace
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, ClassVar, Self

import numpy as np
from numpy.typing import NDArray

from pmmkit.base import Progress, UnknownNameError
from pmmkit.conventions import METRICS, Metric
from pmmkit.effects import CATALOGUE
from pmmkit.models import Standing
from pmmkit.numerics import Array
from pmmkit.presentation import Described, Grid, Group, Section, number
from pmmkit.simulation.kinds.turning import LENGTHS

if TYPE_CHECKING:
    import pandas as pd
    import xarray as xr

    from pmmkit.plotting import Figure
    from pmmkit.simulation.froude import FroudeRange
    from pmmkit.simulation.kinds.manoeuvre import Manoeuvre


@dataclass(frozen=True, kw_only=True, eq=False, repr=False)
class Track(Described):
    """A free-running history of the midship point, simulated or measured, SI and radians.

    Parameters
    ----------
    t : array (m,)
        Time from the first order [s]; negative in the approach, where that was recorded.
    x, y, psi : array (m,)
        Path along and to starboard of the approach [m], heading without jumps of 2π [rad].
    u, v, r, p, phi : array (m,)
        Velocities through the water in ship axes [m/s, rad/s], heel [rad].
    delta, n : array (m,)
        Rudder angle [rad], propeller revolutions per second. What was not measured is NaN.
    name, manoeuvre : str
        Of the ship or model; ``turning`` and so on.
    L, speed, Fn : float
        Ship length [m], approach speed [m/s] and its Froude number.
    rudder_deg : float
        Ordered rudder angle [deg].
    metrics : mapping of str to float
        Numbers of the manoeuvre; lengths in metres, and with ``_L`` in ship lengths. NaN where
        the track does not reach that far.
    scale : str
        At which scale and propulsion point the track is.
    notes : tuple of str
        What a reader must know beside what `standing` says.
    orders : tuple of float
        Instants of the orders [s].
    settings : mapping
        Of the manoeuvre, as they were given.
    tested : FroudeRange, optional
        Of derivatives that follow the Froude number of the moment: how long it was outside the
        range that was tested.
    standing : Standing
        What the numbers of the model that sailed stand on.
    forces : mapping of str to array (3, m)
        X, Y [N] and N [N m] about midship of each effect that sailed, added mass apart; its
        polynomial is called ``derivatives``. Empty unless `simulate` was asked for them.
    """

    t: Array
    x: Array
    y: Array
    psi: Array
    u: Array
    v: Array
    r: Array
    p: Array
    phi: Array
    delta: Array
    n: Array
    name: str
    manoeuvre: str
    L: float
    speed: float
    Fn: float
    rudder_deg: float
    metrics: Mapping[str, float] = field(default_factory=lambda: MappingProxyType({}))
    scale: str = ""
    notes: tuple[str, ...] = ()
    orders: tuple[float, ...] = ()
    settings: Mapping[str, Any] = field(default_factory=lambda: MappingProxyType({}))
    tested: FroudeRange | None = None
    standing: Standing = field(default_factory=Standing)
    forces: Mapping[str, Array] = field(default_factory=lambda: MappingProxyType({}))
    CHANNELS: ClassVar[Mapping[str, tuple[str, str]]] = MappingProxyType(
        {
            "x": ("m", "path in the direction of the approach"),
            "y": ("m", "path to starboard of the approach"),
            "psi": ("rad", "heading, positive to starboard"),
            "u": ("m/s", "surge velocity"),
            "v": ("m/s", "sway velocity, positive to starboard"),
            "r": ("rad/s", "yaw rate, positive to starboard"),
            "p": ("rad/s", "roll rate, positive to starboard down"),
            "phi": ("rad", "heel, positive to starboard down"),
            "delta": ("rad", "rudder angle, positive turns the ship to starboard"),
            "n": ("1/s", "propeller revolutions per second"),
        }
    )
    """Unit of each channel, and what it is."""
    NO_BOTTOM: ClassVar[str] = (
        "The model does not feel the bottom: the depth changes nothing without a part "
        "shallow_water."
    )
    LEVER_HELD: ClassVar[str] = (
        "The lever is held: the propeller keeps the revolutions that hold the speed without waves."
    )
    SPEED_HELD: ClassVar[str] = (
        "The propeller keeps the revolutions that hold the speed of the approach in the waves."
    )
    NO_WAVES: ClassVar[str] = (
        "The model does not feel the waves: they change nothing without a part wave_drift."
    )

    def __len__(self) -> int:
        return len(self.t)

    def at(self, places: NDArray[np.bool_] | slice) -> Self:
        """The track at some of its instants.

        Examples
        --------
        >>> from pmmkit.simulation.single import simulate
        >>> turn = simulate("kcs", speed=12.35, duration=60.0, dt=1.0)
        >>> turn.at(turn.t > 58.0).t
        array([59., 60.])
        """
        kept: dict[str, Any] = {"forces": {name: x[:, places] for name, x in self.forces.items()}}
        for item in fields(self):
            values = getattr(self, item.name)
            if isinstance(values, np.ndarray):
                kept[item.name] = values[places]
        return replace(self, **kept)

    @property
    def ordered(self) -> Self:
        """The track from the order on, without the approach that a measured one may have."""
        return self.at(self.t >= 0.0)

    def resized(self, L: float, speed: float) -> Self:
        """The track of a ship of another length [m] and approach speed [m/s], the same in ship
        lengths."""
        length, pace = L / self.L, speed / self.speed
        time = length / pace
        heavy = (length * pace) ** 2 * np.array([[1.0], [1.0], [length]])
        return replace(
            self,
            forces={name: heavy * x for name, x in self.forces.items()},
            L=L,
            speed=speed,
            t=self.t * time,
            x=self.x * length,
            y=self.y * length,
            u=self.u * pace,
            v=self.v * pace,
            r=self.r / time,
            p=self.p / time,
            n=self.n / time,
            orders=tuple(t * time for t in self.orders),
            metrics=self.scaled(self.metrics, length, pace),
        )

    @staticmethod
    def scaled(values: Mapping[str, float], length: float, pace: float) -> Mapping[str, float]:
        """Numbers of a manoeuvre of which lengths and speeds are so many times as large.

        Examples
        --------
        >>> Track.scaled({"advance": 3.0, "advance_L": 3.0, "time_90": 1.0}, 4.0, 2.0)
        {'advance': 12.0, 'advance_L': 3.0, 'time_90': 2.0}
        """
        time = length / pace
        factors = {"m": length, "s": time, "deg/s": 1.0 / time, "m/s": pace}
        return {
            name: x * factors.get(Metric.of(name).unit_of(name), 1.0) for name, x in values.items()
        }

    @property
    def circle(self) -> dict[str, float]:
        """The measures of a turning circle in ship lengths, those that there are."""
        return {name: self.metrics[name] for name in LENGTHS if name in self.metrics}

    @property
    def unfelt(self) -> tuple[str, ...]:
        """What of the water was asked for, and changes nothing of such a model."""
        return tuple(note for note in self.notes if note in (self.NO_BOTTOM, self.NO_WAVES))

    def to_xarray(self) -> xr.Dataset:
        """The channels over t, with units, and the metrics as attributes."""
        import xarray as xr

        attributes: dict[str, Any] = {
            "name": self.name,
            "manoeuvre": self.manoeuvre,
            "L": self.L,
            "speed": self.speed,
            "Fn": self.Fn,
            "rudder_deg": self.rudder_deg,
            "scale": self.scale,
            **self.metrics,
        }
        return xr.Dataset(
            {
                name: ("t", getattr(self, name), {"units": unit, "long_name": text})
                for name, (unit, text) in self.CHANNELS.items()
            },
            coords={"t": ("t", self.t, {"units": "s", "long_name": "time from the rudder order"})},
            attrs=attributes,
        )

    def to_pandas(self) -> pd.DataFrame:
        """The channels in columns, t first."""
        import pandas as pd

        return pd.DataFrame({"t": self.t, **{name: getattr(self, name) for name in self.CHANNELS}})

    def forces_to_pandas(self) -> pd.DataFrame:
        """X, Y [N] and N [N m] about midship of each effect in columns, t first; empty unless
        `simulate` was asked for forces."""
        import pandas as pd

        columns = {
            f"{channel}_{effect}": row
            for effect, own in self.forces.items()
            for channel, row in zip("XYN", own, strict=True)
        }
        return pd.DataFrame({"t": self.t, **columns} if columns else {})

    def to_csv(self) -> str:
        """The channels in columns, t first, with the fewest digits that give the same floats."""
        columns = [self.t.tolist(), *(getattr(self, name).tolist() for name in self.CHANNELS)]
        head = ",".join(["t", *self.CHANNELS])
        lines = [",".join(map(repr, row)) for row in zip(*columns, strict=True)]
        return "\n".join([head, *lines]) + "\n"

    def figures(self) -> dict[str, Figure]:
        """The figures that show the manoeuvre, by the name of their file.

        As the manoeuvre declares: a turning circle gives ``trajectory`` and ``histories``; and
        ``forces`` of each effect where the track keeps them.
        """
        from pmmkit.plotting import manoeuvre

        known = self._known()
        return manoeuvre([self], known.drawn if known else "path", called=CATALOGUE.title_of)

    def plot(self) -> Figure:
        """The first of the figures that show the manoeuvre."""
        return next(iter(self.figures().values()))

    def animate(
        self,
        path: str | Path,
        *,
        frames: int = 100,
        fps: int = 10,
        progress: Progress | None = None,
    ) -> Path:
        """Write the manoeuvre as an animation, all or nothing.

        On the left the ship goes along her path, to scale, with her rudder. On the right she is
        seen from above in her own axes, where arrows show the forces of each effect if the track
        keeps them: ``simulate(…, forces=True)``. Such an arrow begins where its force acts along
        the ship, N/Y.

        Parameters
        ----------
        path : path
            A file ``.gif``, or ``.mp4`` where the program ffmpeg is installed.
        frames : int
            Pictures, at equal steps from the first instant to the last.
        fps : int
            Pictures in a second; a GIF counts in hundredths of a second.
        progress : Progress, optional
            Told how many pictures are drawn.

        Returns
        -------
        Path
            The file.

        Raises
        ------
        DataError
            If the name has another ending, ffmpeg is not found, or there are no two frames.

        Examples
        --------
        >>> import tempfile
        >>> from pmmkit.simulation.single import simulate
        >>> turn = simulate("kcs", speed=12.35, duration=60.0, forces=True)
        >>> turn.animate(Path(tempfile.mkdtemp()) / "turn.gif", frames=2).name
        'turn.gif'
        """
        from pmmkit.plotting import animate

        called = CATALOGUE.title_of
        return animate(self, path, frames=frames, fps=fps, called=called, progress=progress)

    def _headline(self) -> str:
        angle = f" {self.rudder_deg:.1f}°" if self.rudder_deg else ""
        return (
            f"{self.manoeuvre.replace('_', ' ')}{angle} of {self.name} at {self.speed:.2f} m/s: "
            f"{len(self)} instants, {self.t[-1] - self.t[0]:.0f} s"
        )

    def _sections(self) -> Sequence[Section]:
        told = [
            f"L = {self.L:g} m, Fn {self.Fn:.3f}; {self.scale or 'no scale is stated'}",
            *(f"{name} = {value}" for name, value in self.settings.items()),
            *self.standing.sentences,
        ]
        missing = [
            name for name in METRICS.in_lengths(self.metrics) if not np.isfinite(self.metrics[name])
        ]
        points = [f"The track does not show: {', '.join(missing)}"] if missing else []
        points += self.notes
        return [
            Section(paragraphs=told),
            *([Section(title="Metrics", tables=[self._metrics()])] if self.metrics else []),
            Section(title="Channels", tables=[self._channels()]),
            *([Section(title="Notes", points=points)] if points else []),
        ]

    def _metrics(self) -> Grid:
        known = self._known()
        entries = known.metrics if known else tuple(METRICS.values())
        rows = []
        for name, value in self.metrics.items():
            bare = name.removesuffix(Metric.IN_LENGTHS)
            if bare != name and bare in self.metrics:
                continue
            lengths = self.metrics.get(name + Metric.IN_LENGTHS)
            beside = "" if lengths is None else f"{number(lengths)} L"
            rows.append([name, number(value), _unit(name, entries), beside])
        return Grid(head=["", "value", "unit", ""], groups=[Group(rows=rows)], texts=(2,))

    def _channels(self) -> Grid:
        rows = []
        for name, (unit, text) in self.CHANNELS.items():
            values = getattr(self, name)
            ends = (values[0], values.min(), values.max(), values[-1])
            rows.append([name, unit, *(number(x) for x in ends), text])
        head = ["", "unit", "start", "least", "most", "end", ""]
        return Grid(head=head, groups=[Group(rows=rows)], texts=(1, 6))

    def _known(self) -> Manoeuvre | None:
        """The manoeuvre among those that pmmkit and other packages define."""
        from pmmkit.simulation.kinds.catalogue import manoeuvre_of

        try:
            return manoeuvre_of(self.manoeuvre)
        except UnknownNameError:
            return None


def _unit(name: str, known: tuple[Metric, ...]) -> str:
    """Unit of a number; empty for one that a user brings along."""
    try:
        return Metric.of(name, known).unit_of(name)
    except UnknownNameError:
        return ""
