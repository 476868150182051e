"""The card of a ship as a text file: her particulars and how she manoeuvres, read and written."""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from types import MappingProxyType
from typing import Any, ClassVar, Final

from pmmkit.base import DataError, Problem, did_you_mean
from pmmkit.campaigns import CampaignFile
from pmmkit.conventions import Metric, Ship, Water, unit_factor
from pmmkit.files import read_toml, refuse_other, toml_text
from pmmkit.imo import manoeuvre_words
from pmmkit.models import SECTIONS, Model, load_model, load_ship
from pmmkit.presentation import WIDE, Described, Grid, Group, Section, counted, number, plus_minus
from pmmkit.simulation import MANOEUVRES, simulate

POSTER: Final[tuple[tuple[str, Mapping[str, float], tuple[str, ...]], ...]] = (
    (
        "turning",
        {"rudder_deg": 35.0},
        ("advance_L", "transfer_L", "tactical_diameter_L", "steady_diameter_L", "speed_ratio"),
    ),
    ("initial_turning", {"rudder_deg": 10.0}, ("initial_turning_distance_L",)),
    ("zigzag", {"rudder_deg": 10.0, "switch_deg": 10.0}, ("overshoot_1_deg", "overshoot_2_deg")),
    ("zigzag", {"rudder_deg": 20.0, "switch_deg": 20.0}, ("overshoot_1_deg", "overshoot_2_deg")),
    ("stopping", {}, ("track_reach_L", "time_to_stop")),
)
"""What poster and card show, by A.601(15) and MSC.137(76): manoeuvre, settings, measures."""
SHIP_KEYS: Final = ("name", "L", "B", "d", "CB", "volume", "mass", "xG", "Izz")
SHIP_WORDS: Final = {
    "name": "of the ship",
    "CB": "block coefficient; or volume, or mass",
    "mass": "displacement [kg]: a tonne is 1000 kg",
    "xG": "centre of gravity forward of midship [m]; 0 if absent",
    "Izz": "inertia of yaw about midship [kg m²]; a radius of L/4 if absent",
}
"""What is said of them where the words of a campaign file are of a model under test."""
DERIVED: Final[Mapping[str, tuple[str, float, float]]] = MappingProxyType(
    {"steady_radius": ("steady_diameter", 2.0, 0.0), "speed_loss": ("speed_ratio", -1.0, 1.0)}
)
"""Other words for a measure: which, by what factor, and what is added."""
ORDERED: Final = (
    ("transfer_L", "tactical_diameter_L"),
    ("head_reach_L", "track_reach_L"),
    ("time_90", "time_180"),
)
"""Measures of one manoeuvre of which the first is less than the second, whatever the ship."""
POSSIBLE: Final[Mapping[str, tuple[float, float]]] = MappingProxyType(
    {
        "advance_L": (1.0, 12.0),
        "transfer_L": (0.05, 10.0),
        "tactical_diameter_L": (0.5, 20.0),
        "steady_diameter_L": (0.3, 20.0),
        "initial_turning_distance_L": (0.3, 8.0),
        "head_reach_L": (0.5, 40.0),
        "track_reach_L": (0.5, 40.0),
        "overshoot_{}_deg": (0.0, 90.0),
        "speed_ratio": (0.05, 1.0),
    }
)
"""Where ships lie, wide: twice the limits of MSC.137(76) and more. It catches a slip of unit."""
TOLERANCES: Final[Mapping[str, tuple[float, float]]] = MappingProxyType(
    {"m": (0.05, 0.0), "s": (0.05, 0.0), "deg": (0.1, 0.5), "-": (0.0, 0.05), "deg/s": (0.05, 0.0)}
)
"""Standard deviation where the card says none, by unit: a share of the value, and at least so much.
Of repeated tests by HSVA overshoots differ by 2 to 12 % (reference of KVLCC2 and KCS)."""
CABLES: Final = {"cable": 185.2, "cables": 185.2, "cbl": 185.2}
"""A tenth of a nautical mile [m]."""
UNKNOWN: Final = Ship(name="", L=math.nan, B=1.0, d=1.0, volume=1.0, mass=1.0, Izz=1.0)
"""Stands in where the particulars are wrong, so that all other problems are still found."""
_NUMBER: Final = r"[-+]?(?:\d+\.?\d*|\.\d+)"
_WRITTEN: Final = re.compile(
    rf"(?P<value>{_NUMBER})\s*(?:(?:±|\+/-|\+-)\s*(?P<half>{_NUMBER}))?\s*(?P<unit>[^\d\s,.;].*)?"
)


