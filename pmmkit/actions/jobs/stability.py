"""Show straight-line stability, Nomoto's constants and the curve of steady turns."""

from __future__ import annotations

from typing import Final

from pmmkit.actions.outcome import Outcome, marked, results_folder, written
from pmmkit.actions.setting import settings, stem
from pmmkit.actions.shared import Depth, Extrapolate, Model, Out
from pmmkit.actions.speeds import Speed, approach

STAGE: Final = ("predict", 3)
EXAMPLE: Final = "pmmkit stability kvlcc2 --speed 8"


@settings
class StabilitySettings:
    """What is asked."""

    model: Model
    speed: Speed = None
    depth: Depth = None
    extrapolate: Extrapolate = False
    out: Out = None


def stability(job: StabilitySettings) -> Outcome:
    """Do what is asked."""
    from pmmkit.models import load_model
    from pmmkit.simulation import spiral_curve
    from pmmkit.simulation import stability as stability_linear

    folder = results_folder(job.out, f"{stem(job.model)}-stability")
    loaded = load_model(job.model)
    pace = approach(job.speed, loaded)
    found = stability_linear(loaded, pace, depth=job.depth, extrapolate=job.extrapolate)
    curve = spiral_curve(loaded, pace, depth=job.depth, extrapolate=job.extrapolate)
    numbers = {
        "name": found.name,
        "speed": pace,
        "stable": found.stable,
        "side": found.side,
        **found.constants(),
        "eigenvalues": [[x.real, x.imag] for x in found.eigenvalues.tolist()],
        "loop_width_deg": curve.loop_width_deg,
        "loop_height_deg_s": curve.loop_height_deg_s,
        "neutral_deg": curve.neutral_deg,
        "scale": loaded.scale,
    }
    results = [
        ("stability.json", numbers),
        ("spiral.csv", curve.to_pandas()),
        ("spiral.svg", curve.plot().save),
    ]
    lines = [str(found), "", curve.sentence(), f"Scale: {loaded.scale}"]
    return marked(written(folder, results, numbers, lines), loaded)
