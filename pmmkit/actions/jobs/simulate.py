"""Simulate a manoeuvre: track, metrics and figures."""

from __future__ import annotations

from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

from pmmkit.actions.outcome import Outcome, figure_files, marked, results_folder, written
from pmmkit.actions.sea import WAVES, WaveSettings, carried, first_order, new_notes
from pmmkit.actions.setting import SettingError, setting, settings, stem
from pmmkit.actions.shared import (
    Depth,
    Extrapolate,
    Figures,
    Follow,
    Manoeuvre,
    Model,
    OrderSettings,
    Out,
)
from pmmkit.actions.speeds import CurrentSpeed, Speed, WindSpeed, approach
from pmmkit.base import shown
from pmmkit.presentation import text_of

if TYPE_CHECKING:
    from pmmkit.simulation import Track

STAGE: Final = ("predict", 1)
EXAMPLE: Final = "pmmkit simulate kvlcc2 --manoeuvre zigzag --rudder-deg 10 --speed '15.5 kn'"


@settings
class SteeringSettings(OrderSettings):
    """What is ordered in the manoeuvre."""

    heading_deg: float | None = setting(
        "Change of heading of a course change or initial turn.", default=None, unit="°"
    )
    step_deg: float | None = setting("Rudder step of a spiral.", default=None, unit="°")
    turns: float | None = setting(
        "Revolutions over those of the approach: stopping, accelerating.", default=None
    )
    duration: float | None = setting(
        "Seconds of a turn; until it is steady if absent.", default=None, unit="s"
    )
    rudder_rate_deg: float | None = setting(
        "Rate of the steering gear in deg/s; the ship's if absent.", default=None, unit="°/s"
    )


@settings
class TrackWaveSettings(WaveSettings):
    """Waves."""

    waves_from_deg: float = setting(
        "Where they come from, from the bow of the approach.", default=0.0
    )
    hold_speed: bool = setting(
        "Revolutions that hold the speed in the waves; else those that hold it without them.",
        default=False,
    )
    wave_motion: bool = setting(
        "Superpose heave, roll, pitch and yaw at wave frequency.", default=False
    )
    seed: int = setting("Of the phases of these waves.", default=0)


@settings
class ConditionSettings:
    """Wind, current and depth."""

    wind_speed: WindSpeed = 0.0
    wind_direction_deg: float = setting(
        "Where it comes from, from the bow of the approach.",
        default=0.0,
        usual=(0.0, 355.0, 5.0),
        unit="°",
    )
    current_speed: CurrentSpeed = 0.0
    current_direction_deg: float = setting(
        "Where it flows to, from the bow of the approach.", default=0.0
    )
    depth: Depth = None


@settings
class SimulateSettings:
    """What is asked."""

    model: Model
    speed: Speed = None
    manoeuvre: Manoeuvre = "turning"
    fn: Follow = "approach"
    orders: SteeringSettings = SteeringSettings()
    conditions: ConditionSettings = ConditionSettings()
    waves: TrackWaveSettings = TrackWaveSettings()
    extrapolate: Extrapolate = False
    figures: Figures = True
    forces: bool = setting(
        "Forces of each effect over time too: forces.csv and a figure.", default=False
    )
    animate: str | None = setting(
        "Animation with these forces: name of its file among the results, such as turn.gif, or "
        "turn.mp4 where ffmpeg is installed.",
        default=None,
    )
    out: Out = None


def simulate(job: SimulateSettings) -> Outcome:
    """Do what is asked."""
    from pmmkit.imo import imo_turning, metrics_of, verdict_sections
    from pmmkit.models import load_model
    from pmmkit.simulation import simulate

    if job.animate is not None and Path(job.animate).name != job.animate:
        raise SettingError(f"{job.animate}: name a file alone; it goes to the folder of --out.")
    folder = results_folder(job.out, f"{stem(job.model)}-{job.manoeuvre}")
    loaded = load_model(job.model)
    pace = approach(job.speed, loaded)
    sea = job.waves.sea
    if job.waves.wave_motion and sea is None:
        raise SettingError(WAVES)
    pushed = job.forces or job.animate is not None
    rough, motions, of_sea = carried(loaded, job.waves, job.model, pace)
    track = simulate(
        rough,
        job.manoeuvre,
        speed=pace,
        fn=job.fn,
        extrapolate=job.extrapolate,
        revolutions="speed" if job.waves.hold_speed else None,
        forces=pushed,
        **vars(job.conditions),
        **job.orders.given(),
    )
    metrics, drawn = metrics_of(track), track.figures() if job.figures else {}
    results: list[tuple[str, Any]] = [("track.csv", track.to_csv()), ("metrics.json", metrics)]
    if pushed:
        results.append(("forces.csv", track.forces_to_pandas()))
    moved = None
    if job.waves.wave_motion and sea is not None:
        moved = first_order(
            track, rough, motions, sea, job.model, job.waves.waves_from_deg, job.waves.seed
        )
        results.append(("wave_motion.csv", moved.to_pandas()))
        drawn |= {"wave_motion": moved.plot()} if job.figures else {}
    if drawn:
        results += figure_files(drawn, "svg")
    if job.animate is not None:
        results.append((job.animate, partial(_animated, track)))
    verdicts = imo_turning(track) if track.manoeuvre == "turning" else []
    judged = [text_of(verdict_sections(verdicts)), ""] if verdicts else []
    if judged and sea is not None:
        judged.append("note: The standard asks for a calm; these numbers are those in waves.")
    told = [*new_notes(rough, of_sea, loaded), "", *([str(moved), ""] if moved else [])]
    lines = [str(track), "", *(told if sea else []), *judged]
    return marked(written(folder, results, metrics, lines), loaded)


def _animated(track: Track, path: Path) -> None:
    """Write the animation of a track, and tell how far it is."""
    with shown() as progress:
        track.animate(path, progress=progress)