@dataclass(frozen=True, kw_only=True)
class CardMeasure:
    """A number on a card.

    `name`: as in ``metrics.json``, lengths in ship lengths. `value, std`: and its standard
    deviation [the unit of the metric, L of lengths].
    """

    name: str
    value: float
    std: float

    @property
    def title(self) -> str:
        """What it is, in words."""
        return Metric.in_words(self.name)

    @property
    def unit(self) -> str:
        """In which it is: ``L``, ``deg``, ``s`` or nothing."""
        unit = Metric.of(self.name).unit_of(self.name)
        return "" if unit == "-" else unit

    @property
    def interval(self) -> tuple[float, float]:
        """Of 95 %."""
        return self.value - WIDE * self.std, self.value + WIDE * self.std

    @property
    def written(self) -> str:
        """As the card has it, with half of the 95 % interval.

        Examples
        --------
        >>> CardMeasure(name="advance_L", value=3.1, std=0.155).written
        '3.10 ± 0.30 L'
        """
        return f"{plus_minus(self.value, WIDE * self.std)} {self.unit}".rstrip()


@dataclass(frozen=True, kw_only=True)
class CardTest:
    """A manoeuvre of a card.

    `manoeuvre, settings`: as `simulate` takes them. `speed`: of the approach [m/s].
    """

    manoeuvre: str
    settings: Mapping[str, float]
    speed: float
    measures: tuple[CardMeasure, ...] = ()

    @property
    def words(self) -> str:
        """The manoeuvre with its angles, its side and its speed.

        Examples
        --------
        >>> CardTest(manoeuvre="turning", settings={"rudder_deg": -35.0}, speed=8.0).words
        'turning 35°, to port, 8 m/s'
        """
        return self.told(math.nan)

    def told(self, usual: float) -> str:
        """The same, without the speed [m/s] if it is the usual one."""
        rudder = self.settings.get("rudder_deg", 0.0)
        words = manoeuvre_words(self.manoeuvre, rudder, self.settings.get("switch_deg"))
        return words if self.speed == usual else f"{words}, {self.speed:.3g} m/s"

    @property
    def ordered(self) -> dict[str, Any]:
        """Its settings for a simulation: a zigzag with as many orders as its measures need."""
        if self.manoeuvre != "zigzag":
            return dict(self.settings)
        metric = Metric.of("overshoot_1_deg")
        counts = [int(metric.count(item.name) or 1) for item in self.measures]
        return {"executes": max([2, *counts]) + 1, **self.settings}

    def same(self, other: CardTest) -> bool:
        """Whether the other is the same manoeuvre, whatever is measured of it."""
        one, two = (replace(item, measures=()) for item in (self, other))
        return one == two


