"""What the runs of one speed say, as harmonics of forces against a polynomial in the motion."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, fields, replace
from functools import cache, cached_property
from typing import TYPE_CHECKING, Final

import numpy as np
from numpy.typing import NDArray

from pmmkit.base import DataError
from pmmkit.conventions import Convention
from pmmkit.effects import Regressors, State
from pmmkit.intake.checks.expected import expected, prime_unit
from pmmkit.numerics import Array
from pmmkit.signals import design_matrix

if TYPE_CHECKING:
    from pmmkit.campaigns import Campaign
    from pmmkit.intake.checks.finding import Summary


# What derivatives hulls usually have, and how widely they spread: the prior of the checks.


SPREAD: Final = {
    "Yv": (-0.92, 0.25),
    "Yr": (0.20, 0.15),
    "Yvvv": (-5.0, 5.0),
    "Yrrr": (0.0, 0.3),
    "Yv|v|": (0.0, 1.5),
    "Yr|r|": (0.0, 0.2),
    "Yvvr": (1.5, 6.0),
    "Yvrr": (-2.0, 3.0),
    "Yvdot": (-0.62, 0.11),
    "Yrdot": (0.0, 0.04),
    "Yd": (-0.25, 0.25),
    "Yddd": (0.0, 0.5),
    "Yvvd": (0.0, 5.0),
    "Yvdd": (0.0, 2.0),
    "Nv": (-0.34, 0.12),
    "Nr": (-0.155, 0.05),
    "Nvvv": (0.0, 1.5),
    "Nrrr": (-0.1, 0.2),
    "Nv|v|": (0.0, 0.4),
    "Nr|r|": (0.0, 0.15),
    "Nvvr": (-2.5, 3.0),
    "Nvrr": (0.0, 0.5),
    "Nvdot": (0.0, 0.04),
    "Nrdot": (-0.034, 0.009),
    "Nd": (0.12, 0.12),
    "Nddd": (0.0, 0.25),
    "Nvvd": (0.0, 2.5),
    "Nvdd": (0.0, 1.0),
    "Xuu": (-0.06, 0.04),
    "Xvv": (-0.25, 0.35),
    "Xvvvv": (0.0, 4.0),
    "Xrr": (0.02, 0.06),
    "Xvr": (0.45, 0.30),
    "Xudot": (-0.04, 0.025),
    "Xdd": (-0.12, 0.12),
    "X0": (0.0, 1.0),
    "Y0": (0.0, 0.03),
    "N0": (0.0, 0.015),
}
"""Mean and standard deviation over -Yv of Clarke, Gedling and Hine (1983), prime system, total
coefficients: means of the hulls of the library, and about one and a half times their scatter."""
SAME: Final = 0.02
"""By how much Yrdot and Nvdot, equal in a mass matrix, may differ with way on, over the same."""
MAIN: Final = ("Xuu", "Xudot", "Xvr", "Yv", "Yr", "Yvdot", "Nv", "Nr", "Nrdot")
"""Derivatives whose size physics tells well enough to doubt data that show another."""


@dataclass(frozen=True, kw_only=True, eq=False)
class UsualDerivatives:
    """Prior of derivatives, prime system, instantaneous speed.

    mean (p,); covariance (p, p).
    """

    names: tuple[str, ...]
    mean: Array
    covariance: Array


def usual_derivatives(
    campaign: Campaign, names: tuple[str, ...], *, propelled: bool = False
) -> UsualDerivatives:
    """What a hull of these particulars usually has.

    Examples
    --------
    >>> from pmmkit.campaigns import Campaign
    >>> from pmmkit.conventions import Ship, Water
    >>> s175 = Ship(name="S175", L=175., B=25.4, d=8.5, volume=21222., mass=2.1752e7, Izz=3.84e10)
    >>> known = usual_derivatives(
    ...     Campaign(title="", ship=s175, water=Water(rho=1025.), runs=()), ("Yv", "Nv"))
    >>> known.mean.round(4), np.sqrt(np.diagonal(known.covariance)).round(4)
    (array([-0.0114, -0.0042]), array([0.0031, 0.0015]))
    """
    size = -expected(campaign).Yv
    spread = dict(SPREAD)
    if propelled:
        spread["Xuu"] = (0.0, 0.3)
    mean, std = (size * np.array([spread[name][k] for name in names]) for k in (0, 1))
    covariance = np.diag(std**2)
    if {"Yrdot", "Nvdot"} <= set(names):
        i, j = names.index("Yrdot"), names.index("Nvdot")
        covariance[i, j] = covariance[j, i] = std[i] * std[j] - 0.5 * (SAME * size) ** 2
    return UsualDerivatives(names=names, mean=mean, covariance=covariance)


Bools = NDArray[np.bool_]

CHANNELS: Final = ("X", "Y", "N")
ORDER: Final = 3
LABELS: Final = ("C0", "C1", "S1", "C2", "S2", "C3", "S3")
PHASES: Final = 32
"""Points of a cycle: enough for a fourth power of the third harmonic."""
MASS: Final = ("mass", "gyration")
"""Known parts of a reading: inertia of the model by its mass, and by its moment of inertia."""
GAIN: Final = 0.007
OFFSET: Final = 0.006
FORM: Final = 0.006
"""Scatter that is usual from run to run: of the gain; of the zero, and of each harmonic by what no
polynomial of third order holds, over the size of the channel."""
SPEEDS: Final = 0.01
FEWEST: Final = 6
"""Runs of one speed below which they are not held against one another."""
SHARE: Final = 0.3
"""By how much a share of the inertia may be off where it is doubted."""
KNOWN: Final = 1e-3
"""And where it is not, as a part of that."""
_RUDDER: Final = ("d", "ddd", "vvd", "vdd")


@dataclass(frozen=True, kw_only=True, eq=False)
class RunGroup:
    """Runs of one speed and one rate of revolutions, in the prime system.

    `campaign`: whose runs they are. `rows (n, 3, 7)`: harmonics of X, Y and N about midship, as
    read; NaN where not known. `noise (n, 3, 7)`: their standard deviation by the noise of the
    records. `motion`: motion of midship at 32 phases of each run, (n * 32,). `heading (n, 32)`:
    heading in the tank [rad]. `usual`: derivatives and their prior over `scale`; the last two
    are the shares of the model's inertia that a reading holds. `scale (p,)`: prior standard
    deviation of each derivative, in which all are counted. `level (3,)`: usual size of each
    channel. `zero (3,)`: scatter of the zero from run to run that is usual.
    """

    campaign: Campaign
    summaries: tuple[Summary, ...]
    rows: Array
    noise: Array
    motion: State
    heading: Array
    usual: UsualDerivatives
    scale: Array
    level: Array
    zero: Array

    @property
    def known(self) -> Bools:
        """Which rows are known, (n, 3, 7)."""
        return np.isfinite(self.rows)

    @cached_property
    def omega(self) -> Array:
        """Angular frequency of each run [rad/s]; 0 for a steady one."""
        return np.array([item.run.settings.omega or 0.0 for item in self.summaries])

    @cached_property
    def speed(self) -> float:
        """Speed of the carriage [m/s]."""
        return float(np.mean([item.run.settings.speed for item in self.summaries]))

    @cached_property
    def units(self) -> Array:
        """Units of the channels by run [N, N m], (n, 3)."""
        return np.array(
            [
                [prime_unit(self.campaign, name, item.run.settings.speed) for name in CHANNELS]
                for item in self.summaries
            ]
        )

    def only(self, places: Sequence[int]) -> RunGroup:
        """Some of the runs."""
        at = np.asarray(places, int)
        samples = (at[:, None] * PHASES + np.arange(PHASES)).ravel()
        return replace(
            self,
            summaries=tuple(self.summaries[place] for place in places),
            rows=self.rows[at],
            noise=self.noise[at],
            motion=self.motion.at(samples),
            heading=self.heading[at],
        )

    def histories(self, motion: State | None = None, speed: float | Array | None = None) -> Array:
        """What each parameter multiplies, (n, 32, 3, p), along the motion or another."""
        moved = self.motion if motion is None else motion
        count, names = len(self.summaries), self.usual.names
        out = np.zeros((count * PHASES, 3, len(names)))
        for row, channel in enumerate(CHANNELS):
            at = [k for k, name in enumerate(names) if name[0] == channel]
            columns = Regressors.at(
                [names[k] for k in at],
                moved,
                ship=self.campaign.ship,
                water=self.campaign.water,
                convention=Convention(),
                approach_speed=self.speed if speed is None else speed,
            ).columns
            out[:, row, at] = columns
        rig = self.campaign.rig
        for k, part in ((-2, replace(rig, Izz=0.0)), (-1, replace(rig, mass=0.0))):
            inertia = part.inertia_force(moved)
            for row, channel in enumerate(CHANNELS):
                out[:, row, k] = -inertia[channel]
        shaped = out.reshape(count, PHASES, 3, len(names))
        return shaped * (self.scale / self.units[:, None, :, None])

    def design(self, histories: Array) -> Array:
        """Harmonics of histories (n, 32, 3, p), as (n, 3, 7, p)."""
        n, t, channels, p = histories.shape
        found = _projection() @ histories.reshape(n, t, channels * p)
        return found.reshape(n, len(LABELS), channels, p).transpose(0, 2, 1, 3)


def groups_of(campaign: Campaign, summaries: Sequence[Summary]) -> Iterator[RunGroup]:
    """The captive runs by speed and revolutions, where there are enough to be held together."""
    sorted_: dict[tuple[int, float | None, str], list[Summary]] = {}
    for item in summaries:
        settings, kind = item.run.settings, item.run.kind_of_test
        if kind.free_running or settings.heel or kind.surges:
            continue
        rps = None if settings.propeller_rps is None else round(settings.propeller_rps, 1)
        key = (round(np.log(settings.speed) / SPEEDS), rps, item.run.forces)
        sorted_.setdefault(key, []).append(item)
    made = [found for group in _joined(sorted_) if (found := _group(campaign, group)) is not None]
    if not made:
        return
    shown = np.median([found.level * found.units.mean(axis=0) for found in made], axis=0)
    for found in made:
        yield replace(
            found, zero=OFFSET * np.maximum(found.level, shown / found.units.mean(axis=0))
        )


def _joined(sorted_: dict[tuple[int, float | None, str], list[Summary]]) -> Iterator[list[Summary]]:
    """Groups whose speeds are neighbours in one."""
    keys = sorted(sorted_, key=lambda key: (key[2], key[1] or 0.0, key[1] is None, key[0]))
    joined: list[Summary] = []
    last: tuple[int, float | None, str] | None = None
    for key in keys:
        if last is not None and last[1:] == key[1:] and key[0] - last[0] <= 1:
            joined += sorted_[key]
        else:
            if joined:
                yield joined
            joined = list(sorted_[key])
        last = key
    if joined:
        yield joined


def _group(campaign: Campaign, items: Sequence[Summary]) -> RunGroup | None:
    pairs = [(item, motion) for item in items if (motion := _motion(campaign, item)) is not None]
    if len(pairs) < FEWEST:
        return None
    summaries = tuple(item for item, _ in pairs)
    rows, noise = (np.stack(parts) for parts in zip(*map(_rows, summaries), strict=True))
    if campaign.moment_reference_x:
        rows[:, 2] += campaign.moment_reference_x * rows[:, 1]
    units = np.array(
        [
            [prime_unit(campaign, name, item.run.settings.speed) for name in CHANNELS]
            for item in summaries
        ]
    )
    rows, noise = rows / units[:, :, None], noise / units[:, :, None]
    size = np.sqrt(np.nansum(rows[..., :5] ** 2, axis=2))
    if not np.all(np.isfinite(rows).any(axis=(1, 2))):
        at = np.flatnonzero(np.isfinite(rows).any(axis=(1, 2)))
        return _group(campaign, [summaries[k] for k in at]) if len(at) >= FEWEST else None
    motion = State(
        **{
            field.name: np.concatenate([getattr(own, field.name) for _, own in pairs])
            for field in fields(State)
        }
    )
    level = _level(size)
    heading = np.stack([_heading(item) for item in summaries])
    settings = [item.run.settings for item in summaries]
    propelled = any(item.propeller_rps for item in settings)
    terms = [name for name in SPREAD if name not in ("X0",)]
    if not any(item.largest_rudder for item in settings):
        terms = [name for name in terms if "d" not in name.replace("dot", "")]
    prior = usual_derivatives(campaign, tuple(terms), propelled=propelled)
    inside = 1.0 if summaries[0].run.forces == "balance" else 0.0
    scale = np.append(np.sqrt(np.diagonal(prior.covariance)), [SHARE, SHARE])
    usual = UsualDerivatives(
        names=(*terms, *MASS),
        mean=np.append(prior.mean, [inside, inside]) / scale,
        covariance=_beside(prior.covariance, np.eye(2) * (KNOWN * SHARE) ** 2)
        / np.outer(scale, scale),
    )
    return RunGroup(
        campaign=campaign,
        summaries=summaries,
        rows=rows,
        noise=noise,
        motion=motion,
        heading=heading,
        usual=usual,
        scale=scale,
        level=np.maximum(level, 1e-12),
        zero=OFFSET * level,
    )


def _level(size: Array) -> Array:
    """Usual size of each channel: that of the larger runs that have it."""
    return np.array(
        [float(np.quantile(own[own > 0], 0.75)) if (own > 0).any() else 1.0 for own in size.T]
    )


def _beside(one: Array, other: Array) -> Array:
    """Two matrices on one diagonal."""
    n, m = len(one), len(other)
    out = np.zeros((n + m, n + m))
    out[:n, :n], out[n:, n:] = one, other
    return out


def _rows(item: Summary) -> tuple[Array, Array]:
    """Harmonics (3, 7) of the channels as read, and their noise [N, N m]."""
    rows, noise = np.full((3, len(LABELS)), np.nan), np.zeros((3, len(LABELS)))
    for row, name in enumerate(CHANNELS):
        if item.run.dynamic:
            if name in item.cos:
                rows[row, 0] = item.cos[name][0] if item.run.use_means else np.nan
                rows[row, 1::2] = item.cos[name][1:]
                rows[row, 2::2] = item.sin[name][1:]
        elif name in item.means:
            rows[row, 0] = item.means[name]
        noise[row] = item.harmonic_noise.get(name, 0.0)
    return rows, noise


def _motion(campaign: Campaign, item: Summary) -> State | None:
    """Motion of midship at 32 phases, as recorded where it is."""
    run = item.run
    theta = phases()
    basis = _basis()
    found = {
        name: basis @ _interleaved(item, name)
        for name in ("u", "v", "r", "udot", "vdot", "rdot")
        if run.dynamic and name in item.cos and np.all(np.isfinite(item.cos[name]))
    }
    try:
        state = run.motion_at_phase(theta)
    except (DataError, NotImplementedError):
        if not found:
            return None
        state = State.of(PHASES, **run.beside_motion(theta), **found)
    if found and f"nominal_{next(iter(found))}" in item.cos:
        nominal = {name: basis @ _interleaved(item, f"nominal_{name}") for name in found}
        state = state.with_(
            **{name: getattr(state, name) + found[name] - nominal[name] for name in found}
        )
    if not run.dynamic:
        mean = {
            name: np.full(PHASES, item.facts[f"{name}_mean"])
            for name in ("u", "v", "r")
            if f"{name}_mean" in item.facts
        }
        state = state.with_(**mean)
    return state.moved_aft(campaign.motion_reference_x)


def _interleaved(item: Summary, name: str) -> Array:
    out = np.empty(2 * ORDER + 1)
    out[0] = item.cos[name][0]
    out[1::2], out[2::2] = item.cos[name][1:], item.sin[name][1:]
    return out


def _heading(item: Summary) -> Array:
    run = item.run
    if not run.dynamic or run.kind_of_test.motion.tank is None:
        return np.full(PHASES, run.settings.drift)
    psi = run.kind_of_test.in_tank(run.settings, phases()).psi
    return np.array(np.broadcast_to(psi, (PHASES,)))


def phases() -> Array:
    """Phases of the displacement over a cycle, (32,) [rad]."""
    return np.asarray(np.arange(PHASES) * (2 * np.pi / PHASES), np.float64)


def _basis() -> Array:
    basis: Array = design_matrix(phases(), ORDER)
    return basis


@cache
def _projection() -> Array:
    """From 32 phases to the seven harmonics: exact, as the phases are even."""
    basis = _basis()
    return np.asarray(basis.T / np.sum(basis**2, axis=0)[:, None])
