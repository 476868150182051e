"""A model whose manoeuvres come out as on a card: the estimate, moved as little as it allows.

With x = x(z) the values of the estimate, z ~ N(0, 1) its errors by their covariance, y the measures
of the card, f(x) those of the simulation and R their covariance, z is where
``|z|² + (y - f)ᵀ R⁻¹ (y - f)`` is least (maximum a posteriori), found by Gauss-Newton steps.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar, Final

import numpy as np

from pmmkit.base import DataError, ModelError, Problem, Progress, Remedy, SimulationError, Way
from pmmkit.cards.card import Card, CardMeasure, CardTest, poster, read_card, tolerance
from pmmkit.conventions import Metric
from pmmkit.identification import Prior
from pmmkit.inference import Normal, std_along
from pmmkit.models import Model, estimated_model, hull_less_model, load_model
from pmmkit.numerics import Array
from pmmkit.presentation import (
    WIDE,
    Described,
    Grid,
    Group,
    Section,
    counted,
    fixed,
    listed,
    number,
)
from pmmkit.simulation import Sensitivities, Spread, monte_carlo, sensitivities

if TYPE_CHECKING:
    import pandas as pd

    from pmmkit.plotting import Figure

STEPS: Final = 20
"""Gauss-Newton steps; cards of ten ships took two to seven."""
SETTLED: Final = 1e-3
"""Fall of the sum of squares from which nothing changes any more."""
SHORTEST: Final = 1 / 64
"""Share of a step below which no shorter one is tried."""
STARTS: Final = 30
"""Ships drawn from the estimate until one makes all manoeuvres of the card."""
MISSED: Final = 2.0
"""Standard deviations of a measure from which it is missed."""
UNTOLD: Final = 0.9
"""A standard deviation above this share of the estimate's: the card says nothing of a value, as
records of which identification says the same."""
TOGETHER: Final = 0.5
"""Correlation from which two values are known only together."""
TOLD_OF: Final = 3
"""Values that are named of which a measure would tell."""
WORTH: Final = 0.01
"""Share of a variance from which a measure is named that would take it away."""
CURVED: Final = 0.3
"""Share by which the spread of ships may differ from that to first order: 200 of them tell their
own to 0.1."""


@dataclass(frozen=True, kw_only=True)
class MetMeasure:
    """A measure of the card beside what the ship does.

    `words`: it with its manoeuvre. `card`: what the card says. `before, after`: by the estimate,
    and by the model [its unit]. `std`: tolerance, with what an assumed engine adds.
    """

    test: CardTest
    card: CardMeasure
    before: float
    after: float
    std: float
    words: str

    @property
    def missed(self) -> float:
        """Card less model, in standard deviations."""
        return (self.card.value - self.after) / self.std


@dataclass(frozen=True, kw_only=True)
class ForetoldMeasure:
    """A measure that is not on the card, with its 95 % interval.

    `words`: it with its manoeuvre. `value`: of the model. `low, high; low_before, high_before`: by
    ships drawn from what is known with the card, and from the estimate alone. `straight, std`:
    standard deviation to first order, and of the ships. `tells`: share of the variance of all such
    measures that it would take away if it were known. `of`: values of which it would tell most.
    """

    test: CardTest
    name: str
    value: float
    low: float
    high: float
    low_before: float
    high_before: float
    straight: float
    std: float
    words: str
    tells: float = 0.0
    of: tuple[str, ...] = ()

    @property
    def curved(self) -> bool:
        """Whether the first order is wrong of it."""
        return abs(self.straight - self.std) > CURVED * self.std


@dataclass(frozen=True, kw_only=True, eq=False, repr=False)
class CardFit(Described):
    """A ship from her card.

    Parameters
    ----------
    card : Card
        What was known.
    model : Model
        The ship: values that were moved, with their covariance.
    before : Model
        The estimate, or the model from which it was moved.
    met : tuple of MetMeasure
        The measures of the card.
    foretold : tuple of ForetoldMeasure
        Those of the poster that are not on the card.
    names : tuple of str
        The values that move.
    shrunk : array (m,)
        Their standard deviations over those before.
    correlation : array (m, m)
        Of the values by the card.
    told : float
        How many independent things the card tells (degrees of freedom).
    misfit : float
        The least sum of squares; as many as there are measures are expected.
    """

    MODEL: ClassVar[str] = "model.toml"

    card: Card
    model: Model
    before: Model
    met: tuple[MetMeasure, ...]
    foretold: tuple[ForetoldMeasure, ...]
    names: tuple[str, ...]
    shrunk: Array
    correlation: Array
    told: float
    misfit: float

    @property
    def widened(self) -> float:
        """By what standard deviations grew for the misfit (Birge 1932), to those before at most."""
        return widening(self.misfit, len(self.met))

    @property
    def untold(self) -> tuple[str, ...]:
        """Values of which the card says nothing."""
        pairs = zip(self.names, self.shrunk.tolist(), strict=True)
        return tuple(name for name, ratio in pairs if ratio > UNTOLD)

    @property
    def missed(self) -> tuple[MetMeasure, ...]:
        """Measures of the card that she does not come to."""
        return tuple(item for item in self.met if abs(item.missed) > MISSED)

    def pairs(self) -> list[tuple[str, str, float]]:
        """Values that are known only together, the closest first."""
        found = [
            (one, self.names[j], float(self.correlation[i, j]))
            for i, one in enumerate(self.names)
            for j in range(i)
            if abs(self.correlation[i, j]) > TOGETHER
        ]
        return sorted(found, key=lambda item: -abs(item[2]))

    def completed(self) -> Card:
        """The card with all that a poster shows: the measures it had, and those foretold."""
        tests = list(self.card.tests)
        for item in self.foretold:
            half = 0.5 * (item.high - item.low)
            if not half > 0.0:
                continue
            told = CardMeasure(name=item.name, value=0.5 * (item.high + item.low), std=half / WIDE)
            at = next((i for i, test in enumerate(tests) if test.same(item.test)), None)
            if at is None:
                tests.append(replace(item.test, measures=(told,)))
            else:
                tests[at] = replace(tests[at], measures=(*tests[at].measures, told))
        return replace(self.card, tests=tuple(tests))

    def warnings(self) -> list[str]:
        """What a user must know before she is used."""
        said = []
        for item in self.missed:
            said.append(
                f"{item.words} is {item.card.written} on the card; such a ship comes to "
                f"{number(item.after, 3)}, {abs(item.missed):.1f} standard deviations off."
            )
        if self.widened > 1.0 and self.missed:
            said.append(
                f"The card and the estimate contradict one another: what the card tells is held "
                f"for {self.widened:.2g} times as uncertain. Look at side, speed, loading and "
                f"units of what is missed, and at the particulars."
            )
        curved = [item for item in self.foretold if item.curved]
        if curved:
            worst = max(curved, key=lambda item: abs(item.straight - item.std) / item.std)
            said.append(
                f"{len(curved)} of {len(self.foretold)} measures that are not on the card are no "
                f"straight line over the values (most of all {worst.words}): their intervals, of "
                f"ships that were sailed, are rough."
            )
        return [*said, *self.model.notes]

    def to_pandas(self) -> pd.DataFrame:
        """A row a measure: on the card or not, value, interval, before."""
        import pandas as pd

        rows: list[dict[str, Any]] = [
            {
                "manoeuvre": item.test.words,
                "measure": item.card.name,
                "unit": item.card.unit,
                "card": item.card.value,
                "card_std": item.std,
                "value": item.after,
                "missed": item.missed,
                "estimate": item.before,
            }
            for item in self.met
        ]
        rows += [
            {
                "manoeuvre": item.test.words,
                "measure": item.name,
                "unit": Metric.of(item.name).unit_of(item.name),
                "value": item.value,
                "low": item.low,
                "high": item.high,
                "estimate_low": item.low_before,
                "estimate_high": item.high_before,
                "tells": item.tells,
            }
            for item in self.foretold
        ]
        return pd.DataFrame(rows)

    def values(self) -> pd.DataFrame:
        """A row a value: before and after, its standard deviation, and that over the former one."""
        import pandas as pd

        before, after = _by_name(self.before), _by_name(self.model)
        rows = {
            "before": [before[name] for name in self.names],
            "value": [after[name] for name in self.names],
            "std": [self.model.std[name][0] for name in self.names],
            "std_over_before": self.shrunk,
        }
        return pd.DataFrame(rows, index=pd.Index(self.names, name="name"))

    def plot(self) -> Figure:
        """Intervals of 95 % before and after, over what the ship does, a row a measure."""
        from pmmkit.cards.figures import measures

        none = [math.nan, math.nan]
        met = [[*none, *none, *item.card.interval] for item in self.met]
        rest = [
            [item.low_before, item.high_before, item.low, item.high, *none]
            for item in self.foretold
        ]
        ship = [*(item.after for item in self.met), *(item.value for item in self.foretold)]
        over = np.array([*met, *rest]) / np.array(ship)[:, None] - 1.0
        words = [*(item.words for item in self.met), *(item.words for item in self.foretold)]
        return measures(words, over)

    def _headline(self) -> str:
        return (
            f"{self.model.name} from her card: {counted(len(self.met), 'measure')} "
            f"{'tell' if len(self.met) != 1 else 'tells'} {self.told:.1f} of "
            f"{len(self.names)} directions, {len(self.missed)} missed"
        )

    def _sections(self) -> Sequence[Section]:
        met = [
            [
                item.words,
                item.card.written,
                number(item.before, 3),
                number(item.after, 3),
                fixed(item.missed, 1, signed=True),
            ]
            for item in self.met
        ]
        foretold = [
            [
                item.words,
                number(item.value, 3),
                _interval(item.low, item.high),
                _interval(item.low_before, item.high_before),
                Metric.of(item.name).unit_of(item.name).replace("-", ""),
            ]
            for item in self.foretold
        ]
        head = ["", "ship", "95 % interval", "before the card", ""]
        rest = Grid(head=head, groups=[Group(rows=foretold)])
        return [
            Section(
                title="On the card",
                tables=[
                    Grid(
                        head=["", "card", "before", "ship", "missed"],
                        groups=[Group(rows=met)],
                        caption="missed: card less ship, in standard deviations",
                    )
                ],
            ),
            *([Section(title="Not on the card", tables=[rest])] if foretold else []),
            Section(title="What the card cannot tell", points=self._cannot()),
            *([Section(title="Warnings", points=said)] if (said := self.warnings()) else []),
        ]

    def _cannot(self) -> list[str]:
        """In sentences: values, pairs, engine, and what would tell."""
        said = []
        if self.untold:
            said.append(
                f"It says nothing of {len(self.untold)} of {len(self.names)} values, which keep "
                f"what was known before: {_by_part(self.untold)}."
            )
        order = np.argsort(self.shrunk, kind="stable")
        told = [f"{self.names[i]} ({self.shrunk[i]:.2f})" for i in order[:TOLD_OF]]
        said.append(f"It tells most of {listed(told)}: standard deviations over those before.")
        for one, other, size in self.pairs()[:TOLD_OF]:
            way = "rise together" if size > 0 else "make up for each other"
            said.append(f"{one} and {other} are known together alone: they {way} (ρ {size:+.2f}).")
        if any(item.std > 2.0 * item.card.std for item in self.met):
            said.append(
                "A stop tells little as long as nobody states the engine: write turns and "
                "reversal_s, or torque, under [[stopping]]."
            )
        best = sorted(self.foretold, key=lambda item: -item.tells)[:TOLD_OF]
        said += [
            f"{item.words}, if it were known, would take away {100 * item.tells:.0f} % of the "
            f"variance of the others here, by what it says of {listed(item.of)}."
            for item in best
            if item.tells > WORTH
        ]
        return said


def _by_part(names: Sequence[str]) -> str:
    """Names in groups: derivatives, and values of each part."""
    groups: dict[str, list[str]] = {}
    for name in names:
        part, _, own = name.rpartition(".")
        groups.setdefault(part or "derivatives", []).append(own)
    return "; ".join(f"{part}: {', '.join(own)}" for part, own in groups.items())


def _interval(low: float, high: float) -> str:
    return f"{number(low, 3)} to {number(high, 3)}"


def widening(misfit: float, count: int) -> float:
    """The ratio of Birge: √(χ²/n) where that is above one.

    Examples
    --------
    >>> widening(3.0, 5), widening(20.0, 5)
    (1.0, 2.0)
    """
    return max(1.0, math.sqrt(misfit / count))


def estimate_of(card: Card) -> Model:
    """The estimate from the particulars of a card."""
    tested = hull_less_model(card.ship, card.water, card.propeller, card.rudder)
    made = estimated_model(
        card.ship,
        speed=card.speed,
        propeller_diameter=float(tested.values("propeller")["D"]),
        rudder_area=float(tested.values("rudder_mmg")["area"]),
        water=card.water,
    )
    return made.with_(parts={**made.parts, **tested.parts})


def ship_from_card(
    card: Card | str | Path,
    *,
    model: Model | str | Path | None = None,
    spread: float | None = None,
    ships: int = 200,
    seed: int = 0,
    progress: Progress | None = None,
) -> CardFit:
    """A model that manoeuvres as a card says, and intervals for what is not on the card.

    Parameters
    ----------
    card : Card, str or path
        A card or its file.
    model : Model, str or path, optional
        The model that is moved: a library ship, or one from captive tests, with a covariance or
        `spread`. By default the estimate from the particulars of the card.
    spread : float, optional
        Relative standard deviation of the derivatives of that model.
    ships : int
        Ships that are sailed for an interval.
    seed : int
        Of their draws.
    progress : Progress, optional
        Is told how far it is.

    Returns
    -------
    CardFit

    Raises
    ------
    DataError
        If the card cannot be read, or no ship like this makes its manoeuvres.

    Examples
    --------
    >>> from dataclasses import replace
    >>> full = Card.of("kvlcc2", 7.97)
    >>> found = ship_from_card(replace(full, tests=full.tests[:1]), ships=50)
    >>> len(found.met), found.missed
    (5, ())
    """
    known = card if isinstance(card, Card) else read_card(card)
    base = _base(known, model)
    search = _Search(card=known, base=base, spread=Spread.of(base, known.speed, spread))
    tell = progress or (lambda *_: None)
    rest = list(_absent(known, base))
    total = STEPS + len(rest)
    tell(0, total, "the estimate")
    at, first = search.start()
    for step in range(1, STEPS):
        tell(step, total, f"step {step} towards the card")
        nearer = search.nearer(at)
        if nearer is None:
            break
        at, fall = nearer, at.cost - nearer.cost
        if fall < SETTLED:
            break
    made, posterior = search.model(at)
    how = {"n": ships, "seed": seed}
    foretold: list[_Foretold] = []
    for place, test in enumerate(rest):
        tell(STEPS + place, total, f"{test.words}, {ships} ships")
        foretold += _foretold(test, search, made, at, how, spread)
    tell(total, total, "done")
    covariance, std = search.covariance(at.z, posterior), search.std(at.z, posterior)
    rows = (search.measures, first.tolist(), at.values.tolist(), at.std.tolist())
    return CardFit(
        card=known,
        model=made,
        before=base,
        met=tuple(
            MetMeasure(
                test=test,
                card=item,
                before=was,
                after=now,
                std=own,
                words=f"{test.told(known.speed)}: {item.title}",
            )
            for (test, item), was, now, own in zip(*rows, strict=True)
        ),
        foretold=tuple(_ranked(foretold, search, at, posterior)),
        names=search.spread.names,
        shrunk=search.shrunk(posterior),
        correlation=covariance / np.outer(std, std),
        told=float(len(at.z) - np.trace(posterior)),
        misfit=at.cost,
    )


def _base(card: Card, model: Model | str | Path | None) -> Model:
    """What is moved; her propeller astern is known or estimated, so that it may move too."""
    if model is None:
        base = estimate_of(card)
    else:
        base = model if isinstance(model, Model) else load_model(model)
    if base.Fn:
        raise ModelError(
            Problem(
                message=f"Model {base.name!r} has values for {counted(len(base.Fn), 'speed')}; a "
                f"card moves one set for all.",
                remedy=Remedy("{}", (Way('Reduce with fn="pooled".', "Reduce with --fn pooled."),)),
            )
        )
    return base.as_it_stops() or base


def _by_name(model: Model) -> dict[str, Any]:
    """All values of a model by one name each."""
    return {part.place(name): x for part in model.parts.values() for name, x in part.values.items()}


def _absent(card: Card, model: Model) -> Iterator[CardTest]:
    """The manoeuvres of a poster with those measures that a card does not have."""
    for test in poster(card.speed, model.steering.get("max_deg")):
        if test.manoeuvre == "stopping" and not model.knows_astern:
            continue
        stops = (own.settings for own in card.tests if own.manoeuvre == test.manoeuvre)
        if test.manoeuvre == "stopping":  # with the engine that the card states
            test = replace(test, settings=next(stops, test.settings))
        there = {x.name for own in card.tests if own.same(test) for x in own.measures}
        left = tuple(item for item in test.measures if item.name not in there)
        if left:
            yield replace(test, measures=left)


@dataclass(frozen=True, kw_only=True, eq=False)
class _Point:
    """One ship: errors z (q,), measures (n,), slopes (n, q) over z, covariance (n, n) of the
    measures with what nobody states of the engine, and the sum of squares."""

    z: Array
    values: Array
    slopes: Array
    noise: Array
    cost: float

    @property
    def std(self) -> Array:
        """Of the measures (n,)."""
        found: Array = np.sqrt(np.diagonal(self.noise))
        return found


@dataclass(frozen=True, kw_only=True, eq=False)
class _Search:
    """The card, and the ships among which one is looked for."""

    card: Card
    base: Model
    spread: Spread

    @property
    def measures(self) -> list[tuple[CardTest, CardMeasure]]:
        return [(test, item) for test in self.card.tests for item in test.measures]

    def covariance(self, z: Array, posterior: Array) -> Array:
        """Of the values (m, m) from that of the errors."""
        slopes = self.spread.slopes(z)
        found: Array = slopes @ posterior @ slopes.T
        return found

    def std(self, z: Array, posterior: Array) -> Array:
        return std_along(self.spread.slopes(z), posterior)

    def shrunk(self, posterior: Array) -> Array:
        """Standard deviations (m,) over those before; of what differs by factors those factors."""
        found: Array = std_along(self.spread.root, posterior) / self.spread.std
        return found

    def ship(self, z: Array, covariance: Array) -> Model:
        """The ship of some errors; its values have a covariance (m, m)."""
        values = self.spread.of_normal(z[None])[0]
        known = Prior(names=self.spread.names, mean=values, covariance=covariance)
        return known.carried_by(self.base, "moved to the manoeuvres of her card", measured=False)

    def at(self, z: Array) -> _Point | None:
        """The manoeuvres of a ship; None where she does not make one."""
        try:
            ship = self.ship(z, self.covariance(z, np.eye(len(z))))
            found = [
                sensitivities(ship, test.manoeuvre, speed=test.speed, **test.ordered)
                for test in self.card.tests
            ]
        except (ModelError, SimulationError):
            return None
        along = self.spread.slopes(z)
        values, slopes, engine = [], [], []
        for test, own in zip(self.card.tests, found, strict=True):
            for item in test.measures:
                values.append(own.nominal[item.name])
                slopes.append(_of_names(own, item.name, self.spread.names) @ along)
                engine.append(_of_others(own, item.name, self.spread.names))
        others = sorted({name for own in engine for name in own})
        sides = np.array([[own.get(name, 0.0) for name in others] for own in engine])
        noise = np.diag([item.std**2 for _, item in self.measures])
        if others:
            noise = noise + sides @ sides.T
        left = np.array([item.value for _, item in self.measures]) - np.array(values)
        if not (np.isfinite(left).all() and np.isfinite(slopes).all()):
            return None
        return _Point(
            z=z,
            values=np.array(values),
            slopes=np.array(slopes),
            noise=noise,
            cost=float(z @ z + left @ np.linalg.solve(noise, left)),
        )

    def start(self) -> tuple[_Point, Array]:
        """The estimate, or else a ship near it that makes all manoeuvres; measures of the former.

        A full ship by the estimate may never come back in a zigzag.
        """
        count = self.spread.root.shape[1]
        first = self.at(np.zeros(count))
        if first is not None:
            return first, first.values
        draws = np.random.default_rng(0).standard_normal((STARTS, count))
        near = (self.at(z) for z in draws)
        found = next((point for point in near if point is not None), None)
        if found is None:
            told = listed([test.words for test in self.card.tests])
            raise DataError(
                f"None of {STARTS} ships with these particulars makes all of {told}. Look at the "
                f"particulars and angles, or leave out manoeuvres one by one."
            )
        return found, np.full(len(found.values), math.nan)

    def known(self, point: _Point) -> Normal:
        """What the card says of the errors, its measures as straight lines over them."""
        root = np.linalg.cholesky(point.noise)
        left = np.array([item.value for _, item in self.measures]) - point.values
        rows = np.column_stack([point.slopes, left + point.slopes @ point.z])
        white = np.linalg.solve(root, rows)
        return Normal.of(white[:, :-1], white[:, -1])

    def nearer(self, point: _Point) -> _Point | None:
        """After a Gauss-Newton step, shortened until it comes nearer; None where none does."""
        away, share = self.known(point).mean - point.z, 1.0
        while share > SHORTEST:
            found = self.at(point.z + share * away)
            if found is not None and found.cost < point.cost:
                return found
            share *= 0.5
        return None

    def model(self, point: _Point) -> tuple[Model, Array]:
        """The ship with her covariance, and that of the errors (q, q)."""
        _, alone = self.known(point).posterior
        sizes, axes = np.linalg.eigh(alone)
        wide = widening(point.cost, len(point.values))
        posterior = (axes * np.minimum(wide**2 * sizes, 1.0)) @ axes.T
        return self.ship(point.z, self.covariance(point.z, posterior)), posterior


def _of_names(found: Sensitivities, measure: str, names: Sequence[str]) -> Array:
    """Slopes of a measure over names; none over what a manoeuvre does not have."""
    own = dict(zip(found.names, found.slopes[measure].tolist(), strict=True))
    return np.array([own.get(name, 0.0) for name in names])


def _of_others(found: Sensitivities, measure: str, names: Sequence[str]) -> Mapping[str, float]:
    """What one standard deviation of all else does to a measure: of an engine that nobody states,
    independent of one another."""
    assert found.covariance is not None
    std = np.sqrt(np.diagonal(found.covariance))
    own = zip(found.names, found.slopes[measure] * std, strict=True)
    return {name: float(x) for name, x in own if name not in names and x}


@dataclass(frozen=True, kw_only=True, eq=False)
class _Foretold:
    """A measure with its slopes (q,) over the errors and the variance of all else."""

    measure: ForetoldMeasure
    slopes: Array
    others: float


def _foretold(
    test: CardTest,
    search: _Search,
    made: Model,
    point: _Point,
    how: Mapping[str, Any],
    spread: float | None,
) -> Iterator[_Foretold]:
    """The measures of a manoeuvre that are not on the card."""
    asked = {"speed": test.speed, **test.ordered}
    found = sensitivities(made, test.manoeuvre, **asked)
    many = monte_carlo(made, test.manoeuvre, **asked, **how)
    before = monte_carlo(search.base, test.manoeuvre, spread=spread, **asked, **how)
    along = search.spread.slopes(point.z)
    for item in test.measures:
        name = item.name
        sailed = many.metrics[name][np.isfinite(many.metrics[name])]
        low, high = many.interval(name)
        low_before, high_before = before.interval(name)
        measure = ForetoldMeasure(
            test=test,
            name=name,
            value=many.nominal[name],
            low=low,
            high=high,
            low_before=low_before,
            high_before=high_before,
            straight=found.std(name),
            std=float(np.std(sailed)) if len(sailed) else math.nan,
            words=f"{test.told(search.card.speed)}: {item.title}",
        )
        others = _of_others(found, name, search.spread.names)
        slopes = _of_names(found, name, search.spread.names) @ along
        yield _Foretold(
            measure=measure, slopes=slopes, others=float(sum(x * x for x in others.values()))
        )


def _ranked(
    found: Sequence[_Foretold], search: _Search, point: _Point, posterior: Array
) -> Iterator[ForetoldMeasure]:
    """What each measure would tell of all others, and of which values."""
    slopes = np.nan_to_num(np.array([item.slopes for item in found]).reshape(-1, len(posterior)))
    common = slopes @ posterior @ slopes.T
    total = np.diagonal(common) + np.array([item.others for item in found])
    values = search.spread.slopes(point.z) @ posterior
    std = search.std(point.z, posterior)
    for place, item in enumerate(found):
        own = item.measure
        allowed = tolerance(own.name, own.value) ** 2 + total[place]
        if not math.isfinite(allowed):
            yield own
            continue
        shares = common[place] ** 2 / (allowed * np.where(total > 0.0, total, 1.0))
        gained = np.abs(values @ slopes[place]) / std
        most = np.argsort(-gained, kind="stable")[:TOLD_OF]
        yield replace(
            own,
            tells=float(np.mean(np.delete(shares, place))) if len(found) > 1 else 0.0,
            of=tuple(search.spread.names[i] for i in most),
        )
