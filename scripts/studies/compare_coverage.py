"""Does the uncertainty of a comparison with records hold the error, where the model is true?

    python -m scripts.studies.compare_coverage [--ships s175 kvlcc2-l7] [--seeds 10] [--runs 6]
                                               [--added current wind …]

Campaigns of tests/support/free_tank, which shares no code with the package, with nothing hidden are
compared with the library ship that is exact. Counted by channel and by how far the ship has sailed
from the measured start is the share of samples whose error lies within the uncertainty (k = 2, 95 %
of a normal error), and the rms of error over standard uncertainty, which should be one. Then each
surrounding and fault is hidden, the effect is added, and the campaign is compared before and after.
"""

from __future__ import annotations

import argparse
import tempfile
from collections import defaultdict
from itertools import product
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

import pmmkit as pk
from pmmkit.effects import CATALOGUE
from pmmkit.presentation import aligned
from tests.support.free_tank.campaigns import SHIPS, Setup, write
from tests.support.free_tank.cases import CASES

HORIZONS = (1.0, 5.0, 15.0, 45.0)
"""Ends of the bins [ship lengths sailed since the start]; the last one holds the rest."""
ADDED = ("current", "wind", "bottom", "rudder_zero", "clock", "antenna", "heading", "log", "roll")
"""Surroundings and faults that are hidden and added."""


def ratios(setup: Setup, found: dict[tuple[str, float], list[NDArray[np.float64]]]) -> None:
    """Errors over standard uncertainties of a campaign, put beside those that are there."""
    model = pk.load_model(setup.truth["model"])
    with tempfile.TemporaryDirectory() as place:
        campaign = pk.open_campaign(write(setup, Path(place)))
        data = pk.compare(model, campaign).to_xarray()
    for run, channel in product(range(data.sizes["run"]), data.channel.values.tolist()):
        one = data.isel(run=run).sel(channel=channel)
        sailed = one.t.values * float(one.speed) / model.ship.L
        ratio = 2.0 * one.error.values / one.uncertainty.values
        begin = 0.0
        for end in HORIZONS:
            there = (sailed > begin) & (sailed <= end) & np.isfinite(ratio)
            found[channel, end].append(ratio[there])
            begin = end


def before_and_after(case: str, ship: str) -> list[str]:
    """Errors over their uncertainties, largest of the motion's channels, and what stands out."""
    setup = Setup(case=case, size=1.0, runs=6, seed=0, ship=ship)
    effect = next(name for name in setup.truth["expect"][0] if name in CATALOGUE)
    model = pk.load_model(setup.truth["model"])
    with tempfile.TemporaryDirectory() as place:
        campaign = pk.open_campaign(write(setup, Path(place)))
        added = pk.begin(model, campaign).add(effect).model()
        row = [case, effect]
        for one in (model, added):
            found = pk.compare(one, campaign)
            data = found.to_xarray().sel(channel=["x", "y", "psi", "u", "v", "r"])
            worst = np.sqrt(np.nanmean((2.0 * data.error / data.uncertainty) ** 2, axis=(0, 2)))
            place_of = int(np.argmax(worst))
            channel = str(data.channel.values[place_of])
            row += [f"{worst[place_of]:.2f} ({channel})", str(len(found.statements()))]
    return row


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--ships", nargs="+", default=list(SHIPS), choices=SHIPS)
    parser.add_argument("--seeds", type=int, default=10)
    parser.add_argument("--runs", type=int, default=6, choices=(3, 6))
    parser.add_argument("--added", nargs="*", default=list(ADDED), choices=list(CASES))
    o = parser.parse_args()
    for ship in o.ships:
        found: dict[tuple[str, float], list[NDArray[np.float64]]] = defaultdict(list)
        for seed in range(o.seeds):
            ratios(Setup(case="none", size=1.0, runs=o.runs, seed=seed, ship=ship), found)
        rows = []
        for channel in dict.fromkeys(name for name, _ in found):
            cells = [np.concatenate(found[channel, end]) for end in HORIZONS]
            rows.append(
                [
                    channel,
                    *(
                        f"{100 * np.mean(np.abs(x) <= 2.0):.1f} %, {np.sqrt(np.mean(x**2)):.2f}"
                        if len(x)
                        else ""
                        for x in cells
                    ),
                ]
            )
        print(f"\n{ship}, {o.seeds} campaigns of {o.runs} records: share within k = 2, rms ratio")
        print(aligned(["channel", *(f"to {end:g} L" for end in HORIZONS)], rows), flush=True)
        beside = [before_and_after(case, ship) for case in o.added if ship in CASES[case].make]
        head = ["hidden", "added", "before", "stands out", "after", "stands out"]
        print("\nLargest rms of error over standard uncertainty, six records")
        print(aligned(head, beside), flush=True)


if __name__ == "__main__":
    main()
