"""What an effect of the catalogue does to a captive run: harmonics per unit of each coefficient."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any, Final

import numpy as np

from pmmkit.diagnosis.captive.base import Base
from pmmkit.diagnosis.captive.observed import Seen, filtered
from pmmkit.effects.catalogue import arguments_of
from pmmkit.effects.effect import BY_SPEED, Effect
from pmmkit.effects.primitives import over_arrays
from pmmkit.numerics import Array
from pmmkit.observations.views import View

CHANNELS: Final = ("X", "Y", "N")
Terms = Sequence[Mapping[str, float]]
"""Derivatives that each coefficient stands for, with its share of them."""
Columns = Callable[[View, Base, float], Mapping[str, Array]]
"""Harmonics of an effect in one view by channel, (m, q), at one grid point, q coefficients."""


def columns_of(effect: Effect) -> Columns:
    """The columns of an effect, by its kind."""
    if effect.columns is not None:
        return _of_a_fault(effect)
    terms = terms_of(effect)
    return of_terms(terms) if terms else _of_a_force(effect)


def terms_of(effect: Effect) -> Terms:
    """Derivatives that the coefficients of an effect stand for; none where it is no such effect."""
    if effect.columns is not None or effect.kind != "terms":
        return ()
    return tuple(effect.derivatives_of(name) for name in effect.typical)


def spread_over(
    view: View, parts: Mapping[str, Sequence[Array]], count: int
) -> Mapping[str, Array]:
    """Columns by channel from single columns: channel to one array per coefficient."""
    return MappingProxyType(
        {
            channel: np.array(own, float).T
            for channel, own in parts.items()
            if channel in view.force and len(own) == count
        }
    )


def _of_a_fault(effect: Effect) -> Columns:
    function, count = effect.columns, len(effect.coefficients)
    assert function is not None

    def columns(view: View, base: Base, value: float) -> Mapping[str, Array]:
        return spread_over(view, function(Seen(view, base), value), count)

    return columns


def of_terms(shares: Terms) -> Columns:
    """Columns of coefficients that stand for derivatives, each with its share of them.

    A derivative with the mark of the speed is multiplied by F at the speed of the run.
    """

    def columns(view: View, base: Base, value: float) -> Mapping[str, Array]:
        del value
        known = tuple(name for name in channels_of_terms([shares]) if name in view.force)
        found = {name: TermTable.of([shares], name, [view], base) for name in known}
        return MappingProxyType({name: table.columns(shares) for name, table in found.items()})

    return columns


def channels_of_terms(every: Sequence[Terms]) -> tuple[str, ...]:
    """Channels that derivatives act in."""
    return tuple(dict.fromkeys(name[0] for shares in every for own in shares for name in own))


@dataclass(frozen=True, kw_only=True, eq=False)
class TermTable:
    """Harmonics of what derivatives multiply in one channel of some views.

    Parameters
    ----------
    names : mapping of str to int
        Column of each derivative.
    plain : array (n, p)
        Harmonics, the views one below the other.
    law : array (n, 1)
        F at the speed of each row's run.
    channel : str
        The channel.
    """

    names: Mapping[str, int]
    plain: Array
    law: Array
    channel: str

    @classmethod
    def of(
        cls, every: Sequence[Terms], channel: str, views: Sequence[View], base: Base
    ) -> TermTable:
        """Of all derivatives of a channel that some coefficients stand for."""
        named = (name for shares in every for own in shares for name in own if name[0] == channel)
        names = list(dict.fromkeys(name.removesuffix(BY_SPEED) for name in named))
        law = np.repeat([base.law(view.speed) for view in views], [view.rows for view in views])
        return cls(
            names=MappingProxyType({name: place for place, name in enumerate(names)}),
            plain=base.design(names, views),
            law=law[:, None],
            channel=channel,
        )

    def columns(self, shares: Terms) -> Array:
        """Of coefficients that stand for derivatives (n, q)."""
        weights = np.zeros((2, len(self.names), len(shares)))
        for place, own in enumerate(shares):
            for name, share in own.items():
                if name[0] == self.channel:
                    by_speed = int(name.endswith(BY_SPEED))
                    weights[by_speed, self.names[name.removesuffix(BY_SPEED)], place] += share
        still, with_speed = weights
        found: Array = self.plain @ still
        return found + self.law * (self.plain @ with_speed) if with_speed.any() else found


def _of_a_force(effect: Effect) -> Columns:
    inner = effect.nonlinear

    def columns(view: View, base: Base, value: float) -> Mapping[str, Array]:
        parts: dict[str, list[Array]] = {}
        given = {inner.name: value} if inner is not None else {}
        for label in effect.typical:
            for channel, force in histories(effect, view, base, {label: 1.0, **given}).items():
                parts.setdefault(channel, []).append(view.project(force))
        return spread_over(view, parts, len(effect.coefficients))

    return columns


def histories(
    effect: Effect, view: View, base: Base, values: Mapping[str, float]
) -> dict[str, Array]:
    """Force of an effect of the catalogue along a view, its states as in steady oscillation.

    Parameters
    ----------
    effect : Effect
        With a force, a share of the mass matrix, or states of its own.
    view : View
        Motion.
    base : Base
        Ship, water, and the speed at which F is zero.
    values : mapping of str to float
        Parameters; coefficients that are not named are zero, other parameters at their default.

    Returns
    -------
    dict of channel to array (n,)
        [N, N m].
    """
    motion, ship, water = view.motion, base.ship, base.water
    there: dict[str, Any] = {
        "u": motion.u,
        "v": motion.v,
        "r": motion.r,
        "p": motion.p,
        "phi": motion.phi,
        "delta": motion.delta,
        "n": motion.rps,
        "U": motion.speed,
        "beta": np.arctan2(-motion.v, motion.u),
        "sinkage": motion.sinkage,
        "trim": motion.trim,
        "L": ship.L,
        "B": ship.B,
        "d": ship.d,
        "mass": ship.mass,
        "volume": ship.volume,
        "rho": water.rho,
        "g": water.g,
        "Fn": ship.froude(view.speed, water.g),
        "Fn0": ship.froude(base.reference, water.g),
        **dict.fromkeys(effect.states, 0.0),
        **dict.fromkeys(effect.options, 0),
    }
    for item in effect.parameters:
        if item.name in values:
            there[item.name] = values[item.name]
            if item.form:
                there[item.form[0]] = effect.options[item.form[0]].index(item.form[1])
        elif item.name not in there:
            there[item.name] = (0.0, 0.0) if item.table else item.default or 0.0

    def outputs(**states: Any) -> dict[str, Array]:
        asked = {name: (there | states)[name] for name in arguments_of(effect)}
        found = over_arrays(effect.force)(**asked) if effect.force else ()
        return dict(zip(effect.outputs, found, strict=True))

    found = outputs(**_settled(effect, view, outputs)) if effect.states else outputs()
    forces: dict[str, Array] = {}
    for output, force in found.items():
        if output in CHANNELS:
            forces[output] = force
        elif output.endswith("dot"):
            forces[output[0]] = force * getattr(motion, output[1:])
    return forces


def _settled(
    effect: Effect, view: View, outputs: Callable[..., Mapping[str, Array]]
) -> dict[str, Array]:
    """States of an effect as they follow the motion once the start is forgotten.

    The rate of a state must be linear in it, ds/dt = b - a s: it then follows b/a with a lag 1/a,
    harmonic by harmonic. Where the motion is steady, it has arrived.
    """
    settled: dict[str, Array] = {}
    for state in effect.states:
        none = dict.fromkeys(effect.states, 0.0) | settled
        at_rest = outputs(**none)[f"{state}_rate"]
        per_unit = at_rest - outputs(**(none | {state: 1.0}))[f"{state}_rate"]
        follows = at_rest / per_unit
        if not view.omega:
            settled[state] = follows
            continue
        lag = 1.0 / float(np.mean(per_unit))
        harmonics = view.harmonics(follows)
        settled[state] = view.basis @ filtered(harmonics, _one_pole(view.omega * lag))
    return settled


def _one_pole(angle: float) -> Callable[[int], complex]:
    """What a lag leaves of the n-th harmonic; the angle is that of the first, ω T."""
    return lambda n: 1.0 / (1.0 + 1j * n * angle)
