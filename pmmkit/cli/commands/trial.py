"""``pmmkit trial``."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from functools import partial
from typing import TYPE_CHECKING, Annotated, Any, Final

import typer

from pmmkit.campaigns.test_kinds.free_running import STOPPING, TURNING, ZIGZAG
from pmmkit.cli.options import Campaign, Data, Out, numbers, results_folder, sound_campaign, stem
from pmmkit.cli.output import Outcome, warned
from pmmkit.presentation import aligned

if TYPE_CHECKING:
    from pmmkit.trials import Trial

SHOWN: Final = {
    TURNING.name: (
        "advance",
        "transfer",
        "tactical_diameter",
        "steady_diameter",
        "speed_loss",
        "time_90",
        "time_180",
    ),
    ZIGZAG.name: (
        "overshoot_1_deg",
        "overshoot_2_deg",
        "overshoot_3_deg",
        "time_execute_2",
        "time_execute_3",
        "reach",
        "period",
        "initial_turning_distance",
    ),
    STOPPING.name: ("head_reach", "track_reach", "lateral_deviation", "time_to_stop"),
}
"""Measures in the text, by test; the files hold all."""


def trial(
    campaign: Campaign,
    run: Annotated[
        list[str] | None, typer.Option(help="Id of a run; may be repeated. All if absent.")
    ] = None,
    order: Annotated[
        float | None, typer.Option(help="Instant of the order [s] on the clock of the one --run.")
    ] = None,
    current: Annotated[
        str | None,
        typer.Option(help="A current that is known: north,east [m/s], such as 0.4,-0.1."),
    ] = None,
    data: Data = None,
    out: Out = None,
) -> Outcome:
    """Measure turning circles, zigzags and stops of a sea trial, beside the limits of the IMO."""
    from pmmkit.files import write_results
    from pmmkit.simulation.imo import SOURCE
    from pmmkit.trials import evaluate_trials

    velocity = numbers(current)
    if velocity is not None and len(velocity) != 2:
        raise typer.BadParameter(f"--current {current!r}: write north,east, such as 0.4,-0.1.")
    if order is not None and len(run or ()) != 1:
        raise typer.BadParameter("--order belongs to one run: give one --run with it.")
    folder = results_folder(out, f"{stem(campaign)}-trial")
    opened, findings = sound_campaign(campaign, data)
    found = evaluate_trials(
        opened,
        runs=run,
        order=None if order is None or run is None else {run[0]: order},
        current=None if velocity is None else (velocity[0], velocity[1]),
    )
    content = {
        "campaign": opened.title,
        "source": SOURCE,
        "findings": [item.to_dict() for item in findings],
        "runs": [item.to_dict() for item in found],
    }
    files = write_results(folder, _files(found, content))
    lines = [f"{opened.title}: {len(found)} runs, limits of {SOURCE}"]
    for item in found:
        lines += _text(item)
    lines += warned(findings)
    lines += dict.fromkeys(
        text for item in found for verdict in item.verdicts for text in verdict.conditions
    )
    lines.append(f"Results: {folder}")
    return Outcome(content={"out": str(folder), "files": files, **content}, lines=lines)


def _files(found: Sequence[Trial], content: Mapping[str, Any]) -> Iterator[tuple[str, Any]]:
    import pandas as pd

    from pmmkit.figures.trials import trial_figure
    from pmmkit.plotting.style import save

    yield "trial.csv", pd.DataFrame([row for item in found for row in item.rows()])
    yield "trial.json", content
    for item, name in zip(found, _names(found), strict=True):
        yield f"path_{name}.csv", item.path()
        yield f"trial_{name}.svg", partial(save, trial_figure(item))


def _names(found: Sequence[Trial]) -> list[str]:
    """The ids of runs as parts of names of files, each once."""
    names: list[str] = []
    for item in found:
        plain = "".join(
            letter if letter.isalnum() or letter in "-+." else "_" for letter in item.run
        )
        names.append(plain if plain not in names else f"{plain}_{len(names) + 1}")
    return names


def _text(item: Trial) -> list[str]:
    rudder = "" if item.test == STOPPING.name else f", rudder {item.rudder_deg:+.1f}°"
    std = f" ± {item.speed_std:.2f}" if math.isfinite(item.speed_std) else ""
    lines = [
        "",
        f"{item.run}: {item.test}{rudder}, approach {item.speed:.2f}{std} m/s on "
        f"{item.heading_deg:05.1f}°, order at t = {item.order:.1f} s",
    ]
    if item.current is not None:
        lines.append(
            f"Current {item.current.speed:.3f} ± {item.current.speed_std:.3f} m/s to "
            f"{item.current.direction_deg:03.0f}° ({item.current.origin})"
        )
    if item.wind is not None:
        lines.append(f"Wind {item.wind}")
    limits = {row["measure"]: row for row in item.rows()}
    rows = [
        [*_cells(name, item), *_limit(limits.get(f"{name}_L", limits[name]))]
        for name in SHOWN.get(item.test, ())
        if name in item.metrics
    ]
    lines.append(aligned(["measure", "value", "std", "in L", "limit", ""], rows))
    return [*lines, *item.notes]


def _cells(name: str, item: Trial) -> list[str]:
    from pmmkit.metrics import unit_of

    value, std, unit = item.metrics[name], item.std[name], unit_of(name)
    digits = 3 if unit == "-" else 1
    shown = "°" if unit == "deg" else "" if unit == "-" else f" {unit}"
    label = name.removesuffix("_deg").replace("_", " ")
    if not math.isfinite(value):
        return [label, "-", "-", "-"]
    length = item.metrics.get(f"{name}_L")
    return [
        label,
        f"{value:.{digits}f}{shown}",
        f"{std:.{digits}f}{shown}",
        "" if length is None else f"{length:.2f} L",
    ]


def _limit(row: Mapping[str, Any]) -> list[str]:
    if not math.isfinite(row["limit"]):
        return ["", ""]
    unit = " L" if row["unit"] == "L" else "°"
    word = {True: "met", False: "NOT met", None: "not judged"}[row["passed"]]
    return [f"{row['limit']:.4g}{unit}", word]
