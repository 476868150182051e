"""What the recorded motion says of a test: kind, speed, drift angle, period, amplitudes."""

from __future__ import annotations

import itertools
import math
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, field, replace
from types import MappingProxyType
from typing import Final

import numpy as np

from pmmkit.base import DataError
from pmmkit.campaigns import RUN_SETTINGS, TEST_KINDS, TestKind
from pmmkit.intake.blocks import held_too, kind_with
from pmmkit.intake.checks.positions import METRES_PER_DEGREE
from pmmkit.intake.folder import FileGroup, Look
from pmmkit.intake.guessing import suggest
from pmmkit.intake.seen import ColumnLook, FileLook
from pmmkit.numerics import Array, dead_reckoned, unwrapped
from pmmkit.presentation import WIDE
from pmmkit.signals import FEWEST, at_size, at_speed, design_matrix, estimate_frequency

# Columns of histories that say the drift angle: a setting, and no channel.


def with_drift(seen: Look) -> Look:
    """With a remark at columns that are no channel, and say the drift angle of their runs."""
    return replace(seen, groups=tuple(_drift_told(group) for group in seen.groups))


def _drift_told(group: FileGroup) -> FileGroup:
    found = drift_column(group.first) if group.first.kind == "history" else None
    if found is None:
        return group
    columns = tuple(
        replace(column, remark="it says the drift angle of each run")
        if column.position == found.position
        else column
        for column in group.first.columns
    )
    return replace(group, files=(replace(group.first, columns=columns), *group.files[1:]))


def drift_column(look: FileLook) -> ColumnLook | None:
    """A column of a history that is the drift angle: no channel of ours, but a setting."""
    for column in look.columns:
        if column.suggestion is None and column.numbers:
            (found,) = suggest([column.header], [column.unit], {}, table=True)
            if found is not None and found.name == "drift_deg":
                unit = found.unit or column.unit or "deg"
                return replace(column, suggestion=replace(found, unit=unit))
    return None


_SETTLING: Final = 0.15
"""Part of a record at its beginning that is left out."""
_COHERENT: Final = 0.5
"""Share of a channel's variance that one frequency must explain for it to oscillate."""
_PULLED_STEP: Final = 0.01
_PULLED: Final = 1.0 + _PULLED_STEP * np.array([0, -1, 1, -2, 2, -3, 3, -4, 4, -5, 5])
"""Frequencies over that of a record with its ramps: 13.36 s was fitted where 13 s were run."""
_RAMPED: Final = 0.005
"""Share by which a ramp that was cut must have changed an amplitude to be told."""
_SMALL: Final = {"v": 0.01, "r": 0.004, "psi": 0.004, "y": 0.005, "u": 0.01, "delta": 0.05}
"""Amplitudes below which a motion is held to be none [m/s, rad/s, rad, m]."""


@dataclass(frozen=True, kw_only=True)
class RunFacts:
    """What a record, or its name, says of a run.

    `settings`: value and where it was seen, by key of the campaign file; ``froude`` is the Froude
    number. `alone`: numbers with a unit and no letter, by what they can only be; a record that
    disagrees counts instead. `hints`: values whose meaning a person must confirm, and why.
    `turned`: 1 where a positive rudder raises the heading, -1 where it lowers it, else 0.
    `steady`: whether a ship had come to her speed before her rudder was laid.
    """

    test: str | None = None
    settings: Mapping[str, tuple[float, str]] = field(default_factory=dict)
    alone: Mapping[str, tuple[float, str]] = field(default_factory=dict)
    hints: Mapping[str, tuple[float, str]] = field(default_factory=dict)
    turned: int = 0
    steady: bool = False


