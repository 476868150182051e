"""Do the bands of estimates hold? Each ship of the library is predicted from what others say of it.

    python -m scripts.studies.leave_one_ship_out [--ships 500] [--write]

Of each ship is hidden in turn what was measured of propeller and rudder, of the hull, and of all.
The truth is the turn and the zigzags of the ship's own model, or what was measured at sea and in a
tank; the prediction has the 95 % band of so many ships drawn from the uncertainty of its estimates.
That is taken twice: as the package states it, in which the ship itself has a say, and found anew
from the other ships alone. --write puts the table into docs/estimates.md.
"""

from __future__ import annotations

import argparse
import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cache
from typing import Final

import numpy as np
from scipy import stats

import pmmkit as pk
from pmmkit.conventions import Ship
from pmmkit.files import write_text
from pmmkit.models import Model, converted, estimate, estimated_model, hull_table
from pmmkit.models.empirical import METHODS, StandardError
from pmmkit.models.particulars import (
    DRAWN,
    PROPELLER_ERRORS,
    RUDDER_ERRORS,
    WAKE_GROWTH,
    parts_from_particulars,
    propeller_diameter,
    rudder_area,
)
from scripts.documentation.fences import DOCS, page, table
from scripts.studies.bulk_carrier import NAME, TRIAL, TURNS
from scripts.validation.measurements import HSVA, kept

METHOD: Final = "yoshimura-masumoto"
SCREW, BLADE = "propeller", "rudder_mmg"
SOURCES: Final = {
    "KVLCC2": "kvlcc2",
    "KCS": "kcs",
    "S175": "s175-3dof",
    "Esso Osaka": "esso-osaka-3m",
}
"""The ships that the standard errors come from, and who has them."""
SPEEDS: Final = {
    "s175": ("S175", 9.0),
    "s175-3dof": ("S175", 9.0),
    "kvlcc2": ("KVLCC2", 7.97),
    "kvlcc2-l7": ("KVLCC2", 1.18),
    "kcs": ("KCS", 12.35),
    "esso-osaka-3m": ("Esso Osaka", 0.52),
    "mariner": ("Mariner", 7.7175),
    "esso190k": ("Esso 190 000 dwt", 8.23),
}
"""Models of the library, whose they are, and their approach [m/s]."""
SYMMETRIC: Final = ("s175", "s175-3dof")
"""To port they do as to starboard, which counts once."""
PARTS, DRAWN_PARTS, HULL, ALL = (
    "propeller and rudder",
    "the same, size stated",
    "hull",
    "all, size stated",
)
NOTHING_STATED: Final = "all"
SIDES: Final = ("gamma_positive", "gamma_negative", "C2_positive", "C2_negative")
"""Behind a propeller that turns the other way these are exchanged: the worse side counts."""
CROSS: Final = 0.4
"""Cross flow at the propeller of a 35° turn, v' + xp r'."""
MEASURES: Final = {
    "turning": {
        "tactical_diameter_L": "tactical diameter",
        "advance_L": "advance",
        "transfer_L": "transfer",
    },
    "zigzag": {"overshoot_1_deg": "first overshoot", "overshoot_2_deg": "second overshoot"},
}
MANOEUVRES: Final = (("turning", 35), ("zigzag", 10), ("zigzag", 20))
TWICE: Final = (
    *(f"{SCREW}.{name}" for name in ("t", "wp")),
    *(f"{BLADE}.{name}" for name in ("epsilon", "kappa", "gamma_positive", "gamma_negative")),
    *(f"{BLADE}.{name}" for name in ("tR", "aH")),
)
"""What two laboratories measured of KVLCC2; the xH of one contradicts itself."""
HSVA_SPEED: Final = 1.18
RULES: Final[Mapping[str, Callable[[int], float]]] = {
    "deviation alone": lambda _: 1.0,
    "next ship, as in the package": lambda n: math.sqrt(1.0 + 1.0 / n),
    "Student": lambda n: float(stats.t.ppf(0.975, n) / stats.norm.ppf(0.975)),
}
"""What the deviation of n ships is multiplied by for one more."""


