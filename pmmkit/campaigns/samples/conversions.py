"""From the numbers of a file to SI, ship axes and our signs, each step recorded in words."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar, Final, Literal

import numpy as np

from pmmkit.base import CampaignError
from pmmkit.campaigns.motion.hull_path import PLACE, hull_path
from pmmkit.campaigns.stated_run import StatedRun
from pmmkit.campaigns.test_kinds.kind import TEST_KINDS
from pmmkit.conventions import CHANNEL_UNITS, FORCE_CHANNELS, Convention, Ship, Water, harmonic_part
from pmmkit.numerics import Array

# Forces in axes of the earth or the carriage, about a centre that stays, seen from the hull.
#
# A solver that moves the mesh states forces along axes that stay where they were, and its moments
# about a point that does so too unless it is told to move it. With ψ the heading and (x, y) the
# place of the hull, both from rest::
#
#     X = Fx cos ψ + Fy sin ψ        Y = -Fx sin ψ + Fy cos ψ
#     N = Mz - (rx Fy - ry Fx)       r from the centre to the ship's moment reference


_PAIRS: Final = (("X", "Y"), ("FX_rudder", "FY_rudder"))


@dataclass(frozen=True, kw_only=True)
class Solver:
    """What ``[cfd]`` says of the forces of a computation, besides factors.

    `axes`: along what forces and moments are stated: the ship, axes that stay where they were,
    or the way of the carriage; on a rotating arm that is the tangent. `centre_moves`: whether
    the point that moments refer to moves with the hull. `centre_x, motion_x`: where that point
    (at rest), and the point whose path is stated, lie forward of midship [m]. `ramp`: duration
    from the first sample that belongs to the start-up of the computation [s]. `stated`: keys
    that ``[cfd]`` has.
    """

    axes: Literal["body", "earth", "carriage"] = "body"
    centre_moves: bool = True
    centre_x: float = 0.0
    motion_x: float = 0.0
    ramp: float = 0.0
    stated: frozenset[str] = frozenset()

    @property
    def turns(self) -> bool:
        """Whether anything depends on where the hull is."""
        return self.axes != "body" or not self.centre_moves

    @property
    def needed(self) -> tuple[str, ...]:
        """What must be known of where the hull is."""
        return PLACE if not self.centre_moves else ("psi",) if self.axes != "body" else ()


def without_ramp(
    values: Mapping[str, Array], ramp: float, *, file: str, run: str
) -> tuple[dict[str, Array], list[str]]:
    """A history without the start-up of the computation."""
    if not ramp:
        return dict(values), []
    times = values["t"]
    kept = times >= times[0] + ramp
    if not kept.any():
        raise CampaignError(
            f"ramp_s = {ramp:g} s leaves no samples; they are from t = {times[0]:g} to "
            f"{times[-1]:g} s.",
            file=file,
            run=run,
            remedy="Correct ramp_s under [cfd].",
        )
    note = f"first {ramp:g} s left out (ramp_s): {int(np.sum(~kept))} of {len(times)} samples"
    return {name: numbers[kept] for name, numbers in values.items()}, [note]


def seen_from_hull(
    values: Mapping[str, Array], solver: Solver, run: StatedRun
) -> tuple[dict[str, Array], list[str]]:
    """Forces and moments in ship axes, about the ship's own moment reference.

    Examples
    --------
    >>> import math
    >>> from pmmkit.campaigns.settings import Settings
    >>> side = {"X": np.array([0.0]), "Y": np.array([10.0]), "N": np.array([0.0])}
    >>> run = StatedRun(id="SD", test="static_drift", kind="means",
    ...                 settings=Settings(speed=1.0, drift=math.pi / 6))
    >>> turned, _ = seen_from_hull(side, Solver(axes="earth"), run)
    >>> turned["X"].round(3), turned["Y"].round(3)
    (array([5.]), array([8.66]))
    """
    if not solver.turns:
        return dict(values), []
    _check_pairs(values, solver, run.id)
    on_an_arm = run.kind_of_test.motion.tank is None and solver.axes == "carriage"
    if on_an_arm and solver.centre_moves:
        first = next(iter(values.values()))
        path, whence = {"psi": np.full(len(first), run.settings.drift)}, "the drift angle"
    else:
        path, whence = hull_path(values, run, solver.needed)
    cosine, sine = np.cos(path["psi"]), np.sin(path["psi"])
    out = dict(values)
    notes = [f"heading{' and place' if not solver.centre_moves else ''} of the hull: {whence}"]
    if solver.axes != "body":
        for ahead, aside in _PAIRS:
            if ahead in values:
                along, across = values[ahead], values[aside]
                out[ahead] = along * cosine + across * sine
                out[aside] = -along * sine + across * cosine
        notes.append(f"forces turned from {solver.axes} axes to ship axes by the heading")
    if not solver.centre_moves and "N" in values:
        arm = solver.centre_x - solver.motion_x
        rx, ry = path["x"] + arm * cosine - arm, path["y"] + arm * sine
        ahead_of, beside = rx * cosine + ry * sine, -rx * sine + ry * cosine
        out["N"] = values["N"] - (ahead_of * out["Y"] - beside * out["X"])
        notes.append(
            "N moved from the centre that stays behind to the hull, which is up to "
            f"{float(np.hypot(rx, ry).max()):.4g} m away"
        )
    if "K" in out and (not solver.centre_moves or float(np.abs(sine).max()) > 0):
        del out["K"]
        notes.append("K left out: it turns into the pitching moment, which is not read")
    return out, notes


def _check_pairs(values: Mapping[str, Array], solver: Solver, run: str) -> None:
    """Refuse a force without the one that it turns into, and N without the forces that move it."""
    lacking = {
        other
        for pair in _PAIRS
        for one, other in (pair, pair[::-1])
        if solver.axes != "body" and one in values and other not in values
    }
    if not solver.centre_moves and "N" in values:
        lacking |= {"X", "Y"} - set(values)
    if lacking:
        raise CampaignError(
            f"there is no {' and no '.join(sorted(lacking))}, which the other forces "
            "and moments need to be seen from the hull.",
            run=run,
            remedy="Map them under [columns].",
        )


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
    "Y_forward": "y",
    "Y_aft": "y",
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
