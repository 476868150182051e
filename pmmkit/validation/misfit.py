"""The map of misfit, and what stands out in it, in words."""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Final, Literal

import numpy as np

from pmmkit.campaigns import TEST_KINDS
from pmmkit.conventions import CHANNEL_UNITS
from pmmkit.numerics import Array, rms
from pmmkit.presentation import listed
from pmmkit.validation.captive import CaptiveRun

Sign = Literal["too large", "too small", "too high", "too low", "off"]
STANDS_OUT: Final = 2.0
"""A cell stands out whose error is so many times its expanded uncertainty."""
LEAST_RANGE: Final = 1.3
"""A variable counts as varied if its largest value is so many times its least."""
SHARP: Final = 0.2
"""Standard uncertainty of an exponent that is told."""
NEAR: Final = 0.3
"""How far from a whole number an exponent may lie that is told as one."""
SCATTER: Final = 0.2
"""Scatter of the sizes about the power law, as a share, from which it tells nothing."""
MOST_LISTED: Final = 3
"""Speeds that a sentence lists; of more it gives the number."""
WITHIN: Final = math.sqrt(0.5)
"""Cosine of 45°, within which an error counts as along the measured force."""
THREE: Final = 3
"""Speeds that it takes to tell a power of the speed; of two no more is said than that it grows."""
ORDERS: Final = ("mean", "first", "second", "third", "fourth", "fifth", "sixth", "seventh")
POWERS: Final = {1: "", 2: " squared", 3: " cubed"}


@dataclass(frozen=True, kw_only=True)
class MisfitCell:
    """One channel, test type, speed and harmonic: all runs of it together.

    `channel, test`: X, Y, N or K; kind of test. `speed, Fn`: carriage speed [m/s], Froude
    number. `harmonic`: order; 0 is the mean. `error, uncertainty`: root mean squares over the
    runs: amplitude of the comparison error, expanded validation uncertainty [N, N m]. `ratio`:
    root mean square of the error over its uncertainty. `with_velocity, with_displacement`: the
    same of the parts in phase with the velocity and with the displacement; NaN for a mean.
    `relative`: error over the measured rms force of the runs. `known`: whether the noise of all
    runs is known.
    """

    channel: str
    test: str
    speed: float
    Fn: float
    harmonic: int
    runs: int
    error: float
    uncertainty: float
    ratio: float
    with_velocity: float
    with_displacement: float
    relative: float
    known: bool


@dataclass(frozen=True, kw_only=True)
class Standout:
    """What stands out of the map, over the speeds together.

    `channel, test`: X, Y, N or K; kind of test. `harmonic`: order; 0 is the mean. `speeds`:
    speeds at which it stands out [m/s]. `tested`: all speeds of the test type [m/s]. `ratio`:
    root mean square of error over expanded uncertainty. `growth`: powers of the variables with
    which the coefficient of the error grows. `known`: whether the noise is known. `error`: root
    mean square over the runs of the error's amplitude [N, N m]. `sign`: the prediction beside
    the measurement: its size, where the error is within 45° of the measured force or its
    opposite; else its value, where means err to one side; else neither.
    """

    channel: str
    test: str
    harmonic: int
    speeds: tuple[float, ...]
    tested: tuple[float, ...]
    ratio: float
    growth: Mapping[str, int]
    known: bool
    error: float = math.nan
    sign: Sign = "off"

    @property
    def where(self) -> str:
        """The speeds in words."""
        if len(self.speeds) == len(self.tested) > 1:
            return "all speeds"
        if len(self.speeds) > MOST_LISTED:
            return f"{len(self.speeds)} of {len(self.tested)} speeds"
        return f"{listed([f'{speed:.3g}' for speed in self.speeds])} m/s"

    @property
    def size(self) -> str:
        """Sign and size of the error, in words."""
        if not math.isfinite(self.error):
            return ""
        amount = f"{self.error:.3g} {CHANNEL_UNITS[self.channel]}"
        return f"off by {amount}" if self.sign == "off" else f"{amount} {self.sign}"

    @property
    def weight(self) -> str:
        """The error over its uncertainty, and what it grows with, in words."""
        text = f"{_times(self.ratio)} the uncertainty"
        if not self.known:
            text += " (noise not known)"
        grows = [f"{name}{POWERS[power]}" for name, power in self.growth.items() if power > 0]
        falls = [f"{name}{POWERS[-power]}" for name, power in self.growth.items() if power < 0]
        if grows:
            text += f"; grows with {listed(grows)}"
        if falls:
            text += f"; falls with {listed(falls)}"
        return text

    def holds(self, run: CaptiveRun) -> bool:
        """Whether a run is among those that it speaks of."""
        view = run.view
        orders = {int(label[1:]) for label in view.labels}
        return (
            view.run.test == self.test
            and self.channel in run.channels
            and round(view.speed, 4) in self.speeds
            and self.harmonic in orders
        )

    def __str__(self) -> str:
        size = f"{self.size}, " if self.size else ""
        return (
            f"{self.channel}, {TEST_KINDS[self.test].title}, {order_words(self.harmonic)}, "
            f"{self.where}: {size}{self.weight}"
        )


