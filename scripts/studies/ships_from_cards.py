"""Do the intervals of ships from their cards hold? Cards of library ships, made from their models.

    python -m scripts.studies.ships_from_cards [--ships 200] [--write]

Of each ship a card is made by her own model, which shares no formula with the estimate but where
the table says so; a ship is made from a part of that card, and the rest of the card is foretold.
--write puts the tables into docs/card.md.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Final

from scipy import stats

from pmmkit.cards import Card, CardFit, ship_from_card
from pmmkit.conventions import Metric
from scripts.studies.bulk_carrier import TRIAL

SHIPS: Final = {
    "s175": 9.0,
    "s175-3dof": 9.0,
    "kvlcc2": 7.97,
    "kvlcc2-l7": 1.18,
    "kcs": 12.35,
    "esso-osaka-3m": 0.52,
    "mariner": 7.7175,
    "esso190k": 8.23,
    "bulk-carrier-170": TRIAL,
    "tanker-320": 8.0,
}
"""Models of the library and their approach [m/s]."""
TURN: Final = ("advance_L", "transfer_L", "tactical_diameter_L")
ZIGZAG: Final = ("overshoot_1_deg", "overshoot_2_deg")
CARDS: Final[Mapping[str, Mapping[tuple[str, float], Sequence[str]]]] = {
    "a turn": {("turning", 35.0): TURN},
    "a turn and a 10/10 zigzag": {("turning", 35.0): TURN, ("zigzag", 10.0): ZIGZAG},
    "turns and 10/10 zigzags to both sides": {
        ("turning", side * 35.0): TURN for side in (1.0, -1.0)
    }
    | {("zigzag", side * 10.0): ZIGZAG for side in (1.0, -1.0)},
}
"""What of the card is known: manoeuvre and rudder [deg], measures."""


@dataclass(frozen=True, kw_only=True)
class Row:
    """A measure that was not on a card, beside what the ship's own model does."""

    ship: str
    card: str
    manoeuvre: str
    measure: str
    truth: float
    low: float
    high: float
    width: float

    @property
    def held(self) -> bool:
        """Whether the interval holds the truth."""
        return self.low <= self.truth <= self.high


def part(card: Card, known: Mapping[tuple[str, float], Sequence[str]]) -> Card:
    """A card with some of its measures."""
    tests = []
    for test in card.tests:
        wanted = known.get((test.manoeuvre, test.settings.get("rudder_deg", 0.0)), ())
        kept = tuple(item for item in test.measures if item.name in wanted)
        if kept:
            tests.append(replace(test, measures=kept))
    return replace(card, tests=tuple(tests))


def rows_of(name: str, what: str, ships: int) -> tuple[CardFit, list[Row]]:
    """A ship from a part of her card, and what is foretold of her."""
    full = Card.of(name, SHIPS[name])
    found = ship_from_card(part(full, CARDS[what]), ships=ships)
    truth = {(test.words, item.name): item.value for test in full.tests for item in test.measures}
    rows = [
        Row(
            ship=name,
            card=what,
            manoeuvre=item.test.words.split(",")[0],
            measure=Metric.in_words(item.name),
            truth=truth[item.test.words, item.name],
            low=item.low,
            high=item.high,
            width=(item.high - item.low) / (item.high_before - item.low_before),
        )
        for item in found.foretold
        if (item.test.words, item.name) in truth
    ]
    return found, rows


def share(rows: Sequence[Row]) -> str:
    """How many intervals hold, and the 95 % interval of their share if they were independent."""
    held, n = sum(row.held for row in rows), len(rows)
    known = stats.binomtest(held, n).proportion_ci(0.95, method="exact")
    return (
        f"{held} of {n}, {100 * held / n:.3g} % ({100 * known.low:.0f} to {100 * known.high:.0f})"
    )
