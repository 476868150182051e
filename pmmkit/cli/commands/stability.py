"""``pmmkit stability``."""

from __future__ import annotations

from functools import partial

from pmmkit.cli.options import Depth, Extrapolate, Model, Out, Speed, results_folder, stem
from pmmkit.cli.output import Outcome
from pmmkit.presentation import aligned


def stability(
    model: Model,
    speed: Speed,
    depth: Depth = None,
    extrapolate: Extrapolate = False,
    out: Out = None,
) -> Outcome:
    """Straight-line stability, Nomoto's constants and the curve of steady turns."""
    from pmmkit.figures import steady_turns
    from pmmkit.files import write_results
    from pmmkit.models import load_model
    from pmmkit.plotting.style import save
    from pmmkit.simulation import linear
    from pmmkit.simulation.spiral import spiral_curve

    folder = results_folder(out, f"{stem(model)}-stability")
    loaded = load_model(model)
    found = linear.stability(loaded, speed, depth=depth, extrapolate=extrapolate)
    curve = spiral_curve(loaded, speed, depth=depth, extrapolate=extrapolate)
    constants = {
        "C": found.C,
        "lever_sway": found.lever_sway,
        "lever_yaw": found.lever_yaw,
        "K": found.K,
        "T": found.T,
        "T1": found.T1,
        "T2": found.T2,
        "T3": found.T3,
        "Ydelta": found.rudder[0],
        "Ndelta": found.rudder[1],
    }
    numbers = {
        "name": found.name,
        "speed": speed,
        "stable": found.stable,
        "side": found.side,
        **constants,
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
            ("spiral.svg", partial(save, steady_turns(curve))),
        ],
    )
    word = "stable" if found.stable else "UNSTABLE"
    if found.side != "both":
        word += f" (turning to {found.side}, the less stable side)"
    loop = (
        f"The spiral has a loop {curve.loop_width_deg:.2f}° wide and "
        f"{curve.loop_height_deg_s:.3f}°/s high about a rudder of {curve.neutral_deg:+.2f}°."
        if curve.loop_width_deg > 0
        else f"The spiral has no loop; the ship runs straight at {curve.neutral_deg:+.2f}°."
    )
    lines = [
        f"{found.name} at {speed:g} m/s is straight-line {word}.",
        aligned(
            ["number (prime system)", "value"],
            [[name, f"{value:.4g}"] for name, value in constants.items()],
        ),
        "Eigenvalues [U/L]: " + ", ".join(f"{x:.4g}" for x in found.eigenvalues.tolist()),
        loop,
        f"Results: {folder}",
    ]
    return Outcome(content={"out": str(folder), "files": files, **numbers}, lines=lines)
