"""A little tank of its own: a hull on a balance, towed and swung, with ramp, stop and gauge zeros.

It knows nothing of the package. A run is where midship is in the tank and where it points, as
functions of time; velocities and accelerations follow by differences, forces by sums written out.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from types import MappingProxyType

import numpy as np

L, MASS, XG, RHO, U = 4.0, 450.0, 0.06, 999.1, 1.2
IZZ = MASS * (0.25 * L) ** 2 + MASS * XG**2
RATE = 20.0
TRUTH = {
    "Xuu": -1.9e-3, "Xvv": -3.0e-3, "Xvr": -1.5e-3, "Xrr": 0.3e-3, "Xudot": -0.9e-3,
    "Yv": -15e-3, "Yvvv": -60e-3, "Yr": 3.2e-3, "Yrrr": 1.5e-3, "Yvdot": -9.5e-3, "Yrdot": -0.4e-3,
    "Nv": -5.0e-3, "Nvvv": -6e-3, "Nr": -2.6e-3, "Nrrr": -1.0e-3, "Nvdot": -0.35e-3,
    "Nrdot": -0.55e-3,
}  # fmt: skip
NOISE = {"X": 0.15, "Y": 0.4, "N": 0.5}
HEAD = f"""\
[campaign]
title = "Little tank"
forces = "balance"

[ship]
name = "little hull"
L = {L}
B = 0.7
d = 0.25
volume = {MASS / RHO}
mass = {MASS}
Izz = {IZZ}
xG = {XG}

