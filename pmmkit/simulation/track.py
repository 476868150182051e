"""Track: a free-running history, simulated or measured."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, Final

from pmmkit.numerics import Array

if TYPE_CHECKING:
    import pandas as pd
    import xarray as xr

CHANNELS: Final[Mapping[str, tuple[str, str]]] = MappingProxyType(
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


@dataclass(frozen=True, kw_only=True, eq=False)
class Track:
    """A free-running history of the midship point, SI and radians.

    Parameters
    ----------
    t : array (m,)
        Time from the rudder order [s].
    x, y, psi : array (m,)
        Path along and to starboard of the approach [m], heading [rad].
    u, v, r, p, phi : array (m,)
        Velocities in ship axes [m/s, rad/s], heel [rad].
    delta, n : array (m,)
        Rudder angle [rad], propeller revolutions per second.
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
        What a reader must know.
    orders : tuple of float
        Instants of the orders [s].
    settings : mapping
        Of the manoeuvre, as they were given.
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

    def __len__(self) -> int:
        return len(self.t)

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
                for name, (unit, text) in CHANNELS.items()
            },
            coords={"t": ("t", self.t, {"units": "s", "long_name": "time from the rudder order"})},
            attrs=attributes,
        )

    def to_pandas(self) -> pd.DataFrame:
        """The channels in columns, t first."""
        import pandas as pd

        return pd.DataFrame({"t": self.t, **{name: getattr(self, name) for name in CHANNELS}})

    def to_csv(self) -> str:
        """The channels in columns, t first, with the fewest digits that give the same floats."""
        columns = [self.t.tolist(), *(getattr(self, name).tolist() for name in CHANNELS)]
        head = ",".join(["t", *CHANNELS])
        lines = [",".join(map(repr, row)) for row in zip(*columns, strict=True)]
        return "\n".join([head, *lines]) + "\n"

    def plot(self) -> Any:
        """The first of the figures that show the manoeuvre."""
        import importlib

        drawn = importlib.import_module("pmmkit.figures").manoeuvre(self)
        return next(iter(drawn.values()))
