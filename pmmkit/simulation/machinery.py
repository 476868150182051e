"""The engine in a stop: what a model says of it, what is assumed, and what a trial showed."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import lru_cache
from types import MappingProxyType
from typing import Any, Final, Self

import numpy as np

from pmmkit.base import DataError
from pmmkit.effects import CATALOGUE
from pmmkit.models import Model, Part, as_it_stops
from pmmkit.numerics import Array
from pmmkit.presentation import WIDE, number
from pmmkit.simulation.equations.layouts import State
from pmmkit.simulation.equations.prepared import prepare
from pmmkit.simulation.kinds.manoeuvre import Setting

THERE: Final = 0.02
"""Revolutions this near those ordered, as a share of the approach's, count as reached."""
SPIN: Final = 0.05
"""Time in which the torque of the approach would bring the shaft of an assumed engine from rest to
the revolutions of the approach, in ship lengths over the speed: 1 to 2 s of a large ship. Half or
double of it change a track reach by 2 %."""
GOVERNOR: Final = 0.2
"""Time constant of its governor, in the same unit."""
DEDUCTION, DEDUCTION_STD = 0.22, 0.1
"""Thrust deduction astern where nobody measured it, and how ships differ in it: van Berlekom and
Goddard (1972) have 0.22 for a tanker in all quadrants, and such data are scarce."""
FADING: Final = 0.2
"""Share of the revolutions of the approach below which its friction fades."""


OF_TURNS: Final = "the approach's revolutions"


@dataclass(frozen=True, kw_only=True)
class Assumption:
    """What is taken of an engine that nobody states, and how engines differ.

    `mean, std`: over what the ship has in her approach. `of`: what it is a share of. `text,
    why`: what it is, and on what ground it is taken so.
    """

    mean: float
    std: float
    of: str
    text: str
    why: str


ENGINE: Final[Mapping[str, Assumption]] = MappingProxyType(
    {
        "astern_share": Assumption(
            mean=0.85,
            std=0.15,
            of="the approach's torque",
            text="largest torque astern",
            why="diesels have over 80 % of their power astern (Cockcroft and Lameijer), class asks "
            "for 70 % of the revolutions, which is half of the torque ahead",
        ),
        "reverse_below": Assumption(
            mean=0.30,
            std=0.07,
            of=OF_TURNS,
            text="revolutions below which starting air turns the engine astern",
            why="20 to 40 % of full ahead in what engineers teach; 30 of 110 rpm in a report of a "
            "motor ship of 14 000 t (CHIRP)",
        ),
        "friction": Assumption(
            mean=0.07,
            std=0.02,
            of="the approach's torque",
            text="torque of friction while no fuel is given",
            why="mechanical efficiencies of slow diesels are 0.92 to 0.95",
        ),
    }
)
"""The engine of a ship whose model has no part ``shaft``: a slow diesel that starting air reverses.
None of these is fitted to the stops of docs/stops.md."""


