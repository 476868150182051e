"""What a setting of a run declares: all that anybody asks of it."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Final

ANY: Final = ("any",)
"""Whatever swings."""
LAST: Final = 100
"""Place of a setting that declares none."""
Resolution = tuple[float, float]
SPEED: Final[Resolution] = (0.003, 0.001)
"""3 mm/s or 0.1 %, whichever is larger: what the ITTC (7.5-02-02-01) asks of a carriage. No
programme has two speeds so close."""
ANGLE: Final[Resolution] = (math.radians(0.1), 0.0)
"""0.1°: turntables and steering gears are read to that; programmes step by more than twice."""
LENGTH: Final[Resolution] = (0.001, 0.0)
"""1 mm: to what a crank or a strut is set."""
RATE: Final[Resolution] = (0.0, 0.005)
"""0.5 %: what a drive holds of its revolutions, of a period and of a rate of turn; programmes step
by a few per cent at least."""
SEA: Final[Resolution] = (0.0, 0.02)
"""2 %: to what a wave maker repeats a significant height."""


@dataclass(frozen=True, kw_only=True)
class Bounds:
    """Between what a number must lie, the ends left out or taken in."""

    above: float | None = None
    least: float | None = None
    below: float | None = None
    most: float | None = None
    zero: bool = True
    """Whether it may be zero."""


POSITIVE: Final = Bounds(above=0)
TURN: Final = Bounds(least=-180, most=180)
STEEP: Final = Bounds(above=-90, below=90)
SWING: Final = Bounds(above=0, below=90)
NOT_ZERO: Final = Bounds(zero=False)


@dataclass(frozen=True, kw_only=True)
class Told:
    """How people read a setting: ``symbol value unit``, or ``word value unit``.

    `symbol, word`: what stands before the number. `unit, form`: unit behind it, with its blank,
    and how the number is written. `shown`: property of `Settings` that is told instead; empty
    for the setting itself.
    """

    symbol: str
    word: str
    unit: str
    form: str
    shown: str = ""


@dataclass(frozen=True, kw_only=True)
class Sensor:
    """A column that measures a setting, and how far the two may be apart.

    Parameters
    ----------
    column : str
        Channel, or what `pmmkit.intake.checks.stated` makes of several.
    allowed : float
        By how much they may differ, SI.
    share : float
        The same over the setting, in addition.
    remedy : str
        What is said where they differ by more.
    """

    column: str
    allowed: float
    share: float = 0.0
    remedy: str = "One of them is wrong: look at its zero and its unit."


@dataclass(frozen=True, kw_only=True)
class RunSetting:
    """Something that a test is set to, or another way to state it.

    Parameters
    ----------
    name : str
        In Python, SI and radians; of another way to state a setting its key.
    key : str
        In files; the name where it is empty. In degrees it ends in ``_deg``.
    unit : str
        In files, where a column states none.
    meaning : str
        What the key means, for docs/formats.md.
    bounds : Bounds
        Between what it must lie in a file.
    kept : bool
        Whether it is kept as it is, and not only a way to state others.
    states : tuple of str
        Settings that it states in another way: a run that states one of them takes no other by
        default.
    of_swing : tuple of str
        The motions any of which must swing where it means anything: velocities, ``delta`` of the
        rudder, or ``any``.
    without : tuple of str
        Motions that must not swing.
    where_needed : bool
        Whether it means something only in tests that need it, or may take it.
    surroundings : bool
        Whether it is of the water and the sea, and not of the rig.
    place : int
        Place among all where settings are told and in tables.
    told : Told, optional
        How people read it; absent where it is told elsewhere.
    word, title : str
        What it is called, and at length; the word where that is empty.
    head : str
        Head of its column in a report; empty where it has none.
    zero_error : str
        What an error is called that all runs share, where it is one of the zero.
    stated_std : bool
        Whether its standard uncertainty can be stated.
    missing, asked : str
        What is said where it is missing, and what a draft asks for.
    resolution : (float, float), optional
        How far two values may differ and still be the same one: absolute (SI, radians), relative.
    in_names : tuple of (str, float)
        What may stand for it in the name of a file, a regular expression with ``#`` for the number,
        and the factor by which that becomes its unit.
    header : str
        Regular expression for the header of its column, in small letters.
    words : tuple of str
        Words of other languages for it.
    measured_by : str
        Channel that tells it where it is not stated.
    sensors : tuple of Sensor
        Columns that measure it.
    code : str
        Letters before its number in the name of a planned run.
    typical : float, optional
        A usual value, SI and radians, which contracts try.
    along : str
        Channel with which it changes its sign in other axes.
    """

    name: str
    key: str = ""
    unit: str
    meaning: str
    bounds: Bounds = Bounds()
    kept: bool = True
    states: tuple[str, ...] = ()
    of_swing: tuple[str, ...] = ()
    without: tuple[str, ...] = ()
    where_needed: bool = False
    surroundings: bool = False
    place: int = LAST
    told: Told | None = None
    word: str = ""
    title: str = ""
    head: str = ""
    zero_error: str = ""
    stated_std: bool = False
    missing: str = ""
    asked: str = ""
    resolution: Resolution | None = None
    in_names: tuple[tuple[str, float], ...] = ()
    header: str = ""
    words: tuple[str, ...] = ()
    measured_by: str = ""
    sensors: tuple[Sensor, ...] = ()
    code: str = ""
    typical: float | None = None
    along: str = ""

    @property
    def in_file(self) -> str:
        """Key of a campaign file."""
        return self.key or self.name

    @property
    def angle(self) -> bool:
        """Whether it is in degrees in files, and in radians inside."""
        return self.unit == "deg"

    @property
    def lack(self) -> str:
        """What is said where it is missing."""
        return self.missing or f"the {self.word}, {self.in_file}"

    @property
    def swings(self) -> bool:
        """Whether it is the amplitude of an oscillation."""
        return self.kept and bool(self.of_swing) and self.of_swing != ANY

    def to_si(self, value: float) -> float:
        """The number of a file inside."""
        return math.radians(value) if self.angle else value

    def to_file(self, value: float) -> float:
        """The number inside as a file has it."""
        return math.degrees(value) if self.angle else value
