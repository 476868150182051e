"""Reduce captive tests to a table of derivatives, a model and a report.

Runs in water of several depths give all of that at each depth, and how derivatives grow.

Typed again after an interruption it goes on with the runs that were not yet read.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import asdict
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final, Literal

from pmmkit.actions.outcome import NOT_USABLE, Outcome, not_made, results_folder, say, words_of
from pmmkit.actions.setting import cycles_of, setting, settings, stem
from pmmkit.actions.shared import (
    STRUCTURE,
    Campaign,
    Cycles,
    Data,
    ExecutionSettings,
    Out,
    Sets,
    StructureName,
)
from pmmkit.base import DataError
from pmmkit.presentation import aligned, counted

if TYPE_CHECKING:
    from pmmkit.campaigns import Campaign as Opened
    from pmmkit.models import DerivativeTable, Model, ReferenceTable
    from pmmkit.models import Missing as Gaps
    from pmmkit.reduction import Reduction
    from pmmkit.views import Loop, Turns

STAGE: Final = ("measure", 4)
EXAMPLE: Final = "pmmkit reduce my-campaign --parts s175-3dof"
MOST: Final = 8
"""Differences between methods that are printed."""
ROUNDS: Final = 3
"""Rounds of naming and adding in a demo."""


Method = Literal["regression", "harmonics", "sindy", "ekf", "all"]
"""How derivatives are found, or all ways side by side."""
Fourier = Literal["least-squares", "trapezoid"]
"""Fourier coefficients by least squares, or by integrals over the third cycle."""


@settings
class EstimationSettings:
    """How derivatives are found."""

    method: Method = setting(
        "One regression over all runs; harmonics and curve fits test by test; terms "
        "chosen among a library (sindy); a Kalman filter through the histories (ekf); all of "
        "them side by side.",
        default="regression",
    )
    library: str | None = setting(
        "What sindy chooses from besides: name of a structure, or derivatives. The terms "
        "of all structures in the same variables if absent.",
        default=None,
    )
    fourier: Fourier = setting(
        "Fourier coefficients of harmonics: by least squares, or by trapezoidal "
        "integrals over the third cycle (or --cycles).",
        default="least-squares",
    )


@settings
class ReadingSettings(ExecutionSettings):
    """Where it runs."""

    memory: float = setting(
        "Memory that the workers of this machine may take together in MB.", default=1000.0, least=1
    )


@settings
class ReduceSettings:
    """What is asked."""

    campaign: Campaign
    structure: StructureName = STRUCTURE
    fn: Sets = "each"
    cycles: Cycles = None
    estimation: EstimationSettings = EstimationSettings()
    parts: str | None = setting(
        "Library ship or model file of this ship that lends propeller and rudder; if "
        "absent they are what the tests show, the campaign file states, or an estimate.",
        default=None,
    )
    missing: Literal["estimate", "zero", "library", "refuse"] = setting(
        "Derivatives that the tests do not give: an estimate from the particulars with "
        "its uncertainty, zero, added mass of the library ship, or no model.",
        default="estimate",
    )
    reference: str | None = setting(
        "Library ship, model file or table to compare with.", default=None
    )
    odd_runs: Literal["tell", "weigh", "refuse"] = setting(
        "A run at odds with the others: warned of, also weighed down, or refused.", default="tell"
    )
    data: Data = None
    execution: ReadingSettings = ReadingSettings()
    out: Out = None
    force: bool = setting(
        "Make a model of derivatives that are not usable, which stays marked; let the "
        "output replace the very file that was read.",
        default=False,
    )


def reduce(job: ReduceSettings) -> Outcome:
    """Do what is asked."""
    place = results_folder(
        job.out, f"{stem(job.campaign)}-reduced", read=[job.parts, job.reference], force=job.force
    )
    return reduced(job, place)


def reduced(
    job: ReduceSettings, out: Path, *, reference_name: str = "", lacking: str = "", title: str = ""
) -> Outcome:
    """Reduce a campaign and write everything.

    What was read of a large campaign is kept beside `out` until everything is written, so that
    the same call goes on after an interruption.
    """
    from pmmkit.actions.depths import over_depths
    from pmmkit.campaigns import open_campaign
    from pmmkit.models import ReferenceTable, load_model

    settings = {
        "structure": job.structure,
        "fn": job.fn,
        "cycles": cycles_of(job.cycles),
        "odd_runs": job.odd_runs,
        "executor": job.execution.executor,
        **vars(job.estimation),
    }
    opened = open_campaign(job.campaign, data=job.data)
    if opened.not_made and not opened.runs:
        raise DataError(
            f"None of the {counted(len(opened.not_made), 'run')} is made yet.",
            remedy="Save records under the names that the campaign file has; then type it again.",
        )
    opened = opened.with_(title=title) if title else opened
    one = partial(
        _at_one_depth,
        job=job,
        settings=settings,
        donor=load_model(job.parts) if job.parts else None,
        beside=ReferenceTable.of(job.reference, reference_name) if job.reference else None,
        lacking=lacking,
    )
    depths = opened.by_depth()
    return one(opened, out)[0] if len(depths) == 1 else over_depths(depths, out, one)


def _at_one_depth(
    opened: Opened,
    out: Path,
    *,
    job: ReduceSettings,
    settings: Mapping[str, Any],
    donor: Model | None,
    beside: ReferenceTable | None,
    lacking: str,
) -> tuple[Outcome, Reduction]:
    """Reduce runs in water of one depth and write everything."""
    from pmmkit.base import shown
    from pmmkit.files import MODEL
    from pmmkit.reduction import reduce_campaign, resumable
    from pmmkit.views import Loop, write_reduction

    with resumable(out) as kept:
        with shown() as progress:
            found = reduce_campaign(
                opened, progress=progress, memory=job.execution.memory, resume=kept, **settings
            )
        model, why = _model(found, donor, job.missing, force=job.force)
        turns, why_not = _turns(found, model, beside)
        why += why_not
        loop = None
        if lacking:
            from pmmkit.diagnosis import begin  # half a second, for a demo alone

            say(f"Diagnosing what the structure {lacking} lacks ...")
            base = f"one set of derivatives ({lacking}) over all speeds"
            loop = Loop.of(begin(lacking, opened), base, rounds=ROUNDS)
        say("Writing tables, figures and the report ...")
        files = write_reduction(found, out, model=model, reference=beside, turns=turns, loop=loop)
    judged = found.verdict
    content = {
        "campaign": opened.title,
        "out": str(out),
        "files": files,
        "structure": found.table.provenance["structure"] if found.because else job.structure,
        "fn": job.fn,
        "runs": len(found.runs),
        "excluded": {run.id: reason for run, reason in found.campaign.excluded},
        "findings": [item.to_dict() for item in found.findings],
        "notes": list(found.notes),
        "untold": [item.to_dict() for item in found.untold],
        "verdict": judged.told(),
        "table": found.table.to_pandas().to_dict("records"),
        "method": found.method,
        "methods": _methods(found),
        "differences": [asdict(item) for item in found.differences],
        "model": MODEL.file if model else None,
        "model_lacks": why,
        "turns": [dict(track.metrics, Fn=track.Fn) for track in turns.tracks] if turns else [],
        "changes": turns.changes if turns else {},
        "diagnosis": loop.diagnosis.to_dict() if loop else None,
    }
    lines = [*_words(found, beside, turns, why), *_missing(loop), *not_made(opened)]
    lines += ["", f"Results: {out.resolve()}"]
    outcome = Outcome(
        content=content,
        lines=[*lines, f"Report:  {out.resolve() / 'report.html'}", "", str(judged)],
        status=NOT_USABLE if judged.faults else 0,
    )
    return outcome, found


def _missing(loop: Loop | None) -> list[str]:
    """What a simpler structure lacks, and how the error falls with it."""
    if loop is None:
        return []
    steps = zip(loop.fall.steps, loop.fall.totals, strict=True)
    shares = [f"{name} {error:.1f}" for name, error in steps]
    end = loop.end or loop.diagnosis
    return [
        "",
        f"What {loop.base} lacks, step by step, with the error of left-out conditions in per cent "
        f"of the rms force: {', '.join(shares)}. {end.sentence}",
    ]


def _model(
    found: Reduction, donor: Model | None, missing: Gaps, *, force: bool
) -> tuple[Model | None, list[str]]:
    """The model and in words what of it these tests do not show, or why there is none."""
    from pmmkit.api import model_of
    from pmmkit.base import NotUsableError, PmmkitError

    try:
        model = model_of(found, donor, missing=missing, force=force)
    except NotUsableError:
        return None, [
            "No model.toml: the derivatives are not usable. --force makes one, which stays marked."
        ]
    except PmmkitError as error:
        return None, [f"No model.toml: {words_of(error)}"]
    return model, [note for note in model.notes if note not in found.table.notes]


def _turns(
    found: Reduction, model: Model | None, beside: ReferenceTable | None
) -> tuple[Turns | None, list[str]]:
    """Turning circles, or why there are none."""
    from pmmkit.base import PmmkitError
    from pmmkit.views import Turns

    if model is None or model.lacking:
        return None, []
    tested = sorted({round(item.froude, 4) for item in found.runs})
    try:
        turns = Turns.of(model, tested, beside)
    except PmmkitError as error:
        return None, [f"No turning circle: {words_of(error)}"]
    return turns, [f"No turning circle: {text}" for text in turns.failed]


def _methods(found: Reduction) -> dict[str, dict[str, Any]]:
    """What each method has to say, for JSON."""
    return {
        name: {
            "seconds": estimate.seconds,
            "notes": list(estimate.notes),
            "table": estimate.table.to_pandas().to_dict("records"),
            "shares": {key: own.tolist() for key, own in estimate.shares.items()},
            "innovations": estimate.tests.to_pandas().to_dict("records") if estimate.tests else [],
        }
        for name, estimate in found.estimates.items()
    }


def _side_by_side(found: Reduction) -> list[str]:
    """How far the methods are apart, and why."""
    lines = []
    for name, estimate in found.estimates.items():
        far = found.farthest(name)
        if far is not None:
            lines.append(
                f"{estimate.method}: at most {abs(far.sigma):.1f} standard deviations from the "
                f"regression ({far.derivative} {far.place}), {estimate.seconds:.1f} s."
            )
        lines += [f"  {text}" for text in (estimate.tests.words() if estimate.tests else ())]
    apart = found.differences
    lines += [f"  {item.sentence}" for item in apart[:MOST]]
    if len(apart) > MOST:
        lines.append(f"  and {len(apart) - MOST} more in the report.")
    if len(found.estimates) > 1 and not apart:
        lines.append("No method differs from the regression beyond both intervals.")
    return ["", *lines] if lines else []


def _words(
    found: Reduction, beside: ReferenceTable | None, turns: Turns | None, why: Sequence[str]
) -> list[str]:
    from pmmkit.conventions import Criterion

    reasons = found.verdict.reasons
    doubts = ["Doubts:", *(f"  - {reason}" for reason in reasons), ""] if reasons else []
    chosen = [found.because, ""] if found.because else []
    lines = [*doubts, *chosen, headline(found.table, beside), ""]
    counts = {
        severity: sum(item.severity == severity for item in found.findings)
        for severity in ("warning", "info")
    }
    lines.append(
        f"Checks: {counted(counts['warning'], 'warning')}, {counted(counts['info'], 'remark')}; "
        f"{counted(len(found.notes), 'note')} on what the runs do not tell (see the report)."
    )
    loud = [item for item in found.findings if item.severity == "warning"]
    lines += [" ".join(filter(None, (str(item), item.remedy))) for item in loud]
    lines += [*_side_by_side(found), *why]
    if turns:
        lines += [
            "",
            f"Turning circle, {Criterion.HARD_OVER:g}° of rudder, {turns.tracks[0].scale}:",
        ]
        lines.append(turn_table(turns))
        stands = [text for track in turns.tracks for text in track.standing.sentences]
        lines += dict.fromkeys(stands)
    return lines


def headline(table: DerivativeTable, beside: ReferenceTable | None) -> str:
    """The table in plain text: a row per derivative, a column per Froude number."""
    from pmmkit.views import reference_values

    values = (beside.name, reference_values(table, beside)) if beside else None
    return "\n".join(table.grid(beside=values).lines())


def turn_table(turns: Turns) -> str:
    """The measures of the turning circle in plain text."""
    from pmmkit.presentation import fixed, percent

    moved = turns.changes
    rows = [
        [
            name.replace("_L", " / L").replace("_", " "),
            *(fixed(track.metrics[name], 3) for track in turns.tracks),
            *([percent(moved[name])] if moved else []),
        ]
        for name in turns.tracks[0].circle
    ]
    head = ["", *(f"Fn {track.Fn:.3f}" for track in turns.tracks)]
    return aligned([*head, "change"] if moved else head, rows)
