"""Integration of the equations of motion between corners, with dense output."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pmmkit.errors import SimulationError

Array = NDArray[np.float64]
RightHandSide = Callable[[float, list[float]], Sequence[float]]
Watch = Callable[[list[float]], float]


@dataclass(frozen=True, kw_only=True)
class Solution:
    """A solution as pieces of dense output.

    Parameters
    ----------
    ends : array (k + 1,)
        Instants between the pieces [s].
    pieces : tuple of callable
        Each takes instants (m,) and gives states (size, m).
    """

    ends: Array
    pieces: tuple[Callable[[Any], Array], ...]

    @property
    def end(self) -> float:
        """Last instant [s]."""
        return float(self.ends[-1])

    def __call__(self, t: Array | float) -> Array:
        """States at instants: (size, m) for m instants, (size,) for one."""
        times = np.atleast_1d(np.asarray(t, float))
        place = np.clip(
            np.searchsorted(self.ends, times, side="right") - 1, 0, len(self.pieces) - 1
        )
        first = self.pieces[0](self.ends[0])
        states = np.empty((len(first), len(times)))
        for index in np.unique(place):
            chosen = place == index
            states[:, chosen] = self.pieces[index](times[chosen])
        return states if np.ndim(t) else states[:, 0]

    def joined(self, later: Solution) -> Solution:
        """This solution with the one that goes on from its end."""
        return Solution(
            ends=np.concatenate([self.ends, later.ends[1:]]), pieces=self.pieces + later.pieces
        )

    def crossing(self, state: int, level: float) -> float:
        """First instant at which a state reaches a level, on the dense output [s].

        Returns
        -------
        float
            NaN where it does not reach it.
        """
        from scipy.optimize import brentq

        for start, end, piece in zip(self.ends[:-1], self.ends[1:], self.pieces, strict=True):
            knots = np.unique(np.concatenate([np.linspace(start, end, 201), piece_knots(piece)]))
            side = piece(knots)[state] - level
            found = np.flatnonzero((side[:-1] < 0) != (side[1:] < 0))
            if len(found):
                low, high = knots[found[0]], knots[found[0] + 1]
                root: float = brentq(
                    lambda t, inside=piece: inside(t)[state] - level,
                    low,
                    high,
                    xtol=1e-10,
                    rtol=1e-14,
                )
                return root
        return math.nan


def piece_knots(piece: Any) -> Array:
    """The steps inside a piece of dense output."""
    return np.asarray(getattr(piece, "ts", []), float)


def integrate(
    rhs: RightHandSide,
    start: Sequence[float],
    *,
    times: Sequence[float],
    scale: Sequence[float],
    rtol: float,
    max_step: float,
    stop: Watch | None = None,
    limit: Watch | None = None,
) -> Solution:
    """Integrate from the first to the last instant, step by step between the corners.

    Parameters
    ----------
    rhs : callable
        Rates of the states from time and states, plain floats.
    start : sequence of float
        States at the first instant.
    times : sequence of float
        First instant, corners, last instant [s].
    scale : sequence of float
        Size of each state; `rtol` times it is the absolute tolerance.
    rtol : float
        Relative tolerance of a step.
    max_step : float
        Longest step [s]. Near a steady turn the error estimate alone lets the steps grow to the
        limit of stability, where the dense output loses digits.
    stop : callable, optional
        Ends the integration where it passes zero.
    limit : callable, optional
        Like `stop`, but an error: the ship has left what the model describes.

    Returns
    -------
    Solution

    Raises
    ------
    SimulationError
        If the motion grows beyond `limit` or the steps become too small.
    """
    from scipy.integrate import solve_ivp

    events = [_event(watch) for watch in (limit, stop) if watch is not None]
    ends, pieces = [float(times[0])], []
    state = np.asarray(start, float)
    for begin, end in pairwise(times):
        with np.errstate(all="ignore"):
            try:
                result = solve_ivp(
                    lambda t, y: rhs(t, y.tolist()), (begin, end), state, method="DOP853",
                    rtol=rtol, atol=rtol * np.asarray(scale, float), dense_output=True,
                    events=events, max_step=max_step,
                )  # fmt: skip
            except (OverflowError, ZeroDivisionError, ValueError) as error:
                raise SimulationError(_grown(begin)) from error
        if result.status < 0 or not np.all(np.isfinite(result.y[:, -1])):
            raise SimulationError(_grown(float(result.t[-1])))
        if limit is not None and len(result.t_events[0]):
            raise SimulationError(_grown(float(result.t_events[0][0])))
        state = result.y[:, -1]
        ends.append(float(result.t[-1]))
        pieces.append(result.sol)
        if result.status == 1:
            break
    return Solution(ends=np.array(ends), pieces=tuple(pieces))


def _event(watch: Watch) -> Callable[[float, Array], float]:
    def event(_: float, y: Array) -> float:
        return watch(y.tolist())

    event.terminal = True  # type: ignore[attr-defined]
    return event


def _grown(t: float) -> str:
    return (
        f"The motion leaves what the model describes at t = {t:.4g} s (it grows without bound or "
        f"the ship capsizes). Check the model's derivatives at this speed, or use less rudder."
    )