@dataclass(frozen=True, kw_only=True, eq=False, repr=False)
class Card(Described):
    """A ship by her card: particulars, and manoeuvres as a wheelhouse poster shows them.

    Parameters
    ----------
    ship, water : Ship, Water
        Her particulars at the loading of the manoeuvres, and the water.
    speed : float
        Full sea speed, which is that of manoeuvres without one of their own [m/s].
    tests : tuple of CardTest
        Her manoeuvres with what is known of them.
    propeller, rudder : mapping
        As in a campaign file: ``D`` [m]; ``area`` [m²], ``rate_deg_s``.
    imo : mapping
        What the form of the IMO asks for besides.
    """

    FILE: ClassVar[str] = "card.toml"

    ship: Ship
    water: Water
    speed: float
    tests: tuple[CardTest, ...]
    propeller: Mapping[str, Any] = field(default_factory=lambda: MappingProxyType({}))
    rudder: Mapping[str, Any] = field(default_factory=lambda: MappingProxyType({}))
    imo: Mapping[str, Any] = field(default_factory=lambda: MappingProxyType({}))

    @classmethod
    def of(cls, model: Model | str | Path, speed: float, **settings: Any) -> Card:
        """The card of a model: what its poster would show.

        Parameters
        ----------
        model : Model, str or path
            A model, a library name or a file.
        speed : float
            Full sea speed [m/s].
        **settings
            As for `simulate`, such as ``extrapolate``.

        Examples
        --------
        >>> card = Card.of("kvlcc2", 7.97)
        >>> card.tests[0].words, card.tests[0].measures[0].written
        ('turning 35°, to starboard, 7.97 m/s', '2.98 ± 0.29 L')
        """
        loaded = model if isinstance(model, Model) else load_model(model)
        tests = []
        for test in poster(speed, loaded.steering.get("max_deg")):
            track = simulate(loaded, test.manoeuvre, speed=speed, **settings, **test.ordered)
            found = [
                CardMeasure(name=item.name, value=value, std=tolerance(item.name, value))
                for item in test.measures
                if math.isfinite(value := track.metrics.get(item.name, math.nan))
            ]
            if found:
                tests.append(replace(test, measures=tuple(found)))
        screw, blade = (
            next((x.values for name, x in loaded.parts.items() if word in name), {})
            for word in ("propeller", "rudder")
        )
        return cls(
            ship=loaded.ship,
            water=loaded.water,
            speed=speed,
            tests=tuple(tests),
            propeller={name: screw[name] for name in ("D",) if name in screw},
            rudder={name: blade[name] for name in ("area", "rate_deg_s") if name in blade},
        )

    def text(self) -> str:
        """The card as a file that `read_card` reads."""
        ship = {"name": self.ship.name, "L": self.ship.L, "B": self.ship.B, "d": self.ship.d}
        ship |= {"volume": self.ship.volume, "mass": self.ship.mass}
        ship |= {"xG": self.ship.xG, "Izz": self.ship.Izz}
        tables: dict[str, Any] = {
            "card": {"speed": f"{self.speed:.6g} m/s"},
            "ship": ship,
            "water": {"rho": self.water.rho, "g": self.water.g},
        }
        stated = {"propeller": self.propeller, "rudder": self.rudder, "imo": self.imo}
        tables |= {name: dict(own) for name, own in stated.items() if own}
        for test in self.tests:
            rudder = test.settings.get("rudder_deg", 0.0)
            entry: dict[str, Any] = {}
            if test.speed != self.speed:
                entry["speed"] = f"{test.speed:.6g} m/s"
            entry |= test.settings
            if rudder:
                entry |= {"rudder_deg": abs(rudder), "side": "port" if rudder < 0 else "starboard"}
            for item in test.measures:
                entry[item.name.removesuffix(Metric.IN_LENGTHS)] = item.written
            tables.setdefault(test.manoeuvre, []).append(entry)
        return toml_text(tables)

    def __len__(self) -> int:
        """How many measures it has."""
        return sum(len(test.measures) for test in self.tests)

    def _headline(self) -> str:
        return f"{self.ship.name}: {counted(len(self), 'measure')}, {self.speed:.3g} m/s"

    def _sections(self) -> Sequence[Section]:
        groups = [
            Group(
                title=test.told(self.speed),
                rows=[[f"  {x.title}", x.written] for x in test.measures],
            )
            for test in self.tests
        ]
        told = Grid(head=["", "card"], groups=groups, caption="± is half of the 95 % interval")
        return [Section(paragraphs=[self.ship.words]), Section(tables=[told])]


