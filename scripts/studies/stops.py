"""Stops that were measured, or are told by who sails the ships, beside what pmmkit predicts.

    python -m scripts.studies.stops

Nothing is fitted to them. Two ships are in the library with what is published of them. Of the
others little more than type, size and speed is told: particulars are taken that are usual for such
a ship, and they are sailed by estimates throughout. The last three have no trial and show what
their own models give. A band is of 1000 ships that differ as far as is known, by an engine that
nobody states.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Final

import numpy as np

import pmmkit as pk
from pmmkit.conventions import Ship, Water
from pmmkit.models import Model
from pmmkit.models.particulars import propeller_diameter, rudder_area

KNOT: Final = 1852 / 3600
SHIPS: Final = 1000
LIMIT: Final = 15.0
"""Of the track reach by the standard [L]."""


@dataclass(frozen=True, kw_only=True)
class Stop:
    """A stop.

    Parameters
    ----------
    title, source : str
        Whose it is, and where it is told.
    model : Model
        By which it is predicted.
    knots : float
        Of the approach.
    reach, time : float
        Track reach [m] and time [s] as told; NaN where they are not.
    """

    title: str
    source: str
    model: Model
    knots: float
    reach: float = math.nan
    time: float = math.nan


def usual(name: str, *, L: float, B: float, d: float, block: float, knots: float) -> Model:
    """A ship by estimates from her particulars alone."""
    water = Water(rho=1025.0)
    volume = block * L * B * d
    mass = water.rho * volume
    ship = Ship(
        name=name, L=L, B=B, d=d, volume=volume, mass=mass, xG=0.0, Izz=mass * (0.25 * L) ** 2
    )
    return pk.estimated_model(
        ship,
        speed=knots * KNOT,
        propeller_diameter=propeller_diameter(ship),
        rudder_area=rudder_area(ship),
        water=water,
    )


def stops() -> tuple[Stop, ...]:
    """All of them."""
    vlcc = usual("VLCC", L=320.0, B=58.0, d=20.8, block=0.81, knots=16.0)
    return (
        Stop(
            title="bulk carrier, 170 m, ballast",
            source="sea trial (docs/bulk_carrier.md)",
            model=pk.load_model("bulk-carrier-170"),
            knots=14.1,
            reach=2407.0,
            time=587.0,
        ),
        Stop(
            title="patrol vessel, 44 m, waterjets",
            source="sea trial (docs/patrol_vessel.md)",
            model=pk.load_model("patrol-vessel-44"),
            knots=28.3,
            reach=209.0,
            time=25.0,
        ),
        Stop(
            title="VLCC of a fleet; particulars of KVLCC2 taken",
            source="Idemitsu Tanker, about speed (idemitsu.com)",
            model=vlcc,
            knots=16.0,
            reach=4100.0,
            time=900.0,
        ),
        Stop(
            title="VLCC, 300 000 dwt, laden; the same taken",
            source="Japan Shipowners' Association, seminar 23 (rounded)",
            model=vlcc,
            knots=16.0,
            reach=3000.0,
            time=900.0,
        ),
        Stop(
            title="car carrier Asaka 2, 103.5 m over all",
            source="her trial, in a ruling of 2005 on a collision of 2003",
            model=usual("car carrier", L=96.0, B=16.0, d=5.2, block=0.56, knots=18.6),
            knots=18.6,
            time=228.0,
        ),
        Stop(
            title="coastal tanker of 499 GT, some 65 m over all",
            source="Meiwa Kaiun, tips 62",
            model=usual("coastal tanker", L=61.0, B=10.0, d=4.2, block=0.72, knots=11.5),
            knots=11.5,
            reach=576.0,
        ),
        Stop(
            title="cargo ship of 3000 t, less than 3 min",
            source="Cockcroft and Lameijer, Collision Avoidance Rules",
            model=usual("cargo ship", L=85.0, B=13.0, d=4.4, block=0.60, knots=16.0),
            knots=16.0,
            time=180.0,
        ),
        Stop(
            title="Esso tanker, 190 000 dwt, her own model",
            source="no trial",
            model=pk.load_model("esso190k"),
            knots=16.0,
        ),
        Stop(
            title="KVLCC2, her own model",
            source="no trial",
            model=pk.load_model("kvlcc2"),
            knots=15.5,
        ),
        Stop(title="KCS, her own model", source="no trial", model=pk.load_model("kcs"), knots=24.0),
    )


def row(stop: Stop) -> list[str]:
    """Measured, median, band, whether the band holds it, and the verdict of the standard."""
    speed, L = stop.knots * KNOT, stop.model.ship.L
    many = pk.monte_carlo(stop.model, "stopping", speed=speed, n=SHIPS, extrapolate=True)
    told, bands, held = [], [], []
    for name, value, over, unit in (
        ("track_reach", stop.reach, L, "L"),
        ("time_to_stop", stop.time, 1.0, "s"),
    ):
        low, high = many.interval(name)
        middle = float(np.nanmedian(many.metrics[name]))
        bands.append(f"{middle / over:.3g}, {low / over:.3g} to {high / over:.3g} {unit}")
        told.append(f"{value / over:.3g} {unit}" if math.isfinite(value) else "-")
        held += [low <= value <= high] if math.isfinite(value) else []
    verdict = pk.imo_verdicts(stop.model, speed, n=SHIPS, extrapolate=True)[-1]
    share = "" if verdict.probability is None else f", {100 * verdict.probability:.0f} %"
    inside = f"{sum(held)} of {len(held)}" if held else "-"
    head = [stop.title, f"{stop.knots:g}", *told, *bands, inside]
    return [*head, f"{verdict.words}{share}", stop.source]


def main() -> None:
    """The table."""
    head = ["ship", "knots", "track reach", "time", "predicted reach: median, 95 % band"]
    head += ["predicted time", "inside", "at most 15 L", "told by"]
    print("| " + " | ".join(head) + " |\n" + "|---" * len(head) + "|")
    for stop in stops():
        print("| " + " | ".join(row(stop)) + " |")


if __name__ == "__main__":
    main()
