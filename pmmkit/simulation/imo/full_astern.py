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
the revolutions of the approach. Half or double of it change a track reach by 0.3 %."""


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
        Largest torque astern over that of the approach; None where there is no such limit.
    measured : bool
        Whether a trial shows it; else it is assumed.
    others : tuple of (float, float)
        Other revolutions astern, and the track reach that they give [L].
    limit : float
        Of the track reach [L].
    propeller : str
        What is assumed of the propeller astern, in a sentence; empty where the model knows it.
    bucket : bool
        Whether a bucket turns the thrust: then the size of the revolutions counts.
    """

    turns: float
    reversal_s: float
    most: float = math.nan
    torque: float | None = None
    measured: bool = False
    others: tuple[tuple[float, float], ...] = ()
    limit: float = math.nan
    propeller: str = ""
    bucket: bool = False

    @property
    def words(self) -> str:
        """What is assumed or measured, and what other revolutions give.

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
        others = ", ".join(
            f"{self._turns(own):g} {number(reach, 3)} L"
            f"{'' if reach <= self.limit else ' (not met)'}"
            for own, reach in self.others
        )
        if self.bucket:
            return (
                f"Full astern is the bucket down, {self.reversal_s:.0f} s after the order, and "
                f"pumps at {self._turns(self.turns):g} of the approach's revolutions; the standard "
                f"does not say them. Track reach with others: {others}."
            )
        if self.measured:
            return f"Full astern was {self.turns:.2g} of the approach's revolutions, {when}."
        torque = (
            "with all the torque that this needs"
            if self.torque is None
            else f"with a torque of at most {self.torque:g} of the approach's"
        )
        return (
            f"Full astern is {self.turns:g} of the approach's revolutions, {when}, {torque}; the "
            f"standard does not say them. Track reach with others: {others}."
            + (f" {self.propeller}" if self.propeller else "")
        )

    def _turns(self, own: float) -> float:
        return abs(own) if self.bucket else own


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

    Parameters
    ----------
    model : Model
        Without a part ``shaft`` or ``shaft_lag``.
    speed : float
        Of the approach [m/s].
    **settings
        Of `prepare`.

    Raises
    ------
    DataError
        If the model does not know it.

    Notes
    -----
    An engine that gives nothing loses 2π I dn/dt = -Q.
    """
    ready = prepare(_with_engine(model, 1.0 / (2.0 * math.pi), 0.0), speed, **settings)
    n = ready.self_propulsion()
    place = ready.structure.states.index("n")
    y = [0.0] * len(ready.structure.states)
    y[State.u], y[place] = speed, n
    torque = -ready.rates(y, 0.0, n)[place]
    if not torque > 0.0:
        knowing = [item.name for item in catalogue().values() if "torque" in item.outputs]
        raise DataError(
            f"Model {model.name!r} does not know the torque of its propulsion, so it cannot be "
            f"limited. Leave the limit out, or give a part {' or '.join(knowing)} with its torque."
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
    inertia = torque * SPIN / (2.0 * math.pi * n)
    return _with_engine(model, inertia, most * torque, astern_share=share / most)


def _with_engine(
    model: Model, inertia: float, torque_max: float, *, astern_share: float = 1.0
) -> Model:
    """A model with an engine that gives up to so much torque, whichever way the shaft turns."""
    values = {"inertia": inertia, "torque_max": torque_max, "astern_share": astern_share}
    limit, (constant, *_) = next(iter(SHAFT.options.items()))
    shaft = Part(
        effect=SHAFT.name,
        values=MappingProxyType(values),
        options=MappingProxyType({limit: constant}),
        source="assumed: a limit of the torque in a stop",
    )
    return model.with_(parts=MappingProxyType({**model.parts, SHAFT.name: shaft}))
