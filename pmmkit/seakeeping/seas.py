"""Seas: wave spectra with their moments, spreading over directions, and codes of sea states."""

from __future__ import annotations

import math
import tomllib
from dataclasses import dataclass
from functools import cache
from importlib.resources import files
from typing import Final

import numpy as np
from numpy.typing import ArrayLike

from pmmkit.base import DataError, UnknownNameError
from pmmkit.numerics import Array
from pmmkit.presentation import Described, Grid, Group, Section

FORMS: Final = ("ittc", "bretschneider", "pierson_moskowitz", "jonswap")
"""Forms of a spectrum by name."""
JONSWAP_GAMMA: Final = 3.3

_LOWEST: Final = 0.25  # over the peak: below it the spectrum is e^-320 of itself
_HIGHEST: Final = 20.0  # beyond it the tail in ω⁻⁵ is integrated in closed form
_WIDTHS: Final = (0.07, 0.09)
_WIND: Final = 2 * math.sqrt(8.1e-3 / 0.74)  # Hs = 4√m₀ over U²/g, and its peak at (.74·4/5)^¼ g/U


@dataclass(frozen=True, kw_only=True, repr=False)
class Sea(Described):
    """A sea that is stationary: its spectrum, and how it is spread over directions.

    Parameters
    ----------
    Hs : float
        Significant wave height 4√m₀ [m]; a height from trough to crest, not an amplitude.
    Tp : float
        Period of the peak [s].
    gamma : float
        Peakedness γ; 1 gives the form of Bretschneider, ITTC and Pierson-Moskowitz.
    spreading : int, optional
        The power 2n of cos²ⁿ by which energy is spread over ±90°; long-crested where absent.
    name : str
        For reports.

    Examples
    --------
    >>> rough = Sea(Hs=4.0, Tp=9.7)
    >>> rough
    <Sea Hs 4 m, Tp 9.7 s, long-crested>
    >>> round(4 * rough.moment(0) ** 0.5, 6)
    4.0
    """

    Hs: float
    Tp: float
    gamma: float = 1.0
    spreading: int | None = None
    name: str = ""

    def __post_init__(self) -> None:
        wrong = [
            f"{name} = {value:g} must be {'0 or more' if name == 'Hs' else 'positive'} and finite."
            for name, value in (("Hs", self.Hs), ("Tp", self.Tp), ("gamma", self.gamma))
            if not math.isfinite(value) or value < 0.0 or (value == 0.0 and name != "Hs")
        ]
        if self.spreading is not None and (self.spreading < 2 or self.spreading % 2):
            wrong.append(f"spreading = {self.spreading} must be an even power: 2, 4, ….")
        if wrong:
            raise DataError(wrong, title="Sea")

    @property
    def peak(self) -> float:
        """Circular frequency of the peak [rad/s]."""
        return 2 * math.pi / self.Tp

    def spectrum(self, omega: ArrayLike) -> Array:
        """Spectral density S(ω) of the elevation [m² s/rad], one-sided, ∫S dω = Hs²/16.

        Parameters
        ----------
        omega : array-like
            Circular frequency of the waves in a frame at rest [rad/s].
        """
        return self.Hs**2 * _unit(np.asarray(omega, dtype=float), self.peak, self.gamma)

    def moment(self, n: int) -> float:
        """m_n = ∫ ωⁿ S dω [m² (rad/s)ⁿ], the tail in ω⁻⁵ included; m₄ and beyond have no value."""
        if not 0 <= n < 4:
            raise DataError(f"The moment m{n} of a spectrum in ω⁻⁵ is infinite: ask for 0 to 3.")
        return self.Hs**2 * self.peak**n * _moment(n, self.gamma)

    def energy_above(self, omega: float) -> float:
        """∫S dω from a frequency on [m²], by the tail in ω⁻⁵ exp(-5/4 (ω_p/ω)⁴).

        Beyond 1.5 times the peak that is the whole spectrum, whatever its peakedness.

        Examples
        --------
        >>> rough = Sea(Hs=4.0, Tp=9.7)
        >>> [round(rough.energy_above(omega), 4) for omega in (0.0, 0.65, 2.0)]
        [1.0, 0.7085, 0.0137]
        """
        ratio = max(omega / self.peak, 0.1)
        tail = -0.2 * math.expm1(-1.25 * ratio**-4)
        return self.Hs**2 * tail / (16 * _area(self.gamma, 0))

    @property
    def T1(self) -> float:
        """Mean period 2π m₀/m₁ [s]."""
        return 2 * math.pi * self.moment(0) / self.moment(1)

    @property
    def Tz(self) -> float:
        """Mean period between upward zero crossings 2π √(m₀/m₂) [s]."""
        return 2 * math.pi * math.sqrt(self.moment(0) / self.moment(2))

    def directions(self, heading_deg: float, count: int = 13) -> tuple[Array, Array]:
        """Headings [deg] over which a short-crested sea is summed, and their weights (sum 1).

        Parameters
        ----------
        heading_deg : float
            Of the mean direction.
        count : int
            How many.

        Examples
        --------
        >>> headings, weights = Sea(Hs=2.0, Tp=8.0, spreading=2).directions(180.0, 5)
        >>> headings.round(), weights.round(3)
        (array([120., 150., 180., 210., 240.]), array([0.083, 0.25 , 0.333, 0.25 , 0.083]))
        """
        if self.spreading is None:
            return np.array([heading_deg]), np.ones(1)
        off = np.pi * (np.arange(1, count + 1) / (count + 1) - 0.5)
        weights = np.cos(off) ** self.spreading
        return heading_deg + np.degrees(off), weights / weights.sum()

    @property
    def words(self) -> str:
        """The sea in a line.

        Examples
        --------
        >>> Sea(Hs=4.0, Tp=9.7, name="rough").words
        'rough, Hs 4 m, Tp 9.7 s, long-crested'
        """
        crests = f"cos^{self.spreading}" if self.spreading else "long-crested"
        peaked = f", γ {self.gamma:.3g}" if self.gamma != 1.0 else ""
        named = f"{self.name}, " if self.name else ""
        return f"{named}Hs {self.Hs:.3g} m, Tp {self.Tp:.3g} s{peaked}, {crests}"

    def _headline(self) -> str:
        return self.words

    def _sections(self) -> list[Section]:
        rows = [
            ("significant wave height [m]", f"{self.Hs:.3g}"),
            ("peak period [s]", f"{self.Tp:.3g}"),
            ("mean period T1 [s]", f"{self.T1:.3g}"),
            ("zero-crossing period Tz [s]", f"{self.Tz:.3g}"),
            ("state of the sea (WMO)", f"{state_of(self.Hs).code}, {state_of(self.Hs).words}"),
        ]
        return [Section(tables=[Grid(head=["", "value"], groups=[Group(rows=rows)])])]


