"""Do the intervals of ships from their cards hold? Cards of library ships, made from their models.

    python -m scripts.studies.ships_from_cards [--ships 200] [--write]

Of each ship a card is made by her own model; a ship is made from a part of that card, and the rest
of the card is foretold. The estimate knows nothing of that model, but for two: most derivatives of
the bulk carrier and of the preliminary tanker are such estimates themselves; and errors of the
estimate were found from KVLCC2, KCS and S175. Published trials are done the same way: what one
manoeuvre showed is the card, what others showed is foretold. --write puts the tables into
docs/card.md.
"""

from __future__ import annotations

import argparse
import math
import time
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from statistics import median
from types import MappingProxyType
from typing import Final

import pmmkit as pk
from pmmkit.cards import Card, ship_from_card
from pmmkit.cards.card import CardMeasure, CardTest, tolerance
from pmmkit.cards.fit import CardFit
from pmmkit.conventions import Metric
from pmmkit.files import write_text
from pmmkit.presentation import WIDE
from scripts.documentation.fences import DOCS, page, table
from scripts.studies.bulk_carrier import NAME, STOP, TRIAL, TURNS
from scripts.studies.leave_one_ship_out import SOURCES, SPEEDS, Row, deviations, share
from scripts.validation.measurements import HSVA

