"""Esso Osaka outdoors: a calm-water model is fitted; what does it lack?

    python -m scripts.studies.diagnose_esso_osaka [--data FOLDER] [--out FOLDER] [--swaps 11] \
        [--most 4]

The library's model, every value known to 30 %, without wind. The six zigzags and one random record
are diagnosed with the whole catalogue; the four turns and the other random record are held out,
windows of 60 s with the measured rudder. The check on the wind: the wind of each run is replaced by
that of another one, all rotated by one, two, … places; only the true one may help. The measurements
are not part of the repository; --data or PMMKIT_DATA names their folder.
"""

from __future__ import annotations

import argparse
import json
import os
import time
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

import pmmkit as pk
from pmmkit.diagnosis import Diagnosis
from pmmkit.diagnosis.free_running.diagnose import diagnose_free
from pmmkit.identification import FreeRecord, Smoothed
from pmmkit.models import Model
from pmmkit.plotting import REFERENCE, Figure, colour
from pmmkit.presentation import WIDE, plus_minus
from scripts.studies.identify_esso_osaka import ROOT, SENSORS, records

WINDAGE = (0.135, 0.520)
WINDOW, JUDGED, AFTER = 60.0, 40.0, 0.1


def swapped(all_: Sequence[FreeRecord], donors: Sequence[FreeRecord]) -> list[FreeRecord]:
    """Records with the wind of others, repeated where these are shorter."""
    found = []
    for record, donor in zip(all_, donors, strict=True):
        assert donor.wind_speed is not None
        assert donor.wind_direction is not None
        span = donor.t[-1] - donor.t[0]
        at = donor.t[0] + np.mod(record.t - record.t[0], span)
        found.append(
            record.with_(
                wind_speed=np.interp(at, donor.t, donor.wind_speed),
                wind_direction=np.interp(at, donor.t, donor.wind_direction),
            )
        )
    return found


def told(found: Diagnosis) -> None:
    """The verdict for people."""
    print(
        f"verdict: {found.verdict}; flags: {', '.join(found.flags) or 'none'}; chance "
        f"{found.chance:.2g}; {'; '.join(found.notes)}"
    )
    for names, share in found.group:
        print(f"  {' + '.join(names)}   odds to the best {share:.2g}")
    for item in found.findings:
        falls = [f"{100 * (1 - b / a):.0f} % ({k})" for k, (a, b) in item.errors.items()]
        print(
            f"  {item.family}: {item.effect}, {item.evidence}; left-out errors fall by "
            f"{', '.join(falls)}"
        )
        for name, value in item.coefficients.items():
            print(
                f"     {name:28} {plus_minus(value, WIDE * item.std[name])}   usual "
                f"{item.typical[name]:.5f}"
            )
        if item.rivals:
            print(f"     mimicked by {', '.join(item.rivals)}; {item.separating_test}")
    print("  best sets:")
    for entry in found.entries[:10]:
        print(f"     {entry.log_evidence:7.1f}  {' + '.join(entry.names)}")
    print("  best single effects:")
    for entry in [e for e in found.entries if len(e.names) == 1][:8]:
        print(f"     {entry.log_evidence:7.1f}  {entry.names[0]}")
    for name, row in found.errors.items():
        print(f"  {name:32} " + "  ".join(f"{k} {v:.3g}" for k, v in row.items()))
    hidden = [item for item in found.covered if not item.shown]
    print("  could not be shown: " + ", ".join(f"{x.name} ({x.why})" for x in hidden))


def leftovers(model: Model, all_: Sequence[FreeRecord]) -> None:
    """What is left of the forces beside the model, and what it hangs on: share predicted of each
    record by a straight line through the others, none if below zero."""
    rows = []
    for record in all_:
        found = Smoothed.of(model, thinned(record), sensors=SENSORS)
        k, r = found.motion, found.record
        assert r.wind_speed is not None
        assert r.wind_direction is not None
        bearing = r.wind_direction - k["psi"]
        ahead, side = (
            r.wind_speed * np.cos(bearing) + k["u"],
            r.wind_speed * np.sin(bearing) + k["v"],
        )
        square, angle = ahead**2 + side**2, np.arctan2(side, ahead)
        features = {
            "constant": np.ones(len(r)),
            "north": np.cos(k["psi"]),
            "east": np.sin(k["psi"]),
            "v|v|": k["v"] * np.abs(k["v"]),
            "r|r|": k["r"] * np.abs(k["r"]),
            "rdot": np.gradient(k["r"], r.t),
            "rudder": r.delta * k["u"] ** 2,
        } | {
            f"wind {word}": square * shape
            for word, shape in (
                ("sin", np.sin(angle)),
                ("cos", np.cos(angle)),
                ("sin 2", np.sin(2 * angle)),
                ("cos 2", np.cos(2 * angle)),
                ("sin 3", np.sin(3 * angle)),
            )
        }
        rows.append((features, found.residual))
    for channel in ("X", "Y", "N"):
        forces = [residual[channel] for _, residual in rows]
        total = sum(float(x @ x) for x in forces)
        own = sum(len(x) * float(np.mean(x)) ** 2 for x in forces) / total
        shares = {}
        for name in rows[0][0]:
            left = 0.0
            for j, force in enumerate(forces):
                a = np.concatenate([f[name] for i, (f, _) in enumerate(rows) if i != j])
                b = np.concatenate([x for i, x in enumerate(forces) if i != j])
                left += float(np.sum((force - a @ b / (a @ a) * rows[j][0][name]) ** 2))
            shares[name] = 1.0 - left / total
        best = sorted(shares, key=lambda name: -shares[name])[:3]
        print(
            f"  {channel}: {100 * own:.0f} % is a constant of each record; of the rest of them "
            + ", ".join(f"{name} {100 * shares[name]:.0f} %" for name in best)
        )