def motion_facts(t: Array, channels: Mapping[str, Array], test: str | None) -> RunFacts:
    """What the recorded motion of a captive or free-running test says.

    t [s].

    Examples
    --------
    >>> t = np.arange(0.0, 60.0, 0.1)
    >>> v = 0.2 * 0.5 * np.cos(0.5 * t)
    >>> found = motion_facts(t, {"u": np.full_like(t, 1.2), "v": v, "r": 0 * t}, None)
    >>> found.test, {key: round(value, 3) for key, (value, _) in found.settings.items()}
    ('pure_sway', {'period': 12.566, 'amplitude_m': 0.2, 'speed': 1.2})
    """
    if len(t) < 20 or not np.all(np.diff(t) > 0):
        return RunFacts()
    kind = None if test is None else TEST_KINDS[test]
    if (kind is not None and kind.free_running) or (kind is None and is_track(channels)):
        return _free(t, channels, kind)
    kept, why = _at_speed(t, channels)
    time, seen = t[kept], {name: numbers[kept] for name, numbers in channels.items()}
    swings = _oscillations(time, seen, ("v", "r", "psi", "y", "u"))
    if not swings and (kind is None or kind.steady or kind is TEST_KINDS["harmonic_rudder"]):
        swings = _oscillations(time, seen, ("delta",))
    found = _frequency(time, seen, swings, kind)
    if found is None:
        return _steady(seen, kind, why)
    size, omega = _at_size(t, channels, swings, found[0])
    if why:
        size = slice(max(kept.start, size.start), min(kept.stop, size.stop))
    covered = t[size.stop - 1] - t[size.start] if size.stop > size.start else 0.0
    if size == slice(0, len(t)) or size == kept or covered * omega < 2 * math.pi:
        return _oscillating(time, seen, swings, found, kind)
    whole = {name: abs(_harmonic(time, seen[name], found[0])) for name in swings}
    time, seen = t[size], {name: numbers[size] for name, numbers in channels.items()}
    again = _frequency(time, seen, swings, kind)
    sure = again is not None and math.isfinite(again[1])
    found = again if again is not None and sure else (omega, _PULLED_STEP * omega)
    return _oscillating(time, seen, swings, found, kind, whole)


def is_track(channels: Collection[str]) -> bool:
    """Whether channels are those of a ship that runs free: a path and no forces."""
    tracks = ({"x", "y"}, {"lat", "lon"}, {"u", "v", "r", "delta"})
    return any(x <= {*channels} for x in tracks) and not {"X", "Y", "N"} & {*channels}


def on_plane(t: Array, channels: Mapping[str, Array]) -> dict[str, Array]:
    """With x and y where a record holds latitudes and longitudes, near enough to tell a speed, or
    velocities alone."""
    if {"x", "y", "X", "Y", "N"} & {*channels} or not len(t):
        return dict(channels)
    if {"u", "v"} <= {*channels} and {"psi", "r"} & {*channels}:
        x, y, psi = dead_reckoned(
            t, (channels["u"], channels["v"]), channels.get("r"), channels.get("psi")
        )
        return {**channels, "x": x, "y": y, "psi": psi}
    if not {"lat", "lon"} <= {*channels}:
        return dict(channels)
    lat, lon = channels["lat"], channels["lon"]
    east = METRES_PER_DEGREE * math.cos(math.radians(float(np.median(lat))))
    return {**channels, "x": METRES_PER_DEGREE * lat, "y": east * np.unwrap(lon, period=360.0)}


def sharper(test: str | None, moved: RunFacts) -> str | None:
    """The kind of a test by its name, or by its record where that says more.

    Yaw may show drift or rudder, and the rudder of a steady test may swing.
    """
    if test is None or moved.test is None:
        return test
    named, seen = TEST_KINDS[test], TEST_KINDS[moved.test]
    more = (
        named.steady
        if seen is TEST_KINDS["harmonic_rudder"]
        else named.pure and seen.swings == named.swings and seen.held
    )
    return moved.test if more else test


def _at_speed(t: Array, channels: Mapping[str, Array]) -> tuple[slice, str]:
    """The samples at which the carriage is at its speed, and what was cut, in words."""
    speed = next((channels[x] for x in ("U_carriage", "speed", "u") if x in channels), None)
    if speed is not None and len(t) >= FEWEST:
        travel = at_speed(t, speed)
        if travel.reason:
            span = f"{t[travel.start]:.0f} to {t[travel.stop - 1]:.0f} s"
            return slice(travel.start, travel.stop), f", at speed from {span}"
    return slice(int(np.searchsorted(t, t[0] + _SETTLING * (t[-1] - t[0]))), len(t)), ""


