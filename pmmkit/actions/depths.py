"""Jobs over the depth of the water: what each depth gives, side by side."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

from pmmkit.actions.outcome import WRONG, Outcome, marked, words_of, written
from pmmkit.presentation import aligned, number, plus_minus

if TYPE_CHECKING:
    import pandas as pd
    import xarray as xr

    from pmmkit.actions.speeds import TypedSpeed
    from pmmkit.campaigns import Campaign
    from pmmkit.models import Model
    from pmmkit.reduction import Growth, Reduction

TABLES: Final = "derivatives_by_depth.csv"
"""All rows of all depths, beside the folders of the depths."""
SQUAT: Final = "squat_by_depth.csv"
GROWTH: Final = "growth"
FEW: Final = 3
"""Metrics on the screen: each takes two columns."""
MOST: Final = 5
"""Metrics of a sweep on the screen."""
FOLDER: Final = "depth-"
"""What the name of a depth's folder begins with; its depth over the draught follows."""


def over_depths(
    campaigns: Sequence[Campaign],
    out: Path,
    reduce: Callable[[Campaign, Path], tuple[Outcome, Reduction]],
) -> Outcome:
    """Reduce runs at each depth of the water into a folder of its own."""
    from pmmkit.base import CampaignError, PmmkitError, Problem
    from pmmkit.files import write_results
    from pmmkit.models import TablesByDepth
    from pmmkit.reduction import Felt, Growth
    from pmmkit.views import growth_over_depth

    unstated = [run.id for part in campaigns if part.water.depth is None for run in part.runs]
    if unstated:
        raise CampaignError(
            Problem(
                message=f"{', '.join(unstated[:6])}{' …' if len(unstated) > 6 else ''} state no "
                "depth of the water, others do.",
                remedy="State depth = … of each run or table, or of [water] for those that state "
                "none.",
            )
        )
    lines: list[str] = []
    content: list[dict[str, Any]] = []
    found: list[Reduction] = []
    status = 0
    for part in campaigns:
        depth = part.water.depth
        title = f"In water of {part.depth_in_words}, h/T = {_ratio(part):.4g}"
        lines += ["", title, "=" * len(title)]
        try:
            outcome, reduction = reduce(part, out / f"{FOLDER}{_ratio(part):.2f}")
        except PmmkitError as error:  # the other depths are reduced
            lines.append(words_of(error))
            content.append(
                {"depth": depth, TablesByDepth.RATIO: _ratio(part), "error": words_of(error)}
            )
            status = max(status, WRONG)
            continue
        lines += outcome.lines
        content.append({"depth": depth, TablesByDepth.RATIO: _ratio(part), **outcome.content})
        found.append(reduction)
        status = max(status, outcome.status)
    results: list[tuple[str, Any]] = []
    grown: tuple[Growth, ...] = ()
    if found:
        tables = TablesByDepth(tables=tuple(item.table for item in found))
        grown = Growth.of(tables)
        results.append((TABLES, tables.to_pandas()))
    sunk = [
        item.squat_to_pandas().assign(**{TablesByDepth.RATIO: ratio})
        for ratio, item in _by_ratio(found)
    ]
    if any(len(frame) for frame in sunk):
        results.append((SQUAT, _stacked(sunk)))
    if grown:
        figure = growth_over_depth(grown, convention=tables.tables[0].convention)
        results += [(f"{GROWTH}.csv", _frame(grown)), (f"{GROWTH}.svg", figure.save)]
        lines += ["", *_growth_lines(grown)]
    files = write_results(out, results) if results else []
    return Outcome(
        content={
            "out": str(out),
            "files": [name for name in files if (out / name).is_file()],
            "depths": content,
            "growth": [_row(item) for item in grown],
            "felt": [asdict(item) for item in Felt.of(grown)],
        },
        lines=[*lines, f"Results: {out.resolve()}"],
        status=status,
    )


def _ratio(part: Campaign) -> float:
    return (part.water.depth or math.nan) / part.ship.d


def _by_ratio(found: Sequence[Reduction]) -> list[tuple[float, Reduction]]:
    return [(_ratio(item.campaign), item) for item in found]


def _stacked(frames: Sequence[pd.DataFrame]) -> pd.DataFrame:
    """Frames below each other, the depth over the draught in front."""
    import pandas as pd

    from pmmkit.models import TablesByDepth

    whole = pd.concat(frames, ignore_index=True)
    whole.insert(0, TablesByDepth.RATIO, whole.pop(TablesByDepth.RATIO))
    return whole


def _row(item: Growth) -> dict[str, Any]:
    from pmmkit.models import TablesByDepth

    return {
        "derivative": item.name,
        TablesByDepth.RATIO: item.ratio,
        "factor": item.factor,
        "std": item.std,
        "ci_low": item.factor - item.half,
        "ci_high": item.factor + item.half,
        "formula": None if math.isnan(item.formula) else item.formula,
    }


def _frame(grown: Sequence[Growth]) -> pd.DataFrame:
    import pandas as pd

    return pd.DataFrame([_row(item) for item in grown])


