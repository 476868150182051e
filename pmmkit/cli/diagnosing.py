"""The work behind ``pmmkit diagnose``."""

from __future__ import annotations

import importlib
import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, Final

from pmmkit.checks import examine, refuse
from pmmkit.cli.console import Outcome, aligned, json_text, say
from pmmkit.cli.findings import findings_of
from pmmkit.cli.identifying_input import chosen_records
from pmmkit.cli.options import stem
from pmmkit.cli.tracks import check_folder
from pmmkit.diagnosis.findings import UNITS, Diagnosis, Finding
from pmmkit.diagnosis.free import diagnose_free
from pmmkit.diagnosis.session import begin
from pmmkit.errors import DataError
from pmmkit.files import atomic_folder
from pmmkit.model import Model, load_model, save_model
from pmmkit.report.loop import VERDICTS, loop_of, write_diagnosis
from pmmkit.runs.campaign_file import open_campaign
from pmmkit.runs.run import Campaign
from pmmkit.structures import STRUCTURES


def diagnose(
    model: str, campaign: Path, out: Path, *, floor: float | None = None, given: Sequence[str] = (),
    noise: float | None = None, runs: Sequence[str] | None = None,
    test_runs: Sequence[str] | None = None, window: float = 60.0, drawn: bool = True,
    data: Path | None = None,
) -> Outcome:  # fmt: skip
    """Diagnose a campaign, and write everything.

    Parameters
    ----------
    model : str
        Model file, library ship or structure.
    campaign, data : Path
        As for `open_campaign`.
    out : Path
        Folder of the results.
    floor : float, optional
        What is too small to matter, over the rms force of a channel; 0.005 for captive tests, 0.02
        for free-running records if absent.
    given : sequence of str
        Effects that are known to be there.
    noise : float, optional
        Uncertainty of a mean or harmonic over the rms force, of runs that state none.
    runs, test_runs : sequence of str, optional
        Patterns of free-running runs that are diagnosed, and of those held out.
    window : float
        Length of the windows in which held-out runs are predicted [s].
    drawn : bool
        Whether to draw figures.

    Returns
    -------
    Outcome
    """
    check_folder(out)
    opened = open_campaign(campaign, data=data)
    checked = examine(opened)
    refuse(checked)
    if opened.kind == "free-running":
        if given or noise is not None:
            raise DataError(
                "--given and --noise belong to captive tests; these runs are free-running."
            )
        return diagnose_records(
            load_model(model), opened, out, floor=floor, runs=runs, test_runs=test_runs,
            window=window, checks=findings_of(checked), drawn=drawn,
        )  # fmt: skip
    if runs or test_runs:
        raise DataError("--runs and --test-runs belong to free-running records.")
    floor = FLOOR if floor is None else floor
    session = begin(model, opened, floor=floor, noise=noise)
    for effect in given:
        session = session.add(effect, "known to be there")
    loop = loop_of(session, model)
    found = loop.diagnosis
    content = {
        **found.to_dict(), "campaign": opened.title, "model": model,
        "checks": findings_of(checked),
    }  # fmt: skip
    with atomic_folder(out) as folder:
        (folder / "diagnosis.json").write_text(json_text(content) + "\n", encoding="utf-8")
        found.to_pandas().to_csv(folder / "effects.csv", index=False)
        loop.fall.to_pandas().to_csv(folder / "error_fall.csv", index=False)
        if drawn:
            write_diagnosis(loop, folder / "report.html", title=opened.title, runs=len(opened.runs))
        files = sorted(file.name for file in folder.iterdir())
    lines = [
        f"{opened.title}: {len(opened.runs)} runs against {model}",
        *dict.fromkeys(f"{item['severity']}: {item['message']}" for item in findings_of(checked)),
        *words(found),
        "", f"Results: {out}",
    ]  # fmt: skip
    lines += _next(model, campaign, found)
    return Outcome(content={"out": str(out), "files": files, **content}, lines=lines)


def diagnose_records(
    model: Model, campaign: Campaign, out: Path, *, floor: float | None,
    runs: Sequence[str] | None, test_runs: Sequence[str] | None, window: float,
    checks: Sequence[Mapping[str, Any]], drawn: bool,
) -> Outcome:  # fmt: skip
    """Diagnose free-running records, and write everything.

    Parameters
    ----------
    model : Model
        Complete, at the scale of the records.
    campaign : Campaign
        Free-running runs.
    out : Path
        Folder of the results.
    floor, runs, test_runs, window, drawn
        As for `diagnose`.
    checks : sequence of mapping
        What the checks of the data found.
    """
    used, kept = chosen_records(
        campaign, model, runs=runs, test_runs=test_runs, channels=None, rudder="auto", wind=True
    )
    found = diagnose_free(
        model, used.records, floor=RECORDS_FLOOR if floor is None else floor,
        held_out=kept.records if kept else (), held_out_window=window if kept else None,
        progress=say,
    )  # fmt: skip
    errors = {name: dict(row) for name, row in found.errors.items()}
    content = {
        **found.to_dict(), "campaign": campaign.title, "model": model.name, "errors": errors,
        "used": used.content(), "held_out": kept.content() if kept else None, "checks": checks,
    }  # fmt: skip
    with atomic_folder(out) as folder:
        (folder / "diagnosis.json").write_text(json_text(content) + "\n", encoding="utf-8")
        found.to_pandas().to_csv(folder / "effects.csv", index=False)
        for name, made in (("model", found.model), ("model_refitted", found.refitted)):
            if made is not None:
                save_model(made, folder / f"{name}.toml")
        if drawn:
            figures = importlib.import_module("pmmkit.figures.diagnosis")
            save = importlib.import_module("pmmkit.figures").save
            save(figures.evidence(found), folder / "evidence.svg")
            save(figures.coverage(found), folder / "coverage.svg")
        files = sorted(file.name for file in folder.iterdir())
    lines = [
        f"{campaign.title}: {len(used.records)} records against {model.name}",
        *used.words("Used"), *(kept.words("Held out") if kept else []),
        *dict.fromkeys(f"{item['severity']}: {item['message']}" for item in checks),
        *words(found), "", "Root mean square errors over windows with the measured rudder:",
        _errors(errors), *found.notes, "", f"Results: {out}",
    ]  # fmt: skip
    return Outcome(content={"out": str(out), "files": files, **content}, lines=lines)


