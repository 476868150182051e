"""Derivatives, added mass, propeller and rudder values estimated from a ship's particulars.

Regressions over other ships: good for a first look, not for a verdict. Each value belongs to the
non-dimensional system and the conventions that its estimate states.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from types import MappingProxyType
from typing import Final

from pmmkit.base import UnknownNameError
from pmmkit.conventions import Convention, Ship, cite
from pmmkit.presentation import WIDE, listed


def criterion(values: Mapping[str, float], mass: float, xG: float) -> tuple[float, float]:
    """Levers of yaw and sway: a ship is stable if the first is larger (both over L)."""
    return ((values["Nr"] - mass * xG) / (values["Yr"] - mass), values["Nv"] / values["Yv"])


@dataclass(frozen=True, kw_only=True)
class StraightLine:
    """Straight-line stability of a bare hull by estimated derivatives, without its rudder.

    `lever_yaw, lever_sway`: points at which the forces of yaw and sway act, over L from
    midship; stable if that of yaw lies further forward. `C, std`: yv (Nr - m'xG) - Nv (Yr - m')
    in the prime system, positive where stable, and its standard uncertainty from those of the
    four derivatives.
    """

    lever_yaw: float
    lever_sway: float
    C: float
    std: float

    @property
    def verdict(self) -> str:
        """``stable``, ``unstable``; or ``not settled`` where the 95 % interval of C holds zero."""
        if abs(self.C) <= WIDE * self.std:
            return "not settled"
        return "stable" if self.C > 0.0 else "unstable"


@dataclass(frozen=True, kw_only=True)
class HullEstimate:
    """What a regression gives for a ship.

    Parameters
    ----------
    values : mapping of str to float
        Derivatives by name.
    std : mapping of str to float
        Standard uncertainty of each, by how far ships lie from the formula (`Method.error_of`).
    convention : Convention
        What they mean.
    source : str
        Author and year, and what of it was not checked against the text.
    sources : tuple of str
        The same as keys of the bibliography, that of the added mass last.
    notes : tuple of str
        Where the ship lies outside what the method was made from.
    grounds : mapping of str to str
        From what the uncertainty of each value was found.
    """

    values: Mapping[str, float]
    std: Mapping[str, float]
    convention: Convention
    source: str
    sources: tuple[str, ...]
    notes: tuple[str, ...] = ()
    grounds: Mapping[str, str] = field(default_factory=lambda: MappingProxyType({}))

    @classmethod
    def by_method(cls, ship: Ship) -> dict[str, HullEstimate]:
        """What each method gives for a ship, by the name of the method."""
        return {name: estimate(ship, name) for name in METHODS}

    def straight_line(self, ship: Ship) -> StraightLine:
        """The criterion of straight-line stability by the estimate.

        Parameters
        ----------
        ship : Ship
            Its volume and centre of gravity count.

        Examples
        --------
        >>> ship = Ship(name="b", L=175., B=25.4, d=8.5, volume=21222., mass=2.2e7, Izz=3.8e10)
        >>> told = estimate(ship, "clarke").straight_line(ship)
        >>> round(told.lever_yaw, 2), round(told.lever_sway, 2), told.verdict
        (0.44, 0.37, 'not settled')
        """
        over = 1.0 if self.convention.system == "prime" else ship.d / ship.L
        side = -1.0 if self.convention.sway == "beta" else 1.0
        signs = {"Yv": side, "Nv": side, "Yr": 1.0, "Nr": 1.0}
        x = {name: sign * over * self.values[name] for name, sign in signs.items()}
        mass, xG = 2.0 * ship.volume / ship.L**3, ship.xG / ship.L
        yaw, sway = criterion(x, mass, xG)
        side_force, moment = x["Yr"] - mass, x["Nr"] - mass * xG
        slopes = {"Yv": moment, "Nr": x["Yv"], "Nv": side_force, "Yr": x["Nv"]}
        parts = [slope * over * self.std[name] for name, slope in slopes.items()]
        return StraightLine(
            lever_yaw=yaw,
            lever_sway=sway,
            C=x["Yv"] * moment - x["Nv"] * side_force,
            std=math.hypot(*parts),
        )


_PRIME: Final = Convention(system="prime", coriolis="in-derivatives")
_MMG: Final = Convention(system="prime-d", surge="constant", coriolis="in-derivatives")
_BETA: Final = _MMG.with_(sway="beta")


def _slender(ship: Ship) -> tuple[float, float, float]:
    """π(d/L)², CB B/(π d) and L."""
    return math.pi * (ship.d / ship.L) ** 2, ship.block * ship.B / (math.pi * ship.d), ship.L


def wagner_smitt(ship: Ship) -> dict[str, float]:
    """Velocity derivatives of Wagner Smitt (1971), prime system."""
    S, _, _ = _slender(ship)
    return {"Yv": -1.59 * S, "Yr": 0.32 * S, "Nv": -0.62 * S, "Nr": -0.21 * S}


def norrbin(ship: Ship) -> dict[str, float]:
    """Velocity derivatives of Norrbin (1971), prime system."""
    S, x, _ = _slender(ship)
    return {
        "Yv": -S * (1.69 + 0.08 * x),
        "Yr": -S * (-0.645 + 0.38 * x),
        "Nv": -S * (0.64 - 0.04 * x),
        "Nr": -S * (0.47 - 0.18 * x),
    }


def inoue(ship: Ship) -> dict[str, float]:
    """Velocity derivatives of Inoue et al. (1981), prime system."""
    S, x, L = _slender(ship)
    return {
        "Yv": -S * (1.0 + 1.4 * x),
        "Yr": 0.5 * S,
        "Nv": -2.0 * S / math.pi,
        "Nr": -S * (1.04 / math.pi - 4.0 * ship.d / (math.pi * L)),
    }


def clarke(ship: Ship) -> dict[str, float]:
    """Velocity derivatives of Clarke, Gedling and Hine (1983), prime system.

    Examples
    --------
    >>> tanker = Ship(name="t", L=320., B=58., d=20.8, volume=.81*320*58*20.8, mass=1., Izz=1.)
    >>> round(clarke(tanker)["Yv"], 5)
    -0.02527
    """
    S, _, L = _slender(ship)
    B, d, CB = ship.B, ship.d, ship.block
    return {
        "Yv": -S * (1.0 + 0.4 * CB * B / d),
        "Yr": -S * (-0.5 + 2.2 * B / L - 0.08 * B / d),
        "Nv": -S * (0.5 + 2.4 * d / L),
        "Nr": -S * (0.25 + 0.039 * B / d - 0.56 * B / L),
    }


def clarke_accelerations(ship: Ship) -> dict[str, float]:
    """Acceleration derivatives of Clarke, Gedling and Hine (1983), prime system."""
    S, _, L = _slender(ship)
    B, d, CB = ship.B, ship.d, ship.block
    return {
        "Yvdot": -S * (1.0 + 0.16 * CB * B / d - 5.1 * (B / L) ** 2),
        "Yrdot": -S * (0.67 * B / L - 0.0033 * (B / d) ** 2),
        "Nvdot": -S * (1.1 * B / L - 0.041 * B / d),
        "Nrdot": -S * (1.0 / 12.0 + 0.017 * CB * B / d - 0.33 * B / L),
    }


def zhou_added_mass(ship: Ship) -> dict[str, float]:
    """Added mass of Zhou et al. (1983, Motora's charts) over ½ρL²d and ½ρL⁴d."""
    L, B, d, CB = ship.L, ship.B, ship.d, ship.block
    m = 2.0 * ship.volume / (L**2 * d)
    long = d * L / B**2
    my = m * (
        0.882
        - 0.54 * CB * (1.0 - 1.6 * d / B)
        - 0.156 * (1.0 - 0.673 * CB) * L / B
        + 0.826 * long * (1.0 - 0.678 * d / B)
        - 0.638 * CB * long * (1.0 - 0.669 * d / B)
    )
    arm = (33.0 - 76.85 * CB * (1.0 - 0.784 * CB) + 3.43 * L / B * (1.0 - 0.63 * CB)) / 100.0
    return {"Xudot": -0.05 * m, "Yvdot": -my, "Nrdot": -m * arm**2}


def kijima(ship: Ship) -> dict[str, float]:
    """Hull of Kijima et al. (1990), drift-angle form, over ½ρLd: quadratic in moduli.

    Nβrr as 0.5 d CB/B - 0.05; its sign differs between public copies.
    """
    L, B, d, CB = ship.L, ship.B, ship.d, ship.block
    k, c = 2.0 * d / L, CB * B / L
    m = 2.0 * ship.volume / (L**2 * d)
    slim, full = d * (1.0 - CB) / B, d * CB / B
    return {
        "Yv": 0.5 * math.pi * k + 1.4 * c,
        "Yr": m - 1.5 * c,
        "Yv|v|": 2.5 * slim + 0.5,
        "Yr|r|": 0.343 * full - 0.07,
        "Yvvr": 1.5 * full - 0.65,
        "Yvrr": 5.95 * slim,
        "Nv": k,
        "Nr": -0.54 * k + k**2,
        "Nv|v|": -0.96 * slim + 0.066,
        "Nr|r|": 0.5 * c - 0.09,
        "Nvvr": -(57.5 * c**2 - 18.4 * c + 1.6),
        "Nvrr": 0.5 * full - 0.05,
    }


def yoshimura_masumoto(ship: Ship) -> dict[str, float]:
    """Hull of Yoshimura and Masumoto (2012), over ½ρLd, for medium high-speed merchant ships.

    Notes
    -----
    Printed in the drift angle, with the added mass in the surge terms: X'βr - m'y =
    -1.91 CB B/L + 0.08, X'rr + x'G m'y = -0.085 CB B/L + 0.008, Y'βββ = 0.185 L/B + 0.48,
    N'βrr = 0.075 (1 - CB) L/B - 0.098. These totals, as a captive test measures them, stand here,
    with the sign of terms odd in β turned over. So reads a public program that was written from
    the Japanese edition (ship-ai-design-project), and two that keep β. Others turn the sign of
    the first part of Y'vvv and N'vrr alone and write X'vr as m'y - 1.91 CB B/L + 0.08, which
    KVLCC2 and KCS contradict. Made from ships with CB 0.51 to 0.65 and L/B 2.6 to 7.1: for a full
    ship the nonlinear terms are an extrapolation.

    Examples
    --------
    >>> from pmmkit.models.library import load_ship
    >>> values = yoshimura_masumoto(load_ship("kcs"))     # the library has 0.108 and -1.72
    >>> round(values["Xvr"], 3), round(values["Yvvv"], 2)
    (0.094, -1.8)
    """
    L, B, CB = ship.L, ship.B, ship.block
    k, c = 2.0 * ship.d / L, ship.block * B / L
    slim = (1.0 - CB) * L / B
    return {
        "Xvv": 1.15 * c - 0.18,
        "Xvr": 1.91 * c - 0.08,
        "Xrr": -0.085 * c + 0.008,
        "Xvvvv": -6.68 * c + 1.1,
        "Yv": -(0.5 * math.pi * k + 1.4 * c),
        "Yr": 0.5 * c,
        "Yvvv": -(0.185 * L / B + 0.48),
        "Yvvr": -0.75,
        "Yvrr": -(0.26 * slim + 0.11),
        "Yrrr": -0.051,
        "Nv": -k,
        "Nr": -0.54 * k + k**2,
        "Nvvv": -(-0.69 * CB + 0.66),
        "Nvvr": 1.55 * c - 0.76,
        "Nvrr": -(0.075 * slim - 0.098),
        "Nrrr": 0.25 * c - 0.056,
    }


def ratios(ship: Ship) -> dict[str, float]:
    """What the regressions depend on: CB, L/B and d/B."""
    return {"CB": ship.block, "L/B": ship.L / ship.B, "d/B": ship.d / ship.B}


LIBRARY: Final = ("KVLCC2", "KCS", "S175")
"""Ships of the library whose whole hull was measured."""


@dataclass(frozen=True)
class StandardError:
    """How far a ship may lie from a regression, by how far other ships do.

    `share`: root mean square of what the ships lie off, over the value. `number`: the same in
    the system of the method, where the value may be near zero. `ships`: the ships; empty where
    the size is assumed. `why`: on what ground it is assumed.

    Notes
    -----
    The next ship lies off by sqrt(1 + 1/n) of the deviation of n ships, the standard error of
    prediction of a new observation (any textbook of regression): so few ships say little of how
    far others lie. docs/estimates.md has what a study makes of that factor.

    Examples
    --------
    >>> round(StandardError(0.2).of(-2.0), 3), StandardError(0.2, ships=(), why="usual").of(-2.0)
    (0.462, 0.4)
    """

    share: float = 0.0
    number: float = 0.0
    ships: tuple[str, ...] = LIBRARY
    why: str = ""

    def of(self, value: float) -> float:
        """Standard deviation of a value."""
        return self.widened * max(self.share * abs(value), self.number)

    @property
    def widened(self) -> float:
        """By what a new ship lies further off than the ships do."""
        return math.sqrt(1.0 + 1.0 / len(self.ships)) if self.ships else 1.0

    @property
    def source(self) -> str:
        """What it was found from."""
        return f"{listed(self.ships)} of the library" if self.ships else f"assumed: {self.why}"

    @property
    def words(self) -> str:
        """The deviation of the ships, as a page tells it."""
        return f"{100 * self.share:.0f} %" if self.share else f"{self.number:g}"


@dataclass(frozen=True)
class EmpiricalMethod:
    """A regression over hulls, its added mass, and where both come from."""

    hull: Callable[[Ship], dict[str, float]]
    added_mass: Callable[[Ship], dict[str, float]]
    convention: Convention
    sources: tuple[str, str]
    """Keys of the bibliography, of the hull and of the added mass."""
    errors: Mapping[str, StandardError]
    """Of derivatives that library ships have; the others are `UNSEEN`."""
    remark: str = ""
    """What is to be said with the first of them."""
    made_from: tuple[tuple[str, float, float], ...] = ()
    """Ratios of `ratios`, least and largest among the ships behind it, where that is known."""

    def outside(self, ship: Ship) -> tuple[str, ...]:
        """Sentences on ratios of a ship that lie outside those the method was made from."""
        known = ratios(ship)
        return tuple(
            f"{name} {known[name]:.2f} lies outside {low:g} to {high:g}, from which it was made"
            for name, low, high in self.made_from
            if not low <= known[name] <= high
        )

    def error_of(self, name: str) -> StandardError:
        """How far ships lie from what the method gives for a derivative."""
        return self.errors.get(name, UNSEEN)


def shares(*ships: str, **of: float) -> dict[str, StandardError]:
    """Deviations of ships as shares of the values, by name."""
    return {name: StandardError(share, ships=ships or LIBRARY) for name, share in of.items()}


def _numbers(*ships: str, **numbers: float) -> dict[str, StandardError]:
    return {name: StandardError(number=x, ships=ships or LIBRARY) for name, x in numbers.items()}


UNSEEN: Final = StandardError(0.5, ships=(), why="no ship of the library has it")
_CLARKE: Final = "clarke_gedling_hine_1983"
_CLARKE_MASS: Final = shares(Yvdot=0.15, Nrdot=0.15) | shares("S175", Yrdot=0.3, Nvdot=0.3)
_ZHOU: Final = "zhou_1983"
_ZHOU_MASS: Final = shares(Xudot=0.45, Yvdot=0.05, Nrdot=0.1)
_SLENDER: Final = shares(Yv=0.2, Yr=0.15, Nv=0.2, Nr=0.1)
"""Linear terms of Kijima et al., which Yoshimura and Masumoto took over."""
_UNREAD: Final = ", as public programs quote it; the paper was not at hand"
METHODS: Final[Mapping[str, EmpiricalMethod]] = MappingProxyType(
    {
        "wagner-smitt": EmpiricalMethod(
            wagner_smitt,
            clarke_accelerations,
            _PRIME,
            ("wagner_smitt_1971", _CLARKE),
            _CLARKE_MASS | shares(Yv=0.05, Yr=0.15, Nv=0.2, Nr=0.4),
            " (π form)",
        ),
        "norrbin": EmpiricalMethod(
            norrbin,
            clarke_accelerations,
            _PRIME,
            ("norrbin_1971", _CLARKE),
            _CLARKE_MASS | shares(Yv=0.15, Yr=0.3, Nv=0.2, Nr=0.25),
        ),
        "inoue": EmpiricalMethod(
            inoue,
            clarke_accelerations,
            _PRIME,
            ("inoue_hirano_kijima_1981", _CLARKE),
            _CLARKE_MASS | shares(Yv=0.2, Yr=0.45, Nv=0.2, Nr=0.15),
        ),
        "clarke": EmpiricalMethod(
            clarke,
            clarke_accelerations,
            _PRIME,
            (_CLARKE, _CLARKE),
            _CLARKE_MASS | shares(Yv=0.15, Yr=0.3, Nv=0.2, Nr=0.1),
        ),
        "kijima": EmpiricalMethod(
            kijima,
            zhou_added_mass,
            _BETA,
            ("kijima_1990", _ZHOU),
            _ZHOU_MASS | _SLENDER | shares(Yvrr=0.15) | _numbers(Yvvr=0.6, Nvvr=0.28, Nvrr=0.1),
            _UNREAD,
        ),
        "yoshimura-masumoto": EmpiricalMethod(
            yoshimura_masumoto,
            zhou_added_mass,
            _MMG,
            ("yoshimura_masumoto_2012", _ZHOU),
            _ZHOU_MASS
            | _SLENDER
            | shares(Xvr=0.15, Yvvv=0.2, Yvrr=0.1, Nvvr=0.35, Nrrr=0.3)
            | _numbers(Xvv=0.03, Xrr=0.012, Yvvr=1.0, Yrrr=0.07, Nvvv=0.19, Nvrr=0.1)
            | _numbers("KVLCC2", "KCS", Xvvvv=0.6),
            _UNREAD,
            (("CB", 0.51, 0.65), ("L/B", 2.6, 7.1), ("d/B", 0.25, 0.46)),
        ),
    }
)


def estimate(ship: Ship, method: str) -> HullEstimate:
    """Derivatives of a hull from its particulars, with added mass.

    Parameters
    ----------
    ship : Ship
        Length, breadth, draught and volume.
    method : str
        ``wagner-smitt``, ``norrbin``, ``inoue``, ``clarke`` (linear; acceleration derivatives of
        Clarke), ``kijima``, ``yoshimura-masumoto`` (nonlinear; added mass of Zhou).

    Returns
    -------
    HullEstimate
        Totals as a captive test measures them: Coriolis terms of the added mass are inside. The
        uncertainty is how far the library's KVLCC2, KCS and S175 lie from the formulas.

    Raises
    ------
    UnknownNameError
        If there is no such method.

    Examples
    --------
    >>> ship = Ship(name="b", L=175., B=25.4, d=8.5, volume=21222., mass=2.2e7, Izz=3.8e10)
    >>> found = estimate(ship, "norrbin")
    >>> round(found.values["Nr"], 5), round(found.std["Nr"], 5)
    (-0.00277, 0.0008)
    """
    if method not in METHODS:
        raise UnknownNameError(f"There is no method {method!r}; there are: {', '.join(METHODS)}.")
    found = METHODS[method]
    mass = found.added_mass(ship)
    if found.convention.sway == "beta":
        mass = {name: -x if name.endswith("vdot") else x for name, x in mass.items()}
    values = {**found.hull(ship), **mass}
    return HullEstimate(
        values=MappingProxyType(values),
        std=MappingProxyType({name: found.error_of(name).of(x) for name, x in values.items()}),
        convention=found.convention,
        source=cite(found.sources[0]) + found.remark,
        sources=found.sources,
        notes=found.outside(ship),
        grounds=MappingProxyType({name: found.error_of(name).source for name in values}),
    )


RUDDER_SOURCES: Final = (
    "fujii_1960",
    "quadvlieg_2013",
    "matsumoto_suemitsu_1980",
    "yoshimura_masumoto_2012",
)
"""Where `rudder_values` come from."""


def rudder_values(ship: Ship, *, area: float, aspect: float, D: float) -> dict[str, float]:
    """Rudder of the MMG model from particulars.

    area [m²]; D [m].
    """
    c = ship.block * ship.B / ship.L
    straightening = 2.06 * c + 0.14
    return {
        "area": area,
        "lift_slope": 6.13 * aspect / (aspect + 2.25),
        "eta": D / math.sqrt(area * aspect),
        "aH": 0.627 * ship.block - 0.153,
        "tR": 0.45 - 0.28 * ship.block,
        "xH": -0.45,
        "xR": -0.5,
        "lR": -0.9,
        "gamma_positive": straightening,
        "gamma_negative": straightening,
        "kappa": 0.55 - 0.8 * c,
        "epsilon": 2.26 - 1.82 * (1.0 - wake_fraction(ship)),
    }


def wake_fraction(ship: Ship) -> float:
    """Wake fraction of a single-screw ship, 0.5 CB - 0.05 (Taylor)."""
    return 0.5 * ship.block - 0.05


def friction_coefficient(reynolds: float) -> float:
    """Skin friction of the ITTC 1957 line [-].

    Examples
    --------
    >>> friction_coefficient(1e7)
    0.003
    """
    return 0.075 / (math.log10(reynolds) - 2.0) ** 2


def wetted_surface(ship: Ship) -> float:
    """Wetted surface by Denny and Mumford, 1.7 L d + volume/d [m²]."""
    return 1.7 * ship.L * ship.d + ship.volume / ship.d


def form_factor(ship: Ship) -> float:
    """Form factor k of the viscous resistance by Watanabe (1973) [-].

    Notes
    -----
    -0.095 + 25.6 CB/[(L/B)² sqrt(B/d)], as textbooks quote it; tests or CFD know better.

    Examples
    --------
    >>> from pmmkit.models.library import load_ship
    >>> round(form_factor(load_ship("s175")), 3)
    0.08
    """
    slender = (ship.L / ship.B) ** 2 * math.sqrt(ship.B / ship.d)
    return -0.095 + 25.6 * ship.block / slender