def _at_size(
    t: Array, channels: Mapping[str, Array], swings: Mapping[str, float], omega: float
) -> tuple[slice, float]:
    """The samples at which what oscillates has its full size, and its frequency [rad/s].

    Ramps pull the frequency; at the right one the size stays the same for longest.
    """
    moved = [name for name in ("y", "psi", "x", "delta") if name in swings] or list(swings)
    whole = slice(0, len(t))
    if not moved or len(t) < FEWEST:
        return whole, omega
    rows = np.stack([channels[name] for name in moved])
    tried = [(at_size(t, rows, near), near) for near in omega * _PULLED]
    cut = [item for item in tried if item[0].reason]
    if not cut:
        return whole, omega
    longest, near = max(cut, key=lambda item: item[0].stop - item[0].start)
    return slice(longest.start, longest.stop), float(near)


def _oscillations(time: Array, seen: Mapping[str, Array], names: Sequence[str]) -> dict[str, float]:
    """Channels among these that oscillate, with their rough frequency [rad/s]."""
    found = {}
    for name in names:
        if name in seen and np.ptp(seen[name]) > 2 * _SMALL[name]:
            rough = rough_frequency(time, seen[name])
            if rough is not None:
                found[name] = rough
    return found


_SAMPLED: Final = 8
"""Samples a cycle that a motion has at least; what turns faster is noise of a sensor."""


def rough_frequency(time: Array, values: Array) -> float | None:
    """Angular frequency of the highest peak of the spectrum [rad/s]; None where nothing swings."""
    count = min(len(time), 4096)
    grid = np.linspace(time[0], time[-1], count)
    even = np.interp(grid, time, values)
    trend = np.polynomial.Polynomial.fit(grid, even, 1)
    even = even - trend(grid)
    if not np.any(np.abs(even) > 1e-12 * max(1e-12, float(np.abs(values).max()))):
        return None
    size = 8 * count
    power = np.abs(np.fft.rfft(even * np.hanning(count), size)) ** 2
    peak = int(np.argmax(power[1:])) + 1
    omega = 2 * math.pi * peak / (size * (grid[1] - grid[0]))
    if (time[-1] - time[0]) * omega < 1.5 * 2 * math.pi:
        return None
    if omega * float(np.median(np.diff(time))) > 2 * math.pi / _SAMPLED:
        return None
    rows = design_matrix(omega * grid, 1)
    fit, *_ = np.linalg.lstsq(rows, even, rcond=None)
    left = float(np.sum((even - rows @ fit) ** 2))
    return omega if left < (1 - _COHERENT) * float(np.sum(even**2)) else None


def _frequency(
    time: Array, seen: Mapping[str, Array], swings: Mapping[str, float], kind: TestKind | None
) -> tuple[float, float] | None:
    """Frequency of the motion, of the forces where no motion is recorded, and its std [rad/s]."""
    if swings:
        omega = next(
            swings[name] for name in ("r", "v", "psi", "y", "u", "delta") if name in swings
        )
        rows = [seen[name] for name, rough in swings.items() if abs(rough / omega - 1) < 0.1]
    elif kind is not None and kind.oscillates:
        forces = ("X",) if kind.surges else ("Y", "N")
        roughs = {
            name: rough
            for name in forces
            if name in seen and (rough := rough_frequency(time, seen[name])) is not None
        }
        if not roughs:
            return None
        omega = min(roughs.values())
        rows = [seen[name] for name, rough in roughs.items() if abs(rough / omega - 1) < 0.1]
    else:
        return None
    try:
        return estimate_frequency(time, np.stack(rows), omega)
    except DataError:
        return omega, math.inf