def _errors(errors: Mapping[str, Mapping[str, float]]) -> str:
    names = [name for name in _ERRORS if any(name in row for row in errors.values())]
    head = [f"{name.replace('_', ' ')} [{_ERRORS[name]}]" for name in names]
    rows = [
        [what, *(f"{row[name]:.3g}" if name in row else "-" for name in names)]
        for what, row in errors.items()
    ]
    return aligned(["", *head], rows)


_ERRORS: Final = {
    "heading": "deg", "position": "m", "position_end": "m", "speed": "m/s", "yaw_rate": "deg/s",
}  # fmt: skip
FLOOR: Final = 0.005
RECORDS_FLOOR: Final = 0.02


def _next(model: str, campaign: Path, found: Diagnosis) -> list[str]:
    """The command that puts the findings into the model."""
    if not found.findings:
        return []
    names = " ".join(item.effect for item in found.findings)
    if model in STRUCTURES:
        reduced = f"{stem(campaign)}-reduced"
        return [
            f"Next: pmmkit reduce {campaign} --structure {model} --fn pooled --out {reduced}",
            f"      pmmkit add {reduced}/model.toml {names} --fit {campaign} -o model2.toml",
        ]
    return [f"Next: pmmkit add {model} {names} --fit {campaign} -o model2.toml"]


def words(found: Diagnosis) -> list[str]:
    """A diagnosis in sentences.

    Parameters
    ----------
    found : Diagnosis
        As `diagnose` gives it.
    """
    lines = [
        f"What is smooth and below {100 * found.floor:g} % of a channel's rms force is left alone.",
        f"Verdict: {VERDICTS[found.verdict]}",
    ]
    if found.given:
        lines.append(f"The base has already: {', '.join(found.given)}.")
    if found.findings:
        lines.append(f"Family: {', '.join(found.families)}.")
    for item in found.findings:
        lines += ["", *_finding(item)]
    if found.flags and found.findings:
        lines += ["", "It is not the whole story: something is left that no named effect explains. "
                  "Take it as the nearest relative."]  # fmt: skip
    lines += [f"  {reason}" for reason in found.flags[1:]]
    rivals = found.group[1:]
    if rivals:
        lines += ["", "These runs cannot tell it from:"]
        lines += [f"  {' and '.join(names)} ({_against(odds)})" for names, odds in rivals]
    hidden = found.not_testable
    if hidden:
        lines += ["", "These runs could not show:"]
        lines += [f"  {item.name}: {item.why}{_hides(item.hides)}" for item in hidden]
    return lines


def _finding(item: Finding) -> list[str]:
    """One effect: evidence, sizes, how the error of left-out conditions falls."""
    lines = [f"{item.effect}: {item.summary} Evidence {item.evidence}."]
    for name, value in item.coefficients.items():
        lines.append(f"  {_size(name, value, item.std[name], item.typical[name])}")
    if item.parameter:
        lines.append(f"  {item.parameter}: about {item.value:g}")
    if math.isfinite(item.error_before):
        falls = [
            f"{name} {before:.3g} to {after:.3g} {UNITS.get(name, 'N m')}"
            for name, (before, after) in item.errors.items() if name in item.channels
        ]  # fmt: skip
        shares = (
            f" {100 * item.error_before:.2f} % to {100 * item.error_after:.2f} % of the rms forces"
            if "heading" not in item.errors else ""
        )  # fmt: skip
        how = f" ({', '.join(falls)})." if shares and falls else f" {', '.join(falls)}."
        lines.append(
            f"  Error of what was left out:{shares}{how if falls else ' it does not fall.'}"
        )
    if item.rivals:
        lines.append(f"  On such runs it resembles: {', '.join(item.rivals)}.")
    if item.separating_test:
        lines.append(f"  To be sure: {item.separating_test}.")
    return lines


def _size(name: str, value: float, std: float, typical: float) -> str:
    """A coefficient with its uncertainty beside its usual size; a warning where it is far off."""
    text = f"{name} {value:.3g} ± {1.96 * std:.2g}, usual size {typical:.2g}"
    if abs(value) - 1.96 * std > _LARGE * abs(typical):
        text += " - far more than usual"
    elif abs(value) > 1.96 * std and value * typical < 0.0 and "[" not in name:
        text += " - of the other sign than usual"
    return text


_LARGE = 3.0


def _against(odds: float) -> str:
    return f"about {1.0 / odds:.0f} to 1 against it" if odds < 0.7 else "as likely"


def _hides(share: float) -> str:
    return f"; up to {share:.2g} of its usual size could hide" if math.isfinite(share) else ""
