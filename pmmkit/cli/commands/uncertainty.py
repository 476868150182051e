"""``pmmkit uncertainty``."""

from __future__ import annotations

from dataclasses import replace
from functools import partial
from typing import Annotated, Final

import typer

from pmmkit.base import did_you_mean
from pmmkit.cli.options import (
    Depth,
    Extrapolate,
    Manoeuvre,
    Model,
    More,
    RudderDeg,
    Scheduler,
    Spread,
    SwitchDeg,
    WorkerCount,
    settings_of,
    stated,
    stem,
    where,
)
from pmmkit.cli.output import Outcome, marked
from pmmkit.cli.outputs import Out, results_folder
from pmmkit.cli.speeds import Speed, approach
from pmmkit.presentation import number, text_of

CURVED: Final = 0.2
"""Share by which the standard deviation to first order may miss that of the ships: some hundred of
them tell theirs to less."""
EXAMPLE: Final = "pmmkit uncertainty kvlcc2 --speed 8 --spread 0.05 --ships 1000"


def uncertainty(
    model: Model,
    speed: Speed = None,
    manoeuvre: Manoeuvre = "turning",
    rudder_deg: RudderDeg = None,
    switch_deg: SwitchDeg = None,
    more: More = None,
    depth: Depth = None,
    metric: Annotated[
        str | None, typer.Option(help="Whose causes are listed, such as advance_L.")
    ] = None,
    ships: Annotated[int, typer.Option(help="Number of ships drawn.")] = 10_000,
    spread: Spread = None,
    seed: Annotated[int, typer.Option(help="Of the draws.")] = 0,
    extrapolate: Extrapolate = False,
    workers: WorkerCount = None,
    scheduler: Scheduler = None,
    out: Out = None,
) -> Outcome:
    """How sure a manoeuvre is, and which values decide it."""
    from pmmkit.base import UnknownNameError, shown
    from pmmkit.conventions import main_of
    from pmmkit.files import write_results
    from pmmkit.models import load_model
    from pmmkit.plotting import figure_files, save
    from pmmkit.simulation import SHIPS, SHOWN, bands_of, monte_carlo, sensitivities

    folder = results_folder(out, f"{stem(model)}-uncertainty")
    loaded = load_model(model)
    pace = approach(speed, loaded)
    settings = {
        "speed": pace,
        "spread": spread,
        "extrapolate": extrapolate,
        **stated(rudder_deg=rudder_deg, switch_deg=switch_deg, depth=depth),
        **settings_of(more),
    }
    with shown() as progress:
        many = monte_carlo(
            loaded,
            manoeuvre,
            n=ships,
            seed=seed,
            progress=progress,
            executor=where(workers, scheduler),
            **settings,
        )
    chosen = metric or main_of(many.metrics)
    if chosen not in many.metrics:
        raise UnknownNameError(
            f"{manoeuvre} has no metric {chosen!r}{did_you_mean(chosen, many.metrics) or '.'} It "
            f"has {', '.join(many.metrics)}."
        )
    found = sensitivities(loaded, manoeuvre, **settings)
    bands = replace(
        bands_of(loaded, manoeuvre, n=min(ships, SHIPS), seed=seed, **settings),
        measures={name: many.interval(name) for name in many.metrics},
    )
    summary, causes = many.summary(), found.table(chosen)
    drawn = [chosen, *(name for name in many.varying() if name != chosen)]
    files = write_results(
        folder,
        [
            ("metrics.csv", summary.to_csv),
            ("causes.csv", causes.to_csv),
            ("distributions.svg", partial(save, many.plot(drawn[:SHOWN]))),
            ("causes.svg", partial(save, found.plot(chosen))),
            *figure_files(bands.figures()),
        ],
    )
    curved = []
    if found.covariance is not None:
        straight, sailed = found.std(chosen), float(summary["std"].to_dict()[chosen])
        if abs(straight - sailed) > CURVED * sailed:
            curved = [
                f"To first order, as these shares are, the standard deviation is "
                f"{number(straight, 3)}; that of the ships is {number(sailed, 3)}: {chosen} is no "
                f"straight line over these values."
            ]
    lines = [str(many), "", text_of([found.describe(chosen)]), *curved, "", f"Results: {folder}"]
    content = {
        "out": str(folder),
        "files": files,
        "name": many.name,
        "manoeuvre": manoeuvre,
        "speed": pace,
        "ships": ships,
        "failed": many.failed,
        "origin": many.origin,
        "scale": many.scale,
        "metric": chosen,
        "metrics": summary.to_dict("index"),
        "causes": causes.to_dict("index"),
    }
    return marked(Outcome(content=content, lines=lines), loaded)
