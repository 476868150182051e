"""``pmmkit sweep``."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Final

import typer

from pmmkit.cli.depths import swept_over_depth
from pmmkit.cli.options import (
    Depth,
    Extrapolate,
    Follow,
    Manoeuvre,
    Model,
    More,
    RudderDeg,
    Scheduler,
    Spread,
    SwitchDeg,
    WorkerCount,
    numbers,
    settings_of,
    stated,
    stem,
    where,
)
from pmmkit.cli.output import Outcome, marked
from pmmkit.cli.outputs import Out, results_folder
from pmmkit.cli.speeds import typed_list
from pmmkit.presentation import aligned

if TYPE_CHECKING:
    import xarray as xr

EXAMPLE: Final = "pmmkit sweep kvlcc2 --speeds 6,8"


def sweep(
    model: Model,
    speeds: Annotated[
        str | None,
        typer.Option(
            help="Approach speeds of the ship in the model, at the model's own scale, such as "
            "6,9,12 [m/s], '12,15 kn' or 'Fn 0.1,0.15'; those of the tests if absent."
        ),
    ] = None,
    over: Annotated[
        str | None,
        typer.Option(help="What to vary in place of the speed: rudder_deg, depth, wind_speed …"),
    ] = None,
    values: Annotated[str | None, typer.Option(help="Its values, such as 10,20,35.")] = None,
    depths: Annotated[
        str | None,
        typer.Option(
            help="Depths of the water over the draught, such as 1.3,1.5,2: MODEL is the folder "
            "that reduce wrote from tests over several depths. Needs one approach speed."
        ),
    ] = None,
    manoeuvre: Manoeuvre = "turning",
    fn: Follow = "approach",
    rudder_deg: RudderDeg = None,
    switch_deg: SwitchDeg = None,
    more: More = None,
    depth: Depth = None,
    ships: Annotated[int, typer.Option(help="Ships drawn per value for 95 % intervals.")] = 0,
    spread: Spread = None,
    extrapolate: Extrapolate = False,
    workers: WorkerCount = None,
    scheduler: Scheduler = None,
    out: Out = None,
) -> Outcome:
    """Metrics of a manoeuvre over the approach speed, or over --over, or over --depths."""
    from pmmkit.files import write_results
    from pmmkit.models import load_model, standing
    from pmmkit.plotting import save
    from pmmkit.simulation import (
        SHARES,
        froude_sweep,
        metrics_over,
        sweep_frame,
        told_metric,
        told_metrics,
    )
    from pmmkit.simulation import sweep as sweep_sweeps

    typed = None if speeds is None else typed_list(speeds)
    settings = {
        "n": ships,
        "spread": spread,
        "fn": fn,
        "extrapolate": extrapolate,
        "executor": where(workers, scheduler),
        **stated(rudder_deg=rudder_deg, switch_deg=switch_deg, depth=depth),
        **settings_of(more),
    }
    if over is not None and (values is None or typed is None or len(typed) != 1):
        raise typer.BadParameter("--over needs --values and one approach speed, --speeds 8.")
    folder = results_folder(out, f"{stem(model)}-sweep")
    if depths is not None:
        if over is not None or typed is None or len(typed) != 1:
            raise typer.BadParameter(
                "--depths needs one approach speed, --speeds 8, and no --over."
            )
        ratios = numbers(depths) or ()
        return swept_over_depth(Path(model), ratios, typed[0], manoeuvre, settings, folder)
    loaded = load_model(model)
    asked = [speed.of(loaded.ship, loaded.water) for speed in typed] if typed else None
    if over is None or asked is None:
        found = froude_sweep(loaded, asked, manoeuvre, **settings)
    else:
        found = sweep_sweeps(loaded, over, numbers(values), manoeuvre, speed=asked[0], **settings)
    metrics = told_metrics(found)
    table = sweep_frame(found)
    rows: list[dict[str, Any]] = [
        {str(name): value for name, value in row.items()} for row in table.to_dict("records")
    ]
    figure = metrics_over(found, metrics[:4])
    files = write_results(folder, [("sweep.csv", table), ("sweep.svg", partial(save, figure))])
    coordinates = [str(name) for name in found.coords]
    columns = [*metrics, *(name for name in SHARES if name in found)]
    cells = [
        [f"{row[name]:.4g}" for name in coordinates] + [told_metric(row, name) for name in columns]
        for row in rows
    ]
    sailed = asked or [loaded.ship.speed(Fn, loaded.water.g) for Fn in loaded.Fn]
    lines = [
        f"Scale: {loaded.scale}",
        *dict.fromkeys(text for speed in sailed for text in standing(loaded, speed).sentences),
        aligned([*_heads(found, coordinates, metrics, manoeuvre), *columns[len(metrics) :]], cells),
        f"Results: {folder}",
    ]
    return marked(
        Outcome(content={"out": str(folder), "files": files, "sweep": rows}, lines=lines), loaded
    )


def _heads(
    found: xr.Dataset, coordinates: Sequence[str], metrics: Sequence[str], manoeuvre: str
) -> list[str]:
    """Names of the columns, with their units."""
    from pmmkit.conventions import metric_unit
    from pmmkit.simulation import manoeuvre_of

    known = manoeuvre_of(manoeuvre).metrics
    units = {name: found[name].attrs.get("units", "") for name in coordinates}
    units |= {name: metric_unit(name, known) for name in metrics}
    return [f"{name} [{unit}]" if unit else name for name, unit in units.items()]