def _oscillating(
    time: Array,
    seen: Mapping[str, Array],
    swings: Mapping[str, float],
    frequency: tuple[float, float],
    kind: TestKind | None,
    whole: Mapping[str, float] = MappingProxyType({}),
) -> RunFacts:
    """Settings of an oscillating test; `whole` are the swings with the ramps that were cut."""
    omega, std = frequency
    period = 2 * math.pi / omega
    source = ", ".join(swings) or "forces"
    if std > 1e-4 * omega:
        source += f", ± {period * min(WIDE * std / omega, 0.1):.2g} s"
    settings = {"period": (_rounded(period, 6 if swings else 4), f"recorded {source}")}
    first = {name: _harmonic(time, seen[name], omega) for name in swings}
    turning = any(name in first for name in ("r", "psi"))
    swaying = "v" in first or ("y" in first and not turning)
    if kind is None or not kind.oscillates:
        moved = {name for name, seen in (("v", swaying), ("r", turning)) if seen} or {"v"}
        kind = kind_with(swings={"u"} if set(swings) == {"u"} else moved)
        kind = TEST_KINDS["harmonic_rudder"] if "delta" in swings else kind
    swung = kind.swings if kind else ()
    yaw = TEST_KINDS["pure_yaw"].swings
    for swing in swung if yaw[0] in swung or not turning else (*swung, *yaw):
        for name in (swing.velocity, swing.displacement):
            if name in first:
                to_file = RUN_SETTINGS[swing.amplitude].to_file
                rate = omega if name == swing.velocity else 1.0
                size, over = (
                    _rounded(to_file(x / rate), 4)
                    for x in (abs(first[name]), whole.get(name, abs(first[name])))
                )
                where = f"recorded {name}"
                if abs(over - size) > _RAMPED * size:
                    where += f" after the ramp, {over:g} over it"
                settings.setdefault(RUN_SETTINGS.key_of(swing.amplitude), (size, where))
                if swung == (swing,):
                    _add_phase(settings, first[name], name)
    if kind is TEST_KINDS["harmonic_rudder"]:
        settings |= _steady(seen, kind, "").settings
        settings |= _middle_of_rudder(time, seen, period)
    else:
        settings |= _speed_and_drift(time, seen, first, omega, turning)
        settings |= _held(seen)
    if kind is not None and kind.pure:
        for name in ("drift", "rudder"):
            if abs(settings.get(RUN_SETTINGS.key_of(name), (0.0, ""))[0]) > 0.5:
                kind = held_too(kind, name)
    return RunFacts(test=kind.name if kind else None, settings=settings)


def _add_phase(settings: dict[str, tuple[float, str]], first: complex, name: str) -> None:
    """The phase of the displacement, of which u, v and r are the rate, where it is not zero."""
    lead = 0.0 if name in ("y", "psi", "x", "delta") else 90.0
    phase = (math.degrees(math.atan2(first.real, first.imag)) - lead + 180.0) % 360.0 - 180.0
    if abs(phase) > 2.0:
        settings.setdefault("phase_deg", (round(phase, 1), f"recorded {name}"))


def _middle_of_rudder(
    time: Array, seen: Mapping[str, Array], period: float
) -> dict[str, tuple[float, str]]:
    """The angle about which a recorded rudder swings, over whole cycles."""
    if "delta" not in seen:
        return {}
    whole = time - time[0] < (time[-1] - time[0]) // period * period
    return {"rudder_deg": (_tidy(math.degrees(seen["delta"][whole].mean()), 1), "mean of delta")}


def _harmonic(time: Array, values: Array, omega: float) -> complex:
    """First harmonic C + iS of C cos + S sin."""
    fit, *_ = np.linalg.lstsq(design_matrix(omega * time, 3), values, rcond=None)
    return complex(fit[1], fit[2])


