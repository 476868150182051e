"""Simulate a manoeuvre of a model."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Final

import numpy as np

from pmmkit import kernel
from pmmkit.errors import DataError, Problem, SimulationError, UnknownNameError
from pmmkit.model import Model, load_model
from pmmkit.simulation.integrate import Solution, integrate
from pmmkit.simulation.metrics import steady_turn, turning_metrics
from pmmkit.simulation.steering import RudderLaw, RudderOrder
from pmmkit.simulation.track import Track

MANOEUVRES: Final = ("turning",)
HEADING: Final = 3 * math.pi
"""A turning circle ends after this change of heading (540°) …"""
LONGEST: Final = 2000.0
"""… or after this time in ship lengths over the approach speed,"""
MORE_TURNS: Final = 6
"""and goes on for so many turns at most until it is steady."""
LONGEST_STEP: Final = 0.5
"""Longest step of the integration in ship lengths over the approach speed."""
_FASTEST: Final = 10.0


def simulate(
    model: Model | str | Path,
    manoeuvre: str = "turning",
    *,
    rudder_deg: float = 35.0,
    speed: float,
    duration: float | None = None,
    rudder_rate_deg: float | None = None,
    rudder_law: RudderLaw = "ramp",
    rudder_lag: float = 1.0,
    dt: float | None = None,
    rtol: float = 1e-8,
    extrapolate: bool = False,
) -> Track:
    """Simulate a manoeuvre from steady running straight ahead.

    The rudder is ordered at t = 0; the propeller keeps the revolutions of self-propulsion at the
    approach speed; the derivatives are those of the approach Froude number throughout.

    Parameters
    ----------
    model : Model, str or path
        A model, a library name or a file.
    manoeuvre : {"turning"}
        Turning circle.
    rudder_deg : float
        Ordered rudder angle [deg], positive to starboard.
    speed : float
        Approach speed [m/s] at the scale of the model.
    duration : float, optional
        Length of the track [s]; by default until 540° of heading and the turn is steady.
    rudder_rate_deg : float, optional
        Rate of the steering gear [deg/s]; by default that of the model's rudder.
    rudder_law : {"ramp", "lag"}
        At the rate until the order is reached, or with a first-order lag at most at the rate.
    rudder_lag : float
        Time constant of the lag law [s].
    dt : float, optional
        Interval of the samples [s]; by default about a twentieth of L/speed. The metrics do not
        depend on it.
    rtol : float
        Relative tolerance of the integration.
    extrapolate : bool
        Allow a speed outside the range of the model's values.

    Returns
    -------
    Track

    Raises
    ------
    DataError
        If an argument makes no sense; all of them at once.
    MissingPartError, ExtrapolationError
        If the model lacks a part, or has no values at that speed.
    SimulationError
        If the motion grows without bound.

    Examples
    --------
    >>> track = simulate("s175-3dof", "turning", rudder_deg=35, speed=6.0)
    >>> round(track.metrics["tactical_diameter_L"], 2)
    4.35
    """
    loaded = model if isinstance(model, Model) else load_model(model)
    if manoeuvre not in MANOEUVRES:
        raise UnknownNameError(
            f"There is no manoeuvre {manoeuvre!r}; there is: {', '.join(MANOEUVRES)}."
        )
    _check(rudder_deg, speed, duration, rudder_rate_deg, rudder_law, rudder_lag, dt, rtol)
    c = kernel.prepare(loaded, speed, extrapolate=extrapolate)
    n = kernel.self_propulsion(c, speed)
    gear = RudderOrder(
        order=math.radians(rudder_deg),
        rate=math.radians(_rate(loaded, rudder_deg, rudder_rate_deg)),
        law=rudder_law,
        lag=rudder_lag,
    )
    turn = _Turn(c, n, gear, speed, rtol)
    solution, notes = turn.run(duration)
    steady = steady_turn(c, solution(solution.end), gear.angle(solution.end), n, speed)
    if steady is None and duration is None:
        notes.append("The turn does not become steady: no steady diameter, drift or speed.")
    t = _samples(solution.end, dt or _interval(loaded.ship.L / speed))
    states = solution(t)
    still = np.zeros(len(t))
    return Track(
        t=t, x=states[0], y=states[1], psi=states[2], u=states[3], v=states[4], r=states[5],
        p=states[6] if loaded.rolls else still,
        phi=states[7] if loaded.rolls else still,
        delta=np.array([gear.angle(x) for x in t.tolist()]),
        n=np.full(len(t), n),
        name=loaded.name, manoeuvre=manoeuvre, L=loaded.ship.L, speed=speed,
        Fn=loaded.ship.froude(speed, loaded.water.g), rudder_deg=float(rudder_deg),
        metrics=turning_metrics(solution, steady, rudder=gear.order, speed=speed, L=loaded.ship.L),
        scale=loaded.scale, notes=tuple(notes),
    )  # fmt: skip


class _Turn:
    """The initial value problem of a turn."""

    def __init__(
        self, c: kernel.Constants, n: float, gear: RudderOrder, speed: float, rtol: float
    ) -> None:
        self.c, self.n, self.gear, self.rtol = c, n, gear, rtol
        self.rolls = c.roll is not None
        self.unit = c.L / speed
        scale = [c.L, c.L, 1.0, speed, speed, speed / c.L, speed / c.L, 1.0]
        self.scale = scale if self.rolls else scale[:6]
        self.start = [0.0, 0.0, 0.0, speed, 0.0, 0.0, 0.0, 0.0][: len(self.scale)]
        self.fastest = _FASTEST * speed

    def rhs(self, t: float, y: list[float]) -> tuple[float, ...]:
        return kernel.rates(tuple(y), self.gear.angle(t), self.n, self.c)

    def limit(self, y: list[float]) -> float:
        inside = self.fastest - math.hypot(y[3], y[4])
        return min(inside / self.fastest, 1.0 - abs(y[7]) / (math.pi / 2)) if self.rolls else inside

    def go(self, state: list[float], begin: float, end: float, heading: float | None) -> Solution:
        corners = [x for x in self.gear.corners if begin < x < end]
        return integrate(
            self.rhs, state, times=[begin, *corners, end], scale=self.scale, rtol=self.rtol,
            stop=None if heading is None else lambda y: abs(y[2]) - heading,
            limit=self.limit, max_step=LONGEST_STEP * self.unit,
        )  # fmt: skip

    def run(self, duration: float | None) -> tuple[Solution, list[str]]:
        if duration is not None:
            return self.go(self.start, 0.0, duration, None), []
        longest = LONGEST * self.unit
        solution = self.go(self.start, 0.0, longest, HEADING)
        for turns in range(1, MORE_TURNS + 1):
            if solution.end >= longest or self.settled(solution):
                break
            state = solution(solution.end).tolist()
            heading = HEADING + turns * 2 * math.pi
            solution = solution.joined(self.go(state, solution.end, longest, heading))
        if solution.end >= longest:
            turned = math.degrees(abs(solution(solution.end)[2]))
            return solution, [
                f"The heading changed by {turned:.3g}° only within {LONGEST:g} ship lengths."
            ]
        return solution, []

    def settled(self, solution: Solution) -> bool:
        t = solution.end
        near = steady_turn(self.c, solution(t), self.gear.angle(t), self.n, self.c.L / self.unit)
        return near is not None


def _check(
    rudder_deg: float, speed: float, duration: float | None, rate: float | None, law: str,
    lag: float, dt: float | None, rtol: float,
) -> None:  # fmt: skip
    found = []
    if not (math.isfinite(rudder_deg) and 0 < abs(rudder_deg) <= 90):
        found.append(f"rudder_deg = {rudder_deg} must be an angle up to 90° to either side, not 0.")
    for name, value in (
        ("speed", speed), ("duration", duration), ("rudder_rate_deg", rate), ("rudder_lag", lag),
        ("dt", dt),
    ):  # fmt: skip
        if value is not None and not (math.isfinite(value) and value > 0):
            found.append(f"{name} = {value} must be positive.")
    if law not in ("ramp", "lag"):
        found.append(f"rudder_law = {law!r} is not known: ramp, lag.")
    if not 1e-13 < rtol < 0.1:
        found.append(f"rtol = {rtol} must lie between 1e-13 and 0.1.")
    if dt and duration and math.isfinite(duration / dt) and duration / dt > 1e7:
        found.append(f"dt = {dt:g} s over {duration:g} s are more than ten million samples.")
    if found:
        raise DataError([Problem(message=text) for text in found], title="Cannot simulate")


def _rate(model: Model, rudder_deg: float, given: float | None) -> float:
    values = (
        model.values("rudder_mmg", model.Fn[0] if model.Fn else None)
        if ("rudder_mmg" in model.parts)
        else {}
    )
    largest = values.get("max_deg", 90.0)
    if abs(rudder_deg) > largest:
        raise SimulationError(
            f"The rudder of {model.name!r} goes to {largest:g}°; {rudder_deg:g}° were ordered. "
            f"Order less, or change max_deg in the model."
        )
    if given is not None:
        return given
    if "rate_deg_s" not in values:
        raise DataError(
            f"Model {model.name!r} states no rate of the steering gear; give rudder_rate_deg."
        )
    return values["rate_deg_s"]


def _interval(unit: float) -> float:
    """The 1, 2 or 5 times a power of ten next below a twentieth of a time."""
    target = unit / 20
    power = 10.0 ** math.floor(math.log10(target))
    return max(x * power for x in (1.0, 2.0, 5.0) if x * power <= target * (1 + 1e-12))


def _samples(end: float, dt: float) -> np.ndarray:
    t = np.arange(math.floor(end / dt * (1 + 1e-12)) + 1) * dt
    return t if end - t[-1] < 1e-9 * max(end, 1.0) else np.append(t, end)
