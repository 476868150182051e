"""Sweeps: the metrics of a manoeuvre over speed, rudder angle, depth, loading …"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from concurrent.futures import Executor
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from pmmkit.base import DataError, Problem, Remedy, Way, Workers, each, opened
from pmmkit.conventions import Metric
from pmmkit.models import Model, load_model
from pmmkit.simulation.ensemble import monte_carlo
from pmmkit.simulation.kinds.catalogue import manoeuvre_of
from pmmkit.simulation.kinds.manoeuvre import Manoeuvre
from pmmkit.simulation.single import simulate

if TYPE_CHECKING:
    import xarray as xr


SHARES: Final = ("share_below", "share_above")
"""Of a manoeuvre outside of the tested range, where derivatives follow the speed."""
_UNITS: Final = {
    "depth": "m",
    "wave_height": "m",
    "rudder_rate_deg": "deg/s",
    "rudder_lag": "s",
    "dt": "s",
    "revolutions": "1/s",
    "rtol": "-",
}
"""Units of settings of `simulate`; the others are speeds or angles."""


def froude_sweep(
    model: Model | str | Path,
    speeds: Sequence[float] | None = None,
    manoeuvre: str | Manoeuvre = "turning",
    *,
    Fn: Sequence[float] | None = None,
    n: int = 0,
    spread: float | None = None,
    seed: int = 0,
    executor: Workers = None,
    **settings: Any,
) -> xr.Dataset:
    """Metrics of a manoeuvre over the approach speed, with intervals if asked for.

    Parameters
    ----------
    model : Model, str or path
        A model, a library name or a file.
    speeds : sequence of float, optional
        Approach speeds [m/s]. Without `speeds` and `Fn` the Froude numbers of the model's values
        are taken.
    manoeuvre : str or Manoeuvre
        As for `simulate`.
    Fn : sequence of float, optional
        Froude numbers instead of `speeds`.
    n : int
        Ships drawn at each speed for 95 % intervals; 0 for none.
    spread, seed, executor
        As for `monte_carlo`; an executor is given the rows.
    **settings
        Handed on to `simulate`.

    Returns
    -------
    xarray.Dataset
        A variable per metric over ``Fn``, with ``speed`` [m/s] beside it; with `n` also
        ``<metric>_low`` and ``<metric>_high``; with ``fn="instant"`` also ``share_below`` and
        ``share_above``, the shares of the manoeuvre outside of the tested range.

    Raises
    ------
    DataError
        If both `speeds` and `Fn` are given, or neither and the model has one set for all speeds.

    Examples
    --------
    >>> found = froude_sweep("s175-3dof", [6.0, 12.0])
    >>> found.steady_diameter_L.round(3).values
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
    sailed = manoeuvre_of(manoeuvre)
    cases = [(loaded, {"speed": float(speed), **settings}) for speed in asked]
    rows = _rows(cases, sailed, executor, n=n, spread=spread, seed=seed)
    numbers = [loaded.ship.froude(float(speed), loaded.water.g) for speed in asked]
    return xr.Dataset(
        _variables("Fn", rows, sailed),
        coords={
            "Fn": ("Fn", np.array(numbers)),
            "speed": ("Fn", np.array([float(speed) for speed in asked]), {"units": "m/s"}),
        },
        attrs={
            "name": loaded.name,
            "manoeuvre": sailed.name,
            "scale": loaded.scale,
            **{name: x for name, x in settings.items() if isinstance(x, (int, float, str))},
        },
    )


