"""Simulate a manoeuvre of a model."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import fields, replace
from functools import lru_cache
from pathlib import Path
from types import MappingProxyType
from typing import Any, Final, Literal

import numpy as np

from pmmkit.base import DataError, Problem, SimulationError
from pmmkit.equations import (
    Conditions,
    DenseHistory,
    End,
    Gear,
    Plan,
    Prepared,
    Revolutions,
    run_plan,
)
from pmmkit.models import Model, Standing, load_model
from pmmkit.simulation.froude import FOLLOWS, Follow, froude_range, prepared
from pmmkit.simulation.kinds.catalogue import manoeuvre_of
from pmmkit.simulation.kinds.manoeuvre import Manoeuvre
from pmmkit.simulation.machinery import as_it_reverses, assumed
from pmmkit.simulation.straight import held_straight
from pmmkit.simulation.track import Track

RudderLaw = Literal["ramp", "lag"]
ENVIRONMENT: Final = tuple(item.name for item in fields(Conditions))
"""Settings that say what is around the ship."""
ACROSS: Final = ("wind_speed", "wave_height")
"""Of these what turns a ship out of a straight run."""
LINEAR: Final = (
    "The hull's side force and moment are linear in v and r, which holds for small rudder angles "
    "alone: larger turns come out too tight. Here the drift reaches {drift:.0f}° and r' {rate:.1f}."
)
NO_TURN: Final = "In the end the ship does not turn to the side of its rudder: no steady diameter."
ONE_SET: Final = "The model has one set of values for all speeds: nothing follows the moment's."


def simulate(
    model: Model | str | Path,
    manoeuvre: str | Manoeuvre = "turning",
    *,
    speed: float,
    fn: Follow = "approach",
    rudder_rate_deg: float | None = None,
    rudder_law: RudderLaw = "ramp",
    rudder_lag: float = 1.0,
    wind_speed: float = 0.0,
    wind_direction_deg: float = 0.0,
    current_speed: float = 0.0,
    current_direction_deg: float = 0.0,
    depth: float | None = None,
    wave_height: float | None = None,
    waves_from_deg: float = 0.0,
    revolutions: Revolutions = None,
    dt: float | None = None,
    rtol: float = Prepared.RTOL,
    extrapolate: bool = False,
    compiled: bool | None = None,
    forces: bool = False,
    **settings: Any,
) -> Track:
    """Simulate a manoeuvre from steady running straight ahead.

    The first order is given at t = 0; the propeller keeps the revolutions of self-propulsion at
    the approach speed where the manoeuvre does not change them.

    Parameters
    ----------
    model : Model, str or path
        A model, a library name or a file.
    manoeuvre : str or Manoeuvre
        A name of `pmmkit.simulation.kinds.catalogue.manoeuvres`; docs/simulate.md lists them
        with their settings. Or one of your own.
    speed : float
        Approach speed through the water [m/s] at the scale of the model.
    fn : {"approach", "instant"}
        Values that depend on the Froude number are those of the approach throughout; or they
        follow U/√(gL) of each instant inside the range of the model's values and are held at its
        edge. Then the track says in `tested` how long the ship was outside.
    rudder_rate_deg : float, optional
        Rate of the steering gear [deg/s]; by default that of the model's rudder.
    rudder_law : {"ramp", "lag"}
        At the rate until the order is reached, or with a first-order lag at most at the rate.
    rudder_lag : float
        Time constant of the lag law [s].
    wind_speed, wind_direction_deg : float
        True wind [m/s], direction it comes from, from the heading of the approach, positive to
        starboard [deg]. It acts on models with a part ``wind``, from t = 0 on.
    current_speed, current_direction_deg : float
        Uniform current [m/s] and the direction it flows to, as above [deg].
    depth : float, optional
        Depth of the water [m], for models with a part ``shallow_water``.
    wave_height, waves_from_deg : float, optional
        Significant height of the waves [m] and where they come from, as above [deg]; for models
        with a part ``wave_drift``, whose own sea they stand for. `pmmkit.seakeeping.in_waves`
        gives a model that part.
    revolutions : float or "speed", optional
        Of the approach [1/s]. By default the lever stays where it holds the speed without waves,
        in which the ship then slows down; by ``speed`` it is where it holds the speed in them.
    dt : float, optional
        Interval of the samples [s]; by default about a tenth of L/speed. The metrics do not
        depend on it.
    rtol : float
        Relative tolerance of the integration.
    extrapolate : bool
        Allow a speed outside the range of the model's values.
    compiled : bool, optional
        Run compiled code, or interpreted code, which gives the same numbers. By default a model is
        interpreted at first, and compiled, which takes some seconds, once it is sailed often.
    forces : bool
        Keep the forces of each effect in the track, for `Track.animate`.
    **settings
        Of the manoeuvre, as above.

    Returns
    -------
    Track

    Raises
    ------
    DataError
        If an argument makes no sense; all of them at once.
    UnknownNameError
        If there is no such manoeuvre.
    MissingPartError, ExtrapolationError
        If the model lacks a part, or has no values at that speed.
    SimulationError
        If the motion grows without bound.

    Examples
    --------
    >>> track = simulate("s175-3dof", "turning", rudder_deg=35, speed=6.0)
    >>> round(float(track.metrics["tactical_diameter_L"]), 2)
    4.35
    >>> track = simulate("kvlcc2-l7", "zigzag", rudder_deg=10, switch_deg=10, speed=1.179)
    >>> round(float(track.metrics["overshoot_1_deg"]), 1)
    4.9
    """
    stated = model if isinstance(model, Model) else load_model(model)
    around: dict[str, Any] = {
        "wind_speed": wind_speed,
        "wind_direction_deg": wind_direction_deg,
        "current_speed": current_speed,
        "current_direction_deg": current_direction_deg,
        "depth": depth,
        "wave_height": wave_height,
        "waves_from_deg": waves_from_deg,
    }
    chosen = manoeuvre_of(manoeuvre)
    check_request(
        chosen,
        settings,
        around,
        speed=speed,
        rudder_rate_deg=rudder_rate_deg,
        fn=fn,
        rudder_law=rudder_law,
        rudder_lag=rudder_lag,
        dt=dt,
        rtol=rtol,
        revolutions=None if revolutions == "speed" else revolutions,
    )
    loaded = ship_for(chosen, stated, speed, settings, extrapolate=extrapolate)
    calm = wave_height is None and not any(around.values())
    conditions = None if calm else Conditions(**around)
    ready = prepared(loaded, speed, fn, conditions=conditions, extrapolate=extrapolate)
    plan = chosen.plan(
        speed / ready.L, speed=speed, wind=wind_speed > 0.0, bucket=loaded.has_bucket, **settings
    )
    lag = rudder_lag if rudder_law == "lag" else 0.0
    gear = gear_of(loaded, plan, ready.speed / ready.L, rudder_rate_deg, lag)
    history = run_plan(ready, plan, gear, rtol=rtol, fast=compiled, revolutions=revolutions)
    track = track_of(loaded, history, dt, settings)
    if forces:
        track = replace(track, forces=MappingProxyType(history.forces(track.t)))
    more = [Track.NO_BOTTOM] if depth is not None and not loaded.feels("depth") else []
    if wave_height is not None and not loaded.feels("wave_height"):
        more.append(Track.NO_WAVES)
    if revolutions in (None, "speed") and wave_height_of(loaded, wave_height):
        more.append(Track.SPEED_HELD if revolutions == "speed" else Track.LEVER_HELD)
    if fn == "instant":
        track = replace(track, tested=froude_range(loaded, history))
        more.append(track.tested.words if track.tested else ONE_SET)
    if has_linear_hull(loaded):
        speeds = np.maximum(np.hypot(track.u, track.v), 1e-9)
        drift = float(np.degrees(np.abs(np.arctan2(-track.v, track.u))).max())
        rate = float((np.abs(track.r) * track.L / speeds).max())
        more.append(LINEAR.format(drift=drift, rate=rate))
    more += [step.note for step in reversed(loaded.steps[len(stated.steps) :])]
    heavy = Standing.of(stated, speed).heavy if chosen.reverses else ""
    more += [heavy] if heavy else []
    return replace(track, notes=(*track.notes, *more)) if more else track


def wave_height_of(model: Model, stated: float | None = None) -> float:
    """Significant height of the waves that act on a ship [m].

    Parameters
    ----------
    model : Model
        The ship, perhaps with a sea of her own.
    stated : float, optional
        Height that stands for her own [m].

    Returns
    -------
    float
        0 where no waves act, or she does not feel them.

    Examples
    --------
    >>> wave_height_of(load_model("kvlcc2"), 3.0)
    0.0
    """
    own = [
        part.values.get("Hs", 0.0)
        for part in model.parts.values()
        if "wave_height" in part.known.needs
    ]
    heights = [float(x) for x in own if not isinstance(x, tuple)]
    return max(heights, default=0.0) if stated is None or not heights else stated


def ship_for(
    manoeuvre: Manoeuvre,
    model: Model,
    speed: float,
    settings: Mapping[str, Any],
    *,
    extrapolate: bool = False,
) -> Model:
    """A model with what a manoeuvre asks of it beside what it says.

    speed [m/s].

    Examples
    --------
    >>> ship = load_model("kvlcc2")
    >>> ship_for(manoeuvre_of("turning"), ship, 7.97, {}) is ship
    True
    >>> list(ship_for(manoeuvre_of("stopping"), ship, 7.97, {}).parts)[-1]
    'shaft'
    """
    if manoeuvre.held_straight:
        return held_straight(model)
    if manoeuvre.reverses:
        given = manoeuvre.filled(settings)
        return as_it_reverses(model, speed, **given, extrapolate=extrapolate)
    return model


def stopping_ship(
    manoeuvre: Manoeuvre,
    model: Model,
    speed: float,
    settings: Mapping[str, Any],
    *,
    extrapolate: bool = False,
) -> tuple[Model, str]:
    """The ship that `simulate` stops, and what is assumed of her engine in sentences.

    Parameters
    ----------
    manoeuvre : Manoeuvre
        A stop.
    model : Model
        As it is stated.
    speed : float
        Approach speed [m/s].
    settings : mapping
        Of the stop, those that are given.
    extrapolate : bool
        Allow a speed outside the range of the model's values.

    Returns
    -------
    Model, str
    """
    ship = ship_for(manoeuvre, model, speed, settings, extrapolate=extrapolate)
    turns = next(item for item in manoeuvre.settings if item.name == "turns")
    return ship, assumed(ship, None if turns.name in settings else turns)


@lru_cache(maxsize=64)
def has_linear_hull(model: Model) -> bool:
    """Whether nothing but terms linear in v and r gives the hull's side force and moment.

    Examples
    --------
    >>> has_linear_hull(load_model("kcs"))
    False
    """
    some = model.acts_across(lambda _v, _r: True)
    return some and not model.acts_across(lambda v, r: v + r > 1)


def check_request(
    manoeuvre: Manoeuvre,
    settings: Mapping[str, Any],
    environment: Mapping[str, float | None],
    *,
    fn: str = "approach",
    rudder_law: str = "ramp",
    rtol: float = Prepared.RTOL,
    **positive: float | None,
) -> None:
    """Refuse a request that makes no sense."""
    found = [
        f"{name} = {value} must be positive."
        for name, value in positive.items()
        if value is not None and not (math.isfinite(value) and value > 0)
    ]
    if rudder_law not in ("ramp", "lag"):
        found.append(f"rudder_law = {rudder_law!r} is not known: ramp, lag.")
    if fn not in FOLLOWS:
        found.append(f"fn = {fn!r} is not known: {', '.join(FOLLOWS)}.")
    if not 1e-13 < rtol < 0.1:
        found.append(f"rtol = {rtol} must lie between 1e-13 and 0.1.")
    found += _environment_problems(environment) + manoeuvre.problems(settings)
    across = [name for name in ACROSS if environment.get(name)]
    if manoeuvre.held_straight and across:
        found.append(f"{manoeuvre.name} holds the ship straight: leave out {', '.join(across)}.")
    if found:
        raise DataError([Problem(message=text) for text in found], title="Cannot simulate")


def _environment_problems(environment: Mapping[str, float | None]) -> list[str]:
    found = []
    for name, value in environment.items():
        if value is None:
            continue
        if not math.isfinite(value):
            found.append(f"{name} = {value} must be a finite number.")
        elif value < 0 and name.endswith("_speed"):
            found.append(f"{name} = {value} must not be negative; its direction says where from.")
        elif value < 0 and name == "wave_height":
            found.append(f"wave_height = {value} must not be negative.")
        elif value <= 0 and name == "depth":
            found.append(f"depth = {value} must be positive.")
    return found


def gear_of(model: Model, plan: Plan, pace: float, rate_deg: float | None, lag: float) -> Gear:
    """How the controls of a model follow their orders."""
    limits = model.steering
    largest = limits.get("max_deg", 90.0)
    most = plan.most_rudder
    if math.degrees(most) > largest * (1 + 1e-12):
        raise SimulationError(
            f"The rudder of {model.name!r} goes to {largest:g}°; {math.degrees(most):g}° were "
            f"ordered. Order less, or change max_deg in the model."
        )
    rate = rate_deg if rate_deg is not None else limits.get("rate_deg_s")
    if rate is None and most > 0.0:
        raise DataError(
            f"Model {model.name!r} states no rate of the steering gear; give rudder_rate_deg."
        )
    turning = plan.revolutions_rate
    if turning is None:
        shaft = any("n" in part.known.states for part in model.parts.values())
        turning = Gear.INSTANT if shaft else pace / Gear.REVERSAL
    return Gear(
        rudder_rate=math.radians(rate) if rate is not None else Gear.INSTANT,
        rudder_lag=lag,
        revolutions_rate=turning,
        bucket_rate=pace / Gear.REVERSAL if plan.bucket_rate is None else plan.bucket_rate,
    )


def track_of(
    model: Model, history: DenseHistory, dt: float | None, settings: Mapping[str, Any]
) -> Track:
    """The track of a history: samples, metrics and notes."""
    ready, plan = history.ready, history.plan
    t = samples(history.end, dt or interval(ready.L / ready.speed))
    channels = history.channels(t)
    still = np.zeros(len(t))
    columns: dict[str, Any] = {name: channels.get(name, still) for name in Track.CHANNELS}
    metrics = {name: float(value) for name, value in plan.metrics_of(history.results).items()}
    notes = _notes(history)
    if "steady_diameter" in metrics and metrics["speed_ratio"] > 0.0:
        notes += [NO_TURN] if math.isnan(metrics["steady_diameter"]) else []
    return Track(
        t=t,
        **columns,
        name=model.name,
        manoeuvre=plan.name,
        L=ready.L,
        speed=ready.speed,
        Fn=model.ship.froude(ready.speed, model.water.g),
        rudder_deg=math.degrees(plan.rudder),
        metrics=MappingProxyType(metrics),
        scale=model.scale,
        notes=tuple(notes),
        orders=history.begins,
        settings=MappingProxyType(dict(settings)),
        standing=Standing.of(model, ready.speed),
    )


def _notes(history: DenseHistory) -> list[str]:
    plan, notes = history.plan, []
    for phase, ended in zip(plan.phases, history.finished, strict=True):
        if ended:
            continue
        waited = {
            End.heading: f"the heading does not reach {math.degrees(phase.level):g}°",
            End.steady_turn: f"the heading does not reach {math.degrees(phase.level):g}°",
            End.yaw_rate: "the ship does not stop turning",
            End.surge: f"the ship does not reach {phase.level:.4g} m/s"
            if phase.level
            else "the ship does not stop",
        }
        if phase.until in waited:
            notes.append(f"Within {phase.longest:.4g} s {waited[phase.until]}.")
            break
        if phase.until == End.steady:
            notes.append(f"The motion is not steady within {phase.longest:.4g} s.")
            break
    if plan.settles and not notes:
        results = history.results
        if math.isnan(results.t("steady")):
            notes.append("The turn does not become steady: no steady diameter, drift or speed.")
    astern = any(phase.revolutions < 0.0 for phase in plan.phases)
    if astern and any(item.effect == "propeller" for item in history.ready.structure.used):
        notes.append(
            "The propeller astern is carried on from its open-water characteristics ahead; the "
            "effect four_quadrant_propeller describes it (pmmkit model astern estimates it)."
        )
    return notes


def interval(unit: float) -> float:
    """The 1, 2 or 5 times a power of ten next below a tenth of a time."""
    target = unit / 10
    power = 10.0 ** math.floor(math.log10(target))
    return max(x * power for x in (1.0, 2.0, 5.0) if x * power <= target * (1 + 1e-12))


def samples(end: float, dt: float) -> np.ndarray:
    """Instants from 0 to the end, the last one included."""
    if end / dt > 1e7:
        raise DataError(f"dt = {dt:g} s over {end:g} s are more than ten million samples.")
    whole = math.floor(end / dt * (1 + 1e-12))
    beyond = end - whole * dt >= 1e-9 * max(end, 1.0)
    t = np.arange(whole + 1.0 + beyond) * dt
    if beyond:
        t[-1] = end
    return t
