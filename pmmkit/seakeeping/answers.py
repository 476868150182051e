"""What a ship does in a sea, as results that tell themselves."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Final

from pmmkit.presentation import Cell, Described, Grid, Group, Section, number
from pmmkit.seakeeping.seas import Sea
from pmmkit.seakeeping.transfer import MODES

HOURS: Final = 3.0
"""Duration over which an extreme value is expected [h]."""
_NOTHING: Final = 1e-20  # of a motion that symmetry forbids, and rounding leaves
_ANGLES: Final = frozenset(MODES[3:])


@dataclass(frozen=True, kw_only=True)
class Moments:
    """Spectral moments of a response over frequencies of encounter.

    `m0, m2, m4`: ∫|H|²|ωₑ|ⁿ S dω, over the frequency of the waves [unit² (rad/s)ⁿ].
    """

    m0: float
    m2: float
    m4: float

    @property
    def significant(self) -> float:
        """Significant amplitude 2√m₀: the mean of the highest third of the amplitudes."""
        return 2 * math.sqrt(self.m0)

    @property
    def period(self) -> float:
        """Mean period between zero crossings 2π√(m₀/m₂) [s]."""
        return 2 * math.pi * math.sqrt(self.m0 / self.m2) if self.m2 > 0 else math.nan

    def extreme(self, hours: float = HOURS) -> float:
        """Most probable largest amplitude √(2 m₀ ln N) of N crossings in a duration [h]."""
        count = 3600 * hours / self.period
        return math.sqrt(2 * self.m0 * math.log(max(count, 1.0))) if self.m0 > 0 else 0.0

    def exceeded(self, level: float) -> float:
        """Probability that an amplitude is larger than a level (Rayleigh)."""
        return math.exp(-(level**2) / (2 * self.m0)) if self.m0 > 0 else 0.0


@dataclass(frozen=True, kw_only=True)
class Place:
    """A place on the ship at which motion matters.

    Parameters
    ----------
    name : str
        For reports.
    x, y, z : float
        Forward of midship, to port of the middle, above the water [m].
    freeboard : float, optional
        Height of the deck above still water [m]: for deck wetness.
    draught : float, optional
        Depth of the keel below still water [m]: for slamming.
    """

    name: str
    x: float
    y: float = 0.0
    z: float = 0.0
    freeboard: float | None = None
    draught: float | None = None


@dataclass(frozen=True, kw_only=True)
class AtPlace:
    """What is felt at a place.

    `vertical, acceleration, relative`: vertical motion [m], vertical acceleration [m/s²], and
    motion against the wave [m]. `incidence`: share of people that vomit within the exposure, by
    O'Hanlon and McCauley (1974) [%]. `dose`: motion sickness dose value of ISO 2631-1 over the
    exposure [m/s^1.5]. `dose_incidence`: km = 1/3 of the dose: share of people that vomit,
    unadapted adults [%]. `wet, slam`: probability that a wave wets the deck, and that the keel
    comes out and slams.
    """

    place: Place
    vertical: Moments
    acceleration: Moments
    relative: Moments
    incidence: float
    dose: float
    dose_incidence: float
    wet: float | None = None
    slam: float | None = None
    wet_per_hour: float | None = None
    slams_per_hour: float | None = None


@dataclass(frozen=True, kw_only=True, repr=False)
class Response(Described):
    """What a ship does in a sea, at one speed and heading.

    Parameters
    ----------
    ship : str
        Its name.
    sea : Sea
        The sea.
    speed : float
        [m/s].
    heading_deg : float
        180 is head sea [deg].
    motions : mapping of str to Moments
        Of each motion that is known at all frequencies [m, rad].
    places : tuple of AtPlace
        What is felt.
    hours : float
        Exposure of the motion sickness, and duration of extremes [h].
    notes : tuple of str
        Where it ends.
    """

    ship: str
    sea: Sea
    speed: float
    heading_deg: float
    motions: dict[str, Moments]
    places: tuple[AtPlace, ...] = ()
    hours: float = HOURS
    notes: tuple[str, ...] = field(default=())

    def _headline(self) -> str:
        return f"{self.ship} at {self.speed:.2f} m/s, {self.heading_deg:.0f}°: {self.sea.words}"

    def _sections(self) -> Sequence[Section]:
        head = ["", "significant", f"largest in {self.hours:g} h", "period [s]"]
        rows = []
        for name, found in self.motions.items():
            turn, unit = (180 / math.pi, "deg") if name in _ANGLES else (1.0, "m")
            rows.append([f"{name} [{unit}]", *_cells(found, self.hours, turn)])
        sections = [
            Section(
                title="Motions (amplitudes; the significant is 2√m₀)",
                tables=[Grid(head=head, groups=[Group(rows=rows)])],
            )
        ]
        for one in self.places:
            rows = [
                ["vertical motion [m]", *_cells(one.vertical, self.hours)],
                ["vertical acceleration [m/s²]", *_cells(one.acceleration, self.hours)],
                ["motion against the wave [m]", *_cells(one.relative, self.hours)],
            ]
            points = [
                f"Motion sickness in {self.hours:g} h: {one.incidence:.1f} % (O'Hanlon and "
                f"McCauley 1974), {one.dose_incidence:.1f} % (ISO 2631-1, dose {one.dose:.1f} "
                "m/s^1.5)."
            ]
            if one.wet is not None and one.wet_per_hour is not None:
                points.append(
                    f"Deck wet by {100 * one.wet:.2f} % of waves, {one.wet_per_hour:.2f} an hour."
                )
            if one.slam is not None and one.slams_per_hour is not None:
                points.append(
                    f"Slams at {100 * one.slam:.2f} % of waves, {one.slams_per_hour:.2f} an hour."
                )
            sections.append(
                Section(
                    title=f"At {one.place.name}, {one.place.x:g} m forward of midship",
                    points=points,
                    tables=[Grid(head=head, groups=[Group(rows=rows)])],
                )
            )
        if self.notes:
            sections.append(Section(title="Notes", points=self.notes))
        return sections

    def rows(self) -> list[dict[str, object]]:
        """One mapping for each value: where, what, significant, extreme, period [SI]."""
        found = [("ship", name, moments) for name, moments in self.motions.items()]
        for one in self.places:
            found += [
                (one.place.name, name, getattr(one, name))
                for name in ("vertical", "acceleration", "relative")
            ]
        return [
            {
                "speed": self.speed,
                "heading_deg": self.heading_deg,
                "place": place,
                "response": name,
                "significant": moments.significant,
                "extreme": moments.extreme(self.hours),
                "period": moments.period,
            }
            for place, name, moments in found
        ]


def _cells(found: Moments, hours: float, turn: float = 1.0) -> list[Cell]:
    if found.m0 < _NOTHING:
        return ["0", "0", None]
    return [
        number(turn * found.significant, 3),
        number(turn * found.extreme(hours), 3),
        f"{found.period:.1f}",
    ]