SHIPS: Final = {name: speed for name, (_, speed) in SPEEDS.items()} | {
    NAME: TRIAL,
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
class Foretold(Row):
    """A measure that was not on the card, which `hidden` names, beside what the ship does.

    `before`: its band by the estimate alone.
    """

    side: str = ""
    before: tuple[float, float] = (-math.inf, math.inf)


def part(card: Card, known: Mapping[tuple[str, float], Sequence[str]]) -> Card:
    """A card with some of its measures."""
    tests = []
    for test in card.tests:
        wanted = known.get((test.manoeuvre, test.settings.get("rudder_deg", 0.0)), ())
        kept = tuple(item for item in test.measures if item.name in wanted)
        if kept:
            tests.append(replace(test, measures=kept))
    return replace(card, tests=tuple(tests))


def band(value: float, std: float, *, by_factors: bool) -> tuple[float, float]:
    """95 % interval of a value."""
    low, high = -WIDE * std, WIDE * std
    if by_factors:
        one, two = (value * math.exp(x / value) for x in (low, high))
        return min(one, two), max(one, two)
    return value + low, value + high


def values_of(name: str, what: str, found: CardFit) -> list[Foretold]:
    """Derivatives and values of propeller and rudder beside those that were measured."""
    whose = SPEEDS[name][0] if name in SPEEDS else ""
    if SOURCES.get(whose) != name:
        return []
    rows = []
    for place, row in found.values().iterrows():
        own = str(place).replace("four_quadrant_", "")
        if whose not in (known := deviations().get(own, {})):
            continue
        former = (
            row["std"]
            / row["std_over_before"]
            * (row["before"] / row["value"] if "." in own else 1.0)
        )
        rows.append(
            Foretold(
                ship=name,
                hidden=what,
                manoeuvre="value",
                measure=own,
                truth=known[whose][1],
                band=band(row["value"], row["std"], by_factors="." in own),
                before=band(row["before"], former, by_factors="." in own),
            )
        )
    return rows


def rows_of(name: str, what: str, ships: int) -> tuple[float, list[Foretold], list[Foretold]]:
    """By what a ship of a part of her card was widened, what is foretold of her, and her values."""
    full = Card.of(name, SHIPS[name])
    found = ship_from_card(part(full, CARDS[what]), ships=ships)
    truth = {(test.words, item.name): item.value for test in full.tests for item in test.measures}
    rows = [
        Foretold(
            ship=name,
            hidden=what,
            manoeuvre=item.test.words.partition(",")[0],
            measure=Metric.in_words(item.name),
            truth=truth[item.test.words, item.name],
            band=(item.low, item.high),
            before=(item.low_before, item.high_before),
        )
        for item in found.foretold
        if (item.test.words, item.name) in truth
    ]
    return found.widened, rows, values_of(name, what, found)


ESSO_OSAKA: Final[Mapping[float, Mapping[str, float]]] = MappingProxyType(
    {
        34.9: {
            "advance_L": 2.85,
            "transfer_L": 1.32,
            "tactical_diameter_L": 2.93,
            "steady_diameter_L": 2.13,
            "speed_ratio": 0.39,
        },
        19.5: {
            "advance_L": 2.89,
            "transfer_L": 1.58,
            "tactical_diameter_L": 4.10,
            "steady_diameter_L": 4.28,
            "speed_ratio": 0.68,
        },
    }
)
"""Turns to starboard of the 3 m model outdoors by `pmmkit trial datasets/esso_osaka`: rudder [deg]
and measures. Its wind was four times as fast as the ship."""


def as_tested(
    speed: float, settings: Mapping[str, float], manoeuvre: str, known: Mapping[str, float]
) -> CardTest:
    """A manoeuvre with what a trial showed of it."""
    measures = tuple(
        CardMeasure(name=name, value=x, std=tolerance(name, x)) for name, x in known.items()
    )
    return CardTest(manoeuvre=manoeuvre, settings=settings, speed=speed, measures=measures)


def overshoots(rudder: int, switch: int, speed: float) -> CardTest:
    """A zigzag of HSVA's."""
    angles = {f"overshoot_{i}_deg": x for i, x in enumerate(HSVA[rudder, switch], start=1)}
    return as_tested(speed, {"rudder_deg": rudder, "switch_deg": switch}, "zigzag", angles)


def trials() -> Iterator[tuple[str, Card, list[CardTest]]]:
    """Published trials: the card of some manoeuvres, and the others."""
    bulk = pk.load_model(NAME)
    to = {
        side: as_tested(
            TRIAL,
            {"rudder_deg": side},
            "turning",
            {x: v for (y, x), v in TURNS.items() if y == side},
        )
        for side in (35.0, -35.0)
    }
    stop = {
        "track_reach_L": STOP["track_reach"] / bulk.ship.L,
        "time_to_stop": STOP["time_to_stop"],
    }
    yield (
        "bulk carrier of 170 m at sea: turn to starboard",
        Card(ship=bulk.ship, water=bulk.water, speed=TRIAL, tests=(to[35.0],)),
        [to[-35.0], as_tested(TRIAL, {}, "stopping", stop)],
    )
    tank = pk.load_model("kvlcc2-l7")
    yield (
        "KVLCC2 of HSVA, model of 7 m: zigzags 10/10 to both sides",
        Card(
            ship=tank.ship,
            water=tank.water,
            speed=1.179,
            tests=tuple(overshoots(rudder, 10, 1.179) for rudder in (10, -10)),
            propeller={"D": 0.204, "P_over_D": 0.808, "area_ratio": 0.448, "blades": 4},
            rudder={"area_lateral": 0.0654, "rate_deg_s": 15.8},
        ),
        [overshoots(rudder, switch, 1.179) for rudder, switch in HSVA if abs(rudder) != switch],
    )
    osaka = pk.load_model("esso-osaka-3m")
    card = Card.of(osaka, 0.36)
    sharp, wide = (
        as_tested(0.36, {"rudder_deg": rudder}, "turning", own)
        for rudder, own in ESSO_OSAKA.items()
    )
    yield "Esso Osaka, model of 3 m outdoors: turn of 35°", replace(card, tests=(sharp,)), [wide]


def trial_rows(title: str, card: Card, others: Sequence[CardTest], ships: int) -> list[Foretold]:
    """What a card foretells of the other manoeuvres of a trial."""
    found = ship_from_card(card, ships=ships)
    rows = []
    for test in others:
        many = pk.monte_carlo(
            found.model, test.manoeuvre, speed=test.speed, n=ships, **test.ordered
        )
        rows += [
            Foretold(
                ship=title,
                hidden=title,
                manoeuvre=test.words.rpartition(",")[0],
                measure=item.title,
                truth=item.value,
                band=many.interval(item.name),
            )
            for item in test.measures
        ]
    return rows


def narrower(rows: Sequence[Foretold]) -> str:
    """Median of the widths over those before."""
    ratios = [(x.band[1] - x.band[0]) / (x.before[1] - x.before[0]) for x in rows]
    return f"{median(ratios):.2f}"


def shares(
    rows: Sequence[Foretold], values: Sequence[Foretold], ships: Mapping[tuple[str, str], float]
) -> str:
    """By card, by measure and by ship."""
    by_card = [
        [
            what,
            *(share([x for x in rows if x.hidden == what and (x.manoeuvre == "stopping") is s])
              for s in (False, True)),
            narrower([x for x in rows if x.hidden == what]),
            share(own := [x for x in values if x.hidden == what]),
            narrower(own),
        ]
        for what in CARDS
    ]  # fmt: skip
    measures = dict.fromkeys((x.manoeuvre, x.measure) for x in rows)
    by_measure = [
        [f"{words}: {measure}", share(own), narrower(own)]
        for words, measure in measures
        for own in [[x for x in rows if (x.manoeuvre, x.measure) == (words, measure)]]
    ]
    by_ship = [
        [
            name,
            *(
                f"{sum(x.held for x in own)} of {len(own)}"
                + (f", widened {ships[name, what]:.2g}" if ships[name, what] > 1.0 else "")
                for what in CARDS
                for own in [[x for x in rows if (x.ship, x.hidden) == (name, what)]]
            ),
        ]
        for name in SHIPS
    ]
    return "\n\n".join(
        [
            table(
                [
                    "on the card",
                    "others hold",
                    "stops hold",
                    "width over before",
                    "derivatives and values hold",
                    "width over before",
                ],
                by_card,
            ),
            table(["measure", "hold", "width over before"], by_measure),
            table(["ship", *CARDS], by_ship),
        ]
    )


def measured(rows: Sequence[Foretold]) -> str:
    """Published trials, a row a measure."""
    lines = [
        [
            x.ship,
            f"{x.manoeuvre}: {x.measure}",
            f"{x.truth:.3g}",
            f"{x.band[0]:.3g} to {x.band[1]:.3g}" if x.held
            else f"**{x.band[0]:.3g} to {x.band[1]:.3g}**",
        ]
        for x in rows
    ]  # fmt: skip
    head = ["trial and card", "foretold", "measured", "95 % interval"]
    return f"{table(head, lines)}\n\n{share(list(rows))} hold; bold does not."


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--ships", type=int, default=200)
    parser.add_argument("--write", action="store_true", help="put the tables into docs/card.md")
    args = parser.parse_args()
    rows: list[Foretold] = []
    values: list[Foretold] = []
    widened: dict[tuple[str, str], float] = {}
    seconds = []
    for what in CARDS:
        for name in SHIPS:
            start = time.process_time()
            widened[name, what], found, own = rows_of(name, what, args.ships)
            seconds.append(time.process_time() - start)
            rows += found
            values += own
    sailed = [row for trial in trials() for row in trial_rows(*trial, args.ships)]
    print(shares(rows, values, widened), measured(sailed), sep="\n\n")
    print(f"\n{share(rows)}; {median(seconds):.1f} s a ship, {max(seconds):.1f} s at most")
    if args.write:
        made = {
            "ships from cards": lambda: shares(rows, values, widened),
            "trials from cards": lambda: measured(sailed),
        }
        write_text(DOCS / "card.md", page("card.md", made))


if __name__ == "__main__":
    main()
