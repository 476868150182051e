"""What the numbers of a model stand on: how it was made, what is estimated, where it was tested."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache, lru_cache
from typing import Any, Final

import numpy as np

from pmmkit.conventions import parse_derivative
from pmmkit.effects import HULL
from pmmkit.models.estimates import resistance_derivative
from pmmkit.models.model import FN_TOLERANCE, SAILING, Model
from pmmkit.models.part import Part
from pmmkit.presentation import listed

EMPIRICAL: Final = "empirical"
"""How the source of an estimate begins."""
FASTEST: Final = 0.29
"""Largest Froude number of the ships that the standard errors of the estimates come from: KVLCC2,
KCS and S175."""
GUESSED: Final = (
    "All derivatives of the hull's side force and moment are estimates from particulars: a first "
    "look, not a verdict."
)
UNCOUPLED: Final = (
    "The hull has no term of sway and yaw together in side force and moment: nobody asked for one, "
    "which is not zero. How she turns is a first look, not a verdict."
)
"""Of S175 the tactical diameter is 3.49 L with a `cubic` hull of her tests, 4.36 L with hers."""
COUPLED: Final = (
    "The terms of sway and yaw together in side force and moment are estimates from particulars: "
    "how she turns is a first look, not a verdict."
)
"""Of a little hull the tactical diameter is 3.2 L without them and 5.2 L with estimates."""
REVERSED: Final = (
    "Nobody states what the engine does in a stop: it is assumed, and so are the stop's figures. "
    "`pmmkit uncertainty --manoeuvre stopping` gives their range."
)
TOO_FAST: Final = (
    "At Fn {:.2f} nothing says how good they are: they were held against ships at Fn {:g} at most."
)


HEAVIER: Final = 1.5
"""From so many times the resistance of a ship of her size on it is taken for a model's. KVLCC2 and
KCS of the library have 2.1 and 1.7 at full scale, S175 0.9; the estimate is good to a quarter."""
PRIMES: Final = ("prime", "prime-d")
"""Non-dimensional systems in which Xuu is a resistance over the square of the speed."""
WAVES: Final = 0.3
"""Froude number beyond which waves may make as much of the resistance."""
HEAVY: Final = (
    "Her resistance is {:.1f} times that of ships of her size, as a model's is: a ship runs on "
    "farther when her engine is stopped, at other revolutions."
)


@dataclass(frozen=True, kw_only=True)
class Standing:
    """What the numbers of a model stand on at the speed of an approach.

    Parameters
    ----------
    forced : str
        Why the model is not usable; empty where it is.
    hull : bool
        Whether all derivatives of the hull's side force and moment are estimates.
    uncoupled : bool
        Whether nothing of the hull's side force and moment goes with sway and yaw together.
    coupled : bool
        Whether what goes with both is estimated, of a hull of which other terms are not.
    estimated : tuple of str
        Among propulsion and steering, what goes by values that nobody measured.
    reversed : bool
        Whether it is assumed what the engine does in a stop.
    Fn : float
        Of the approach.
    tested : tuple of float
        Least and greatest Froude number of the derivatives; empty where they are one set for all.
    heavy : str
        That the ship has the resistance of a model, in a sentence; empty where she has not.
    """

    forced: str = ""
    hull: bool = False
    uncoupled: bool = False
    coupled: bool = False
    estimated: tuple[str, ...] = ()
    reversed: bool = False
    Fn: float = 0.0
    tested: tuple[float, ...] = ()
    heavy: str = ""

    @staticmethod
    def of(model: Model, speed: float) -> Standing:
        """What the numbers of a model stand on.

        Parameters
        ----------
        model : Model
            Whose steps say whether it was made by force, and whose sources which values are
            estimates.
        speed : float
            Of the approach [m/s].

        Examples
        --------
        >>> from pmmkit.models.estimates import estimated_model
        >>> from pmmkit.models.store import load_model
        >>> ship = load_model("kcs").ship
        >>> made = estimated_model(ship, speed=12.35, propeller_diameter=7.9, rudder_area=45.3)
        >>> Standing.of(load_model("kcs"), 12.35).sentences
        ()
        >>> Standing.of(made, 12.35).hull, Standing.of(made, 12.35).estimated
        (True, ('propulsion', 'steering'))
        """
        return _standing(model, float(speed))

    @property
    def outside(self) -> float:
        """By how much the approach is beyond what was tested, over the end that it is beyond:
        positive above, negative below, zero inside.

        Examples
        --------
        >>> round(Standing(Fn=0.36, tested=(0.15, 0.3)).outside, 3)
        0.2
        >>> Standing(Fn=0.29, tested=(0.15, 0.3)).outside
        0.0
        """
        if not self.tested:
            return 0.0
        for end, beyond in ((self.tested[0], min), (self.tested[-1], max)):
            share = self.Fn / end - 1.0
            if beyond(share, 0.0) and abs(share) > FN_TOLERANCE:
                return share
        return 0.0

    @property
    def unsettled(self) -> tuple[str, ...]:
        """Why no criterion is met or failed by such numbers, a sentence each."""
        return tuple(
            text
            for text in (
                self.forced,
                GUESSED if self.hull else "",
                UNCOUPLED if self.uncoupled else "",
                COUPLED if self.coupled else "",
                self._parts,
                self._range,
            )
            if text
        )

    @property
    def remarks(self) -> tuple[str, ...]:
        """What a reader must know beside that, a sentence each."""
        fast = TOO_FAST.format(self.Fn, FASTEST) if self.hull and self.Fn > FASTEST else ""
        stop = REVERSED if self.reversed else ""
        return tuple(text for text in (stop, fast) if text)

    @property
    def sentences(self) -> tuple[str, ...]:
        """What a reader of a number must know, a sentence each."""
        return (*self.unsettled, *self.remarks)

    @property
    def _parts(self) -> str:
        """That what drives and steers her is an estimate."""
        if not self.estimated:
            return ""
        one = len(self.estimated) == 1
        who = listed(self.estimated)
        return (
            f"{who[0].upper()}{who[1:]} {'is an estimate' if one else 'are estimates'} from "
            "particulars: how she turns and stops is a first look, not a verdict."
        )

    @property
    def _range(self) -> str:
        """That the approach is outside of what was tested."""
        if not self.outside:
            return ""
        where = "above" if self.outside > 0.0 else "below"
        span = " to ".join(f"{Fn:.3f}" for Fn in dict.fromkeys((self.tested[0], self.tested[-1])))
        return (
            f"The approach at Fn {self.Fn:.3f} is {100 * abs(self.outside):.0f} % {where} what was "
            f"tested (Fn {span}): an extrapolation, not a verdict."
        )

    def to_dict(self) -> dict[str, Any]:
        """As plain data."""
        return {
            "usable": not self.forced,
            "hull_estimated": self.hull,
            "uncoupled": self.uncoupled,
            "couplings_estimated": self.coupled,
            "estimated": list(self.estimated),
            "engine_assumed": self.reversed,
            "Fn": self.Fn,
            "tested": [self.tested[0], self.tested[-1]] if self.tested else None,
            "outside": self.outside,
            "sentences": list(self.sentences),
        }


@lru_cache(maxsize=64)  # of the same model every manoeuvre asks again
def _standing(model: Model, speed: float) -> Standing:
    hull = model.parts.get(HULL)
    across = [] if hull is None else [hull.source_of(x) for x in hull.values if x[0] in "YN"]
    both = [] if hull is None else [hull.source_of(x) for x in hull.values if _together(x)]
    guessed = _empirical(across)
    return Standing(
        forced=model.not_usable,
        hull=guessed,
        coupled=not guessed and _empirical(both),
        uncoupled=bool(across) and not model.acts_across(lambda v, r: v and r),
        estimated=tuple(
            role
            for role in SAILING
            if any(_guessed(x) for x in model.parts.values() if x.known.serves(role))
        ),
        reversed=any("n" in part.known.states and part.assumed() for part in model.parts.values()),
        Fn=model.ship.froude(speed, model.water.g),
        tested=tuple(model.Fn),
        heavy=_resistance_of_a_model(model, speed),
    )


def _empirical(sources: Sequence[str]) -> bool:
    """Whether there are sources, and all are of estimates."""
    return bool(sources) and all(source.startswith(EMPIRICAL) for source in sources)


def _resistance_of_a_model(model: Model, speed: float) -> str:
    """That a ship has the resistance of a model; empty where she has not."""
    hull = model.parts.get(HULL)
    ship = model.ship
    slow = ship.froude(speed, model.water.g) < WAVES
    if hull is None or "Xuu" not in hull.values or not slow or ship.L < ship.LONGEST_MODEL:
        return ""
    if model.convention.surge == "delta-u" or model.convention.system not in PRIMES:
        return ""
    own = float(np.mean(hull.values["Xuu"]))
    usual, _ = resistance_derivative(ship, model.water, speed, model.convention)
    return HEAVY.format(own / usual) if own / usual > HEAVIER else ""


@cache
def _together(name: str) -> bool:
    """Whether a term of side force or moment goes with sway and yaw."""
    term = parse_derivative(name)
    return name[0] in "YN" and bool(term.count("v") and term.count("r"))


def _guessed(part: Part) -> bool:
    """Whether an estimate of a part is of those by which ships differ."""
    return any(name in part.std for name in part.estimated)
