"""Add effects to a model, fit them together with it, and show how the error falls."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

from pmmkit.actions.outcome import Outcome, marked, results_file, results_folder
from pmmkit.actions.records import (
    RecordSettings,
    errors_table,
    middle_speed,
    session_about,
    sound_campaigns,
)
from pmmkit.actions.setting import SettingError, sensors_of, setting, settings
from pmmkit.actions.shared import Data, DrawFigures, Force, NoiseSettings, Out, Output, Own
from pmmkit.presentation import aligned

if TYPE_CHECKING:
    from pmmkit.campaigns import Campaign
    from pmmkit.diagnosis import Fall
    from pmmkit.models import Model
    from pmmkit.simulation import Track


STAGE: Final = ("explain", 3)
EXAMPLE: Final = "pmmkit add model.toml nonlinear_added_mass --fit my-campaign -o model2.toml"


@settings
class AddSettings:
    """What is asked."""

    model: str = setting("Library ship or model file.", argument=True)
    effects: tuple[str, ...] = setting(
        "Effects to add, one after another; roll: a roll of its own, by the heel of "
        "free-running records and GM and Ix of their campaign file. A fault of one of several "
        "campaigns is named with it: current@'my trials'.",
        default=(),
        argument=True,
    )
    steps: Path | None = setting(
        "File of steps, as pmmkit workbench saves them, to carry out again in place of "
        "effects that are named.",
        default=None,
    )
    fit: tuple[Path, ...] = setting(
        "Campaign to which the model is fitted with them; several of one ship by several --fit."
    )
    data: Data = None
    records: RecordSettings = RecordSettings()
    uncertainty: NoiseSettings = NoiseSettings()
    own: Own = None
    output: Output = None
    undo: bool = setting("Take the effect that was added last out again.", default=False)
    why: str = setting("A remark for the model's history.", default="")
    figures: DrawFigures = True
    out: Out = None
    force: Force = False


def add(job: AddSettings) -> Outcome:
    """Do what is asked."""
    from pmmkit.diagnosis import read_session, undone
    from pmmkit.effects import own_effects
    from pmmkit.files import atomic_path, write_results
    from pmmkit.models import load_model, save_model

    if [job.undo, bool(job.effects), job.steps is not None].count(True) != 1:
        raise SettingError("Name an effect to add, or a file with --steps, or say --undo.")
    kept = read_session(job.steps) if job.steps else None
    if job.out is not None:
        results_folder(job.out, job.out)
    written = results_file(
        job.output,
        f"{Path(job.model).stem}-extended.toml",
        read=[job.model, job.own],
        force=job.force,
    )
    before = load_model(job.model)
    effects_of_user = own_effects(job.own) if job.own else ()
    taken = ""
    if job.undo:
        before, taken = undone(before, effects_of_user)
    opened = {name: one for name, (one, _) in sound_campaigns(job.fit, job.data, before).items()}
    sailed = max(opened.values(), key=lambda item: item.kind == "free-running")
    base = before
    rest = [step.effect for step in kept.steps] if kept else list(job.effects)
    if "roll" in rest:
        base = _rolling(before, sailed, job.records)
        rest.remove("roll")
    rolled = [str(step) for step in base.history[len(before.history) :]]
    fall: Fall | None = None
    held_out: Mapping[str, Mapping[str, float]] = {}
    after = base
    if rest or job.undo:
        least = kept.floor if kept else job.uncertainty.floor
        session = session_about(
            base, opened, rest, job.records, least, job.uncertainty.noise, effects_of_user
        )
        for step in kept.steps if kept else ():
            session = session.add(step, step.note)
        for effect in () if kept else rest:
            name, _, campaign = effect.partition("@")
            session = session.add(name, job.why, campaign=campaign)
        after, fall, held_out = session.model(), session.fall(), session.held_out_errors()
    turns = _turns(before, after, sailed)
    files: list[str] = []
    with atomic_path(written) as part:  # the model is there when its folder is, not long before
        save_model(after, part)
        if job.out is not None and fall:
            files = write_results(job.out, _files(fall, job.figures))
    content = {
        "model": str(written),
        "added": rest if kept else list(job.effects),
        "taken_out": taken,
        "errors": fall.to_pandas().to_dict("records") if fall else [],
        "held_out": {name: dict(row) for name, row in held_out.items()},
        "useless": list(fall.useless) if fall else [],
        "turning": {name: track.circle for name, track in turns.items()},
        "standing": turns["after"].standing.to_dict() if turns else None,
        "notes": list(after.notes),
        "history": list(after.history),
    }
    lines = _words(fall, taken, rolled, turns)
    if held_out:
        lines += [
            "",
            f"Windows of {job.records.window:g} s of the runs held out:",
            errors_table(held_out),
        ]
    lines += [f"note: {text}" for text in after.notes if text not in before.notes]
    lines += ["", f"Model: {written}", *([f"Results: {job.out}"] if job.out is not None else [])]
    done = Outcome(content={"out": str(job.out or ""), "files": files, **content}, lines=lines)
    return marked(done, after)


def _rolling(model: Model, campaign: Campaign, asked: RecordSettings) -> Model:
    """The model with a roll of its own, by the heel of free-running records."""

    from pmmkit.base import DataError
    from pmmkit.identification import with_roll

    if campaign.kind != "free-running":
        raise DataError(
            "roll is found from the heel of free-running records; K of captive tests gives "
            "it to the model that pmmkit reduce writes."
        )
    used, _ = asked.chosen(campaign, model)
    ship = model.ship
    return with_roll(
        model,
        used.records,
        GM=campaign.ship.GM if ship.GM is None else ship.GM,
        Ixx=campaign.ship.Ixx if ship.Ixx is None else ship.Ixx,
        sensors=sensors_of(asked.sensors),
    )


def _files(fall: Fall, drawn: bool) -> list[tuple[str, Any]]:

    figure = [("error_fall.svg", fall.plot().save)] if drawn else []
    return [("error_fall.csv", fall.to_pandas()), *figure]


def _turns(before: Model, after: Model, campaign: Campaign) -> dict[str, Track]:
    """Turning circles with both models at the middle speed of the tests; empty if they cannot."""
    from pmmkit.base import PmmkitError
    from pmmkit.conventions import Criterion
    from pmmkit.simulation import simulate

    found = {}
    for name, model in (("before", before), ("after", after)):
        try:
            found[name] = simulate(
                model,
                "turning",
                rudder_deg=Criterion.HARD_OVER,
                speed=middle_speed(campaign, model),
            )
        except PmmkitError:
            return {}
    return found


def _words(
    fall: Fall | None, taken: str, rolled: Sequence[str], turns: Mapping[str, Track]
) -> list[str]:
    from pmmkit.conventions import Criterion

    lines = [f"Taken out: {taken}.", ""] if taken else []
    lines += rolled
    lines += [str(fall)] if fall else []
    if turns:
        lines += ["", f"Turning circle, rudder {Criterion.HARD_OVER:g}°, in ship lengths:"]
        measured = {name: track.circle for name, track in turns.items()}
        names = list(measured["after"])
        lines.append(
            aligned(
                ["", *(name.removesuffix("_L").replace("_", " ") for name in names)],
                [
                    [key, *(f"{values[name]:.3f}" for name in names)]
                    for key, values in measured.items()
                ],
            )
        )
        lines += turns["after"].standing.sentences
    return lines
