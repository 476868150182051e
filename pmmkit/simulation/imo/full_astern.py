"""The full astern stop: what is assumed of the engine, and what other assumptions give."""

from __future__ import annotations

import math
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any, Final

import numpy as np

from pmmkit.effects.catalogue import catalogue
from pmmkit.effects.shaft import SHAFT
from pmmkit.equations import prepare
from pmmkit.equations.code_generation import told
from pmmkit.equations.layouts import State
from pmmkit.errors import DataError
from pmmkit.metrics import TRACK_REACH
from pmmkit.models import Model
from pmmkit.models.model import Part
from pmmkit.numerics import Array
from pmmkit.presentation import number
from pmmkit.simulation.manoeuvres.catalogue import manoeuvre_of

ASTERN: Final = (-0.6, -0.7, -0.8, -0.9, -1.0)
"""Revolutions astern over those of the approach, of which the track reach is told."""
THERE: Final = 0.02
"""Revolutions this near those ordered, as a share of the approach's, count as reached."""
SPIN: Final = 1.0
"""Seconds in which the torque of the approach would bring the shaft of a torque limit from rest to
the revolutions of the approach. The stop does not feel it: half or double of it change the track
reach in the fourth digit."""


@dataclass(frozen=True, kw_only=True)
class FullAstern:
    """The engine in a full astern stop, which the standard does not say.

    Parameters
    ----------
    turns : float
        Revolutions astern over those of the approach, negative: as ordered, or as measured.
    reversal_s : float
        Time from the order until they are reached [s]; NaN where they never are.
    torque : float, optional
        Largest torque astern over that of the approach; None where there is no such limit.
    measured : bool
        Whether a trial shows it; else it is assumed.
    others : tuple of (float, float)
        Other revolutions astern, and the track reach that they give [L].
    limit : float
        Of the track reach [L].
    """

    turns: float
    reversal_s: float
    torque: float | None = None
    measured: bool = False
    others: tuple[tuple[float, float], ...] = ()
    limit: float = math.nan

    @property
    def words(self) -> str:
        """What is assumed or measured, and what other revolutions give.

        Examples
        --------
        >>> print(FullAstern(turns=-0.62, reversal_s=44.6, measured=True).words)
        Full astern was -0.62 of the approach's revolutions, 45 s after the order.
        """
        when = (
            f"{self.reversal_s:.0f} s after the order"
            if math.isfinite(self.reversal_s)
            else "not reached before she stops"
        )
        if self.measured:
            return f"Full astern was {self.turns:.2g} of the approach's revolutions, {when}."
        torque = (
            "with all the torque that this needs"
            if self.torque is None
            else f"with a torque of at most {self.torque:g} of the approach's"
        )
        said = ", ".join(
            f"{own:g} {number(reach, 3)} L{'' if reach <= self.limit else ' (not met)'}"
            for own, reach in self.others
        )
        return (
            f"Full astern is {self.turns:g} of the approach's revolutions, {when}, {torque}; the "
            f"standard does not say them. Track reach with others: {said}."
        )


def usual_turns() -> float:
    """Revolutions astern over those of the approach, where none are stated."""
    usual = {item.name: item.default for item in manoeuvre_of(TRACK_REACH.manoeuvre).settings}
    return usual["turns"] or 0.0


def reached(t: Array, n: Array, ahead: float, turns: float) -> float:
    """When revolutions astern are reached [s]; NaN where they never are.

    Parameters
    ----------
    t, n : array (m,)
        Time from the order [s] and revolutions [1/s].
    ahead : float
        Revolutions of the approach [1/s].
    turns : float
        Those astern over these.

    Examples
    --------
    >>> t = np.arange(0.0, 200.0)
    >>> reached(t, np.clip(1.5 - 0.05 * t, -0.9, 1.5), 1.5, -0.6)
    48.0
    """
    there = n <= (turns + THERE) * ahead
    return float(t[int(np.argmax(there))]) if there.any() else math.nan


def measured_astern(t: Array, n: Array, ahead: float) -> FullAstern | None:
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
    return FullAstern(turns=turns, reversal_s=reached(t, n, ahead, turns), measured=True)


def torque_of(model: Model, speed: float, **settings: Any) -> float:
    """Torque at the propeller in the approach [N m].

    Raises
    ------
    DataError
        If the model does not know it.
    """
    ready = prepare(model, speed, **settings)
    names = told(ready.structure)
    found = [0.0] * len(names)
    if "torque" in names:
        y = [0.0] * len(ready.structure.states)
        y[State.u] = speed
        ready.functions().forces(y, 0.0, ready.self_propulsion(), 0.0, list(ready.k), found)
    torque = found[names.index("torque")] if "torque" in names else 0.0
    if not torque > 0.0:
        knowing = [item.name for item in catalogue().values() if "torque" in item.outputs]
        raise DataError(
            f"Model {model.name!r} does not know the torque of its propulsion, so it cannot be "
            f"limited. Leave the limit out, or give a part {' or '.join(knowing)} with KQ."
        )
    return torque


def with_torque_limit(model: Model, speed: float, share: float, **settings: Any) -> Model:
    """A model whose engine gives at most a share of the approach's torque astern.

    Parameters
    ----------
    model : Model
        Without a part ``shaft`` or ``shaft_lag``, which has an engine of its own.
    speed : float
        Of the approach [m/s].
    share : float
        Largest torque astern over that of the approach.
    **settings
        Of `prepare`.

    Raises
    ------
    DataError
        If the share is not positive, the model has a shaft, or it does not know its torque.
    """
    if not share > 0.0:
        raise DataError(f"The torque of a stop is a positive share of the approach's, not {share}.")
    own = [name for name, part in model.parts.items() if "n" in part.known.states]
    if own:
        raise DataError(
            f"Model {model.name!r} has a part {own[0]}, which says how its engine turns the "
            f"propeller. State the limit there, or leave it out."
        )
    torque = torque_of(model, speed, **settings)
    n = prepare(model, speed, **settings).self_propulsion()
    most = max(share, 1.0)
    limit = Part(
        effect=SHAFT.name,
        values=MappingProxyType(
            {
                "inertia": torque * SPIN / (2.0 * math.pi * n),
                "torque_max": most * torque,
                "astern_share": share / most,
                "reverse_below": 1e6,
                "friction": 0.0,
                "n_low": 0.3,
                "time_constant": 5.0,
            }
        ),
        options=MappingProxyType({"limit": SHAFT.options["limit"][0]}),
        source="assumed: a limit of the torque in a stop",
    )
    return model.with_(parts=MappingProxyType({**model.parts, SHAFT.name: limit}))
