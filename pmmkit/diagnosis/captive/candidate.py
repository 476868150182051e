"""What takes part in a diagnosis: an effect or a fault as columns over all runs and channels."""

from __future__ import annotations

from collections.abc import Callable, Container, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, Final, Literal

import numpy as np

from pmmkit.base import Problem, Remedy, UnknownNameError, Way, did_you_mean
from pmmkit.conventions import parse_derivative
from pmmkit.diagnosis.captive.base import MOTION, CaptiveBase, Columns
from pmmkit.effects import BY_SPEED, Effect
from pmmkit.numerics import Array
from pmmkit.reduction import RunViews, View

# What an effect of the catalogue does to a captive run: harmonics per unit of each coefficient.


CHANNELS: Final = ("X", "Y", "N")
Terms = Sequence[Mapping[str, float]]
"""Derivatives that each coefficient stands for, with its share of them."""


def columns_of(effect: Effect) -> Columns:
    """The columns of an effect, by its kind."""
    if effect.acts is not None:
        return _of_a_fault(effect)
    terms = terms_of(effect)
    return of_terms(terms) if terms else _of_a_force(effect)


def terms_of(effect: Effect) -> Terms:
    """Derivatives that the coefficients of an effect stand for; none where it is no such effect."""
    if effect.acts is not None or effect.kind != "terms":
        return ()
    return tuple(effect.derivatives_of(name) for name in effect.typical)


def _of_a_fault(effect: Effect) -> Columns:
    inner, names = effect.nonlinear, list(effect.typical)

    def columns(
        views: Sequence[View], base: CaptiveBase, value: float
    ) -> Sequence[Mapping[str, Array]]:
        at = {inner.name: value} if inner is not None else {}
        found: dict[int, Mapping[str, Array]] = {}
        for numbers in _alike(views):
            begin = 0
            for runs in RunViews.stretches([views[i] for i in numbers], base):
                slopes = effect.slopes(runs, at, names)
                whole = {name: np.stack(own, axis=1) for name, own in slopes.items()}
                for i, view, rows in zip(numbers[begin:], runs.views, runs.rows, strict=False):
                    found[i] = {name: x[rows] for name, x in whole.items() if name in view.force}
                begin += len(runs.views)
        return [found[i] for i in range(len(views))]

    return columns


def _alike(views: Sequence[View]) -> Iterable[list[int]]:
    """Places of the views with equal numbers of harmonics, and steady as each other or not."""
    kinds: dict[tuple[int, bool], list[int]] = {}
    for i, view in enumerate(views):
        kinds.setdefault((len(view.whole), view.omega > 0.0), []).append(i)
    return kinds.values()


def of_terms(shares: Terms) -> Columns:
    """Columns of coefficients that stand for derivatives, each with its share of them.

    A derivative with the mark of the speed is multiplied by F at the speed of the run.
    """

    def columns(
        views: Sequence[View], base: CaptiveBase, value: float
    ) -> Sequence[Mapping[str, Array]]:
        del value
        edges = np.cumsum([view.rows for view in views])[:-1]
        made = {
            name: np.split(of_derivatives([shares], name, views, base)[0], edges)
            for name in channels_of_terms([shares])
        }
        return [
            {name: own[i] for name, own in made.items() if name in view.force}
            for i, view in enumerate(views)
        ]

    return columns


def channels_of_terms(every: Sequence[Terms]) -> tuple[str, ...]:
    """Channels that derivatives act in."""
    return tuple(dict.fromkeys(name[0] for shares in every for own in shares for name in own))


def of_derivatives(
    every: Sequence[Terms], channel: str, views: Sequence[View], base: CaptiveBase
) -> list[Array]:
    """Columns (n, q) in one channel of coefficients that stand for derivatives, the views one below
    the other: what each derivative multiplies is looked at once for all of `every`."""
    named = (name for shares in every for own in shares for name in own if name[0] == channel)
    names = list(dict.fromkeys(name.removesuffix(BY_SPEED) for name in named))
    law = np.repeat([base.law(view.speed) for view in views], [view.rows for view in views])
    place = {name: k for k, name in enumerate(names)}
    plain = base.design(names, views)
    columns = []
    for shares in every:
        weights = np.zeros((2, len(names), len(shares)))
        for k, own in enumerate(shares):
            for name, share in own.items():
                if name[0] == channel:
                    by_speed = int(name.endswith(BY_SPEED))
                    weights[by_speed, place[name.removesuffix(BY_SPEED)], k] += share
        still, with_speed = weights
        made: Array = plain @ still
        if with_speed.any():
            made = made + law[:, None] * (plain @ with_speed)
        columns.append(made)
    return columns


