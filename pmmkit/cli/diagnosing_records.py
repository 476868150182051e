"""The work behind ``pmmkit diagnose`` on free-running records."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

from pmmkit.campaigns.run import Campaign
from pmmkit.cli.console import Outcome, json_text, say
from pmmkit.cli.diagnosis_words import words
from pmmkit.cli.identifying_input import chosen_records
from pmmkit.diagnosis.free_running.diagnose import diagnose_free
from pmmkit.files import atomic_folder
from pmmkit.models import Model, save_model
from pmmkit.presentation import aligned

FLOOR: Final = 0.02
SPREAD: Final = (0.05, 0.1)
"""Relative standard deviations of a model's values: beside a covariance, and without one."""


@dataclass(frozen=True, kw_only=True)
class Asked:
    """What a user says of free-running records.

    Parameters
    ----------
    runs, test_runs : sequence of str, optional
        Patterns of the runs that are diagnosed, and of those held out.
    channels : sequence of str, optional
        Channels to use.
    sensors : mapping of str to float, optional
        Standard deviations of channels, SI and radians.
    spread : float, optional
        Relative standard deviation of the model's values before.
    shortest : float, optional
        Shortest segment [s].
    windage : (float, float), optional
        Frontal and lateral area above water [m²].
    judged : float, optional
        Length of the windows by which sets are judged [s].
    window : float
        Length of the windows in which runs held out are predicted [s].
    """

    runs: Sequence[str] | None = None
    test_runs: Sequence[str] | None = None
    channels: Sequence[str] | None = None
    sensors: Mapping[str, float] | None = None
    spread: float | None = None
    shortest: float | None = None
    windage: tuple[float, float] | None = None
    judged: float | None = None
    window: float = 60.0


def diagnose_records(
    model: Model,
    campaign: Campaign,
    out: Path,
    *,
    asked: Asked,
    floor: float | None,
    checks: Sequence[Mapping[str, Any]],
    drawn: bool,
) -> Outcome:
    """Diagnose free-running records, and write everything.

    Parameters
    ----------
    model : Model
        Complete, at the scale of the records.
    campaign : Campaign
        Free-running runs.
    out : Path
        Folder of the results.
    asked : Asked
        What the user says.
    floor, drawn
        As for `diagnose`.
    checks : sequence of mapping
        What the checks of the data found.
    """
    used, kept = chosen_records(
        campaign,
        model,
        runs=asked.runs,
        test_runs=asked.test_runs,
        channels=asked.channels,
        rudder="auto",
        wind=True,
        shortest=asked.shortest,
    )
    beside, alone = SPREAD
    if asked.spread is not None:
        beside, alone = (0.0 if model.covariance is None else asked.spread), asked.spread
    found = diagnose_free(
        model,
        used.records,
        spread=beside,
        loose=alone,
        windage=asked.windage,
        sensors=asked.sensors,
        floor=FLOOR if floor is None else floor,
        window=asked.judged,
        held_out=kept.records if kept else (),
        held_out_window=asked.window if kept else None,
        progress=say,
    )
    errors = {name: dict(row) for name, row in found.errors.items()}
    content = {
        **found.to_dict(),
        "campaign": campaign.title,
        "model": model.name,
        "errors": errors,
        "used": used.content(),
        "held_out": kept.content() if kept else None,
        "checks": checks,
    }
    with atomic_folder(out) as folder:
        (folder / "diagnosis.json").write_text(json_text(content) + "\n", encoding="utf-8")
        found.to_pandas().to_csv(folder / "effects.csv", index=False)
        for name, made in (("model", found.model), ("model_refitted", found.refitted)):
            if made is not None:
                save_model(made, folder / f"{name}.toml")
        if drawn:
            from pmmkit.figures import diagnosis as figures
            from pmmkit.plotting.style import save

            save(figures.evidence(found), folder / "evidence.svg")
            save(figures.coverage(found), folder / "coverage.svg")
        files = sorted(file.name for file in folder.iterdir())
    lines = [
        f"{campaign.title}: {len(used.records)} records against {model.name}",
        *used.words("Used"),
        *(kept.words("Held out") if kept else []),
        *dict.fromkeys(f"{item['severity']}: {item['message']}" for item in checks),
        *words(found),
        "",
        "Root mean square errors over windows with the measured rudder:",
        _errors(errors),
        *found.notes,
        "",
        f"Results: {out}",
    ]
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
    "heading": "deg",
    "position": "m",
    "position_end": "m",
    "speed": "m/s",
    "yaw_rate": "deg/s",
}
