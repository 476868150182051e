"""KVLCC2 from HMRI's captive tests: what do HSVA's zigzags say it lacks?

    python -m scripts.studies.diagnose_hsva [--data FOLDER] [--out FOLDER]

Every second zigzag in order of name is diagnosed, the others are held out: windows of 80 s with the
measured rudder, and the overshoots of simulated zigzags. HSVA's executes come late, at 0.3 to 1.4°
beyond the nominal heading, which a measured overshoot holds and a simulated one does not; so
overshoots are also compared with each execute at the heading of the run. The measurements are not
part of the repository; --data or PMMKIT_DATA names their folder.
"""

from __future__ import annotations

import argparse
import csv
import math
import os
import time
from dataclasses import replace
from pathlib import Path

import numpy as np

import pmmkit as pk
from pmmkit.campaigns import Run
from pmmkit.diagnosis.free_running.diagnose import diagnose_free
from pmmkit.equations import prepare, run_plan
from pmmkit.identification import Prediction, Smoothed, free_records
from pmmkit.models import Model
from pmmkit.plotting import Figure, colour
from pmmkit.simulation import MANOEUVRES
from pmmkit.simulation.single import gear_of, track_of
from scripts.studies.diagnose_esso_osaka import told
from scripts.studies.identify_hsva import overshoot_errors
from scripts.studies.kvlcc2_hsva import ROOT, as_at_hsva, captive_model, compare

WINDOW = 80.0


def executes(run: Run) -> tuple[list[float], list[float]]:
    """Headings [rad] at which the rudder leaves one side, and the extremes that follow."""
    data = run.data
    psi, delta = np.unwrap(data["psi"].to_numpy()), data["delta"].to_numpy()
    moved = int(np.argmax(np.abs(delta - delta[0]) > math.radians(0.5)))
    psi = psi - psi[moved]
    full = float(np.abs(delta).max())
    hand = math.copysign(1.0, float(delta[int(np.argmax(np.abs(delta) > 0.5 * full))]))
    levels: list[float] = []
    places: list[int] = []
    at = moved
    while True:
        on = np.flatnonzero(hand * delta[at:] > 0.97 * full)
        if not len(on):
            break
        at += int(on[0])
        off = np.flatnonzero(hand * delta[at:] < 0.95 * full)
        if not len(off):
            break
        at += int(off[0])
        levels.append(hand * float(psi[at]))
        places.append(at)
        hand = -hand
    peaks = []
    first = math.copysign(1.0, float(delta[int(np.argmax(np.abs(delta) > 0.5 * full))]))
    for i, begin in enumerate(places):
        end = places[i + 1] if i + 1 < len(places) else len(psi)
        top = begin + int(np.argmax(first * (-1.0) ** i * psi[begin:end]))
        if top >= end - 2:
            break
        peaks.append(first * (-1.0) ** i * float(psi[top]))
    return levels, peaks


def as_executed(run: Run, model: Model) -> list[float]:
    """Simulated less measured extremes of the heading [deg], each execute at the run's heading."""
    levels, peaks = executes(run)
    count = min(len(levels), 3)
    speed = run.settings.speed
    ready = prepare(model, speed)
    plan = MANOEUVRES["zigzag"].plan(
        speed / ready.L,
        rudder_deg=math.degrees(run.settings.rudder),
        switch_deg=abs(math.degrees(run.settings.switch or 0.0)),
        executes=count + 1,
    )
    phases = tuple(
        replace(phase, level=phase.side * levels[i]) if i < count else phase
        for i, phase in enumerate(plan.phases)
    )
    plan = replace(plan, phases=phases)
    gear = gear_of(model, plan, speed / ready.L, None, 0.0)
    track = track_of(model, run_plan(ready, plan, gear, rtol=ready.RTOL, fast=False), None, {})
    switch = abs(math.degrees(run.settings.switch or 0.0))
    found = [track.metrics[f"overshoot_{i + 1}_deg"] + switch for i in range(count)]
    return [a - math.degrees(b) for a, b in zip(found, peaks, strict=False)]


