"""KVLCC2 by HMRI's captive tests and HSVA's zigzags together, and what a third laboratory measures.

    python -m scripts.studies.third_laboratory [--data FOLDER] [--out FOLDER] [--ships 2000]

Every second of HSVA's zigzags in order of name is asked together with HMRI's captive tests, with
the full catalogue; the others are held out. Printed: evidence of each campaign alone and of both,
whose the effects are, and turns and zigzags with 95 % intervals for a third laboratory (Lpp 7 m,
HSVA's propeller and rudder, 1.179 m/s, constant revolutions), beside what is not known of the ship
alone; drawn in next_ship.png. The measurements are not part of the repository; --data or
PMMKIT_DATA names their folder.
"""

from __future__ import annotations

import argparse
import os
import time
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from types import MappingProxyType
from typing import Any

import numpy as np

import pmmkit as pk
from pmmkit.diagnosis import Together
from pmmkit.identification import Prediction, Smoothed, free_records
from pmmkit.models import Model
from pmmkit.plotting import Figure, colour
from pmmkit.reduction import Parts
from scripts.studies.diagnose_hsva import WINDOW, as_executed, rms
from scripts.studies.identify_hsva import overshoot_errors
from scripts.studies.kvlcc2_hsva import ROOT, as_at_hsva, captive_model, compare

SPEED = 1.179
NOISE, FLOOR = 0.03, 0.02
TURN = ("advance_L", "transfer_L", "tactical_diameter_L")
ZIGZAG = ("overshoot_1_deg", "overshoot_2_deg")
MANOEUVRES: Mapping[str, tuple[str, Mapping[str, Any], tuple[str, ...]]] = {
    "turn, 35° to starboard": ("turning", {"rudder_deg": 35.0}, TURN),
    "turn, 35° to port": ("turning", {"rudder_deg": -35.0}, TURN),
    **{
        f"zigzag {angle}/{angle}, first to {side}": (
            "zigzag",
            {"rudder_deg": sign * angle, "switch_deg": float(angle)},
            ZIGZAG,
        )
        for angle in (10, 20)
        for side, sign in (("starboard", 1.0), ("port", -1.0))
    },
}


def with_uncertain_parts(model: Model, parts: Parts) -> Model:
    """The model with what the tests say of the uncertainty of propeller and rudder."""
    made = dict(model.parts)
    for part in (parts.propeller, parts.rudder):
        own = made[part.effect]
        std = {name: parts.std[name] for name in own.values if name in parts.std}
        made[part.effect] = replace(own, std=MappingProxyType({**own.std, **std}))
    return replace(model, parts=MappingProxyType(made))


Intervals = Mapping[tuple[str, str], Mapping[str, tuple[float, float, float, int]]]
"""By manoeuvre and measure: of each model mean, ends of the 95 % interval, and ships lost."""


def intervals(models: Mapping[str, Model], ships: int) -> Intervals:
    """Of each measure of each manoeuvre."""
    found: dict[tuple[str, str], dict[str, tuple[float, float, float, int]]] = {}
    for title, (manoeuvre, settings, measures) in MANOEUVRES.items():
        for name, model in models.items():
            drawn = pk.monte_carlo(model, manoeuvre, n=ships, speed=SPEED, **settings)
            for measure in measures:
                values = drawn.metrics[measure]
                own = (
                    float(np.nanmean(values)),
                    *drawn.interval(measure),
                    int(np.isnan(values).sum()),
                )
                found.setdefault((title, measure), {})[name] = own
    return found


def told(found: Intervals) -> str:
    """A column for each model, as a table of markdown."""
    names = [*next(iter(found.values()))]
    lines = [f"| | {' | '.join(names)} |", "|---|" + "---|" * len(names)]
    for (title, measure), own in found.items():
        cells = [
            f"{mean:.3g} ({low:.3g} to {high:.3g})" + (f", {lost} lost" if lost else "")
            for mean, low, high, lost in own.values()
        ]
        lines.append(f"| {title}, {measure} | {' | '.join(cells)} |")
    return "\n".join(lines)


