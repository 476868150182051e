"""Say how sure a manoeuvre is, and which values decide it."""

from __future__ import annotations

from dataclasses import replace
from typing import Final

from pmmkit.actions.outcome import Outcome, figure_files, marked, results_folder, written
from pmmkit.actions.setting import present, setting, settings, stem
from pmmkit.actions.shared import (
    Depth,
    ExecutionSettings,
    Extrapolate,
    Manoeuvre,
    Model,
    OrderSettings,
    Out,
    Spread,
)
from pmmkit.actions.speeds import Speed, approach
from pmmkit.base import did_you_mean
from pmmkit.presentation import number, text_of

CURVED: Final = 0.2
"""Share by which the standard deviation to first order may miss that of the ships: some hundred of
them tell theirs to less."""
STAGE: Final = ("predict", 4)
EXAMPLE: Final = "pmmkit uncertainty kvlcc2 --speed 8 --spread 0.05 --ships 1000"


@settings
class UncertaintySettings:
    """What is asked."""

    model: Model
    speed: Speed = None
    manoeuvre: Manoeuvre = "turning"
    orders: OrderSettings = OrderSettings()
    depth: Depth = None
    metric: str | None = setting("Whose causes are listed, such as advance_L.", default=None)
    ships: int = setting("Number of ships drawn.", default=10_000)
    spread: Spread = None
    seed: int = setting("Of the draws.", default=0)
    extrapolate: Extrapolate = False
    execution: ExecutionSettings = ExecutionSettings()
    out: Out = None


def uncertainty(job: UncertaintySettings) -> Outcome:
    """Do what is asked."""
    from pmmkit.base import UnknownNameError, shown
    from pmmkit.conventions import METRICS
    from pmmkit.models import load_model
    from pmmkit.simulation import Bands, monte_carlo, sensitivities

    folder = results_folder(job.out, f"{stem(job.model)}-uncertainty")
    loaded = load_model(job.model)
    pace = approach(job.speed, loaded)
    settings = {
        "speed": pace,
        "spread": job.spread,
        "extrapolate": job.extrapolate,
        **present(depth=job.depth),
        **job.orders.given(),
    }
    with shown() as progress:
        many = monte_carlo(
            loaded,
            job.manoeuvre,
            n=job.ships,
            seed=job.seed,
            progress=progress,
            executor=job.execution.executor,
            **settings,
        )
    chosen = job.metric or METRICS.main(many.metrics)
    if chosen not in many.metrics:
        raise UnknownNameError(
            f"{job.manoeuvre} has no metric {chosen!r}"
            f"{did_you_mean(chosen, many.metrics) or '.'} It has {', '.join(many.metrics)}."
        )
    found = sensitivities(loaded, job.manoeuvre, **settings)
    bands = replace(
        Bands.of(loaded, job.manoeuvre, n=min(job.ships, Bands.SHIPS), seed=job.seed, **settings),
        measures={name: many.interval(name) for name in many.metrics},
    )
    summary, causes = many.summary(), found.table(chosen)
    drawn = [chosen, *(name for name in many.varying() if name != chosen)]
    results = [
        ("metrics.csv", summary.to_csv),
        ("causes.csv", causes.to_csv),
        ("distributions.svg", many.plot(drawn[: many.SHOWN]).save),
        ("causes.svg", found.plot(chosen).save),
        *figure_files(bands.figures()),
    ]
    curved = []
    if found.covariance is not None:
        straight, sailed = found.std(chosen), float(summary["std"].to_dict()[chosen])
        if abs(straight - sailed) > CURVED * sailed:
            curved = [
                f"To first order, as these shares are, the standard deviation is "
                f"{number(straight, 3)}; that of the ships is {number(sailed, 3)}: {chosen} is no "
                f"straight line over these values."
            ]
    lines = [str(many), "", text_of([found.describe(chosen)]), *curved, ""]
    content = {
        "name": many.name,
        "manoeuvre": job.manoeuvre,
        "speed": pace,
        "ships": job.ships,
        "failed": many.failed,
        "origin": many.origin,
        "scale": many.scale,
        "metric": chosen,
        "metrics": summary.to_dict("index"),
        "causes": causes.to_dict("index"),
    }
    return marked(written(folder, results, content, lines), loaded)
