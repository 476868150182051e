"""Show metrics of a manoeuvre over the approach speed, or over --over, or over --depths."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

from pmmkit.actions.depths import swept_over_depth, told_metric, told_metrics
from pmmkit.actions.outcome import Outcome, marked, results_folder, written
from pmmkit.actions.setting import SettingError, numbers, present, setting, settings, stem
from pmmkit.actions.shared import (
    Depth,
    ExecutionSettings,
    Extrapolate,
    Follow,
    Manoeuvre,
    Model,
    OrderSettings,
    Out,
    Spread,
)
from pmmkit.actions.speeds import typed_list
from pmmkit.presentation import aligned

if TYPE_CHECKING:
    import xarray as xr

STAGE: Final = ("predict", 2)
EXAMPLE: Final = "pmmkit sweep kvlcc2 --speeds 6,8"


@settings
class SweepSettings:
    """What is asked."""

    model: Model
    speeds: str | None = setting(
        "Approach speeds of the ship in the model, at the model's own scale, such as "
        "6,9,12 [m/s], '12,15 kn' or 'Fn 0.1,0.15'; those of the tests if absent.",
        default=None,
    )
    over: str | None = setting(
        "What to vary in place of the speed: rudder_deg, depth, wind_speed …", default=None
    )
    values: str | None = setting("Its values, such as 10,20,35.", default=None)
    depths: str | None = setting(
        "Depths of the water over the draught, such as 1.3,1.5,2: MODEL is the folder "
        "that reduce wrote from tests over several depths. Needs one approach speed.",
        default=None,
    )
    manoeuvre: Manoeuvre = "turning"
    fn: Follow = "approach"
    orders: OrderSettings = OrderSettings()
    depth: Depth = None
    ships: int = setting("Ships drawn per value for 95 % intervals.", default=0)
    spread: Spread = None
    extrapolate: Extrapolate = False
    execution: ExecutionSettings = ExecutionSettings()
    out: Out = None


def sweep(job: SweepSettings) -> Outcome:
    """Do what is asked."""
    from pmmkit.models import Standing, load_model
    from pmmkit.simulation import SHARES, froude_sweep, metrics_over
    from pmmkit.simulation import sweep as sweep_sweeps

    typed = None if job.speeds is None else typed_list(job.speeds)
    settings = {
        "n": job.ships,
        "spread": job.spread,
        "fn": job.fn,
        "extrapolate": job.extrapolate,
        "executor": job.execution.executor,
        **present(depth=job.depth),
        **job.orders.given(),
    }
    if job.over is not None and (job.values is None or typed is None or len(typed) != 1):
        raise SettingError("--over needs --values and one approach speed, --speeds 8.")
    folder = results_folder(job.out, f"{stem(job.model)}-sweep")
    if job.depths is not None:
        if job.over is not None or typed is None or len(typed) != 1:
            raise SettingError("--depths needs one approach speed, --speeds 8, and no --over.")
        ratios = numbers(job.depths) or ()
        return swept_over_depth(Path(job.model), ratios, typed[0], job.manoeuvre, settings, folder)
    loaded = load_model(job.model)
    asked = [speed.of(loaded.ship, loaded.water) for speed in typed] if typed else None
    if job.over is None or asked is None:
        found = froude_sweep(loaded, asked, job.manoeuvre, **settings)
    else:
        found = sweep_sweeps(
            loaded, job.over, numbers(job.values), job.manoeuvre, speed=asked[0], **settings
        )
    metrics = told_metrics(found)
    table = found.to_dataframe().reset_index()
    rows: list[dict[str, Any]] = [
        {str(name): value for name, value in row.items()} for row in table.to_dict("records")
    ]
    figure = metrics_over(found, metrics[:4])
    coordinates = [str(name) for name in found.coords]
    columns = [*metrics, *(name for name in SHARES if name in found)]
    cells = [
        [f"{row[name]:.4g}" for name in coordinates] + [told_metric(row, name) for name in columns]
        for row in rows
    ]
    sailed = asked or [loaded.ship.speed(Fn, loaded.water.g) for Fn in loaded.Fn]
    lines = [
        f"Scale: {loaded.scale}",
        *dict.fromkeys(text for speed in sailed for text in Standing.of(loaded, speed).sentences),
        aligned(
            [*_heads(found, coordinates, metrics, job.manoeuvre), *columns[len(metrics) :]], cells
        ),
    ]
    results = [("sweep.csv", table), ("sweep.svg", figure.save)]
    return marked(written(folder, results, {"sweep": rows}, lines), loaded)


def _heads(
    found: xr.Dataset, coordinates: Sequence[str], metrics: Sequence[str], manoeuvre: str
) -> list[str]:
    """Names of the columns, with their units."""
    from pmmkit.conventions import Metric
    from pmmkit.simulation import MANOEUVRES

    known = MANOEUVRES[manoeuvre].metrics
    units = {name: found[name].attrs.get("units", "") for name in coordinates}
    units |= {name: Metric.of(name, known).unit_of(name) for name in metrics}
    return [f"{name} [{unit}]" if unit else name for name, unit in units.items()]