def figure(found: Intervals, path: Path) -> None:
    """Intervals of the measures, a bar for each model."""
    drawing = Figure(height=5.2)
    axes = drawing.subplots(4, 4).ravel()
    for axis, ((title, measure), own) in zip(axes, found.items(), strict=False):
        for place, (name, (mean, low, high, _)) in enumerate(own.items()):
            axis.plot([low, high], [place, place], lw=4, alpha=0.5, color=colour(place))
            axis.plot(mean, place, ls="", marker="o", color=colour(place), label=name)
        axis.set_yticks([])
        axis.set_ylim(len(own) - 0.5, -0.5)
        words = measure.replace("_L", " [L]").replace("_deg", " [°]").replace("_", " ")
        axis.set_title(f"{title.replace(', first', '')}\n{words}", fontsize=7)
    for axis in axes[len(found) :]:
        axis.remove()
    drawing.legend_below([axes[0]])
    drawing.save(path)


def evidence(found: Together) -> str:
    """Sets by campaign and together, as a table of markdown."""
    lines = [f"| set | {' | '.join(found.names)} | together |", "|---|" + "---|" * 3]
    for item in found.entries:
        if item.linear and item.log_evidence < 0.0:
            continue
        cells = []
        for name in found.names:
            ballot = item.ballots.get(name)
            about = "about " if ballot and ballot.linear else ""
            beside = f" with {' and '.join(ballot.faults)}" if ballot and ballot.faults else ""
            cells.append(f"{about}{ballot.log_evidence:+.1f}{beside}" if ballot else "not asked")
        sets = " + ".join(f"`{name}`" for name in item.names)
        lines.append(f"| {sets} | {' | '.join(cells)} | {item.log_evidence:+.1f} |")
    return "\n".join(lines)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    default = os.environ.get("PMMKIT_DATA", str(ROOT.parent / "shared" / "data"))
    parser.add_argument("--data", type=Path, default=Path(default))
    parser.add_argument("--out", type=Path, default=Path("third-laboratory"))
    parser.add_argument("--ships", type=int, default=2000)
    parser.add_argument("--workers", type=int, default=2)
    options = parser.parse_args()
    own, parts = captive_model(options.data)
    captive = as_at_hsva(with_uncertain_parts(own, parts), options.data)
    tests = pk.open_campaign(ROOT / "datasets" / "kvlcc2_hmri", data=options.data)
    free = pk.open_campaign(ROOT / "datasets" / "kvlcc2_hsva", data=options.data)
    runs = sorted(free.runs, key=lambda run: run.id)
    used, kept = runs[::2], runs[1::2]
    records = [x for run in used for x in free_records(run, captive)]
    began = time.perf_counter(), time.process_time()
    found = pk.begin(
        captive,
        {"HMRI": tests, "HSVA": records},
        noise=NOISE,
        floor=FLOOR,
        executor=options.workers,
        progress=lambda word: print(f"… {word}", flush=True),
    ).diagnose()
    print(
        f"{time.perf_counter() - began[0]:.0f} s, of processor time "
        f"{time.process_time() - began[1]:.0f} s\n{found}\n\n{evidence(found)}\n"
    )
    models = {"captive tests alone": captive}
    alone = found.diagnoses["HSVA"].model
    models |= {"HSVA's zigzags, effects that they name alone": alone} if alone else {}
    models |= {"both": found.model} if found.model else {}
    models |= {"a third laboratory": found.others[0].model}
    test = Smoothed.references(captive, [x for run in kept for x in free_records(run, captive)])
    print(f"held out, windows of {WINDOW:g} s; overshoots nominal and as executed, rms [deg]")
    for name, model in models.items():
        row = Prediction.of(model, test, window=WINDOW).pooled()
        plain = overshoot_errors([compare(run, model) for run in kept])
        exact = rms([as_executed(run, model) for run in kept])
        print(
            f"{name:46} {'  '.join(f'{k} {v:.3g}' for k, v in row.items())}   "
            f"{' '.join(f'{x:.2f}' for x in plain)}   {' '.join(f'{x:.2f}' for x in exact)}"
        )
    scale = {f"prior × {n:g}": x.model for n, x in zip((1.0, 0.5, 2.0), found.others, strict=True)}
    first = found.others[0]
    bars = {
        "captive tests alone": captive,
        "next laboratory": first.model,
        "of the ship": first.ship,
    }
    drawn = intervals(bars, options.ships)
    table = f"{told(drawn)}\n\n{told(intervals(scale, options.ships))}"
    print(f"\n{table}")
    options.out.mkdir(parents=True, exist_ok=True)
    figure(drawn, options.out / "next_ship.png")
    for name, model in {"another_laboratory": found.others[0].model, "captive": captive}.items():
        pk.save_model(model, options.out / f"{name}.toml")
    (options.out / "intervals.md").write_text(table + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