def poster(speed: float, largest: float | None = None) -> Iterator[CardTest]:
    """The manoeuvres that a card shows, with values to be filled in, to both sides.

    speed [m/s]; largest rudder [deg].
    """
    for name, settings, measures in POSTER:
        empty = tuple(CardMeasure(name=item, value=math.nan, std=math.nan) for item in measures)
        for side in (1.0, -1.0) if "rudder_deg" in settings else (0.0,):
            given = dict(settings)
            if side:
                given["rudder_deg"] = side * min(given["rudder_deg"], largest or math.inf)
            yield CardTest(manoeuvre=name, settings=given, speed=speed, measures=empty)


def tolerance(name: str, value: float) -> float:
    """Standard deviation of a measure of which nobody says how sure it is.

    Examples
    --------
    >>> tolerance("advance_L", 3.0), tolerance("overshoot_1_deg", 3.0)
    (0.15, 0.5)
    """
    share, least = TOLERANCES.get(Metric.of(name).unit, (0.05, 0.0))
    return max(round(share * abs(value), 12), least)


def empty_card() -> str:
    """An empty card to fill in, as text: what is left empty nobody knows.

    Examples
    --------
    >>> 'advance = ""' in empty_card()
    True
    """
    keys = CampaignFile.keys_of("ship")
    lines = [
        "# Card of a ship, after wheelhouse poster and pilot card of IMO resolution A.601(15).",
        '# Fill in what you know. What stays "" nobody knows. Then: pmmkit card fit card.toml',
        '# Lengths of manoeuvres need their unit: "640 m", "3.2 L" (ship lengths), "3.4 cables".',
        "# Angles are in degrees, times in seconds. How sure a value is, 95 of 100 times:",
        '# "3.2 ± 0.2 L", or "3.2 +- 0.2 L". If absent: 10 % of lengths and times, 20 % of angles.',
        "",
        "[card]",
        'speed = ""  # full sea speed in deep water, such as "15.5 kn", "8 m/s" or "Fn 0.14"',
        "",
        "[ship]  # as loaded in the manoeuvres; numbers, without quotes",
        *(f'{key} = ""  # {SHIP_WORDS.get(key) or keys[key].description}' for key in SHIP_KEYS),
        "",
        "[propeller]",
        'D = ""  # diameter [m]; also P_over_D, area_ratio, blades',
        "",
        "[rudder]",
        'area = ""  # of all rudders [m²]; also height [m]',
        'rate_deg_s = ""  # rate of the steering gear [deg/s]',
    ]
    for test in poster(1.0):
        rudder = test.settings.get("rudder_deg", 0.0)
        lines += ["", f"[[{test.manoeuvre}]]"]
        lines += [f"{name} = {abs(value):g}" for name, value in test.settings.items()]
        if rudder:
            lines.append(f'side = "{"port" if rudder < 0 else "starboard"}"')
        lines.append('speed = ""  # of the approach, if it is another')
        lines += [f'{item.name.removesuffix(Metric.IN_LENGTHS)} = ""' for item in test.measures]
        known = MANOEUVRES[test.manoeuvre]
        engine = [item for item in known.settings if known.reverses and item.name != "rudder_deg"]
        lines += [f'{item.name} = ""  # {item.text}' for item in engine]
    return "\n".join(lines) + "\n"


def read_card(path: str | Path) -> Card:
    """A card from its file.

    Parameters
    ----------
    path : str or path
        TOML, as `empty_card` gives it.

    Raises
    ------
    DataError
        With everything that is wrong in it, and what to write instead.

    Examples
    --------
    >>> import tempfile
    >>> file = Path(tempfile.mkdtemp()) / "card.toml"
    >>> _ = file.write_text(Card.of("kvlcc2", 7.97).text(), encoding="utf-8")
    >>> read_card(file)
    <Card KVLCC2: 22 measures, 7.97 m/s>
    """
    file = str(path)
    content = read_toml(path)
    refuse_other(content, None, file, DataError)
    reading = _Reading(file)
    card = reading.card({name: _filled(own) for name, own in content.items()})
    if reading.problems or card is None:
        raise DataError(reading.problems, title=f"{file} cannot be read")
    return card


def _filled(entry: Any) -> Any:
    """An entry without what was left empty."""
    if isinstance(entry, Mapping):
        return {name: own for name, own in entry.items() if own != ""}
    return [_filled(own) for own in entry] if isinstance(entry, list) else entry


