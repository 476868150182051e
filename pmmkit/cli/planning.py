"""The work behind ``pmmkit plan``."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any

from pmmkit.campaigns.file.campaign_file import open_campaign
from pmmkit.campaigns.run import Campaign
from pmmkit.cli.console import Outcome
from pmmkit.cli.tracks import check_folder
from pmmkit.errors import CampaignError, DataError
from pmmkit.files import atomic_folder
from pmmkit.models import load_model
from pmmkit.presentation import aligned
from pmmkit.test_planning.next_run import Advice, next_runs
from pmmkit.test_planning.options import Limits, Option, limits_of
from pmmkit.test_planning.plan_file import entries_text, read_plan_file
from pmmkit.test_planning.programme import Plan
from pmmkit.test_planning.programme import plan as programme


def plan(
    model: str,
    campaign: Path | None,
    out: Path,
    *,
    effects: Sequence[str],
    runs: int | None,
    hours: float | None,
    speeds: Sequence[float] | None,
    limits: Path | None,
    noise: float | None,
    record_noise: float,
    floor: float,
    given: Sequence[str],
    before: bool,
    data: Path | None,
) -> Outcome:
    """The next run where tests are made, a programme where there are none or one is asked for.

    Parameters
    ----------
    model : str
        Structure, library ship or model file.
    campaign, data : Path, optional
        As for `open_campaign`; `before` leaves its tests out.
    out : Path
        Folder for ``plan.csv`` and ``plan.toml``.
    effects, runs, hours, noise, record_noise, floor, given
        As for `programme.plan`.
    speeds : sequence of float, optional
        [m/s]
    limits : Path, optional
        As for `read_plan_file`.
    before : bool
        As if no test were made.

    Returns
    -------
    Outcome
        With the runs, and what stays invisible or is better checked at the bench.
    """
    check_folder(out)
    opened = None if campaign is None else _opened(campaign, data, before)
    allowed, options = _limits(opened, model, limits, speeds)
    if opened is not None and opened.runs and runs is None and hours is None:
        advice = next_runs(
            model,
            opened,
            effects=effects,
            limits=allowed,
            options=options,
            floor=floor,
            given=given,
            noise=noise,
        )
        return _advised(advice, out)
    made = programme(
        model,
        opened,
        runs=runs,
        hours=hours,
        effects=effects,
        limits=allowed,
        options=options,
        noise=noise,
        record_noise=record_noise,
        floor=floor,
        given=given,
    )
    return _planned(made, out)


def _opened(campaign: Path, data: Path | None, before: bool) -> Campaign:
    if before:
        return open_campaign(campaign, data=data, runs=False)
    try:
        return open_campaign(campaign, data=data)
    except CampaignError as error:
        if all("there are no runs" in item.message for item in error.problems):
            return open_campaign(campaign, data=data, runs=False)
        raise


def _limits(
    campaign: Campaign | None, model: str, file: Path | None, speeds: Sequence[float] | None
) -> tuple[Limits | None, tuple[Option, ...] | None]:
    found = limits_of(campaign) if campaign is not None and campaign.runs else None
    if speeds is not None:
        found = (found or Limits(speeds=(1.0,))).with_(speeds=tuple(speeds))
    if file is None:
        if found is None:
            raise DataError("Before any test a plan needs speeds: --speeds 1.0,1.5, or --limits.")
        return found, None
    ship = campaign.ship if campaign is not None else load_model(model).ship
    return read_plan_file(file, ship, found)


def _advised(advice: Advice, out: Path) -> Outcome:
    runs = [
        {
            **item.option.entry,
            "repeats": item.repeats,
            "gain": item.gain,
            "gains": item.gains,
            "resolves": item.resolves,
            "hours": item.hours,
            "words": item.words,
        }
        for item in advice.runs
    ]
    chosen = [item.option for item in advice.runs[:1] for _ in range(item.repeats)]
    files = _written(out, advice.to_pandas(), chosen)
    lines = [advice.words]
    if advice.runs and advice.rivals:
        lines.append(
            aligned(
                ["run", "repeats", "gain in ln odds", "resolves", "hours"],
                [
                    [
                        item.option.words,
                        f"{item.repeats}",
                        f"{item.gain:.1f}",
                        f"{100 * item.resolves:.0f} %",
                        f"{item.hours:.2f}",
                    ]
                    for item in advice.runs
                ],
            )
        )
    elif advice.runs:
        lines.append(
            aligned(
                ["run", "shows", "hours"],
                [
                    [item.option.words, " ".join(item.gains), f"{item.hours:.2f}"]
                    for item in advice.runs
                ],
            )
        )
    lines.append(f"Results: {out}")
    content = {
        "out": str(out),
        "files": files,
        "words": advice.words,
        "rivals": advice.rivals,
        "wanted": advice.wanted,
        "runs": runs,
        "checks": advice.checks,
    }
    return Outcome(content=content, lines=lines)


def _planned(made: Plan, out: Path) -> Outcome:
    files = _written(out, made.to_pandas(), made.options)
    head = (
        f"{made.made} tests are made and show {len(made.before)} of {len(made.sights)} effects. "
        if made.made
        else ""
    )
    last = made.steps[-1] if made.steps else None
    told = (
        f"{len(made.steps)} runs in {made.hours:.1f} h show {last.visible} of {len(made.sights)} "
        f"effects at usual size and tell {100 * last.separated:.0f} % of their pairs apart."
        if last
        else "No further run is worth its time."
    )
    lines = [
        head + told,
        aligned(
            ["run", "min", "hours", "visible", "apart", "becomes visible"],
            [
                [
                    step.option.words,
                    f"{60 * step.option.hours:.0f}",
                    f"{step.hours:.2f}",
                    f"{step.visible}",
                    f"{100 * step.separated:.0f} %",
                    ", ".join(step.shown),
                ]
                for step in made.steps
            ],
        ),
        "Stays invisible:" if made.invisible else "Nothing stays invisible.",
        *(f"  {item.name}: {item.why}." for item in made.invisible),
        f"Results: {out}",
    ]
    content: Mapping[str, Any] = {
        "out": str(out),
        "files": files,
        "hours": made.hours,
        "made": made.made,
        "before": made.before,
        "steps": [
            {
                **step.option.entry,
                "duration_h": step.option.hours,
                "hours": step.hours,
                "shown": step.shown,
                "visible": step.visible,
                "separated": step.separated,
            }
            for step in made.steps
        ],
        "effects": [asdict(item) for item in made.sights],
    }
    return Outcome(content=content, lines=lines)


def _written(out: Path, table: Any, options: Sequence[Option]) -> list[str]:
    with atomic_folder(out) as folder:
        table.to_csv(folder / "plan.csv", index=False)
        (folder / "plan.toml").write_text(entries_text(options), encoding="utf-8")
        return sorted(file.name for file in folder.iterdir())
