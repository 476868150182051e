"""The engine in a stop: what a model says of it, what is assumed, and what a trial showed."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import lru_cache
from types import MappingProxyType
from typing import Any, Final

from pmmkit.base import DataError
from pmmkit.effects import CATALOGUE
from pmmkit.equations import State, prepare
from pmmkit.models import Model, Part
from pmmkit.presentation import WIDE, number
from pmmkit.simulation.kinds.manoeuvre import Setting

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
    turning = model.as_it_stops()
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
    approach = torque_of(model, speed, extrapolate=extrapolate)
    if not approach > 0.0:
        if torque is None:
            return model
        knowing = [item.name for item in CATALOGUE.values() if "torque" in item.outputs]
        raise DataError(
            f"Model {model.name!r} does not know the torque of its propulsion, so it cannot be "
            f"limited. Leave the limit out, or give a part {' or '.join(knowing)} with its torque."
        )
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
    """Torque at the propeller in the approach [N m]; none where nothing says it.

    An engine that gives nothing loses 2π I dn/dt = -Q.
    """
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
