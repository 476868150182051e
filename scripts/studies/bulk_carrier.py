"""A bulk carrier's trials beside the ship of the library that has few measured values.

    python -m scripts.studies.bulk_carrier

The trials are those printed in "Estimation of Hydrodynamic Derivatives from Sea Trial Data Using
System Identification Technique" (170 m bulk carrier in ballast, 19 137 t). Of `bulk-carrier-170`
the paper gives nine derivatives; the rest is estimated from the particulars and not tuned to the
trial. The turns are also read from where a bridge stands, and the stop is made with what nobody
states varied, to show what of it decides.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any, Final

import numpy as np

import pmmkit as pk
from pmmkit.simulation import Track

KNOT: Final = 1852 / 3600
NAME: Final = "bulk-carrier-170"
TRIAL: Final = 14.1 * KNOT
TURNS: Final[Mapping[tuple[float, str], float]] = {
    (-35.0, "advance_L"): 3.61,
    (-35.0, "transfer_L"): 0.74,
    (-35.0, "tactical_diameter_L"): 2.99,
    (35.0, "advance_L"): 3.62,
    (35.0, "transfer_L"): 0.85,
    (35.0, "tactical_diameter_L"): 3.08,
}
"""Turning circles of the trial: rudder [deg, to starboard] and metric."""
METRICS: Final = ("advance_L", "transfer_L", "tactical_diameter_L")
STOP: Final = {"time_to_stop": 587.0, "track_reach": 2407.0}
"""The crash stop of the trial [s, m]."""
BRIDGE: Final = -0.4
"""Where the bridge of a bulk carrier usually stands, forward of midship over L: her log of
positions is its."""
STOPS: Final[Mapping[str, Mapping[str, float]]] = {
    "an engine as pmmkit assumes it": {},
    "0.5 of the revolutions": {"turns": -0.5},
    "all of them": {"turns": -1.0},
    "half of the approach's torque astern": {"torque": 0.5},
    "reversed in 120 s, whatever the engine": {"reversal_s": 120.0},
    "reversed in 240 s, whatever the engine": {"reversal_s": 240.0},
}
"""What of the stop nobody states, one thing at a time."""
SHIPS: Final = 2000
"""Drawn for the band of the stop."""


def turned(angle: float) -> Track:
    """A turning circle as in the trial."""
    return pk.simulate(NAME, "turning", rudder_deg=angle, speed=TRIAL, compiled=False)


def seen_from(track: Track, place: float) -> tuple[float, float, float]:
    """Advance, transfer and tactical diameter [L] of a point on the centre line.

    Parameters
    ----------
    track : Track
        A turn.
    place : float
        The point, forward of midship over L.
    """
    heading = np.abs(track.psi)
    first, half = (float(np.interp(angle, heading, track.t)) for angle in (math.pi / 2, math.pi))
    x = track.x / track.L + place * (np.cos(track.psi) - 1.0)
    y = np.abs(track.y / track.L + place * np.sin(track.psi))
    advance, transfer = (float(np.interp(first, track.t, way)) for way in (x, y))
    return advance, transfer, float(np.interp(half, track.t, y))


def stopped(**settings: float) -> Mapping[str, Any]:
    """Numbers of a stop as in the trial."""
    return pk.simulate(NAME, "stopping", speed=TRIAL, compiled=False, **settings).metrics


def band() -> dict[str, tuple[float, float]]:
    """95 % bands of the stop's time and track reach [s, m]."""
    many = pk.monte_carlo(NAME, "stopping", speed=TRIAL, n=SHIPS)
    return {name: many.interval(name) for name in STOP}


def main() -> None:
    tracks = {angle: turned(angle) for angle in (-35.0, 35.0)}
    print(f"{60 * tracks[35.0].n[0]:.0f} rpm at 14.1 kn")
    print("\nTurning circles, 35°, in L        trial   model          from the bridge")
    for (angle, name), trial in TURNS.items():
        found = tracks[angle].metrics[name]
        bridge = seen_from(tracks[angle], BRIDGE)[METRICS.index(name)]
        where = "port" if angle < 0 else "starboard"
        off, beside = (100 * (x / trial - 1) for x in (found, bridge))
        print(
            f"  {where:10} {name:20} {trial:6.2f}  {found:6.2f}  {off:+4.0f} %"
            f"  {bridge:6.2f}  {beside:+4.0f} %"
        )
    print(f"\n{'Crash stop from 14.1 kn':42} time [s]   track reach [m]")
    print(f"{'trial':42} {STOP['time_to_stop']:8.0f} {STOP['track_reach']:17.0f}")
    bands = band()
    low, high = (
        f"{bands['time_to_stop'][end]:8.0f} {bands['track_reach'][end]:17.0f}" for end in (0, 1)
    )
    print(f"{'95 % band, from':42} {low}\n{'95 % band, to':42} {high}")
    for title, settings in STOPS.items():
        found = stopped(**settings)
        off = found["track_reach"] / STOP["track_reach"] - 1
        print(
            f"{title:42} {found['time_to_stop']:8.0f} {found['track_reach']:17.0f}"
            f"  {100 * off:+.0f} %"
        )


if __name__ == "__main__":
    main()
