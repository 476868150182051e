"""``pmmkit stability``."""

from __future__ import annotations

from functools import partial
from typing import Final

from pmmkit.cli.options import Depth, Extrapolate, Model, stem
from pmmkit.cli.output import Outcome, marked
from pmmkit.cli.outputs import Out, results_folder
from pmmkit.cli.speeds import Speed, approach

EXAMPLE: Final = "pmmkit stability kvlcc2 --speed 8"


def stability(
    model: Model,
    speed: Speed = None,
    depth: Depth = None,
    extrapolate: Extrapolate = False,
    out: Out = None,
) -> Outcome:
    """Straight-line stability, Nomoto's constants and the curve of steady turns."""
    from pmmkit.files import write_results
    from pmmkit.models import load_model
    from pmmkit.plotting import save
    from pmmkit.simulation import spiral_curve
    from pmmkit.simulation import stability as stability_linear

    folder = results_folder(out, f"{stem(model)}-stability")
    loaded = load_model(model)
    pace = approach(speed, loaded)
    found = stability_linear(loaded, pace, depth=depth, extrapolate=extrapolate)
    curve = spiral_curve(loaded, pace, depth=depth, extrapolate=extrapolate)
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
    files = write_results(
        folder,
        [
            ("stability.json", numbers),
            ("spiral.csv", curve.to_pandas()),
            ("spiral.svg", partial(save, curve.plot())),
        ],
    )
    lines = [str(found), "", curve.sentence(), f"Scale: {loaded.scale}", f"Results: {folder}"]
    return marked(
        Outcome(content={"out": str(folder), "files": files, **numbers}, lines=lines), loaded
    )
