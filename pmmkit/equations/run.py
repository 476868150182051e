"""Running a plan: one ship with its history, or many ships with their metrics."""

from __future__ import annotations

import math
import os
from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from functools import cached_property, lru_cache
from typing import Any, ClassVar, Final, Literal

import numpy as np

from pmmkit.base import ModelError, SimulationError
from pmmkit.equations.compilation import is_compiled, is_loaded
from pmmkit.equations.histories import forces_by_effect
from pmmkit.equations.layouts import (
    Constant,
    Control,
    EventField,
    OutcomeField,
    SettingField,
    Status,
    StepField,
)
from pmmkit.equations.plan import Plan, ProbeResults
from pmmkit.equations.prepared import LONGEST_STEP, Prepared, mass_problem, propulsion_problem
from pmmkit.equations.structure import EquationStructure
from pmmkit.numerics import Array

FASTEST: Final = 10.0
"""A ship beyond so many times its approach speed has left what the model describes."""
ROOM: Final = 400
"""Steps for which there is room at first."""
MOST: Final = 400 * 4**4
"""Steps of a manoeuvre: hundreds are usual, ten thousand with a tolerance of 1e-11. A ship that
trembles, as some that are drawn from wide spreads do, would take millions."""


Revolutions = float | Literal["speed"] | None
"""Of the approach [1/s]: stated, or by which the speed is held, in waves or (None) without them."""


@dataclass(frozen=True, kw_only=True)
class Gear:
    """How the controls follow their orders.

    Parameters
    ----------
    rudder_rate : float
        [rad/s]
    rudder_lag : float
        Time constant near the order [s]; 0 goes at the rate to the end.
    revolutions_rate : float
        Rate of the revolutions, or of their order where an effect ``shaft`` moves them, over those
        of the approach [1/s].
    bucket_rate : float
        Of a waterjet [1/s].
    """

    INSTANT: ClassVar[float] = 1e9
    """Rate of a control that follows its order at once."""
    REVERSAL: ClassVar[float] = 2.0
    """Time in ship lengths over the approach speed in which revolutions fall to zero, in a model
    without a shaft, and in which the bucket of a waterjet goes down."""
    rudder_rate: float
    rudder_lag: float = 0.0
    revolutions_rate: float = INSTANT
    bucket_rate: float = INSTANT


ENOUGH: Final = 25_000
"""Interpreted steps of one structure after which it is compiled. They take 0.7 to 2.2 s, to import
numba and compile 1.5 s."""
FEW: Final = 2_000
"""The same where the machine code lies on the disk: 22 turns; to fetch it takes the time of 40,
which a reduction with its ten would not get back."""
_INTERPRETED: Final[Counter[EquationStructure]] = Counter()
"""Steps of each structure so far, those of ships that failed among them: it decides on time alone,
never on a number."""


def _pays(structure: EquationStructure, to_come: int = 0) -> bool:
    """Whether compiled functions take less time than the interpreted steps so far and those to
    come: those that the session has loaded always do."""
    if is_loaded(structure):
        return True
    steps = _INTERPRETED[structure] + to_come
    return steps >= ENOUGH or (steps >= FEW and is_compiled(structure))