def _shape(ratio: Array, gamma: float) -> Array:
    """x⁻⁵ exp(-5/4 x⁻⁴) γ^r of the frequency over the peak."""
    bounded = np.maximum(ratio, 0.1)  # below, it is zero anyway
    plain = np.where(ratio > 0.1, bounded**-5 * np.exp(-1.25 * bounded**-4), 0.0)
    if gamma == 1.0:
        return plain
    width = np.where(ratio <= 1.0, *_WIDTHS)
    return np.asarray(plain * gamma ** np.exp(-((ratio - 1.0) ** 2) / (2 * width**2)))


def _unit(omega: Array, peak: float, gamma: float) -> Array:
    return _shape(omega / peak, gamma) / (16 * peak * _area(gamma, 0))


def _moment(n: int, gamma: float) -> float:
    return _area(gamma, n) / (16 * _area(gamma, 0))


@cache
def _area(gamma: float, n: int) -> float:
    """∫xⁿ x⁻⁵ exp(-5/4 x⁻⁴) γ^r dx: by Γ where γ is 1, else by Simpson and the tail."""
    if gamma == 1.0:
        return float(0.25 * 1.25 ** (n / 4 - 1) * math.gamma(1 - n / 4))
    from scipy.integrate import simpson

    ratio = np.geomspace(_LOWEST, _HIGHEST, 8001)
    inner = simpson(_shape(ratio, gamma) * ratio ** (n + 1), x=np.log(ratio))
    return float(inner) + _HIGHEST ** (n - 4) / (4 - n)


