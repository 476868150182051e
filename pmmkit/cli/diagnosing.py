"""The work behind ``pmmkit diagnose``."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from pmmkit.campaigns.file.campaign_file import open_campaign
from pmmkit.checks import examine, refuse
from pmmkit.cli.console import Outcome, json_text
from pmmkit.cli.diagnosing_records import Asked, diagnose_records
from pmmkit.cli.diagnosis_words import words
from pmmkit.cli.findings import findings_of
from pmmkit.cli.options import stem
from pmmkit.cli.tracks import check_folder
from pmmkit.diagnosis.findings import Diagnosis
from pmmkit.effects.grammar import own_effects
from pmmkit.errors import DataError
from pmmkit.files import atomic_folder
from pmmkit.loop.session import begin
from pmmkit.models import load_model
from pmmkit.report.loop import loop_of, write_diagnosis
from pmmkit.structures import structures


def diagnose(
    model: str,
    campaign: Path,
    out: Path,
    *,
    floor: float | None = None,
    given: Sequence[str] = (),
    noise: float | None = None,
    own: Path | None = None,
    records: Asked | None = None,
    drawn: bool = True,
    data: Path | None = None,
) -> Outcome:
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
        What is too small to matter, over the rms force of a channel; as for
        `diagnose_captive`, 0.02 for free-running records if absent.
    given : sequence of str
        Effects that are known to be there.
    noise : float, optional
        Uncertainty of a mean or harmonic over the rms force, of runs that state none.
    own : Path, optional
        File of the user's own effects.
    records : Asked, optional
        What is asked of free-running records.
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
        if given or noise is not None or own is not None:
            raise DataError(
                "--given, --noise and --own belong to captive tests; these runs run free."
            )
        return diagnose_records(
            load_model(model),
            opened,
            out,
            asked=records or Asked(),
            floor=floor,
            drawn=drawn,
            checks=findings_of(checked),
        )
    if records is not None and records != Asked():
        raise DataError("Options of free-running records are of no use for captive tests.")
    session = begin(model, opened, floor=floor, noise=noise, own=own_effects(own) if own else ())
    for effect in given:
        session = session.add(effect, "known to be there")
    loop = loop_of(session, model)
    found = loop.diagnosis
    content = {
        **found.to_dict(),
        "campaign": opened.title,
        "model": model,
        "checks": findings_of(checked),
    }
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
        "",
        f"Results: {out}",
    ]
    lines += _next(model, campaign, found)
    return Outcome(content={"out": str(out), "files": files, **content}, lines=lines)


def _next(model: str, campaign: Path, found: Diagnosis) -> list[str]:
    """The command that puts the findings into the model."""
    if not found.findings:
        return []
    names = " ".join(item.effect for item in found.findings)
    if model in structures():
        reduced = f"{stem(campaign)}-reduced"
        return [
            f"Next: pmmkit reduce {campaign} --structure {model} --fn pooled --out {reduced}",
            f"      pmmkit add {reduced}/model.toml {names} --fit {campaign} -o model2.toml",
        ]
    return [f"Next: pmmkit add {model} {names} --fit {campaign} -o model2.toml"]