@dataclass(frozen=True, kw_only=True)
class FullAstern:
    """The engine in a full astern stop, which the standard does not say.

    Parameters
    ----------
    turns : float
        Revolutions astern over those of the approach, negative: as ordered, or as measured.
    reversal_s : float
        Time from the order until they are reached, or the bucket is down [s]; NaN where they
        never are.
    most : float
        The farthest astern that the revolutions went, over those of the approach.
    torque : float, optional
        Largest torque astern over that of the approach, where somebody states it.
    measured : bool
        Whether a trial shows it; else it is stated or assumed.
    assumed : str
        What is assumed of the engine and of the propeller astern, in sentences.
    low, high : float
        95 % band of the track reach [L] of ships that differ as far as is known; NaN where it was
        not asked for.
    bucket : bool
        Whether a bucket turns the thrust: then the size of the revolutions counts.
    """

    turns: float
    reversal_s: float
    most: float = math.nan
    torque: float | None = None
    measured: bool = False
    assumed: str = ""
    low: float = math.nan
    high: float = math.nan
    bucket: bool = False

    @classmethod
    def of_a_stop(cls, t: Array, n: Array, ahead: float) -> Self | None:
        """What the engine did in a measured stop; None where the propeller never turns astern.

        Parameters
        ----------
        t, n, ahead
            As for `reached`, until the ship stops.

        Notes
        -----
        The revolutions are the median of the second half of the time in which they are astern.
        """
        astern = np.flatnonzero(n < 0.0)
        if not len(astern):
            return None
        turns = float(np.median(n[astern[len(astern) // 2 :]])) / ahead
        return cls(turns=turns, reversal_s=reached(t, n, ahead, turns), measured=True)

    @property
    def words(self) -> str:
        """What the engine did, what of it is assumed, and what that leaves open.

        Examples
        --------
        >>> print(FullAstern(turns=-0.62, reversal_s=44.6, measured=True).words)
        Full astern was -0.62 of the approach's revolutions, reached 45 s after the order.
        """
        when = (
            f"reached {self.reversal_s:.0f} s after the order"
            if math.isfinite(self.reversal_s)
            else f"never reached (at most {self.most:.2g})"
        )
        if self.measured:
            return f"Full astern was {self.turns:.2g} of the approach's revolutions, {when}."
        done = (
            f"the bucket down, {self.reversal_s:.0f} s after the order, and pumps at "
            f"{abs(self.turns):g} of the approach's revolutions"
            if self.bucket
            else f"{self.turns:g} of the approach's revolutions, {when}"
        )
        said = [f"Full astern is {done}; the standard does not say it.", self.assumed, self._band]
        return " ".join(text for text in said if text)

    @property
    def _band(self) -> str:
        """The track reach of ships that differ as far as is known."""
        if math.isnan(self.low):
            return ""
        return (
            f"Track reach of 95 % of such ships: {number(self.low, 3)} to {number(self.high, 3)} L."
        )


def reached(t: Array, n: Array, ahead: float, turns: float) -> float:
    """When revolutions astern are reached [s]; NaN where they never are.

    t, n (m,); t, n [s]; ahead [1/s].

    Examples
    --------
    >>> t = np.arange(0.0, 200.0)
    >>> reached(t, np.clip(1.5 - 0.05 * t, -0.9, 1.5), 1.5, -0.6)
    48.0
    """
    there = n <= (turns + THERE) * ahead
    return float(t[int(np.argmax(there))]) if there.any() else math.nan


def as_it_reverses(
    model: Model,
    speed: float,
    *,
    turns: float = -1.0,
    reversal_s: float | None = None,
    torque: float | None = None,
    extrapolate: bool = False,
    **_others: Any,
) -> Model:
    """A model with all that a stop asks of its propulsion, by assumptions where it must be.

    speed [m/s].

    Notes
    -----
    An engine gives no torque until the shaft, which the water drives, has slowed to the revolutions
    at which starting air turns it astern. Then it gives what its governor asks for, up to its
    limit.

    Examples
    --------
    >>> from pmmkit.models import load_model
    >>> made = as_it_reverses(load_model("kvlcc2"), 7.97)
    >>> list(made.parts)[-1], made.values("shaft")["astern_share"]
    ('shaft', 0.85)
    """
    turning = as_it_stops(model)
    own = [name for name, part in model.parts.items() if "n" in part.known.states]
    if torque is not None and own:
        raise DataError(
            f"Model {model.name!r} has a part {own[0]}, which says how its engine turns the "
            f"propeller. State the limit there, or leave it out."
        )
    ordered = reversal_s is not None and torque is None
    if turning is None or turns >= 0.0:
        return model
    if turning.has_bucket:
        return turning
    turning = _with_deduction(turning)
    if own or ordered:
        return turning
    return _with_engine(turning, speed, torque, reversal_s is not None, extrapolate)


@lru_cache(maxsize=64)
def _with_engine(
    model: Model, speed: float, torque: float | None, at_once: bool, extrapolate: bool
) -> Model:
    """A model with an assumed engine; its torque may be stated, and it may be reversed at once. The
    model itself where nothing is stated and nothing says the torque."""
    approach = _torque(model, speed, extrapolate=extrapolate)
    if not approach > 0.0:
        if torque is None:
            return model
        raise _unknown_torque(model)
    n = prepare(model, speed, extrapolate=extrapolate).self_propulsion()
    over = {"astern_share": 1.0, "reverse_below": n, "friction": approach}
    stated = {"astern_share": torque, "reverse_below": at_once}
    drawn = [name for name in over if not stated.get(name)]
    values = {name: over[name] * ENGINE[name].mean for name in drawn}
    most = max(torque or 1.0, 1.0)
    pace = speed / model.ship.L
    values |= {
        "inertia": approach * SPIN / pace / (2.0 * math.pi * n),
        "torque_max": most * approach,
        "time_constant": GOVERNOR / pace,
        "n_low": FADING * n,
    }
    if torque:
        values["astern_share"] = torque / most
    return _with_shaft(model, values, {name: over[name] * ENGINE[name].std for name in drawn})


@lru_cache(maxsize=64)
def _with_deduction(model: Model) -> Model:
    """A model with a thrust deduction astern, which is assumed where nobody states it."""
    blades = model.parts.get("four_quadrant_propeller")
    if blades is None or "t_astern" in blades.values:
        return model
    losing = replace(
        blades,
        values=MappingProxyType({**blades.values, "t_astern": DEDUCTION}),
        std=MappingProxyType({**blades.std, "t_astern": DEDUCTION_STD}),
        sources=MappingProxyType({**blades.sources, "t_astern": "assumed"}),
    )
    return model.with_(parts=MappingProxyType({**model.parts, "four_quadrant_propeller": losing}))


def assumed(model: Model, turns: Setting | None = None) -> str:
    """What is assumed of the engine of a model from `as_it_reverses`, in sentences.

    Examples
    --------
    >>> from pmmkit.models import load_model
    >>> print(assumed(load_model("esso190k")))
    <BLANKLINE>
    """
    shaft, blades = model.parts.get("shaft"), model.parts.get("four_quadrant_propeller")
    told = []
    if turns is not None:
        what, sign = ("of the pumps", -1.0) if model.has_bucket else ("astern", 1.0)
        mean = sign * (turns.default or 0.0)
        told.append(_told(f"revolutions {what}", mean, turns.std, f" of {OF_TURNS}"))
    if shaft is not None and shaft.assumed():
        told += [
            _told(item.text, item.mean, item.std, f" of {item.of}")
            for name, item in ENGINE.items()
            if name in shaft.std
        ]
    if blades is not None and blades.assumed("t_astern"):
        told.append(_told("thrust deduction astern", DEDUCTION, DEDUCTION_STD, ""))
    return f"Assumed: {'; '.join(told)}." if told else ""


def _told(text: str, mean: float, std: float, of: str) -> str:
    """An assumption with its 95 % band, in words."""
    return f"{text} {mean:g} ± {number(WIDE * std, 2)}{of}"


def torque_of(model: Model, speed: float, **settings: Any) -> float:
    """Torque at the propeller in the approach [N m].

    speed [m/s].

    Notes
    -----
    An engine that gives nothing loses 2π I dn/dt = -Q.
    """
    torque = _torque(model, speed, **settings)
    if not torque > 0.0:
        raise _unknown_torque(model)
    return torque


def _unknown_torque(model: Model) -> DataError:
    knowing = [item.name for item in CATALOGUE.values() if "torque" in item.outputs]
    return DataError(
        f"Model {model.name!r} does not know the torque of its propulsion, so it cannot be "
        f"limited. Leave the limit out, or give a part {' or '.join(knowing)} with its torque."
    )


def _torque(model: Model, speed: float, **settings: Any) -> float:
    """Torque at the propeller in the approach [N m]; none where nothing says it."""
    if not any("torque" in part.known.outputs for part in model.parts.values()):
        return 0.0
    free = _with_shaft(model, {"inertia": 1.0 / (2.0 * math.pi), "torque_max": 0.0}, {})
    ready = prepare(free, speed, **settings)
    n = ready.self_propulsion()
    place = ready.structure.states.index("n")
    y = [0.0] * len(ready.structure.states)
    y[State.u], y[place] = speed, n
    return -float(ready.rates(y, 0.0, n)[place])


def _with_shaft(model: Model, values: Mapping[str, float], std: Mapping[str, float]) -> Model:
    """A model with an engine of constant torque, whichever way the shaft turns."""
    limit, (constant, *_) = next(iter(CATALOGUE["shaft"].options.items()))
    shaft = Part(
        effect="shaft",
        values=MappingProxyType(dict(values)),
        std=MappingProxyType(dict(std)),
        options=MappingProxyType({limit: constant}),
        source="assumed: an engine that nobody states",
    )
    return model.with_(parts=MappingProxyType({**model.parts, "shaft": shaft}))
