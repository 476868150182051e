"""Results as a workshop asks for them: ASCII, comma separated, ``name [unit]`` over columns."""

from __future__ import annotations

import csv
import io
import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from pmmkit.base import CampaignError, DataError, Problem
from pmmkit.campaigns import Attitude, Campaign, Rig, Run
from pmmkit.conventions import CHANNEL_UNITS, CHANNELS
from pmmkit.numerics import Array
from pmmkit.presentation import safe_cell
from pmmkit.reduction import PreparedRun, one_cycle
from pmmkit.signals import design_matrix
from pmmkit.syntax import plain

# What a workshop asks of a captive run: means of static ones, one cycle of oscillating ones.


MOTION: Final = {name: name for name in ("u", "v", "r", "udot", "vdot", "rdot")}
HELD: Final = {"phi": "phi", "delta": "delta", "n": "rps"}
"""Channels that a test holds, and their names in `State`."""


@dataclass(frozen=True, kw_only=True, eq=False)
class SimmanResult:
    """The means of a static run, or the Fourier coefficients of an oscillating one.

    `run`: the run, with the period that its record has. `labels`: ``C0``, or ``C0, C1, S1, C2
    …`` with the displacement ∝ sin θ. `force (m,)`: force of the water at midship, without the
    inertia of the model [N, N m]; NaN where the source gives no such coefficient. `std (m,)`:
    their standard uncertainties from the noise of the record, where they are known. `motion
    (m,)`: velocities and accelerations of midship, heel, rudder, revolutions, SI and radians.
    `extras`: means of further channels: thrust, sinkage …. `samples`: samples that count; 0
    where the source is a table. `cycles`: whole cycles that count. `begin, end`: times of the
    first and the last sample that counts [s]; NaN without a record.
    """

    run: Run
    labels: tuple[str, ...]
    force: Mapping[str, Array]
    std: Mapping[str, Array]
    motion: Mapping[str, Array]
    extras: Mapping[str, float]
    samples: int
    cycles: int | None
    begin: float
    end: float

    @property
    def recorded(self) -> bool:
        """Whether there is a record, and not a row of a table alone."""
        return self.samples > 0


def results_of(campaign: Campaign) -> list[SimmanResult]:
    """The results of all captive runs, as `reduce` takes them."""
    rig = campaign.rig
    found: list[SimmanResult] = []
    problems: list[Problem] = []
    for run in campaign.runs:
        try:
            found.append(_result(PreparedRun.of(run, campaign), rig))
        except DataError as error:
            problems += [replace(item, run=item.run or run.id) for item in error.problems]
    if problems:
        raise CampaignError(problems, title=f"{campaign.title!r} has no results to hand in")
    return found


def _result(prepared: PreparedRun, rig: Rig) -> SimmanResult:
    result = prepared.result
    motion = prepared.motion_at_midship(rig)
    recorded = result.run.kind == "history"
    return SimmanResult(
        run=result.run,
        labels=result.labels,
        force=_handed_in(prepared, rig),
        std={
            name: np.sqrt(np.diag(matrix))
            for name, matrix in result.covariance.items()
            if matrix is not None
        },
        motion={
            name: prepared.projection @ getattr(motion, attribute)
            for name, attribute in {**MOTION, **HELD}.items()
        },
        extras=result.extras,
        samples=result.samples if recorded else 0,
        cycles=result.cycles,
        begin=float(prepared.t[0]) if recorded else np.nan,
        end=float(prepared.t[-1]) if recorded else np.nan,
    )


def _handed_in(prepared: PreparedRun, rig: Rig) -> dict[str, Array]:
    """Harmonics of the force of the water; what a record was not fitted to is zero in it."""
    order = prepared.result.smoothed
    force = prepared.water_force(rig)
    if order is None:
        return force
    return {name: np.where(np.arange(len(x)) > 2 * order, 0.0, x) for name, x in force.items()}


def cycle_of(result: SimmanResult) -> dict[str, Array]:
    """One cycle from its Fourier coefficients, at equal steps from the displacement's
    upcrossing."""
    order = int(result.labels[-1][1:])
    theta = one_cycle()
    basis = design_matrix(theta, order)
    omega = result.run.settings.omega or 1.0
    t = theta / omega
    known = {name: x for name, x in result.force.items() if np.isfinite(x).all()}
    moved = {name: basis @ x for name, x in result.motion.items()}
    psi = result.run.settings.drift + _integral(moved["r"], omega)
    u, v = moved["u"], moved["v"]
    ahead, aside = Attitude(psi=psi).over_ground(u, v)
    x = ahead.mean() * t + _integral(ahead, omega)
    y = aside.mean() * t + _integral(aside, omega)
    forces = {name: basis @ x for name, x in known.items()}
    return {"t": t, **forces, "x": x - x[0], "y": y, "psi": psi, **moved}


