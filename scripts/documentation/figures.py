"""Tables of figures that pages quote, computed by what they describe."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

import pmmkit as pk
from pmmkit.empirical import METHODS, estimate
from pmmkit.models.hull import hull_table
from pmmkit.ship_library import load_ship
from pmmkit.tables.convert import converted
from scripts.documentation.fences import table

METHOD: Final = "yoshimura-masumoto"
SHIPS: Final = ("kvlcc2", "kcs", "s175-3dof")


def formulas() -> str:
    """How far library ships lie from Yoshimura and Masumoto's formulas."""
    known = METHODS[METHOD]
    guesses = [estimate(load_ship(name), METHOD) for name in SHIPS]
    there = [converted(hull_table(name), known.convention).at() for name in SHIPS]
    rows: list[Sequence[str]] = []
    for name in guesses[0].values:
        cells = [
            f"{guess.values[name]:.3f}, {values[name]:.3f}" if name in values else ""
            for guess, values in zip(guesses, there, strict=True)
        ]
        error = known.error_of(name)
        told = f"{100 * error.share:.0f} %" if error.share else f"{error.number:g}"
        rows.append((name, *cells, told))
    head = ("derivative", *(f"`{name}`: formula, library" for name in SHIPS), "standard error")
    return table(head, rows)


def scales() -> str:
    """A turn of KVLCC2 by the steps from model to ship scale."""
    model = pk.load_model("kvlcc2-l7")
    how = {"speed": 7.97, "form": 0.2, "wetted": 27194.0, "water": pk.Water(rho=1025.0)}
    steps = {
        "Froude's law alone": pk.scaled(model, 320.0),
        "friction corrected": pk.full_scale(model, 320.0, wake=False, **how),
        "friction and wake corrected": pk.full_scale(model, 320.0, **how),
    }
    rows = []
    for name, ship in steps.items():
        track = pk.simulate(ship, "turning", rudder_deg=35, speed=7.97, compiled=False)
        lengths = (track.metrics[x] for x in ("advance_L", "tactical_diameter_L"))
        rows.append((name, f"{60 * track.n[0]:.1f}", *(f"{x:.2f}" for x in lengths)))
    head = ("KVLCC2, 35° to starboard, 7.97 m/s", "rpm", "advance / L", "tactical diameter / L")
    return table(head, rows)


TABLES: Final = {"estimates.md": {"formulas": formulas}, "scale.md": {"scales": scales}}
"""What stands between the marks of a page."""
