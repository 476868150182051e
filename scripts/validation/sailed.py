"""Published turns and zigzags beside those of our simulator."""

from __future__ import annotations

from collections.abc import Mapping
from functools import cache
from typing import Any, Final

from pmmkit.conventions import METRICS
from pmmkit.models import Model
from pmmkit.simulation import simulate
from scripts.validation.published import Published, Values, table

TITLES: Final = {item.name: item.title for item in METRICS.values()}
Turns = Mapping[tuple[float, str], float]
"""Rudder [deg] and metric to the published value."""
Zigzags = Mapping[tuple[float, float], tuple[float, ...]]
"""Rudder and heading [deg], rudder first to starboard if positive, to the published overshoots."""


def side(rudder_deg: float) -> str:
    """Angle and side of a rudder in words."""
    return f"{abs(rudder_deg):g}° to {'starboard' if rudder_deg > 0 else 'port'}"


def of_turn(rudder_deg: float, metric: str) -> str:
    """What a metric of a turn is called."""
    return f"{TITLES[metric.removesuffix('_L')]}, {side(rudder_deg)}"


def of_zigzag(rudder_deg: float, switch_deg: float, number: int) -> str:
    """What an overshoot is called."""
    ordinal = {1: "first", 2: "second", 3: "third"}[number]
    first = "starboard" if rudder_deg > 0 else "port"
    return f"{ordinal} overshoot, {abs(rudder_deg):g}/{switch_deg:g} to {first}"


def turns(
    title: str, model: str | Model, speed: float, values: Turns, *, rate: float | None = None,
    **more: Any,
) -> tuple[Published, ...]:  # fmt: skip
    """Figures of turning circles; `more` goes to `table`."""

    @cache
    def ours() -> Values:
        found = {
            angle: simulate(model, speed=speed, rudder_deg=angle, rudder_rate_deg=rate).metrics
            for angle in dict.fromkeys(angle for angle, _ in values)
        }
        return {of_turn(*key): found[key[0]][key[1]] for key in values}

    named = {of_turn(*key): value for key, value in values.items()}
    units = {of_turn(*key): "L" for key in values if key[1].endswith("_L")}
    return table(title, named, ours, unit=units, **more)


def zigzags(
    title: str, model: str | Model, speed: float, values: Zigzags, *, rate: float | None = None,
    **more: Any,
) -> tuple[Published, ...]:  # fmt: skip
    """Overshoot angles [deg] of zigzags; `more` goes to `table`."""

    @cache
    def ours() -> Values:
        return {
            of_zigzag(rudder, switch, number): found[f"overshoot_{number}_deg"]
            for (rudder, switch), angles in values.items()
            for found in [sailed(model, speed, rudder, switch, len(angles), rate)]
            for number in range(1, len(angles) + 1)
        }

    named = {
        of_zigzag(rudder, switch, number): angle
        for (rudder, switch), angles in values.items()
        for number, angle in enumerate(angles, start=1)
    }
    return table(title, named, ours, unit="°", **more)


def sailed(
    model: str | Model, speed: float, rudder: float, switch: float, count: int, rate: float | None
) -> Mapping[str, float]:
    """Metrics of a zigzag."""
    return simulate(
        model,
        "zigzag",
        speed=speed,
        rudder_deg=rudder,
        switch_deg=switch,
        executes=count + 1,
        rudder_rate_deg=rate,
    ).metrics
