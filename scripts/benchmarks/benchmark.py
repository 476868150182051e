"""Speed, measured side by side: reading and reducing histories beside pandas.read_csv alone.

    python -m scripts.benchmarks.benchmark [--runs 24] [--rows 20000] [--rounds 7]

The same CSV files are read by pandas alone, read by pmmkit with all its checks of the file, and
reduced to a derivative table. The rounds alternate, so that a busy machine hits all alike; ratios
are those of processor time, which other work on the machine changes least.
"""

from __future__ import annotations

import argparse
import math
import statistics
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pandas as pd

import pmmkit as pk
from pmmkit.reduction import reduce_campaign
from scripts.datasets.s175_programme import noise
from scripts.datasets.virtual_tank import SHIP, SON_NOMOTO, WATER, motion, water_forces

SPEED = 1.5
COLUMNS = ("t", "X", "Y", "N", "u", "v", "r", "sinkage", "trim")


def make(folder: Path, runs: int, rows: int) -> list[Path]:
    """Histories as CSV with a campaign file, nine columns each."""
    rng = np.random.default_rng(0)
    entries, files = [], []
    for number in range(runs):
        test = ("static_drift", "pure_sway", "pure_yaw")[number % 3]
        size = 0.2 + 0.5 * (number // 3 + 1) / runs
        omega = 2.0 * SPEED / SHIP.L
        t = np.arange(rows) * (6 * 2 * math.pi / omega / rows)
        drift = math.radians(-12 + 24 * number / runs)
        given = {
            "static_drift": {"drift": drift},
            "pure_sway": {"v": 0.5 * size},
            "pure_yaw": {"r": size},
        }[test]
        state = motion(test, SPEED, omega * t, omega, **given)
        force = water_forces(SON_NOMOTO, *state)
        frame = pd.DataFrame({"t": t})
        for channel, values in force.items():
            frame[channel] = values + noise(rng, rows, 0.01 * float(np.abs(values).max()))
        for name, values in zip("uvr", state[:3], strict=True):
            frame[name] = values
        frame["sinkage"], frame["trim"] = -0.004, 0.001
        path = folder / f"{test}_{number:03d}.csv"
        frame.to_csv(path, index=False, float_format="%.6g", columns=list(COLUMNS))
        files.append(path)
        entry = f'[[runs]]\nid = "{path.stem}"\ntest = "{test}"\nfile = "{path.name}"\n'
        entry += f"speed = {SPEED}\n"
        if test == "static_drift":
            entry += f"drift_deg = {math.degrees(drift)}\n"
        else:
            entry += f"period = {2 * math.pi / omega}\n"
        if test == "pure_sway":
            entry += f"amplitude_m = {0.5 * size * SPEED / omega}\n"
        if test == "pure_yaw":
            entry += f"yaw_amplitude_deg = {math.degrees(size * SPEED / SHIP.L / omega)}\n"
        entries.append(entry)
    head = (
        '[campaign]\ntitle = "benchmark"\nkind = "captive"\nforces = "hydrodynamic"\n'
        f'[ship]\nname = "model"\nL = {SHIP.L}\nB = {SHIP.B}\nd = {SHIP.d}\nmass = {SHIP.mass}\n'
        f"Izz = {SHIP.Izz}\nvolume = {SHIP.volume}\n[water]\nrho = {WATER.rho}\n"
    )
    (folder / "campaign.toml").write_text(head + "\n".join(entries), encoding="utf-8")
    return files


def seconds(work: Callable[[], object]) -> tuple[float, float]:
    """Of the clock, and of this process."""
    start, own = time.perf_counter(), time.process_time()
    work()
    return time.perf_counter() - start, time.process_time() - own


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--runs", type=int, default=24)
    parser.add_argument("--rows", type=int, default=20_000)
    parser.add_argument("--rounds", type=int, default=7)
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        files = make(folder, options.runs, options.rows)
        size = sum(path.stat().st_size for path in files) / 1e6
        ways: dict[str, Callable[[], object]] = {
            "pandas.read_csv alone": lambda: [pd.read_csv(path) for path in files],
            "pmmkit, reading and checking the files": lambda: [
                run.data for run in pk.open_campaign(folder)
            ],
            "pmmkit, to the derivative table, 1 thread": lambda: reduce_campaign(
                pk.open_campaign(folder), structure="cubic", executor=1
            ),
            "pmmkit, to the derivative table": lambda: reduce_campaign(
                pk.open_campaign(folder), structure="cubic"
            ),
        }
        times: dict[str, list[tuple[float, float]]] = {way: [] for way in ways}
        for work in ways.values():
            work()
        for _ in range(options.rounds):
            for way, work in ways.items():
                times[way].append(seconds(work))
    print(
        f"{len(files)} histories of {options.rows} rows, {size:.1f} MB, median of {options.rounds}"
    )
    base = statistics.median(own for _, own in times["pandas.read_csv alone"])
    for way, taken in times.items():
        clock, own = (statistics.median(x) for x in zip(*taken, strict=True))
        print(
            f"{way:42} {clock:6.3f} s, {own:6.3f} s of the processor  "
            f"{size / own:6.1f} MB/s  {own / base:5.2f} x pandas"
        )


if __name__ == "__main__":
    main()