@dataclass(frozen=True, kw_only=True)
class Row:
    """One figure of a ship beside its band."""

    ship: str
    hidden: str
    manoeuvre: str
    measure: str
    side: str
    truth: float
    band: tuple[float, float]

    @property
    def held(self) -> bool:
        """Whether the band holds the truth."""
        return self.band[0] <= self.truth <= self.band[1]


@cache
def deviations() -> Mapping[str, Mapping[str, tuple[float, float]]]:
    """What is estimated and what was measured, by place and by ship."""
    found: dict[str, dict[str, tuple[float, float]]] = {}
    for ship, name in SOURCES.items():
        model = pk.load_model(name)
        own = {SCREW: dict(model.values(SCREW)), BLADE: dict(model.values(BLADE))}
        if ship in WAKE_GROWTH.ships and "C2_positive" not in own[SCREW]:
            grown = own[SCREW]["tau"] * CROSS**2 / (1.0 - own[SCREW]["wp"])
            growth = 1.0 + grown / (1.0 - math.exp(-2.0 * CROSS))
            own[SCREW] |= {"C2_positive": growth, "C2_negative": growth}
        drawn = parts_from_particulars(
            model.ship, {"D": own[SCREW]["D"]}, {"area": own[BLADE]["area"]}
        )
        guess = {part.effect: dict(part.values) for part in drawn}
        guess[SCREW]["D"] = propeller_diameter(model.ship)
        guess[BLADE]["area"] = rudder_area(model.ship)
        for effect, errors in ((SCREW, PROPELLER_ERRORS), (BLADE, RUDDER_ERRORS)):
            for value, error in errors.items():
                if ship in error.ships:
                    pair = guess[effect][value], own[effect][value]
                    found.setdefault(f"{effect}.{value}", {})[ship] = pair
        if name != "esso-osaka-3m":
            method = METHODS[METHOD]
            there = converted(hull_table(name), method.convention).at()
            for value, x in estimate(model.ship, METHOD).values.items():
                if ship in method.error_of(value).ships and value in there:
                    found.setdefault(value, {})[ship] = x, float(there[value])
    return found


def stated() -> dict[str, StandardError]:
    """What the package states, by place."""
    return {
        **METHODS[METHOD].errors,
        **{f"{SCREW}.{name}": error for name, error in PROPELLER_ERRORS.items()},
        **{f"{BLADE}.{name}": error for name, error in RUDDER_ERRORS.items()},
    }


def of_others(place: str, error: StandardError, ship: str = "") -> StandardError:
    """The deviation of a value found anew, without a ship."""
    effect, _, name = place.rpartition(".")
    base, _, _ = name.rpartition("_")
    both = [f"{effect}.{base}_{x}" for x in ("positive", "negative")] if name in SIDES else [place]
    ships = tuple(x for x in error.ships if x != ship)
    sizes = []
    for one in both:
        pairs = [deviations()[one][x] for x in ships]
        over = [abs(own - guess) / (abs(guess) if error.share else 1.0) for guess, own in pairs]
        sizes.append(float(np.sqrt(np.mean(np.square(over)))))
    size = max(sizes)
    return replace(error, ships=ships, **{"share" if error.share else "number": size})


def errors_without(ship: str) -> dict[str, StandardError]:
    """Standard errors in which a ship has no say; an assumed one stays."""
    return {
        place: of_others(place, error, ship) if ship in error.ships else error
        for place, error in stated().items()
    }


def with_errors(
    model: Model, errors: Mapping[str, StandardError], rule: Callable[[int], float]
) -> Model:
    """A model whose estimates have other standard errors."""

    def size(place: str, value: float, known: float) -> float:
        error = errors.get(place)
        if error is None or not error.ships:
            return known
        return rule(len(error.ships)) * error.of(value) / error.widened

    parts = {
        name: replace(
            part,
            std={
                own: size(f"{name}.{own}", float(part.values[own]), x)
                for own, x in part.std.items()
            },
        )
        for name, part in model.parts.items()
    }
    made = replace(model, parts=parts)
    if made.covariance is None:
        return made
    held = {name: float(x) for part in made.parts.values() for name, x in part.values.items()}
    known = np.sqrt(np.diagonal(made.covariance))
    std = [size(own, held[own], x) for own, x in zip(made.covariance_names, known, strict=True)]
    return replace(made, covariance=np.diag(np.square(std)))


