"""Criteria of IMO resolution MSC.137(76): what each asks, and whether a ship meets it."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

from pmmkit.bibliography import cite
from pmmkit.effects.catalogue import catalogue
from pmmkit.errors import DataError
from pmmkit.models import Model, load_model
from pmmkit.simulation.simulate import simulate, steering
from pmmkit.simulation.track import Track

if TYPE_CHECKING:
    from pmmkit.simulation.ensemble import Ensemble

SOURCE: Final = cite("msc137")
TURNING_LIMITS: Final = (("advance", 4.5), ("tactical_diameter", 5.0))
INITIAL_LIMIT: Final = 2.5
OVERSHOOT_20: Final = 25.0
STOPPING_LIMIT: Final = 15.0
RUDDER_DEG: Final = 35.0
SHORTEST: Final = 100.0


@dataclass(frozen=True, kw_only=True)
class Verdict:
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
    if time < 10.0:
        return 10.0, 25.0
    if time < 30.0:
        return 5.0 + 0.5 * time, 17.5 + 0.75 * time
    return 20.0, 40.0


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
    conditions = _conditions(track)
    if abs(abs(track.rudder_deg) - RUDDER_DEG) > 0.5:
        conditions = (
            f"The standard asks for 35° of rudder or the largest permissible; this is "
            f"{abs(track.rudder_deg):g}°.",
            *conditions,
        )
    side = "starboard" if track.rudder_deg > 0 else "port"
    conditions += (f"The standard asks for turns to both sides; this is the one to {side}.",)
    return [_verdict(name, limit, f"{name}_L", track, conditions) for name, limit in TURNING_LIMITS]


def imo_verdicts(
    model: Model | str | Path,
    speed: float,
    *,
    n: int = 2000,
    spread: float | None = None,
    seed: int = 0,
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
    **settings
        Handed on to `simulate`: `depth`, `rudder_rate_deg`, `compiled` …

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
    first, second = zigzag_limits(loaded.ship.L, speed)
    hard = min(RUDDER_DEG, steering(loaded).get("max_deg", RUDDER_DEG))
    drawn = n if spread is not None or loaded.covariance is not None else 0
    found: list[Verdict] = []
    for side in (1.0, -1.0):
        asked: list[tuple[str, dict[str, Any], list[tuple[str, float, str, str]]]] = [
            (
                "turning",
                {"rudder_deg": side * hard},
                [(name, limit, f"{name}_L", "L") for name, limit in TURNING_LIMITS],
            ),
            (
                "initial_turning",
                {"rudder_deg": side * 10.0},
                [("initial_turning", INITIAL_LIMIT, "initial_turning_distance_L", "L")],
            ),
            (
                "zigzag",
                {"rudder_deg": side * 10.0, "switch_deg": 10.0, "executes": 3},
                [
                    ("first_overshoot_10_10", first, "overshoot_1_deg", "deg"),
                    ("second_overshoot_10_10", second, "overshoot_2_deg", "deg"),
                ],
            ),
            (
                "zigzag",
                {"rudder_deg": side * 20.0, "switch_deg": 20.0, "executes": 2},
                [("first_overshoot_20_20", OVERSHOOT_20, "overshoot_1_deg", "deg")],
            ),
        ]
        for manoeuvre, given, criteria in asked:
            track = simulate(loaded, manoeuvre, speed=speed, **settings, **given)
            many = _many(loaded, manoeuvre, speed, drawn, spread, seed, settings, given)
            found += [
                _verdict(name, limit, metric, track, _conditions(track), unit, many)
                for name, limit, metric, unit in criteria
            ]
    return [*found, _stopping(loaded, speed, settings)]


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


def _stopping(model: Model, speed: float, settings: Mapping[str, Any]) -> Verdict:
    """Track reach of a full astern stop, if the model knows what happens astern."""
    if not any(catalogue()[part].astern for part in model.parts):
        return Verdict(
            criterion="track_reach",
            limit=STOPPING_LIMIT,
            value=math.nan,
            margin=math.nan,
            passed=None,
            scale=model.scale,
            manoeuvre="stopping, full astern",
            conditions=(
                "Not judged: the model does not say what its propulsion does astern; the effects "
                f"{', '.join(x.name for x in catalogue().values() if x.astern)} do.",
            ),
        )
    track = simulate(model, "stopping", speed=speed, **settings)
    conditions = (
        *_conditions(track),
        "The administration may allow up to 20 L for ships of large displacement.",
    )
    return _verdict("track_reach", STOPPING_LIMIT, "track_reach_L", track, conditions)


def _verdict(
    criterion: str,
    limit: float,
    metric: str,
    track: Track,
    conditions: tuple[str, ...],
    unit: str = "L",
    many: Ensemble | None = None,
) -> Verdict:
    value = track.metrics.get(metric, math.nan)
    to = "port" if track.rudder_deg < 0 else "starboard"
    side = f", to {to}" if track.rudder_deg else ""
    probability = None
    if many is not None:
        probability = many.probability(metric, limit)
    return Verdict(
        criterion=criterion,
        limit=limit,
        value=value,
        margin=limit - value,
        passed=None if math.isnan(value) else value <= limit,
        conditions=conditions,
        scale=track.scale,
        unit=unit,
        manoeuvre=f"{track.manoeuvre.replace('_', ' ')} {abs(track.rudder_deg):g}°{side}",
        probability=probability,
    )


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
    return tuple(found)
