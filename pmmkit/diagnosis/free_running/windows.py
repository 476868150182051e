"""Free-running records cut into windows that a model sails through from states of their own."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields, replace
from types import ModuleType
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from pmmkit.effects import CURRENT, OUTSIDE
from pmmkit.equations import InputField, State
from pmmkit.identification import Binding, FreeRecord
from pmmkit.models import Model
from pmmkit.numerics import Array

WINDOW: Final = 5.0
"""Length of a window in ship lengths over the speed."""
PIECE: Final = 0.4
"""An unknown force is constant for so long, in ship lengths over the speed."""
BLOCK: Final = 0.15
"""Measurements are averaged over so long, and so is what the model shows for them."""
SHORT: Final = 5
"""Short windows in a window: what starts and noise are told by. In them any model is almost
linear."""
RUDDER_ZERO: Final = "rudder_zero"
"""The value that turns what is recorded of the rudder."""
INSTANTS: Final = 6
"""Least instants of a short window."""


@dataclass(frozen=True, kw_only=True, eq=False)
class RecordWindows:
    """A record in windows, with the equations that sail it.

    `names`: values that may move. `binding`: constants over those of them that are constants.
    `begins (w + 1,)`: first instant of each window, and the number of instants. `starts (w,
    s)`: states at the first instants. `forces (n, f)`: unknown forces that keep it on the
    measured path, over ½ρLdU² (½ρL²dU²): the path about which all is made linear. `units (f,)`:
    these units [N, N m]. `pieces, blocks`: number within its window of the piece and of the
    block that each instant belongs to. `spacing (w,)`: length of the pieces of each window, in
    ship lengths over the speed. `pace`: speed over ship length [1/s]. `samples`: how many an
    instant is the mean of, over those of the record with the fewest.
    """

    record: FreeRecord
    names: tuple[str, ...]
    binding: Binding
    functions: ModuleType
    begins: NDArray[np.int64]
    starts: Array
    forces: Array
    units: Array
    pieces: NDArray[np.int64]
    blocks: NDArray[np.int64]
    spacing: Array
    pace: float
    samples: float

    def __reduce__(self) -> tuple[Any, ...]:
        """For another process, which compiles the equations or has them."""
        given = {x.name: getattr(self, x.name) for x in fields(self) if x.name != "functions"}
        return _compiled_anew, (given,)

    @property
    def states(self) -> tuple[str, ...]:
        """Names of the states."""
        return self.binding.states

    @property
    def own(self) -> int:
        """Number of the states of the ship; those that effects bring follow."""
        return len(self.states) - len(self.binding.equations.structure.brought)

    @property
    def channels(self) -> tuple[str, ...]:
        """What was measured."""
        return tuple(self.record.measured)

    @property
    def longest(self) -> float:
        """Longest step of the integration [s]."""
        return Binding.STEP / self.pace

    def along(self, starts: Array, forces: Array) -> RecordWindows:
        """The same from other states and with other forces."""
        return replace(self, starts=starts, forces=forces)

    @property
    def free(self) -> RecordWindows:
        """The same without unknown forces."""
        return replace(self, forces=np.zeros_like(self.forces))


def _compiled_anew(given: Mapping[str, Any]) -> RecordWindows:
    return RecordWindows(functions=given["binding"].functions, **given)


def stretches_of(
    model: Model,
    records: Sequence[FreeRecord],
    names: Sequence[str],
    *,
    sensors: Mapping[str, float],
    samples: Sequence[float] | None = None,
    window: float = WINDOW,
    extrapolate: bool = False,
) -> tuple[RecordWindows, ...]:
    """Records in windows of equal length that do not overlap."""
    own = [name for name in names if name in CURRENT or name not in OUTSIDE]
    at = {
        place: Binding.of(model, own, place[0], conditions=place[1], extrapolate=extrapolate)
        for place in {(record.speed, record.conditions) for record in records}
    }
    return tuple(
        _stretch(
            model, record, count, tuple(names), at[record.speed, record.conditions], sensors, window
        )
        for record, count in zip(records, samples or [1.0] * len(records), strict=True)
    )


_UNSEEN: Final = 1e-3
"""Of an unknown roll moment that nothing shows: the forces of heel would tell any."""


def _stretch(
    model: Model,
    record: FreeRecord,
    samples: float,
    names: tuple[str, ...],
    binding: Binding,
    sensors: Mapping[str, float],
    window: float,
) -> RecordWindows:
    pace = record.speed / model.ship.L
    default = record.first_state(binding.states, sensors, model.ship.L)[0]
    begins = _begins(record, window / pace)
    pieces, spacing = _pieces(record, begins, pace)
    by = record.force_units(model)
    if not {"phi", "p"} & {*record.measured}:
        by = {channel: size * (_UNSEEN if channel == "K" else 1.0) for channel, size in by.items()}
    made = RecordWindows(
        record=record,
        names=names,
        binding=binding,
        functions=binding.functions,
        begins=begins,
        starts=record.first_states(begins, binding.states, default, 0.5 / pace),
        forces=np.zeros((len(record), len(by))),
        units=np.array([*by.values()]),
        pieces=pieces,
        blocks=_blocks(record, begins, pace),
        spacing=spacing,
        pace=pace,
        samples=samples,
    )
    return replace(made, starts=_with_settled_flow(made))


def _with_settled_flow(stretch: RecordWindows) -> Array:
    """Starts (w, s) with what effects bring where it stands still beside the first states.

    Only the first window begins there; in the others it goes on from the one before.
    """
    starts, still = stretch.starts.copy(), np.zeros(len(stretch.names))
    k, now, further = constants(stretch, still), *np.zeros((2, len(stretch.states)))
    if k is None:
        return starts
    given = inputs(stretch, still)[
        0, [InputField.rudder, InputField.revolutions, InputField.bucket]
    ]
    for i in range(stretch.own, len(stretch.states)):
        at = starts[0].copy()
        stretch.functions.rates(at, *given, k, now)
        at[i] += 1.0
        stretch.functions.rates(at, *given, k, further)
        # The rate of what follows the motion is a straight line over it.
        starts[:, i] -= now[i] / (further[i] - now[i]) if further[i] != now[i] else 0.0
    return starts


def joined(stretch: RecordWindows, count: int = SHORT) -> RecordWindows:
    """A stretch whose windows are so many of another one's, along the same path."""
    begins = np.unique(np.append(stretch.begins[:-1:count], stretch.begins[-1]))
    if len(begins) > 2 and 2 * (begins[-1] - begins[-2]) < begins[1] - begins[0]:
        begins = np.delete(begins, -2)
    pieces, spacing = _pieces(stretch.record, begins, stretch.pace)
    made = replace(
        stretch,
        begins=begins,
        starts=starts_of(stretch, begins),
        pieces=pieces,
        blocks=_blocks(stretch.record, begins, stretch.pace),
        spacing=spacing,
    )
    return replace(made, forces=of_instants(made, by_piece(made, stretch.forces)))