@dataclass(frozen=True, kw_only=True)
class Statement:
    """A sentence on a comparison, and what of the tests it speaks of.

    `channel`: a force, or a motion of free-running records; empty where it speaks of a measure
    of whole manoeuvres. `runs`: ids of the runs, or names of the records.
    """

    text: str
    channel: str
    runs: tuple[str, ...]

    def __str__(self) -> str:
        return self.text


def statements_of(
    standouts: Sequence[Standout], runs: Sequence[CaptiveRun]
) -> tuple[Statement, ...]:
    """Sentences that join what belongs together, the worst first.

    Examples
    --------
    >>> cell = {"channel": "Y", "test": "pure_sway", "speeds": (1.5,), "tested": (1.5,),
    ...         "growth": {}, "known": True, "sign": "too small"}
    >>> first = Standout(harmonic=1, ratio=8.0, error=6.0, **cell)
    >>> mean = Standout(harmonic=0, ratio=4.0, error=2.0, **cell)
    >>> print(*statements_of([first, mean], ()))
    Y, pure sway, 1.5 m/s: first harmonic 6 N too small (8 times the uncertainty), mean 2 N too \
small (4 times the uncertainty)
    """
    return tuple(
        Statement(
            text=_sentence(own),
            channel=own[0].channel,
            runs=tuple(run.view.run.id for run in runs if any(item.holds(run) for item in own)),
        )
        for own in _joined(standouts)
    )


def _joined(standouts: Sequence[Standout]) -> tuple[list[Standout], ...]:
    """What one sentence tells together."""
    by_test: dict[tuple[str, str], list[Standout]] = {}
    for item in standouts:
        by_test.setdefault((item.channel, item.test), []).append(item)
    joined: dict[tuple[str, ...], list[Standout]] = {}
    for own in by_test.values():
        alone = own[0] if len(own) == 1 else None
        place = ("harmonic", str(alone.harmonic), alone.where) if alone else ("test", own[0].test)
        joined.setdefault((own[0].channel, *place), []).extend(own)
    return tuple(joined.values())


def _sentence(own: Sequence[Standout]) -> str:
    first = own[0]
    if len(own) == 1:
        return str(first)
    one_test = len({item.test for item in own}) == 1
    alike = len({item.where for item in own}) == 1
    parts = []
    for item in own:
        what = order_words(item.harmonic) if one_test else TEST_KINDS[item.test].title
        where = "" if alike else f", {item.where},"
        parts.append(f"{what}{where} {item.size} ({item.weight})")
    common = TEST_KINDS[first.test].title if one_test else order_words(first.harmonic)
    head = [first.channel, common, *([first.where] if alike else [])]
    return f"{', '.join(head)}: {', '.join(parts)}"


def _times(ratio: float) -> str:
    return f"{ratio:.0f} times" if ratio >= 3.0 else f"{ratio:.1f} times"


def order_words(harmonic: int) -> str:
    """An order of harmonics for a sentence.

    Examples
    --------
    >>> order_words(0), order_words(3)
    ('mean', 'third harmonic')
    """
    return "mean" if harmonic == 0 else f"{ORDERS[harmonic]} harmonic"