def _speed_and_drift(
    time: Array,
    seen: Mapping[str, Array],
    first: Mapping[str, complex],
    omega: float,
    turning: bool,
) -> dict[str, tuple[float, str]]:
    """Carriage speed and mean drift angle of an oscillating test."""
    if "u" not in seen:
        return _carriage(seen) or _along_tangent(time, seen, first, omega)
    v = seen.get("v", np.zeros_like(time))
    psi = np.zeros_like(time)
    if turning and "r" in first:
        turned = first["r"] / omega
        psi = turned.real * np.sin(omega * time) - turned.imag * np.cos(omega * time)
    elif turning and "psi" in first:
        swing = first["psi"]
        psi = swing.real * np.cos(omega * time) + swing.imag * np.sin(omega * time)
    along = np.hypot(seen["u"], v) * np.cos(psi) if turning else seen["u"]
    found = {"speed": (_rounded(float(np.mean(along)), 4), "recorded u and v")}
    if turning and "v" in seen:
        beta = math.degrees(math.atan2(-float(np.mean(v)), float(np.mean(seen["u"]))))
        found["drift_deg"] = (_tidy(beta), "recorded u and v")
    return found


_IN_PHASE: Final = 0.05
"""Share of a cross-track velocity that may be out of phase with the heading of a pure yaw."""
BY_PATH: Final = "path and heading of yaw"
"""Where a speed that nobody states comes from."""


def _along_tangent(
    time: Array, seen: Mapping[str, Array], first: Mapping[str, complex], omega: float
) -> dict[str, tuple[float, str]]:
    """The speed of a hull that points along its path: across the tank it goes U tan ψ."""
    if not {"y", "psi"} <= set(first):
        return {}
    across = omega * complex(first["y"].imag, -first["y"].real)
    speed = across / _harmonic(time, np.tan(seen["psi"]), omega)
    if abs(speed.imag) > _IN_PHASE * abs(speed.real):
        return {}
    return {"speed": (_rounded(abs(speed.real), 4), BY_PATH)}


def _steady(seen: Mapping[str, Array], kind: TestKind | None, when: str) -> RunFacts:
    """Settings of a test without oscillation; `when` says what was cut from its record."""
    settings = _carriage(seen) | _held(seen)
    if "u" in seen and not {"v", "speed", "U_carriage"} & set(seen):
        settings["speed"] = (_rounded(float(np.mean(seen["u"])), 4), f"recorded u{when}")
    if {"u", "v"} <= set(seen):
        u, v = float(np.mean(seen["u"])), float(np.mean(seen["v"]))
        settings["speed"] = (_rounded(math.hypot(u, v), 4), f"recorded u and v{when}")
        settings["drift_deg"] = (_tidy(math.degrees(math.atan2(-v, u))), "recorded u and v")
    elif "psi" in seen and np.ptp(seen["psi"]) < 0.02:
        heading = math.degrees(float(np.mean(seen["psi"])))
        settings["drift_deg"] = (_tidy(heading), "recorded psi, the heading in the tank")
    elif "drift" in seen and np.ptp(seen["drift"]) < 0.02:
        angle = math.degrees(float(np.mean(seen["drift"])))
        settings["drift_deg"] = (_tidy(angle), "column of the drift angle")
    if "r" in seen:
        r = float(np.mean(seen["r"]))
        if abs(r) > 0.005 and float(np.std(seen["r"])) < 0.2 * abs(r):
            settings["yaw_rate"] = (_rounded(r, 5), "recorded r")
    kind = kind or _static_test(settings)
    return RunFacts(test=kind.name if kind else None, settings=settings)


def _static_test(settings: Mapping[str, tuple[float, str]]) -> TestKind | None:
    """Kind of a steady test; None where the record does not say that it is one."""
    if "yaw_rate" in settings:
        return kind_with(turning=True)
    held = [
        name
        for name in ("drift", "rudder", "heel")
        if abs(settings.get(RUN_SETTINGS.key_of(name), (0.0, ""))[0]) > 0.3
    ]
    if len(held) > 1:
        held = [name for name in held if name != "heel"]
    return kind_with(held=held) if held or "drift_deg" in settings else None


