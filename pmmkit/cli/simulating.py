"""The work behind the commands that simulate."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from pmmkit.cli.console import Outcome, aligned
from pmmkit.cli.tracks import check_folder, metrics_of, sweep_rows, write_sweep, write_track
from pmmkit.model import load_model
from pmmkit.simulation.imo import imo_turning
from pmmkit.simulation.simulate import simulate


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


def sweep(model: str, out: Path, *, speeds: Sequence[float] | None, rudder_deg: float) -> Outcome:
    """Measures of the turning circle over the approach speed.

    Parameters
    ----------
    model : str
        Library ship or model file.
    out : Path
        The folder of the results.
    speeds : sequence of float, optional
        Approach speeds [m/s].
    rudder_deg : float
        Rudder angle [deg].

    Returns
    -------
    Outcome
        With a row per speed.
    """
    check_folder(out)
    loaded = load_model(model)
    from pmmkit.simulation.sweeps import froude_sweep

    found = froude_sweep(loaded, speeds, rudder_deg=rudder_deg, compiled=False)
    files = write_sweep({loaded.name: found}, out)
    rows = sweep_rows(found)
    names = ["Fn", "speed", "advance_L", "transfer_L", "tactical_diameter_L", "steady_diameter_L"]
    cells = [[f"{row[name]:.4g}" for name in names] for row in rows]
    lines = [f"Scale: {loaded.scale}", aligned(names, cells), f"Results: {out}"]
    return Outcome(content={"out": str(out), "files": files, "sweep": rows}, lines=lines)
