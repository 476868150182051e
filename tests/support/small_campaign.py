"""A small campaign on disk: a synthetic S175 model at two speeds, a few seconds to reduce.

The forces are written out here term by term, apart from the package's own regressors.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from pathlib import Path
from types import MappingProxyType

import numpy as np

L, RHO = 4.861111, 999.1
TRUTH = {
    "Xudot": -0.000238,
    "Xuu": -0.0004226,
    "Xvv": -0.00386,
    "Xrr": 0.0002,
    "Xvr": 0.003939,
    "Yv": -0.0116,
    "Yr": 0.002182,
    "Yvvv": -0.109,
    "Yrrr": 0.00177,
    "Yvvr": 0.0214,
    "Yvrr": -0.0405,
    "Yvdot": -0.007049,
    "Yrdot": -0.00035245,
    "Nv": -0.0038545,
    "Nr": -0.00222,
    "Nvvv": 0.001492,
    "Nrrr": -0.00229,
    "Nvvr": -0.0424,
    "Nvrr": 0.00156,
    "Nvdot": -0.00035245,
    "Nrdot": -0.000419,
}
"""Son and Nomoto's derivatives as captive tests measure them (Yr - mx, Xvr + my)."""
NOISE = {"X": 0.4, "Y": 1.0, "N": 1.5}
SPEEDS = (1.0, 2.0)
RAMP = 2.0
"""Time in which the carriage starts [s]."""

SHIP = f"""\
[ship]
name = "S175 model"
L = {L}
B = 0.705556
d = 0.236111
mass = 454.476
xG = 0.0
Izz = 618.332
volume = 0.454861
"""
"""The section of the S175 model in a campaign file."""
HEAD = f"""\
[campaign]
title = "Small S175 programme"
kind = "captive"
forces = "hydrodynamic"

{SHIP}
[water]
rho = {RHO}
g = 9.81
"""


def forces(u, v, r, udot, vdot, rdot) -> dict[str, np.ndarray]:
    """Son and Nomoto's hull forces [N, N m], every term by hand."""
    speed = np.hypot(u, v)
    a, b, c = u / speed, v / speed, r * L / speed
    a1, b1, c1 = udot * L / speed**2, vdot * L / speed**2, rdot * L**2 / speed**2
    t = TRUTH
    surge = (
        t["Xudot"] * a1 + t["Xuu"] * a * a + t["Xvv"] * b * b + t["Xrr"] * c * c + t["Xvr"] * b * c
    )
    sway = (
        t["Yv"] * b
        + t["Yr"] * c
        + t["Yvvv"] * b**3
        + t["Yrrr"] * c**3
        + t["Yvvr"] * b * b * c
        + t["Yvrr"] * b * c * c
        + t["Yvdot"] * b1
        + t["Yrdot"] * c1
    )
    yaw = (
        t["Nv"] * b
        + t["Nr"] * c
        + t["Nvvv"] * b**3
        + t["Nrrr"] * c**3
        + t["Nvvr"] * b * b * c
        + t["Nvrr"] * b * c * c
        + t["Nvdot"] * b1
        + t["Nrdot"] * c1
    )
    pressure = 0.5 * RHO * L**2 * speed**2
    return {"X": pressure * surge, "Y": pressure * sway, "N": pressure * L * yaw}


def sway(speed: float, amplitude: float, t: np.ndarray, omega: float) -> dict[str, np.ndarray]:
    """Motion of a pure sway test."""
    still = np.zeros_like(t)
    return {
        "u": np.full_like(t, speed),
        "v": amplitude * omega * np.cos(omega * t),
        "r": still,
        "udot": still,
        "vdot": -amplitude * omega**2 * np.sin(omega * t),
        "rdot": still,
    }


def yaw(
    speed: float, amplitude: float, drift: float, t: np.ndarray, omega: float
) -> dict[str, np.ndarray]:
    """Motion of a yaw test along the exact path, with drift."""
    psi = amplitude * np.sin(omega * t)
    r = amplitude * omega * np.cos(omega * t)
    along = speed / np.cos(psi)
    gain = along * np.tan(psi) * r
    return {
        "u": along * math.cos(drift),
        "v": -along * math.sin(drift),
        "r": r,
        "udot": gain * math.cos(drift),
        "vdot": -gain * math.sin(drift),
        "rdot": -amplitude * omega**2 * np.sin(omega * t),
    }


