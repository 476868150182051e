"""``pmmkit imo``."""

from __future__ import annotations

import math
from dataclasses import asdict
from typing import TYPE_CHECKING, Annotated

import typer

from pmmkit.cli.options import Depth, Extrapolate, Model, Out, Speed, Spread, results_folder, stem
from pmmkit.cli.output import Outcome
from pmmkit.presentation import aligned

if TYPE_CHECKING:
    from pmmkit.simulation.imo import Verdict


def imo(
    model: Model,
    speed: Speed,
    ships: Annotated[int, typer.Option(help="Ships drawn for the probability of passing.")] = 2000,
    spread: Spread = None,
    depth: Depth = None,
    extrapolate: Extrapolate = False,
    out: Out = None,
) -> Outcome:
    """Judge a ship by every criterion of IMO MSC.137(76), to both sides."""
    import pandas as pd

    from pmmkit.files import write_results
    from pmmkit.models import load_model
    from pmmkit.simulation.imo import SOURCE, imo_verdicts

    folder = results_folder(out, f"{stem(model)}-imo")
    loaded = load_model(model)
    found = imo_verdicts(
        loaded, speed, n=ships, spread=spread, depth=depth, extrapolate=extrapolate
    )
    rows = [asdict(item) for item in found]
    table = pd.DataFrame([{**row, "conditions": " ".join(row["conditions"])} for row in rows])
    files = write_results(folder, [("imo.json", rows), ("imo.csv", table)])
    lines = [
        f"{loaded.name}, {speed:g} m/s (Fn {loaded.ship.froude(speed, loaded.water.g):.3f}), "
        f"criteria of {SOURCE}",
        f"Scale: {found[0].scale}",
        aligned(
            ["criterion", "manoeuvre", "value", "limit", "margin", "", "probability"],
            [_verdict_row(item) for item in found],
        ),
        *dict.fromkeys(text for item in found for text in item.conditions),
        f"Results: {folder}",
    ]
    return Outcome(content={"out": str(folder), "files": files, "verdicts": rows}, lines=lines)


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