def sweep(
    model: Model | str | Path | Mapping[Any, Model | str | Path],
    over: str,
    values: Sequence[float] | None = None,
    manoeuvre: str | Manoeuvre = "turning",
    *,
    n: int = 0,
    spread: float | None = None,
    seed: int = 0,
    executor: Workers = None,
    **settings: Any,
) -> xr.Dataset:
    """Metrics of a manoeuvre over any of its settings, or over several models.

    Parameters
    ----------
    model : Model, str, path, or a mapping of them
        A mapping, e.g. of loading conditions or of depths, with ``over="model"``.
    over : str
        A setting of `simulate` or of the manoeuvre: ``rudder_deg``, ``depth``, ``wind_speed``,
        ``switch_deg``, ``speed`` …, or ``model``.
    values : sequence of float, optional
        Values of that setting.
    manoeuvre : str or Manoeuvre
        As for `simulate`.
    n, spread, seed, executor
        As for `froude_sweep`.
    **settings
        Handed on to `simulate`.

    Returns
    -------
    xarray.Dataset
        A variable per metric over the setting, and more as in `froude_sweep`.

    Raises
    ------
    DataError
        If there is nothing to sweep over.

    Examples
    --------
    >>> found = sweep("s175-3dof", "rudder_deg", [10, 20, 35], speed=9.0)
    >>> found.tactical_diameter_L.round(2).values
    array([9.06, 6.14, 4.35])
    """
    import xarray as xr

    if isinstance(model, Mapping):
        if over != "model" or not model:
            raise DataError(
                Problem(
                    message="There are several models.",
                    remedy=Remedy("Sweep over them: {}.", (Way('over="model"', "--over model"),)),
                )
            )
        cases: list[tuple[Any, Any, dict[str, Any]]] = [
            (label, item, dict(settings)) for label, item in model.items()
        ]
    else:
        if values is None or len(values) == 0:
            raise DataError(f"Give the values of {over}.")
        cases = [(float(x), model, {**settings, over: float(x)}) for x in values]
    sailed = manoeuvre_of(manoeuvre)
    loaded = [item if isinstance(item, Model) else load_model(item) for _, item, _ in cases]
    asked = [(item, given) for item, (_, _, given) in zip(loaded, cases, strict=True)]
    rows = _rows(asked, sailed, executor, n=n, spread=spread, seed=seed)
    return xr.Dataset(
        _variables(over, rows, sailed),
        coords={over: (over, np.array([label for label, _, _ in cases]), _with_unit(over, sailed))},
        attrs={
            "name": ", ".join(dict.fromkeys(item.name for item in loaded)),
            "manoeuvre": sailed.name,
            "scale": "; ".join(dict.fromkeys(item.scale for item in loaded)),
        },
    )


def _rows(
    cases: Sequence[tuple[Model, dict[str, Any]]],
    manoeuvre: Manoeuvre,
    executor: Workers,
    **draws: Any,
) -> list[dict[str, float]]:
    """A row for each model with its settings."""
    with opened(executor) as ready:
        sent = isinstance(ready, Executor)
        row = partial(_row, manoeuvre, **draws)
        found = each(
            partial(row, threads=1),
            cases,
            ready if sent else None,
            names=[f"{model.name}, {given}" for model, given in cases],
            here=partial(row, threads=None if sent else ready),
        )
        done = dict(found)
    return [done[place] for place in range(len(cases))]


def _row(
    manoeuvre: Manoeuvre,
    case: tuple[Model, dict[str, Any]],
    *,
    n: int,
    spread: float | None,
    seed: int,
    threads: int | None,
) -> dict[str, float]:
    model, given = case
    track = simulate(model, manoeuvre, **given)
    row = dict(track.metrics)
    if n:
        plain = {name: x for name, x in given.items() if name not in ("compiled", "dt")}
        many = monte_carlo(
            model, manoeuvre, n=n, spread=spread, seed=seed, executor=threads, **plain
        )
        for name in tuple(row):
            row[f"{name}_low"], row[f"{name}_high"] = many.interval(name)
    if given.get("fn") == "instant":
        row |= {name: getattr(track.tested, name, math.nan) for name in SHARES}
    return row


def _variables(
    over: str, rows: Sequence[Mapping[str, float]], manoeuvre: Manoeuvre
) -> dict[str, Any]:
    def unit(column: str) -> str:
        if column in SHARES:
            return "-"
        plain = column.removesuffix("_low").removesuffix("_high")
        return Metric.of(plain, manoeuvre.metrics).unit_of(plain, lengths="-")

    return {
        name: (over, np.array([row[name] for row in rows]), {"units": unit(name)})
        for name in rows[0]
    }


def _with_unit(over: str, manoeuvre: Manoeuvre) -> dict[str, str]:
    if over == "model":
        return {}
    units = _UNITS | {setting.name: setting.unit for setting in manoeuvre.settings}
    return {"units": units.get(over, "m/s" if "speed" in over else "deg")}