def _of_a_force(effect: Effect) -> Columns:
    """Columns of an effect with a force, a share of the mass matrix, or states of its own."""
    inner = effect.nonlinear

    def columns(
        views: Sequence[View], base: CaptiveBase, value: float
    ) -> Sequence[Mapping[str, Array]]:
        given = {inner.name: value} if inner is not None else {}
        asked = [{label: 1.0, **given} for label in effect.typical]
        return [
            found
            for runs in RunViews.stretches(views, base)
            for found in _projected(runs, histories(effect, runs, base, asked))
        ]

    return columns


def _projected(runs: RunViews, forces: Sequence[Mapping[str, Array]]) -> list[Mapping[str, Array]]:
    """Columns by channel of each view, from the forces per unit of each coefficient."""
    count, channels = len(forces), list(forces[0])
    whole = np.stack([harmonics[name] for name in channels for harmonics in forces], axis=1)
    by_view: list[Mapping[str, Array]] = []
    for view, samples in zip(runs.views, runs.samples, strict=True):
        harmonics = view.project(whole[samples])
        by_view.append(
            {
                name: harmonics[:, place * count : (place + 1) * count]
                for place, name in enumerate(channels)
                if name in view.force
            }
        )
    return by_view


def histories(
    effect: Effect, runs: RunViews, base: CaptiveBase, asked: Sequence[Mapping[str, float]]
) -> list[dict[str, Array]]:
    """Force of an effect of the catalogue along views, its states as in steady oscillation."""
    ship, water = base.ship, base.water
    names = effect.arguments
    there: dict[str, Any] = {
        "L": ship.L,
        "B": ship.B,
        "d": ship.d,
        "mass": ship.mass,
        "volume": ship.volume,
        "rho": water.rho,
        "g": water.g,
        "Fn0": ship.froude(base.reference, water.g),
        **dict.fromkeys(effect.states, 0.0),
        **dict.fromkeys(effect.options, 0),
    }
    if "Fn" in names:
        there["Fn"] = runs.each([ship.froude(view.speed, water.g) for view in runs.views])
    there |= {name: of(runs) for name, of in MOTION.items() if name in names}
    force = effect.force_over_arrays if effect.force else None
    forces = []
    for values in asked:
        own = there | _parameters(effect, values, {*there, *MOTION})

        def outputs(states: Mapping[str, Any], own: Mapping[str, Any] = own) -> dict[str, Array]:
            given = {name: states[name] if name in states else own[name] for name in names}
            made = force(**given) if force else ()
            return dict(zip(effect.outputs, made, strict=True))

        settled = _settled(effect, runs, outputs) if effect.states else {}
        forces.append(_forces(runs, outputs(settled)))
    return forces


def _parameters(
    effect: Effect, values: Mapping[str, float], known: Container[str]
) -> dict[str, Any]:
    """Parameters as given or at their default, and the options that they need."""
    given: dict[str, Any] = {}
    for item in effect.parameters:
        if item.name in values:
            given[item.name] = values[item.name]
            if item.form:
                given[item.form[0]] = effect.options[item.form[0]].index(item.form[1])
        elif item.name not in known:
            given[item.name] = (0.0, 0.0) if item.table else item.default or 0.0
    return given


def _forces(runs: RunViews, outputs: Mapping[str, Array]) -> dict[str, Array]:
    """Forces by channel; a share of the mass matrix is multiplied by its acceleration."""
    forces: dict[str, Array] = {}
    for output, force in outputs.items():
        if output in CHANNELS:
            forces[output] = np.broadcast_to(force, (runs.size,))
        elif output.endswith("dot"):
            forces[output[0]] = force * runs.history(output[1:])
    return forces


def _settled(
    effect: Effect, runs: RunViews, outputs: Callable[..., Mapping[str, Array]]
) -> dict[str, Array]:
    """States of an effect as they follow the motion once the start is forgotten.

    The rate of a state must be linear in it, ds/dt = b - a s: it then follows b/a with a lag 1/a,
    harmonic by harmonic. Where the motion is steady, it has arrived.
    """
    settled: dict[str, Array] = {}
    for state in effect.states:
        none = dict.fromkeys(effect.states, 0.0) | settled
        at_rest = outputs(none)[f"{state}_rate"]
        per_unit = at_rest - outputs(none | {state: 1.0})[f"{state}_rate"]
        follows = np.broadcast_to(at_rest / per_unit, (runs.size,))
        rates = runs.means(np.broadcast_to(per_unit, (runs.size,)))
        settled[state] = runs.lagging(follows, rates)
    return settled


LARGE: Final = 5
"""Coefficients from which the linear ones of an effect also compete alone."""


