"""What an effect does to standard tests, generated from its definition; and what mimics it."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from pmmkit.campaigns import Run, Settings
from pmmkit.conventions import STRUCTURES, Convention
from pmmkit.diagnosis.captive.base import CaptiveBase
from pmmkit.diagnosis.captive.candidate import Candidate
from pmmkit.diagnosis.evidence import MIMICS
from pmmkit.effects import HULL, INERTIA
from pmmkit.inference import RANK_TOLERANCE
from pmmkit.models import converted, from_values, load_model, scaled
from pmmkit.numerics import Array
from pmmkit.reduction import View

if TYPE_CHECKING:
    import xarray as xr

CHANNELS: Final = ("X", "Y", "N")
LENGTH: Final = 4.86
"""Of the S175 model that stands for all [m]."""
FROUDE: Final = (0.145, 0.217, 0.29)
SAMPLES: Final = 96
ORDERS: Final = 3
LEAST: Final = 0.01
"""Share of a channel's force below which an effect is not said to act there."""
SAME: Final = 1e-6
"""Runs whose harmonics differ by no more are alike; the first stands for them."""
ABSORBED: Final = 1e-3
"""Share of its square outside the hull's terms below which an effect is absorbed by them."""


@dataclass(frozen=True, kw_only=True)
class Signature:
    """An effect of usual size in standard tests.

    `acts`: mean (C0) and harmonics in phase with the velocity (C1 …) and the displacement (S1
    …), over the rms force of the channel in these tests; what is below 1 % is left out.
    `mimics`: effects that reproduce most of it beside a cubic hull, with the share. `absorbed`:
    whether the terms of a cubic hull take it over: no residual shows it.
    """

    name: str
    acts: Mapping[str, Mapping[str, Mapping[str, float]]]
    mimics: Mapping[str, float]
    absorbed: bool


def signatures(candidates: Sequence[Candidate]) -> tuple[Signature, ...]:
    """Signatures of effects, from their columns alone.

    Examples
    --------
    >>> from pmmkit.diagnosis.captive.candidate import candidate_of
    >>> from pmmkit.effects import CATALOGUE
    >>> (found,) = signatures([candidate_of(CATALOGUE["modulus_sway_drag"])])
    >>> sway = found.acts["pure_sway"]["Y"]
    >>> sorted(sway), round(sway["C3"] / sway["C1"], 2)
    (['C1', 'C3'], 0.2)
    """
    views, base = standard_tests()
    sizes = _sizes(views, base)
    hull = {c: base.design(base.names[c], views) for c in CHANNELS}
    over = {
        c: np.concatenate([np.full(v.rows, sizes[v.speed, c]) for v in views]) for c in CHANNELS
    }
    outside = {c: _projector(hull[c] / over[c][:, None]) for c in CHANNELS}
    plain = {
        (item.name, value): [
            _stacked(item, value, c, views, base) / over[c][:, None] for c in CHANNELS
        ]
        for item in candidates
        for value in item.grid
    }
    blocks = {
        key: np.concatenate([outside[c](x) for c, x in zip(CHANNELS, own, strict=True)])
        for key, own in plain.items()
    }
    found = []
    for item in candidates:
        whole = np.concatenate(plain[item.name, _middle(item)]) @ _usual(item)
        left = blocks[item.name, _middle(item)] @ _usual(item)
        hidden = bool(left @ left <= ABSORBED * (whole @ whole))
        acts = [_acts(item, value, views, base, sizes) for value in (_middle(item), *item.grid)]
        found.append(
            Signature(
                name=item.name,
                acts=MappingProxyType(next((x for x in acts if x), {})),
                mimics=MappingProxyType({} if hidden else _mimics(item.name, left, blocks)),
                absorbed=hidden,
            )
        )
    return tuple(found)