def _integral(values: Array, omega: float) -> Array:
    """Integral over time of what a cycle holds beside its mean, itself with a mean of zero."""
    size = len(values)
    spectrum = np.fft.rfft(values)
    orders = np.arange(len(spectrum))
    spectrum[0] = 0.0
    spectrum[1:] /= 1j * omega * orders[1:]
    return np.asarray(np.fft.irfft(spectrum, size), np.float64)


Row = dict[str, str | float]


def static_means(results: Sequence[SimmanResult]) -> str:
    """A row per static run: means of forces and motions, standard uncertainties of the means."""
    rows = []
    for item in results:
        if item.run.dynamic:
            continue
        means = {_titled(name): float(x[0]) for name, x in item.force.items()}
        doubts = {_titled(f"{name}_std", name): float(x[0]) for name, x in item.std.items()}
        rows.append(
            {
                **_head(item),
                _titled("psi"): item.run.settings.drift,
                **means,
                **doubts,
                **{_titled(name): float(item.motion[name][0]) for name in MOTION},
                **_held(item, results),
                **{_titled(name): x for name, x in item.extras.items()},
                "samples": item.samples or math.nan,
                "t_start [s]": item.begin,
                "t_end [s]": item.end,
            }
        )
    return _text(rows)


def fourier_coefficients(results: Sequence[SimmanResult]) -> str:
    """A row per oscillating run: means, cosines and sines of forces and velocities."""
    return _text(
        {
            **_head(item),
            "period [s]": item.run.settings.period or math.nan,
            "cycles": item.cycles or math.nan,
            **_coefficients(item, {**item.force, **{x: item.motion[x] for x in ("u", "v", "r")}}),
            **_held(item, results),
            **{_titled(f"{name}_mean", name): x for name, x in item.extras.items()},
        }
        for item in results
        if item.run.dynamic
    )


def fourier_uncertainties(results: Sequence[SimmanResult]) -> str:
    """The same, of the coefficients of forces: standard uncertainties from the noise of the record.

    Runs of which nothing is known are left out; the text is empty where that is all of them.
    """
    return _text(
        {**_head(item), **_coefficients(item, item.std)}
        for item in results
        if item.run.dynamic and item.std
    )


def one_cycle_series(result: SimmanResult, results: Sequence[SimmanResult]) -> str:
    """One cycle of a run over time."""
    values = cycle_of(result)
    shown = _shown(results)
    kept = {name: x for name, x in values.items() if name not in HELD or name in shown}
    return _series({_titled(name): x for name, x in kept.items()})


def _head(item: SimmanResult) -> Row:
    run = item.run
    return {"run": safe_cell(plain(run.id)), "test": run.test, _titled("speed"): run.settings.speed}


def _coefficients(item: SimmanResult, values: Mapping[str, Array]) -> Row:
    parts = {"C": "cos", "S": "sin"}
    found: Row = {}
    for name, numbers in values.items():
        for label, number in zip(item.labels, numbers.tolist(), strict=True):
            part = "mean" if label == "C0" else f"{parts[label[0]]}{label[1:]}"
            found[_titled(f"{name}_{part}", name)] = number
    return found


def _held(item: SimmanResult, results: Sequence[SimmanResult]) -> Row:
    """Heel, rudder and revolutions, those that are not zero in all runs."""
    return {_titled(name): float(item.motion[name][0]) for name in _shown(results)}


def _shown(results: Iterable[SimmanResult]) -> list[str]:
    every = list(results)
    return [name for name in HELD if any(item.motion[name].any() for item in every)]


def _titled(name: str, channel: str | None = None) -> str:
    return f"{name} [{CHANNEL_UNITS[channel or name]}]"


def _text(rows: Iterable[Mapping[str, str | float]]) -> str:
    """Rows under all their columns; what a run does not have is left empty."""
    every = list(rows)
    titles = _in_order(dict.fromkeys(title for row in every for title in row))
    if not every:
        return ""
    room = io.StringIO(newline="")
    writer = csv.writer(room, lineterminator="\n")
    writer.writerow(titles)
    for row in every:
        writer.writerow([_cell(row.get(title, math.nan)) for title in titles])
    return room.getvalue()


def _in_order(titles: Iterable[str]) -> list[str]:
    """Columns of K, which few runs have, beside those of X, Y and N."""
    every = list(titles)
    forces = [title for title in every if title.partition(" ")[0].partition("_")[0] in CHANNELS]
    first = min((every.index(title) for title in forces), default=0)
    rest = [title for title in every if title not in forces]
    ordered = [
        title for name in CHANNELS for title in forces if title.startswith((f"{name} ", f"{name}_"))
    ]
    return [*rest[:first], *ordered, *rest[first:]]


def _series(columns: Mapping[str, Array]) -> str:
    lines = [",".join(columns)]
    lines += [
        ",".join(map(repr, row))
        for row in zip(*(x.tolist() for x in columns.values()), strict=True)
    ]
    return "\n".join(lines) + "\n"


def _cell(value: str | float) -> str:
    if isinstance(value, str):
        return value
    return "" if math.isnan(value) else repr(value)
