"""``pmmkit uncertainty``."""

from __future__ import annotations

from functools import partial
from typing import TYPE_CHECKING, Annotated, Final

import typer

from pmmkit.cli.options import (
    Depth,
    Extrapolate,
    Manoeuvre,
    Model,
    Out,
    RudderDeg,
    Speed,
    Spread,
    SwitchDeg,
    results_folder,
    stated,
    stem,
)
from pmmkit.cli.output import Outcome
from pmmkit.presentation import aligned

if TYPE_CHECKING:
    from pmmkit.numerics import Array

SHOWN: Final = 3
"""Metrics drawn as distributions."""
LISTED: Final = 10
"""Derivatives listed."""


def uncertainty(
    model: Model,
    speed: Speed,
    manoeuvre: Manoeuvre = "turning",
    rudder_deg: RudderDeg = None,
    switch_deg: SwitchDeg = None,
    depth: Depth = None,
    metric: Annotated[
        str | None, typer.Option(help="Whose causes are listed, such as advance_L.")
    ] = None,
    ships: Annotated[int, typer.Option(help="Number of ships drawn.")] = 10_000,
    spread: Spread = None,
    seed: Annotated[int, typer.Option(help="Of the draws.")] = 0,
    extrapolate: Extrapolate = False,
    out: Out = None,
) -> Outcome:
    """How sure a manoeuvre is, and which derivatives decide it."""
    from pmmkit.errors import UnknownNameError
    from pmmkit.figures import distributions, importance
    from pmmkit.files import write_results
    from pmmkit.models import load_model
    from pmmkit.plotting.style import save
    from pmmkit.progress import shown
    from pmmkit.simulation.ensemble import monte_carlo
    from pmmkit.simulation.sensitivity import sensitivities

    folder = results_folder(out, f"{stem(model)}-uncertainty")
    loaded = load_model(model)
    settings = {
        "speed": speed,
        "spread": spread,
        "extrapolate": extrapolate,
        **stated(rudder_deg=rudder_deg, switch_deg=switch_deg, depth=depth),
    }
    with shown() as progress:
        many = monte_carlo(loaded, manoeuvre, n=ships, seed=seed, progress=progress, **settings)
    names = [
        name for name in many.metrics if name.endswith("_L") or f"{name}_L" not in many.metrics
    ]
    chosen = metric or ("tactical_diameter_L" if "tactical_diameter_L" in names else names[0])
    if chosen not in many.metrics:
        raise UnknownNameError(
            f"{manoeuvre} has no metric {chosen!r}; it has {', '.join(many.metrics)}."
        )
    found = sensitivities(loaded, manoeuvre, **settings)
    summary, causes = many.summary(), found.table(chosen)
    drawn = [chosen, *[name for name in names if name != chosen and _varies(many.metrics[name])]]
    files = write_results(
        folder,
        [
            ("metrics.csv", summary.to_csv),
            ("causes.csv", causes.to_csv),
            ("distributions.svg", partial(save, distributions(many, drawn[:SHOWN]))),
            ("causes.svg", partial(save, importance(found, chosen))),
        ],
    )
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
        f"Results: {folder}",
    ]
    content = {
        "out": str(folder),
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


def _varies(values: Array) -> bool:
    import numpy as np

    there = values[np.isfinite(values)]
    return len(there) > 1 and float(np.ptp(there)) > 0.0
