"""``pmmkit imo``."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Annotated, Final

import typer

from pmmkit.cli.options import Depth, Extrapolate, Follow, Form, Model, Spread, stem
from pmmkit.cli.output import Outcome, marked
from pmmkit.cli.outputs import Out, results_folder
from pmmkit.cli.speeds import Speed, approach
from pmmkit.presentation import counted, text_of

if TYPE_CHECKING:
    import pandas as pd

    from pmmkit.simulation import Verdict

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
    reversal: Annotated[
        float | None,
        typer.Option(
            min=0.1,
            help="Seconds from the order astern until those revolutions are reached; a model's own "
            "shaft lags behind it. If absent they fall to zero in two ship lengths over the "
            "speed and go on at that rate.",
        ),
    ] = None,
    torque: Annotated[
        float | None,
        typer.Option(
            min=0.01,
            help="Largest torque astern over that of the approach, such as 0.8; as much as the "
            "revolutions need if absent.",
        ),
    ] = None,
    form: Form = None,
    fn: Follow = "approach",
    depth: Depth = None,
    extrapolate: Extrapolate = False,
    out: Out = None,
) -> Outcome:
    """Judge a ship by every criterion of IMO MSC.137(76), to both sides."""
    from pmmkit.files import write_results
    from pmmkit.models import load_model
    from pmmkit.simulation import imo_verdicts, verdict_sections
    from pmmkit.views import PAGE, form_files, form_of_model, read_stated

    folder = results_folder(out, f"{stem(model)}-imo")
    loaded = load_model(model)
    pace = approach(speed, loaded)
    stated = {} if form is None else read_stated(form)
    found = imo_verdicts(
        loaded,
        pace,
        n=ships,
        spread=spread,
        astern=astern,
        reversal=reversal,
        torque=torque,
        full_speed=stated.get("speed_85"),
        full_draught=stated.get("full_load_draught"),
        fn=fn,
        depth=depth,
        extrapolate=extrapolate,
    )
    rows = [item.to_dict() for item in found]
    filled = form_of_model(loaded, found, speed=pace, stated=stated, depth=depth)
    files = write_results(
        folder, [("imo.json", rows), ("imo.csv", _table(found)), *form_files(filled)]
    )
    lines = [
        f"{loaded.name}, {pace:g} m/s (Fn {loaded.ship.froude(pace, loaded.water.g):.3f})",
        text_of(verdict_sections(found)),
        "",
        f"Form: {folder / PAGE}, with {counted(len(filled.not_supplied), 'field')} not supplied",
        f"Results: {folder}",
    ]
    return marked(
        Outcome(content={"out": str(folder), "files": files, "verdicts": rows}, lines=lines), loaded
    )


def _table(found: Sequence[Verdict]) -> pd.DataFrame:
    """The verdicts as a table, sentences in one cell."""
    import pandas as pd

    rows = [
        {
            **item.to_dict(),
            "unsettled": " ".join(item.unsettled),
            "conditions": " ".join(item.conditions),
            "full_astern": "" if item.full_astern is None else item.full_astern.words,
        }
        for item in found
    ]
    return pd.DataFrame(rows)
