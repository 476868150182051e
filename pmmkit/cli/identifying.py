"""The work behind ``pmmkit identify``."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final, Literal

import numpy as np

from pmmkit.campaigns.file.campaign_file import open_campaign
from pmmkit.checks import examine, refuse
from pmmkit.cli.console import Outcome, json_text
from pmmkit.cli.findings import findings_of
from pmmkit.cli.identifying_input import Chosen, chosen_records, known_before, parameters_of
from pmmkit.cli.tracks import check_folder
from pmmkit.errors import UnknownNameError
from pmmkit.files import atomic_folder
from pmmkit.identification.binding import AROUND
from pmmkit.identification.comparing import (
    BEFORE,
    UNITS,
    MethodComparison,
    compare_methods,
    predicted_window,
)
from pmmkit.identification.consistency import Consistency, consistency
from pmmkit.identification.filters import Filtered
from pmmkit.identification.methods import METHODS, Identified
from pmmkit.identification.predict import reference
from pmmkit.identification.record import CHANNELS
from pmmkit.identification.smoother import Smoothed
from pmmkit.models import load_model, save_model
from pmmkit.presentation import aligned
from pmmkit.progress import shown

WIDE: Final = 1.96
FAR: Final = 3.0
"""Values so many standard deviations of the prior away from it are named."""


@dataclass(frozen=True, kw_only=True)
class _Work:
    """All that one call of the command found."""

    title: str
    used: Chosen
    held_out: Chosen | None
    found: MethodComparison
    references: tuple[Smoothed, ...]
    tests: Mapping[str, Consistency]
    findings: Sequence[Mapping[str, Any]]


def identify(
    campaign: Path,
    out: Path,
    *,
    model: str,
    method: str = "ekf",
    derivatives: Sequence[str] | None = None,
    prior: str | None = None,
    spread: float | None = None,
    runs: Sequence[str] | None = None,
    test_runs: Sequence[str] | None = None,
    channels: Sequence[str] | None = None,
    sensors: Mapping[str, float] | None = None,
    rudder: Literal["auto", "measured", "ordered"] = "auto",
    wind: bool = True,
    shortest: float | None = None,
    window: float = 60.0,
    extrapolate: bool = False,
    data: Path | None = None,
) -> Outcome:
    """Identify a model from the free-running runs of a campaign, and write everything.

    Parameters
    ----------
    campaign, data : Path
        As for `open_campaign`.
    out : Path
        Folder of the results.
    model : str
        Library ship or model file.
    method : str
        One method, or ``all``.
    derivatives : sequence of str, optional
        Parameters; all derivatives of the hull if absent.
    prior : str, optional
        Library ship, model file or derivative table; the model if absent.
    spread : float, optional
        Relative standard deviation before.
    runs, test_runs : sequence of str, optional
        Patterns of runs to identify from, and of those held out.
    channels, rudder, wind, shortest
        As for `free_records`.
    sensors : mapping of str to float, optional
        Standard deviations of channels, SI and radians.
    window : float
        Length of the predicted windows [s].
    extrapolate : bool
        Allow a speed outside the range of the model's values.

    Returns
    -------
    Outcome
        With parameters, errors, tests of the filters and notes.
    """
    check_folder(out)
    base = load_model(model)
    if lost := [name for name in sensors or {} if name not in CHANNELS]:
        raise UnknownNameError(f"There is no channel {', '.join(lost)}: {', '.join(CHANNELS)}.")
    opened = open_campaign(campaign, data=data)
    findings = examine(opened)
    refuse(findings)
    used, held_out = chosen_records(
        opened,
        base,
        runs=runs,
        test_runs=test_runs,
        channels=channels,
        rudder=rudder,
        wind=wind,
        shortest=shortest,
    )
    names = parameters_of(base, derivatives)
    before = known_before(
        base, names, used.records[0].speed, prior=prior, spread=spread, extrapolate=extrapolate
    )
    judged = (held_out or used).long_enough(window)
    references = reference(base, judged, sensors=sensors, extrapolate=extrapolate)
    with shown() as progress:
        found = compare_methods(
            base,
            used.records,
            names,
            methods=METHODS if method == "all" else (method,),
            references=references,
            window=window,
            prior=before,
            sensors=sensors,
            extrapolate=extrapolate,
            progress=progress,
        )
    tests = {
        name: consistency(item.detail)
        for name, item in found.found.items()
        if isinstance(item.detail, Filtered)
    }
    work = _Work(
        title=opened.title,
        used=used,
        held_out=held_out,
        found=found,
        references=references,
        tests=tests,
        findings=findings_of(findings),
    )
    content = _content(work)
    files = _write(work, out, content, extrapolate=extrapolate)
    lines = [*_words(work), "", f"Results: {out}"]
    return Outcome(content={"out": str(out), "files": files, **content}, lines=lines)


def _write(work: _Work, out: Path, content: Mapping[str, Any], *, extrapolate: bool) -> list[str]:
    """All files of the results, or none."""
    found = work.found
    from pmmkit.figures import identification as figures
    from pmmkit.plotting.style import save

    with atomic_folder(out) as folder:
        found.parameters().to_csv(folder / "identified.csv", index=False)
        errors = found.errors()
        errors.insert(2, "held_out", work.held_out is not None)
        errors.to_csv(folder / "predictions.csv", index=False)
        (folder / "identified.json").write_text(json_text(content) + "\n", encoding="utf-8")
        for name, item in found.found.items():
            ending = "" if len(found.found) + len(found.failed) == 1 else f"_{name}"
            save_model(item.model, folder / f"model{ending}.toml")
        save(figures.identified_parameters(list(found.found.values())), folder / "parameters.svg")
        for name in work.tests:
            detail = found.found[name].detail
            histories = figures.parameter_histories(
                detail, work.used.records, found.model.convention
            )
            save(histories, folder / f"history_{name}.svg")
            drawn = figures.innovation_figure(detail, work.used.records)
            save(drawn, folder / f"innovations_{name}.svg")
        models = {BEFORE: found.model, **{name: x.model for name, x in found.found.items()}}
        sailed = predicted_window(
            models, work.references, window=found.window, extrapolate=extrapolate
        )
        save(figures.window_figure(sailed), folder / "prediction.svg")
        return sorted(file.name for file in folder.iterdir())


def _content(work: _Work) -> dict[str, Any]:
    found = work.found
    predictions = {
        name: {**item.errors, "all": item.pooled()} for name, item in found.predictions.items()
    }
    return {
        "campaign": work.title,
        "model": found.model.name,
        "used": work.used.content(),
        "held_out": work.held_out.content() if work.held_out else None,
        "prior": found.prior.origin,
        "window": found.window,
        "units": dict(UNITS),
        "methods": {
            name: {
                "parameters": item.to_pandas().reset_index().to_dict("records"),
                "unseen": list(item.unseen),
                "left_out": _left_out(item),
                "seconds": item.seconds,
                "notes": list(item.notes),
                "errors": predictions.get(name, {}),
                "consistency": work.tests[name].to_pandas().to_dict("records")
                if name in work.tests
                else None,
                "judgement": list(work.tests[name].words()) if name in work.tests else [],
            }
            for name, item in found.found.items()
        },
        "failed": dict(found.failed),
        "errors_before": predictions.get(BEFORE, {}),
        "findings": list(work.findings),
    }


def _words(work: _Work) -> list[str]:
    """What the command prints."""
    found = work.found
    lines = [f"{work.title}: identified with {found.model.name}", *work.used.words("Used")]
    if work.held_out is not None:
        lines += work.held_out.words("Held out")
    lines += dict.fromkeys(f"{item['severity']}: {item['message']}" for item in work.findings)
    lines += ["", f"Prior: {found.prior.origin}. Values with half of the 95 % interval:"]
    lines.append(_table(found))
    for name, item in found.found.items():
        if item.unseen:
            lines.append(
                f"{name}: the records do not determine {', '.join(item.unseen)}; the model keeps "
                f"what was known before."
            )
        if far := _far(item):
            lines.append(
                f"{name}: more than {FAR:g} standard deviations from what was known before: "
                f"{', '.join(far)}. Either the prior is wrong, or these take up what the model "
                f"lacks."
            )
        if left := _left_out(item):
            lines.append(f"{name}: left out, since the records do not need them: {', '.join(left)}")
    if set(found.prior.names) & set(AROUND):
        lines.append("The current is no part of a model: predictions sail without it.")
    lines += [f"{name} FAILED: {why}" for name, why in found.failed.items()]
    lines += ["", _judged(work), _errors(found)]
    lines.append("")
    for name, item in found.found.items():
        lines += [f"{name}: {text}" for text in item.notes]
        if name in work.tests:
            lines += [f"{name}: {text}" for text in work.tests[name].words()]
    return lines


def _table(found: MethodComparison) -> str:
    """Prior and results side by side."""
    rows = [
        [name, _cell(mean, std), *(_found(item, name) for item in found.found.values())]
        for name, mean, std in zip(
            found.prior.names, found.prior.mean.tolist(), found.prior.std.tolist(), strict=True
        )
    ]
    return aligned(["parameter", "prior", *found.found], rows)


def _found(item: Identified, name: str) -> str:
    if name not in item.names:
        return "held"
    if name in _left_out(item):
        return "left out"
    if name in item.unseen:
        return "not determined"
    i = item.names.index(name)
    return _cell(float(item.values[i]), float(item.std[i]))


def _cell(value: float, std: float) -> str:
    """A value and half of its interval, to two digits of the latter."""
    half = WIDE * std
    if not math.isfinite(half) or half <= 0.0:
        return f"{value:.4g}"
    digits = min(max(1 - math.floor(math.log10(half)), 0), 9)
    return f"{value:.{digits}f} ± {half:.{digits}f}"


def _left_out(item: Identified) -> list[str]:
    """Terms that a sparse regression found absent."""
    return [name for name in getattr(item.detail, "left_out", ()) if name in item.names]


def _far(item: Identified) -> list[str]:
    """Parameters that ended far from their prior."""
    away = np.abs(item.values - item.prior.mean) / item.prior.std
    gone = {*_left_out(item), *item.unseen}
    return [
        name
        for name, far in zip(item.names, away.tolist(), strict=True)
        if far > FAR and name not in gone
    ]


def _judged(work: _Work) -> str:
    windows = next(iter(work.found.predictions.values())).pooled()["windows"]
    what = (
        "the runs held out"
        if work.held_out is not None
        else "the very runs that were used, which is no test: hold some out with --test-runs"
    )
    return (
        f"Root mean square errors over {windows:.0f} windows of {work.found.window:g} s with the "
        f"measured rudder, of {what}:"
    )


def _errors(found: MethodComparison) -> str:
    rows = []
    for name, item in found.predictions.items():
        pooled = item.pooled()
        time = f"{found.found[name].seconds:.2f} s" if name in found.found else ""
        rows.append([name, *(_number(pooled[error]) for error in UNITS), time])
    head = [f"{error.replace('_', ' ')} [{unit}]" for error, unit in UNITS.items()]
    return aligned(["model", *head, "time"], rows)


def _number(value: float) -> str:
    return f"{value:.3g}" if np.isfinite(value) else "-"
