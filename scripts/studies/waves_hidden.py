"""Waves hidden among wind and current in free-running records, as docs/evidence.md quotes it.

    python -m scripts.studies.waves_hidden
    python -m scripts.studies.waves_hidden wrong 6

The tank's own S175, whose waves are walls that reflect, sails two turns and two zigzags; the model
that is asked has strip theory's table of drift, which waits. Asked for what is ``wrong`` its X is
off by two and its N by five, either way, at as many seeds.
"""

from __future__ import annotations

import sys
from time import process_time

import numpy as np

import pmmkit as pk
from pmmkit.diagnosis.free_running.diagnose import diagnose_free
from pmmkit.seakeeping import frequencies
from pmmkit.seakeeping.second_order.mean_drift import drift_table
from tests.diagnosis.test_wave_drift import HEIGHT, NOISE, PERIOD, RIVALS, SHIP, sailed, with_table
from tests.support.few_stations import thinned
from tests.support.free_tank.hidden import NOTHING, Hidden

CURRENT = (0.4, 0.3)
CASES = (
    ("waves", Hidden(waves=1.0), False),
    ("wind", Hidden(windage=1.0), False),
    ("current", Hidden(current=CURRENT), False),
    ("waves and wind", Hidden(waves=1.0, windage=1.0), False),
    ("waves and current", Hidden(waves=1.0, current=CURRENT), False),
    ("waves, wind and current", Hidden(waves=1.0, windage=1.0, current=CURRENT), False),
    ("nothing", NOTHING, False),
    ("waves, wind from the same side", Hidden(waves=1.0), True),
)


WRONG = {"too large": {"DX": 2.0, "DN": 5.0}, "too small": {"DX": 0.5, "DN": 0.2}}
"""Tables that are off, by what."""


def table() -> dict[str, tuple[float, ...]]:
    """Strip theory's table of drift of the sea."""
    hull = thinned(pk.load_hull("s175"))
    waves = pk.sea("bretschneider", Hs=HEIGHT, Tp=PERIOD)
    headings = np.arange(0, 181, 15)
    omega = frequencies(hull.L, waves)
    found = pk.rao(hull, speeds=8.5, headings_deg=headings, omega=omega)
    return drift_table(found, waves)


def wrong(seeds: int) -> None:
    """Print what is named by tables that are off, at several seeds."""
    for name, off in WRONG.items():
        values = table()
        values |= {force: tuple(by * x for x in values[force]) for force, by in off.items()}
        model = with_table(SHIP, values)
        for case, hidden, _ in (CASES[0], CASES[3], CASES[-2]):
            for seed in range(seeds):
                records = sailed(hidden, seed=seed)
                told = diagnose_free(model, records, candidates=RIVALS, sensors=NOISE, most=3)
                named = [f"{', '.join(effects)} ({odds:.3f})" for effects, odds in told.group]
                said = f"{'; '.join(named) or 'nothing'} [{told.verdict}] {', '.join(told.flags)}"
                print(f"{name}, {case}, seed {seed}: {said}", flush=True)


def main() -> None:
    """Print what is named in each case, and by which sizes."""
    model = with_table(SHIP, table())
    for name, hidden, one_side in CASES:
        records = sailed(hidden, one_side=one_side)
        begun = process_time()
        told = diagnose_free(model, records, candidates=RIVALS, sensors=NOISE, most=3)
        named = [f"{', '.join(effects)} ({odds:.3f})" for effects, odds in told.group]
        print(f"{name}: {'; '.join(named) or 'nothing'} ({process_time() - begun:.0f} s)")
        for one in told.findings:
            sizes = ", ".join(f"{key} {value:.3f}" for key, value in one.coefficients.items())
            error = f"{one.error_before:.2f} to {one.error_after:.2f}"
            print(f"    {one.effect}: {sizes}; {one.evidence}; error {error}")
        factors = told.model.values("wave_drift") if told.findings else {}
        moved = ", ".join(f"{key} {factors[key]:.2f}" for key in ("kx", "ky", "kn") if factors)
        print(f"    {moved}" if moved else "")


if __name__ == "__main__":
    if sys.argv[1:2] == ["wrong"]:
        wrong(int(sys.argv[2]))
    else:
        main()
