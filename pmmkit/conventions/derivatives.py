"""Axes, signs, units, prime systems and the names of derivatives.

Ship axes: x forward, y to starboard, z down, origin midship. Drift angle
``beta = atan2(-v, u)``. A positive rudder turns the ship to starboard. SI and radians inside.
"""

from __future__ import annotations

import math
import re
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import TYPE_CHECKING, Final, Literal, get_args

from pmmkit.base import DataError, UnknownNameError

if TYPE_CHECKING:
    from pmmkit.conventions.ship import Ship, Water

Channel = Literal["X", "Y", "N", "K"]
CHANNELS: Final[tuple[str, ...]] = ("X", "Y", "N", "K")
FORCES: Final = frozenset({"X", "Y"})

System = Literal["prime", "prime-d", "bis"]

FACTORS: Final[tuple[str, ...]] = (
    "udot",
    "vdot",
    "rdot",
    "pdot",
    "phi",
    "|u|",
    "|v|",
    "|r|",
    "|p|",
    "|d|",
    "u",
    "v",
    "r",
    "p",
    "d",
    "T",
    "0",
)
"""What a derivative multiplies; ``d`` is the rudder angle, ``T`` the propeller thrust, ``0`` one.
Longer names come first so that the text is read greedily."""

_ORDER: Final = {
    name: place
    for place, name in enumerate(
        ("0", "u", "v", "r", "p", "d", "phi", "T", "udot", "vdot", "rdot", "pdot")
    )
}
_LENGTH_POWER: Final = {"r": 1, "p": 1, "udot": 1, "vdot": 1, "rdot": 2, "pdot": 2}
_SPEED_POWER: Final = {
    "u": 1,
    "v": 1,
    "r": 1,
    "p": 1,
    "T": 2,
    "udot": 2,
    "vdot": 2,
    "rdot": 2,
    "pdot": 2,
}
_TOKEN: Final = re.compile("|".join(re.escape(name) for name in FACTORS))


_LATEX: Final = {
    "udot": r"\dot{u}",
    "vdot": r"\dot{v}",
    "rdot": r"\dot{r}",
    "pdot": r"\dot{p}",
    "phi": r"\phi ",
    "d": r"\delta ",
    "|d|": r"|\delta|",
}


@dataclass(frozen=True)
class Derivative:
    """A derivative's name taken apart.

    Parameters
    ----------
    channel : {"X", "Y", "N", "K"}
        The force or moment it contributes to.
    factors : tuple of str
        What it multiplies, in canonical order, e.g. ``("v", "v", "r")``.
    """

    channel: str
    factors: tuple[str, ...]

    @property
    def name(self) -> str:
        """Canonical name, e.g. ``"Yvvr"``."""
        return self.channel + "".join(self.factors)

    @property
    def term(self) -> str:
        """The name without the channel, e.g. ``"vvr"``."""
        return "".join(self.factors)

    @property
    def speed_power(self) -> int:
        """Power of speed in the product of the factors (v 1, v̇ 2, δ 0)."""
        return sum(_SPEED_POWER.get(factor.strip("|"), 0) for factor in self.factors)

    @property
    def length_power(self) -> int:
        """Power of length that makes the product of the factors a power of speed (r 1, ṙ 2)."""
        return sum(_LENGTH_POWER.get(factor.strip("|"), 0) for factor in self.factors)

    @property
    def heels(self) -> bool:
        """Whether it asks for heel or its rates alone, which may be measured."""
        return self.channel != "K" and any(map(self.count, ("phi", "p", "pdot")))

    @property
    def rolls(self) -> bool:
        """Whether it belongs to roll: a K, or a factor of heel or its rates."""
        return self.channel == "K" or self.heels

    @property
    def variables(self) -> frozenset[str]:
        """The factors without their modulus bars, each once."""
        return frozenset(factor.strip("|") for factor in self.factors)

    def latex(self, *, beta: bool = False, double: bool = False) -> str:
        r"""The derivative as LaTeX mathematics.

        Parameters
        ----------
        beta : bool
            Write the drift angle in place of v.
        double : bool
            Two primes, for the bis system.

        Examples
        --------
        >>> print(parse_derivative("Nv|v|").latex(), parse_derivative("Yrdot").latex())
        N'_{v|v|} Y'_{\dot{r}}
        """
        symbols = _LATEX | (
            {"v": r"\beta ", "|v|": r"|\beta|", "vdot": r"\dot{\beta}"} if beta else {}
        )
        lower = "".join(symbols.get(factor, factor) for factor in self.factors).strip()
        prime = "''" if double else "'"
        return f"{self.channel}{prime}_{{{lower}}}"

    def count(self, variable: str) -> int:
        """How often a variable stands among the factors, with or without modulus."""
        return sum(factor.strip("|") == variable for factor in self.factors)

    def sign_under_flip(self, variable: str) -> int:
        """-1 if the product changes sign with the variable (its dot included), else 1."""
        odd = sum(factor in (variable, f"{variable}dot") for factor in self.factors)
        return -1 if odd % 2 else 1


