"""Noise, scatter from run to run, and the background of the hard case."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy.signal import lfilter

from .hull import Force
from .motion import Array, Motion
from .sizes import CHANNELS, NOISE, scale, unit

LEVELS = ("standard", "double", "hard", "none")


@dataclass(frozen=True, kw_only=True, eq=False)
class RunNoise:
    """What chance does to one run: gains, offsets [N, N m], record noise, heading [rad]."""

    gain: dict[str, float]
    offset: dict[str, float]
    record: dict[str, Array]
    heading: float
    phi: Array


def draw(level: str, seed: int, number: int, samples: int) -> RunNoise:
    """Noise of run `number`: the same for the same seed, whatever effects are hidden."""
    generator = np.random.default_rng([seed, number])
    white, kicks = generator.standard_normal((2, len(CHANNELS), samples))
    starts = generator.standard_normal(len(CHANNELS))
    gains, offsets = generator.standard_normal((2, len(CHANNELS)))
    heavy = generator.standard_t(NOISE["student"], len(CHANNELS))
    heading = generator.standard_normal()
    phi = generator.standard_normal(samples)
    if level == "none":
        zero = dict.fromkeys(CHANNELS, 0.0)
        return RunNoise(
            gain=zero,
            offset=zero,
            record=dict.fromkeys(CHANNELS, np.zeros(samples)),
            heading=0.0,
            phi=np.zeros(samples),
        )
    share = NOISE["ar1_share"]
    record = np.sqrt(1 - share) * white + np.sqrt(share) * _ar1(kicks, starts)
    if level == "hard":
        offsets = heavy
    return RunNoise(
        gain={name: NOISE["gain"] * z for name, z in zip(CHANNELS, gains, strict=True)},
        offset={
            name: NOISE["offset"] * scale(name) * z
            for name, z in zip(CHANNELS, offsets, strict=True)
        },
        record={
            name: NOISE["rms"][level] * scale(name) * z
            for name, z in zip(CHANNELS, record, strict=True)
        },
        heading=np.radians(NOISE["drift_deg"]) * heading if level == "hard" else 0.0,
        phi=np.radians(NOISE["phi_deg"]) * phi,
    )


def _ar1(kicks: Array, starts: Array) -> Array:
    """AR(1) series of unit variance, stationary from the first sample on."""
    a = NOISE["ar1"]
    driven = np.sqrt(1 - a**2) * kicks
    driven[:, 0] = starts
    return lfilter([1.0], [1.0, -a], driven, axis=-1)


def background(seed: int) -> Callable[[Motion], Force]:
    """A smooth force of no catalogue form: random waves in the space of motions.

    Y and N are odd, X even under the mirror (v, r and the rudder change sign), as a symmetric
    hull asks for. The rms over motions is `NOISE["background"]` of the channel scale.
    """
    generator = np.random.default_rng([seed, 2**31])
    count = 16
    lengths = np.array([0.20, 0.40, 0.50, 1.0, 0.35])[:, None]
    directions = generator.standard_normal((len(CHANNELS), 5, count)) / lengths
    speeds = generator.standard_normal((len(CHANNELS), count)) / 0.8
    phases = generator.uniform(0, 2 * np.pi, (len(CHANNELS), count))
    size = NOISE["background"] * np.sqrt(2 / count) * np.sqrt(2)

    def force(m: Motion) -> Force:
        rudder = np.full_like(m.vp, m.delta)
        place = np.stack([m.vp, m.rp, m.vd, m.rd, rudder], axis=-1)
        made = {}
        for k, name in enumerate(CHANNELS):
            wave = place @ directions[k]
            tail = speeds[k] * m.F + phases[k]
            # cos(a + b): the even part in a is cos a cos b, the odd part -sin a sin b
            part = np.cos(wave) * np.cos(tail) if name == "X" else -np.sin(wave) * np.sin(tail)
            value = size * NOISE["scale"][name] * part.sum(axis=-1)
            made[name] = value * unit(name, 1.0) * m.U**2
        return made

    return force
