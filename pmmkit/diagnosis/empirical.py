"""A formula in place of a cause: products of the motion that fit what no effect explains."""

from __future__ import annotations

import math
import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import groupby
from typing import Any, Final

from pmmkit.conventions import CHANNELS, Derivative, parse_derivative
from pmmkit.diagnosis.evidence import finite
from pmmkit.effects import BY_SPEED, Effect, own_effect, own_effects_text
from pmmkit.presentation import WIDE, Grid, Group, listed, number

FAMILY: Final = "empirical"
NO_CAUSE: Final = "empirical term, no physical cause is named"
MIRRORED: Final = frozenset(("v", "r", "p", "phi", "d", "vdot", "rdot", "pdot"))
"""Variables that change sign in a mirrored motion."""
HIGH: Final = 4
"""Order from which a product is more often something that sets in at some angle than a power."""
_SYMBOLS: Final = {
    "0": "1",
    "d": "δ",
    "phi": "φ",
    "udot": "u̇'",
    "vdot": "v̇'",
    "rdot": "ṙ'",
    "pdot": "ṗ'",
}
_POWERS: Final = ("", "", "²", "³", "⁴", "⁵")


def is_symmetric(derivative: Derivative) -> bool:
    """Whether a ship that is alike to port and starboard has it (Abkowitz 1964): X is the same in a
    mirrored motion; Y, N and K change sign.

    Examples
    --------
    >>> [is_symmetric(parse_derivative(name)) for name in ("Yv|r|", "Yvr", "Xvr", "Y0")]
    [True, False, True, False]
    """
    odd = sum(factor in MIRRORED for factor in derivative.factors) % 2 == 1
    return odd != (derivative.channel == "X")


def noted(effect: str, why: str) -> str:
    """A remark on a step that adds an effect: a term of a formula says that it has no cause.

    Examples
    --------
    >>> noted("keel", "seen in sway")
    'seen in sway'
    >>> noted("empirical_yv_absr", "seen in sway")
    'seen in sway; empirical term, no physical cause is named'
    """
    if not effect.startswith(f"{FAMILY}_") or NO_CAUSE in why:
        return why
    return f"{why}; {NO_CAUSE}" if why else NO_CAUSE