def with_amidships(model: Model, data: Path) -> Model:
    """The captive model with side force and moment of HMRI's run with the rudder amidships (314).

    The run belongs to the captive tests; the structure of the model has no place for it.
    """
    with (data / "kvlcc2_hmri_pmm" / "static_rudder.csv").open(encoding="utf-8") as file:
        (row,) = [row for row in csv.DictReader(file) if row["Run No."] == "314"]
    ratio = model.ship.L / model.ship.d
    return model.with_values(
        "hull_polynomial", Y0=float(row["Y'"]) * ratio, N0=float(row["N'"]) * ratio
    )


def rms(rows: list[list[float]]) -> list[float]:
    """Root mean square of the first, second and third entries."""
    columns = [np.array([row[i] for row in rows if len(row) > i]) for i in range(3)]
    return [float(np.sqrt(np.mean(x[np.isfinite(x)] ** 2))) for x in columns]


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    default = os.environ.get("PMMKIT_DATA", str(ROOT.parent / "shared" / "data"))
    parser.add_argument("--data", type=Path, default=Path(default))
    parser.add_argument("--out", type=Path, default=Path("hsva-diagnosis"))
    options = parser.parse_args()
    captive = as_at_hsva(captive_model(options.data)[0], options.data)
    campaign = pk.open_campaign(ROOT / "datasets" / "kvlcc2_hsva", data=options.data)
    runs = sorted(campaign.runs, key=lambda run: run.id)
    used, kept = runs[::2], runs[1::2]
    train = [x for run in used for x in free_records(run, captive)]
    test = [x for run in kept for x in free_records(run, captive)]
    print("diagnosed:", ", ".join(run.id for run in used))
    print("held out: ", ", ".join(run.id for run in kept))
    began = time.perf_counter()
    found = diagnose_free(
        captive,
        train,
        held_out=test,
        held_out_window=WINDOW,
        progress=lambda word: print(f"… {word}", flush=True),
    )
    print(f"{time.perf_counter() - began:.0f} s")
    told(found)
    amidships = with_amidships(captive, options.data)
    own = amidships.parts["hull_polynomial"].values
    prime = captive.ship.d / captive.ship.L
    row = Prediction.of(amidships, Smoothed.references(captive, test), window=WINDOW).pooled()
    print(
        f"\ncaptive tests with their own run at rudder amidships, over ½ρL²U² Y0 "
        f"{prime * own['Y0']:.2g}, N0 {prime * own['N0']:.2g}, nothing fitted to the zigzags:"
    )
    print("  held out " + "  ".join(f"{k} {v:.3g}" for k, v in row.items()))
    print(f"\n{'overshoots of the held-out zigzags, rms [deg]':46} nominal heading     as executed")
    for name, model in (
        ("captive tests alone", captive),
        ("captive tests with rudder amidships", amidships),
        ("base refitted", found.refitted),
        ("with the effects", found.model),
    ):
        assert model is not None
        plain = overshoot_errors([compare(run, model) for run in kept])
        exact = rms([as_executed(run, model) for run in kept])
        print(
            f"{name:46} "
            + " ".join(f"{x:5.2f}" for x in plain)
            + "   "
            + " ".join(f"{x:5.2f}" for x in exact)
        )
    options.out.mkdir(parents=True, exist_ok=True)
    assert found.model is not None
    pk.save_model(found.model, options.out / "model.toml")
    figure(found.errors, options.out / "errors.png")


def figure(errors: dict, path: Path) -> None:
    """Errors of the held-out zigzags, before and after."""
    rows = [name for name in errors if name.startswith("held out")]
    drawing = Figure(height=2.6)
    axes = drawing.subplots(1, 3, sharey=True)
    for axis, (key, unit) in zip(
        axes, (("heading", "deg"), ("position", "m"), ("yaw_rate", "deg/s")), strict=True
    ):
        axis.barh(
            range(len(rows)),
            [errors[name][key] for name in rows],
            color=[colour(i) for i in range(len(rows))],
        )
        axis.set_yticks(range(len(rows)), [name[10:] for name in rows])
        axis.set_ylim(len(rows) - 0.5, -0.5)
        axis.set_title(f"{key.replace('_', ' ')} [{unit}]")
    drawing.save(path)


if __name__ == "__main__":
    main()