@lru_cache(maxsize=4096)
def parse_derivative(name: str) -> Derivative:
    """Take the name of a derivative apart.

    Parameters
    ----------
    name : str
        A name of the literature without primes, factors in any order: ``Yv``, ``Yv|v|``,
        ``Nvvr``, ``Yvdot``, ``Xrv``, ``Yddd``, ``Kphi``, ``Y0``.

    Returns
    -------
    Derivative
        With the factors in canonical order.

    Raises
    ------
    UnknownNameError
        If the name does not start with a channel or holds an unknown factor.

    Examples
    --------
    >>> parse_derivative("Xrv").name
    'Xvr'
    >>> parse_derivative("Yvvvdot").factors
    ('v', 'v', 'vdot')
    """
    channel, term = name[:1], name[1:]
    tokens = _TOKEN.findall(term)
    if channel not in CHANNELS or not term or "".join(tokens) != term:
        raise UnknownNameError(
            f"{name!r} is not the name of a derivative. Write a channel (X, Y, N, K) and the "
            f"factors it multiplies, such as Yv, Nvvr, Yv|v|, Yvdot, Xuu, Yd, Y0."
        )
    factors = tuple(sorted(tokens, key=lambda token: (_ORDER[token.strip("|")], "|" in token)))
    return Derivative(channel, factors)


@dataclass(frozen=True, kw_only=True)
class Convention:
    """What the numbers of a table mean.

    Parameters
    ----------
    system : {"prime", "prime-d", "bis"}
        ``prime``: ½ρL²U² and ½ρL³U². ``prime-d``: ½ρLdU² and ½ρL²dU² (MMG). ``bis``: forces over
        the weight ρg∇, moments over ρg∇L, speed unit √(gL).
    U : {"instantaneous", "carriage"}
        Speed that makes velocities and forces non-dimensional.
    surge : {"u", "constant", "delta-u"}
        ``u``: Xuu multiplies u'². ``constant``: Xuu is the resistance straight ahead, whatever the
        drift. ``delta-u``: factors u are the loss of speed from the approach speed (Abkowitz).
    coriolis : {"in-derivatives", "separate"}
        Where the added-mass Coriolis terms are: inside Yr, Xvr … as a PMM measures them, or
        written out in the equations (Son and Nomoto, MMG).
    sway : {"v", "beta"}
        Whether factors v are v' or the drift angle beta = -v'.
    rudder_positive : {"starboard", "port"}
        Which way the ship turns for a positive rudder.
    moment_reference_x, motion_reference_x : float
        Point to which moments and motions refer, forward of midship [m].
    """

    system: System = "prime"
    U: Literal["instantaneous", "carriage"] = "instantaneous"
    surge: Literal["u", "constant", "delta-u"] = "u"
    coriolis: Literal["in-derivatives", "separate"] = "in-derivatives"
    sway: Literal["v", "beta"] = "v"
    rudder_positive: Literal["starboard", "port"] = "starboard"
    moment_reference_x: float = 0.0
    motion_reference_x: float = 0.0

    @property
    def meaning(self) -> str:
        """What the numbers mean, in words.

        Examples
        --------
        >>> Convention().meaning.split(", ")[0:2]
        ['prime (½ρL²U²', '½ρL³U²)']
        """
        unit = {
            "prime": "prime (½ρL²U², ½ρL³U²)",
            "prime-d": "prime-d (½ρLdU², ½ρL²dU²)",
            "bis": "bis (ρg∇, ρg∇L, √(gL))",
        }[self.system]
        speed = "instantaneous speed" if self.U == "instantaneous" else "carriage speed"
        coriolis = (
            "added-mass Coriolis terms inside the derivatives"
            if self.coriolis == "in-derivatives"
            else "added-mass Coriolis terms written separately"
        )
        point = (
            "midship"
            if self.moment_reference_x == self.motion_reference_x == 0
            else f"x = {self.moment_reference_x:g} m (moments), {self.motion_reference_x:g} m "
            f"(motions)"
        )
        return f"{unit}, {speed}, {coriolis}, referred to {point}"

    def latex(self, name: str) -> str:
        r"""A derivative as LaTeX mathematics; two primes in the bis system.

        Examples
        --------
        >>> print(Convention().latex("Nv|v|"), Convention(system="bis").latex("Yrdot"))
        N'_{v|v|} Y''_{\dot{r}}
        """
        return parse_derivative(name).latex(beta=self.sway == "beta", double=self.system == "bis")

    def symbol(self, name: str) -> str:
        """A derivative as text of a figure; names of other parameters stay."""
        try:
            return f"${self.latex(name)}$"
        except UnknownNameError:
            return name

    def force_unit(self, channel: str, *, ship: Ship, water: Water, U: float) -> float:
        """Unit [N or N m] by which a channel is divided.

        Parameters
        ----------
        channel : str
            X or Y, or a moment: N or K.
        ship, water : Ship, Water
            Length, draught and volume; density and gravity.
        U : float
            Speed [m/s]; it does not count in the bis system.

        Raises
        ------
        UnknownNameError
            If there is no such system.

        Examples
        --------
        >>> from pmmkit.conventions.ship import Ship, Water
        >>> ship = Ship(name="m", L=4.0, B=1.0, d=.25, volume=.5, mass=500., Izz=500.)
        >>> Convention().force_unit("Y", ship=ship, water=Water(rho=1000.0), U=2.0)
        32000.0
        """
        arm = 1.0 if channel in FORCES else ship.L
        system: str = self.system
        if system == "prime":
            return 0.5 * water.rho * ship.L**2 * U**2 * arm
        if system == "prime-d":
            return 0.5 * water.rho * ship.L * ship.d * U**2 * arm
        if system == "bis":
            return water.rho * water.g * ship.volume * arm
        raise UnknownNameError(f"System {system!r} is not known: {', '.join(get_args(System))}.")

    def speed_unit(self, *, ship: Ship, water: Water, U: float) -> float:
        """Speed [m/s] by which velocities are divided."""
        return math.sqrt(water.g * ship.L) if self.system == "bis" else U

    def with_(self, **changes: object) -> Convention:
        """A copy with some entries changed."""
        return replace(self, **changes)  # type: ignore[arg-type]


