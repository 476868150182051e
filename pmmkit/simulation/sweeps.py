"""Sweeps: the metrics of a manoeuvre over the Froude number."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from pmmkit.errors import DataError
from pmmkit.model import Model, load_model
from pmmkit.simulation.simulate import simulate

if TYPE_CHECKING:
    import xarray as xr


def froude_sweep(
    model: Model | str | Path,
    speeds: Sequence[float] | None = None,
    manoeuvre: str = "turning",
    *,
    Fn: Sequence[float] | None = None,
    rudder_deg: float = 35.0,
    **settings: Any,
) -> xr.Dataset:
    """Metrics of a manoeuvre over the approach speed.

    Parameters
    ----------
    model : Model, str or path
        A model, a library name or a file.
    speeds : sequence of float, optional
        Approach speeds [m/s]. Without `speeds` and `Fn` the Froude numbers of the model's values
        are taken.
    manoeuvre : str
        As for `simulate`.
    Fn : sequence of float, optional
        Froude numbers instead of `speeds`.
    rudder_deg : float
        Rudder angle [deg].
    **settings
        Handed on to `simulate`.

    Returns
    -------
    xarray.Dataset
        A variable per metric over ``Fn``, with ``speed`` [m/s] beside it.

    Raises
    ------
    DataError
        If both `speeds` and `Fn` are given, or neither and the model has one set for all speeds.

    Examples
    --------
    >>> sweep = froude_sweep("s175-3dof", [6.0, 12.0])
    >>> sweep.steady_diameter_L.round(3).values
    array([3.534, 3.534])
    """
    import xarray as xr

    loaded = model if isinstance(model, Model) else load_model(model)
    if speeds is not None and Fn is not None:
        raise DataError("Give speeds or Fn, not both.")
    numbers = loaded.Fn if Fn is None else Fn
    asked = [loaded.ship.speed(x, loaded.water.g) for x in numbers] if speeds is None else speeds
    if len(asked) == 0:
        raise DataError(
            f"Model {loaded.name!r} has one set of values for all speeds: say which speeds."
        )
    tracks = [
        simulate(loaded, manoeuvre, rudder_deg=rudder_deg, speed=float(speed), **settings)
        for speed in asked
    ]
    names = list(tracks[0].metrics)
    return xr.Dataset(
        {
            name: (
                "Fn",
                np.array([track.metrics[name] for track in tracks]),
                {"units": _unit(name)},
            )
            for name in names
        },
        coords={
            "Fn": ("Fn", np.array([track.Fn for track in tracks])),
            "speed": ("Fn", np.array([track.speed for track in tracks]), {"units": "m/s"}),
        },
        attrs={
            "name": loaded.name,
            "manoeuvre": manoeuvre,
            "rudder_deg": float(rudder_deg),
            "scale": loaded.scale,
        },
    )


def _unit(metric: str) -> str:
    if metric.endswith("_L") or metric == "speed_ratio":
        return "-"
    if metric.endswith("_deg_s"):
        return "deg/s"
    if metric.endswith("_deg"):
        return "deg"
    return "s" if metric.startswith("time") else "m"
