"""What roll makes of the S175's turn: trajectories of an independent program against our models.

The trajectories were made with the public MSS model container.m in GNU Octave; they are not part
of the repository. Give their folder with --data or PMMKIT_DATA.
"""

from __future__ import annotations

import argparse
import os
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pandas as pd

from pmmkit.simulation import Track, simulate

ROOT = Path(__file__).parents[2]
FILES = (("U6_d+35", 6.0, 35.0), ("U6_d-35", 6.0, -35.0), ("U12_d+35", 12.0, 35.0))
CHANNELS = ("u", "v", "r", "x", "y", "psi", "phi")
MEASURES = ("advance_L", "transfer_L", "tactical_diameter_L", "steady_diameter_L", "speed_ratio")


@dataclass(frozen=True)
class Case:
    """One trajectory of the other program and ours with and without roll."""

    file: str
    speed: float
    rudder_deg: float
    theirs: pd.DataFrame
    rolling: Track
    upright: Track


def read(folder: Path) -> list[Case]:
    """The cases of a folder; the rudder law is that of the other program."""
    cases = []
    for file, speed, rudder_deg in FILES:
        theirs = pd.read_csv(folder / f"s175_mss_turn_{file}.csv")
        rolling, upright = (
            simulate(
                name,
                speed=speed,
                rudder_deg=rudder_deg,
                rudder_law="lag",
                rudder_rate_deg=5.0,
                dt=1.0,
                duration=float(theirs["t"].iloc[-1]),
                rtol=1e-10,
            )
            for name in ("s175", "s175-3dof")
        )
        cases.append(Case(file, speed, rudder_deg, theirs, rolling, upright))
    return cases


def difference(track: Track, theirs: pd.DataFrame, channel: str) -> float:
    """Largest difference over the range of the channel [%]."""
    expected = theirs[channel].to_numpy()
    ours = getattr(track, channel)
    return float(100 * np.max(np.abs(ours - expected)) / np.ptp(expected))


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    default = os.environ.get("PMMKIT_DATA", ROOT.parent / "shared" / "data")
    parser.add_argument("--data", type=Path, default=Path(default))
    folder = parser.parse_args().data / "s175_container_m"
    if not folder.is_dir():
        print(f"The trajectories are not at {folder}: give their folder with --data. Nothing done.")
        return
    cases = read(folder)
    print("Largest difference from the independent program, % of the range of the channel")
    print(f"{'trajectory':12}{'model':8}" + "".join(f"{name:>10}" for name in CHANNELS))
    for case in cases:
        for label, track in (("4-DOF", case.rolling), ("3-DOF", case.upright)):
            row = "".join(f"{difference(track, case.theirs, name):10.2g}" for name in CHANNELS)
            print(f"{case.file:12}{label:8}{row}")
    print("\nThe turn with roll and without (what roll makes of it, %)")
    print(f"{'measure':22}" + "".join(f"{case.file:>26}" for case in cases))
    for name in MEASURES:
        row = f"{name:22}"
        for case in cases:
            with_roll, without = case.rolling.metrics[name], case.upright.metrics[name]
            change = 100 * (with_roll / without - 1)
            row += f"{with_roll:10.3f}{without:8.3f} {change:+6.1f}%"
        print(row)
    for name in ("heel_max_deg", "heel_steady_deg"):
        print(
            f"{name:22}" + "".join(f"{case.rolling.metrics[name]:10.2f}{'':16}" for case in cases)
        )


if __name__ == "__main__":
    main()