def hidden(name: str, what: str) -> Model:
    """A model of the library with a part of it estimated from particulars."""
    model, speed = pk.load_model(name), SPEEDS[name][1]
    rate = next(x.values["rate_deg_s"] for x in model.parts.values() if "rate_deg_s" in x.values)
    own = {effect: dict(model.values(effect)) for effect in (SCREW, BLADE) if effect in model.parts}
    sized = what in (DRAWN_PARTS, ALL)
    parts = parts_from_particulars(
        model.ship,
        {"D": own[SCREW]["D"]} if sized else {},
        {"rate_deg_s": rate} | ({"area": own[BLADE]["area"]} if sized else {}),
    )
    lent = {part.effect: part for part in parts}
    if what in (PARTS, DRAWN_PARTS):
        return model.with_(parts={**model.parts, **lent})
    if what == HULL:
        lent = {effect: model.parts[effect] for effect in (SCREW, BLADE)}
    return whole(model.ship, speed, lent, model.water)


def whole(ship: Ship, speed: float, parts: Mapping[str, object], water: pk.Water) -> Model:
    """A ship whose hull is estimated, with propeller and rudder as given."""
    made = estimated_model(
        ship,
        METHOD,
        speed=speed,
        propeller_diameter=propeller_diameter(ship),
        rudder_area=rudder_area(ship),
        water=water,
    )
    return made.with_(parts={**made.parts, **parts})


def cases() -> list[tuple[str, str]]:
    """Which ship is judged with what of it hidden; where forms differ, only all of it can be."""
    return [
        (name, what)
        for name in SPEEDS
        for what in (
            (PARTS, DRAWN_PARTS, HULL, ALL) if SPEEDS[name][0] in SOURCES else (NOTHING_STATED,)
        )
    ]


@cache
def truth(name: str, kind: str, rudder: int) -> Mapping[str, float]:
    """What the ship's own model does."""
    return dict(pk.simulate(name, kind, speed=SPEEDS[name][1], **angles(kind, rudder)).metrics)


def angles(kind: str, rudder: int, switch: int = 0) -> dict[str, int]:
    """The settings of a manoeuvre; a zigzag is turned over at the angle of its rudder."""
    turned = {"switch_deg": switch or abs(rudder)} if kind == "zigzag" else {}
    return {"rudder_deg": rudder, **turned}


def bands(
    model: Model, kind: str, speed: float, settings: Mapping[str, int], ships: int
) -> dict[str, tuple[float, float]]:
    """The 95 % bands of what is judged in a manoeuvre."""
    many = pk.monte_carlo(model, kind, speed=speed, n=ships, executor=1, **settings)
    return {name: many.interval(name) for name in MEASURES[kind]}


def rows_of(name: str, what: str, ships: int, rule: Callable[[int], float] | None) -> list[Row]:
    """All figures of a ship with something hidden."""
    who, speed = SPEEDS[name]
    model = hidden(name, what)
    if rule is not None:
        model = with_errors(model, errors_without(who), rule)
    rows = []
    for kind, angle in MANOEUVRES:
        for side in ("starboard",) if name in SYMMETRIC else ("starboard", "port"):
            rudder = angle if side == "starboard" else -angle
            found = bands(model, kind, speed, angles(kind, rudder), ships)
            rows += [
                Row(
                    ship=name,
                    hidden=what,
                    manoeuvre=f"{angle}/{angle}" if kind == "zigzag" else f"{angle}°",
                    measure=measure,
                    side=side,
                    truth=truth(name, kind, rudder)[measure],
                    band=found[measure],
                )
                for measure in MEASURES[kind]
            ]
    return rows


