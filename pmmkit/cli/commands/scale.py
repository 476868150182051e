"""``pmmkit scale``."""

from __future__ import annotations

from functools import partial
from pathlib import Path
from typing import Annotated, Final

import typer

from pmmkit.cli.options import Data, Model, stated, stem
from pmmkit.cli.output import Outcome, marked
from pmmkit.cli.outputs import Force, Out, results_folder
from pmmkit.cli.speeds import WAYS, TypedSpeed, typed

EXAMPLE: Final = "pmmkit scale kvlcc2-l7 --length 320 --speed 8"


def scale(
    model: Model,
    length: Annotated[float | None, typer.Option("--length", help="Of the ship, m.")] = None,
    like: Annotated[
        Path | None,
        typer.Option(
            help="Campaign of the same hull: its length, mass and water by Froude's law, and the "
            "propeller and rudder that it states."
        ),
    ] = None,
    speed: Annotated[
        TypedSpeed | None,
        typer.Option(
            parser=typed,
            metavar="SPEED",
            help=f"Of the ship at its new length, where the model has one set for all speeds: "
            f"{WAYS}.",
        ),
    ] = None,
    form: Annotated[float | None, typer.Option(help="Form factor k; estimated if absent.")] = None,
    wetted: Annotated[
        float | None, typer.Option(help="Wetted surface of the ship in m²; estimated if absent.")
    ] = None,
    rho: Annotated[float | None, typer.Option(help="Density of the ship's water in kg/m³.")] = None,
    froude_only: Annotated[
        bool, typer.Option("--froude-only", help="Correct neither friction nor wake.")
    ] = False,
    data: Data = None,
    out: Out = None,
    force: Force = False,
) -> Outcome:
    """Carry a model over to ship scale: Froude's law, friction and wake.

    Or, with --like, to the model of another laboratory.
    """
    from pmmkit.api import carried_to
    from pmmkit.campaigns import open_campaign
    from pmmkit.conventions import Water
    from pmmkit.files import MODEL, write_results
    from pmmkit.models import full_scale, load_model, save_model, scaled

    if (length is None) == (like is None):
        raise typer.BadParameter(
            "Say --length, such as --length 320, or --like and a campaign of the same hull."
        )
    target = "ship" if like is None else stem(like)
    folder = results_folder(out, f"{stem(model)}-{target}", read=[model], force=force)
    loaded = load_model(model)
    if like is not None:
        if froude_only or stated(speed=speed, form=form, wetted=wetted, rho=rho):
            raise typer.BadParameter(
                "--like takes all of the campaign: leave out --speed, --form, --wetted, --rho and "
                "--froude-only."
            )
        made = carried_to(loaded, open_campaign(like, data=data))
    else:
        assert length is not None
        made = scaled(loaded, length)
        if not froude_only:
            water = None if rho is None else Water(rho=rho, g=loaded.water.g)
            pace = None if speed is None else speed.of(made.ship, made.water)
            made = full_scale(loaded, length, speed=pace, form=form, wetted=wetted, water=water)
    write_results(folder, [(MODEL.file, partial(save_model, made))])
    steps = list(made.history[len(loaded.history) :])
    steps += [text for text in made.notes if text not in loaded.notes]
    path = str(folder / MODEL.file)
    return marked(
        Outcome(
            content={"out": str(folder), "model": path, "scale": made.scale, "steps": steps},
            lines=[*steps, f"Scale: {made.scale}", f"Model: {path}"],
        ),
        loaded,
    )
