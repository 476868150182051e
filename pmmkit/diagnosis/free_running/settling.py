"""Starts of windows, noise of sensors and outliers, told with forces that follow any ship."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Final

import numpy as np

from pmmkit.diagnosis.free_running.information import Forces, whitened
from pmmkit.diagnosis.free_running.slopes import Sheet, channels_of, sheets_of
from pmmkit.diagnosis.free_running.windows import RecordWindows, of_instants, sailed
from pmmkit.identification import FreeRecord
from pmmkit.inference import InformationRoot
from pmmkit.models import Model
from pmmkit.numerics import Array
from pmmkit.signals import white_noise

AGILE: Final = Forces(shares=np.full(4, 0.03), memory=1.0)
"""Unknown forces that follow any ship, so that its sensors alone say how it went."""
ROUNDS: Final = 5
"""Times that starts and noise are told from each other."""
VAGUE: Final = 3e4
"""Standard deviation of a start before its window is seen, over that which the noise makes of it
where it is the only one: where two states show nearly the same, so that they are κ times as wide,
it draws them by (κ / 3e4)² towards where they were; in the free tank κ is 4 at most windows and 32
at the worst."""
GATE: Final = 6.0
"""An average so many standard deviations from all others of its window is an outlier."""
FEW: Final = 0.3
"""Share of the windows of a record that may hold one; where there are more its noise is larger."""
FINEST: Final = 1e-5
"""No sensor is better than this share of a ship length, a radian, the speed, or speed over length:
what is exact, from a program, would outweigh the integration."""
LEAST_FREE: Final = 10.0
"""Averages beyond those that starts and forces take from which a noise is told."""
ANEW: Final = 3
"""Times that it is told again with what was found: beside a log a current of .12 m/s makes fixes
of .006 m look like such of .34 m, and after three times they are .006 m."""
BETTER: Final = 0.8
"""Share of the noise of a channel below which what was found makes it another one."""


def agile(stretch: RecordWindows) -> Forces:
    """Forces that follow any ship, in the channels of a stretch."""
    channels = 4 if "phi" in stretch.states else 3
    return replace(AGILE, shares=AGILE.shares[:channels])


def settled(
    model: Model,
    records: Sequence[FreeRecord],
    samples: Sequence[float],
    cut: Callable[[Sequence[FreeRecord], Mapping[str, float]], tuple[RecordWindows, ...]],
    given: Mapping[str, float],
) -> tuple[tuple[RecordWindows, ...], Mapping[str, float], int]:
    """Starts and noise from each other, in a few rounds."""
    sensors = first_sensors(records, samples, given, model.ship.L)
    stretches = cut(records, sensors)
    outliers = 0
    still = np.zeros(len(stretches[0].names))
    for number in range(ROUNDS):
        stretches, sheets, fits = _on_their_way(stretches, still, sensors)
        if number == 0:
            continue
        cleaned, count = _without_outliers(stretches, sheets, fits)
        if count:
            stretches, outliers = cleaned, outliers + count
        else:
            sensors = _told(stretches, sheets, fits, sensors, given, model.ship.L)
    return stretches, sensors, outliers


def told_anew(
    stretches: Sequence[RecordWindows],
    change: Array,
    sensors: Mapping[str, float],
    given: Mapping[str, float],
    L: float,
) -> Mapping[str, float]:
    """Noise of sensors as records tell it that are read with some values.

    What moves positions or turns headings without any force looks like noise until it is found.

    change (m,); L [m].
    """
    noise = sensors
    for _ in range(ANEW):
        stretches, sheets, fits = _on_their_way(stretches, change, noise)
        noise = _told(stretches, sheets, fits, noise, given, L)
    better = any(noise[name] < BETTER * sensors[name] for name in sensors)
    return noise if better else sensors


def _on_their_way(
    stretches: Sequence[RecordWindows], change: Array, sensors: Mapping[str, float]
) -> tuple[tuple[RecordWindows, ...], list[list[Sheet]], list[list[Smooth]]]:
    """Stretches from the starts that sensors tell of them with some values, and what tells them."""
    sheets = [sheets_of(item, change) for item in stretches]
    fits = [
        smoothed(own, _sigma(item, sensors), agile(item))
        for item, own in zip(stretches, sheets, strict=True)
    ]
    moved = tuple(
        _kept_on_its_way(item, own, change) for item, own in zip(stretches, fits, strict=True)
    )
    return moved, sheets, fits


def follow(stretch: RecordWindows, change: Array, sensors: Mapping[str, float]) -> RecordWindows:
    """A stretch along the path that the sensors tell, as they are read with some values.

    Where the motion is lost with these values the path stays as it is.

    change (m,).
    """
    if not np.all(np.isfinite(sailed(stretch, change))):
        return stretch
    sheets = sheets_of(stretch, change)
    return moved_along(stretch, sheets, sensors, np.zeros(len(change)), agile(stretch))


def moved_along(
    stretch: RecordWindows,
    sheets: Sequence[Sheet],
    sensors: Mapping[str, float],
    change: Array,
    forces: Forces,
) -> RecordWindows:
    """A stretch along the most probable path as sheets tell it for other values.

    change (m,).
    """
    sigma = _sigma(stretch, sensors)
    return _moved(stretch, smoothed(sheets, sigma, forces, change))


def _kept_on_its_way(
    stretch: RecordWindows, fits: Sequence[Smooth], change: Array
) -> RecordWindows:
    """A stretch from the starts of its windows' fits; as it was where the motion is lost there."""
    made = _moved(stretch, fits)
    return made if np.all(np.isfinite(sailed(made, change))) else stretch


