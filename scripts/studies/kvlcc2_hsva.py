"""KVLCC2 from HMRI's captive tests alone against HSVA's free-running zigzags.

    python -m scripts.studies.kvlcc2_hsva [--data FOLDER] [--out FOLDER]

Hull, propeller and rudder come from the captive tests (1:46.4); the model is carried to HSVA's
scale (1:45.7), propeller and rudder. Nothing is tuned to the zigzags. The measurements are not part
of the repository; give their folder with --data or PMMKIT_DATA.
"""

from __future__ import annotations

import argparse
import csv
import math
import os
from dataclasses import dataclass, replace
from pathlib import Path
from types import MappingProxyType

import numpy as np

import pmmkit as pk
from pmmkit.campaigns import Run
from pmmkit.models import Model
from pmmkit.plotting import Figure, colour
from pmmkit.presentation import WIDE
from pmmkit.reduction import Parts
from pmmkit.simulation import Track

ROOT = Path(__file__).parents[2]
SPEED, REVOLUTIONS = 1.1702, 9.9
FULL_HEIGHT, FULL_AREA, FULL_LATERAL = 15.8, 112.5, 136.7
LENT = "library: Yasukawa and Yoshimura 2015"


@dataclass(frozen=True)
class Case:
    """One zigzag measured and simulated; overshoots in degrees, times in seconds."""

    run: Run
    measured: tuple[float, ...]
    simulated: tuple[float, ...]
    second_execute: tuple[float, float]
    mean_speed: tuple[float, float]
    track: Track


def captive_model(data: Path) -> tuple[Model, Parts]:
    """The MMG model of HMRI's tests, at their scale."""
    campaign = pk.open_campaign(ROOT / "datasets" / "kvlcc2_hmri", data=data)
    reduction = pk.reduce_campaign(campaign, structure="mmg")
    scale = 320.0 / campaign.ship.L
    parts = Parts.of(
        reduction,
        area=FULL_AREA / scale**2,
        height=FULL_HEIGHT / scale,
        lift_slope=2.747,
        lR=-0.71,
        rate_deg_s=2.34 * math.sqrt(scale),
        assumed=LENT,
    )
    table = reduction.table
    full = np.isfinite(table["Yv"])
    table = table.with_(
        Fn=table.Fn[full],
        value=table.value[full],
        covariance=table.covariance[full][:, :, full],
        dof=table.dof[full],
        method=table.method[full],
        runs=table.runs[full],
    )
    hull = parts.hull_alone(table, speed=SPEED, revolutions=REVOLUTIONS)
    donor = Model(
        name=campaign.ship.name,
        ship=campaign.ship,
        water=campaign.water,
        parts=MappingProxyType({"propeller": parts.propeller, "rudder_mmg": parts.rudder}),
        scale=f"L = {campaign.ship.L:g} m, the scale of the tests",
    )
    return pk.to_model(hull, donor, name="KVLCC2 by HMRI's captive tests"), parts


def as_at_hsva(model: Model, data: Path) -> Model:
    """The model at HSVA's scale, with its propeller, rudder rate and area."""
    free = pk.open_campaign(ROOT / "datasets" / "kvlcc2_hsva", data=data)
    made = pk.scaled(model, free.ship.L)
    with (data / "kvlcc2_hsva_free" / "open_water_INSEAN_propeller.csv").open() as file:
        rows = list(csv.DictReader(file))
    J, KT = (np.array([float(row[name]) for row in rows]) for name in ("J", "Kt"))
    low = J <= 0.8
    kt2, kt1, kt0 = np.polyfit(J[low], KT[low], 2).tolist()
    D = float(free.propeller["D"])
    height = FULL_HEIGHT * free.ship.L / 320.0
    made = made.with_values("propeller", D=D, kt0=kt0, kt1=kt1, kt2=kt2)
    rudder = made.parts["rudder_mmg"]
    ratio = float(free.rudder["area_lateral"]) / (FULL_LATERAL * (free.ship.L / 320.0) ** 2)
    made = made.with_values(
        "rudder_mmg",
        eta=D / height,
        rate_deg_s=float(free.rudder["rate_deg_s"]),
        area=float(rudder.values["area"]) * ratio,  # type: ignore[arg-type]
    )
    ship = replace(
        made.ship, mass=free.ship.mass, Izz=free.ship.Izz, xG=free.ship.xG, volume=free.ship.volume
    )
    return made.with_(ship=ship, water=replace(made.water, rho=free.water.rho))


def overshoots(
    t: np.ndarray, psi: np.ndarray, delta: np.ndarray, switch: float
) -> tuple[list[float], list[float]]:
    """Overshoot angles [deg] and the times of the executes [s] of a measured zigzag.

    Executes are where the rudder leaves one side; the extreme of the heading between two of them is
    the top of a parabola through 41 samples.
    """
    side = math.copysign(1.0, float(delta[np.argmax(np.abs(delta) > 0.5 * np.abs(delta).max())]))
    executes, level = [], 0.9 * float(np.abs(delta).max())
    on = side
    for i in range(1, len(t)):
        if on * delta[i] < level <= on * delta[i - 1]:
            executes.append(i)
            on = -on
    found = []
    for number, i in enumerate(executes):
        end = executes[number + 1] if number + 1 < len(executes) else len(t) - 1
        hand = side * (-1.0) ** number
        top = i + int(np.argmax(hand * psi[i:end]))
        if top >= len(t) - 2 or top == end - 1:
            break
        near = slice(max(top - 20, 0), min(top + 21, len(t)))
        a, b, c = np.polyfit(t[near] - t[top], np.degrees(hand * psi[near]), 2)
        found.append(float(c - b * b / (4 * a)) - switch)
    return found, [float(t[i]) for i in executes]