def measured(ships: int, rule: Callable[[int], float] | None) -> list[Row]:
    """Turns of a bulk carrier at sea, and HSVA's zigzags with a model of KVLCC2."""
    rows = []
    carrier = pk.load_model(NAME).ship
    parts = {part.effect: part for part in parts_from_particulars(carrier, {}, {})}
    model = whole(carrier, TRIAL, parts, pk.load_model(NAME).water)
    if rule is not None:
        model = with_errors(model, stated(), rule)
    for side in (35, -35):
        found = bands(model, "turning", TRIAL, angles("turning", side), ships)
        rows += [
            Row(
                ship="bulk carrier at sea",
                hidden=NOTHING_STATED,
                manoeuvre="35°",
                measure=measure,
                side="starboard" if side > 0 else "port",
                truth=TURNS[float(side), measure],
                band=found[measure],
            )
            for measure in MEASURES["turning"]
        ]
    tank = pk.load_model("kvlcc2-l7")
    drawn = parts_from_particulars(
        tank.ship,
        {"D": 0.204, "P_over_D": 0.808, "area_ratio": 0.448, "blades": 4},
        {"area_lateral": 0.0654, "rate_deg_s": 15.8},
    )
    model = whole(tank.ship, HSVA_SPEED, {part.effect: part for part in drawn}, tank.water)
    if rule is not None:
        model = with_errors(model, errors_without("KVLCC2"), rule)
    for (rudder, switch), angles_measured in HSVA.items():
        if switch != 10:
            continue
        found = bands(model, "zigzag", HSVA_SPEED, angles("zigzag", rudder, switch), ships)
        rows += [
            Row(
                ship="kvlcc2 of HSVA, in the tank",
                hidden=ALL,
                manoeuvre=f"{abs(rudder)}/{switch}",
                measure=measure,
                side="starboard" if rudder > 0 else "port",
                truth=angle,
                band=found[measure],
            )
            for measure, angle in zip(MEASURES["zigzag"], angles_measured, strict=False)
        ]
    return rows


def everything(ships: int, rule: Callable[[int], float] | None) -> list[Row]:
    """All figures of all ships, with the errors of the package or, by a rule, those of others."""
    own = [row for name, what in cases() for row in rows_of(name, what, ships, rule)]
    return [*own, *measured(ships, rule)]


def share(rows: Sequence[Row]) -> str:
    """How many bands hold, and the 95 % interval of their share if the figures were independent."""
    held, n = sum(row.held for row in rows), len(rows)
    known = stats.binomtest(held, n).proportion_ci(0.95, method="exact")
    return (
        f"{held} of {n}, {100 * held / n:.3g} % ({100 * known.low:.0f} to {100 * known.high:.0f})"
    )


def columns() -> list[tuple[str, str]]:
    """Manoeuvre and measure of each column of the table."""
    turn = [("35°", name) for name in MEASURES["turning"]]
    return [*turn, *((f"{x}/{x}", name) for x in (10, 20) for name in MEASURES["zigzag"])]


def cell(rows: list[Row]) -> str:
    """Truth and band to starboard; a miss in bold, one to port alone with an asterisk."""
    first = next(row for row in rows if row.side == "starboard")
    text = f"{first.truth:.3g}, {first.band[0]:.3g} to {first.band[1]:.3g}"
    if not first.held:
        return f"**{text}**"
    return text if all(row.held for row in rows) else f"{text} *"


def figures(rows: list[Row]) -> str:
    """Truth and band, a row per ship and what is hidden."""
    head = ["ship", "hidden", "held"]
    head += [
        f"{manoeuvre} {MEASURES['turning' if '°' in manoeuvre else 'zigzag'][name]}"
        for manoeuvre, name in columns()
    ]
    lines = []
    for ship, what in dict.fromkeys((row.ship, row.hidden) for row in rows):
        own = [row for row in rows if (row.ship, row.hidden) == (ship, what)]
        cells = []
        for manoeuvre, measure in columns():
            wanted = (manoeuvre, manoeuvre.replace("20/20", "20/10") if "HSVA" in ship else "")
            there = [row for row in own if row.manoeuvre in wanted and row.measure == measure]
            cells.append(cell(there) if there else "")
        lines.append([ship, what, f"{sum(row.held for row in own)} of {len(own)}", *cells])
    return table(head, lines)


