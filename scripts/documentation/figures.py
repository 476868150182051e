"""Tables of figures that pages quote, computed by what they describe."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

import pmmkit as pk
from pmmkit.api import DAMPED
from pmmkit.models import converted, estimate, hull_table, load_ship
from pmmkit.models.empirical import METHODS, StandardError
from pmmkit.models.estimates import RESISTANCE_ERROR
from pmmkit.models.particulars import (
    ANOTHER,
    ANOTHER_DRAWN,
    DRAWN,
    ELSEWHERE,
    GROWTH,
    PROPELLER_ERRORS,
    SERIES_ERRORS,
)
from pmmkit.models.revise import ERRORS, share_left
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
        rows.append((name, *cells, error.words, next_ship(error)))
    ships = (f"`{name}`: formula, library" for name in SHIPS)
    return table(("derivative", *ships, "deviation", "standard error"), rows)


def next_ship(error: StandardError, share: float = 1.0) -> str:
    """A share of the standard error of one more ship."""
    size = share * error.of(1.0)
    return "none" if not size else f"{100 * size:.0f} %" if error.share else f"{size:.2g}"


def kinds() -> str:
    """Which uncertainty a value has, by what it stands on."""
    drawn = ", ".join(DRAWN)
    growth = next_ship(PROPELLER_ERRORS[GROWTH[-1]])
    rows = [
        ("measured here", "covariance of the reduction or the fit", "the scatter of its runs"),
        ("drawn or stated", "none", "a drawing, an open-water test, or who states it"),
        (
            "measured on this ship elsewhere",
            f"{ELSEWHERE:g} of the error of an estimate; {drawn}: none",
            "KVLCC2 in two laboratories",
        ),
        (
            "another ship's",
            f"{ANOTHER:g} of the error of an estimate; {drawn}: {ANOTHER_DRAWN:g} of it",
            "√2 of the deviation of a ship; similar ships of the library",
        ),
        (
            "estimated",
            "√(1 + 1/n) of the deviation of n ships",
            "ships of the library beside the formula, below",
        ),
        (
            "not stated",
            f"none; growth of a propeller's wake in drift: {growth}, as an estimate",
            "values of the library are as published, without an uncertainty",
        ),
    ]
    return table(("a value is", "its standard uncertainty", "where that is from"), rows)


def provenance() -> str:
    """The standard errors of propeller, rudder, resistance and roll damping."""
    rows: list[Sequence[str]] = []
    for effect, errors in ERRORS.items():
        for name, error in errors.items():
            lent = (next_ship(error, share_left(name, same_ship=own)) for own in (False, True))
            rows.append((f"`{effect}.{name}`", error.words, next_ship(error), *lent, error.source))
    for name, error in SERIES_ERRORS.items():
        text = f"`propeller.{name}`, B series"
        rows.append((text, error.words, next_ship(error), "", "", error.source))
    known = RESISTANCE_ERROR
    rows.append(("resistance", known.words, next_ship(known), "", "", known.source))
    usual, doubt = DAMPED
    told = f"{doubt:g} of the critical beside {usual:g}"
    rows.append(("`roll.damping`", "", told, "", "", "assumed: usual roll damping"))
    head = ("value", "deviation", "estimated", "another ship's", "this ship's, elsewhere", "from")
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


TABLES: Final = {
    "estimates.md": {"formulas": formulas, "kinds": kinds, "provenance": provenance},
    "scale.md": {"scales": scales},
}
"""What stands between the marks of a page."""
