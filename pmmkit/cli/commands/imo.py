"""``pmmkit imo``."""

from __future__ import annotations

from dataclasses import asdict
from typing import Annotated, Final

import typer

from pmmkit.cli.options import Depth, Extrapolate, Follow, Model, Spread, stem
from pmmkit.cli.output import Outcome
from pmmkit.cli.outputs import Out, results_folder
from pmmkit.cli.speeds import Speed, approach
from pmmkit.presentation import text_of

EXAMPLE: Final = "pmmkit imo kvlcc2 --speed 8 --spread 0.05"


def imo(
    model: Model,
    speed: Speed = None,
    ships: Annotated[int, typer.Option(help="Ships drawn for the probability of passing.")] = 2000,
    spread: Spread = None,
    astern: Annotated[
        float | None,
        typer.Option(
            max=-0.01,
            help="Revolutions of the full astern stop over those of the approach, such as -0.6; "
            "the standard does not say them. -0.7 if absent.",
        ),
    ] = None,
    fn: Follow = "approach",
    depth: Depth = None,
    extrapolate: Extrapolate = False,
    out: Out = None,
) -> Outcome:
    """Judge a ship by every criterion of IMO MSC.137(76), to both sides."""
    import pandas as pd

    from pmmkit.files import write_results
    from pmmkit.models import load_model
    from pmmkit.simulation.imo import imo_verdicts, verdict_sections

    folder = results_folder(out, f"{stem(model)}-imo")
    loaded = load_model(model)
    pace = approach(speed, loaded)
    found = imo_verdicts(
        loaded,
        pace,
        n=ships,
        spread=spread,
        astern=astern,
        fn=fn,
        depth=depth,
        extrapolate=extrapolate,
    )
    rows = [asdict(item) for item in found]
    table = pd.DataFrame([{**row, "conditions": " ".join(row["conditions"])} for row in rows])
    files = write_results(folder, [("imo.json", rows), ("imo.csv", table)])
    lines = [
        f"{loaded.name}, {pace:g} m/s (Fn {loaded.ship.froude(pace, loaded.water.g):.3f})",
        text_of(verdict_sections(found)),
        "",
        f"Results: {folder}",
    ]
    return Outcome(content={"out": str(folder), "files": files, "verdicts": rows}, lines=lines)
