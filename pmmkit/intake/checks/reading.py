"""Reading a run once for the checks."""

from __future__ import annotations

import hashlib
import itertools
import json
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Final

import numpy as np
from numpy.typing import NDArray

from pmmkit.base import DataError
from pmmkit.campaigns import Campaign, Counted, Run, TankRecord
from pmmkit.intake.checks.carriage import carriage_facts
from pmmkit.intake.checks.clock import clock_facts
from pmmkit.intake.checks.density import density_facts
from pmmkit.intake.checks.finding import EMPTY, Summary
from pmmkit.intake.checks.free_running import record_facts
from pmmkit.intake.checks.gauges import change_facts, hold_facts
from pmmkit.intake.checks.late import late_facts
from pmmkit.intake.checks.record import flat_facts, spike_facts, without_spikes
from pmmkit.intake.checks.rest import rest_facts
from pmmkit.intake.checks.signs import axis_facts
from pmmkit.intake.checks.stated import set_facts
from pmmkit.intake.checks.static import SWINGS, wave_facts
from pmmkit.intake.checks.track import free_facts, motion_facts
from pmmkit.numerics import Array
from pmmkit.signals import FEWEST, CycleSums, FourierBasis, Window

if TYPE_CHECKING:
    import xarray as xr

    from pmmkit.effects import State

ORDER: Final = 3
FORCES: Final = ("X", "Y", "N", "K", "T", "Q", "FX_rudder", "FY_rudder")
MOTIONS: Final = ("u", "v", "r", "udot", "vdot", "rdot")
_HULL: Final = ("X", "Y", "N", "K")
_SKETCH: Final = 48
_PARTS: Final = 12
_GRID: Final = 64


@dataclass(frozen=True, kw_only=True, eq=False)
class KnownHistory:
    """What was found in a history before, so that it is not sought again.

    Parameters
    ----------
    channels : tuple of str
        The forces that told it.
    window : Window or None
        The steady part of a static record.
    counted : Counted or None
        The whole cycles of an oscillating record.
    motion : State
        At the samples of window or cycles.
    """

    channels: tuple[str, ...]
    window: Window | None
    counted: Counted | None
    motion: State


def summarise(run: Run, campaign: Campaign, *, known: KnownHistory | None = None) -> Summary:
    """Read a run once and keep what the checks need.

    Parameters
    ----------
    run : Run
        A run of the campaign.
    campaign : Campaign
        Its campaign.
    known : KnownHistory, optional
        What was found before.

    Returns
    -------
    Summary
        Quantities that the run does not hold, or that cannot be had (too short, no period
        stated), are left out; damaged samples are counted in ``facts`` and then passed over.
    """
    data = run.data
    if run.kind == "history":
        return _of_history(run, campaign, data, known)
    if run.kind == "harmonics":
        return _of_harmonics(run, data)
    means = {name: float(data[name]) for name in FORCES if name in data}
    values = np.array([means[name] for name in _HULL if name in means])
    return Summary(
        run=run,
        means=means,
        digest=_digest(values),
        sketch=_scaled(values),
        facts={**axis_facts(data), **set_facts(run, data)},
    )


def _of_harmonics(run: Run, data: xr.Dataset) -> Summary:
    cos, sin = {}, {}
    for name in FORCES:
        if f"{name}_cos" in data:
            cos[name] = _first(data[f"{name}_cos"].values)
            sin[name] = _first(data[f"{name}_sin"].values)
    values = np.concatenate(
        [part[name] for name in _HULL if name in cos for part in (cos, sin)] or [EMPTY]
    )
    values = values[np.isfinite(values)]
    means = {name: float(part[0]) for name, part in cos.items()}
    for name, (cosines, sines) in _nominal(run).items():
        cos[name], sin[name] = cosines, sines
    return Summary(
        run=run,
        means=means,
        cos=cos,
        sin=sin,
        digest=_digest(values),
        sketch=_scaled(values),
        facts=axis_facts(data),
    )