@dataclass(frozen=True, kw_only=True)
class Candidate:
    """One effect, or one fault of the measurement.

    `name, family`: name in the catalogue; family by which an answer is given first. `kind`:
    whether it is the ship and the water, or the measurement. `summary`: one sentence for
    people. `coefficients`: what is fitted: derivatives, or the size of a fault with its unit.
    `typical`: their usual sizes, signed where nature has a sign. `columns`: from views, the
    base and a grid value to harmonics per unit coefficient in each view; channels without force
    are left out. `grid`: values of a nonlinear parameter; one without meaning where there is none.
    `parameter`: what the grid is, with unit. `continuous`: whether values between those of the
    grid have a meaning. `centre`: values about which coefficients are expected; zeros where
    absent. `each_run`: whether each run and channel draws a size of its own. `check`: a check
    at the bench or a run that shows it, in words. `excites`: what a campaign must hold:
    ``several speeds``, ``roll``, ``rudder`` …. `linear`: places of the coefficients that are
    linear in the motion, of an effect with many others. `partial`: whether it is only these.
    `terms`: derivatives that each coefficient stands for, with its share of them, where
    `columns` are those: of many such candidates they are made together.
    """

    name: str
    family: str
    kind: Literal["physics", "fault"]
    summary: str
    coefficients: tuple[str, ...]
    typical: tuple[float, ...]
    columns: Columns
    grid: tuple[float, ...] = (0.0,)
    parameter: str = ""
    continuous: bool = False
    centre: tuple[float, ...] = ()
    each_run: bool = False
    check: str = ""
    excites: tuple[str, ...] = field(default=())
    linear: tuple[int, ...] = ()
    partial: bool = False
    terms: Terms = ()

    @property
    def size(self) -> int:
        """Number of coefficients."""
        return len(self.coefficients)

    @property
    def forms(self) -> tuple[Candidate, ...]:
        """The candidate, and its linear terms alone: many terms that are not needed cost it much
        of its evidence."""
        if not self.linear:
            return (self,)
        places, columns = list(self.linear), self.columns

        def linear(
            views: Sequence[View], base: CaptiveBase, value: float
        ) -> Sequence[Mapping[str, Array]]:
            return [
                {name: own[:, places] for name, own in found.items()}
                for found in columns(views, base, value)
            ]

        part = replace(
            self,
            coefficients=tuple(self.coefficients[k] for k in places),
            typical=tuple(self.typical[k] for k in places),
            centre=tuple(self.centre[k] for k in places) if self.centre else (),
            columns=linear,
            linear=(),
            partial=True,
            terms=tuple(self.terms[k] for k in places) if self.terms else (),
        )
        return (self, part)


def candidate_of(effect: Effect, speeds: Sequence[float] = ()) -> Candidate:
    """An effect as captive tests are asked for it.

    Parameters
    ----------
    effect : Effect
        With coefficients.
    speeds : sequence of float
        Of the tests [m/s], where its grid is theirs.

    Examples
    --------
    >>> from pmmkit.effects import CATALOGUE
    >>> candidate_of(CATALOGUE["memory"]).coefficients
    ('Yv_late', 'Nv_late')
    """
    inner, sizes = effect.nonlinear, effect.coefficients
    expected = tuple(item.expected for item in sizes)
    grid: tuple[float, ...] = (0.0,)
    if inner is not None:
        grid = tuple(speeds) if inner.of_the_tests else inner.grid
    return Candidate(
        name=effect.name,
        family=effect.family.replace("_", " "),
        kind="fault" if effect.faulty else "physics",
        summary=effect.summary,
        coefficients=tuple(
            f"{item.name} [{item.unit}]" if effect.faulty else item.name for item in sizes
        ),
        typical=tuple(effect.typical.values()),
        columns=columns_of(effect),
        grid=grid,
        parameter=inner.text if inner is not None else "",
        continuous=inner is not None and inner.continuous,
        centre=expected if any(expected) else (),
        each_run=effect.each_run,
        check=effect.check,
        excites=effect.excites,
        linear=_linear(effect),
        terms=terms_of(effect),
    )


def _linear(effect: Effect) -> tuple[int, ...]:
    """Places of the coefficients that stand for derivatives of first order, of a large effect."""
    if effect.kind != "terms" or len(effect.typical) < LARGE:
        return ()
    orders = [
        max(
            len(parse_derivative(name.removesuffix(BY_SPEED)).factors)
            for name in effect.derivatives_of(label)
        )
        for label in effect.typical
    ]
    places = tuple(place for place, order in enumerate(orders) if order == 1)
    return places if len(places) < len(orders) else ()


def no_such_effect(name: str, known: Iterable[str]) -> UnknownNameError:
    """The error that names the effects that take part: those that share a word, else all."""
    listed = list(dict.fromkeys(known))
    words = set(name.lower().split("_"))
    near = [item for item in listed if words & set(item.split("_"))]
    if near:
        said = f"; did you mean {' or '.join(map(repr, near))}?"
    else:
        said = f"{did_you_mean(name, listed) or '.'} These do: {', '.join(listed)}."
    return UnknownNameError(
        Problem(
            message=f"No effect {name!r} takes part here{said}",
            remedy=Remedy(
                "{} has the whole catalogue.",
                (Way("pmmkit.effects.entries.catalogue()", "pmmkit effects"),),
            ),
        )
    )
