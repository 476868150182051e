"""Campaigns of free-running records, as files: programme, records, and the truth beside them."""

from __future__ import annotations

import json
import math
import zlib
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from .cases import CASES, FLEETS, Case, Fleet
from .hidden import NOTHING, Hidden
from .sailing import Order, Sailed, sail
from .sensors import fault_coefficients, recorded

SHIPS = tuple(FLEETS)
LARGE, SMALL = (25, 30, 35), (10, 15, 20)
"""Rudder angles of turns [deg]."""
ZIGZAGS = ((10, 5), (10, 10), (15, 15), (20, 10), (20, 20), (25, 10))
"""Rudder angle and heading of reversal [deg]."""


@dataclass(frozen=True, kw_only=True)
class Setup:
    """A campaign: what is hidden, how much of it, how many runs (six or three), seed, ship."""

    case: str = "none"
    size: float = 1.0
    runs: int = 6
    seed: int = 0
    ship: str = "s175"

    def __post_init__(self) -> None:
        if self.ship not in CASES[self.case].make:
            raise ValueError(f"The {self.ship} has no case {self.case!r}.")
        if self.runs not in (3, 6):
            raise ValueError(f"A programme has three runs or six, not {self.runs}.")

    @property
    def name(self) -> str:
        """Of its folder; it does not tell the case."""
        return f"f{zlib.crc32(repr(self).encode()) % 1_000_000:06d}"

    @property
    def fleet(self) -> Fleet:
        return FLEETS[self.ship]

    @property
    def known(self) -> Case:
        return CASES[self.case]

    @property
    def truth(self) -> dict[str, Any]:
        """What a diagnosis should say."""
        return {
            "case": self.case,
            "model": self.known.start or self.fleet.model,
            "expect": [list(names) for names in self.known.expect],
            "verdict": [self.known.verdict],
            "extra": [],
            "size": self.size,
            "runs": self.runs,
            "seed": self.seed,
            "coefficients": self.coefficients,
        }

    @property
    def coefficients(self) -> dict[str, dict[str, float]]:
        """Of each effect that is hidden in the form of the catalogue: memory, stall, wind and the
        bottom are of the tank's own."""
        hidden = hidden_in(self)
        every = self.fleet.build(hidden).coefficients | fault_coefficients(hidden)
        named = [name for names in self.known.expect for name in names]
        return {name: every[name] for name in named if any(every.get(name, {}).values())}


@dataclass(frozen=True)
class Plan:
    """A run: speed [m/s], rudder and, in a zigzag, heading of reversal [deg]."""

    speed: float
    rudder: int
    switch: int | None = None

    @property
    def test(self) -> str:
        return "turning" if self.switch is None else "zigzag"

    @property
    def id(self) -> str:
        return f"{self.test}_{self.speed:g}_{self.rudder:+d}"


def programme(setup: Setup) -> list[Plan]:
    """Turns and zigzags at two speeds; one seed has one programme, whatever is hidden."""
    rng = np.random.default_rng([setup.seed, setup.runs])
    fleet = setup.fleet
    slow, fast = float(rng.choice(fleet.slow)), float(rng.choice(fleet.fast))
    side = int(rng.choice([-1, 1]))
    large = [int(x) for x in rng.choice(LARGE, 2, replace=False)]
    weaves = [ZIGZAGS[i] for i in rng.choice(len(ZIGZAGS), 3, replace=False)]
    zigzags = [
        Plan(speed, way * side * rudder, switch)
        for speed, way, (rudder, switch) in zip(
            (slow, fast, slow), (1, -1, -1), weaves, strict=True
        )
    ]
    turn = Plan(slow, -side * max(large))
    if setup.runs == 3:
        return [turn, *zigzags[:2]]
    gentle = Plan(fast, side * int(rng.choice(SMALL)))
    return [turn, Plan(slow, side * min(large)), gentle, *zigzags]


def hidden_in(setup: Setup) -> Hidden:
    """What is hidden, with the sign that the seed draws where none is usual."""
    sign = float(_draws(setup, "sign").choice([-1.0, 1.0])) if setup.known.either else 1.0
    return setup.known.make[setup.ship](sign * setup.size)


def sailed(setup: Setup) -> list[Sailed]:
    """The runs of a campaign before any instrument has seen them; each has its wind, if any."""
    rng, hidden, fleet = _draws(setup, "wind"), hidden_in(setup), setup.fleet
    orders = [
        Order(
            rudder=math.radians(plan.rudder),
            switch=None if plan.switch is None else math.radians(plan.switch),
            speed=plan.speed,
            seconds=fleet.turn if plan.switch is None else fleet.zigzag,
            wind_speed=fleet.wind if hidden.windage else 0.0,
            wind_from=rng.uniform(-math.pi, math.pi) if hidden.windage else 0.0,
        )
        for plan in programme(setup)
    ]
    return sail(fleet.build(hidden), orders, fleet.step)


def records(setup: Setup) -> dict[str, dict[str, np.ndarray]]:
    """Columns of each run, by its id."""
    rng, fleet = _draws(setup, "noise"), setup.fleet
    every = round(fleet.interval / fleet.step)
    return {
        plan.id: recorded(run, hidden_in(setup), fleet.noise, every, rng)
        for plan, run in zip(programme(setup), sailed(setup), strict=True)
    }


def write(setup: Setup, folder: Path) -> Path:
    """Write a campaign into a folder of its own below `folder`, and give its path."""
    home = folder / setup.name
    (home / "runs").mkdir(parents=True)
    for name, columns in records(setup).items():
        np.savetxt(
            home / "runs" / f"{name}.csv",
            np.column_stack(list(columns.values())),
            fmt="%.6g",
            delimiter=",",
            header=",".join(columns),
            comments="",
        )
    (home / "campaign.toml").write_text(_campaign(setup), encoding="utf-8")
    return home


def write_all(setups: Sequence[Setup], folder: Path) -> None:
    """Write campaigns, and what is hidden in each beside them, in ``truth.json``."""
    for setup in setups:
        write(setup, folder)
    truth = {setup.name: setup.truth for setup in setups}
    (folder / "truth.json").write_text(json.dumps(truth, indent=1), encoding="utf-8")


def _draws(setup: Setup, purpose: str) -> np.random.Generator:
    return np.random.default_rng(zlib.crc32(f"{setup!r} {purpose}".encode()))


def _campaign(setup: Setup) -> str:
    """The campaign file; it states a depth that the ship feels."""
    bottom, body = hidden_in(setup).bottom, setup.fleet.build(NOTHING).body
    depth = f"depth = {body.d / math.sqrt(bottom):.6g}\n" if bottom else ""
    head = f"""\
[campaign]
title = "{setup.fleet.title} free running"
kind = "free-running"
rudder_positive = "starboard"

[ship]
name = "{setup.fleet.model}"

[water]
rho = {body.rho}
g = 9.81
{depth}"""
    return "\n".join([head, *map(_run, programme(setup))])


def _run(plan: Plan) -> str:
    switch = "" if plan.switch is None else f"switch_deg = {plan.switch:.1f}\n"
    return f"""\
[[runs]]
id = "{plan.id}"
test = "{plan.test}"
file = "runs/{plan.id}.csv"
speed = {plan.speed}
rudder_deg = {plan.rudder:.1f}
{switch}"""
