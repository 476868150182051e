"""The work behind the commands that judge a model."""

from __future__ import annotations

import math
from dataclasses import asdict
from pathlib import Path
from typing import Any, Final

import numpy as np

from pmmkit.cli.console import Outcome, json_text
from pmmkit.cli.tracks import check_folder
from pmmkit.errors import UnknownNameError
from pmmkit.files import atomic_folder
from pmmkit.models import load_model
from pmmkit.presentation import aligned
from pmmkit.progress import shown
from pmmkit.simulation.imo import SOURCE, Verdict, imo_verdicts
from pmmkit.simulation.linear import stability as stability_of

SHOWN: Final = 3
"""Metrics drawn as distributions."""
LISTED: Final = 10
"""Derivatives listed."""


def imo(model: str, out: Path, *, speed: float, ships: int, **settings: Any) -> Outcome:
    """Judge a model by the criteria of the IMO.

    Parameters
    ----------
    model : str
        Library ship or model file.
    out : Path
        Folder for ``imo.csv`` and ``imo.json``.
    speed : float
        Approach speed [m/s].
    ships : int
        Ships drawn.
    **settings
        As for `imo_verdicts`.

    Returns
    -------
    Outcome
        With a verdict per criterion and side.
    """
    check_folder(out)
    loaded = load_model(model)
    found = imo_verdicts(loaded, speed, n=ships, **settings)
    rows = [asdict(item) for item in found]
    with atomic_folder(out) as folder:
        (folder / "imo.json").write_text(json_text(rows) + "\n", encoding="utf-8")
        _frame(rows).to_csv(folder / "imo.csv", index=False)
        files = sorted(file.name for file in folder.iterdir())
    conditions = dict.fromkeys(text for item in found for text in item.conditions)
    lines = [
        f"{loaded.name}, {speed:g} m/s (Fn {loaded.ship.froude(speed, loaded.water.g):.3f}), "
        f"criteria of {SOURCE}",
        f"Scale: {found[0].scale}",
        aligned(
            ["criterion", "manoeuvre", "value", "limit", "margin", "", "probability"],
            [_verdict_row(item) for item in found],
        ),
        *conditions,
        f"Results: {out}",
    ]
    return Outcome(content={"out": str(out), "files": files, "verdicts": rows}, lines=lines)


def _verdict_row(item: Verdict) -> list[str]:
    word = {True: "met", False: "NOT met", None: "not judged"}[item.passed]
    unit = " L" if item.unit == "L" else "°"
    return [
        item.criterion.replace("_", " "),
        item.manoeuvre,
        f"{item.value:.2f}{unit}" if math.isfinite(item.value) else "-",
        f"{item.limit:.4g}{unit}",
        f"{item.margin:+.2f}" if math.isfinite(item.margin) else "-",
        word,
        "-" if item.probability is None else f"{100 * item.probability:.1f} %",
    ]


def _frame(rows: list[dict[str, Any]]) -> Any:
    import pandas as pd

    return pd.DataFrame([{**row, "conditions": " ".join(row["conditions"])} for row in rows])


def stability(
    model: str, out: Path, *, speed: float, depth: float | None, extrapolate: bool
) -> Outcome:
    """Straight-line stability of a model, and its steady turns.

    Parameters
    ----------
    model : str
        Library ship or model file.
    out : Path
        Folder for ``stability.json``, ``spiral.csv`` and ``spiral.svg``.
    speed : float
        [m/s]
    depth : float, optional
        Of the water [m].
    extrapolate : bool
        Allow a speed outside the tested range.

    Returns
    -------
    Outcome
        With the numbers.
    """
    check_folder(out)
    from pmmkit.simulation.spiral import spiral_curve

    loaded = load_model(model)
    found = stability_of(loaded, speed, depth=depth, extrapolate=extrapolate)
    curve = spiral_curve(loaded, speed, depth=depth, extrapolate=extrapolate)
    numbers = {
        "name": found.name,
        "speed": speed,
        "stable": found.stable,
        "side": found.side,
        "C": found.C,
        "lever_sway": found.lever_sway,
        "lever_yaw": found.lever_yaw,
        "K": found.K,
        "T": found.T,
        "T1": found.T1,
        "T2": found.T2,
        "T3": found.T3,
        "Ydelta": found.rudder[0],
        "Ndelta": found.rudder[1],
        "eigenvalues": [[x.real, x.imag] for x in found.eigenvalues.tolist()],
        "loop_width_deg": curve.loop_width_deg,
        "loop_height_deg_s": curve.loop_height_deg_s,
        "neutral_deg": curve.neutral_deg,
        "scale": loaded.scale,
    }
    with atomic_folder(out) as folder:
        (folder / "stability.json").write_text(json_text(numbers) + "\n", encoding="utf-8")
        curve.to_pandas().to_csv(folder / "spiral.csv", index=False)
        from pmmkit import figures

        figures.save(figures.steady_turns(curve), folder / "spiral.svg")
        files = sorted(file.name for file in folder.iterdir())
    word = "stable" if found.stable else "UNSTABLE"
    if found.side != "both":
        word += f" (turning to {found.side}, the less stable side)"
    loop = (
        f"The spiral has a loop {curve.loop_width_deg:.2f}° wide and "
        f"{curve.loop_height_deg_s:.3f}°/s high about a rudder of {curve.neutral_deg:+.2f}°."
        if curve.loop_width_deg > 0
        else f"The spiral has no loop; the ship runs straight at {curve.neutral_deg:+.2f}°."
    )
    names = ("C", "lever_sway", "lever_yaw", "K", "T", "T1", "T2", "T3", "Ydelta", "Ndelta")
    lines = [
        f"{found.name} at {speed:g} m/s is straight-line {word}.",
        aligned(["number (prime system)", "value"], [[x, f"{numbers[x]:.4g}"] for x in names]),
        "Eigenvalues [U/L]: " + ", ".join(f"{x:.4g}" for x in found.eigenvalues.tolist()),
        loop,
        f"Results: {out}",
    ]
    return Outcome(content={"out": str(out), "files": files, **numbers}, lines=lines)


