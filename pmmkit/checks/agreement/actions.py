"""What slips and faults do to the motion of the model, and to what gauges and files show."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from typing import Final

import numpy as np

from pmmkit.campaigns.motion.kinematics import motion_at_phase, move_motion
from pmmkit.campaigns.run import Run
from pmmkit.campaigns.settings import Settings
from pmmkit.checks.agreement.rows import CHANNELS, PHASES, Group, phases
from pmmkit.effects.state import State
from pmmkit.numerics import Array

_MOVES: Final = ("u", "v", "r", "udot", "vdot", "rdot")

Move = Callable[[Group, float], State]
"""From a group and a value to how the model went."""
Show = Callable[[Group, Array, float], Array]
"""From a group, histories (n, 32, 3, p) and a value to what is shown of them."""
Column = Callable[[Group, Array, float], Array]
"""From a group, expected forces (n, 32, 3) and a value to harmonics (n, 3, 7) shown beside them."""


def scaled(*channels: str) -> Show:
    """Forces of some channels times the value."""
    at = [CHANNELS.index(name) for name in channels]

    def show(group: Group, shown: Array, value: float) -> Array:
        del group
        out = shown.copy()
        out[:, :, at] *= value
        return out

    return show


def filtered(factor: Callable[[Array, float], Array], *channels: str) -> Show:
    """Harmonics multiplied by a complex factor of n ω and the value."""
    at = [CHANNELS.index(name) for name in channels or CHANNELS]

    def show(group: Group, shown: Array, value: float) -> Array:
        out = shown.copy()
        n = np.arange(PHASES // 2 + 1)
        rate = n[None, :] * group.omega[:, None]
        gain = factor(rate, value) if factor is not turned else turned(n[None, :] + 0 * rate, value)
        for k in at:
            spectrum = np.fft.rfft(shown[:, :, k], axis=1) * gain[:, :, None]
            out[:, :, k] = np.fft.irfft(spectrum, PHASES, axis=1)
        return out

    return show


def late(rate: Array, seconds: float) -> Array:
    """Factor of harmonics that come later by so many seconds."""
    return np.asarray(np.exp(-1j * rate * seconds))


def turned(number: Array, degrees: float) -> Array:
    """Factor of harmonics of a record that begins at another phase."""
    return np.asarray(np.exp(-1j * number * math.radians(degrees)))


def one_pole(rate: Array, seconds: float) -> Array:
    """Factor of harmonics behind a filter of one pole with so many seconds."""
    return np.asarray(1 / (1 + 1j * rate * seconds))


def exchanged(group: Group, shown: Array, value: float) -> Array:
    """Y and N in each other's place: newtons read as newton metres."""
    del value
    L = group.campaign.ship.L
    out = shown.copy()
    out[:, :, 1], out[:, :, 2] = L * shown[:, :, 2], shown[:, :, 1] / L
    return out


def in_tank(group: Group, shown: Array, value: float) -> Array:
    """Forces along and across the tank."""
    del value
    cosine, sine = np.cos(group.heading)[..., None], np.sin(group.heading)[..., None]
    out = shown.copy()
    out[:, :, 0] = shown[:, :, 0] * cosine - shown[:, :, 1] * sine
    out[:, :, 1] = shown[:, :, 0] * sine + shown[:, :, 1] * cosine
    return out


def moments_about(group: Group, shown: Array, value: float) -> Array:
    """Moments about a point by so many lengths forward of the one stated."""
    del group
    out = shown.copy()
    out[:, :, 2] = shown[:, :, 2] - value * shown[:, :, 1]
    return out


def bent(channel: str) -> Column:
    """What an amplifier that bends takes off: it ends at so many times the largest force."""
    at = CHANNELS.index(channel)

    def column(group: Group, expected: Array, value: float) -> Array:
        force = expected[:, :, at]
        end = value * np.abs(force).max()
        out = np.zeros_like(expected)
        out[:, :, at] = end * np.tanh(force / end) - force
        return group.design(out[..., None])[..., 0]

    return column


def own_clock(group: Group, expected: Array, seconds: float) -> Array:
    """Forces as much later as each record starts too early."""
    rate = _rate(np.moveaxis(expected, 1, 2).reshape(-1), np.repeat(group.omega, 3 * PHASES))
    late = np.moveaxis(rate.reshape(len(expected), 3, PHASES), 1, 2)
    return -seconds * group.design(late[..., None])[..., 0]


def other_side(group: Group, value: float) -> State:
    """The motion to the other side."""
    del value
    m = group.motion
    return m.with_(v=-m.v, r=-m.r, vdot=-m.vdot, rdot=-m.rdot, delta=-m.delta)


def drift(group: Group, degrees: float) -> State:
    """The motion of a hull that stands at so many more degrees of drift."""
    m, c, s = group.motion, math.cos(math.radians(degrees)), math.sin(math.radians(degrees))
    return m.with_(
        u=c * m.u + s * m.v,
        v=c * m.v - s * m.u,
        udot=c * m.udot + s * m.vdot,
        vdot=c * m.vdot - s * m.udot,
    )


def point(group: Group, lengths: float) -> State:
    """The recorded motion is that of a point so many lengths forward of the one stated."""
    return move_motion(group.motion, lengths * group.campaign.ship.L)


def velocities_in_tank(group: Group, value: float) -> State:
    """The columns u and v are velocities along and across the tank."""
    del value
    m = group.motion
    psi, omega = group.heading.ravel(), np.repeat(group.omega, PHASES)
    u, v = np.cos(psi) * m.u + np.sin(psi) * m.v, np.cos(psi) * m.v - np.sin(psi) * m.u
    return m.with_(u=u, v=v, udot=_rate(u, omega), vdot=_rate(v, omega))


def _rate(values: Array, omega: Array) -> Array:
    """Time derivative of a history over 32 phases of each run."""
    n = np.arange(PHASES // 2 + 1)
    spectrum = np.fft.rfft(values.reshape(-1, PHASES), axis=1) * (1j * n)
    return np.asarray(np.fft.irfft(spectrum, PHASES, axis=1).ravel() * omega)


def restated(group: Group, of: Callable[[Settings], Settings]) -> State:
    """The motion that other settings would give; where runs recorded theirs, so it changes."""
    change = {name: np.zeros(len(group.motion.u)) for name in _MOVES}
    for place, item in enumerate(group.summaries):
        settings, kind = item.run.settings, item.run.kind_of_test
        if not item.run.dynamic:
            continue
        before, after = (kind.nominal(x, phases()) for x in (settings, of(settings)))
        at = slice(place * PHASES, (place + 1) * PHASES)
        for name, values in change.items():
            values[at] = after.get(name, 0.0) - np.asarray(before.get(name, 0.0))
    return group.motion.with_(
        **{name: getattr(group.motion, name) + values for name, values in change.items()}
    )


def as_set(group: Group, run: Run) -> State:
    """The motion of another run, for a group of one."""
    return move_motion(motion_at_phase(run, phases()), group.campaign.motion_reference_x)


def amplitude(group: Group, factor: float) -> State:
    """The motion at another amplitude."""

    def other(settings: Settings) -> Settings:
        sway, yaw = settings.amplitude, settings.yaw_amplitude
        return replace(
            settings,
            amplitude=sway and sway * factor,
            yaw_amplitude=yaw and min(yaw * factor, math.radians(80)),
        )

    return restated(group, other)
