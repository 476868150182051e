"""HSVA's zigzags of KVLCC2: half of them correct HMRI's captive model, the other half judges it.

    python -m scripts.studies.identify_hsva [--data FOLDER] [--methods ekf trajectory ...]

The start is the model that HMRI's captive tests alone give (`kvlcc2_hsva.py`), with the covariance
of those tests as prior, or 20 % of each value; what they do not tell (rudder, wake) is known to
20 %. Every second zigzag in order of name is used. Judged by the overshoots of the simulated
zigzags, and by the heading over windows of 80 s with the measured rudder. The measurements are not
part of the repository; --data or PMMKIT_DATA names their folder.
"""

from __future__ import annotations

import argparse
import os
import time
from pathlib import Path

import numpy as np

import pmmkit as pk
from pmmkit.identification import Prediction, Smoothed, free_records, identify
from pmmkit.models import Model
from scripts.studies.kvlcc2_hsva import ROOT, Case, as_at_hsva, captive_model, compare

RUDDER = (
    "rudder_mmg.aH",
    "rudder_mmg.epsilon",
    "rudder_mmg.gamma_positive",
    "rudder_mmg.gamma_negative",
    "propeller.wp",
)
WINDOW = 80.0


def overshoot_errors(cases: list[Case]) -> list[float]:
    """Root mean square of simulated less measured, first to third overshoot [deg]."""
    found = []
    for number in range(3):
        off = [
            case.simulated[number] - case.measured[number]
            for case in cases
            if len(case.measured) > number and len(case.simulated) > number
        ]
        known = np.array(off)[np.isfinite(off)]
        found.append(float(np.sqrt(np.mean(known**2))))
    return found


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    default = os.environ.get("PMMKIT_DATA", str(ROOT.parent / "shared" / "data"))
    parser.add_argument("--data", type=Path, default=Path(default))
    parser.add_argument("--methods", nargs="+", default=["ekf", "ukf", "trajectory", "regression"])
    options = parser.parse_args()
    captive = as_at_hsva(captive_model(options.data)[0], options.data)
    campaign = pk.open_campaign(ROOT / "datasets" / "kvlcc2_hsva", data=options.data)
    runs = sorted(campaign.runs, key=lambda run: run.id)
    used, kept = runs[::2], runs[1::2]
    print("used:   ", ", ".join(run.id for run in used))
    print("judged: ", ", ".join(run.id for run in kept))
    train = [x for run in used for x in free_records(run, captive)]
    test = Smoothed.references(captive, [x for run in kept for x in free_records(run, captive)])
    head = f"{'':32} overshoots rms [deg]      windows of {WINDOW:g} s, rms"
    print(
        f"\n{head}\n{'':32} {'1st':>6} {'2nd':>6} {'3rd':>6}   {'heading':>8} {'position':>9} "
        f"{'yaw rate':>9}"
    )

    def told(name: str, model: Model, after: str = "") -> None:
        errors = overshoot_errors([compare(run, model) for run in kept])
        found = Prediction.of(model, test, window=WINDOW).pooled()
        print(
            f"{name:32} {errors[0]:6.2f} {errors[1]:6.2f} {errors[2]:6.2f}   "
            f"{found['heading']:7.1f}° {found['position']:8.2f}m {found['yaw_rate']:7.2f}°/s{after}"
        )

    told("captive tests alone", captive)
    names = (*captive.parts["hull_polynomial"].values, *RUDDER)
    results = []
    for prior, spread in (("tests", dict.fromkeys(RUDDER, 0.2)), ("20 %", 0.2)):
        for method in options.methods:
            began = time.perf_counter()
            found = identify(captive, train, names, method=method, spread=spread)
            seconds = time.perf_counter() - began
            told(
                f"{method}, prior {prior}",
                found.model,
                f"  {seconds:5.1f} s  {'; '.join(found.notes)}",
            )
            results.append((f"{method}, prior {prior}", found))
    for title, found in results:
        print(f"\n{title}; not determined: {', '.join(found.unseen) or 'none'}")
        frame = found.to_pandas()
        print(frame[["prior", "prior_std", "value", "std", "std_over_prior"]].round(4).to_string())


if __name__ == "__main__":
    main()
