"""The work behind the commands that simulate."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from pmmkit.cli.console import Outcome
from pmmkit.cli.tracks import check_folder, metrics_of, sweep_rows, write_sweep, write_track
from pmmkit.models import load_model
from pmmkit.presentation import aligned
from pmmkit.simulation.imo import imo_turning
from pmmkit.simulation.simulate import simulate

if TYPE_CHECKING:
    import xarray as xr

MOST: Final = 5
"""Metrics in a table for the screen."""


def simulate_manoeuvre(model: str, out: Path, *, drawn: bool = True, **settings: Any) -> Outcome:
    """Simulate and write a manoeuvre.

    Parameters
    ----------
    model : str
        Library ship or model file.
    out : Path
        The folder of the results.
    drawn : bool
        Whether to draw figures, which takes most of the time.
    **settings
        As for `simulate`.

    Returns
    -------
    Outcome
        With the metrics.
    """
    check_folder(out)
    track = simulate(model, compiled=False, **settings)
    files = write_track(track, out, drawn=drawn)
    metrics = metrics_of(track)
    rows = [[name, f"{value:.4g}"] for name, value in track.metrics.items() if not np.isnan(value)]
    verdicts = imo_turning(track) if track.manoeuvre == "turning" else []
    limits = [
        f"IMO {item.criterion.replace('_', ' ')}: {item.value:.2f} L, limit {item.limit:g} L, "
        f"{'met' if item.passed else 'not reached' if item.passed is None else 'NOT met'}"
        for item in verdicts
    ]
    lines = [
        f"{track.name}, {track.manoeuvre.replace('_', ' ')}, {track.rudder_deg:+g}° of rudder, "
        f"{track.speed:g} m/s (Fn {track.Fn:.3f})",
        f"Scale: {track.scale}",
        aligned(["metric", "value"], rows),
        *limits,
        *track.notes,
        f"Results: {out}",
    ]
    return Outcome(content={"out": str(out), "files": files, **metrics}, lines=lines)


def sweep(
    model: str,
    out: Path,
    *,
    speeds: Sequence[float] | None,
    over: str | None,
    values: Sequence[float] | None,
    manoeuvre: str,
    ships: int,
    **settings: Any,
) -> Outcome:
    """Metrics of a manoeuvre over the approach speed, or over one of its settings.

    Parameters
    ----------
    model : str
        Library ship or model file.
    out : Path
        The folder of the results.
    speeds : sequence of float, optional
        Approach speeds [m/s]; one where `over` is given.
    over : str, optional
        What is varied in place of the speed.
    values : sequence of float, optional
        Its values.
    manoeuvre : str
        As for `simulate`.
    ships : int
        Ships drawn per value.
    **settings
        Of the manoeuvre and of the draws.

    Returns
    -------
    Outcome
        With a row per value.
    """
    check_folder(out)
    loaded = load_model(model)
    from pmmkit.simulation import sweeps

    compiled = ships > 0
    if over is None:
        found = sweeps.froude_sweep(
            loaded, speeds, manoeuvre, n=ships, compiled=compiled, **settings
        )
    else:
        assert speeds is not None
        found = sweeps.sweep(
            loaded, over, values, manoeuvre, n=ships, speed=speeds[0], compiled=compiled, **settings
        )
    metrics = _told(found)
    files = write_sweep(found, metrics, out)
    rows = sweep_rows(found)
    coordinates = [str(name) for name in found.coords]
    cells = [
        [f"{row[name]:.4g}" for name in coordinates] + [_cell(row, name) for name in metrics]
        for row in rows
    ]
    lines = [f"Scale: {loaded.scale}", aligned([*coordinates, *metrics], cells), f"Results: {out}"]
    return Outcome(content={"out": str(out), "files": files, "sweep": rows}, lines=lines)


def _told(found: xr.Dataset) -> list[str]:
    """The metrics worth a column: in ship lengths where they are, without those that stay empty."""
    names = [str(name) for name in found.data_vars if not str(name).endswith(("_low", "_high"))]
    kept = [name for name in names if f"{name}_L" not in names]
    return [name for name in kept if np.any(np.isfinite(found[name].values))][:MOST]


def _cell(row: Mapping[str, Any], name: str) -> str:
    text = f"{row[name]:.4g}"
    if f"{name}_low" not in row:
        return text
    return f"{text} ({row[f'{name}_low']:.4g} to {row[f'{name}_high']:.4g})"