def _moved(stretch: RecordWindows, fits: Sequence[Smooth]) -> RecordWindows:
    """A stretch from the starts and with the forces of its windows' fits."""
    starts = stretch.starts.copy()
    starts[:, : stretch.own] += np.stack([fit.start for fit in fits])
    return stretch.along(starts, of_instants(stretch, np.concatenate([fit.forces for fit in fits])))


def _sigma(stretch: RecordWindows, sensors: Mapping[str, float]) -> Array:
    return np.array([sensors[name] for name in stretch.channels])


def first_sensors(
    records: Sequence[FreeRecord], samples: Sequence[float], given: Mapping[str, float], L: float
) -> dict[str, float]:
    """Noise of each channel: as given, else from third differences."""
    noise = {}
    for name in dict.fromkeys(name for record in records for name in record.measured):
        noises = [
            math.sqrt(count) * white_noise(item.measured[name])
            for item, count in zip(records, samples, strict=True)
            if name in item.measured
        ]
        known = [x for x in noises if math.isfinite(x)]
        least = finest(name, records[0].speed, L)
        noise[name] = given.get(name) or max(float(np.median(known)) if known else 0.0, least)
    return noise


def finest(name: str, speed: float, L: float) -> float:
    """What no sensor of a channel is better than."""
    sizes = {"x": L, "y": L, "r": speed / L, "p": speed / L}
    sizes |= dict.fromkeys(("u", "v", "xdot", "ydot", "sog"), speed)
    return FINEST * sizes.get(name, 1.0)


@dataclass(frozen=True, kw_only=True, eq=False)
class Smooth:
    """A window as its sensors tell it.

    `start (s,)`: what comes to its first states. `left (b,)`: residuals over the noise. `design,
    known`: rows of starts and forces, and what is known of these.
    """

    start: Array
    forces: Array
    left: Array
    design: Array
    known: InformationRoot

    @cached_property
    def leverage(self) -> Array:
        """Share of each average (b,) that starts and forces take."""
        return self.known.spread(self.design)


def smoothed(
    sheets: Sequence[Sheet], sigma: Array, forces: Forces, moved: Array | None = None
) -> list[Smooth]:
    """The most probable starts and forces of windows.

    sigma (c,); moved (m,).
    """
    alike: dict[tuple[int, int], list[int]] = {}
    for number, sheet in enumerate(sheets):
        alike.setdefault(sheet.forces.shape[:2], []).append(number)
    found: dict[int, Smooth] = {}
    for numbers in alike.values():
        own = _smoothed([sheets[number] for number in numbers], sigma, forces, moved)
        found |= dict(zip(numbers, own, strict=True))
    return [found[number] for number in range(len(sheets))]


