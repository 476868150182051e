"""``pmmkit add``."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Final

import typer

from pmmkit.cli.options import Data, DrawFigures, Floor, Noise, Own, sound_campaigns
from pmmkit.cli.output import Outcome, marked
from pmmkit.cli.outputs import Force, Out, results_file, results_folder
from pmmkit.cli.records import (
    WINDOW,
    Channels,
    Judged,
    RecordOptions,
    Runs,
    Sensors,
    Shortest,
    Spread,
    TestRuns,
    Windage,
    Window,
    errors_table,
)
from pmmkit.cli.sessions import session_about
from pmmkit.presentation import aligned

if TYPE_CHECKING:
    from pmmkit.campaigns import Campaign
    from pmmkit.diagnosis import Fall
    from pmmkit.models import Model
    from pmmkit.simulation import Track


EXAMPLE: Final = "pmmkit add model.toml nonlinear_added_mass --fit my-campaign -o model2.toml"


def add(
    model: Annotated[str, typer.Argument(help="Library ship or model file.")],
    effects: Annotated[
        list[str] | None,
        typer.Argument(
            help="Effects to add, one after another; roll: a roll of its own, by the heel of "
            "free-running records and GM and Ix of their campaign file. A fault of one of several "
            "campaigns is named with it: current@'my trials'."
        ),
    ] = None,
    *,
    fit: Annotated[
        list[Path],
        typer.Option(
            "--fit",
            help="Campaign to which the model is fitted with them; several of one ship by several "
            "--fit.",
        ),
    ],
    target: Annotated[
        Path | None, typer.Option("-o", "--output", help="Model file to write.")
    ] = None,
    steps: Annotated[
        Path | None,
        typer.Option(
            help="File of steps, as pmmkit workbench saves them, to carry out again in place of "
            "effects that are named."
        ),
    ] = None,
    undo: Annotated[
        bool, typer.Option("--undo", help="Take the effect that was added last out again.")
    ] = False,
    why: Annotated[str, typer.Option(help="A remark for the model's history.")] = "",
    floor: Floor = None,
    noise: Noise = None,
    own: Own = None,
    runs: Runs = None,
    test_runs: TestRuns = None,
    channels: Channels = None,
    spread: Spread = None,
    shortest: Shortest = None,
    sensors: Sensors = None,
    windage: Windage = None,
    judged: Judged = None,
    window: Window = WINDOW,
    figures: DrawFigures = True,
    data: Data = None,
    out: Out = None,
    force: Force = False,
) -> Outcome:
    """Add effects to a model, fit them together with it, and show how the error falls."""
    from pmmkit.campaigns import sailing
    from pmmkit.diagnosis import read_session, undone
    from pmmkit.effects import ROLL_PART, own_effects
    from pmmkit.files import write_results
    from pmmkit.models import load_model, save_model

    asked = RecordOptions(
        runs=runs,
        test_runs=test_runs,
        channels=channels,
        spread=spread,
        shortest=shortest,
        sensors=sensors,
        windage=windage,
        judged=judged,
        window=window,
    )
    if [undo, bool(effects), steps is not None].count(True) != 1:
        raise typer.BadParameter("Name an effect to add, or a file with --steps, or say --undo.")
    kept = read_session(steps) if steps else None
    if out is not None:
        results_folder(out, out)
    written = results_file(
        target, f"{Path(model).stem}-extended.toml", read=[model, own], force=force
    )
    before = load_model(model)
    effects_of_user = own_effects(own) if own else ()
    taken = ""
    if undo:
        before, taken = undone(before, effects_of_user)
    opened = {name: one for name, (one, _) in sound_campaigns(fit, data).items()}
    sailed = opened[sailing(opened)]
    base = before
    rest = [step.effect for step in kept.steps] if kept else list(effects or ())
    if ROLL_PART in rest:
        base = _rolling(before, sailed, asked)
        rest.remove(ROLL_PART)
    rolled = [str(step) for step in base.history[len(before.history) :]]
    fall: Fall | None = None
    held_out: Mapping[str, Mapping[str, float]] = {}
    after = base
    if rest or undo:
        least = kept.floor if kept else floor
        session = session_about(base, opened, rest, asked, least, noise, effects_of_user)
        for step in kept.steps if kept else ():
            session = session.add(step, step.note)
        for effect in () if kept else rest:
            name, _, campaign = effect.partition("@")
            session = session.add(name, why, campaign=campaign)
        after, fall, held_out = session.model(), session.fall(), session.held_out_errors()
    save_model(after, written)
    turns = _turns(before, after, sailed)
    content = {
        "model": str(written),
        "added": rest if kept else effects or [],
        "taken_out": taken,
        "errors": fall.to_pandas().to_dict("records") if fall else [],
        "held_out": {name: dict(row) for name, row in held_out.items()},
        "useless": list(fall.useless) if fall else [],
        "turning": {name: _lengths(track) for name, track in turns.items()},
        "standing": turns["after"].standing.to_dict() if turns else None,
        "notes": list(after.notes),
        "history": list(after.history),
    }
    files = write_results(out, _files(fall, figures)) if out is not None and fall else []
    lines = _words(fall, taken, rolled, turns)
    if held_out:
        lines += ["", f"Windows of {window:g} s of the runs held out:", errors_table(held_out)]
    lines += [f"note: {text}" for text in after.notes if text not in before.notes]
    lines += ["", f"Model: {written}", *([f"Results: {out}"] if out is not None else [])]
    done = Outcome(content={"out": str(out or ""), "files": files, **content}, lines=lines)
    return marked(done, after)


def _rolling(model: Model, campaign: Campaign, asked: RecordOptions) -> Model:
    """The model with a roll of its own, by the heel of free-running records."""
    from pmmkit.base import DataError
    from pmmkit.cli.options import sensors_of
    from pmmkit.effects import ROLL_PART
    from pmmkit.identification import with_roll

    if campaign.kind != "free-running":
        raise DataError(
            f"{ROLL_PART} is found from the heel of free-running records; K of captive tests gives "
            f"it to the model that pmmkit reduce writes."
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
    from pmmkit.plotting import save

    figure = [("error_fall.svg", partial(save, fall.plot()))] if drawn else []
    return [("error_fall.csv", fall.to_pandas()), *figure]


def _turns(before: Model, after: Model, campaign: Campaign) -> dict[str, Track]:
    """Turning circles with both models at the middle speed of the tests; empty if they cannot."""
    from pmmkit.base import PmmkitError
    from pmmkit.conventions import HARD_OVER
    from pmmkit.simulation import simulate

    speeds = sorted({run.settings.speed for run in campaign.runs})
    ship = campaign.ship
    Fn = ship.froude(speeds[len(speeds) // 2], campaign.water.g)
    found = {}
    for name, model in (("before", before), ("after", after)):
        try:
            found[name] = simulate(
                model, "turning", rudder_deg=HARD_OVER, speed=model.ship.speed(Fn, model.water.g)
            )
        except PmmkitError:
            return {}
    return found


def _lengths(track: Track) -> dict[str, float]:
    """The measures of a turning circle in ship lengths."""
    from pmmkit.simulation import LENGTHS

    return {key: track.metrics[key] for key in LENGTHS if key in track.metrics}


def _words(
    fall: Fall | None, taken: str, rolled: Sequence[str], turns: Mapping[str, Track]
) -> list[str]:
    from pmmkit.conventions import HARD_OVER

    lines = [f"Taken out: {taken}.", ""] if taken else []
    lines += rolled
    lines += [str(fall)] if fall else []
    if turns:
        lines += ["", f"Turning circle, rudder {HARD_OVER:g}°, in ship lengths:"]
        measured = {name: _lengths(track) for name, track in turns.items()}
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
