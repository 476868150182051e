"""What the function of a model says of itself: the comment that MATLAB shows as its help."""

from __future__ import annotations

import hashlib
from collections.abc import Sequence
from typing import Final

from pmmkit.exports.text import written_by
from pmmkit.models import Model, model_text
from pmmkit.syntax import comment

_STATES: Final = {
    "u": ("surge velocity", "m/s"),
    "v": ("sway velocity", "m/s"),
    "r": ("yaw velocity", "rad/s"),
    "x": ("position in x-direction", "m"),
    "y": ("position in y-direction", "m"),
    "psi": ("yaw angle", "rad"),
    "p": ("roll velocity", "rad/s"),
    "phi": ("roll angle", "rad"),
    "delta": ("actual rudder angle", "rad"),
    "n": ("actual shaft velocity", "rpm"),
}


def meaning(model: Model) -> str:
    """What the derivatives of a model are, in words."""
    convention = model.convention
    unit = {
        "prime": "forces over rho/2 L^2 U^2, moments over rho/2 L^3 U^2",
        "prime-d": "forces over rho/2 L d U^2, moments over rho/2 L^2 d U^2",
        "bis": "forces over rho g volume, moments over rho g volume L, speeds over sqrt(g L)",
    }[convention.system]
    coriolis = {
        "separate": "Coriolis terms of the added mass in the equations of motion",
        "in-derivatives": "Coriolis terms of the added mass inside the derivatives",
    }[convention.coriolis]
    return f"derivatives in the {convention.system} system ({unit}), {coriolis}"


def heading(
    model: Model,
    called: str,
    states: Sequence[str],
    inputs: Sequence[str],
    *,
    speed: float | None,
    revolutions: float | None,
    about: bool,
) -> list[str]:
    """The comment behind the first line: states, inputs, axes, sources, the program.

    speed [m/s]; revolutions [1/s].
    """
    listed = " ".join(states)
    lines = comment(
        f"[xdot,U] = {called} returns the speed U in m/s (optionally) and the time derivative of "
        f"the state vector x = [ {listed} ]' for {model.title or model.name}, "
        f"L = {model.ship.L:g} m."
    )
    lines.append("%")
    for name in states:
        text, unit = _STATES[name]
        if name == "u" and about:
            text = "perturbed surge velocity about U0"
        lines += comment(f"{name:<5} = {text} ({unit})")
    lines += ["%", *comment(f"Input: ui = [ {' '.join(inputs)} ]'"), "%"]
    lines += comment("delta_c = commanded rudder angle (rad)")
    if "n_c" in inputs:
        follows = "" if "n" in states else ", which the shaft has at once"
        lines += comment(f"n_c = commanded shaft velocity (rpm){follows}")
        if revolutions is not None:
            lines += comment(
                f"Without n_c: {60 * revolutions:.6g} rpm, self-propulsion at {speed:g} m/s."
            )
    if ",U0)" in called:
        lines += comment(f"U0 = nominal speed (m/s), {speed:g} m/s if left out")
    lines += [
        "%",
        *comment(
            "Axes: x forward, y to starboard, z down, origin midship. A positive rudder angle "
            "(delta and delta_c) turns the ship to starboard. Calm water, no current."
        ),
    ]
    if model.Fn:
        assert speed is not None
        froude = model.ship.froude(speed, model.water.g)
        ends = ", ".join(f"{x:.4g}" for x in model.Fn)
        lines += comment(f"Values at Fn {froude:.4g} ({speed:g} m/s), from those at Fn {ends}.")
    lines += comment(f"Scale: {model.scale}") if model.scale else []
    for note in model.notes:
        lines += comment(f"Note: {note}")
    digest = hashlib.sha256(model_text(model).encode()).hexdigest()
    lines += ["%", *written_by()]
    lines += comment(f"Model: {model.name}; SHA-256 of its file as pmmkit writes it: {digest}")
    for step in model.history:
        lines += comment(f"Step: {step}")
    return lines