class _Reading:
    """One file while it is read, with what is wrong in it."""

    def __init__(self, file: str) -> None:
        self.file = file
        self.problems: list[Problem] = []

    def wrong(self, entry: str, message: str, remedy: str | None = None) -> None:
        self.problems.append(Problem(message=message, file=self.file, entry=entry, remedy=remedy))

    def stated(self, table: str, raw: Any) -> dict[str, Any]:
        """What a table states whose keys are those of a campaign file."""
        try:
            return CampaignFile.stated(table, raw, self.file)
        except DataError as error:
            self.problems += error.problems
            return {}

    def card(self, content: Mapping[str, Any]) -> Card | None:
        known = ("card", "ship", "water", "propeller", "rudder", "imo", *MANOEUVRES)
        for name in content:
            if name not in known:
                self.wrong(f"[{name}]", f"is not known{did_you_mean(name, known) or '.'}")
        water = Water(**self.stated("water", content.get("water", {})))
        if water.depth is not None:
            self.wrong(
                "[water], key 'depth'",
                "the manoeuvres are taken for those of deep water.",
                "Leave out the depth, and manoeuvres in shallow water.",
            )
        ship = self.ship(content.get("ship", {}), water)
        for name in SECTIONS:
            for key, message in SECTIONS[name].problems(own) if (own := content.get(name)) else ():
                self.wrong(f"[{name}], key '{key}'", message)
        sailed = ship or UNKNOWN
        head = content.get("card", {})
        if "speed" not in head:
            self.wrong(
                "[card], key 'speed'", "is missing.", 'Write the full sea speed, such as "15.5 kn".'
            )
            return None
        speed = self.speed(head["speed"], "[card]", sailed, water)
        tests = [
            test
            for name, found in content.items()
            if name in MANOEUVRES
            for place, entry in enumerate(self.entries(name, found), start=1)
            if (test := self.test(name, entry, f"[[{name}]] {place}", speed, sailed, water))
        ]
        for place, one in enumerate(tests):
            if any(one.same(other) for other in tests[:place]):
                self.wrong(
                    f"[[{one.manoeuvre}]]",
                    f"{one.words} stands twice.",
                    "Put its measures into one table, or correct side, angle or speed.",
                )
        if not (tests or self.problems):
            self.wrong(
                "the card", "has no measure.", 'Write one at least, such as advance = "3.1 L".'
            )
        return (
            None
            if ship is None
            else Card(
                ship=ship,
                water=water,
                speed=speed,
                tests=tuple(tests),
                propeller=MappingProxyType(dict(content.get("propeller", {}))),
                rudder=MappingProxyType(dict(content.get("rudder", {}))),
                imo=MappingProxyType(self.stated("imo", content.get("imo", {}))),
            )
        )

    def entries(self, name: str, found: Any) -> Iterable[Mapping[str, Any]]:
        """The tables of a manoeuvre; one alone counts as a list of one."""
        several = found if isinstance(found, list) else [found]
        if all(isinstance(item, Mapping) for item in several):
            return several
        self.wrong(f"[[{name}]]", "must be a table.", f"Write [[{name}]] on a line of its own.")
        return ()

    def ship(self, raw: Any, water: Water) -> Ship | None:
        """Her particulars, those that a first look can do without filled in."""
        before = len(self.problems)
        own = self.stated("ship", raw)
        if len(self.problems) > before:
            return None
        if set(raw) == {"name"}:
            try:
                return load_ship(own["name"])
            except DataError:
                pass
        missing = [name for name in ("L", "B", "d") if name not in own]
        if not {"volume", "mass", "CB"} & set(own):
            missing.append("CB (or volume or mass)")
        if missing:
            self.wrong(
                "[ship]",
                f"{', '.join(missing)} {'is' if len(missing) == 1 else 'are'} missing.",
                "They stand in the pilot card: length between perpendiculars, breadth, mean "
                "draught [m], block coefficient or displacement.",
            )
            return None
        L, B, d = (float(own[name]) for name in ("L", "B", "d"))
        volume = own.get("volume") or (
            own["mass"] / water.rho if "mass" in own else own["CB"] * L * B * d
        )
        block = volume / (L * B * d)
        if not 0.3 <= block <= 0.95:
            self.wrong(
                "[ship]",
                f"the block coefficient would be {block:.3g}; ships have 0.4 to 0.9.",
                "Look at the units: m, m³, and kg of the mass (a tonne is 1000 kg).",
            )
        if not B < L < 12.0 * B or not d < B:
            self.wrong(
                "[ship]",
                f"L {L:g}, B {B:g}, d {d:g} m are no ship's.",
                "L is the longest and d the least; all are in metres.",
            )
        mass, xG = own.get("mass", water.rho * volume), own.get("xG", 0.0)
        return Ship(
            name=own.get("name") or "ship",
            L=L,
            B=B,
            d=d,
            volume=volume,
            mass=mass,
            Izz=own.get("Izz") or mass * ((0.25 * L) ** 2 + xG**2),
            xG=xG,
        )

    def speed(self, given: Any, entry: str, ship: Ship, water: Water) -> float:
        """A speed [m/s]: a number, or a text such as 15.5 kn or Fn 0.14."""
        text = str(given).strip()
        froude = text.lower().startswith("fn")
        found = _WRITTEN.fullmatch(text[2:].lstrip(" =") if froude else text)
        value = math.nan
        if found and not found["half"]:
            value = float(found["value"])
            if froude:
                value = ship.speed(value, water.g) if not found["unit"] else math.nan
            else:
                kind, factor = _unit(found["unit"] or "m/s")
                value = value * factor if kind == "m/s" else math.nan
        if froude and math.isnan(ship.L) and found:
            return math.nan
        if not value > 0.0:
            self.wrong(
                f"{entry}, key 'speed'",
                f"{given!r} is no speed.",
                'Write "15.5 kn", "8 m/s" or "Fn 0.14".',
            )
            return math.nan
        if ship.froude(value, water.g) > 1.0:
            self.wrong(
                f"{entry}, key 'speed'",
                f"{given!r} is Fn {ship.froude(value, water.g):.2g}.",
                "Look at its unit: a number alone is in m/s.",
            )
        return value

    def test(
        self,
        name: str,
        entry: Mapping[str, Any],
        where: str,
        speed: float,
        ship: Ship,
        water: Water,
    ) -> CardTest | None:
        """A manoeuvre; None where nothing of it is filled in."""
        known = MANOEUVRES[name]
        kinds = {item.name: item for item in known.settings}
        settings: dict[str, float] = {}
        measures: list[CardMeasure] = []
        pace, side = speed, None
        before = len(self.problems)
        for key, value in entry.items():
            where_it_is = f"{where}, key '{key}'"
            if key == "speed":
                pace = self.speed(value, where, ship, water)
            elif key == "side":
                side = value
            elif key in kinds:
                wrong = kinds[key].problem(value)
                if wrong:
                    self.wrong(where_it_is, wrong)
                else:
                    settings[key] = float(value)
            elif found := self.measure(name, key, value, where_it_is, ship):
                measures.append(found)
        if not measures:
            return None
        for key in ("rudder_deg", "switch_deg"):
            default = kinds[key].default if key in kinds else None
            if default:
                settings.setdefault(key, default)
        rudder = settings.get("rudder_deg", 0.0)
        if side is not None:
            if side not in ("port", "starboard"):
                self.wrong(f"{where}, key 'side'", f"{side!r} is port or starboard.")
            elif rudder < 0.0 and side == "starboard":
                self.wrong(
                    where,
                    f"a rudder of {rudder:g}° turns her to port, and the side is starboard.",
                    "Write the angle without its sign.",
                )
            else:
                settings["rudder_deg"] = -abs(rudder) if side == "port" else abs(rudder)
        if len(self.problems) == before:
            self.contradictions(measures, where)
        return CardTest(
            manoeuvre=name,
            settings=MappingProxyType(settings),
            speed=pace,
            measures=tuple(measures),
        )

    def measure(
        self, manoeuvre: str, key: str, given: Any, where: str, ship: Ship
    ) -> CardMeasure | None:
        """A measure of a manoeuvre, lengths in ship lengths."""
        bare, factor, added = DERIVED.get(key, (key.removesuffix(Metric.IN_LENGTHS), 1.0, 0.0))
        metrics = MANOEUVRES[manoeuvre].metrics
        metric = next((item for item in metrics if item.count(bare) is not None), None)
        if metric is None:
            names = [x.name.format(1) for x in metrics]
            words = [*names, "speed", "side", *(x.name for x in MANOEUVRES[manoeuvre].settings)]
            self.wrong(
                where,
                f"{manoeuvre} has no {key}{did_you_mean(key, words) or '.'} Its measures are "
                f"{', '.join(names)}.",
            )
            return None
        text = f"{given} L" if key.endswith(Metric.IN_LENGTHS) else str(given).strip()
        found = None if isinstance(given, bool) else _WRITTEN.fullmatch(text)
        if not found:
            remedy = 'Write such as "3.2 L", "640 ± 30 m" or 12.5, with a point for decimals.'
            self.wrong(where, f"{given!r} cannot be read.", remedy)
            return None
        value, half = float(found["value"]), float(found["half"] or math.nan)
        scale = self.scale(metric, found["unit"] or "", where, given, ship)
        if scale is None:
            return None
        name = bare + (Metric.IN_LENGTHS if metric.length else "")
        value = value * scale * factor + added
        low, high = POSSIBLE.get(name, POSSIBLE.get(metric.name, (-math.inf, math.inf)))
        if value < low or value > high:
            unit = metric.unit_of(name)
            self.wrong(
                where,
                f"{given!r} is {number(value, 3)} {unit}; ships have {low:g} to {high:g}.",
                "Look at its unit and its place on the card.",
            )
            return None
        std = abs(half * scale * factor) / WIDE if half > 0.0 else tolerance(name, value)
        return CardMeasure(name=name, value=value, std=std)

    def scale(self, metric: Metric, unit: str, where: str, given: Any, ship: Ship) -> float | None:
        """What takes a number to the unit of its metric, lengths to ship lengths."""
        unit = unit.strip()
        if metric.length:
            if unit in ("L", "Lpp", "ship lengths", "lengths"):
                return 1.0
            kind, factor = _unit(unit)
            if kind == "m" and unit:
                return factor / ship.L
            problem = "has no unit" if not unit else f"{unit!r} is no length"
            self.wrong(
                where,
                f"{given!r}: {problem}.",
                'Write "3.2 L" for ship lengths, "640 m" or "3.4 cables".',
            )
            return None
        if not unit:
            return 1.0
        kind, factor = _unit(unit)
        own, own_factor = _unit(metric.unit)
        if kind == own:
            return factor / own_factor
        self.wrong(
            where,
            f"{given!r}: {unit!r} is not its unit.",
            f"It is in {metric.unit}." if metric.unit != "-" else "It is a share, or in %.",
        )
        return None

    def contradictions(self, measures: Sequence[CardMeasure], where: str) -> None:
        """Measures of one manoeuvre that cannot be so for any ship."""
        there = {item.name: item for item in measures}
        if len(there) < len(measures):
            self.wrong(where, "a measure stands twice, in two words.", "Keep one of them.")
        for less, more in ORDERED:
            if less not in there or more not in there:
                continue
            one, two = there[less], there[more]
            if one.value - two.value > 2.0 * math.hypot(one.std, two.std):
                self.wrong(
                    where,
                    f"{one.title} {number(one.value, 3)} is more than {two.title} "
                    f"{number(two.value, 3)} {two.unit}: no ship does so.",
                    "Look at both on the card, and at their units.",
                )


def _unit(text: str) -> tuple[str, float]:
    """SI unit and the factor to it; none of what is no unit."""
    if text.lower() in CABLES:
        return "m", CABLES[text.lower()]
    try:
        return unit_factor(text)
    except DataError:
        return "?", math.nan