def _carriage(seen: Mapping[str, Array]) -> dict[str, tuple[float, str]]:
    found = seen.get("U_carriage", seen.get("speed"))
    if found is None:
        return {}
    return {"speed": (_rounded(float(np.median(found)), 4), "recorded speed")}


def _held(seen: Mapping[str, Array]) -> dict[str, tuple[float, str]]:
    """Rudder, heel and revolutions where they are held."""
    found = {}
    for name, key, factor in (
        ("delta", "rudder_deg", 180 / math.pi),
        ("phi", "heel_deg", 180 / math.pi),
        ("n", "propeller_rps", 1.0),
    ):
        if name in seen and abs(float(np.mean(seen[name])) * factor) > 0.3:
            value = float(np.mean(seen[name])) * factor
            if float(np.std(seen[name])) * factor < 0.1 * abs(value):
                found[key] = (_tidy(value), f"recorded {name}")
    return found


def _free(t: Array, channels: Mapping[str, Array], kind: TestKind | None) -> RunFacts:
    """Settings of a free-running test, by its rudder, heading and track."""
    settings: dict[str, tuple[float, str]] = {}
    begun = turned = 0
    heading = unwrapped(channels["psi"]) if "psi" in channels else None
    if kind is None and heading is not None and np.ptp(heading) < _KEPT and not _slows(t, channels):
        kind = TEST_KINDS["straight"]
    if kind is not TEST_KINDS["straight"] and "delta" in channels:
        delta = channels["delta"]
        held = _most_held(delta)
        near = max(0.08 * held, math.radians(0.6))
        on = np.where(np.abs(np.abs(delta) - held) < near, np.sign(delta), 0.0)
        long = _stretches(on, t, least=0.01 * float(t[-1] - t[0]))
        swaps = sum(one[0] != two[0] for one, two in itertools.pairwise(long))
        if held > math.radians(0.7) and long:
            kind = kind or (
                TEST_KINDS["zigzag"]
                if swaps >= 2
                else TEST_KINDS["turning"]
                if swaps == 0
                else None
            )
            side, begun, _ = max(long, key=_length) if kind is TEST_KINDS["turning"] else long[0]
            if kind in (TEST_KINDS["zigzag"], TEST_KINDS["turning"], TEST_KINDS["pull_out"]):
                settings["rudder_deg"] = (_tidy(side * math.degrees(held), 0), "recorded delta")
            if kind is TEST_KINDS["zigzag"] and heading is not None:
                settings |= _switch(heading, long)
            turned = 0 if heading is None else _turned(heading, long)
    if "n" in channels:
        settings |= _held({"n": channels["n"]})
    found = settings | _approach(t, channels, begun)
    return RunFacts(
        test=kind.name if kind else None,
        settings=found,
        turned=turned,
        steady=bool(begun) and not _sped_up(t, channels, found),
    )