_UNITS: Final[dict[str, tuple[str, float]]] = {
    "": ("", 1.0),
    "-": ("", 1.0),
    "1": ("", 1.0),
    "%": ("", 0.01),
    "m": ("m", 1.0),
    "mm": ("m", 1e-3),
    "cm": ("m", 1e-2),
    "km": ("m", 1e3),
    "ft": ("m", 0.3048),
    "in": ("m", 0.0254),
    "nm": ("m", 1852.0),
    "nmi": ("m", 1852.0),
    "s": ("s", 1.0),
    "sec": ("s", 1.0),
    "sek": ("s", 1.0),
    "秒": ("s", 1.0),
    "초": ("s", 1.0),
    "ms": ("s", 1e-3),
    "min": ("s", 60.0),
    "h": ("s", 3600.0),
    "m/s": ("m/s", 1.0),
    "mm/s": ("m/s", 1e-3),
    "cm/s": ("m/s", 1e-2),
    "km/h": ("m/s", 1 / 3.6),
    "kn": ("m/s", 1852 / 3600),
    "knot": ("m/s", 1852 / 3600),
    "knots": ("m/s", 1852 / 3600),
    "ft/s": ("m/s", 0.3048),
    "m/s2": ("m/s2", 1.0),
    "m/s^2": ("m/s2", 1.0),
    "m/s²": ("m/s2", 1.0),
    "g": ("m/s2", 9.80665),
    "rad": ("rad", 1.0),
    "deg": ("rad", math.pi / 180),
    "°": ("rad", math.pi / 180),
    "grad": ("rad", math.pi / 180),
    "度": ("rad", math.pi / 180),
    "도": ("rad", math.pi / 180),
    "rad/s": ("rad/s", 1.0),
    "deg/s": ("rad/s", math.pi / 180),
    "°/s": ("rad/s", math.pi / 180),
    "deg/min": ("rad/s", math.pi / 10800),
    "rad/s2": ("rad/s2", 1.0),
    "rad/s^2": ("rad/s2", 1.0),
    "rad/s²": ("rad/s2", 1.0),
    "deg/s2": ("rad/s2", math.pi / 180),
    "deg/s^2": ("rad/s2", math.pi / 180),
    "deg/s²": ("rad/s2", math.pi / 180),
    "°/s2": ("rad/s2", math.pi / 180),
    "°/s^2": ("rad/s2", math.pi / 180),
    "°/s²": ("rad/s2", math.pi / 180),
    "mm/m": ("rad", 1e-3),
    "rps": ("1/s", 1.0),
    "1/s": ("1/s", 1.0),
    "hz": ("1/s", 1.0),
    "rpm": ("1/s", 1 / 60),
    "1/min": ("1/s", 1 / 60),
    "u/min": ("1/s", 1 / 60),
    "tr/min": ("1/s", 1 / 60),
    "n": ("N", 1.0),
    "kn_force": ("N", 1e3),
    "mn_mega": ("N", 1e6),
    "mn_milli": ("N", 1e-3),
    "kgf": ("N", 9.80665),
    "gf": ("N", 9.80665e-3),
    "tf": ("N", 9806.65),
    "lbf": ("N", 4.4482216152605),
    "n m": ("N m", 1.0),
    "nm_moment": ("N m", 1.0),
    "n-m": ("N m", 1.0),
    "n·m": ("N m", 1.0),
    "n*m": ("N m", 1.0),
    "n.m": ("N m", 1.0),
    "n・m": ("N m", 1.0),
    "n･m": ("N m", 1.0),
    "n⋅m": ("N m", 1.0),
    "n•m": ("N m", 1.0),
    "n×m": ("N m", 1.0),
    "n mm": ("N m", 1e-3),
    "nmm": ("N m", 1e-3),
    "n·mm": ("N m", 1e-3),
    "kn m": ("N m", 1e3),
    "kn-m": ("N m", 1e3),
    "kn·m": ("N m", 1e3),
    "kn・m": ("N m", 1e3),
    "kgf m": ("N m", 9.80665),
    "kgf-m": ("N m", 9.80665),
    "kgf·m": ("N m", 9.80665),
    "kgf・m": ("N m", 9.80665),
    "kg": ("kg", 1.0),
    "t": ("kg", 1e3),
    "lb": ("kg", 0.45359237),
    "lbs": ("kg", 0.45359237),
    **{
        text.format(stroke): ("N m", lever * 4.4482216152605)
        for unit, lever in (("ft", 0.3048), ("in", 0.0254))
        for text in (f"lbf{{}}{unit}", f"{unit}{{}}lbf", f"lb{{}}{unit}", f"{unit}{{}}lb")
        for stroke in (" ", "-", "·", ".", "*", "")
    },
}
_CASED: Final = {
    "kN": "kn_force",
    "MN": "mn_mega",
    "mN": "mn_milli",
    "Nm": "nm_moment",
    "kNm": "kn m",
    "NM": "nm_moment",  # of files in capitals; a distance has no channel
    "KNM": "kn m",
    "kgfm": "kgf m",
}


