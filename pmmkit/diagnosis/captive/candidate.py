"""What takes part in a diagnosis: an effect or a fault as columns over all runs and channels."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Final, Literal

from pmmkit.base import Problem, Remedy, UnknownNameError, Way, did_you_mean
from pmmkit.conventions import parse_derivative
from pmmkit.diagnosis.captive.base import CaptiveBase
from pmmkit.diagnosis.captive.columns import (
    Columns,
    Terms,
    Together,
    columns_of,
    of_terms,
    terms_of,
    together_of,
)
from pmmkit.effects import BY_SPEED, Effect
from pmmkit.numerics import Array
from pmmkit.reduction import View

LARGE: Final = 5
"""Coefficients from which the linear ones of an effect also compete alone."""


@dataclass(frozen=True, kw_only=True)
class Candidate:
    """One effect, or one fault of the measurement.

    `name, family`: name in the catalogue; family by which an answer is given first. `kind`:
    whether it is the ship and the water, or the measurement. `summary`: one sentence for
    people. `coefficients`: what is fitted: derivatives, or the size of a fault with its unit.
    `typical`: their usual sizes, signed where nature has a sign. `columns`: from a view, the
    base and a grid value to harmonics per unit coefficient; channels without force are left
    out. `grid`: values of a nonlinear parameter; one without meaning where there is none.
    `parameter`: what the grid is, with unit. `continuous`: whether values between those of the
    grid have a meaning. `centre`: values about which coefficients are expected; zeros where
    absent. `each_run`: whether each run and channel draws a size of its own. `check`: a check
    at the bench or a run that shows it, in words. `excites`: what a campaign must hold:
    ``several speeds``, ``roll``, ``rudder`` …. `linear`: places of the coefficients that are
    linear in the motion, of an effect with many others. `partial`: whether it is only these.
    `terms`: derivatives that each coefficient stands for, with its share of them, where
    `columns` are those: of many such candidates they are made together. `together`: `columns`
    of several views at once, where that is faster.
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
    together: Together | None = None

    def along(
        self, views: Sequence[View], base: CaptiveBase, value: float
    ) -> Sequence[Mapping[str, Array]]:
        """Columns in several views."""
        if self.together is not None:
            return self.together(views, base, value)
        return [self.columns(view, base, value) for view in views]

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

        def linear(view: View, base: CaptiveBase, value: float) -> Mapping[str, Array]:
            return {name: own[:, places] for name, own in columns(view, base, value).items()}

        part = replace(
            self,
            coefficients=tuple(self.coefficients[k] for k in places),
            typical=tuple(self.typical[k] for k in places),
            centre=tuple(self.centre[k] for k in places) if self.centre else (),
            columns=linear,
            together=None,
            linear=(),
            partial=True,
            terms=tuple(self.terms[k] for k in places) if self.terms else (),
        )
        return (self, part)


def polynomial(
    name: str,
    family: str,
    summary: str,
    sizes: Mapping[str, float],
    *,
    check: str = "",
    excites: tuple[str, ...] = (),
) -> Candidate:
    """An effect whose forces are derivatives that the base does not have.

    Examples
    --------
    >>> polynomial("sway_drag", "hull", "Drag of sway.", {"Yv|v|": -0.02}).coefficients
    ('Yv|v|',)
    """
    terms = tuple({label: 1.0} for label in sizes)
    return Candidate(
        name=name,
        family=family,
        kind="physics",
        summary=summary,
        coefficients=tuple(sizes),
        typical=tuple(sizes.values()),
        columns=of_terms(terms),
        terms=terms,
        check=check,
        excites=excites,
    )


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
        together=together_of(effect),
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