def _turned(psi: Array, held: Sequence[tuple[float, int, int]]) -> int:
    """Whether the heading gathers way to the side of the rudder, while that is held, or goes far:
    in a turn its rate falls with the speed."""
    bends = np.array([s * _gathered(psi[a], psi[(a + b) // 2], psi[b]) for s, a, b in held])
    sure = abs(bends.sum()) > _ONE_WAY * np.abs(bends).sum()
    return int(np.sign(bends.sum())) if sure else 0


def _gathered(first: float, middle: float, last: float) -> float:
    return last - first if abs(last - first) > _FAR else last - 2.0 * middle + first


_FAR: Final = 1.5
"""Change of heading that no zigzag makes under one rudder [rad]: twice 45°."""
_ONE_WAY: Final = 0.8
"""Share of the bends of a heading that must go one way."""


def _slows(t: Array, channels: Mapping[str, Array]) -> bool:
    """Whether a ship that begins at speed loses most of it, as in a stop."""
    path = np.hypot(channels["x"] - channels["x"][0], channels["y"] - channels["y"][0])
    tenth = max(len(t) // 10, 1)
    first = (path[tenth] - path[0]) / (t[tenth] - t[0])
    last = (path[-1] - path[-1 - tenth]) / (t[-1] - t[-1 - tenth])
    return bool(first > 0.05 * np.ptp(path) / (t[-1] - t[0]) and last < 0.5 * first)


_KEPT: Final = math.radians(6.0)
"""A heading that moves by less in all is kept: the smallest usual zigzag, 5°/5°, moves by 10°; an
autopilot in waves, benchmark of the DTC, by 1.8°."""


def _most_held(delta: Array) -> float:
    """The rudder angle, either side, at which the rudder stays longest [rad]."""
    size = np.round(np.degrees(np.abs(delta)) * 2).astype(int)
    counts = np.bincount(size[size >= 2], minlength=3)
    near = np.abs(size - int(np.argmax(counts))) <= 1
    return float(np.median(np.abs(delta[near]))) if near.any() else 0.0


def _stretches(on: Array, t: Array, *, least: float) -> list[tuple[float, int, int]]:
    """Stretches of at least so many seconds with the rudder held: side, first and last sample."""
    edges = np.flatnonzero(np.diff(on)) + 1
    starts, stops = np.concatenate([[0], edges]), np.concatenate([edges, [len(on)]]) - 1
    return [
        (float(on[start]), int(start), int(stop))
        for start, stop in zip(starts, stops, strict=True)
        if on[start] != 0 and t[stop] - t[start] >= least
    ]


def _length(stretch: tuple[float, int, int]) -> int:
    return stretch[2] - stretch[1]


def _switch(psi: Array, held: list[tuple[float, int, int]]) -> dict[str, tuple[float, str]]:
    """Half the difference of the headings at which a zigzag leaves the rudder to either side."""
    left = {
        side: [psi[stop] for which, _, stop in held[:-1] if which == side] for side in (-1.0, 1.0)
    }
    if not (left[-1.0] and left[1.0]):
        return {}
    value = abs(math.degrees(float(np.median(left[1.0]) - np.median(left[-1.0])))) / 2
    return {"switch_deg": (_tidy(value, 0), "recorded psi where the rudder leaves its angle")}


def _approach(t: Array, channels: Mapping[str, Array], begun: int) -> dict[str, tuple[float, str]]:
    """Speed in the seconds before the rudder, or over the whole record where there is no rudder."""
    late = t[begun] if begun else t[-1]
    first = (t <= late) & (t >= late - (5.0 if begun else np.inf))
    if np.count_nonzero(first) < 3:
        first = np.arange(len(t)) < 3
    when = "before the rudder" if begun else "mean of the record"
    if {"u", "v"} <= set(channels):
        speed = float(np.mean(np.hypot(channels["u"][first], channels["v"][first])))
        return {"speed": (_rounded(speed, 3), f"recorded u and v, {when}")}
    if {"x", "y"} <= set(channels):
        steps = [np.diff(channels[name][first]) for name in ("x", "y")]
        speed = float(np.sum(np.hypot(*steps)) / np.ptp(t[first]))
        return {"speed": (_rounded(speed, 3), f"recorded x and y, {when}")}
    return {}


def _sped_up(
    t: Array, channels: Mapping[str, Array], found: Mapping[str, tuple[float, str]]
) -> bool:
    """Whether a ship went faster after her rudder was laid: then she had not come to her speed."""
    if "speed" not in found:
        return False
    if {"u", "v"} <= set(channels):
        way = np.hypot(channels["u"], channels["v"])
    else:
        edges = np.arange(0, len(t), max(2, len(t) // 60))
        steps = (np.diff(channels[name][edges]) for name in ("x", "y"))
        way = np.hypot(*steps) / np.diff(t[edges])
    return bool(np.percentile(way, 75) > _FASTER * found["speed"][0])


_FASTER: Final = 1.3
"""Ratio of speeds: gusts, jumps of fixes and a current along the track make less."""


def _rounded(value: float, digits: int) -> float:
    return float(f"{value:.{digits}g}")


def _tidy(value: float, decimals: int = 2) -> float:
    """An angle to hundredths of a degree (or so), never minus zero."""
    return round(value, decimals) + 0.0