def write_campaign(
    folder: Path,
    *,
    seed: int = 1,
    noise: float = 1.0,
    rest: float = 0.0,
    zero: Mapping[str, float] = MappingProxyType({}),
    hundredfold: str = "",
    thrust: float = 0.0,
    grown: float = 1.0,
) -> Path:
    """Write the campaign file and its histories.

    Parameters
    ----------
    folder : Path
        Where; made if missing.
    seed : int
        Of the noise.
    noise : float
        Factor on the noise.
    rest : float
        Seconds for which the carriage stands at the head of each record; it then starts in 2 s.
    zero : mapping of str to float
        What gauges show at rest [N, N m].
    hundredfold : str
        A run whose side force is written in another unit, a hundred times too large.
    thrust : float
        Of a propeller that turns in all runs and stands inside X, over ½ρL²U².
    grown : float
        Factor on side force and moment.
    """
    generator = np.random.default_rng(seed)
    (folder / "runs").mkdir(parents=True)
    text = [HEAD]

    def add(name: str, keys: str, speed: float, t: np.ndarray, motion: dict) -> None:
        before = np.arange(t[0] - rest - RAMP, t[0], t[1] - t[0]) if rest else t[:0]
        started = np.clip((before - t[0]) / RAMP + 1.0, 0.0, 1.0) ** 2
        columns = {"t": np.concatenate([before, t])}
        for channel, run in forces(**motion).items():
            run = run if channel == "X" else grown * run
            clean = np.concatenate([started * run[0], run]) + zero.get(channel, 0.0)
            clean = clean + (0.5 * RHO * (L * speed) ** 2 * thrust if channel == "X" else 0.0)
            shown = clean + noise * NOISE[channel] * generator.normal(size=len(clean))
            columns[channel] = 100.0 * shown if (name, channel) == (hundredfold, "Y") else shown
        table = np.stack(list(columns.values()), axis=1)
        np.savetxt(
            folder / "runs" / f"{name}.csv",
            table,
            fmt="%.6g",
            delimiter=",",
            header=",".join(columns),
            comments="",
        )
        text.append(
            f'\n[[runs]]\nid = "{name}"\nfile = "runs/{name}.csv"\nspeed = {speed}\n{keys}\n'
            + ("propeller_rps = 8.0\n" if thrust else "")
        )

    for speed in SPEEDS:
        for degrees in (-8, -4, 0, 4, 8, 12):
            t = np.arange(0.0, 20.0, 0.1)
            beta, still = math.radians(degrees), np.zeros_like(t)
            motion = {
                "u": np.full_like(t, speed * math.cos(beta)),
                "v": np.full_like(t, -speed * math.sin(beta)),
                "r": still,
                "udot": still,
                "vdot": still,
                "rdot": still,
            }
            keys = f'test = "static_drift"\ndrift_deg = {degrees}.0'
            add(f"SD_U{speed:g}_b{degrees:+03d}", keys, speed, t, motion)
        period = 12.5 / speed
        t = np.arange(0.0, 4 * period - 1e-9, period / 250)
        omega = 2 * math.pi / period
        for amplitude in (0.15, 0.3):
            keys = f'test = "pure_sway"\nperiod = {period}\namplitude_m = {amplitude}'
            name = f"PS_U{speed:g}_a{amplitude:g}"
            add(name, keys, speed, t, sway(speed, amplitude, t, omega))
        for degrees in (8, 14):
            keys = f'test = "pure_yaw"\nperiod = {period}\nyaw_amplitude_deg = {degrees}.0'
            motion = yaw(speed, math.radians(degrees), 0.0, t, omega)
            add(f"PY_U{speed:g}_p{degrees}", keys, speed, t, motion)
        for drift in (4, 8):
            keys = (
                f'test = "yaw_drift"\nperiod = {period}\nyaw_amplitude_deg = 12.0\n'
                f"drift_deg = {drift}.0"
            )
            motion = yaw(speed, math.radians(12), math.radians(drift), t, omega)
            add(f"YD_U{speed:g}_b{drift}", keys, speed, t, motion)
    (folder / "campaign.toml").write_text("".join(text), encoding="utf-8")
    return folder


def write_depths(folder: Path, grown: Mapping[float, float]) -> Path:
    """One campaign in water of several depths.

    Parameters
    ----------
    folder : Path
        Where; made if missing.
    grown : mapping of float to float
        Factor on side force and moment by the depth [m].
    """
    text = [HEAD]
    for seed, (depth, factor) in enumerate(grown.items(), start=1):
        place = write_campaign(folder / f"h{depth:g}", seed=seed, grown=factor)
        own = (place / "campaign.toml").read_text(encoding="utf-8").removeprefix(HEAD)
        own = own.replace('file = "', f'file = "h{depth:g}/').replace(
            'id = "', f'id = "h{depth:g}_'
        )
        text.append(own.replace("[[runs]]\n", f"[[runs]]\ndepth = {depth}\n"))
    (folder / "campaign.toml").write_text("".join(text), encoding="utf-8")
    return folder