[water]
rho = {RHO}
"""

Course = Callable[[np.ndarray], tuple[np.ndarray, np.ndarray, np.ndarray]]


@dataclass(frozen=True)
class Test:
    """A run: what the campaign file says, where the hull is on the carriage, how long it lasts."""

    __test__ = False

    name: str
    keys: str
    course: Course
    seconds: float


def drift(degrees: float) -> Test:
    """Held at a drift angle."""
    beta = math.radians(degrees)
    return Test(
        f"SD{degrees:+03.0f}",
        f'test = "static_drift"\ndrift_deg = {degrees}',
        lambda t: (0 * t, 0 * t, beta + 0 * t),
        30.0,
    )


def sway(period: float, amplitude: float, cycles: float = 3.0) -> Test:
    """Swung across the tank."""
    w = 2 * math.pi / period
    return Test(
        f"PS{period:g}_{amplitude:g}",
        f'test = "pure_sway"\nperiod = {period}\namplitude_m = {amplitude}',
        lambda t: (0 * t, amplitude * np.sin(w * t), 0 * t),
        cycles * period,
    )


def yaw(period: float, degrees: float, cycles: float = 3.0) -> Test:
    """Swung along the path whose tangent is the heading, integrated step by step."""
    w, largest = 2 * math.pi / period, math.radians(degrees)

    def course(t: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        psi = largest * np.sin(w * t)
        slope = U * np.tan(psi)
        y = np.concatenate([[0.0], np.cumsum(0.5 * (slope[1:] + slope[:-1]) * np.diff(t))])
        return 0 * t, y, psi

    return Test(
        f"PY{period:g}_{degrees:g}",
        f'test = "pure_yaw"\nperiod = {period}\nyaw_amplitude_deg = {degrees}',
        course,
        cycles * period,
    )


def forces(t: np.ndarray, x: np.ndarray, y: np.ndarray, psi: np.ndarray) -> dict[str, np.ndarray]:
    """What the balance shows of a hull at such places; u, v and r beside it."""

    def rate(values: np.ndarray) -> np.ndarray:
        return np.gradient(values, t, edge_order=2)

    c, s = np.cos(psi), np.sin(psi)
    xdot, ydot, r = rate(x), rate(y), rate(psi)
    u, v = xdot * c + ydot * s, ydot * c - xdot * s
    ud, vd, rd = rate(u), rate(v), rate(r)
    speed = np.maximum(np.hypot(u, v), 1e-3)
    a, b = v / speed, r * L / speed
    q, m, k = 0.5 * RHO * speed**2 * L**2, 0.5 * RHO * L**3, TRUTH
    X = q * (k["Xuu"] * (u / speed) ** 2 + k["Xvv"] * a * a + k["Xvr"] * a * b + k["Xrr"] * b * b)
    X = X + m * k["Xudot"] * ud
    Y = q * (k["Yv"] * a + k["Yvvv"] * a**3 + k["Yr"] * b + k["Yrrr"] * b**3)
    Y = Y + m * k["Yvdot"] * vd + m * L * k["Yrdot"] * rd
    N = q * L * (k["Nv"] * a + k["Nvvv"] * a**3 + k["Nr"] * b + k["Nrrr"] * b**3)
    N = N + m * L * k["Nvdot"] * vd + m * L * L * k["Nrdot"] * rd
    sway_of_mass = vd + u * r + XG * rd
    return {
        "X": X - MASS * (ud - v * r - XG * r * r),
        "Y": Y - MASS * sway_of_mass,
        "N": N - IZZ * rd - MASS * XG * (vd + u * r),
        "u": u,
        "v": v,
        "r": r,
    }


def record(
    test: Test,
    *,
    rest: float = 0.0,
    ramp: float = 0.0,
    stop: float = 0.0,
    together: bool = False,
    finer: int = 8,
) -> dict[str, np.ndarray]:
    """A run from the rest on; its own time begins where the carriage is at its speed.

    The oscillator runs throughout, or comes up together with the carriage.
    """
    begin, end = -rest - ramp, test.seconds + stop
    t = np.arange(round(begin * RATE * finer), round(end * RATE * finer)) / (RATE * finer)
    up = np.clip((t + ramp) / ramp, 0.0, 1.0) if ramp else np.ones_like(t)
    down = np.clip((end - t) / stop, 0.0, 1.0) if stop else np.ones_like(t)
    carriage = U * (0.5 - 0.5 * np.cos(np.pi * np.minimum(up, down)))
    x = np.concatenate([[0.0], np.cumsum(0.5 * (carriage[1:] + carriage[:-1]) * np.diff(t))])
    on_carriage, y, psi = test.course(t)
    if together and "period" in test.keys:
        y, psi = (x * (0.5 - 0.5 * np.cos(np.pi * up)) for x in (y, psi))
    columns = {"t": t, **forces(t, x + on_carriage, y, psi)}
    columns |= {"U_carriage": carriage, "x": on_carriage, "y": y, "psi": psi}
    return {name: values[::finer] for name, values in columns.items()}


def write(
    folder: Path,
    tests: Sequence[Test],
    *,
    head: str = "",
    columns: Sequence[str] = (),
    zeros: Mapping[str, Sequence[float]] = MappingProxyType({}),
    noise: float = 1.0,
    seed: int = 3,
    extra: Callable[[dict[str, np.ndarray]], dict[str, np.ndarray]] = lambda columns: {},
    **lead: float,
) -> Path:
    """The campaign file and a text file a run: t, X, Y, N and the columns asked."""
    folder.mkdir(parents=True, exist_ok=True)
    dice = np.random.default_rng(seed)
    text = [HEAD, head]
    for place, test in enumerate(tests):
        found = record(test, **lead)
        kept = {"t": found["t"]}
        for name in ("X", "Y", "N"):
            off = zeros[name][place] if name in zeros else 0.0
            kept[name] = found[name] + off + noise * NOISE[name] * dice.normal(size=len(found["t"]))
        kept |= {name: found[name] for name in columns} | extra(found)
        np.savetxt(
            folder / f"{test.name}.csv",
            np.column_stack(list(kept.values())),
            fmt="%.9g",
            delimiter=",",
            header=",".join(kept),
            comments="",
        )
        text.append(
            f'\n[[runs]]\nid = "{test.name}"\nfile = "{test.name}.csv"\nspeed = {U}\n{test.keys}\n'
        )
    (folder / "campaign.toml").write_text("".join(text), encoding="utf-8")
    return folder


PROGRAMME = (
    *(drift(beta) for beta in (-8, -4, 0, 4, 8, 12)),
    *(sway(9.0, a, 2.6) for a in (0.25, 0.4)),
    sway(13.0, 0.5, 2.6),
    *(yaw(9.0, a, 2.6) for a in (8.0, 13.0)),
    yaw(13.0, 11.0, 2.6),
)
"""Drift, sway and yaw; few cycles, as short tanks give them."""