def thinned(record: FreeRecord) -> FreeRecord:
    """Every fourth instant."""
    return record.at(slice(None, None, 4))


def of_wind(found: Diagnosis) -> float:
    """ln evidence of the wind alone."""
    return next(item.log_evidence for item in found.entries if item.names == ("wind",))


def best_rival(found: Diagnosis) -> float:
    """ln evidence of the best set without the wind."""
    return next(item.log_evidence for item in found.entries if "wind" not in item.names)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    default = os.environ.get("PMMKIT_DATA", str(ROOT.parent / "shared" / "data"))
    parser.add_argument("--data", type=Path, default=Path(default))
    parser.add_argument("--out", type=Path, default=Path("esso-osaka-diagnosis"))
    parser.add_argument("--swaps", type=int, default=11)
    parser.add_argument("--most", type=int, default=4, help="effects in a set")
    options = parser.parse_args()
    calm = pk.load_model("esso-osaka-3m")
    found = records(options.data, calm)
    train = [
        x for name, all_ in found.items() if name[0] == "z" or name.endswith("_4") for x in all_
    ]
    test = [
        x for name, all_ in found.items() if name[0] == "t" or name.endswith("_6") for x in all_
    ]
    train, test = named(train), named(test)
    how = {
        "sensors": SENSORS,
        "window": JUDGED,
        "held_out": test,
        "held_out_window": WINDOW,
        "windage": WINDAGE,
        "most": options.most,
    }
    began = time.perf_counter()
    whole = diagnose_free(calm, train, **how, progress=lambda word: print(f"… {word}", flush=True))
    print(f"\nWhole catalogue, {time.perf_counter() - began:.0f} s")
    told(whole)
    assert whole.model is not None
    after = diagnose_free(whole.model, train, **how | {"spread": AFTER})
    print(f"\nWhat is missing after that (the model above, its values known to {100 * AFTER:g} %)")
    told(after)
    print("\nForces that are left; what of them other records predict")
    leftovers(whole.model, [*train, *test])
    print("\nWind of another run against the whole catalogue: ln evidence, price taken off")
    own = of_wind(whole)
    print(f"   its own {own:7.1f}, best rival {best_rival(whole):.1f}")
    swaps = []
    for turn in range(1, min(options.swaps + 1, len(train))):
        other = swapped(train, [*train[turn:], *train[:turn]])
        found_there = diagnose_free(calm, other, **how | {"held_out": (), "most": 1})
        swaps.append(of_wind(found_there))
        print(f"   {turn:2} places on {swaps[-1]:7.1f}", flush=True)
    options.out.mkdir(parents=True, exist_ok=True)
    text = {"own": own, "swapped": swaps, "errors": {k: dict(v) for k, v in whole.errors.items()}}
    (options.out / "wind.json").write_text(json.dumps(text, indent=1), encoding="utf-8")
    figure(own, swaps, options.out / "wind.png")


def figure(own: float, swaps: Sequence[float], path: Path) -> None:
    """Evidence of the wind: its own, and that of other records."""
    drawing = Figure(height=2.4)
    axis = drawing.subplots()
    axis.bar(range(len(swaps) + 1), [own, *swaps], color=[colour(0), *[colour(1)] * len(swaps)])
    axis.axhline(1.0, color=REFERENCE, lw=0.8, ls=":")
    axis.ticks_at_most(side="x", whole=True)
    axis.set_xlabel("places by which the winds are rotated among the records")
    axis.set_title("ln evidence of the wind, less its price")
    drawing.save(path)


def named(all_: Sequence[FreeRecord]) -> list[FreeRecord]:
    """Each segment with a name of its own."""
    return [replace(x, name=f"{x.name} {i}") for i, x in enumerate(all_)]


if __name__ == "__main__":
    main()