def compare(run: Run, model: Model) -> Case:
    """One zigzag measured and simulated."""
    data = run.data
    t = data["t"].to_numpy() - float(data["t"][0])
    psi = np.unwrap(data["psi"].to_numpy())
    delta = data["delta"].to_numpy()
    moved = int(np.argmax(np.abs(delta - delta[0]) > math.radians(0.5)))
    start = float(t[moved])
    switch = abs(math.degrees(run.settings.switch or 0.0))
    measured, times = overshoots(t, psi - psi[moved], delta, switch)
    ordered = math.degrees(run.settings.rudder)
    track = pk.simulate(
        model, "zigzag", rudder_deg=ordered, switch_deg=switch, executes=4, speed=run.settings.speed
    )
    simulated = tuple(track.metrics[f"overshoot_{i}_deg"] for i in (1, 2, 3))
    speed = np.hypot(data["xdot"].to_numpy(), data["ydot"].to_numpy())
    end = min(float(t[-1]) - start, float(track.t[-1]))
    here = (t >= start) & (t <= start + end)
    there = track.t <= end
    return Case(
        run=run,
        measured=tuple([*measured, math.nan, math.nan, math.nan][:3]),
        simulated=simulated,
        second_execute=(times[0] - start, track.metrics["time_execute_2"]),
        mean_speed=(float(speed[here].mean()), float(np.hypot(track.u, track.v)[there].mean())),
        track=track,
    )


def table(cases: list[Case]) -> str:
    """Measured and simulated overshoots of every zigzag."""
    lines = [
        f"{'zigzag':10} {'1st overshoot':>18} {'2nd overshoot':>18} {'3rd overshoot':>18} "
        f"{'2nd execute [s]':>16} {'mean speed [m/s]':>17}"
    ]
    for case in cases:
        cells = " ".join(
            f"{a:8.2f} {b:8.2f} " for a, b in zip(case.measured, case.simulated, strict=True)
        )
        lines.append(
            f"{case.run.id:10} {cells} {case.second_execute[0]:7.1f} {case.second_execute[1]:7.1f}"
            f"  {case.mean_speed[0]:7.3f} {case.mean_speed[1]:7.3f}"
        )
    gap = np.array([np.subtract(case.simulated, case.measured) for case in cases])
    rms = np.sqrt(np.nanmean(gap**2, axis=0))
    mean = np.nanmean(gap, axis=0)
    lines.append(
        "rms difference [deg]: "
        + ", ".join(
            f"{n} {x:.2f} (mean {m:+.2f})" for n, x, m in zip("123", rms, mean, strict=True)
        )
    )
    speeds = np.array([b / a for a, b in (case.mean_speed for case in cases)])
    lines.append(f"mean speed simulated over measured: {speeds.mean():.3f}")
    return "\n".join(lines)


def figure(cases: list[Case], path: Path) -> None:
    """Heading and rudder of six zigzags, measured and simulated."""
    chosen = [
        c
        for c in cases
        if c.run.id in ("Z_10_10_S", "Z_10_10_P", "Z_20_10_S", "Z_10_05", "Z_20_05", "Z_35_05")
    ]
    drawing = Figure(height=7.2)
    axes = drawing.subplots(3, 2).ravel()
    for axis, case in zip(axes, chosen, strict=True):
        data = case.run.data
        t = data["t"].to_numpy() - float(data["t"][0])
        delta = data["delta"].to_numpy()
        start = float(t[int(np.argmax(np.abs(delta - delta[0]) > math.radians(0.5)))])
        psi = np.degrees(np.unwrap(data["psi"].to_numpy()))
        axis.plot(t - start, psi, color=colour(0), label="heading, measured")
        axis.plot(
            t - start, np.degrees(delta), color=colour(0), lw=0.8, ls=":", label="rudder, measured"
        )
        axis.plot(
            case.track.t,
            np.degrees(case.track.psi),
            color=colour(1),
            ls="--",
            label="heading, simulated",
        )
        axis.set_xlim(-2, min(float(t[-1]) - start, 1.15 * float(case.track.t[-1])))
        axis.set_title(f"{case.run.id.replace('_', ' ')} [deg]")
        axis.set_xlabel("time from the first execute [s]")
    drawing.legend_below([axes[0]], columns=3)
    drawing.save(path)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    default = os.environ.get("PMMKIT_DATA", str(ROOT.parent / "shared" / "data"))
    parser.add_argument("--data", type=Path, default=Path(default))
    parser.add_argument("--out", type=Path, default=Path("kvlcc2-hsva"))
    options = parser.parse_args()
    model, parts = captive_model(options.data)
    for part in (parts.propeller, parts.rudder):
        for name, value in part.values.items():
            spread = f" ± {WIDE * parts.std[name]:.3f}" if name in parts.std else ""
            print(f"{part.effect:12} {name:15} {value:9.4f}{spread}  {part.source_of(name)}")
    there = as_at_hsva(model, options.data)
    straight = pk.simulate(there, "turning", rudder_deg=35, speed=1.179)
    print(f"self-propulsion at 1.179 m/s: {60 * straight.n[0]:.1f} rpm (HSVA ran 614)")
    free = pk.open_campaign(ROOT / "datasets" / "kvlcc2_hsva", data=options.data)
    cases = [compare(run, there) for run in free]
    print(table(cases))
    for name in ("advance_L", "tactical_diameter_L", "steady_diameter_L", "speed_ratio"):
        print(f"turn at 35°: {name} {straight.metrics[name]:.3f}")
    options.out.mkdir(parents=True, exist_ok=True)
    pk.save_model(there, options.out / "model.toml")
    figure(cases, options.out / "zigzags.png")
    print(f"figure and model: {options.out}")


if __name__ == "__main__":
    main()