def is_unit(text: str) -> bool:
    """Whether a text is a unit that is known; an empty one is, without dimension.

    Parameters
    ----------
    text : str
        What may be one.

    Examples
    --------
    >>> is_unit("kN"), is_unit("Fx")
    (True, False)
    """
    try:
        unit_factor(text)
    except DataError:
        return False
    return True


def unit_factor(unit: str) -> tuple[str, float]:
    """SI unit and the factor that leads to it.

    Case matters only where it decides: ``kN`` is a force and ``kn`` a speed, ``Nm`` a moment and
    ``nm`` a nautical mile.

    Parameters
    ----------
    unit : str
        As a file states it.

    Raises
    ------
    DataError
        If the unit is not known.

    Examples
    --------
    >>> unit_factor("deg")
    ('rad', 0.017453292519943295)
    >>> unit_factor("kN"), unit_factor("kn")
    (('N', 1000.0), ('m/s', 0.5144444444444445))
    """
    text = unit.strip()
    key = _CASED.get(text, text.lower())
    if key not in _UNITS:
        raise DataError(
            f"Unit {unit!r} is not known. Known: N, kN, kgf, N m, m, mm, m/s, kn, deg, rad, "
            f"deg/s, rad/s, s, Hz, rpm and similar."
        )
    return _UNITS[key]
