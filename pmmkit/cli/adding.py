"""The work behind ``pmmkit add``."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any, Final

from pmmkit.campaigns.file.campaign_file import open_campaign
from pmmkit.campaigns.run import Campaign
from pmmkit.channels import CHANNEL_UNITS
from pmmkit.checks import examine, refuse
from pmmkit.cli.console import Outcome
from pmmkit.cli.tracks import check_folder
from pmmkit.effects.grammar import own_effects
from pmmkit.errors import PmmkitError
from pmmkit.files import atomic_folder
from pmmkit.loop.session import ErrorFall, begin, undone
from pmmkit.metrics import HARD_OVER
from pmmkit.models import Model, load_model, save_model
from pmmkit.presentation import aligned

METRICS: Final = ("advance_L", "transfer_L", "tactical_diameter_L", "steady_diameter_L")


def add(
    model: str,
    effects: Sequence[str],
    campaign: Path,
    target: Path,
    *,
    undo: bool = False,
    why: str = "",
    floor: float | None = None,
    noise: float | None = None,
    own: Path | None = None,
    drawn: bool = True,
    data: Path | None = None,
    out: Path | None = None,
) -> Outcome:
    """Add effects to a model with a joint fit, and write it.

    Parameters
    ----------
    model : str
        Model file or library ship.
    effects : sequence of str
        What is added, one after another.
    campaign, data : Path
        As for `open_campaign`.
    target : Path
        Model file to write.
    undo : bool
        Take the effect that was added last out again.
    why : str
        A remark for the history.
    floor : float, optional
        What is too small to matter, over the rms force of a channel; as for `diagnose_captive`.
    noise : float, optional
        Uncertainty of a mean or harmonic over the rms force, of runs that state none.
    own : Path, optional
        File of the user's own effects.
    drawn : bool
        Whether to draw figures into `out`.
    out : Path, optional
        Folder of the error fall as a table and a figure.

    Returns
    -------
    Outcome
    """
    if out is not None:
        check_folder(out)
    before = load_model(model)
    effects_of_user = own_effects(own) if own else ()
    taken = ""
    if undo:
        before, taken = undone(before, effects_of_user)
    opened = open_campaign(campaign, data=data)
    refuse(examine(opened))
    session = begin(before, opened, floor=floor, noise=noise, own=effects_of_user)
    for effect in effects:
        session = session.add(effect, why)
    after = session.model()
    fall = session.fall()
    save_model(after, target)
    turns = _turns(replace(session, steps=()).model(), after, opened)
    content = {
        "model": str(target),
        "added": list(effects),
        "taken_out": taken,
        "errors": fall.to_pandas().to_dict("records"),
        "useless": list(fall.useless),
        "turning": turns,
        "notes": list(after.notes),
        "history": list(after.history),
    }
    files = _write(fall, out, drawn) if out is not None else []
    lines = _words(fall, taken, turns)
    lines += [f"note: {text}" for text in after.notes if text not in before.notes]
    lines += ["", f"Model: {target}", *([f"Results: {out}"] if out is not None else [])]
    return Outcome(content={"out": str(out or ""), "files": files, **content}, lines=lines)


def _write(fall: ErrorFall, out: Path, drawn: bool) -> list[str]:
    with atomic_folder(out) as folder:
        fall.to_pandas().to_csv(folder / "error_fall.csv", index=False)
        if drawn:
            from pmmkit.figures import diagnosis as figures
            from pmmkit.plotting.style import save

            save(figures.error_fall(fall), folder / "error_fall.svg")
        return sorted(file.name for file in folder.iterdir())


def _turns(before: Model, after: Model, campaign: Campaign) -> dict[str, dict[str, float]]:
    """Turning circles with both models at the middle speed of the tests; empty if they cannot."""
    from pmmkit.simulation.simulate import simulate

    speeds = sorted({run.settings.speed for run in campaign.runs})
    ship = campaign.ship
    Fn = ship.froude(speeds[len(speeds) // 2], campaign.water.g)
    found = {}
    for name, model in (("before", before), ("after", after)):
        try:
            track = simulate(
                model,
                "turning",
                rudder_deg=HARD_OVER,
                speed=model.ship.speed(Fn, model.water.g),
                compiled=False,
            )
        except PmmkitError:
            return {}
        found[name] = {key: track.metrics[key] for key in METRICS if key in track.metrics}
    return found


def _words(fall: ErrorFall, taken: str, turns: Mapping[str, Mapping[str, float]]) -> list[str]:
    lines = [f"Taken out: {taken}."] if taken else []
    lines.append("Error of conditions left out of the fit, in per cent of the rms force:")
    frame = fall.to_pandas()
    channels = fall.errors[0].channels
    tests = list(dict.fromkeys(frame["test"]))
    rows = []
    for step, item in zip(fall.steps, fall.errors, strict=True):
        own = frame[frame["step"] == step]
        errors = own[own["test"] == "all"].set_index("channel")["error"]
        rows.append(
            [
                step if step == fall.steps[0] else f"+ {step}",
                f"{100 * item.share():.2f}",
                *(f"{float(errors[name]):.3g}" for name in channels),
                *(_per_test(own, test) for test in tests if test != "all"),
            ]
        )
    units = [f"{name} [{CHANNEL_UNITS[name]}]" for name in channels]
    lines.append(
        aligned(["step", "all", *units, *(t.replace("_", " ") for t in tests if t != "all")], rows)
    )
    for number, step in enumerate(fall.steps[1:], start=1):
        better = fall.errors[number].better_than(fall.errors[number - 1])
        lines.append(
            f"{step}: better in {100 * better:.0f} % of the conditions and channels it changes."
        )
    lines += [f"{step} does not lower the error of left-out conditions." for step in fall.useless]
    if turns:
        lines += ["", f"Turning circle, rudder {HARD_OVER:g}°, in ship lengths:"]
        names = list(turns["after"])
        lines.append(
            aligned(
                ["", *(name.removesuffix("_L").replace("_", " ") for name in names)],
                [
                    [key, *(f"{values[name]:.3f}" for name in names)]
                    for key, values in turns.items()
                ],
            )
        )
    return lines


def _per_test(own: Any, test: str) -> str:
    shares = own[own["test"] == test]["share"].dropna()
    return f"{100 * float((shares**2).mean() ** 0.5):.2f}" if len(shares) else "-"
