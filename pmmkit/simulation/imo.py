"""Criteria of IMO resolution MSC.137(76): what each asks, and whether a ship meets it."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import groupby
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

from pmmkit.bibliography import cite
from pmmkit.effects.catalogue import catalogue
from pmmkit.errors import DataError
from pmmkit.metrics import (
    HARD_OVER,
    Criterion,
    Metric,
    criteria,
    first_overshoot_limit,
    second_overshoot_limit,
)
from pmmkit.models import Model, load_model
from pmmkit.presentation import ABSENT, Described, Grid, Group, Section
from pmmkit.simulation.manoeuvres.catalogue import manoeuvre_of
from pmmkit.simulation.simulate import simulate, steering
from pmmkit.simulation.track import Track

if TYPE_CHECKING:
    from pmmkit.simulation.ensemble import Ensemble

SOURCE: Final = cite("msc137")
SHORTEST: Final = 100.0
"""Length from which on the standard applies [m]."""
ASTERN: Final = (-0.6, -0.7, -0.8, -0.9, -1.0)
"""Revolutions astern over those of the approach, of which the track reach is told."""
LARGE: Final = "The administration may allow up to 20 L for ships of large displacement."


@dataclass(frozen=True, kw_only=True, repr=False)
class Verdict(Described):
    """One criterion applied to one manoeuvre.

    Parameters
    ----------
    criterion : str
        What is limited.
    limit, value : float
        In `unit`.
    margin : float
        Limit less value: positive where the criterion is met.
    passed : bool or None
        None where the track does not reach that far, or the criterion cannot be judged.
    conditions : tuple of str
        Conditions of the standard that this track does not meet, or does not show.
    scale : str
        At which scale and propulsion point the track is.
    unit : str
        ``L`` or ``deg``.
    manoeuvre : str
        In words, with the side.
    probability : float or None
        Share of ships drawn from the uncertainty of the model that meet it.
    """

    criterion: str
    limit: float
    value: float
    margin: float
    passed: bool | None
    conditions: tuple[str, ...]
    scale: str
    unit: str = "L"
    manoeuvre: str = ""
    probability: float | None = None

    @property
    def metric(self) -> str:
        """Name of the number that is judged."""
        return next(m.judged(item) for m, item in criteria() if item.name == self.criterion)

    def row(self) -> list[str]:
        """Criterion, manoeuvre, value, limit, margin, what follows, and how probable that is."""
        unit = " L" if self.unit == "L" else "°"
        return [
            self.criterion.replace("_", " "),
            self.manoeuvre,
            f"{self.value:.2f}{unit}" if math.isfinite(self.value) else ABSENT,
            f"{self.limit:.4g}{unit}",
            f"{self.margin:+.2f}" if math.isfinite(self.margin) else ABSENT,
            {True: "met", False: "NOT met", None: "not judged"}[self.passed],
            ABSENT if self.probability is None else f"{100 * self.probability:.1f} %",
        ]

    def _headline(self) -> str:
        criterion, manoeuvre, value, limit, _, word, _ = self.row()
        return f"{criterion}, {manoeuvre}: {value}, at most {limit}: {word}"

    def _sections(self) -> Sequence[Section]:
        return verdict_sections([self])


def verdict_sections(verdicts: Sequence[Verdict]) -> list[Section]:
    """Verdicts as a table, and the conditions that stand beside them.

    Parameters
    ----------
    verdicts : sequence of Verdict
        Of one ship.
    """
    head = ["criterion", "manoeuvre", "value", "limit", "margin", "", "probability"]
    rows = [item.row() for item in verdicts]
    scales = dict.fromkeys(f"Scale: {item.scale}" for item in verdicts if item.scale)
    said = dict.fromkeys(text for item in verdicts for text in item.conditions)
    return [
        Section(paragraphs=[f"Criteria of {SOURCE}", *scales]),
        Section(tables=[Grid(head=head, groups=[Group(rows=rows)], texts=(1,))]),
        *([Section(title="Conditions", points=list(said))] if said else []),
    ]


def judge(
    metric: Metric,
    criterion: Criterion,
    metrics: Mapping[str, float],
    *,
    L: float,
    speed: float,
    manoeuvre: str,
    scale: str,
    conditions: tuple[str, ...] = (),
) -> Verdict:
    """A criterion applied to the numbers of a manoeuvre.

    Parameters
    ----------
    metric, criterion : Metric, Criterion
        What is asked of what.
    metrics : mapping of str to float
        Numbers of the manoeuvre.
    L, speed : float
        Ship length [m], test speed [m/s].
    manoeuvre, scale, conditions
        As in `Verdict`.
    """
    limit = criterion.limit_for(L, speed)
    value = metrics.get(metric.judged(criterion), math.nan)
    return Verdict(
        criterion=criterion.name,
        limit=limit,
        value=value,
        margin=limit - value,
        passed=None if math.isnan(value) else value <= limit,
        conditions=conditions,
        scale=scale,
        unit="L" if metric.length else metric.unit,
        manoeuvre=manoeuvre,
    )


def zigzag_limits(L: float, speed: float) -> tuple[float, float]:
    """Limits of the first and the second overshoot of a 10/10 zigzag [deg].

    Parameters
    ----------
    L : float
        Ship length [m].
    speed : float
        Test speed [m/s].

    Examples
    --------
    >>> zigzag_limits(175.0, 17.6), zigzag_limits(200.0, 10.0), zigzag_limits(320.0, 7.97)
    ((10.0, 25.0), (15.0, 32.5), (20.0, 40.0))
    """
    time = L / speed
    return first_overshoot_limit(time), second_overshoot_limit(time)


def imo_turning(track: Track) -> list[Verdict]:
    """Turning ability: advance at most 4.5 L, tactical diameter at most 5 L.

    Parameters
    ----------
    track : Track
        A turning circle.

    Returns
    -------
    list of Verdict
        With the conditions of the standard that the track does not meet or does not show.

    Raises
    ------
    DataError
        If the track is no turning circle.

    References
    ----------
    IMO resolution MSC.137(76), Standards for ship manoeuvrability, 2002.

    Examples
    --------
    >>> from pmmkit.simulation import simulate
    >>> [(v.criterion, v.limit, v.passed) for v in imo_turning(simulate("s175", speed=9.0))]
    [('advance', 4.5, True), ('tactical_diameter', 5.0, True)]
    """
    if track.manoeuvre != "turning":
        raise DataError(f"The criteria are for a turning circle, not for {track.manoeuvre!r}.")
    conditions = turning_conditions(track.rudder_deg, _conditions(track))
    return [
        _verdict(metric, item, track, conditions)
        for metric, item in criteria()
        if item.manoeuvre == track.manoeuvre
    ]


def turning_conditions(
    rudder_deg: float, others: tuple[str, ...], digits: str = "g"
) -> tuple[str, ...]:
    """What one turning circle does not show of the two that the standard asks for."""
    rudder = (
        f"The standard asks for {HARD_OVER:g}° of rudder or the largest permissible; this is "
        f"{abs(rudder_deg):{digits}}°."
    )
    side = "starboard" if rudder_deg > 0 else "port"
    return (
        *([rudder] if abs(abs(rudder_deg) - HARD_OVER) > 0.5 else []),
        *others,
        f"The standard asks for turns to both sides; this is the one to {side}.",
    )


def imo_verdicts(
    model: Model | str | Path,
    speed: float,
    *,
    n: int = 2000,
    spread: float | None = None,
    seed: int = 0,
    astern: float | None = None,
    **settings: Any,
) -> list[Verdict]:
    """Every criterion of the standard, to both sides.

    Parameters
    ----------
    model : Model, str or path
        A model, a library name or a file.
    speed : float
        Test speed [m/s].
    n : int
        Ships drawn for the probability of passing, where the model has a covariance or `spread`
        is given; 0 for none.
    spread, seed
        As for `monte_carlo`.
    astern : float, optional
        Revolutions of the full astern stop over those of the approach, negative; by default those
        of the manoeuvre `stopping`. The standard does not say them: what other ones give stands
        beside the verdict.
    **settings
        Handed on to `simulate`: `fn`, `depth`, `rudder_rate_deg`, `compiled` …

    Returns
    -------
    list of Verdict
        Turning circles, initial turning, zigzags 10/10 and 20/20, stopping. The stop is judged
        only for a model that says what its propulsion does astern.

    References
    ----------
    IMO resolution MSC.137(76), Standards for ship manoeuvrability, 2002.

    Examples
    --------
    >>> found = imo_verdicts("kcs", 12.35)
    >>> sum(bool(verdict.passed) for verdict in found), len(found)
    (12, 13)
    """
    loaded = model if isinstance(model, Model) else load_model(model)
    hard = min(HARD_OVER, steering(loaded).get("max_deg", HARD_OVER))
    drawn = n if spread is not None or loaded.covariance is not None else 0
    sided = [(metric, item) for metric, item in criteria() if "rudder_deg" in item.settings]
    tests = groupby(sided, key=lambda pair: (pair[1].manoeuvre, dict(pair[1].settings)))
    asked = [(manoeuvre, given, tuple(pairs)) for (manoeuvre, given), pairs in tests]
    found: list[Verdict] = []
    for side in (1.0, -1.0):
        for manoeuvre, given, pairs in asked:
            rudder = given["rudder_deg"]
            given = given | {"rudder_deg": side * (hard if rudder == HARD_OVER else rudder)}
            track = simulate(loaded, manoeuvre, speed=speed, **settings, **given)
            many = _many(loaded, manoeuvre, speed, drawn, spread, seed, settings, given)
            for metric, item in pairs:
                verdict = _verdict(metric, item, track, _conditions(track))
                if many is not None:
                    probability = many.probability(verdict.metric, verdict.limit)
                    verdict = replace(verdict, probability=probability)
                found.append(verdict)
    alone = [(metric, item) for metric, item in criteria() if (metric, item) not in sided]
    return [*found, *(_stopping(loaded, speed, astern, settings, *pair) for pair in alone)]


def _many(
    model: Model,
    manoeuvre: str,
    speed: float,
    n: int,
    spread: float | None,
    seed: int,
    settings: Mapping[str, Any],
    given: Mapping[str, Any],
) -> Ensemble | None:
    if not n:
        return None
    from pmmkit.simulation.ensemble import monte_carlo

    kept = {name: x for name, x in settings.items() if name not in ("compiled", "dt")}
    return monte_carlo(
        model, manoeuvre, speed=speed, n=n, spread=spread, seed=seed, **kept, **given
    )


def _stopping(
    model: Model,
    speed: float,
    astern: float | None,
    settings: Mapping[str, Any],
    metric: Metric,
    criterion: Criterion,
) -> Verdict:
    """Track reach of a full astern stop, if the model knows what happens astern."""
    if not any(part.known.astern for part in model.parts.values()):
        return judge(
            metric,
            criterion,
            {},
            L=model.ship.L,
            speed=speed,
            scale=model.scale,
            manoeuvre="stopping, full astern",
            conditions=(
                "Not judged: the model does not say what its propulsion does astern; the effects "
                f"{', '.join(x.name for x in catalogue().values() if x.astern)} do.",
            ),
        )
    usual = {item.name: item.default for item in manoeuvre_of(criterion.manoeuvre).settings}
    turns = astern if astern is not None else usual["turns"] or 0.0
    if not turns < 0.0:
        raise DataError(f"Revolutions of a stop are negative: astern is {turns:g}.")

    def stopped(own: float) -> Track:
        return simulate(model, criterion.manoeuvre, speed=speed, turns=own, **settings)

    track = stopped(turns)
    others = {own: _verdict(metric, criterion, stopped(own), ()) for own in ASTERN if own != turns}
    said = ", ".join(
        f"{own:g} {found.value:.3g} L{'' if found.passed else ' (not met)'}"
        for own, found in others.items()
    )
    assumed = (
        f"Full astern is {turns:g} of the approach's revolutions, at once and with all the torque "
        f"that this needs; the standard does not say them. Track reach with others: {said}."
    )
    return _verdict(metric, criterion, track, (*_conditions(track), assumed, LARGE))


def _verdict(
    metric: Metric, criterion: Criterion, track: Track, conditions: tuple[str, ...]
) -> Verdict:
    return judge(
        metric,
        criterion,
        track.metrics,
        L=track.L,
        speed=track.speed,
        scale=track.scale,
        conditions=conditions,
        manoeuvre=_sailed(track),
    )


def _sailed(track: Track) -> str:
    """The manoeuvre in words, with the side."""
    to = "port" if track.rudder_deg < 0 else "starboard"
    side = f", to {to}" if track.rudder_deg else ""
    return f"{track.manoeuvre.replace('_', ' ')} {abs(track.rudder_deg):g}°{side}"


def _conditions(track: Track) -> tuple[str, ...]:
    found = []
    if track.L < SHORTEST:
        found.append(
            f"The standard is for ships of 100 m and more; this track is of L = {track.L:.4g} m."
        )
    found.append(
        f"The approach speed ({track.speed:.4g} m/s, Fn {track.Fn:.3f}) must be at least 90 % of "
        f"the speed at 85 % of the engine's output, which the model does not state."
    )
    if track.tested and track.tested.below + track.tested.above > 0.0:
        found.append(f"{_sailed(track)}: {track.tested.words}")
    return tuple(found)
