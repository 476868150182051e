"""The time of one diagnosis of free-running records, on one core.

    python -m scripts.benchmarks.benchmark_records [--records 8 20] [--instants 151 2000] \
        [--steps 0.5 0.1]

Turns and zigzags of the 7 m model of KVLCC2, which the library's model sails with an asymmetry that
the diagnosis does not know, with the noise of a tank's sensors; the whole catalogue is asked. Times
are those of the process, compiling not counted.
"""

from __future__ import annotations

import argparse
import time
from typing import Any, Final

import numpy as np

import pmmkit as pk
from pmmkit.diagnosis.free_running.diagnose import diagnose_free
from pmmkit.identification import FreeRecord
from tests.support.recorded import recorded
from tests.support.zigzags import ASYMMETRY, SENSORS, SHIP, SPEED

ORDERS: Final = (
    ("zigzag", 20.0, 20.0),
    ("zigzag", -10.0, 10.0),
    ("turning", 35.0, 0.0),
    ("zigzag", 25.0, 5.0),
    ("turning", -25.0, 0.0),
    ("zigzag", -15.0, 15.0),
)
"""Manoeuvre, rudder, and heading of reversal [deg]; in turn, each with a speed of its own."""


def records(count: int, instants: int, step: float) -> list[FreeRecord]:
    """So many records of so many instants, a step [s] apart."""
    rng = np.random.default_rng(1)
    found = []
    for number in range(count):
        manoeuvre, rudder, switch = ORDERS[number % len(ORDERS)]
        speed = SPEED * (1.0 - 0.05 * (number // len(ORDERS)))
        own: dict[str, Any] = {"duration": step * instants}
        if manoeuvre == "zigzag":
            own = {"switch_deg": switch, "executes": 60}
        track = pk.simulate(ASYMMETRY, manoeuvre, rudder_deg=rudder, speed=speed, dt=step, **own)
        record = recorded(track, SENSORS, rng, name=f"{manoeuvre} {number}", speed=speed)
        found.append(record.cut(0.0, step * (instants - 1)))
    return found


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--records", type=int, nargs="*", default=[8, 20])
    parser.add_argument("--instants", type=int, nargs="*", default=[151, 2000])
    parser.add_argument("--steps", type=float, nargs="*", default=[0.5, 0.1])
    asked = parser.parse_args()
    diagnose_free(SHIP, records(2, 101, 0.5), candidates=["asymmetry"], most=1)
    print("records  instants  step [s]  processor [s]  clock [s]  named")
    for count, instants, step in zip(asked.records, asked.instants, asked.steps, strict=True):
        given = records(count, instants, step)
        begun = time.process_time(), time.perf_counter()
        found = diagnose_free(SHIP, given)
        used, waited = time.process_time() - begun[0], time.perf_counter() - begun[1]
        lengths = {len(item) for item in given}
        told = " and ".join(found.best) or found.verdict
        print(
            f"{count:7d}  {max(lengths):8d}  {step:8g}  {used:13.1f}  {waited:9.1f}  {told}",
            flush=True,
        )


if __name__ == "__main__":
    main()
