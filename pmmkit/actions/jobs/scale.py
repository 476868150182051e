"""Carry a model over to ship scale: Froude's law, friction and wake.

Or, with --like, to the model of another laboratory.
"""

from __future__ import annotations

from functools import partial
from pathlib import Path
from typing import Final

from pmmkit.actions.outcome import Outcome, marked, results_folder
from pmmkit.actions.setting import SettingError, setting, settings, stated, stem
from pmmkit.actions.shared import Data, Force, Model, Out
from pmmkit.actions.speeds import WAYS, TypedSpeed, typed

STAGE: Final = ("model", 6)
EXAMPLE: Final = "pmmkit scale kvlcc2-l7 --length 320 --speed 8"


@settings
class ScaleSettings:
    """What is asked."""

    model: Model
    length: float | None = setting("Of the ship, m.", default=None)
    like: Path | None = setting(
        "Campaign of the same hull: its length, mass and water by Froude's law, and the "
        "propeller and rudder that it states.",
        default=None,
    )
    speed: TypedSpeed | None = setting(
        f"Of the ship at its new length, where the model has one set for all speeds: {WAYS}.",
        default=None,
        read=typed,
        metavar="SPEED",
    )
    form: float | None = setting("Form factor k; estimated if absent.", default=None)
    wetted: float | None = setting(
        "Wetted surface of the ship in m²; estimated if absent.", default=None
    )
    rho: float | None = setting("Density of the ship's water in kg/m³.", default=None)
    froude_only: bool = setting("Correct neither friction nor wake.", default=False)
    data: Data = None
    out: Out = None
    force: Force = False


def scale(job: ScaleSettings) -> Outcome:
    """Do what is asked."""
    from pmmkit.api import carried_to
    from pmmkit.campaigns import open_campaign
    from pmmkit.conventions import Water
    from pmmkit.files import MODEL, write_results
    from pmmkit.models import full_scale, load_model, save_model, scaled

    if (job.length is None) == (job.like is None):
        raise SettingError(
            "Say --length, such as --length 320, or --like and a campaign of the same hull."
        )
    target = "ship" if job.like is None else stem(job.like)
    folder = results_folder(
        job.out, f"{stem(job.model)}-{target}", read=[job.model], force=job.force
    )
    loaded = load_model(job.model)
    if job.like is not None:
        if {"speed", "form", "wetted", "rho", "froude_only"} & set(stated(job)):
            raise SettingError(
                "--like takes all of the campaign: leave out --speed, --form, --wetted, --rho and "
                "--froude-only."
            )
        made = carried_to(loaded, open_campaign(job.like, data=job.data))
    else:
        assert job.length is not None
        made = scaled(loaded, job.length)
        if not job.froude_only:
            water = None if job.rho is None else Water(rho=job.rho, g=loaded.water.g)
            pace = None if job.speed is None else job.speed.of(made.ship, made.water)
            made = full_scale(
                loaded, job.length, speed=pace, form=job.form, wetted=job.wetted, water=water
            )
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
