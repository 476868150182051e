"""Diagnosis of simulated zigzags: how often is it right, and does it stay silent?

    python -m scripts.studies.diagnose_free_study [--seeds 3] [--first 0] \
        [--hidden none asymmetry ...]

The 7 m model of KVLCC2 sails six zigzags with an effect hidden in it; the model that is diagnosed
is off by 3 % (one standard deviation) in every value, and the diagnosis knows no more than that.
All candidates take part, in sets of up to two. Ship and simulator are pmmkit's own: this counts, it
does not validate; for that see the real cases, and trajectories of another program in the tests.
"""

from __future__ import annotations

import argparse
import math
import time

import numpy as np

from pmmkit.diagnosis.free_running.base import movable
from pmmkit.diagnosis.free_running.diagnose import diagnose_free
from pmmkit.identification import Prior, places
from pmmkit.identification.binding import with_parameters
from pmmkit.models import Model
from tests.support.zigzags import SENSORS, SHIP, SPEED, sailed

RUNS = ((20, 20), (-10, 10), (25, 5), (-15, 10), (-20, 20), (10, 10))
HULL, RUDDER = "hull_polynomial", "rudder_mmg"
HIDDEN = {
    "none": (SHIP, 0.0),
    "asymmetry": (SHIP.with_values(HULL, Y0=0.0015, N0=-0.0007), 0.0),
    "fault_rudder_zero": (SHIP, math.radians(1.0)),
    "yaw_sway_coupling": (SHIP.with_values(HULL, Nvvr=-0.470, Yvvr=0.606), 0.0),
    "flow_straightening": (SHIP.with_values(RUDDER, gamma_positive=0.44, gamma_negative=0.55), 0.0),
    "rudder_slipstream": (SHIP.with_values(RUDDER, epsilon=1.3), 0.0),
    "modulus_yaw_drag": (SHIP.with_values(HULL, **{"Yr|r|": 0.10, "Nr|r|": -0.076}), 0.0),
}


def known_to(share: float, seed: int) -> Model:
    """The ship as somebody knows it: every value off by a share."""
    prior = Prior.of(SHIP, movable(SHIP), SPEED, spread=share)
    drawn = np.random.default_rng(seed + 77).normal(size=len(prior.names))
    return with_parameters(SHIP, places(SHIP, prior.names), prior.mean + prior.std * drawn)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--seeds", type=int, default=3)
    parser.add_argument("--first", type=int, default=0)
    parser.add_argument("--hidden", nargs="+", default=list(HIDDEN), choices=list(HIDDEN))
    options = parser.parse_args()
    for seed in range(options.first, options.first + options.seeds):
        for name in options.hidden:
            model, zero = HIDDEN[name]
            began = time.perf_counter()
            found = diagnose_free(
                known_to(0.03, seed),
                sailed(model, seed, zero=zero, runs=RUNS),
                sensors=SENSORS,
                most=2,
            )
            group = ", ".join(f"{' + '.join(names)} {odds:.2f}" for names, odds in found.group)
            best = found.entries[0]
            print(
                f"{name:20} {seed:3} {found.verdict:15} {group or '-'}   (best "
                f"{' + '.join(best.names)} {best.log_evidence:.1f}) "
                f"{time.perf_counter() - began:.0f} s",
                flush=True,
            )


if __name__ == "__main__":
    main()