def _growth_lines(grown: Sequence[Growth]) -> list[str]:
    """A row per derivative, measured and by the formulas at each depth."""
    from pmmkit.reduction import Felt

    ratios = list(dict.fromkeys(item.ratio for item in grown))
    found = {(item.name, item.ratio): item for item in grown}
    rows = []
    for name in dict.fromkeys(item.name for item in grown):
        row = [name]
        for ratio in ratios:
            item = found.get((name, ratio))
            row += (
                ["–", "–"]
                if item is None
                else [
                    plus_minus(item.factor, item.half) or "–",
                    "–" if math.isnan(item.formula) else number(round(item.formula, 2)),
                ]
            )
        rows.append(row)
    head = [""]
    for ratio in ratios:
        head += [f"h/T {ratio:.4g}", "formula"]
    return [
        f"How derivatives grow from h/T {grown[0].deepest:.4g} (factors with their 95 % intervals; "
        "formulas of the effect shallow_water):",
        aligned(head, rows),
        *map(str, Felt.of(grown)),
    ]


def swept_over_depth(
    folder: Path,
    ratios: Sequence[float],
    speed: TypedSpeed,
    manoeuvre: str,
    settings: Mapping[str, Any],
    out: Path,
) -> Outcome:
    """Metrics of a manoeuvre over the depth of the water, beside those by the formulas."""
    from pmmkit.base import PmmkitError
    from pmmkit.models import TablesByDepth, model_at_depth
    from pmmkit.simulation import metrics_over, sweep

    models = _models(folder)
    asked = sorted(ratios, reverse=True)
    sailed = {ratio: model_at_depth(models, ratio) for ratio in asked}
    first = next(iter(sailed.values()))
    given = {"speed": speed.of(first.ship, first.water), **settings}
    found = sweep(sailed, "model", manoeuvre=manoeuvre, **given).rename(
        {"model": TablesByDepth.RATIO}
    )
    deepest = max(models)
    plain = {name: value for name, value in given.items() if name not in ("n", "spread")}
    beside: dict[float, dict[str, float] | str] = {}
    for ratio in asked:
        try:
            by_law = model_at_depth(models, ratio, by_formulas=True)
            own = sweep({ratio: by_law}, "model", manoeuvre=manoeuvre, **plain)
            beside[ratio] = {str(name): float(own[name][0]) for name in own.data_vars}
        except PmmkitError as error:
            beside[ratio] = words_of(error)
    metrics = told_metrics(found)
    table = found.to_dataframe().reset_index()
    for name in metrics:
        table[f"{name}_formula"] = [
            row[name] if isinstance(row, dict) else math.nan for row in beside.values()
        ]
    figure = metrics_over(found, metrics[:4])
    results = [("sweep.csv", table), ("sweep.svg", figure.save)]
    rows: list[dict[str, Any]] = [
        {str(name): value for name, value in row.items()} for row in table.to_dict("records")
    ]
    metrics = metrics[:FEW]
    heads = [name for metric in metrics for name in (metric, "formula")]
    cells = [
        [
            f"{row[TablesByDepth.RATIO]:.4g}",
            *(
                text
                for name in metrics
                for text in (told_metric(row, name), number(row[f"{name}_formula"]))
            ),
        ]
        for row in rows
    ]
    ends = f"{min(models):.4g} to {deepest:.4g}"
    lines = [
        f"Scale: {first.scale}",
        aligned(["h/T", *heads], cells),
        f"Measured at h/T {ends}, between them straight lines over T/h; formula: the derivatives "
        f"at h/T {deepest:.4g} carried by the effect shallow_water.",
        *dict.fromkeys(f"No formula: {why}" for why in beside.values() if isinstance(why, str)),
    ]
    return marked(written(out, results, {"sweep": rows}, lines), first)


def _models(folder: Path) -> dict[float, Model]:
    """Models of a reduction over several depths, by the depth over the draught."""
    from pmmkit.base import DataError, Problem
    from pmmkit.files import MODEL
    from pmmkit.models import load_model

    read = [load_model(file) for file in sorted(folder.glob(f"{FOLDER}*/{MODEL.file}"))]
    models = {item.water.depth / item.ship.d: item for item in read if item.water.depth}
    if len(models) < 2:
        raise DataError(
            Problem(
                message=f"{folder} does not hold models at several depths of the water.",
                remedy="Name the folder that pmmkit reduce wrote from runs with depth = … of "
                "several depths.",
            )
        )
    return models


def told_metrics(sweep: xr.Dataset) -> list[str]:
    """The metrics worth a column: in ship lengths where they are, without those that stay empty."""
    from pmmkit.conventions import METRICS
    from pmmkit.simulation import SHARES

    names = [str(name) for name in sweep.data_vars if not str(name).endswith(("_low", "_high"))]
    metrics = [name for name in METRICS.in_lengths(names) if name not in SHARES]
    return [name for name in metrics if sweep[name].notnull().any()][:MOST]


def told_metric(row: Mapping[str, Any], name: str) -> str:
    """A metric of a row of a sweep, with its interval where it has one."""
    text = f"{row[name]:.4g}"
    if f"{name}_low" not in row:
        return text
    return f"{text} ({row[f'{name}_low']:.4g} to {row[f'{name}_high']:.4g})"