def _smoothed(
    sheets: Sequence[Sheet], sigma: Array, forces: Forces, moved: Array | None
) -> list[Smooth]:
    """The same of windows of as many averages and pieces."""
    rows, size = np.stack([whitened(sheet, sigma) for sheet in sheets]), sheets[0].starts.shape[1]
    pieces, channels = sheets[0].forces.shape[1:]
    length = np.maximum(np.linalg.norm(rows[:, :, :size], axis=1), 1e-300)
    root = forces.root(np.array([sheet.spacing for sheet in sheets]), pieces)
    split = size + pieces * channels
    A = np.concatenate([rows[:, :, :size] / length[:, None], rows[:, :, size:split] @ root], axis=2)
    along = np.stack([sheet.along.ravel() for sheet in sheets])
    e = rows[:, :, -1] + (rows[:, :, size:split] @ along[:, :, None])[:, :, 0]
    if moved is not None:
        e = e - rows[:, :, split:-1] @ moved
    std = np.concatenate([np.full(size, VAGUE), np.ones(pieces * channels)])
    known = InformationRoot.of(np.zeros(len(std)), std).with_rows(
        *_with_loose(sheets, A, e, length)
    )
    mean = known.mean[:, :, None]
    left = e - (A @ mean)[:, :, 0]
    pushes = (root @ mean[:, size:]).reshape(len(sheets), pieces, channels)
    starts = mean[:, :size, 0] / length
    return [
        Smooth(
            start=starts[w],
            forces=pushes[w],
            left=left[w],
            design=A[w],
            known=InformationRoot(root=known.root[w]),
        )
        for w in range(len(sheets))
    ]


def _with_loose(sheets: Sequence[Sheet], A: Array, e: Array, length: Array) -> tuple[Array, Array]:
    """Rows and errors of windows with what is known of starts that nothing measures."""
    loose = sheets[0].loose
    places = np.flatnonzero(np.isfinite(loose))
    if not places.size:
        return A, e
    extra = np.zeros((len(sheets), places.size, A.shape[2]))
    extra[:, np.arange(places.size), places] = 1.0 / (length[:, places] * loose[places])
    begun = np.stack([sheet.begun for sheet in sheets])[:, places]
    return np.concatenate([A, extra], axis=1), np.concatenate([e, -begun / loose[places]], axis=1)


def _told(
    stretches: Sequence[RecordWindows],
    sheets: Sequence[Sequence[Sheet]],
    fits: Sequence[Sequence[Smooth]],
    sensors: Mapping[str, float],
    given: Mapping[str, float],
    L: float,
) -> dict[str, float]:
    """Noise of the channels from what starts and forces leave."""
    noise = dict(sensors)
    for name in channels_of(stretches):
        if name in given:
            continue
        square, free = 0.0, 0.0
        for item, own, fitted in zip(stretches, sheets, fits, strict=True):
            if name not in item.channels:
                continue
            number = item.channels.index(name)
            for sheet, fit in zip(own, fitted, strict=True):
                at = sheet.channels == number
                square += float(np.sum(fit.left[at] ** 2))
                free += float(np.sum(1.0 - fit.leverage[at]))
        if free > LEAST_FREE:
            least = finest(name, stretches[0].record.speed, L)
            noise[name] = max(sensors[name] * math.sqrt(square / free), least)
    return noise


def _without_outliers(
    stretches: Sequence[RecordWindows],
    sheets: Sequence[Sequence[Sheet]],
    fits: Sequence[Sequence[Smooth]],
) -> tuple[tuple[RecordWindows, ...], int]:
    """The worst average of each window is taken out of the records, where nothing explains it."""
    made, count = [], 0
    for item, own, fitted in zip(stretches, sheets, fits, strict=True):
        wild = [
            (w, row)
            for w, (sheet, fit) in enumerate(zip(own, fitted, strict=True))
            if (row := _worst(fit)) is not None
        ]
        if len(wild) > max(FEW * len(own), 1.0):
            wild = []
        count += len(wild)
        measured = {name: x.copy() for name, x in item.record.measured.items()}
        for w, row in wild:
            rows = slice(item.begins[w], item.begins[w + 1])
            name = item.channels[own[w].channels[row]]
            measured[name][rows][item.blocks[rows] == own[w].blocks[row]] = np.nan
        made.append(replace(item, record=item.record.with_(measured=measured)))
    return tuple(made), count


def _worst(fit: Smooth) -> int | None:
    """Row of the average furthest off in a window, if it is beyond the gate."""
    away = fit.left**2 / np.maximum(1.0 - fit.leverage, 1e-6)
    row = int(np.argmax(away))
    return row if away[row] > GATE**2 else None