def counts(found: Mapping[str, list[Row]]) -> str:
    """Bands that hold, by what was hidden and by how the standard errors were found."""
    first = next(iter(found.values()))
    groups = [
        *dict.fromkeys(row.hidden for row in first),
        "measured at sea or in a tank",
        "all figures",
    ]

    def chosen(rows: list[Row], group: str) -> list[Row]:
        if group == "all figures":
            return rows
        real = [row for row in rows if row.ship not in SPEEDS]
        if group not in {row.hidden for row in rows}:
            return real
        return [row for row in rows if row.hidden == group and row not in real]

    lines = [[group, *(share(chosen(rows, group)) for rows in found.values())] for group in groups]
    return table(["hidden", *found], lines)


def by_ship(found: Mapping[str, list[Row]]) -> str:
    """Bands that hold, by ship."""
    first = next(iter(found.values()))
    lines = [
        [ship, *(share([row for row in rows if row.ship == ship]) for rows in found.values())]
        for ship in dict.fromkeys(row.ship for row in first)
    ]
    return table(["ship", *found], lines)


def ratio(apart: Mapping[str, list[float]]) -> float:
    """Root mean square of how far values lie apart, over the deviation that ships have."""
    errors = stated()
    return math.sqrt(
        np.mean(
            [
                np.mean(np.square(sizes)) / of_others(place, errors[place]).share ** 2
                for place, sizes in apart.items()
            ]
        )
    )


def lent() -> dict[str, float]:
    """How far a value of the same ship from another laboratory, and that of a similar ship, lies
    off, over the deviation of ships from a formula."""
    two = pk.load_model("kvlcc2-l7")
    elsewhere = {
        place: [kept("hmri")()[name] / float(two.values(effect)[name]) - 1.0]
        for place in TWICE
        for effect, _, name in [place.partition(".")]
    }
    others: dict[str, list[float]] = {}
    drawn: dict[str, list[float]] = {}
    for one, other in (("kvlcc2", "esso-osaka-3m"), ("kcs", "s175-3dof")):
        pair = pk.load_model(one), pk.scaled(pk.load_model(other), pk.load_model(one).ship.L)
        for effect, errors in ((SCREW, PROPELLER_ERRORS), (BLADE, RUDDER_ERRORS)):
            mine, theirs = (model.values(effect) for model in pair)
            for name, error in errors.items():
                ships = {SPEEDS[one][0], SPEEDS[other][0]}
                if ships <= set(error.ships) and error.share and name in mine and name in theirs:
                    group = drawn if name in DRAWN else others
                    a, b = float(mine[name]), float(theirs[name])
                    group.setdefault(f"{effect}.{name}", []).extend((a / b - 1.0, b / a - 1.0))
    return {
        "the same ship in two laboratories": ratio(elsewhere),
        "similar ships": ratio(others),
        "similar ships, what is drawn": ratio(drawn),
    }


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--ships", type=int, default=500)
    parser.add_argument("--write", action="store_true", help="the table into docs/estimates.md")
    options = parser.parse_args()
    found = {"the package's own": everything(options.ships, None)}
    found |= {f"others', {name}": everything(options.ships, rule) for name, rule in RULES.items()}
    fair = found[f"others', {list(RULES)[1]}"]
    text = f"{counts(found)}\n\n{by_ship(found)}\n\n{figures(fair)}"
    print(text)
    for name, size in lent().items():
        print(f"{name}: {size:.2f} of the deviation of ships from the formulas apart")
    if options.write:
        made = page("estimates.md", {"leave one ship out": lambda: text})
        write_text(DOCS / "estimates.md", made)


if __name__ == "__main__":
    main()