@dataclass(frozen=True, kw_only=True)
class EmpiricalTerm:
    """One product of the motion in one channel, with the coefficient that fits.

    Parameters
    ----------
    name : str
        Of its derivative, ``Yv|r|``; with the mark of the speed, ``Yvvv F``, it is multiplied by
        F = (Fn/Fn0)² - 1.
    value, std : float
        Coefficient and its standard deviation, fitted together with the base: prime system,
        instantaneous speed [-].
    typical : float
        Its usual size before the tests: a tenth of the rms force of its channel.
    share : float
        Posterior probability that it belongs to the formula, of the products that were asked.
    like : mapping of str to float
        Products that can stand in its place, with their shares: these runs cannot tell them apart.
    Fn0 : float
        Froude number at which F is zero.
    """

    name: str
    value: float
    std: float
    typical: float
    share: float
    like: Mapping[str, float]
    Fn0: float

    @property
    def derivative(self) -> Derivative:
        """Its derivative, without the mark of the speed."""
        return parse_derivative(self.name.removesuffix(BY_SPEED))

    @property
    def by_speed(self) -> bool:
        """Whether it changes with the speed."""
        return self.name.endswith(BY_SPEED)

    @property
    def product(self) -> str:
        """What it multiplies, in symbols.

        Examples
        --------
        >>> term = EmpiricalTerm(name="Yvv|r|", value=1.0, std=0.1, typical=1.0, share=1.0,
        ...                      like={}, Fn0=0.2)
        >>> term.product
        "v'²|r'|"
        """
        parts = [
            _symbol(factor) + _POWERS[len(list(same))]
            for factor, same in groupby(self.derivative.factors)
        ]
        return "".join([*parts, *([" F"] if self.by_speed else [])])

    @property
    def reading(self) -> str:
        """What such a term usually stands for, in words."""
        said = [_reading(self.derivative)]
        if self.by_speed:
            said.append("changing with the speed (waves, sinkage, load of the propeller)")
        if len(self.derivative.factors) >= HIGH:
            said.append("of high order: often something that sets in at some angle")
        if not is_symmetric(self.derivative):
            said.append("which a ship that is alike to port and starboard has not")
        return ", ".join(said)

    @property
    def effect(self) -> Effect:
        """It as an effect of the user, which a model takes."""
        d = self.derivative
        label = re.sub(r"\|(\w+)\|", r"_abs\1", d.name).lower()
        rate = next((x for x in d.factors if x.endswith("dot")), "")
        rest = [factor for factor in d.factors if factor != rate]
        if not self.by_speed and not rate:
            return _effect(label, f"{d.channel}: {_typed(rest)}")
        words = [*(["Fn^2"] if self.by_speed else []), *([_typed(rest)] if rest else [])]
        usual = self.typical / self.Fn0**2 if self.by_speed else self.typical
        return _effect(
            f"{label}_speed" if self.by_speed else label,
            f"{d.channel}{rate}: {'*'.join(['a', *words])}; a ~ {usual:.3g}",
        )

    def row(self) -> list[str | None]:
        """Derivative, value, half of the 95 % interval, share and reading."""
        return [
            self.name,
            number(self.value, 3),
            f"± {number(WIDE * self.std, 2)}",
            f"{100 * self.share:.0f} %",
            self.reading,
        ]

    def to_dict(self) -> dict[str, Any]:
        """As plain data."""
        return {
            "term": self.name,
            "coefficient": self.value,
            "std": self.std,
            "typical": self.typical,
            "share": self.share,
            "cannot_be_told_from": dict(self.like),
            "reading": self.reading,
            "effect": self.effect.name,
        }


def _effect(label: str, text: str) -> Effect:
    about = f"{NO_CAUSE.capitalize()}."
    return own_effect(f"{FAMILY}_{label}", text, family=FAMILY, summary=about)


def _symbol(factor: str) -> str:
    bare = factor.strip("|")
    symbol = _SYMBOLS.get(bare, f"{bare}'")
    return f"|{symbol}|" if bare != factor else symbol


def _typed(factors: Sequence[str]) -> str:
    """A product as a text of an own effect has it."""
    return "*".join(
        factor + (f"^{count}" if count > 1 else "")
        for factor, count in _counted("1" if factor == "0" else factor for factor in factors)
    )


def _counted(factors: Iterator[str]) -> list[tuple[str, int]]:
    return [(factor, len(list(same))) for factor, same in groupby(factors)]


def _reading(d: Derivative) -> str:
    """The usual cause of forces with the variables of a derivative."""
    there, order = d.variables, len(d.factors)
    if any(x.endswith("dot") for x in there):
        return "added mass" if order == 1 else "added mass that changes with the motion"
    if "d" in there:
        return "force of the rudder" + (" in drift and yaw" if there & {"v", "r"} else "")
    if there & {"phi", "p"}:
        return "force of the heel, or what makes the model heel" + (
            " in drift and yaw" if there & {"v", "r"} else ""
        )
    if {"v", "r"} <= there:
        return "cross flow along the hull in drift and yaw together"
    if there <= {"v"}:
        return {1: "lift of the hull", 2: "drag of the cross flow"}.get(
            order, "lift and cross flow of the hull in drift"
        )
    if there <= {"r"}:
        return "damping and cross flow of the hull in yaw"
    return "a constant force" if there <= {"0"} else "resistance straight ahead"


@dataclass(frozen=True, kw_only=True)
class FormulaLength:
    """The best formula of some length: its terms, and its error on left-out conditions over the rms
    forces."""

    terms: tuple[str, ...]
    error: float


