"""The work behind ``pmmkit diagnose``."""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path

from pmmkit.checks import examine, refuse
from pmmkit.cli.console import Outcome, json_text
from pmmkit.cli.findings import findings_of
from pmmkit.cli.options import stem
from pmmkit.cli.tracks import check_folder
from pmmkit.diagnosis.findings import Diagnosis, Finding
from pmmkit.diagnosis.session import begin
from pmmkit.files import atomic_folder
from pmmkit.report.loop import VERDICTS, loop_of, write_diagnosis
from pmmkit.runs.campaign_file import open_campaign
from pmmkit.structures import STRUCTURES


def diagnose(
    model: str, campaign: Path, out: Path, *, floor: float = 0.005, given: Sequence[str] = (),
    noise: float | None = None, drawn: bool = True, data: Path | None = None,
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
    floor : float
        What is too small to matter, over the rms force of a channel.
    given : sequence of str
        Effects that are known to be there.
    noise : float, optional
        Uncertainty of a mean or harmonic over the rms force, of runs that state none.
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
            f"{name} {before:.3g} to {after:.3g} {'N' if name in 'XY' else 'N m'}"
            for name, (before, after) in item.errors.items() if name in item.channels
        ]  # fmt: skip
        lines.append(
            f"  Error of left-out conditions: {100 * item.error_before:.2f} % to "
            f"{100 * item.error_after:.2f} % of the rms forces"
            + (f" ({', '.join(falls)})." if falls else ": it does not fall.")
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
