"""Responses of a ship in a sea: significant and extreme values, comfort, wet decks, slamming."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Final

import numpy as np
from numpy.typing import ArrayLike

from pmmkit.numerics import Array
from pmmkit.presentation import Described, Grid, Group, Section, counted, number
from pmmkit.seakeeping.lengthwise import Complex
from pmmkit.seakeeping.seas import Sea
from pmmkit.seakeeping.transfer import MODES, Rao, between, nearest

# What a ship does in a sea, as results that tell themselves.


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


def _cells(found: Moments, hours: float, turn: float = 1.0) -> list[str | None]:
    if found.m0 < _NOTHING:
        return ["0", "0", None]
    return [
        number(turn * found.significant, 3),
        number(turn * found.extreme(hours), 3),
        f"{found.period:.1f}",
    ]


# Motion sickness: by O'Hanlon and McCauley, and by the dose of ISO 2631-1.


_KM: Final = 1 / 3  # share of unadapted adults that vomit [%] over the dose MSDV [m/s^1.5]
_HIGH_PASS: Final = (0.08, 1 / math.sqrt(2))  # f1 [Hz], Q1
_LOW_PASS: Final = (0.63, 1 / math.sqrt(2))  # f2
_TRANSITION: Final = (0.25, 0.86)  # f4, Q4; f3 is infinite
_STEP_UP: Final = (0.0625, 0.80, 0.1, 0.80)  # f5, Q5, f6, Q6


def dose_weight(omega: ArrayLike) -> Array:
    """The weighting Wf of ISO 2631-1 for motion sickness [-], largest about 0.17 Hz.

    omega [rad/s].

    Examples
    --------
    >>> dose_weight(2 * np.pi * np.array([0.02, 0.1, 0.16, 0.315, 0.63])).round(3)
    array([0.024, 0.695, 1.006, 0.619, 0.116])
    """
    s = 1j * np.abs(np.asarray(omega, dtype=float))

    def quadratic(f: float, Q: float) -> Array:
        w = 2 * math.pi * f
        return np.asarray(1 + s / (Q * w) + (s / w) ** 2)

    f1, Q1 = _HIGH_PASS
    high = (s / (2 * math.pi * f1)) ** 2 / quadratic(f1, Q1)
    low = 1 / quadratic(*_LOW_PASS)
    transition = 1 / quadratic(*_TRANSITION)
    f5, Q5, f6, Q6 = _STEP_UP
    step = quadratic(f5, Q5) / quadratic(f6, Q6) * (f5 / f6) ** 2
    return np.asarray(np.abs(high * low * transition * step))


def incidence_in_waves(m0: float, m2: float, hours: float, g: float = 9.81) -> float:
    """Motion sickness incidence [%] by O'Hanlon and McCauley (1974).

    Share of people that vomit at least once within an exposure to vertical acceleration; the time
    enters as McCauley et al. 1976 have it, by Φ(z_a) Φ(z_t).

    hours [h]; g [m/s²].

    Examples
    --------
    >>> round(incidence_in_waves(1.0, 1.1, 2.0), 1)
    32.8
    """
    if m0 <= 0.0:
        return 0.0
    from scipy.special import ndtr

    frequency = math.sqrt(m2 / m0) / (2 * math.pi)
    strength = math.sqrt(m0) / g
    octaves = math.log10(frequency)
    za = 2.128 * math.log10(strength) - 9.277 * octaves - 5.809 * octaves**2 - 1.851
    zt = 1.134 * za + 1.989 * math.log10(60 * hours) - 2.904
    return float(100 * ndtr(za) * ndtr(zt))


def moments(transfer: Complex, encounter: Array, omega: Array, sea: Sea) -> Moments:
    """Moments of a response in a long-crested sea, integrated over the frequency of the waves.

    In following seas several waves share a frequency of encounter, so that a spectrum over it is
    singular; its moments over ω are not.

    encounter, omega [rad/s].

    Examples
    --------
    >>> omega = np.linspace(0.2, 4.0, 400)
    >>> wave = moments(np.ones(400) + 0j, omega, omega, Sea(Hs=3.0, Tp=9.0))
    >>> round(2 * wave.significant, 2)
    3.0
    """
    energy = np.abs(transfer) ** 2 * sea.spectrum(omega)
    m0, m2, m4 = (float(np.trapezoid(energy * np.abs(encounter) ** n, omega)) for n in (0, 2, 4))
    return Moments(m0=m0, m2=m2, m4=m4)


def response(
    rao: Rao,
    sea: Sea,
    *,
    speed: float | None = None,
    heading_deg: float | None = None,
    places: Sequence[Place] = (),
    hours: float = HOURS,
) -> Response:
    """What a ship does in a sea.

    Parameters
    ----------
    rao : Rao
        Transfer functions; for a short-crested sea at headings around the one that is asked.
    sea : Sea
        The sea.
    speed, heading_deg : float, optional
        One of those of `rao` [m/s, deg]; may be absent where it has one.
    places : sequence of Place
        Where motions are felt.
    hours : float
        Exposure of the motion sickness, and duration of extremes [h].

    Returns
    -------
    Response

    Raises
    ------
    DataError
        If `rao` lacks the speed or a heading, or its frequencies leave out a part of the sea.
    """
    a = nearest(rao.speed, speed, "speed [m/s]")
    mean = np.degrees(rao.heading)
    b = nearest(mean, heading_deg, "heading_deg")
    headings, shares = sea.directions(float(mean[b]), 13)
    share = rao.share_of(sea)
    places_ = tuple(_at_place(rao, a, headings, shares, sea, place, hours) for place in places)
    found, absent = {}, []
    for mode in MODES:
        one = _summed(rao, rao.mode(mode)[a], a, headings, shares, sea)
        if math.isfinite(one.m0):
            found[mode] = one
        else:
            absent.append(mode)
    notes = [f"The frequencies hold {100 * share:.1f} % of the energy of the sea."]
    if absent:
        notes.append(
            f"{', '.join(absent)}: not known where waves meet the ship too slowly, so not given."
        )
    if rao.notes:
        notes.append(
            f"The motions have {counted(len(rao.notes), 'note')} of their own: print them."
        )
    return Response(
        ship=rao.name,
        sea=sea,
        speed=float(rao.speed[a]),
        heading_deg=float(mean[b]),
        motions=found,
        places=places_,
        hours=hours,
        notes=tuple(notes),
    )


def _summed(
    rao: Rao, transfer: Complex, speed: int, headings: Array, shares: Array, sea: Sea
) -> Moments:
    """Moments of a response (headings, frequencies), summed over the directions of the sea."""
    total = np.zeros(3)
    for heading, share in zip(headings, shares, strict=True):
        near, weight = between(rao.heading, float(heading))
        for b, part in zip(near, weight, strict=True):
            one = moments(transfer[b], rao.encounter[speed, b], rao.omega, sea)
            total += share * part * np.array([one.m0, one.m2, one.m4])
    return Moments(m0=float(total[0]), m2=float(total[1]), m4=float(total[2]))


def relative_motion(rao: Rao, place: Place) -> Complex:
    """Vertical motion of a place against the undisturbed wave, (speeds, headings, frequencies)."""
    forward = place.x - rao.x
    k, beta = rao.wavenumber, rao.heading[:, None]
    wave = np.exp(-1j * k * (forward * np.cos(beta) - place.y * np.sin(beta)))
    return np.asarray(rao.at_point(place.x, place.y, place.z)[2] - wave)


def _at_place(
    rao: Rao, a: int, headings: Array, shares: Array, sea: Sea, place: Place, hours: float
) -> AtPlace:
    up, against = rao.at_point(place.x, place.y, place.z)[2, a], relative_motion(rao, place)[a]

    def summed(transfer: Complex) -> Moments:
        return _summed(rao, transfer, a, headings, shares, sea)

    hard = -(rao.encounter[a] ** 2) * up
    felt, relative = summed(hard), summed(against)
    weighted = summed(hard * dose_weight(rao.encounter[a]))
    dose = math.sqrt(weighted.m0 * 3600 * hours)
    wet = slam = None
    if place.freeboard is not None:
        wet = relative.exceeded(place.freeboard)
    if place.draught is not None:
        # Ochi (1964): the keel comes out and enters faster than .093 √(gL)
        fast = 0.093 * math.sqrt(rao.g * rao.L)
        slam = relative.exceeded(place.draught) * math.exp(-(fast**2) / (2 * relative.m2))
    waves = 3600 / relative.period
    return AtPlace(
        place=place,
        vertical=summed(up),
        acceleration=felt,
        relative=relative,
        incidence=incidence_in_waves(felt.m0, felt.m2, hours, rao.g),
        dose=dose,
        dose_incidence=min(_KM * dose, 100.0),
        wet=wet,
        slam=slam,
        wet_per_hour=None if wet is None else wet * waves,
        slams_per_hour=None if slam is None else slam * waves,
    )
