"""What every manoeuvre and every metric must hold."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from inspect import signature
from typing import Any, Final

import numpy as np

from pmmkit.base import DataError, PmmkitError
from pmmkit.conventions import METRICS, Metric
from pmmkit.simulation import MANOEUVRES, Manoeuvre, Setting, Track, simulate
from pmmkit.testing import hold

UNITS: Final = {"m": "", "s": "", "-": "", "m/s": "", "deg": "_deg", "deg/s": "_deg_s"}
"""Units of metrics, and what then stands in their names."""
SAME: Final = 1e-9
"""Relative difference between interpreted and compiled, and between the sides."""
SHIP: Final = "s175-3dof"
"""A ship of the library that is the same to port and to starboard."""
_PACE: Final = 0.05
_TIMES: Final = np.linspace(1.0, 100.0, 199)


def check_metric(metric: Metric) -> None:
    """Whether a metric can stand beside those of pmmkit.

    Its name is plain and says the unit of angles; a name of pmmkit's table means the same as
    there; what the IMO asks of it is asked of a manoeuvre that gives it, with settings which that
    manoeuvre has.

    Parameters
    ----------
    metric : Metric
        An entry, yours or pmmkit's.

    Raises
    ------
    AssertionError
        With everything that does not hold.

    Examples
    --------
    >>> check_metric(Metric.of("advance"))
    >>> check_metric(Metric(name="Drift", symbol="β", title="drift angle", unit="deg"))
    Traceback (most recent call last):
    AssertionError: Metric 'Drift':
    - its name is not of small letters, digits and underscores
    - its name does not say its unit: _deg
    """
    hold(f"Metric {metric.name!r}", _faults_of_metric(metric))


def check_manoeuvre(
    manoeuvre: Manoeuvre, *, ship: str = SHIP, speed: float = 8.0, **settings: Any
) -> None:
    """Whether a manoeuvre can stand beside those of pmmkit.

    Its settings are those that its function takes, and what makes no sense is refused by name; its
    plan is data and always the same; it gives the metrics that it declares, finite, the same to
    the bit when it is run again, to 1e-9 when it is compiled, and mirrored to the other side.

    Parameters
    ----------
    manoeuvre : Manoeuvre
        An entry, yours or pmmkit's.
    ship : str
        A symmetric ship of the library that can do it.
    speed : float
        Approach speed [m/s].
    **settings
        Of the manoeuvre: those that it requires, or smaller ones that take less time.

    Raises
    ------
    AssertionError
        With everything that does not hold.

    Examples
    --------
    >>> from pmmkit.simulation import MANOEUVRES
    >>> check_manoeuvre(MANOEUVRES["initial_turning"])
    """
    named = f"Manoeuvre {manoeuvre.name!r}"
    hold(named, _faults_of_entry(manoeuvre))
    hold(named, _faults_of_plan(manoeuvre, settings))
    try:
        track = simulate(ship, manoeuvre, speed=speed, compiled=False, **settings)
    except PmmkitError as error:
        hold(named, [f"it does not run: {error}"])
        raise
    hold(named, _faults_of_run(manoeuvre, track, ship, settings))


def _plain(name: str) -> bool:
    bare = name.replace("{}", "0", 1).replace("_", "")
    return bare.isalnum() and bare.isascii() and bare == bare.lower()


def _faults_of_metric(metric: Metric) -> Iterator[str]:
    if not _plain(metric.name):
        yield "its name is not of small letters, digits and underscores"
    if metric.name.endswith(Metric.IN_LENGTHS):
        end = Metric.IN_LENGTHS
        yield f"its name ends with {end}, which is for the same length in ship lengths"
    if metric.unit not in UNITS:
        yield f"its unit is {metric.unit!r}, none of {', '.join(UNITS)}"
    elif UNITS[metric.unit] not in metric.name:
        yield f"its name does not say its unit: {UNITS[metric.unit]}"
    if not (metric.symbol and metric.title):
        yield "it has no symbol or no title"
    for known in METRICS.values():
        if known.name == metric.name and known.unit != metric.unit:
            yield f"it is in {metric.unit}; the metric of that name is in {known.unit}"
    for item in metric.criteria:
        values = [item.limit_for(time, 1.0) for time in _TIMES]
        if not all(math.isfinite(value) and value > 0 for value in values):
            yield f"the limit of {item.name} is not positive"
        if not item.paragraph:
            yield f"{item.name} names no paragraph"
        sailed = MANOEUVRES.get(item.manoeuvre)
        if sailed is None:
            yield f"{item.name} is judged by {item.manoeuvre!r}, which is no manoeuvre"
            continue
        if metric.name not in [given.name for given in sailed.metrics]:
            yield f"{item.name} is judged by {item.manoeuvre}, which does not give it"
        yield from sailed.problems(item.settings)


def _faults_of_entry(manoeuvre: Manoeuvre) -> Iterator[str]:
    if not _plain(manoeuvre.name):
        yield "its name is not of small letters, digits and underscores"
    if not manoeuvre.title:
        yield "it has no title"
    if not manoeuvre.metrics:
        yield "it declares no metric"
    for metric in manoeuvre.metrics:
        yield from (f"metric {metric.name}: {text}" for text in _faults_of_metric(metric))
    names = [setting.name for setting in manoeuvre.settings]
    if len(set(names)) < len(names):
        yield "a setting comes twice"
    around = list(manoeuvre.around())
    takes = list(signature(manoeuvre.orders).parameters)[1:]
    ordered = [setting.name for setting in manoeuvre.settings if not setting.engine]
    if set(takes) != {*ordered, *around}:
        declared = ", ".join([*ordered, *around])
        yield f"its function takes {', '.join(takes)}; declared are {declared}"
    for setting in manoeuvre.settings:
        yield from _faults_of_setting(manoeuvre, setting)


def _faults_of_setting(manoeuvre: Manoeuvre, setting: Setting) -> Iterator[str]:
    if setting.unit == "deg" and not setting.name.endswith("_deg"):
        yield f"{setting.name} is in degrees and does not end with _deg"
    if not setting.text:
        yield f"{setting.name} has no text"
    if setting.default is not None and (wrong := setting.problem(setting.default)):
        yield f"the default of {setting.name}: {wrong}"
    for value in (math.nan, "much", True):
        if not any(setting.name in text for text in manoeuvre.problems({setting.name: value})):
            yield f"{setting.name} = {value!r} is not refused"


def _faults_of_plan(manoeuvre: Manoeuvre, settings: Mapping[str, Any]) -> Iterator[str]:
    missing = manoeuvre.problems(settings)
    if missing:
        yield from missing
        return
    given = manoeuvre.filled(settings, engine=False) | manoeuvre.around()
    one, other = (manoeuvre.orders(_PACE, **given) for _ in range(2))
    if one != other:
        yield "its plan is not the same twice"
    try:
        numbers = [*one.orders, *one.questions]
    except (TypeError, ValueError) as error:
        yield f"its plan does not consist of numbers: {error}"
        return
    if not numbers:
        yield "its plan is empty"
    for probe, place in one.probes.items():
        if not 0 <= place.first <= place.last < len(one.phases):
            yield f"the probe {probe} looks at phases that there are not"
    for setting in manoeuvre.settings:
        for value in (0.1, 1.0, min(setting.below, 90.0) * (1 - 1e-9)):
            if setting.problem(value) is None and not setting.engine:
                yield from _refused_badly(manoeuvre, given | {setting.name: value}, setting.name)


def _refused_badly(manoeuvre: Manoeuvre, given: Mapping[str, Any], name: str) -> Iterator[str]:
    """A setting that does not go with the others is refused by an error that names it."""
    whole = {item.name for item in manoeuvre.settings if item.whole}
    try:
        manoeuvre.orders(_PACE, **{x: int(v) if x in whole else v for x, v in given.items()})
    except DataError as error:
        if name not in str(error):
            yield f"{name} = {given[name]} is refused without its name: {error}"
    except Exception as error:
        yield f"{name} = {given[name]} ends in {type(error).__name__}: {error}"


def _faults_of_run(
    manoeuvre: Manoeuvre, track: Track, ship: str, settings: Mapping[str, Any]
) -> Iterator[str]:
    given: dict[str, int] = {metric.name: 0 for metric in manoeuvre.metrics}
    for name, value in track.metrics.items():
        given[Metric.of(name, manoeuvre.metrics).name] += 1
        if not math.isfinite(value):
            yield f"{name} is {value}"
    for metric in manoeuvre.metrics:
        if not given[metric.name] and not metric.rolls:
            yield f"it does not give {metric.name}, which it declares"

    def again(**changed: Any) -> Track:
        asked = {"compiled": False, **settings, **changed}
        return simulate(ship, manoeuvre, speed=track.speed, **asked)

    twice = again()
    if dict(twice.metrics) != dict(track.metrics) or not all(
        np.array_equal(getattr(twice, name), getattr(track, name)) for name in Track.CHANNELS
    ):
        yield "it is not the same when it is run again"
    yield from _differ(track.metrics, again(compiled=True).metrics, "compiled")
    angles = {
        setting.name: settings.get(setting.name) or setting.default or 10.0
        for setting in manoeuvre.settings
        if setting.takes in ("side", "angle")
    }
    if angles:
        one = again(**angles)
        other = again(**{name: -angle for name, angle in angles.items()})
        mirrored = dict(_mirrored(manoeuvre, one.metrics))
        yield from _differ(mirrored, other.metrics, "to the other side")


def _mirrored(manoeuvre: Manoeuvre, metrics: Mapping[str, float]) -> Iterator[tuple[str, float]]:
    """The metrics as the mirror image has them, rudder angles in their names mirrored too."""
    for name, value in metrics.items():
        metric = Metric.of(name, manoeuvre.metrics)
        if not metric.starboard:
            yield name, value
            continue
        angle = metric.count(name.removesuffix(Metric.IN_LENGTHS)) or ""
        turned = angle.translate(str.maketrans("+-", "-+"))
        yield name.replace(angle, turned) if angle else name, -value


def _differ(one: Mapping[str, float], other: Mapping[str, float], how: str) -> Iterator[str]:
    if set(one) != set(other):
        yield f"{how} it gives {', '.join(sorted(set(one) ^ set(other)))} only once"
        return
    for name, value in one.items():
        if not math.isclose(value, other[name], rel_tol=SAME, abs_tol=SAME):
            yield f"{how} {name} is {other[name]}, not {value}"