def uncertainty(
    model: str,
    out: Path,
    *,
    speed: float,
    manoeuvre: str,
    metric: str | None,
    ships: int,
    spread: float | None,
    seed: int,
    **settings: Any,
) -> Outcome:
    """How the metrics of a manoeuvre spread, and why.

    Parameters
    ----------
    model : str
        Library ship or model file.
    out : Path
        Folder for ``metrics.csv``, ``causes.csv`` and figures.
    speed, manoeuvre, spread, seed
        As for `monte_carlo`.
    metric : str, optional
        Whose causes are listed; the tactical diameter, or the first of the manoeuvre.
    ships : int
        Number of ships.
    **settings
        Of the manoeuvre.

    Returns
    -------
    Outcome
        With intervals and causes.
    """
    check_folder(out)
    from pmmkit.simulation.ensemble import monte_carlo
    from pmmkit.simulation.sensitivity import sensitivities

    loaded = load_model(model)
    with shown() as progress:
        many = monte_carlo(
            loaded,
            manoeuvre,
            speed=speed,
            n=ships,
            spread=spread,
            seed=seed,
            progress=progress,
            **settings,
        )
    told = [
        name for name in many.metrics if not name.endswith("_L") and f"{name}_L" in many.metrics
    ]
    names = [name for name in many.metrics if name not in told]
    chosen = metric or ("tactical_diameter_L" if "tactical_diameter_L" in names else names[0])
    if chosen not in many.metrics:
        raise UnknownNameError(
            f"{manoeuvre} has no metric {chosen!r}; it has {', '.join(many.metrics)}."
        )
    found = sensitivities(loaded, manoeuvre, speed=speed, spread=spread, **settings)
    summary, causes = many.summary(), found.table(chosen)
    drawn = [chosen, *[name for name in names if name != chosen and _varies(many.metrics[name])]]
    with atomic_folder(out) as folder:
        summary.to_csv(folder / "metrics.csv")
        causes.to_csv(folder / "causes.csv")
        from pmmkit import figures

        figures.save(figures.distributions(many, drawn[:SHOWN]), folder / "distributions.svg")
        figures.save(figures.importance(found, chosen), folder / "causes.svg")
        files = sorted(file.name for file in folder.iterdir())
    columns = ["nominal", "std", "low", "high"]
    lines = [
        f"{many.name}, {manoeuvre.replace('_', ' ')}, {speed:g} m/s (Fn {many.Fn:.3f}): {ships} "
        f"ships drawn from {many.origin}; {many.failed} could not be simulated.",
        f"Scale: {many.scale}",
        aligned(
            ["metric", "as it is", "std", "2.5 %", "97.5 %"],
            [[name, *(f"{x:.4g}" for x in summary.loc[name, columns])] for name in names],
        ),
        f"What decides {chosen}:",
        aligned(
            ["derivative", "share of the variance", "% per %"],
            [
                [
                    str(name),
                    f"{100 * row['share_of_variance']:.1f} %",
                    f"{row['per_cent_per_per_cent']:+.2f}",
                ]
                for name, row in causes.head(LISTED).iterrows()
            ],
        ),
        f"Results: {out}",
    ]
    content = {
        "out": str(out),
        "files": files,
        "name": many.name,
        "manoeuvre": manoeuvre,
        "speed": speed,
        "ships": ships,
        "failed": many.failed,
        "origin": many.origin,
        "scale": many.scale,
        "metric": chosen,
        "metrics": summary.to_dict("index"),
        "causes": causes.to_dict("index"),
    }
    return Outcome(content=content, lines=lines)


def _varies(values: np.ndarray) -> bool:
    there = values[np.isfinite(values)]
    return len(there) > 1 and float(np.ptp(there)) > 0.0