@dataclass(frozen=True)
class _Part:
    """One order of one channel of one run."""

    run: CaptiveRun
    channel: str
    harmonic: int

    def _of(self, values: Array) -> Array:
        labels = self.run.view.labels
        return np.array([x for x, own in zip(values, labels, strict=True) if own in self.labels])

    @property
    def labels(self) -> tuple[str, ...]:
        return ("C0",) if self.harmonic == 0 else (f"C{self.harmonic}", f"S{self.harmonic}")

    @property
    def error(self) -> Array:
        return self._of(self.run.error(self.channel))

    @property
    def measured(self) -> Array:
        return self._of(self.run.view.force[self.channel])

    @property
    def uncertainty(self) -> Array:
        return self._of(self.run.uncertainty(self.channel))

    @property
    def size(self) -> float:
        """Amplitude of the error."""
        return float(np.linalg.norm(self.error))

    @property
    def doubt(self) -> float:
        """Its expanded uncertainty: that of one of the two parts at right angles."""
        return float(np.sqrt(np.mean(self.uncertainty**2)))

    @property
    def ratio(self) -> float:
        return float(np.sqrt(np.mean((self.error / self.uncertainty) ** 2)))


def cells(runs: Sequence[CaptiveRun]) -> tuple[MisfitCell, ...]:
    """The map: channel by test type, speed and harmonic."""
    grouped = _grouped(
        runs,
        lambda part: (
            part.channel,
            part.run.view.run.test,
            round(part.run.view.speed, 4),
            part.harmonic,
        ),
    )
    return tuple(_cell(parts) for parts in grouped.values())


def _grouped(
    runs: Sequence[CaptiveRun], key: Callable[[_Part], tuple[Any, ...]]
) -> dict[tuple[Any, ...], list[_Part]]:
    found: dict[tuple[Any, ...], list[_Part]] = {}
    for run in runs:
        orders = sorted({int(label[1:]) for label in run.view.labels})
        for channel, harmonic in itertools.product(run.channels, orders):
            part = _Part(run, channel, harmonic)
            found.setdefault(key(part), []).append(part)
    return dict(sorted(found.items(), key=lambda item: ("XYNK".index(item[0][0]), *item[0][1:])))


def _cell(parts: Sequence[_Part]) -> MisfitCell:
    first = parts[0]
    phases = [math.nan, math.nan]
    if first.harmonic:
        ratios = [part.error / part.uncertainty for part in parts if len(part.error) == 2]
        if ratios:
            phases = np.sqrt(np.mean(np.square(ratios), axis=0)).tolist()
    error = rms([part.size for part in parts])
    measured = [float(np.linalg.norm(part.run.view.force[part.channel])) for part in parts]
    return MisfitCell(
        channel=first.channel,
        test=first.run.view.run.test,
        speed=first.run.view.speed,
        Fn=first.run.Fn,
        harmonic=first.harmonic,
        runs=len(parts),
        error=error,
        uncertainty=rms([part.doubt for part in parts]),
        ratio=rms([part.ratio for part in parts]),
        with_velocity=phases[0],
        with_displacement=phases[1],
        relative=error / max(rms(measured), 1e-300),
        known=all(part.run.view.known(part.channel) for part in parts),
    )


def standouts_of(
    runs: Sequence[CaptiveRun], lengths: float, *, least: float = STANDS_OUT
) -> tuple[Standout, ...]:
    """Cells that stand out, speeds merged, the worst first.

    lengths [m].
    """
    found = []
    grouped = _grouped(
        runs, lambda part: (part.channel, part.run.view.run.test, part.harmonic)
    ).values()
    for parts in grouped:
        speeds = sorted({round(part.run.view.speed, 4) for part in parts})
        loud = [
            speed
            for speed in speeds
            if rms([p.ratio for p in parts if round(p.run.view.speed, 4) == speed]) >= least
        ]
        if not loud:
            continue
        own = [part for part in parts if round(part.run.view.speed, 4) in loud]
        first = own[0]
        found.append(
            Standout(
                channel=first.channel,
                test=first.run.view.run.test,
                harmonic=first.harmonic,
                speeds=tuple(loud),
                tested=tuple(speeds),
                ratio=rms([part.ratio for part in own]),
                growth=_growth(own, lengths),
                known=all(part.run.view.known(part.channel) for part in own),
                error=rms([part.size for part in own]),
                sign=_sign(own),
            )
        )
    return tuple(sorted(found, key=lambda item: -item.ratio))


