"""A kind of test of somebody else: sway with a third harmonic at a drift angle, in one file."""

from __future__ import annotations

import numpy as np

from pmmkit.campaigns.test_kinds.kind import SWAY, KindFit, NominalMotion, TankMotion, TestKind

THIRD = 0.1


def tank(settings, theta):
    size, omega = settings.amplitude or 0.0, settings.omega or 0.0
    zero = np.zeros_like(theta)
    return TankMotion(
        xdot=zero + settings.speed,
        ydot=size * omega * (np.cos(theta) + 3 * THIRD * np.cos(3 * theta)),
        xddot=zero,
        yddot=-size * omega**2 * (np.sin(theta) + 9 * THIRD * np.sin(3 * theta)),
        psi=zero + settings.drift,
        r=zero,
        rdot=zero,
    )


def place(settings, theta):
    size = settings.amplitude or 0.0
    return np.zeros_like(theta), size * (np.sin(theta) + THIRD * np.sin(3 * theta))


KIND = TestKind(
    name="double_sway",
    title="double sway",
    family="oscillating",
    needs=("period", "amplitude", "drift"),
    varies=("u", "v", "udot", "vdot"),
    swings=(SWAY,),
    motion=NominalMotion(tank=tank, place=place),
    fit=KindFit(factors=("u", "v", "vdot", "T")),
    codes=("DS",),
    phrase=r"\bdouble ?sway\b",
    shares={"amplitude": (0.5, 1.0), "drift": (0.5,)},
)
