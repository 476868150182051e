"""The figures of a report, made from a reduction."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING, Final

import numpy as np

from pmmkit.base import TableError
from pmmkit.campaigns import TEST_KINDS, TankRecord
from pmmkit.conventions import CHANNEL_UNITS
from pmmkit.intake import CheckFinding
from pmmkit.models import ReferenceTable
from pmmkit.presentation import Picture, figure_text
from pmmkit.reduction import Reduction, Rows, RunResult
from pmmkit.views.figures.captions import drawn
from pmmkit.views.figures.derivatives import (
    beside_reference,
    correlated,
    correlations,
    derivatives_over_froude,
    strongest,
)
from pmmkit.views.figures.forces import (
    Cycle,
    CycleForces,
    DriftPoints,
    cycles_by_froude,
    forces_over_drift,
    over_a_cycle,
    unit_in,
)
from pmmkit.views.figures.forests import farthest, forest
from pmmkit.views.figures.inspecting import zeros_over_the_day

if TYPE_CHECKING:
    from pmmkit.models import DerivativeTable
    from pmmkit.plotting import Figure


# Figures of what the checks found.


def zeros_at_rest(finding: CheckFinding) -> Figure:
    """What the gauges show at rest, run by run in the order of the day.

    Parameters
    ----------
    finding : CheckFinding
        Of the check ``zeros``.
    """
    runs = finding.by_run
    channels = finding.gauges
    return zeros_over_the_day(
        list(runs),
        {name: np.array([x.get(name, np.nan) for x in runs.values()]) for name in channels},
        {
            name: np.array([x.get(f"{name}_std", np.nan) for x in runs.values()])
            for name in channels
        },
        CHANNEL_UNITS,
    )


_SHOWN: Final = ("X", "Y", "N")
_WIDE: Final = 12
"""Derivatives from which on their matrix takes the whole width."""
_ALL: Final = "regression over all runs"


def of_forces(reduction: Reduction) -> Iterator[Picture]:
    """Static forces over the drift angle, and oscillating ones over a cycle."""
    points = drift_points(reduction)
    if points:
        yield drawn(
            forces_over_drift(points, reduction.table, channels=_channels(reduction)),
            "Static drift: mean forces (95 % intervals as bars) and what the derivatives "
            "of all runs together make of them (lines, 95 % bands).",
        )
    yield drawn(
        reduction.plot(),
        "What the fit leaves of means and harmonics, over what it fits: a row a kind of test, with "
        "its root mean square. A curve or a slope means that the structure lacks something.",
        file="residuals",
    )
    cycles = typical_cycles(reduction)
    if cycles:
        yield drawn(
            over_a_cycle(cycles, channels=_channels(reduction)),
            "Oscillating tests: the cycles that count, on top of each other, and their "
            "harmonics. One run per kind of test is shown, that with the largest amplitude at "
            "the middle speed.",
        )
    compared = cycles_at_speeds(reduction)
    if compared:
        yield drawn(
            cycles_by_froude(
                compared,
                channels=_channels(reduction),
                stroke="''" if reduction.table.convention.system == "bis" else "'",
            ),
            "Forces of the water over a cycle of the same motion at several speeds, by their "
            "harmonics, with 95 % bands: curves that lie on top of each other do not depend on the "
            "Froude number.",
            file="cycles_by_froude",
        )


def of_derivatives(table: DerivativeTable, reference: ReferenceTable | None) -> Iterator[Picture]:
    """Derivatives over the Froude number, and beside a reference."""
    if not table.pooled and np.any(np.isfinite(table.value).sum(axis=0) > 1):
        figure = derivatives_over_froude(
            table,
            reference=reference.table if reference else None,
            reference_name=reference.name if reference else "",
        )
        yield drawn(figure, "Derivatives over the Froude number with 95 % intervals.")
    matrix = _correlations(table)
    if matrix is not None:
        names, values = correlated(table)
        yield drawn(
            matrix,
            "Correlation of the derivatives: what stands near ±1 is known together, not apart.",
            facts=strongest(names, values),
            narrow=len(names) < _WIDE,
            file="correlation",
        )
    if reference is not None:
        figure = beside_reference(table, reference.table, reference_name=reference.name)
        yield drawn(
            figure,
            f"Each derivative over its value in {reference.name}, with its 95 % interval: "
            "at 1 they agree.",
        )


def _correlations(table: DerivativeTable) -> Figure | None:
    """The correlation matrix of a table; none where fewer than two derivatives have a value."""
    try:
        return correlations(table)
    except TableError:
        return None


def _forest(tables: Mapping[str, DerivativeTable], beside: ReferenceTable | None) -> Figure:
    """Several tables side by side with published values, where there are any."""
    return forest(
        tables,
        reference=beside.table if beside else None,
        reference_name=beside.name if beside else "",
    )


def of_families(reduction: Reduction, beside: ReferenceTable | None) -> Iterator[Picture]:
    """The forest plot of the families of tests; none where no family has derivatives."""
    shared = {
        title: table
        for title, table in reduction.families.items()
        if any(np.isfinite(table[name]).any() for name in table.names if name in reduction.table)
    }
    if shared:
        yield drawn(
            _forest({_ALL: reduction.table, **shared}, beside),
            "Each family of tests alone less all runs together, over half of the 95 % "
            "interval of all runs (grey): bars are 95 % intervals, numbers stand for what lies "
            "outside.",
            facts=farthest({_ALL: reduction.table, **reduction.families}),
            file="families",
        )


def of_methods(reduction: Reduction, beside: ReferenceTable | None) -> Iterator[Picture]:
    """The forest plot of a reduction by several methods."""
    tables = {estimate.method: estimate.table for estimate in reduction.estimates.values()}
    if len(tables) > 1:
        yield drawn(
            _forest(tables, beside),
            "Every method less the global regression, over half of the regression's 95 % "
            "interval (grey): bars are 95 % intervals, numbers stand for what lies outside.",
            facts=farthest(tables),
            file="methods",
        )


def of_findings(reduction: Reduction) -> Iterator[Picture]:
    """What the gauges show at rest over the day, where the checks tell it."""
    for item in reduction.findings:
        if item.by_run:
            yield drawn(
                zeros_at_rest(item),
                "Zeros of the gauges at rest, run by run in the order of the day, with 95 % "
                "intervals; the line is their mean.",
                facts=[item.message],
                file=item.check,
            )


def drift_points(reduction: Reduction) -> list[DriftPoints]:
    """Means of the steady runs that drift and do nothing else, a set per Froude number."""
    steady = [item for item in reduction.rows if item.result.run.kind_of_test.steady]
    found = [item for item in steady if item.result.run.kind_of_test.varies == ("v",)]
    sets = []
    for froude in sorted({round(item.result.froude, 3) for item in found}):
        rows = [item for item in found if round(item.result.froude, 3) == froude]
        rows.sort(key=lambda item: item.result.run.settings.drift)
        channels = [c for c in _SHOWN if all(c in item.force for item in rows)]
        sets.append(
            DriftPoints(
                froude=float(np.mean([item.result.froude for item in rows])),
                drift=np.array([item.result.run.settings.drift for item in rows]),
                force={c: np.array([item.force[c][0] for item in rows]) for c in channels},
                std={c: np.array([_std(item.result, c) for item in rows]) for c in channels},
                thrust=np.array([item.result.extras.get("T", 0.0) for item in rows]),
            )
        )
    return sets


def _std(result: RunResult, channel: str) -> float:
    covariance = result.covariance.get(channel)
    return float("nan") if covariance is None else float(np.sqrt(covariance[0, 0]))


def typical_cycles(reduction: Reduction) -> list[Cycle]:
    """One run of each oscillating test, over the phase of its motion."""
    cycles = []
    for kind in (x for x in TEST_KINDS.values() if x.captive):
        results = [
            item
            for item in reduction.runs
            if kind.oscillates and item.run.test == kind.name and item.run.kind == "history"
        ]
        if results:
            cycles.append(_cycle(_typical(results), reduction))
    return cycles


def cycles_at_speeds(reduction: Reduction) -> dict[str, list[CycleForces]]:
    """Runs of each oscillating test that differ in the speed alone, by title.

    Of the amplitudes and frequencies ωL/U that were tried at several speeds the largest amplitude
    is taken; tests for which there are none are left out.
    """
    found = {}
    for kind in (x for x in TEST_KINDS.values() if x.captive):
        rows = [x for x in reduction.rows if kind.oscillates and x.result.run.test == kind.name]
        alike: dict[tuple[float, ...], dict[float, Rows]] = {}
        for item in rows:
            alike.setdefault(_motion_of(item.result, reduction.table), {}).setdefault(
                round(item.result.froude, 3), item
            )
        several = {motion: own for motion, own in alike.items() if len(own) > 1}
        if several:
            best = max(several, key=lambda motion: (len(several[motion]), motion))
            speeds = several[best]
            found[f"{kind.title}, ω′ {best[-1]:g}"] = [
                _non_dimensional(speeds[froude], reduction.table) for froude in sorted(speeds)
            ]
    return found


def _motion_of(result: RunResult, table: DerivativeTable) -> tuple[float, ...]:
    """Amplitudes over length and speed, drift and reduced frequency, as near as counts."""
    settings = result.run.settings
    pace = table.ship.speed(result.froude, table.water.g) / table.ship.L
    omega = (result.frequency or 0.0) / pace
    sway = (settings.amplitude or 0.0) / table.ship.L * omega
    yaw = (settings.yaw_amplitude or 0.0) * omega
    rudder = settings.rudder_amplitude or 0.0
    return *(round(x, 2) for x in (sway, yaw, rudder, settings.drift)), round(omega, 1)


def _non_dimensional(item: Rows, table: DerivativeTable) -> CycleForces:
    result = item.result
    units = {channel: unit_in(table, channel, result.froude) for channel in item.force}
    return (
        result.froude,
        {channel: x / units[channel] for channel, x in item.force.items()},
        {
            channel: V / units[channel] ** 2
            for channel, V in result.covariance.items()
            if V is not None and channel in units
        },
    )


def _typical(results: list[RunResult]) -> RunResult:
    speeds = sorted({item.froude for item in results})
    middle = speeds[len(speeds) // 2]
    return max(
        (item for item in results if item.froude == middle),
        key=lambda item: (
            item.run.settings.yaw_amplitude
            or item.run.settings.amplitude
            or item.run.settings.largest_rudder,
            abs(item.run.settings.drift),
        ),
    )


def _cycle(result: RunResult, reduction: Reduction) -> Cycle:
    data = result.run.data
    times = np.asarray(data["t"].values, float)
    channels = [name for name in _SHOWN if name in result.measured]
    record = np.stack([np.asarray(data[name].values, float) for name in channels])
    asked = reduction.table.provenance.get("cycles")
    counted = TankRecord(
        run=result.run, data=data, times=times, forces=record, names=channels
    ).cycles(asked)
    theta, cut = counted.theta, slice(counted.cycles.start, counted.cycles.stop)
    kind = result.run.kind_of_test
    return Cycle(
        title=f"{kind.title}, Fn {result.froude:.3f}\n{figure_text(result.run.id)}",
        theta=theta[cut],
        samples={name: values[cut] for name, values in zip(channels, record, strict=True)},
        coefficients={name: result.measured[name] for name in channels},
    )


def _channels(reduction: Reduction) -> list[str]:
    return [c for c in _SHOWN if any(c in item.measured for item in reduction.runs)]