def piece_begins(stretch: RecordWindows) -> NDArray[np.int64]:
    """First instants of all pieces of all windows."""
    first = np.zeros(len(stretch.record), bool)
    first[stretch.begins[:-1]] = True
    first[1:] |= np.diff(stretch.pieces) != 0
    return np.flatnonzero(first)


def by_piece(stretch: RecordWindows, forces: Array) -> Array:
    """Means (q, f) over the pieces of all windows of forces (n, f) at instants."""
    begins = piece_begins(stretch)
    lengths = np.diff(np.append(begins, len(stretch.record)))[:, None]
    found: Array = np.add.reduceat(forces, begins, axis=0) / lengths
    return found


def of_instants(stretch: RecordWindows, forces: Array) -> Array:
    """Forces (n, f) at instants from those of the pieces (q, f) of all windows."""
    begins = piece_begins(stretch)
    return np.repeat(forces, np.diff(np.append(begins, len(stretch.record))), axis=0)


def starts_of(stretch: RecordWindows, begins: NDArray[np.int64]) -> Array:
    """The starts of those windows of a stretch that begin at some instants."""
    return stretch.starts[np.searchsorted(stretch.begins, begins[:-1])]


def _begins(record: FreeRecord, window: float) -> NDArray[np.int64]:
    """First instants of windows, each with some instants at least."""
    t = record.t
    count = max(min(round((t[-1] - t[0]) / window), len(t) // INSTANTS), 1)
    edges = np.searchsorted(t, np.linspace(t[0], t[-1], count + 1)[1:-1])
    return np.unique(np.array([0, *edges.tolist(), len(t)], np.int64))


def _pieces(
    record: FreeRecord, begins: NDArray[np.int64], pace: float
) -> tuple[NDArray[np.int64], Array]:
    """Pieces of equal length, none without an instant."""
    found, spacing = np.zeros(len(record), np.int64), []
    for begin, end in zip(begins[:-1].tolist(), begins[1:].tolist(), strict=True):
        t = (record.t[begin:end] - record.t[begin]) * pace
        count = max(min(round(float(t[-1]) / PIECE), end - begin), 1)
        own = np.minimum(t / max(float(t[-1]), 1e-300) * count, count - 1).astype(np.int64)
        found[begin:end] = np.unique(own, return_inverse=True)[1]
        spacing.append(float(t[-1]) / (int(found[end - 1]) + 1))
    return found, np.array(spacing)


def _blocks(record: FreeRecord, begins: NDArray[np.int64], pace: float) -> NDArray[np.int64]:
    found = np.zeros(len(record), np.int64)
    for begin, end in zip(begins[:-1].tolist(), begins[1:].tolist(), strict=True):
        own = ((record.t[begin:end] - record.t[begin]) * pace / BLOCK + 1e-9).astype(np.int64)
        found[begin:end] = np.unique(own, return_inverse=True)[1]
    return found


def constants(stretch: RecordWindows, change: Array) -> Array | None:
    """Constants of the equations after a change of the values; None if no ship has such a mass."""
    moved = dict(zip(stretch.names, change.tolist(), strict=True))
    lines = stretch.binding
    own, k = np.array([moved[name] for name in lines.names]), np.empty_like(lines.base)
    lost = stretch.functions.constants(lines.base, lines.starts, lines.places, lines.slopes, own, k)
    return None if lost else k


def inputs(stretch: RecordWindows, change: Array) -> Array:
    """Inputs (n, i) after a change of the values."""
    moved = dict(zip(stretch.names, change.tolist(), strict=True))
    found = stretch.record.inputs
    found[:, InputField.rudder] += moved.get(RUDDER_ZERO, 0.0)
    return found


def sailed(stretch: RecordWindows, change: Array) -> Array:
    """States (n, s) at all instants, each window from its own start; NaN where they are lost."""
    out = np.full((len(stretch.record), len(stretch.states)), np.nan)
    k = constants(stretch, change)
    if k is not None:
        stretch.functions.pushed(
            stretch.record.t,
            inputs(stretch, change),
            np.ascontiguousarray(stretch.forces * stretch.units),
            stretch.begins,
            np.ascontiguousarray(stretch.starts),
            k,
            stretch.longest,
            out,
        )
    return out


def shown(stretch: RecordWindows, states: Array, change: Array) -> Array:
    """What the channels (n, c) should show of states (n, s)."""
    moved = dict(zip(stretch.names, change.tolist(), strict=True))
    psi, u, v = (states[:, place] for place in (State.psi, State.u, State.v))
    ahead, aside = np.cos(psi), np.sin(psi)
    level = v * np.cos(_heel(stretch, states))
    current = [
        stretch.binding.base[stretch.binding.equations.place(name)] + moved.get(name, 0.0)
        for name in CURRENT
    ]
    north = u * ahead - level * aside + current[0]
    east = u * aside + level * ahead + current[1]
    lag, offset = moved.get("clock_lag", 0.0), moved.get("heading_offset", 0.0)
    forward, starboard = (moved.get(name, 0.0) for name in ("antenna_x", "antenna_y"))
    gain = 1.0 + moved.get("log_gain", 0.0)
    made = {
        "x": states[:, State.x] - lag * north + forward * ahead - starboard * aside,
        "y": states[:, State.y] - lag * east + forward * aside + starboard * ahead,
        "psi": psi + offset,
        "u": gain * u,
        "v": gain * v,
        "xdot": north,
        "ydot": east,
        "sog": np.hypot(north, east),
    }
    place = {name: i for i, name in enumerate(stretch.states)}
    return np.stack(
        [made[name] if name in made else states[:, place[name]] for name in stretch.channels],
        axis=1,
    )


def _heel(stretch: RecordWindows, states: Array) -> Array | float:
    """Heel [rad] at all instants: the ship's own, else the one that was measured."""
    if State.phi.name in stretch.states:
        found: Array = states[:, stretch.states.index(State.phi.name)]
        return found
    return 0.0 if stretch.record.roll is None else stretch.record.roll
