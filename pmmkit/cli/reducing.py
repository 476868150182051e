"""The work behind ``pmmkit reduce`` and ``pmmkit demo``."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Final, Literal

import numpy as np

from pmmkit.api import hull_table, model_of
from pmmkit.campaigns.file.campaign_file import open_campaign
from pmmkit.cli.console import Outcome, say
from pmmkit.cli.findings import findings_of
from pmmkit.cli.results import write_reduction
from pmmkit.cli.tracks import check_folder
from pmmkit.conventions import CHANNELS
from pmmkit.errors import MissingPartError, ModelError, SimulationError
from pmmkit.files import datasets_folder
from pmmkit.loop.session import begin
from pmmkit.metrics import HARD_OVER
from pmmkit.models import Model, load_model
from pmmkit.presentation import aligned, percent
from pmmkit.progress import shown
from pmmkit.reduction import Reduction, reduce_campaign
from pmmkit.reduction.reading.resume import forget, resume_folder
from pmmkit.report import Loop, Reference, Turns, changes, loop_of, tables
from pmmkit.report.loop import VERDICTS
from pmmkit.simulation import froude_sweep, simulate
from pmmkit.tables import DerivativeTable, read_table

if TYPE_CHECKING:
    from pmmkit.observations.prepare import CycleChoice

STEPS: Final = 7
"""Froude numbers of a sweep in a report."""
ROUNDS: Final = 3
"""Rounds of naming and adding in a demo."""
PARTS: Final = ("propeller", "rudder_mmg")


def reduce(
    campaign: Path,
    out: Path,
    *,
    structure: str = "abkowitz3",
    fn: Literal["each", "pooled"] = "each",
    cycles: CycleChoice = None,
    data: Path | None = None,
    parts: str | None = None,
    reference: str | None = None,
    reference_name: str | None = None,
    asked: str | None = None,
    jobs: int | None = None,
    memory: float = 1000.0,
) -> Outcome:
    """Reduce a campaign and write everything.

    What was read of a large campaign is kept beside `out` until everything is written, so that
    the same call goes on after an interruption.

    Parameters
    ----------
    campaign, data : Path
        As for `open_campaign`.
    out : Path
        The folder of the results.
    structure, fn, cycles
        As for `reduce_campaign`.
    parts : str, optional
        Library ship or model file whose propeller and rudder the model gets.
    reference : str, optional
        Library ship, model file or derivative table to compare with.
    reference_name : str, optional
        Its name in the report.
    asked : str, optional
        A simpler structure: the report ends with what it lacks.
    jobs, memory
        As for `reduce_campaign`.

    Returns
    -------
    Outcome
        Files, table, findings, notes, the model or why there is none.
    """
    check_folder(out)
    donor = load_model(parts) if parts else None
    beside = _reference(reference, reference_name) if reference else None
    opened = open_campaign(campaign, data=data)
    kept = resume_folder(out)
    with shown() as progress:
        found = reduce_campaign(
            opened,
            structure=structure,
            fn=fn,
            cycles=cycles,
            progress=progress,
            jobs=jobs,
            memory=memory,
            resume=kept,
        )
    model, why = _model(found, donor)
    turns, why_not = _turns(found, model, reference, beside)
    why += why_not
    loop = None
    if asked:
        say(f"Diagnosing what the structure {asked} lacks ...")
        base = f"one set of derivatives ({asked}) over all speeds"
        loop = loop_of(begin(asked, opened), base, rounds=ROUNDS)
    say("Writing tables, figures and the report ...")
    files = write_reduction(found, out, model=model, reference=beside, turns=turns, loop=loop)
    forget(kept)
    content = {
        "campaign": opened.title,
        "out": str(out),
        "files": files,
        "structure": structure,
        "fn": fn,
        "runs": len(found.runs),
        "excluded": {run.id: reason for run, reason in opened.excluded},
        "findings": findings_of(found.findings),
        "notes": list(found.notes),
        "table": found.table.to_pandas().to_dict("records"),
        "model": "model.toml" if model else None,
        "model_lacks": why,
        "turns": [dict(track.metrics, Fn=track.Fn) for track in turns.tracks] if turns else [],
        "changes": changes(turns.tracks) if turns and len(turns.tracks) > 1 else {},
        "diagnosis": loop.diagnosis.to_dict() if loop else None,
    }
    lines = [*_words(found, beside, turns, why), *_missing(loop), "", f"Results: {out.resolve()}"]
    return Outcome(content=content, lines=[*lines, f"Report:  {out.resolve() / 'report.html'}"])


def demo(out: Path) -> Outcome:
    """The main job on the synthetic S175 programme that comes with pmmkit.

    Parameters
    ----------
    out : Path
        The folder of the results.

    Returns
    -------
    Outcome
        As `reduce`.
    """
    return reduce(
        datasets_folder() / "s175",
        out,
        parts="s175-3dof",
        reference="s175-3dof",
        reference_name="Son and Nomoto 1981",
        asked="cubic",
    )


def _missing(loop: Loop | None) -> list[str]:
    """What a simpler structure lacks, and how the error falls with it."""
    if loop is None:
        return []
    steps = zip(loop.fall.steps, loop.fall.errors, strict=True)
    shares = [f"{name} {100 * item.share():.1f}" for name, item in steps]
    end = loop.end or loop.diagnosis
    return [
        "",
        f"What {loop.base} lacks, step by step, with the error of left-out conditions in per cent "
        f"of the rms force: {', '.join(shares)}. {VERDICTS[end.verdict]}",
    ]


def _reference(given: str, name: str | None) -> Reference:
    """A library ship, a model file or a table, by what the text looks like."""
    if _is_table(given):
        return Reference(table=read_table(given), name=name or Path(given).stem)
    return Reference(table=hull_table(given), name=name or given)


def _is_table(given: str) -> bool:
    return Path(given).suffix.lower() in (".csv", ".nc", ".h5", ".xlsx")


def _model(found: Reduction, donor: Model | None) -> tuple[Model | None, list[str]]:
    """The model, and in words what it lacks."""
    try:
        model = model_of(found, donor)
    except (MissingPartError, ModelError) as error:
        return None, [f"No model.toml: {error}"]
    lacks = [name for name in PARTS if name not in model.parts]
    if not lacks:
        return model, []
    return model, [
        f"model.toml holds the hull without {' and '.join(lacks)}: {' '.join(model.notes[:2])} "
        f"With --parts a library ship (pmmkit ships) or a model file gives them."
    ]


def _turns(
    found: Reduction, model: Model | None, given: str | None, beside: Reference | None
) -> tuple[Turns | None, list[str]]:
    """Turning circles at the speeds of the tests and sweeps between them, or why there are none."""
    if model is None or any(name not in model.parts for name in PARTS):
        return None, []
    tested = model.Fn or tuple(sorted({round(item.froude, 4) for item in found.runs}))
    along = np.linspace(tested[0], tested[-1], STEPS if len(tested) > 1 else 1).tolist()
    speeds = [model.ship.speed(number, model.water.g) for number in tested]
    sweeps = {}
    try:
        tracks = [
            simulate(model, rudder_deg=HARD_OVER, speed=speed, compiled=False) for speed in speeds
        ]
        sweeps["these derivatives"] = froude_sweep(
            model, Fn=along, rudder_deg=HARD_OVER, compiled=False
        )
    except SimulationError as error:
        return None, [f"No turning circle: {error}"]
    if given and beside and not _is_table(given):
        sweeps[beside.name] = froude_sweep(given, Fn=along, rudder_deg=HARD_OVER, compiled=False)
    return Turns(tracks=tracks, sweeps=sweeps, notes=model.notes), []


def _words(
    found: Reduction, beside: Reference | None, turns: Turns | None, why: Sequence[str]
) -> list[str]:
    lines = [headline(found.table, beside), ""]
    counts = {
        severity: sum(item.severity == severity for item in found.findings)
        for severity in ("warning", "info")
    }
    lines.append(
        f"Checks: {counts['warning']} warnings, {counts['info']} remarks; "
        f"{len(found.notes)} notes on what the runs do not tell (see the report)."
    )
    lines += why
    if turns:
        lines += ["", f"Turning circle, {HARD_OVER:g}° of rudder, {turns.tracks[0].scale}:"]
        lines.append(turn_table(turns))
    return lines


def headline(table: DerivativeTable, beside: Reference | None) -> str:
    """The table in plain text: a row per derivative, a column per Froude number.

    Parameters
    ----------
    table : DerivativeTable
        Our values.
    beside : Reference or None
        Values to compare with.
    """
    grid = tables.derivatives(table, beside)
    names = [name for channel in CHANNELS for name in table.names if name[0] == channel]
    cells = [row[1:] for group in grid.groups for row in group.rows]
    rows = [[name, *(cell or "–" for cell in row)] for name, row in zip(names, cells, strict=True)]
    return f"{grid.caption}\n\n{aligned(list(grid.head), rows)}"


def turn_table(turns: Turns) -> str:
    """The measures of the turning circle in plain text.

    Parameters
    ----------
    turns : Turns
        Turns at several speeds.
    """
    names = ("advance_L", "transfer_L", "tactical_diameter_L", "steady_diameter_L")
    moved = changes(turns.tracks) if len(turns.tracks) > 1 else {}
    rows = [
        [
            name.replace("_L", " / L").replace("_", " "),
            *(f"{track.metrics[name]:.3f}" for track in turns.tracks),
            *([percent(moved[name])] if moved else []),
        ]
        for name in names
    ]
    head = ["", *(f"Fn {track.Fn:.3f}" for track in turns.tracks)]
    return aligned([*head, "change"] if moved else head, rows)
