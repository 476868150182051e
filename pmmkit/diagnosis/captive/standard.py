"""Standard tests of a hull that every effect can be asked in."""

from __future__ import annotations

import math
from functools import cache
from types import MappingProxyType
from typing import TYPE_CHECKING, Final

import numpy as np

from pmmkit.campaigns import Run, Settings
from pmmkit.conventions import STRUCTURES, Convention
from pmmkit.diagnosis.captive.base import CaptiveBase
from pmmkit.effects import HULL, INERTIA
from pmmkit.models import converted, from_values, load_model, scaled
from pmmkit.reduction import View

if TYPE_CHECKING:
    import xarray as xr

CHANNELS: Final = ("X", "Y", "N")
LENGTH: Final = 4.86
"""Of the S175 model that stands for all [m]."""
FROUDE: Final = (0.145, 0.217, 0.29)
SAMPLES: Final = 96
ORDERS: Final = 3


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