def _of_history(
    run: Run, campaign: Campaign, data: xr.Dataset, known: KnownHistory | None
) -> Summary:
    raw = np.asarray(data["t"].values, float)
    facts = {**clock_facts(raw), **density_facts(data), **axis_facts(data)}
    asked = campaign.kind == "captive" and known is None  # what is known was asked before
    if asked and (refused := run.clock_problem(raw)):
        return Summary(run=run, facts=facts, refused=refused)
    columns = {
        name: np.asarray(data.variables[name].values, float)
        for name in (*FORCES, *(("x", "y") if campaign.kind == "free-running" else ()))
        if name in data and data.variables[name].dims == ("t",)
    }
    columns = {
        name: part
        for name, part in columns.items()
        if np.count_nonzero(np.isfinite(part)) >= FEWEST
    }
    present = [name for name in FORCES if name in columns]
    for name in _HULL:
        if name in columns:
            facts |= {f"{name}_flat_{k}": v for k, v in flat_facts(columns[name]).items()}
            facts |= {f"{name}_{k}": v for k, v in hold_facts(columns[name]).items()}
    digest = _digest(*(columns[name] for name in (*_HULL, "x", "y") if name in columns))
    order = _usable(raw, columns)
    if len(order) < 16:
        return Summary(run=run, digest=digest, facts=facts)
    whole = np.array_equal(order, np.arange(len(raw)))
    t = raw if whole else raw[order]
    clean = data if whole else data.isel(t=order)
    if campaign.kind == "free-running":
        free = {**free_facts(clean, t), **record_facts(run, campaign, clean, t)}
        return Summary(run=run, digest=digest, facts={**facts, **free})
    forces = np.zeros((len(present), len(t)))
    for row, name in zip(forces, present, strict=True):
        row[:] = columns[name] if whole else columns[name][order]
    facts |= motion_facts(run, clean, t)
    facts |= carriage_facts(run, clean, t) | set_facts(run, clean)
    tared = json.loads(data.attrs.get("tared", "{}"))
    motion = {
        name: np.asarray(clean.variables[name].values, float)
        for name in ("U_carriage", "y", "psi")
        if name in clean and clean.variables[name].dims == ("t",)
    }
    facts |= rest_facts(t, {**motion, **dict(zip(present, forces, strict=True))}, tared)
    at = np.linspace(0, len(t) - 1, _SKETCH).astype(int)
    hull = [row for row, name in enumerate(present) if name in _HULL]
    shared: dict[str, Any] = {
        "run": run,
        "digest": digest,
        "facts": facts,
        "sketch": _scaled(forces[hull][:, at].ravel()),
    }
    if not present:
        return Summary(**shared)
    same = known if clean is data and known and known.channels == (*present,) else None
    if run.dynamic:
        return _oscillating(run, clean, t, present, forces, shared, same)
    window = (same and same.window) or TankRecord(
        run=run, data=clean, times=t, forces=forces, names=present
    ).window()
    inside = slice(window.start, window.stop)
    part = forces[:, inside]
    moved = [
        np.asarray(clean.variables[name].values, float)[inside]
        for name in SWINGS
        if name in clean and clean.variables[name].dims == ("t",)
    ]
    waves = wave_facts(t[inside], part[present.index("X")], moved) if "X" in present else {}
    gauges = _gauge_facts(t[inside], part, None, present) | _spike_facts(forces, present, inside)
    told = {} if window.steady else {"unsteady_from": float(t[window.start])}
    shared["facts"] = facts | gauges | waves | told
    noise = _mean_noise(_calm(part, gauges, present))
    return Summary(
        means=dict(zip(present, part.mean(axis=1).tolist(), strict=True)),
        harmonic_noise=dict(zip(present, noise.tolist(), strict=True)),
        **shared,
    )


def _gauge_facts(
    t: Array, forces: Array, theta: Array | None, names: Sequence[str]
) -> dict[str, float]:
    """Steps, creep and noise of each channel over what counts of the record."""
    jitter = np.diff(forces, 2, axis=1).std(axis=1) if forces.shape[1] > 3 else np.zeros(len(names))
    found = {f"{name}_noise": float(size) for name, size in zip(names, jitter, strict=True)}
    for name, own in zip(names, change_facts(t, forces, theta), strict=True):
        found |= {f"{name}_{key}": value for key, value in own.items()}
    return found


def _spike_facts(
    forces: Array, names: Sequence[str], counts: slice = slice(None)
) -> dict[str, float]:
    """Spikes of each channel, and how they move the mean of what counts."""
    return {
        f"{name}_{key}": value
        for name, values in zip(names, forces, strict=True)
        for key, value in spike_facts(values, counts).items()
    }


def _calm(forces: Array, facts: Mapping[str, float], names: Sequence[str]) -> Array:
    """Forces without spikes, which are no noise."""
    return np.stack(
        [
            without_spikes(values) if f"{name}_spikes" in facts else values
            for name, values in zip(names, forces, strict=True)
        ]
    )


def _mean_noise(part: Array) -> Array:
    """Standard error of the mean of each record from the scatter of twelve parts of it."""
    size = part.shape[1] // _PARTS
    if not size:
        return np.zeros(len(part))
    parts = part[:, : size * _PARTS].reshape(len(part), _PARTS, size).mean(axis=2)
    return np.asarray(parts.std(axis=1, ddof=1) / math.sqrt(_PARTS))


