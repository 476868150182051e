"""How far library ships lie from Yoshimura and Masumoto's formulas, for docs/estimates.md."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Final

from pmmkit.empirical import METHODS, estimate
from pmmkit.models.hull import hull_table
from pmmkit.ship_library import load_ship
from pmmkit.tables.convert import converted

PAGE: Final = Path(__file__).parents[2] / "docs" / "estimates.md"
FENCE: Final = re.compile(r"(<!-- figures:.*? -->\n).*?(<!-- end of figures -->)", re.S)
METHOD: Final = "yoshimura-masumoto"
SHIPS: Final = ("kvlcc2", "kcs", "s175-3dof")


def page() -> str:
    """docs/estimates.md with the figures as they stand."""
    known = METHODS[METHOD]
    guesses = [estimate(load_ship(name), METHOD) for name in SHIPS]
    there = [converted(hull_table(name), known.convention).at() for name in SHIPS]
    head = ["derivative", *(f"`{name}`: formula, library" for name in SHIPS), "standard error"]
    lines = [f"| {' | '.join(head)} |", "|---" * len(head) + "|"]
    for name in guesses[0].values:
        cells = [
            f"{guess.values[name]:.3f}, {values[name]:.3f}" if name in values else ""
            for guess, values in zip(guesses, there, strict=True)
        ]
        error = known.error_of(name)
        told = f"{100 * error.share:.0f} %" if error.share else f"{error.number:g}"
        lines.append(f"| {' | '.join([name, *cells, told])} |")
    table = "\n".join(lines)
    text = PAGE.read_text(encoding="utf-8")
    return FENCE.sub(lambda found: f"{found[1]}{table}\n{found[2]}", text)
