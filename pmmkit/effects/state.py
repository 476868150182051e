"""The motion that an effect sees: arrays, nothing of runs or models."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, fields, replace

import numpy as np

from pmmkit.numerics import Array


@dataclass(frozen=True, kw_only=True)
class State:
    """Motion of a ship at n instants, ship axes, referred to midship, SI and radians.

    Parameters
    ----------
    u, v, r : array (n,)
        Surge and sway velocity [m/s], yaw rate [rad/s].
    p, phi : array (n,)
        Roll rate [rad/s], heel [rad], positive to starboard down.
    udot, vdot, rdot, pdot : array (n,)
        Accelerations [m/s², rad/s²] in ship axes.
    delta : array (n,)
        Rudder angle [rad], positive turns the ship to starboard.
    rps : array (n,)
        Propeller revolutions per second.
    thrust : array (n,)
        Propeller thrust [N]; zero without a propeller.
    sinkage, trim : array (n,)
        Sinkage of midship [m], positive down, and trim [rad], positive bow up; zero where they
        are not measured.
    """

    u: Array
    v: Array
    r: Array
    p: Array
    phi: Array
    udot: Array
    vdot: Array
    rdot: Array
    pdot: Array
    delta: Array
    rps: Array
    thrust: Array
    sinkage: Array
    trim: Array

    @classmethod
    def of(cls, size: int | None = None, **given: float | Array) -> State:
        """A state from what is known; everything else is zero.

        Examples
        --------
        >>> State.of(u=2.0, v=np.array([0.1, 0.2])).r
        array([0., 0.])
        """
        arrays = {name: np.atleast_1d(np.asarray(value, float)) for name, value in given.items()}
        length = size or max((len(array) for array in arrays.values()), default=1)
        zero = np.zeros(length)
        return cls(
            **{
                field.name: np.broadcast_to(arrays.get(field.name, zero), (length,))
                for field in fields(cls)
            }
        )

    @classmethod
    def joined(cls, states: Sequence[State]) -> State:
        """Several states one after another.

        Examples
        --------
        >>> State.joined([State.of(u=1.0), State.of(u=[2.0, 3.0])]).u
        array([1., 2., 3.])
        """
        return cls(
            **{
                field.name: np.concatenate([getattr(state, field.name) for state in states])
                for field in fields(cls)
            }
        )

    @property
    def speed(self) -> Array:
        """Instantaneous speed sqrt(u² + v²) [m/s]."""
        return np.hypot(self.u, self.v)

    def with_(self, **changes: Array) -> State:
        """A copy with some arrays changed."""
        return replace(self, **changes)

    def moved_aft(self, x: float) -> State:
        """Motion of the point that lies x [m] aft of this one: v - x r and v̇ - x ṙ, else the same.

        Examples
        --------
        >>> State.of(u=1.0, v=0.3, r=0.1).moved_aft(2.0).v
        array([0.1])
        """
        if x == 0.0:
            return self
        return self.with_(v=self.v - x * self.r, vdot=self.vdot - x * self.rdot)

    def at(self, index: slice | Array | Iterable[int]) -> State:
        """The state at some of the instants."""
        return State(**{field.name: getattr(self, field.name)[index] for field in fields(self)})