def _oscillating(
    run: Run,
    data: xr.Dataset,
    t: Array,
    names: list[str],
    forces: Array,
    shared: Mapping[str, Any],
    known: KnownHistory | None,
) -> Summary:
    """Harmonics of the whole cycles without transient, and of each cycle."""
    try:
        if known is not None and known.counted is not None and known.counted.channels:
            counted, state = known.counted, known.motion
        else:
            counted = TankRecord(run=run, data=data, times=t, forces=forces, names=names).cycles()
            part = counted.cut
            state = run.measured_motion(data, t[part], counted.kept, within=part)
    except DataError as error:
        if known is None or known.counted is None:
            return Summary(refused=error.problems[0], **shared)
        counted, state = known.counted, known.motion  # the cycles that were asked for
    part, theta = counted.cut, counted.kept.phase
    moving = slice(counted.travel.start, counted.travel.stop)
    project = counted.kept.projector[: 2 * ORDER + 1]
    found = dict(zip(names, map(_split, forces[:, part] @ project.T), strict=True))
    found |= _split_motion(state, project)
    found |= {f"nominal_{name}": parts for name, parts in _nominal(run).items()}
    travelled = counted.basis.within(moving)
    gauges = _gauge_facts(t[part], forces[:, part], theta, names)
    gauges |= _spike_facts(forces[:, part], names)
    calm, sums = forces[:, moving], counted.sums
    if any(f"{name}_spikes" in gauges for name in names):
        calm = _calm(calm, gauges, names)
        sums = CycleSums.of(calm, travelled.rows, sums.edges)
    single, noise = _by_cycle(travelled, calm, sums)
    count = max(counted.cycles.count, 1)
    hull = [(row, name) for row, name in enumerate(names) if name in _HULL]
    balance = {name: forces[row, moving] for row, name in hull}
    late = late_facts(t[moving], travelled, balance)
    more = {**shared, "facts": {**shared["facts"], **gauges, **late}}
    return Summary(
        means={name: float(found[name][0][0]) for name in names},
        cos={name: cosines for name, (cosines, _) in found.items()},
        sin={name: sines for name, (_, sines) in found.items()},
        cycles={name: single[:, row] for row, name in hull} if len(single) else {},
        cycle_noise={name: float(noise[row]) for row, name in hull},
        harmonic_noise={name: float(noise[row]) / math.sqrt(count) for row, name in hull},
        **more,
    )


def _by_cycle(basis: FourierBasis, forces: Array, sums: CycleSums) -> tuple[Array, Array]:
    """Coefficients of each cycle (cycles, channels, 7), and the noise of a first harmonic.

    The noise is that of the residual of a fit of order 6 to each cycle, widened for the
    correlation of neighbouring samples.
    """
    nothing = np.zeros((0, len(forces), 2 * ORDER + 1)), np.zeros(len(forces))
    size = np.diff(sums.edges)
    if not size.size or size.min() < 4 * ORDER + 4:
        return nothing
    order = min(2 * ORDER, int(size.min()) // 4)
    rows = basis.up_to(order).rows
    single = sums.up_to(order).single
    noise = []
    for fitted, (start, stop) in zip(single, itertools.pairwise(sums.edges), strict=True):
        rest = forces[:, start:stop] - fitted @ rows[:, start:stop]
        power = np.vecdot(rest, rest)
        lag = np.vecdot(rest[:, 1:], rest[:, :-1])
        rho = np.clip(np.divide(lag, power, out=np.zeros_like(lag), where=power > 0), 0, 0.98)
        free = max(stop - start - len(rows), 1)
        noise.append(np.sqrt(2 * power / free / (stop - start) * (1 + rho) / (1 - rho)))
    return single[:, :, : 2 * ORDER + 1], np.median(noise, axis=0)


def _nominal(run: Run) -> dict[str, tuple[Array, Array]]:
    """Harmonics of the motion that the test was set to; nothing where its settings do not say."""
    basis = FourierBasis.at(np.linspace(0, 2 * np.pi, _GRID, endpoint=False), ORDER)
    try:
        return _split_motion(run.motion_at_phase(basis.phase), basis.projector)
    except DataError:
        return {}


def _split_motion(state: State, project: Array) -> dict[str, tuple[Array, Array]]:
    """Harmonics of the motions, cosines and sines, by name."""
    return {name: _split(project @ getattr(state, name)) for name in MOTIONS}


def _split(coefficients: Array) -> tuple[Array, Array]:
    return (
        np.concatenate((coefficients[:1], coefficients[1::2])),
        np.concatenate((np.zeros(1), coefficients[2::2])),
    )


def _first(values: Array) -> Array:
    """Harmonics 0 to 3, nan where the row has fewer."""
    out = np.full(ORDER + 1, np.nan)
    take = np.asarray(values, float)[: ORDER + 1]
    out[: len(take)] = take
    return out


def _usable(t: Array, columns: Mapping[str, Array]) -> NDArray[np.intp]:
    """Indices of the samples with a time and all forces, in order of time, each time once."""
    good = np.isfinite(t)
    for name in _HULL:
        if name in columns:
            good &= np.isfinite(columns[name])
    index = np.flatnonzero(good)
    if np.all(np.diff(t[index]) > 0):
        return index
    _, first = np.unique(t[index], return_index=True)
    return index[first]


def _digest(*parts: Array) -> str:
    """Of the values of the parts, one after another; empty where there is none but zero."""
    if not any(np.any(part) for part in parts):
        return ""
    digest = hashlib.sha256()
    for part in parts:
        digest.update(np.ascontiguousarray(part).data)
    return digest.hexdigest()


def _scaled(values: Array) -> Array:
    return values if np.all(np.isfinite(values)) else EMPTY
