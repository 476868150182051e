"""A virtual towing tank with plain formulas, written apart from the package it tests."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

import numpy as np
import xarray as xr

from pmmkit.campaigns import Campaign, Run
from pmmkit.campaigns import Settings
from pmmkit.conventions import Ship, Water

SHIP = Ship(
    name="S175 1:36", L=4.861111, B=0.705556, d=0.236111, volume=0.454861, mass=454.476, Izz=618.332
)
WATER = Water(rho=999.1, g=9.81)

# Son and Nomoto 1981 as a PMM measures them: Yr - mx, Xvr + my, added masses as derivatives.
SON_NOMOTO = {
    "Xuu": -0.0004226, "Xvv": -0.00386, "Xrr": 0.00020, "Xvr": -0.00311 + 0.007049,
    "Xudot": -0.000238,
    "Yv": -0.0116, "Yr": 0.00242 - 0.000238, "Yvvv": -0.109, "Yrrr": 0.00177,
    "Yvvr": 0.0214, "Yvrr": -0.0405, "Yvdot": -0.007049, "Yrdot": -0.05 * 0.007049,
    "Nv": -0.0038545, "Nr": -0.00222, "Nvvv": 0.001492, "Nrrr": -0.00229,
    "Nvvr": -0.0424, "Nvrr": 0.00156, "Nvdot": -0.05 * 0.007049, "Nrdot": -0.000419,
}


def water_forces(
    c: Mapping[str, float], u, v, r, udot, vdot, rdot, *, speed=None, ship=SHIP, water=WATER
):
    """Forces of the water on the hull in newtons, written out by hand."""
    U = np.sqrt(u**2 + v**2) if speed is None else speed
    q = 0.5 * water.rho * ship.L**2 * U**2
    up, vp, rp = u / U, v / U, r * ship.L / U
    ud, vd, rd = udot * ship.L / U**2, vdot * ship.L / U**2, rdot * ship.L**2 / U**2
    g = c.get
    X = (
        g("Xuu", 0) * up**2 + g("Xvv", 0) * vp**2 + g("Xrr", 0) * rp**2 + g("Xvr", 0) * vp * rp
        + g("Xudot", 0) * ud
    )
    lateral = [
        g(f"{a}v", 0) * vp + g(f"{a}r", 0) * rp + g(f"{a}vvv", 0) * vp**3 + g(f"{a}rrr", 0) * rp**3
        + g(f"{a}vvr", 0) * vp**2 * rp + g(f"{a}vrr", 0) * vp * rp**2
        + g(f"{a}v|v|", 0) * vp * abs(vp) + g(f"{a}r|r|", 0) * rp * abs(rp)
        + g(f"{a}vdot", 0) * vd + g(f"{a}rdot", 0) * rd
        for a in "YN"
    ]
    return {"X": q * X, "Y": q * lateral[0], "N": q * ship.L * lateral[1]}


def motion(test: str, speed: float, theta, omega, *, drift=0.0, v=0.0, r=0.0, ship=SHIP):
    """Motion of midship in closed form: amplitudes v and r are non-dimensional."""
    one = np.ones_like(theta)
    if test in ("static_drift", "resistance"):
        return (speed * math.cos(drift) * one, -speed * math.sin(drift) * one, *(0 * one,) * 4)
    if test == "pure_sway":
        V = v * speed
        return (
            speed * one,
            V * np.cos(theta),
            0 * one,
            0 * one,
            -V * omega * np.sin(theta),
            0 * one,
        )
    psi0 = r * speed / ship.L / omega
    psi, rate = psi0 * np.sin(theta), psi0 * omega * np.cos(theta)
    along = speed / np.cos(psi)
    gain = speed * np.sin(psi) / np.cos(psi) ** 2 * rate
    return (
        along * math.cos(drift), -along * math.sin(drift), rate,
        gain * math.cos(drift), -gain * math.sin(drift), -psi0 * omega**2 * np.sin(theta),
    )


def balance_reading(force, u, v, r, udot, vdot, rdot, *, ship=SHIP):
    """What the balance shows: force of the water less mass times acceleration."""
    m, x = ship.mass, ship.xG
    return {
        "X": force["X"] - m * (udot - r * v - x * r**2),
        "Y": force["Y"] - m * (vdot + u * r + x * rdot),
        "N": force["N"] - ship.Izz * rdot - m * x * (vdot + u * r),
    }


def history(t, force: Mapping[str, np.ndarray]) -> xr.Dataset:
    return xr.Dataset({name: ("t", values) for name, values in force.items()}, coords={"t": t})


def state_of(run: Run):
    """Motion of a run of `captive` at its samples."""
    settings = run.settings
    omega = settings.omega or 1.0
    scale = {"v": omega / settings.speed, "r": omega * SHIP.L / settings.speed}
    given = {"drift": settings.drift}
    if settings.amplitude:
        given["v"] = settings.amplitude * scale["v"]
    if settings.yaw_amplitude:
        given["r"] = settings.yaw_amplitude * scale["r"]
    return motion(run.test, settings.speed, omega * run.data["t"].values, omega, **given)


def programme(speeds: Sequence[float]):
    """(id, test, speed, settings) of a usual programme."""
    for U in speeds:
        for beta in (-12, -8, -4, 0, 4, 8, 12):
            yield f"SD_{U}_{beta}", "static_drift", U, {"drift": math.radians(beta)}
        for V in (0.10, 0.17, 0.24):
            yield f"PS_{U}_{V}", "pure_sway", U, {"v": V}
        for R in (0.2, 0.4, 0.6):
            yield f"PY_{U}_{R}", "pure_yaw", U, {"r": R}
        for beta in (-8, 4, 8):
            for R in (0.25, 0.5):
                yield (
                    f"YD_{U}_{beta}_{R}", "yaw_drift", U,
                    {"r": R, "drift": math.radians(beta)},
                )


def captive(
    coefficients: Mapping[str, float] | None = None,
    *,
    speeds: Sequence[float] = (1.5,),
    omega_prime: float = 2.0,
    cycles: float = 4.0,
    per_cycle: int = 64,
    balance: bool = False,
    carriage: bool = False,
    noise=None,
    times=None,
    runs=None,
    **campaign,
) -> Campaign:
    """A campaign of histories made with the formulas above.

    `noise` is a function (channel, speed, n, seed number) -> newtons; `times` one (t) -> t.
    """
    c = SON_NOMOTO if coefficients is None else coefficients
    made = []
    for number, (name, test, U, given) in enumerate(runs or programme(speeds)):
        omega = omega_prime * U / SHIP.L
        n = int(cycles * per_cycle)
        t = np.arange(n) * (2 * math.pi / omega / per_cycle)
        t = t if times is None else times(t)
        state = motion(test, U, omega * t, omega, **given)
        force = water_forces(c, *state, speed=U if carriage else None)
        if balance:
            force = balance_reading(force, *state)
        if noise is not None:
            force = {
                ch: f + noise(ch, U, n, 10 * number + k) for k, (ch, f) in enumerate(force.items())
            }
        period = 2 * math.pi / omega
        settings = Settings(
            speed=U,
            drift=given.get("drift", 0.0),
            period=None if test == "static_drift" else period,
            amplitude=given["v"] * U / omega if "v" in given else None,
            yaw_amplitude=given["r"] * U / SHIP.L / omega if "r" in given else None,
        )
        data = history(t, force)
        made.append(
            Run(
                id=name,
                test=test,
                kind="history",
                settings=settings,
                loader=lambda data=data: data,
                forces="balance" if balance else "hydrodynamic",
            )
        )
    return Campaign(
        title="virtual tank", ship=SHIP, water=WATER, runs=tuple(made),
        forces="balance" if balance else "hydrodynamic", **campaign,
    )