def _middle(candidate: Candidate) -> float:
    return candidate.grid[len(candidate.grid) // 2]


def _usual(candidate: Candidate) -> Array:
    return np.array(candidate.centre or candidate.typical)


def _stacked(
    candidate: Candidate, value: float, channel: str, views: Sequence[View], base: CaptiveBase
) -> Array:
    none = np.zeros((1, candidate.size))
    return np.concatenate(
        [
            candidate.columns(view, base, value).get(channel, np.repeat(none, view.rows, axis=0))
            for view in views
        ]
    )


def _acts(
    candidate: Candidate,
    value: float,
    views: Sequence[View],
    base: CaptiveBase,
    sizes: Mapping[tuple[float, str], float],
) -> dict[str, dict[str, dict[str, float]]]:
    """By test the harmonics of the run in which they are largest."""
    found: dict[str, dict[str, dict[str, float]]] = {}
    for view in views:
        for channel, columns in candidate.columns(view, base, value).items():
            shares = columns @ _usual(candidate) / sizes[view.speed, channel]
            own = {
                label: float(x)
                for label, x in zip(_labels(view.rows), shares, strict=True)
                if abs(x) >= max(LEAST, 0.05 * np.abs(shares).max())
            }
            before = found.setdefault(view.run.test, {}).get(channel, {})
            if _largest(own) > (1.0 + SAME) * _largest(before):
                found[view.run.test][channel] = own
    return {test: own for test, own in found.items() if own}


def _largest(shares: Mapping[str, float]) -> float:
    return max(map(abs, shares.values()), default=0.0)


def _labels(rows: int) -> list[str]:
    return ["C0", *(f"{kind}{n}" for n in range(1, rows // 2 + 1) for kind in "CS")]


def _mimics(name: str, left: Array, blocks: Mapping[tuple[str, float], Array]) -> dict[str, float]:
    """Share of a signature that each other effect reproduces at its best grid value."""
    found: dict[str, float] = {}
    for (other, _), block in blocks.items():
        if other != name:
            share = 1.0 - float(np.sum(_projector(block)(left) ** 2)) / float(left @ left)
            if share >= MIMICS:
                found[other] = max(found.get(other, 0.0), share)
    return dict(sorted(found.items(), key=lambda item: (-round(item[1], 3), item[0])))


def _projector(columns: Array) -> Any:
    """What is left of vectors outside the span of columns."""
    size = np.linalg.norm(columns, axis=0)
    U, s, _ = np.linalg.svd(columns[:, size > 0] / size[size > 0], full_matrices=False)
    Q = U[:, s > RANK_TOLERANCE * s.max(initial=0.0)]
    return lambda x: x - Q @ (Q.T @ x)


def _sizes(views: Sequence[View], base: CaptiveBase) -> dict[tuple[float, str], float]:
    """Root mean square of the base's force, by speed and channel [N, N m]."""
    found: dict[tuple[float, str], list[float]] = {}
    for view in views:
        for channel, force in base.forces(view.motion, view.speed).items():
            found.setdefault((view.speed, channel), []).append(float(np.mean(force**2)))
    return {key: math.sqrt(float(np.mean(values))) for key, values in found.items()}


@cache
def standard_tests() -> tuple[tuple[View, ...], CaptiveBase]:
    """Standard tests of the S175, and its published cubic hull as base."""
    model = scaled(load_model("s175-3dof"), LENGTH)
    values = {**model.values(HULL), **model.values(INERTIA)}
    names = (*STRUCTURES["cubic"].derivatives, "Yd", "Nd", "Xdd")
    known = {"Yd": -0.0026, "Nd": 0.00126, "Xdd": -0.0015}
    table = from_values(
        {name: x for name, x in values.items() if name[0] in CHANNELS},
        ship=model.ship,
        water=model.water,
        convention=model.convention,
    )
    total = converted(table, Convention()).at()
    base = CaptiveBase(
        names=MappingProxyType({c: tuple(n for n in names if n[0] == c) for c in CHANNELS}),
        values=MappingProxyType(
            {name: float(known.get(name, total.get(name, 0.0))) for name in names}
        ),
        ship=model.ship,
        water=model.water,
        convention=Convention(),
        reference=model.ship.speed(FROUDE[1], model.water.g),
    )
    views = [
        _view(test, speed, **settings)
        for speed in (model.ship.speed(Fn, model.water.g) for Fn in FROUDE)
        for test, settings in _programme(speed)
    ]
    return tuple(views), base


def _programme(speed: float) -> list[tuple[str, dict[str, float]]]:
    """Settings of the standard tests at a speed."""
    found: list[tuple[str, dict[str, float]]] = []
    for degrees in (-12, -8, -4, 4, 8, 12):
        found.append(("static_drift", {"drift": math.radians(degrees)}))
    for degrees in (-30, -15, 15, 30):
        found.append(("static_rudder", {"rudder": math.radians(degrees)}))
        found += [
            ("drift_rudder", {"rudder": math.radians(degrees), "drift": math.radians(beta)})
            for beta in (-8, 8)
        ]
    for degrees in (-10, -5, 5, 10):
        found.append(("static_heel", {"heel": math.radians(degrees)}))
    for omega_prime, v in ((1.5, 0.1), (1.5, 0.2), (3.0, 0.2)):
        omega = omega_prime * speed / LENGTH
        found.append(("pure_sway", {"period": 2 * math.pi / omega, "amplitude": v * speed / omega}))
    for omega_prime, r, degrees in (
        (1.5, 0.2, 0),
        (1.5, 0.4, 0),
        (3.0, 0.4, 0),
        (1.5, 0.4, 8),
        (1.5, 0.4, -8),
    ):
        yaw = {
            "period": 2 * math.pi * LENGTH / (omega_prime * speed),
            "yaw_amplitude": r / omega_prime,
            "drift": math.radians(degrees),
        }
        found.append(("yaw_drift" if degrees else "pure_yaw", yaw))
    return found


def _nothing() -> xr.Dataset:
    import xarray as xr

    return xr.Dataset()


def _view(test: str, speed: float, **settings: float) -> View:
    run = Run(
        id=test,
        test=test,
        kind="history",
        loader=_nothing,
        settings=Settings(speed=speed, **settings),  # type: ignore[arg-type]
    )
    omega = run.settings.omega
    t = np.arange(SAMPLES) * (2 * math.pi / omega if omega else 30.0) / SAMPLES
    motion = run.nominal_motion(t)
    rows = [np.full(SAMPLES, 1.0 / SAMPLES)]
    turned = np.zeros(SAMPLES)
    if omega:
        turned = -motion.rdot / omega**2
        for n in range(1, ORDERS + 1):
            rows += [2 * np.cos(n * omega * t) / SAMPLES, 2 * np.sin(n * omega * t) / SAMPLES]
    size = len(rows)
    return View(
        run=run,
        early=False,
        projection=np.stack(rows),
        motion=motion,
        t=t,
        force=dict.fromkeys(CHANNELS, np.zeros(size)),
        covariance=dict.fromkeys(CHANNELS, np.eye(size)),
        heading=settings.get("drift", 0) + turned,
    )