def _sign(parts: Sequence[_Part]) -> Sign:
    """Whether predictions are too large or too small, or too high or too low, for all parts."""
    pairs = [(part.error, part.measured) for part in parts]
    along = sum(float(e @ m) for e, m in pairs)
    whole = math.sqrt(sum(float(e @ e) for e, _ in pairs) * sum(float(m @ m) for _, m in pairs))
    if whole > 0.0 and abs(along) > WITHIN * whole:
        return "too large" if along > 0.0 else "too small"
    if parts[0].harmonic == 0:
        values = np.array([float(e[0]) for e, _ in pairs])
        if abs(values.sum()) > WITHIN * float(np.abs(values).sum()):
            return "too high" if values.sum() > 0.0 else "too low"
    return "off"


def conditions(run: CaptiveRun, length: float) -> dict[str, float]:
    """Sizes of what a run varies: drift, sway velocity v', yaw rate r', rudder, heel, Fn, ω'.

    length [m].
    """
    view, motion = run.view, run.view.motion
    settings = view.run.settings
    drifting = abs(settings.drift)
    return {
        "drift": drifting,
        "sway velocity": 0.0 if drifting else float(np.max(np.abs(motion.v / motion.speed))),
        "yaw rate": float(np.max(np.abs(motion.r))) * length / view.speed,
        "rudder": settings.largest_rudder,
        "heel": float(np.max(np.abs(motion.phi))),
        "speed": run.Fn,
        "frequency": view.omega * length / view.speed,
    }


def _growth(parts: Sequence[_Part], length: float) -> dict[str, int]:
    """Whole powers by which the error over U² grows; empty where nothing is clear.

    A straight line through the logarithms of the errors that exceed their uncertainty, over those
    of all variables that the runs vary; only powers that the runs fix are told.
    """
    loud = [part for part in parts if part.size > part.doubt]
    if not loud:
        return {}
    settings = [conditions(part.run, length) for part in loud]
    varied = [
        name
        for name in settings[0]
        if (least := min(s[name] for s in settings)) > 1e-9
        and max(s[name] for s in settings) > LEAST_RANGE * least
    ]
    if not varied or len(loud) < len(varied) + 2:
        return {}
    size = np.array([part.size / part.run.view.speed**2 for part in loud])
    doubt = np.array([max(0.5 * part.doubt / part.size, 0.03) for part in loud])
    X = np.log([[s[name] for name in varied] for s in settings])
    A = np.column_stack([np.ones(len(loud)), X - X.mean(axis=0)]) / doubt[:, None]
    y = np.log(size) / doubt
    if np.linalg.matrix_rank(A, tol=1e-3 * np.linalg.norm(A)) < A.shape[1]:
        return {}
    covariance = np.linalg.inv(A.T @ A)
    powers = covariance @ (A.T @ y)
    left = y - A @ powers
    if np.sqrt(left @ left / np.sum(doubt**-2)) > SCATTER:
        return {}
    wider = max(1.0, float(left @ left) / (len(loud) - A.shape[1]))
    std = np.sqrt(wider * np.diagonal(covariance))[1:]
    whole = np.round(powers[1:])
    if "speed" in varied and len({round(s["speed"], 4) for s in settings}) < THREE:
        place = varied.index("speed")
        whole[place] = np.sign(whole[place])
    clear = (std < SHARP) & (np.abs(powers[1:] - np.round(powers[1:])) < NEAR) & (whole != 0)
    return {
        name: int(power)
        for name, power, told in zip(varied, whole, clear, strict=True)
        if told and abs(power) in POWERS
    }