def sea(
    form: str = "bretschneider",
    *,
    Hs: float | None = None,
    Tp: float | None = None,
    T1: float | None = None,
    Tz: float | None = None,
    wind: float | None = None,
    gamma: float | None = None,
    spreading: int | None = None,
) -> Sea:
    """A sea by the name of its spectrum and what is known of it.

    Parameters
    ----------
    form : {"ittc", "bretschneider", "pierson_moskowitz", "jonswap"}
        ITTC's two parameters, Bretschneider's and Pierson and Moskowitz's are one form,
        A ω⁻⁵ exp(-B ω⁻⁴); the last has one parameter. ITTC writes A = 173 Hs²/T1⁴ and
        B = 691/T1⁴, rounded; here A and B are such that 4√m₀ = Hs and 2π m₀/m₁ = T1 exactly.
    Hs : float
        Significant wave height [m]; may be absent where `wind` is given.
    Tp, T1, Tz : float, optional
        One of them: period of the peak, mean period, zero-crossing period [s].
    wind : float, optional
        Wind speed at 19.5 m over a fully grown sea [m/s], for ``pierson_moskowitz``.
    gamma : float, optional
        Peakedness of ``jonswap``; 3.3 where absent.
    spreading : int, optional
        The power of the cosine by which energy is spread over ±90°.

    Returns
    -------
    Sea

    Raises
    ------
    UnknownNameError
        If there is no such form.
    DataError
        If too little or too much is given.

    Examples
    --------
    >>> sea("ittc", Hs=4.0, T1=8.0)
    <Sea ittc, Hs 4 m, Tp 10.4 s, long-crested>
    >>> sea("pierson_moskowitz", wind=15.0)
    <Sea pierson_moskowitz, Hs 4.8 m, Tp 11 s, long-crested>
    >>> round(sea("jonswap", Hs=3.0, Tz=7.0).Tp, 2)
    9.0
    """
    if form not in FORMS:
        raise UnknownNameError(f"There is no spectrum {form!r}. There are {', '.join(FORMS)}.")
    if form == "pierson_moskowitz":
        Hs, Tp = _fully_grown(Hs, wind, [Tp, T1, Tz])
    elif wind is not None:
        raise DataError("wind belongs to the form pierson_moskowitz; others need Hs and a period.")
    peaked = (JONSWAP_GAMMA if gamma is None else gamma) if form == "jonswap" else 1.0
    if form != "jonswap" and gamma not in (None, 1.0):
        raise DataError("gamma belongs to the form jonswap.")
    if Hs is None:
        raise DataError(f"A sea {form} needs Hs, the significant wave height [m].")
    periods = [x for x in (Tp, T1, Tz) if x is not None]
    if len(periods) != 1:
        raise DataError(f"A sea {form} needs one of Tp, T1, Tz [s]; {len(periods)} are given.")
    unit = Sea(Hs=1.0, Tp=1.0, gamma=peaked)
    peak = periods[0] / (1.0 if Tp is not None else unit.T1 if T1 is not None else unit.Tz)
    return Sea(Hs=Hs, Tp=peak, gamma=peaked, spreading=spreading, name=form)


def _fully_grown(
    Hs: float | None, wind: float | None, periods: list[float | None]
) -> tuple[float, float]:
    """Height and peak period of Pierson and Moskowitz's sea from one of height and wind."""
    if any(x is not None for x in periods) or (Hs is None) == (wind is None):
        raise DataError(
            "A sea pierson_moskowitz needs one of Hs [m] and wind [m/s] at 19.5 m, and no period; "
            "for a height and a period take the form bretschneider."
        )
    g = 9.81
    height = _WIND * (wind or 0.0) ** 2 / g if Hs is None else Hs
    speed = math.sqrt(height * g / _WIND)
    return height, 2 * math.pi * speed / (g * (0.74 * 0.8) ** 0.25)


@dataclass(frozen=True, kw_only=True)
class SeaState:
    """A code of the state of the sea.

    `code`: by WMO, 0 to 9. `lowest, highest`: significant wave height [m]. `period`: most
    probable peak period of the North Atlantic [s].
    """

    code: int
    words: str
    lowest: float
    highest: float
    period: float | None = None

    @property
    def sea(self) -> Sea:
        """A sea of the middle height with the most probable period.

        Examples
        --------
        >>> sea_states()[5].sea
        <Sea sea state 5, Hs 3.25 m, Tp 9.7 s, long-crested>
        """
        if self.period is None or not math.isfinite(self.highest):
            raise DataError(f"No period or no height is known for sea state {self.code}.")
        height = (self.lowest + self.highest) / 2
        return Sea(Hs=height, Tp=self.period, name=f"sea state {self.code}")


@cache
def sea_states() -> tuple[SeaState, ...]:
    """The states of the sea by code (WMO code table 3700)."""
    text = (files(__package__) / "sea_states.toml").read_text(encoding="utf-8")
    return tuple(SeaState(**entry) for entry in tomllib.loads(text)["states"])


def state_of(Hs: float) -> SeaState:
    """The state of a sea.

    Hs [m].

    Examples
    --------
    >>> state_of(3.0).words
    'rough'
    """
    return next(state for state in sea_states() if state.highest >= Hs)
