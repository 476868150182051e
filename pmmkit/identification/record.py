"""A free-running run as the estimators take it: inputs and measurements at instants."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import ClassVar, Final

import numpy as np
from numpy.typing import NDArray

from pmmkit.base import DataError, Problem, Remedy, Way
from pmmkit.campaigns import Attitude
from pmmkit.conventions import Convention
from pmmkit.equations import Conditions, InputField, OverGround, State
from pmmkit.models import Model
from pmmkit.numerics import Array
from pmmkit.signals import white_noise

KINDS: Final[Mapping[str, OverGround]] = {
    "xdot": OverGround.north,
    "ydot": OverGround.east,
    "sog": OverGround.size,
}
"""Channels that are no states, by the number the filters know them by."""
STATES: Final = (*State.__members__,)


@dataclass(frozen=True, kw_only=True, eq=False)
class FreeRecord:
    """Inputs and measurements of a free-running ship.

    Parameters
    ----------
    name : str
        Of the run.
    t : array (n,)
        Instants [s], ascending.
    delta, turns : array (n,)
        Rudder as it stood [rad] and revolutions [1/s].
    measured : mapping of str to array (n,)
        Of `CHANNELS`, SI and radians, the heading unwrapped, NaN where nothing was measured.
    wind_speed, wind_direction : array (n,), optional
        True wind over ground [m/s] and where it comes from, from north [rad].
    wave_height, wave_direction : array (n,), optional
        Significant height of the sea [m] and where it comes from, from north [rad]; by default the
        sea is that of the model, if it has one.
    wave_period : float, optional
        Its peak period [s].
    bucket : array (n,), optional
        Of waterjets, 0 up to 1 down.
    roll, roll_rate, roll_acceleration : array (n,), optional
        Heel to starboard [rad], its rate [rad/s] and the rate of that [rad/s²] as inputs of a model
        that does not roll; zero where they are not given. A model that rolls goes by ``measured``
        alone.
    speed : float
        Of the approach [m/s].
    depth : float, optional
        Of the water [m]; by default that of the model's water, deep if it has none.
    current : (float, float)
        Velocity of the water over ground, to north and east [m/s].
    reckoned : tuple of str
        Those of `measured` that follow from others: a track from velocities.
    campaign : str
        Title of the tests.
    """

    CHANNELS: ClassVar[tuple[str, ...]] = (*STATES, *KINDS)

    name: str
    t: Array
    delta: Array
    turns: Array
    measured: Mapping[str, Array]
    speed: float
    wind_speed: Array | None = None
    wind_direction: Array | None = None
    wave_height: Array | None = None
    wave_direction: Array | None = None
    wave_period: float | None = None
    bucket: Array | None = None
    roll: Array | None = None
    roll_rate: Array | None = None
    roll_acceleration: Array | None = None
    depth: float | None = None
    current: tuple[float, float] = (0.0, 0.0)
    campaign: str = ""
    reckoned: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        inputs = (self.delta, self.turns, *(x for x in self._optional.values() if x is not None))
        lengths = {len(x) for x in (self.t, *inputs, *self.measured.values())}
        if lengths != {len(self.t)} or len(self.t) < 2:
            raise DataError(f"The arrays of record {self.name!r} must have one length, 2 or more.")
        if not np.all(np.diff(self.t) > 0):
            raise DataError(f"The instants of record {self.name!r} must ascend.")
        if (self.wave_height is None) != (self.wave_direction is None):
            raise DataError(
                f"Record {self.name!r} states half a sea: give wave_height and wave_direction."
            )
        for name, values in (
            ("rudder", self.delta),
            ("revolutions", self.turns),
            ("heel", self.roll),
            ("roll rate", self.roll_rate),
            ("rate of the roll rate", self.roll_acceleration),
            ("wave height", self.wave_height),
            ("wave direction", self.wave_direction),
        ):
            if values is not None and not np.all(np.isfinite(values)):
                raise DataError(
                    f"The {name} of record {self.name!r} are not known at all instants: fill the "
                    f"gaps or cut the record there."
                )
        unknown = [name for name in self.measured if name not in self.CHANNELS]
        if unknown:
            raise DataError(
                f"Record {self.name!r} has channels {', '.join(unknown)}; an estimator takes "
                f"{', '.join(self.CHANNELS)}."
            )

    def __len__(self) -> int:
        return len(self.t)

    @property
    def _optional(self) -> dict[str, Array | None]:
        """Inputs that are not known of every ship, by the names that `InputField` has for them."""
        controls = (InputField.rudder, InputField.revolutions)
        return {
            field.name: getattr(self, field.name) for field in InputField if field not in controls
        }

    @property
    def conditions(self) -> Conditions:
        """What surrounds the ship all along; wind is an input of each instant."""
        north, east = self.current
        return Conditions(
            depth=self.depth,
            current_speed=math.hypot(north, east),
            current_direction_deg=math.degrees(math.atan2(east, north)),
        )

    @property
    def inputs(self) -> Array:
        """A row of `InputField` per instant."""
        columns = {InputField.rudder: self.delta, InputField.revolutions: self.turns} | {
            InputField[name]: values for name, values in self._optional.items()
        }
        found = np.zeros((len(self), len(InputField)))
        found[:, InputField.wave_height] = Conditions.NO_SEA
        for place, values in columns.items():
            if values is not None:
                found[:, place] = values
        return found

    def force_units(self, model: Model) -> dict[str, float]:
        """½ρLdU² and ½ρL²dU² by each channel of a model [N, N m], U the speed of the approach."""
        ship, water, unit = model.ship, model.water, Convention(system="prime-d")
        return {
            channel: unit.force_unit(channel, ship=ship, water=water, U=self.speed)
            for channel in ("XYNK" if model.rolls else "XYN")
        }

    def calm(self) -> FreeRecord:
        """The record as if no wind had been measured."""
        return self.with_(wind_speed=None, wind_direction=None)

    def with_(self, **changes: object) -> FreeRecord:
        """A copy with some entries changed."""
        from dataclasses import replace

        return replace(self, **changes)  # type: ignore[arg-type]

    def at(self, places: NDArray[np.bool_] | slice) -> FreeRecord:
        """The record at some of its instants.

        Examples
        --------
        >>> t = np.arange(6.0)
        >>> record = FreeRecord(name="a", t=t, delta=t, turns=t, measured={"psi": t}, speed=1.0)
        >>> record.at(slice(None, None, 2)).t
        array([0., 2., 4.])
        """
        return self.with_(
            t=self.t[places],
            delta=self.delta[places],
            turns=self.turns[places],
            measured={name: x[places] for name, x in self.measured.items()},
            **{name: x[places] for name, x in self._optional.items() if x is not None},
        )

    def cut(self, first: float, last: float) -> FreeRecord:
        """The record between two instants."""
        return self.at((self.t >= first) & (self.t <= last))

    def only(self, channels: Sequence[str]) -> FreeRecord:
        """The record with some of its channels.

        Raises
        ------
        DataError
            If one of them is not there.
        """
        lost = [name for name in channels if name not in self.measured]
        if lost:
            raise DataError(
                f"Record {self.name!r} has no {', '.join(lost)}; it has {', '.join(self.measured)}."
            )
        return self.with_(measured={name: self.measured[name] for name in channels})

    @property
    def measured_once(self) -> FreeRecord:
        """The record without what follows from other channels: their noise, once more and summed
        up, is no measurement. A heading that follows from the rate of turn stands for that."""
        twice = {*self.reckoned} - {"psi"} | ({"r"} if "psi" in self.reckoned else set())
        return self.only([name for name in self.measured if name not in twice])

    def first_state(
        self, states: Sequence[str], sensors: Mapping[str, float], L: float
    ) -> tuple[Array, Array]:
        """States at the first instant and their variances.

        Positions and heading are those measured, velocities too where they are; else the speed is
        that of the path over the first ship length, with a wide variance.
        """
        y, spread = np.zeros(len(states)), np.zeros(len(states))
        pace = self.speed / L
        wide = {
            "x": L,
            "y": L,
            "psi": 0.5,
            "u": 0.3 * self.speed,
            "v": 0.2 * self.speed,
            "r": 0.3 * pace,
            "p": 0.1 * pace,
            "phi": 0.1,
        }
        for i, name in enumerate(states):
            values = self.measured.get(name)
            there = np.flatnonzero(np.isfinite(values)) if values is not None else np.array([])
            if values is not None and len(there) and self.t[there[0]] - self.t[0] < 0.2 / pace:
                y[i], spread[i] = (
                    _begun(self.t, values, there, sensors[name]),
                    9 * sensors[name] ** 2,
                )
            else:
                y[i] = self.speed if name == "u" else 0.0
                spread[i] = wide.get(name, 1.0) ** 2
        if "u" not in self.measured and {"x", "y"} <= set(self.measured):
            path = _pace_over_ground(self, 1.0 / pace)
            if math.isfinite(path):
                y[list(states).index("u")] = path
        return y, spread

    def first_states(
        self, begins: NDArray[np.int64], states: Sequence[str], default: Array, length: float
    ) -> Array:
        """States (w, s) at the first instants of windows: straight lines through what is measured.

        begins (w + 1,): first instants, and the number of instants; default (s,): for what no
        measurement tells; length: of the lines [s], three instants at least.
        """
        found = np.zeros((len(begins) - 1, len(states)))
        for w, at in enumerate(begins[:-1].tolist()):
            stop = int(np.searchsorted(self.t, self.t[at] + length))
            rows = slice(at, max(stop, min(at + 3, len(self))))
            lines = {
                name: line
                for name, x in self.measured.items()
                if (line := _line(self.t[rows] - self.t[at], x[rows])) is not None
            }
            found[w] = _start(lines, states, default, self.current)
        return found

    @staticmethod
    def title_of(records: Sequence[FreeRecord]) -> str:
        """Title of the tests of records; empty where they are of several."""
        titles = {record.campaign for record in records}
        return titles.pop() if len(titles) == 1 else ""


def sensors_of(records: Sequence[FreeRecord], given: Mapping[str, float]) -> dict[str, float]:
    """Standard deviation of each channel: as given, else from its own noise.

    None falls below a thousandth of the channel's range, because no sensor is so much better than a
    model: on real records a filter that trusts its sensors more overrules its prior with errors of
    the model. State them where they are known.
    """
    found = {}
    for name in dict.fromkeys(name for record in records for name in record.measured):
        if name in given:
            found[name] = float(given[name])
            continue
        noises = [
            white_noise(record.measured[name]) for record in records if name in record.measured
        ]
        spans = [
            float(np.nanmax(x) - np.nanmin(x))
            for record in records
            if name in record.measured and np.any(np.isfinite(x := record.measured[name]))
        ]
        noise = float(np.nanmedian(noises)) if np.any(np.isfinite(noises)) else math.nan
        if math.isnan(noise) or not spans:
            raise DataError(
                Problem(
                    message=f"The noise of {name} cannot be told from the records.",
                    remedy=Remedy(
                        "State it: {}.", (Way(f"sensors={{{name!r}: …}}", f"--sensors {name}=…"),)
                    ),
                )
            )
        found[name] = max(noise, 1e-3 * max(spans), 1e-9)
    return found


def rate_limited(t: Array, order: Array, rate: float) -> Array:
    """What a steering gear of a rate [rad/s] makes of its orders.

    Examples
    --------
    >>> rate_limited(np.arange(5.0), np.array([0.0, 1.0, 1.0, 1.0, 1.0]), 0.4)
    array([0. , 0. , 0.4, 0.8, 1. ])
    """
    made = np.empty(len(order))
    at = made[0] = float(order[0])
    for i, (gone, wanted) in enumerate(
        zip(np.diff(t).tolist(), order[:-1].tolist(), strict=True), start=1
    ):
        most = rate * gone
        at += min(max(wanted - at, -most), most)
        made[i] = at
    return made


def _begun(t: Array, values: Array, there: NDArray[np.intp], std: float) -> float:
    """The first measurement; if it is wild, what a line through the next ones says of it."""
    v, after = values[there[:7]], t[there[:7]] - t[there[0]]
    if len(v) < 4:
        return float(v[0])
    i, j = np.triu_indices(len(v), 1)
    line = v - after * np.median((v[j] - v[i]) / (after[j] - after[i]))
    level = float(np.median(line))
    scatter = float(np.median(np.abs(line - level)))
    return level if abs(v[0] - level) > 15.0 * std + 10.0 * scatter else float(v[0])


def _pace_over_ground(record: FreeRecord, within: float) -> float:
    """Speed over ground during the first seconds, by a straight line."""
    at = record.t <= record.t[0] + within
    x, y, t = record.measured["x"][at], record.measured["y"][at], record.t[at]
    there = np.isfinite(x) & np.isfinite(y)
    if there.sum() < 3:
        return math.nan
    slopes = np.polyfit(t[there] - t[0], np.stack([x[there], y[there]], axis=1), 1)[0]
    return float(np.hypot(*slopes))


def _line(t: Array, values: Array) -> Array | None:
    """Slope and start of a straight line; None where nothing is measured."""
    there = np.isfinite(values)
    if there.sum() >= 2:
        return np.polyfit(t[there], values[there], 1)
    return np.array([0.0, values[there][0]]) if there.any() else None


def _start(
    lines: Mapping[str, Array], states: Sequence[str], default: Array, current: tuple[float, float]
) -> Array:
    """States from slopes and starts of the channels; velocities are through the water."""
    found = default.copy()
    place = {name: i for i, name in enumerate(states)}
    for name, i in place.items():
        if name in lines:
            found[i] = lines[name][1]
    if "psi" in lines and "r" not in lines:
        found[place["r"]] = lines["psi"][0]
    if {"x", "y", "psi"} <= set(lines) and "u" not in lines:
        north, east = lines["x"][0] - current[0], lines["y"][0] - current[1]
        found[place["u"]], found[place["v"]] = Attitude(psi=lines["psi"][1]).in_ship_axes(
            north, east
        )
    return found


# What the seas of records tell, and what they do not.


ONE_SEA: Final = 1.2
"""Ratio of peak periods up to which one table of drift stands for both."""
ONE_SIDE: Final = math.radians(30.0)
_TURNING: Final = math.radians(20.0)  # by which a wind changes enough to be told from waves


def sea_notes(model: Model, records: Sequence[FreeRecord]) -> tuple[str, ...]:
    """What a reader must know of waves in records: their period, and the wind beside them.

    Parameters
    ----------
    model : Model
        With a part for waves, else there is nothing to say.
    records : sequence of FreeRecord
        Those that are used.

    Returns
    -------
    tuple of str
        That the table is for waves of another period; that wind and waves come from one side, so
        that their forces are not told apart.
    """
    waves = model.in_role("waves")
    stated = [item for item in records if item.wave_height is not None]
    if not waves or not stated:
        return ()
    periods = {item.wave_period for item in stated if item.wave_period is not None}
    other = other_period(model, sorted(periods), "the records state")
    notes = [other] if other else []
    if all(_one_side(item) for item in stated):
        notes.append(
            "Wind and waves come from one side in all records: their forces are not told apart. "
            "Swell from another side, a change of the wind, or a wind that the model knows does."
        )
    return tuple(notes)


def other_period(model: Model, periods: Sequence[float], told: str) -> str:
    """That the drift of a model is for waves of another period; empty where it is not.

    Parameters
    ----------
    model : Model
        With a part for waves.
    periods : sequence of float
        Peak periods of what it sails in [s].
    told : str
        Words before these periods.
    """
    (waves, *_) = model.in_role("waves")
    made_for = model.parts[waves].values.get("Tp", 0.0)
    if not isinstance(made_for, float) or made_for <= 0.0:
        return ""
    off = [f"{x:g} s" for x in periods if not 1 / ONE_SEA <= x / made_for <= ONE_SEA]
    if not off:
        return ""
    return (
        f"The model's drift of waves is for a peak period of {made_for:g} s, {told} "
        f"{', '.join(off)}: make the table anew for their sea (pmmkit seakeeping --tp)."
    )


def _one_side(record: FreeRecord) -> bool:
    """Whether a steady wind blows from where the waves come."""
    wind, waves, blows = record.wind_direction, record.wave_direction, record.wind_speed
    if wind is None or waves is None or blows is None or not np.any(blows > 0.0):
        return False
    mean = _mean(wind)
    steady = float(np.sqrt(np.mean(_between(wind, mean) ** 2))) < _TURNING
    return steady and abs(float(_between(np.array([mean]), _mean(waves))[0])) < ONE_SIDE


def _mean(angles: Array) -> float:
    return float(np.angle(np.mean(np.exp(1j * angles))))


def _between(angles: Array, other: float) -> Array:
    return np.asarray(np.angle(np.exp(1j * (angles - other))))
