"""``pmmkit simulate``."""

from __future__ import annotations

from typing import Annotated, Final

import typer

from pmmkit.cli.options import (
    Depth,
    Extrapolate,
    Figures,
    Follow,
    Manoeuvre,
    Model,
    More,
    RudderDeg,
    SwitchDeg,
    settings_of,
    stated,
    stem,
)
from pmmkit.cli.output import Outcome, marked
from pmmkit.cli.outputs import Out, results_folder
from pmmkit.cli.sea import (
    WAVES,
    WaveHeight,
    WavePeriod,
    WaveSpeeds,
    carried,
    first_order,
    new_notes,
    stated_sea,
)
from pmmkit.cli.speeds import CurrentSpeed, Speed, WindSpeed, approach
from pmmkit.presentation import text_of

EXAMPLE: Final = "pmmkit simulate kvlcc2 --manoeuvre zigzag --rudder-deg 10 --speed '15.5 kn'"


def simulate(
    model: Model,
    speed: Speed = None,
    manoeuvre: Manoeuvre = "turning",
    fn: Follow = "approach",
    rudder_deg: RudderDeg = None,
    switch_deg: SwitchDeg = None,
    heading_deg: Annotated[
        float | None, typer.Option(help="Change of heading of a course change or initial turn.")
    ] = None,
    step_deg: Annotated[float | None, typer.Option(help="Rudder step of a spiral.")] = None,
    turns: Annotated[
        float | None,
        typer.Option(help="Revolutions over those of the approach: stopping, accelerating."),
    ] = None,
    duration: Annotated[
        float | None, typer.Option(help="Seconds of a turn; until it is steady if absent.")
    ] = None,
    more: More = None,
    rudder_rate_deg: Annotated[
        float | None, typer.Option(help="Rate of the steering gear in deg/s; the ship's if absent.")
    ] = None,
    wind_speed: WindSpeed = 0.0,
    wind_direction_deg: Annotated[
        float, typer.Option(help="Where it comes from, from the bow of the approach.")
    ] = 0.0,
    current_speed: CurrentSpeed = 0.0,
    current_direction_deg: Annotated[
        float, typer.Option(help="Where it flows to, from the bow of the approach.")
    ] = 0.0,
    wave_height: WaveHeight = None,
    wave_period: WavePeriod = None,
    waves_from_deg: Annotated[
        float, typer.Option(help="Where they come from, from the bow of the approach.")
    ] = 0.0,
    wave_speeds: WaveSpeeds = None,
    wave_motion: Annotated[
        bool,
        typer.Option(
            "--wave-motion", help="Superpose heave, roll, pitch and yaw at wave frequency."
        ),
    ] = False,
    seed: Annotated[int, typer.Option(help="Of the phases of these waves.")] = 0,
    depth: Depth = None,
    extrapolate: Extrapolate = False,
    figures: Figures = True,
    out: Out = None,
) -> Outcome:
    """Simulate a manoeuvre: track, metrics and figures."""
    from pmmkit.files import write_results
    from pmmkit.models import load_model
    from pmmkit.simulation import imo_turning, metrics_of, simulate, track_files, verdict_sections

    folder = results_folder(out, f"{stem(model)}-{manoeuvre}")
    loaded = load_model(model)
    pace = approach(speed, loaded)
    sea = stated_sea(wave_height, wave_period)
    if wave_motion and sea is None:
        raise typer.BadParameter(WAVES)
    rough = carried(loaded, sea, model, pace, waves_from_deg, wave_speeds)
    track = simulate(
        rough.model,
        manoeuvre,
        speed=pace,
        fn=fn,
        rudder_rate_deg=rudder_rate_deg,
        wind_speed=wind_speed,
        wind_direction_deg=wind_direction_deg,
        current_speed=current_speed,
        current_direction_deg=current_direction_deg,
        depth=depth,
        extrapolate=extrapolate,
        **stated(
            rudder_deg=rudder_deg,
            switch_deg=switch_deg,
            heading_deg=heading_deg,
            step_deg=step_deg,
            turns=turns,
            duration=duration,
        )
        | settings_of(more),
    )
    results, drawn = list(track_files(track)), track.figures() if figures else {}
    moved = None
    if wave_motion and sea is not None:
        moved = first_order(track, rough, sea, model, waves_from_deg, seed)
        results.append(("wave_motion.csv", moved.to_pandas()))
        drawn |= {"wave_motion": moved.plot()} if figures else {}
    if drawn:
        from pmmkit.plotting import figure_files

        results += figure_files(drawn, "svg")
    files = write_results(folder, results)
    verdicts = imo_turning(track) if track.manoeuvre == "turning" else []
    judged = [text_of(verdict_sections(verdicts)), ""] if verdicts else []
    if judged and sea is not None:
        judged.append("note: The standard asks for a calm; these numbers are those in waves.")
    told = [*new_notes(rough, loaded), "", *([str(moved), ""] if moved else [])]
    lines = [str(track), "", *(told if sea else []), *judged, f"Results: {folder}"]
    return marked(
        Outcome(content={"out": str(folder), "files": files, **metrics_of(track)}, lines=lines),
        loaded,
    )
