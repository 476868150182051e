"""From the numbers of a file to SI, ship axes and our signs, each step recorded in words."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar, Final, Literal

import numpy as np

from pmmkit.campaigns.test_kinds.registry import TEST_KINDS
from pmmkit.conventions import CHANNEL_UNITS, FORCE_CHANNELS, Convention, Ship, Water, harmonic_part
from pmmkit.numerics import Array

_AXIS_PARITY: Final[dict[str, str]] = {
    "X": "x",
    "u": "x",
    "udot": "x",
    "x": "x",
    "xdot": "x",
    "FX_rudder": "x",
    "Y": "y",
    "v": "y",
    "vdot": "y",
    "y": "y",
    "ydot": "y",
    "y_forward": "y",
    "y_aft": "y",
    "FY_rudder": "y",
    "N": "xy",
    "r": "xy",
    "rdot": "xy",
    "psi": "xy",
    "cog": "xy",
    "wind_direction": "xy",
    "K": "yz",
    "p": "yz",
    "pdot": "yz",
    "phi": "yz",
}
"""Axes whose reversal changes the sign of a channel."""


@dataclass(frozen=True, kw_only=True)
class Frame:
    """How the numbers of a source differ from ours.

    A force or velocity changes sign with its axis. A yaw moment and a yaw rate are positive from x
    towards y, so they change sign if one of x and y is reversed and keep it if both are; a roll
    moment, roll rate and heel are positive from y towards z. Reversing z alone therefore leaves N
    and turns K; reversing y and z (x forward, y to port, z up) turns Y, v, N and r and leaves K.
    The path and heading of free-running tests are taken to be stated in axes reversed alike, and so
    are displacements, yaw rates, heel and drift angles that a test was set to: a drift angle is a
    heading, unless `drift_positive` says where the bow is.

    Parameters
    ----------
    reversed_axes : str
        Their axes that point the other way, e.g. ``"xy"``.
    rudder_to_port : bool
        Whether a positive rudder turns the ship to port.
    drift_positive : {"starboard-bow", "port-bow"} or None
        Where the bow is at a positive drift; None where it goes with the axes.
    nondimensional : str or None
        System of their forces.
    symmetry_factor, density_factor : float
        What the forces of a CFD are multiplied by: 2 for half a domain, rho/rho_inf.
    """

    reversed_axes: str = ""
    rudder_to_port: bool = False
    drift_positive: Literal["starboard-bow", "port-bow"] | None = None
    nondimensional: str | None = None
    symmetry_factor: float = 1.0
    density_factor: float = 1.0
    TURNED: ClassVar[str] = "sign changed to our axes and rudder"
    """How the note begins that names the channels whose sign was changed."""

    def sign(self, channel: str) -> int:
        """-1 if a channel changes sign between their axes and ours.

        Examples
        --------
        >>> port_up = Frame(reversed_axes="yz")
        >>> [port_up.sign(channel) for channel in "XYNKvrp"]
        [1, -1, -1, 1, -1, -1, 1]
        """
        if channel == "delta":
            return -1 if self.rudder_to_port else 1
        turned = sum(axis in self.reversed_axes for axis in _AXIS_PARITY.get(channel, ""))
        return -1 if turned % 2 else 1

    @property
    def drift_sign(self) -> int:
        """-1 if a stated drift angle changes sign.

        Examples
        --------
        >>> Frame(reversed_axes="yz").drift_sign
        -1
        >>> Frame(reversed_axes="yz", drift_positive="starboard-bow").drift_sign
        1
        """
        if self.drift_positive is None:
            return self.sign("psi")
        return -1 if self.drift_positive == "port-bow" else 1

    def motion_sign(self, test: str) -> int:
        """-1 if the displacement of an oscillating test changes sign in our axes."""
        leading = TEST_KINDS[test].leading
        return 1 if leading is None else self.sign(leading.displacement)


def to_ours(
    values: Mapping[str, Array],
    *,
    frame: Frame,
    ship: Ship,
    water: Water,
    speed: float,
    dimensional: frozenset[str] = frozenset(),
    turn_harmonics: bool = False,
) -> tuple[dict[str, Array], list[str]]:
    """Forces from their system to N and N m, and all channels to our axes and signs.

    ship, water, speed [m/s].
    """
    out: dict[str, Array] = {}
    scaled: dict[str, float] = {}
    flipped: list[str] = []
    for name, numbers in values.items():
        part = harmonic_part(name)
        channel = part[0] if part else name
        factor = 1.0
        if channel in FORCE_CHANNELS:
            factor = frame.symmetry_factor * frame.density_factor
            if frame.nondimensional and name not in dimensional:
                unit = _unit(channel, frame.nondimensional, ship, water, speed)
                scaled[channel] = unit
                factor *= unit
        sign = frame.sign(channel)
        if part and part[1] == "std":
            sign = 1
        elif part and turn_harmonics and part[2] % 2:
            sign = -sign
        if sign < 0:
            flipped.append(name)
        factor *= sign
        out[name] = numbers if factor == 1.0 else numbers * factor
    notes = [
        f"{channel}: from {frame.nondimensional} to SI with U = {speed:g} m/s (times {unit:.10g})"
        for channel, unit in scaled.items()
    ]
    if frame.symmetry_factor != 1.0:
        notes.append(f"forces times {frame.symmetry_factor:g}: part of the domain was computed")
    if frame.density_factor != 1.0:
        notes.append(f"forces times rho/rho_inf = {frame.density_factor:.10g}")
    if flipped:
        notes.append(f"{frame.TURNED}: {', '.join(flipped)}")
    if turn_harmonics:
        notes.append("odd harmonics refer to the motion reversed with the axis")
    return out, notes


def _unit(channel: str, system: str, ship: Ship, water: Water, speed: float) -> float:
    return (
        Convention()
        .with_(system=system)
        .force_unit(
            "N" if CHANNEL_UNITS[channel] == "N m" else "X", ship=ship, water=water, U=speed
        )
    )


def in_phase_parts(name: str, phase: str) -> tuple[str, int]:
    """Our name of an in-phase or out-of-phase part of a harmonic, and its sign.

    The motion is sin θ. In phase with the displacement, ``in`` is the sine and ``out`` the cosine;
    with the velocity the other way round; with the acceleration ``in`` is minus the sine.

    Examples
    --------
    >>> in_phase_parts("Y_in2", "velocity"), in_phase_parts("Y_in1", "acceleration")
    (('Y_cos2', 1), ('Y_sin1', -1))
    """
    part = harmonic_part(name)
    if part is None or part[1] not in ("in", "out"):
        return name, 1
    channel, way, order = part
    sine = (way == "in") != (phase == "velocity")
    sign = -1 if phase == "acceleration" and way == "in" else 1
    return f"{channel}_{'sin' if sine else 'cos'}{order}", sign


def stacked_harmonics(values: Mapping[str, Array]) -> dict[str, Array]:
    """Parts of harmonics as arrays over the order of the harmonic.

    ``X_cos`` at 0 is the mean (NaN where not stated), ``X_sin`` at 0 is zero; parts that the
    source does not state are NaN.
    """
    parts = {name: found for name in values if (found := harmonic_part(name))}
    highest = max(order for _, _, order in parts.values())
    out: dict[str, Array] = {}
    for name, (channel, way, order) in parts.items():
        key = f"{channel}_{'cos' if way == 'mean' else way}"
        if way == "std":
            continue
        for each in (f"{channel}_cos", f"{channel}_sin"):
            if each not in out:
                out[each] = np.full(highest + 1, np.nan)
        out[f"{channel}_sin"][0] = 0.0
        out[key][order] = values[name].item()
    return out
