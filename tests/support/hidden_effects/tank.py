"""The tank: programme, truth, hidden effects and noise made into a campaign."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Literal

import numpy as np
import xarray as xr

from pmmkit import Campaign, Run
from pmmkit.campaigns import Settings, TypeB

from . import beyond, catalogue, outside, sources, unseen
from .gauges import GAUGE_EFFECTS, inertia, read
from .hull import Force, add, heel, hull_force, times
from .motion import Array, Motion, motion_of
from .noise import LEVELS, RunNoise, background, draw
from .programmes import Plan, Sided, plans
from .sizes import CHANNELS, CYCLES, NOISE, PER_CYCLE, SHIP, STATIC_CYCLES, WATER, scale

Truth = Literal["catalogue", "foreign"]
Removal = Literal["ideal", "nominal"]

FINE = 4
"""Steps of the simulation per sample of the record."""
LEAD = 3
"""Cycles that the model has oscillated before the record starts, so that states have settled."""

INSIDE = tuple(
    dict.fromkeys(
        (
            *catalogue.FORCES,
            *catalogue.RIG_EFFECTS,
            *(name for name in GAUGE_EFFECTS if name.startswith("fault_")),
        )
    )
)
"""Effects that a catalogue holds."""
OUTSIDE = (*outside.FORCES, "outside_dead_zone")
"""Effects that no catalogue holds."""
BEYOND = tuple(beyond.FORCES)
"""Others that no catalogue holds, of kinds that nothing was tried on before."""
UNSEEN = tuple(unseen.FORCES)
"""Others, made before the rules and no part of what they were tried on."""
EFFECTS = (*INSIDE, *OUTSIDE, *BEYOND, *UNSEEN)


def hidden_campaign(
    programme: str | Sequence[Plan] = "full",
    effects: Mapping[str, float] | None = None,
    *,
    truth: Truth = "catalogue",
    noise: str = "standard",
    seed: int = 0,
    roll_measured: bool = True,
    sided: Sided = "both",
    balance: bool = False,
    removal: Removal = "ideal",
    stated: bool = False,
) -> Campaign:
    """A campaign of histories with effects hidden in it.

    The nominal motion is all that the records tell of the motion: no motion channels but heel.

    Parameters
    ----------
    programme : {"full", "middle", "small"} or sequence of Plan
        48, 27 or 13 runs, or any. The noise of a run hangs on its place alone.
    effects : mapping of str to float, optional
        Names from `EFFECTS` with size factors, any sign.
    truth : {"catalogue", "foreign"}
        Effects in the catalogue's form, or at a physical source. Those that no catalogue holds
        have one form.
    noise : {"standard", "double", "hard", "none"}
        See `sizes.toml`.
    seed : int
        Of noise and background; the same noise whatever the effects.
    roll_measured : bool
        Whether the records hold the heel, which the model is free to take.
    sided : {"both", "one"}
        As the programme stands, or without runs to port.
    balance : bool
        Whether the model's inertia stays inside the forces.
    removal : {"ideal", "nominal"}
        Where it does not: never there for the gauges (ideal), or there when the gauges erred and
        taken off afterwards with the stated motion (nominal).
    stated : bool
        Whether the campaign states the scatter of offsets and gains as its uncertainty.

    Returns
    -------
    Campaign
        48 samples a cycle, 4 cycles (discard the first); static records as long as 3 cycles of
        omega' 2.
    """
    hidden = {name: float(size) for name, size in (effects or {}).items() if size}
    unknown = sorted(set(hidden) - set(EFFECTS))
    if unknown or noise not in LEVELS or truth not in ("catalogue", "foreign"):
        raise ValueError(f"unknown: effects {unknown}, or {noise=}, {truth=}.")
    smooth = background(seed) if noise == "hard" else None
    made = []
    named = isinstance(programme, str)
    asked, title = (plans(programme, sided), programme) if named else (programme, "as planned")
    for number, plan in enumerate(asked):
        t = record_times(plan)
        chance = draw(noise, seed, number, len(t))
        told, m = motions(plan, hidden, truth, chance.heading)
        force = water_force(m, hidden, truth)
        if smooth is not None:
            force = add(force, smooth(m))
        weighed = balance or removal == "nominal"
        if weighed:
            force = add(force, times(-1.0, inertia(m)))
        reading = read(force, m, hidden, truth == "foreign")
        if weighed and not balance:
            reading = add(reading, inertia(told))
        made.append(_run(plan, _sample(reading, m, t, chance, roll_measured), balance))
    return Campaign(
        title=f"hidden effects, {title}",
        ship=SHIP,
        water=WATER,
        runs=tuple(made),
        forces="balance" if balance else "hydrodynamic",
        free=("heave", "pitch", "roll"),
        uncertainty=_scatter() if stated and noise != "none" else (),
    )


def _scatter() -> tuple[TypeB, ...]:
    """Standard uncertainty of offset and gain of each gauge, run by run."""
    return tuple(
        TypeB(name=f"{name}_gauge", std=std, relative=relative)
        for name in CHANNELS
        for std, relative in ((NOISE["offset"] * scale(name), False), (NOISE["gain"], True))
    )


def record_times(plan: Plan) -> Array:
    """Times of the samples of a record [s]."""
    if plan.dynamic:
        return np.arange(CYCLES * PER_CYCLE) * (2 * math.pi / plan.omega / PER_CYCLE)
    return np.arange(STATIC_CYCLES * PER_CYCLE) * (math.pi * SHIP.L / plan.speed / PER_CYCLE)


def fine_times(plan: Plan) -> Array:
    """Times of the simulation, from before the record on."""
    t = record_times(plan)
    step = t[1] / FINE
    lead = LEAD * PER_CYCLE * FINE if plan.dynamic else FINE
    return np.arange(-lead, len(t) * FINE) * step


def motions(
    plan: Plan, effects: Mapping[str, float], truth: Truth, heading: float = 0.0
) -> tuple[Motion, Motion]:
    """Stated and true motion, heel included; catalogue faults leave the motion as it is stated."""
    t = fine_times(plan)
    stated = motion_of(plan, t)
    rig = catalogue.rig_of(dict(effects) if truth == "foreign" else {})
    rig = replace(rig, heading=rig.heading + heading)
    m = motion_of(plan, t, rig)
    return stated, replace(m, phi=heel(m))


def water_force(m: Motion, effects: Mapping[str, float], truth: Truth) -> Force:
    """Force of the water with all hidden physics, and the catalogue's faults of motion."""
    forms = {**(sources.FORCES if truth == "foreign" else catalogue.FORCES), **outside.FORCES}
    forms |= beyond.FORCES | unseen.FORCES

    def force(m: Motion) -> Force:
        parts = [times(size, forms[name](m)) for name, size in effects.items() if name in forms]
        return add(hull_force(m), *parts)

    if truth == "foreign":
        return force(m)
    return add(force(m), catalogue.rig_change(m, dict(effects), force))


def _sample(
    reading: Force, m: Motion, t: Array, chance: RunNoise, roll_measured: bool
) -> xr.Dataset:
    start = len(m.t) - FINE * len(t)
    channels = {
        name: reading[name][start::FINE] * (1 + chance.gain[name])
        + chance.offset[name]
        + chance.record[name]
        for name in CHANNELS
    }
    if roll_measured:
        channels["phi"] = m.phi[start::FINE] + chance.phi
    return xr.Dataset({name: ("t", values) for name, values in channels.items()}, coords={"t": t})


def _run(plan: Plan, data: xr.Dataset, balance: bool) -> Run:
    settings = Settings(
        speed=plan.speed,
        drift=plan.drift,
        rudder=plan.rudder,
        propeller_rps=0.0,
        period=2 * math.pi / plan.omega if plan.dynamic else None,
        amplitude=plan.sway or None,
        yaw_amplitude=plan.yaw or None,
        repeat_of=plan.repeat_of,
    )
    return Run(
        id=plan.id,
        test=plan.test,
        kind="history",
        settings=settings,
        loader=lambda: data,
        forces="balance" if balance else "hydrodynamic",
    )