@dataclass(frozen=True, kw_only=True, eq=False)
class DenseHistory:
    """An integrated manoeuvre with its dense output.

    Parameters
    ----------
    ready : Prepared
        The ship.
    plan : Plan
        What she was ordered.
    steps, events, settings : list of float, or array
        As the engine fills them.
    constants : list of float, or array
        With the inverse of the mass matrix, as the functions take them.
    kept : int
        Number of steps.
    n0 : float
        Revolutions of the approach [1/s].
    fast : bool
        Whether compiled functions made it.
    """

    ready: Prepared
    plan: Plan
    steps: Any
    events: Any
    settings: Any
    constants: Any
    kept: int
    n0: float
    fast: bool

    @property
    def end(self) -> float:
        """Last instant [s]."""
        return float(self._table[-1, EventField.begin])

    @property
    def begins(self) -> tuple[float, ...]:
        """Instants at which the phases begin [s]."""
        return tuple(self._table[:-1, EventField.begin].tolist())

    @property
    def finished(self) -> tuple[bool, ...]:
        """Whether each phase was ended by what it waited for."""
        return tuple(map(bool, self._table[:-1, EventField.finished]))

    @cached_property
    def _table(self) -> Array:
        return np.asarray(self.events).reshape(-1, len(EventField))

    @cached_property
    def results(self) -> ProbeResults:
        """What the probes of the plan find."""
        states = self.ready.structure.states
        width, count = 1 + len(states), len(self.plan.probes)
        functions = self.ready.functions(fast=self.fast)
        found = self.room(width * count)
        functions.probe(
            self.steps,
            self.events,
            self.plan.questions_array if self.fast else self.plan.questions,
            count,
            self.n0,
            self.settings,
            self.constants,
            found,
        )
        flat = found.tolist() if self.fast else found
        values = [flat[i * width : (i + 1) * width] for i in range(count)]
        return ProbeResults(
            places=self.plan.places,
            states=states,
            values=values,
            speed=self.ready.speed,
            L=self.ready.L,
        )

    def channels(self, t: Array) -> dict[str, Array]:
        """States, rudder angle ``delta`` and revolutions ``n`` at ascending instants."""
        rows, states = self.sampled(t), self.ready.structure.states
        followed = {
            "delta": rows[len(states) + Control.rudder],
            "n": rows[len(states) + Control.revolutions],
        }
        return followed | dict(zip(states, rows, strict=False))

    def forces(self, t: Array) -> dict[str, Array]:
        """X, Y [N] and N [N m] about midship (3, n) of each effect at ascending instants.

        Added mass apart. The polynomial is called ``derivatives``.

        Raises
        ------
        SimulationError
            If derivatives follow the speed of the moment: these are constants of no history.
        """
        if self.ready.structure.follows:
            raise SimulationError(
                "Forces of each effect are not kept where derivatives follow the speed of the "
                'moment; take those of the approach: fn = "approach".'
            )
        rows, place = self.sampled(t), len(self.ready.structure.states)
        controls = {
            "n_order": rows[place + Control.revolutions],
            "bucket": rows[place + Control.bucket],
        }
        return forces_by_effect(self.ready.structure, self.ready.k, controls | self.channels(t))

    def sampled(self, t: Array) -> Array:
        """States and the three controls at ascending instants, a row each."""
        rows = len(self.ready.structure.states) + 3
        functions = self.ready.functions(fast=self.fast)
        times = t if self.fast else t.tolist()
        out = self.room(rows * len(t))
        functions.sample(
            self.steps,
            self.kept,
            self.events,
            len(self.plan.phases),
            self.settings,
            times,
            len(t),
            self.n0,
            out,
        )
        return np.asarray(out).reshape(rows, len(t))

    def room(self, size: int) -> Any:
        """Room for numbers, as the functions take it."""
        return np.empty(size) if self.fast else [0.0] * size


@lru_cache(maxsize=64)
def settings_for(
    L: float, speed: float, gear: Gear, rtol: float, revolutions: Revolutions = None
) -> tuple[float, ...]:
    """The settings of the integrator, in the order of `SettingField`."""
    values = {
        SettingField.rtol: rtol,
        SettingField.longest: LONGEST_STEP * L / speed,
        SettingField.speed: speed,
        SettingField.rudder_rate: gear.rudder_rate,
        SettingField.rudder_lag: gear.rudder_lag,
        SettingField.revolutions_rate: gear.revolutions_rate,
        SettingField.revolutions_lag: 0.0,
        SettingField.bucket_rate: gear.bucket_rate,
        SettingField.bucket_lag: 0.0,
        SettingField.revolutions: -1.0 if revolutions == "speed" else revolutions or 0.0,
        SettingField.fastest: FASTEST * speed,
    }
    return tuple(values[place] for place in SettingField)


def run_plan(
    ready: Prepared,
    plan: Plan,
    gear: Gear,
    *,
    rtol: float,
    fast: bool | None = None,
    revolutions: Revolutions = None,
) -> DenseHistory:
    """Integrate one ship through a plan.

    Parameters
    ----------
    ready : Prepared
        The ship at her approach.
    plan : Plan
        What is ordered.
    gear : Gear
        How the controls follow.
    rtol : float
        Relative tolerance.
    fast : bool, optional
        Whether compiled functions do it; by default once the structure is sailed often.
    revolutions : float or "speed", optional
        Of the approach [1/s]; by default those of self-propulsion without waves, by ``speed``
        those in the waves.

    Returns
    -------
    DenseHistory

    Raises
    ------
    SimulationError
        If the motion grows without bound.
    ModelError
        If the mass matrix is not positive, or no revolutions hold the speed.
    """
    asked = fast
    if fast is None:
        fast = _pays(ready.structure)
    functions = ready.functions(fast=fast)
    given = settings_for(ready.L, ready.speed, gear, rtol, revolutions)
    settings: Any = np.array(given) if fast else list(given)
    orders: Any = plan.orders_array if fast else plan.orders
    count = len(plan.phases)
    marks = len(EventField) * (count + 1)
    events: Any = np.zeros(marks) if fast else [0.0] * marks
    stride = functions.STRIDE
    room = ROOM
    while True:
        steps: Any = np.empty(stride * room) if fast else [0.0] * (stride * room)
        k: Any = ready.array.copy() if fast else list(ready.k)
        try:
            status, kept, n0 = functions.run(
                k, orders, count, settings, steps, stride * room, events
            )
        except ModelError:
            raise
        except (OverflowError, ZeroDivisionError, ValueError):
            status, kept, n0 = Status.unbound, 0, math.nan
        if not fast:
            _INTERPRETED[ready.structure] += kept
        if status != Status.no_room or room >= MOST:
            break
        room *= 4
        if asked is None and not fast and _pays(ready.structure, room):
            return run_plan(ready, plan, gear, rtol=rtol, fast=True, revolutions=revolutions)
    if status != Status.done:
        last = steps[stride * (kept - 1) + StepField.begin] if kept else 0.0
        raise problem(status, ready, float(last))
    return DenseHistory(
        ready=ready,
        plan=plan,
        steps=steps,
        events=events,
        settings=settings,
        constants=k,
        kept=kept,
        n0=float(n0),
        fast=fast,
    )