@dataclass(frozen=True, kw_only=True)
class EmpiricalFormula:
    """What fits the forces that no effect of the catalogue explains: numbers, no cause.

    Parameters
    ----------
    terms : tuple of EmpiricalTerm
        Empty where no formula makes left-out conditions better.
    beside : tuple of str
        Effects that are named and stay beside it.
    instead : tuple of str
        Effects that are named and whose place it takes.
    asked : int
        Number of products that were asked for.
    log_odds : float
        ln of the odds for it, against none.
    error_before, error_after, error_level : float
        Error of left-out conditions without and with it, and what noise alone gives, over the rms
        forces.
    lengths : tuple of FormulaLength
        The best formula of each length, from none on.
    """

    terms: tuple[EmpiricalTerm, ...]
    beside: tuple[str, ...]
    instead: tuple[str, ...]
    asked: int
    log_odds: float
    error_before: float
    error_after: float
    error_level: float
    lengths: tuple[FormulaLength, ...]

    @property
    def effects(self) -> tuple[Effect, ...]:
        """Its terms as effects of the user."""
        return tuple(item.effect for item in self.terms)

    def text(self, own: Sequence[Effect] = ()) -> str:
        """A file of its terms as effects of the user, and of those that the user has already."""
        known = {item.name: item for item in (*own, *self.effects)}
        return own_effects_text(list(known.values()))

    @property
    def equations(self) -> tuple[str, ...]:
        """Its channels, ``Y' = 0.0022 v'|r'|``."""
        by_channel = [[x for x in self.terms if x.derivative.channel == c] for c in CHANNELS]
        return tuple(
            f"{own[0].derivative.channel}' = "
            + " + ".join(f"{number(x.value, 3)} {x.product}" for x in own).replace("+ -", "- ")
            for own in by_channel
            if own
        )

    def with_titles(self, titles: Mapping[str, str]) -> EmpiricalFormula:
        """The same with the effects that it stands beside, or instead of, by their titles."""
        beside, instead = (
            tuple(titles.get(name, name) for name in own) for own in (self.beside, self.instead)
        )
        return replace(self, beside=beside, instead=instead)

    def remarks(self) -> list[str]:
        """What is to be said of it."""
        if not self.terms:
            return [
                f"No formula of a few of {self.asked} products of the motion explains it either, "
                f"whichever run is left out. Think of what is no function of the motion of the "
                f"instant: its history, the place in the tank, the rig."
            ]
        noise = f", where noise alone gives {100 * self.error_level:.2f} %"
        said = [
            f"A formula that fits what is left: {'; '.join(self.equations)}. The error of what was "
            f"left out goes from {100 * self.error_before:.2f} % to {100 * self.error_after:.2f} % "
            f"of the rms forces{noise if math.isfinite(self.error_level) else ''}. These are "
            f"numbers, no cause."
        ]
        if self.beside:
            said.append(f"It stands beside {listed(self.beside)}.")
        if self.instead:
            said.append(f"It takes the place of {listed(self.instead)}.")
        if any(item.by_speed for item in self.terms):
            said.append(f"F = (Fn/{self.terms[0].Fn0:.3g})² - 1.")
        said += [
            f"These runs cannot tell {item.name} from "
            f"{listed([f'{name} ({100 * x:.0f} %)' for name, x in item.like.items()])}."
            for item in self.terms
            if item.like
        ]
        return said

    def table(self) -> Grid:
        """A row for each term."""
        head = ["term", "value", "95 %", "probability", "usually"]
        return Grid(head=head, groups=[Group(rows=[x.row() for x in self.terms])], texts=(4,))

    def to_dict(self) -> dict[str, Any]:
        """As plain data."""
        return {
            "equations": list(self.equations),
            "terms": [item.to_dict() for item in self.terms],
            "beside": list(self.beside),
            "instead": list(self.instead),
            "asked": self.asked,
            "log_odds": self.log_odds,
            "error_before": finite(self.error_before),
            "error_after": finite(self.error_after),
            "error_level": finite(self.error_level),
            "lengths": [{"terms": list(x.terms), "error": finite(x.error)} for x in self.lengths],
        }
