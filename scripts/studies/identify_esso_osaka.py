"""Esso Osaka, 3 m, outdoors: identified from six zigzags and a random record, calm and in wind.

    python -m scripts.studies.identify_esso_osaka [--data FOLDER] [--methods ekf trajectory ...] \
        [--each]

The library's model is the start (every value known to 30 %); the four turns and the other random
record are predicted over windows of 60 s, from the smoothed motion, with the measured rudder and
revolutions. Each method runs twice: without wind, and with the measured wind and three coefficients
of it among the parameters. With --each every record is looked at alone: which values it determines.
The measurements are not part of the repository; --data or PMMKIT_DATA names their folder.
"""

from __future__ import annotations

import argparse
import math
import os
import time
from dataclasses import replace
from pathlib import Path
from types import MappingProxyType

import pmmkit as pk
from pmmkit.identification import FreeRecord, Prediction, Prior, Smoothed, free_records, identify
from pmmkit.identification.filters import kalman
from pmmkit.identification.methods import UNSEEN
from pmmkit.models import Model, Part

ROOT = Path(__file__).parents[2]
CHANNELS = ("x", "y", "psi", "r")
SENSORS = {"x": 0.03, "y": 0.03, "psi": math.radians(0.5), "r": math.radians(0.3)}
SPREAD, WINDOW, SHORTEST = 0.3, 60.0, 40.0
HULL = (
    "Xu",
    "Xu|v|",
    "Xvr",
    "Y|u|v",
    "Yur",
    "Nuv",
    "N|u|r",
    "crossflow_drag.CD",
    "rudder_mmg.aH",
    "rudder_mmg.epsilon",
    "rudder_mmg.gamma_positive",
    "rudder_mmg.gamma_negative",
    "propeller.wp",
)
WIND = ("wind.cx", "wind.cy", "wind.cn")


def models() -> tuple[Model, Model]:
    """The library's ship, and the same with the windage that its builders state."""
    calm = pk.load_model("esso-osaka-3m")
    part = Part(
        effect="wind",
        source="windage as stated; coefficients typical",
        values=MappingProxyType({"AF": 0.135, "AL": 0.520, "cx": 0.7, "cy": 0.8, "cn": 0.1}),
    )
    return calm, replace(calm, parts=MappingProxyType({**calm.parts, "wind": part}))


def records(data: Path, model: Model) -> dict[str, tuple[FreeRecord, ...]]:
    """Usable segments of every run; the speed columns are late and left out."""
    campaign = pk.open_campaign(ROOT / "datasets" / "esso_osaka", data=data)
    return {
        run.id: free_records(run, model, channels=CHANNELS, shortest=SHORTEST) for run in campaign
    }


def row(name: str, model: Model, references: list[Smoothed]) -> str:
    found = Prediction.of(model, references, window=WINDOW).pooled()
    return (
        f"{name:24} {found['position']:9.2f} {found['position_end']:9.2f} {found['heading']:9.1f} "
        f"{found['speed']:9.3f} {found['yaw_rate']:9.2f}"
    )


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    default = os.environ.get("PMMKIT_DATA", str(ROOT.parent / "shared" / "data"))
    parser.add_argument("--data", type=Path, default=Path(default))
    parser.add_argument("--methods", nargs="+", default=["ekf", "ukf", "trajectory", "regression"])
    parser.add_argument("--each", action="store_true")
    options = parser.parse_args()
    calm, windy = models()
    found = records(options.data, calm)
    train = [
        x for name, all_ in found.items() if name[0] == "z" or name.endswith("_4") for x in all_
    ]
    test = [
        x for name, all_ in found.items() if name[0] == "t" or name.endswith("_6") for x in all_
    ]
    still = list(Smoothed.references(calm, [x.calm() for x in test], sensors=SENSORS))
    blown = [replace(item, record=x) for item, x in zip(still, test, strict=True)]
    print(
        f"Identified from {sum(map(len, train))} instants of {len(train)} segments, judged on "
        f"{len(test)} segments, windows of {WINDOW:g} s"
    )
    print(f"{'':24} {'position':>9} {'its end':>9} {'heading':>9} {'speed':>9} {'yaw rate':>9}")
    print(f"{'':24} {'[m]':>9} {'[m]':>9} {'[deg]':>9} {'[m/s]':>9} {'[deg/s]':>9}")
    print(row("library, calm", calm, still))
    print(row("library, wind", windy, blown))
    tables = []
    for method in options.methods:
        for model, names, given, judged, word in (
            (calm, HULL, [x.calm() for x in train], still, "calm"),
            (windy, (*HULL, *WIND), train, blown, "wind"),
        ):
            began = time.perf_counter()
            result = identify(model, given, names, method=method, spread=SPREAD, sensors=SENSORS)
            seconds = time.perf_counter() - began
            line = row(f"{method}, {word}", result.model, judged)
            print(f"{line}   {seconds:.1f} s   {'; '.join(result.notes)}")
            tables.append((f"{method}, {word}", result.to_pandas()))
    for title, frame in tables:
        print(f"\n{title}")
        print(frame[["prior", "value", "std", "std_over_prior", "seen"]].round(3).to_string())
    if options.each:
        each(windy, found)


def each(model: Model, found: dict[str, tuple[FreeRecord, ...]]) -> None:
    """What each record determines by itself."""
    names = (*HULL, *WIND)
    print("\nStandard deviation over that before, by record alone (- above 0.9)")
    print(f"{'':16}" + " ".join(f"{name.split('.')[-1][:9]:>9}" for name in names))
    for run, pieces in found.items():
        if not pieces:
            continue
        prior = Prior.of(model, names, pieces[0].speed, spread=SPREAD)
        result = kalman(model, pieces, prior, sensors=SENSORS)
        shares = result.std / prior.std
        print(
            f"{run:16}"
            + " ".join(f"{'-' if share > UNSEEN else f'{share:.2f}':>9}" for share in shares)
        )


if __name__ == "__main__":
    main()
