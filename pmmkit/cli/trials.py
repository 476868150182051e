"""The work behind the command about sea trials."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any, Final

from pmmkit.campaigns.file.campaign_file import open_campaign
from pmmkit.checks import examine, refuse
from pmmkit.cli.console import Outcome, json_text
from pmmkit.cli.findings import findings_of
from pmmkit.cli.tracks import check_folder
from pmmkit.files import atomic_folder
from pmmkit.metrics import unit_of
from pmmkit.presentation import aligned
from pmmkit.simulation.imo import SOURCE
from pmmkit.trials import Trial, evaluate_trials

SHOWN: Final = {
    "turning": (
        "advance",
        "transfer",
        "tactical_diameter",
        "steady_diameter",
        "speed_loss",
        "time_90",
        "time_180",
    ),
    "zigzag": (
        "overshoot_1_deg",
        "overshoot_2_deg",
        "overshoot_3_deg",
        "time_execute_2",
        "time_execute_3",
        "reach",
        "period",
        "initial_turning_distance",
    ),
    "stopping": ("head_reach", "track_reach", "lateral_deviation", "time_to_stop"),
}
"""Measures in the text, by test; the files hold all."""


def trial(
    campaign: Path,
    out: Path,
    *,
    runs: Sequence[str] | None,
    order: Mapping[str, float] | None,
    current: tuple[float, float] | None,
    data: Path | None,
) -> Outcome:
    """Evaluate a sea trial: ``trial.csv``, ``trial.json``, paths and figures.

    Parameters
    ----------
    campaign, data : Path
        As for `open_campaign`.
    out : Path
        Folder of the results.
    runs, order, current
        As for `evaluate_trials`.

    Returns
    -------
    Outcome
        With the measures of every run.
    """
    check_folder(out)
    opened = open_campaign(campaign, data=data)
    findings = examine(opened)
    refuse(findings)
    found = evaluate_trials(opened, runs=runs, order=order, current=current)
    entries = [_entry(item) for item in found]
    warnings = findings_of(findings)
    with atomic_folder(out) as folder:
        _rows(found).to_csv(folder / "trial.csv", index=False)
        content = {"campaign": opened.title, "source": SOURCE, "findings": warnings}
        text = json_text({**content, "runs": entries})
        (folder / "trial.json").write_text(text + "\n", encoding="utf-8")
        from pmmkit.figures import trials as figures
        from pmmkit.plotting.style import save

        for item, name in zip(found, _names(found), strict=True):
            _path(item).to_csv(folder / f"path_{name}.csv", index=False)
            save(figures.trial_figure(item), folder / f"trial_{name}.svg")
        files = sorted(file.name for file in folder.iterdir())
    lines = [f"{opened.title}: {len(found)} runs, limits of {SOURCE}"]
    for item in found:
        lines += _text(item)
    lines += dict.fromkeys(f"{item['severity']}: {item['message']}" for item in warnings)
    lines += dict.fromkeys(
        text for item in found for verdict in item.verdicts for text in verdict.conditions
    )
    lines.append(f"Results: {out}")
    return Outcome(
        content={"out": str(out), "files": files, **content, "runs": entries}, lines=lines
    )


def _entry(item: Trial) -> dict[str, Any]:
    current = None
    if item.current is not None:
        current = {
            "x": item.current.x,
            "y": item.current.y,
            "std_x": item.current.std[0],
            "std_y": item.current.std[1],
            "speed": item.current.speed,
            "direction_deg": item.current.direction_deg,
            "origin": item.current.origin,
        }
    return {
        "run": item.run,
        "test": item.test,
        "L": item.L,
        "speed": item.speed,
        "speed_std": item.speed_std,
        "heading_deg": item.heading_deg,
        "rudder_deg": item.rudder_deg,
        "order": item.order,
        "orders": list(item.orders),
        "metrics": dict(item.metrics),
        "std": dict(item.std),
        "current": current,
        "wind": None if item.wind is None else asdict(item.wind),
        "noise": asdict(item.noise),
        "imo": [asdict(verdict) for verdict in item.verdicts],
        "notes": list(item.notes),
    }


def _rows(found: Sequence[Trial]) -> Any:
    import pandas as pd

    return pd.DataFrame([row for item in found for row in item.rows()])


def _path(item: Trial) -> Any:
    import pandas as pd

    names = ("t", "x", "y", "psi", "x_ground", "y_ground", "delta")
    return pd.DataFrame({name: getattr(item, name) for name in names})


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
    rudder = "" if item.test == "stopping" else f", rudder {item.rudder_deg:+.1f}°"
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