def problem(status: int, ready: Prepared, t: float) -> SimulationError | ModelError:
    """The error that a status of the engine stands for."""
    if status == Status.mass:
        return ModelError(mass_problem(ready.name))
    if status == Status.no_propulsion:
        return ModelError(propulsion_problem(ready.name, ready.speed))
    if status == Status.no_room:
        return SimulationError(
            f"The motion needs more than {MOST:,} steps; at t = {t:.4g} s they were used up. Some "
            f"force changes far faster than the ship moves: look for a coefficient that is too "
            f"large by orders of magnitude, in an own effect above all."
        )
    return SimulationError(
        f"The motion leaves what the model describes at t = {t:.4g} s (it grows without bound or "
        f"the ship capsizes). Check the model's derivatives at this speed, or use less rudder."
    )


CHUNK: Final = 250
"""Ships that one thread takes at a time."""
BATCH_ROOM: Final = 4000
"""Steps of a ship for which each thread has room."""


def run_ships(
    structure: EquationStructure,
    k: Sequence[Any],
    number: int,
    plan: Plan,
    gear: Gear,
    *,
    speed: float,
    rtol: float,
    revolutions: Revolutions = None,
    jobs: int | None = None,
    advance: Callable[[int], object] | None = None,
) -> tuple[ProbeResults, Array]:
    """Run many ships of one structure through a plan.

    Parameters
    ----------
    structure : EquationStructure
        Of all of them.
    k : sequence
        Constants one after another, a number or one for each ship.
    number : int
        Of the ships.
    plan : Plan
        What is ordered.
    gear : Gear
        How the controls follow.
    speed : float
        Of the approach [m/s].
    rtol : float
        Relative tolerance.
    revolutions : float or "speed", optional
        Of the approach [1/s]; by default those of self-propulsion.
    jobs : int, optional
        Threads; by default one for each core.
    advance : callable, optional
        Told how many ships are done.

    Returns
    -------
    ProbeResults, array (ships,)
        What the probes find, and the status of each ship.

    Notes
    -----
    Each ship is integrated on its own, in a lane of `pmmkit.equations.lanes`: the
    results are the same bit for bit whatever the number of threads and whichever ships are beside
    it.
    """
    from pmmkit.equations.code_generation import SAILING
    from pmmkit.equations.compilation import compiled
    from pmmkit.equations.lanes import memory_size

    functions = compiled(structure, SAILING)
    width = len(k)
    ships = np.empty((number, width))
    for column, value in enumerate(k):
        ships[:, column] = value
    L = float(ships[0, Constant.L])
    settings = settings_for(L, speed, gear, rtol, revolutions)
    asked, states = len(plan.probes), structure.states
    filled = np.empty(number * asked * (1 + len(states)))
    outcomes = np.empty(len(OutcomeField) * number)
    flat = ships.reshape(-1)
    orders, questions, given = plan.orders_array, plan.questions_array, np.array(settings)
    room = BATCH_ROOM * functions.STRIDE
    lanes, counted = functions.LANES, (len(states), width, len(plan.phases), asked)
    kept = memory_size(lanes, functions.WIDE, *counted)

    def work(first: int) -> int:
        last: int = min(first + CHUNK, number)
        # Lanes without a ship reckon with zeros.
        with np.errstate(all="ignore"):
            functions.run_many(
                flat,
                first,
                last,
                width,
                orders,
                len(plan.phases),
                given,
                questions,
                asked,
                room,
                np.empty(lanes * room),
                np.zeros(kept),
                filled,
                outcomes,
            )
        return last - first

    starts = range(0, number, CHUNK)
    threads = min(jobs or os.cpu_count() or 1, len(starts))
    with ThreadPoolExecutor(max(threads, 1)) as pool:
        done: Iterator[int] = pool.map(work, starts) if threads > 1 else map(work, starts)
        for size in done:
            if advance is not None:
                advance(size)
    values = filled.reshape(number, asked, 1 + len(states)).transpose(1, 2, 0)
    results = ProbeResults(places=plan.places, states=states, values=values, speed=speed, L=L)
    return results, outcomes.reshape(-1, len(OutcomeField))[:, OutcomeField.status]
