"""The recorded speed of the carriage against the hull's, and against the speed that is stated."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Final

import numpy as np

from pmmkit.base import DataError
from pmmkit.campaigns import Attitude
from pmmkit.intake.checks.finding import Check, CheckFinding, figure
from pmmkit.numerics import Array
from pmmkit.signals import at_speed

if TYPE_CHECKING:
    import xarray as xr

    from pmmkit.campaigns import Campaign, Run
    from pmmkit.intake.checks.finding import Summary

AGREES: Final = 0.02
"""Share of the speed within which two speeds are the same."""
DIFFERS: Final = 0.10
"""Share beyond which one of them is wrong."""


def carriage_facts(run: Run, data: xr.Dataset, t: Array) -> dict[str, float]:
    """Mean speed of the carriage while it is at its speed, and that of the hull along the tank.

    t [s].
    """
    wanted = {
        name: data.variables[name] for name in ("U_carriage", "u", "v", "psi") if name in data
    }
    column = {
        name: np.asarray(series.values, float)
        for name, series in wanted.items()
        if series.dims == ("t",) and np.isfinite(series.values).all()
    }
    if "U_carriage" not in column:
        return {}
    try:
        travel = at_speed(t, column["U_carriage"])
        kept = slice(travel.start, travel.stop)
        facts = {"carriage": float(np.mean(column["U_carriage"][kept]))}
        if {"u", "v"} <= set(column) and not run.kind_of_test.surges:
            psi = column["psi"] if "psi" in column else _heading(run, data, t, kept)
            ahead, _ = Attitude(psi=psi).over_ground(column["u"], column["v"])
            facts["hull_ahead"] = float(np.mean(ahead[kept]))
    except DataError:
        return {}
    return facts


def _heading(run: Run, data: xr.Dataset, t: Array, kept: slice) -> Array:
    """The heading in the tank that the test was set to."""
    kind = run.kind_of_test
    if not kind.oscillates:
        return np.full_like(t, run.settings.drift)
    return kind.in_tank(run.settings, run.displacement_phase(data, t, within=kept)).psi


def examine_carriage(_campaign: Campaign, summaries: Sequence[Summary]) -> Iterator[CheckFinding]:
    """Speeds of the carriage that are not those stated, or not those of the hull along the tank."""
    towed = [item for item in summaries if "carriage" in item.facts]
    yield from _apart(
        towed,
        {item.run.id: item.run.settings.speed for item in towed},
        "the speed that the campaign file states",
        "Correct speed of these runs, or the unit of U_carriage under [columns].",
    )
    straight = [
        item for item in towed if "hull_ahead" in item.facts and not item.run.kind_of_test.circles
    ]
    yield from _apart(
        straight,
        {item.run.id: item.facts["hull_ahead"] for item in straight},
        "the speed along the tank, u cos ψ - v sin ψ, of the recorded u and v",
        "Look at the units and axes of u, v and U_carriage; u and v are those of the hull in ship "
        "axes. Leave out with = false the one that is wrong.",
    )


def _apart(
    items: Sequence[Summary], others: Mapping[str, float], what: str, remedy: str
) -> Iterator[CheckFinding]:
    """What is told where the carriage's speeds differ from others."""
    shares = {x.run.id: x.facts["carriage"] / others[x.run.id] - 1.0 for x in items}
    off = {name: share for name, share in shares.items() if not abs(share) <= AGREES}
    if off:
        worst = max(off, key=lambda name: abs(off[name]))
        own = next(item.facts["carriage"] for item in items if item.run.id == worst)
        yield CheckFinding(
            check="carriage",
            severity="error" if not abs(off[worst]) <= DIFFERS else "warning",
            message=f"U_carriage is not {what} in {len(off)} of {len(items)} runs: in {worst} "
            f"{figure(own, 4)} m/s against {figure(others[worst], 4)} m/s.",
            runs=tuple(off),
            remedy=remedy,
            numbers={"carriage": own, "other": others[worst]},
        )


CHECKS = (
    Check("carriage", "the carriage's speed against the hull's and the stated", examine_carriage),
)
