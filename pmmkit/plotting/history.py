"""What is drawn of a free-running history, whatever holds it."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Protocol

from pmmkit.numerics import Array


class History(Protocol):
    """A free-running history: arrays over the time, SI and radians, and what they are of.

    A `Track` has this shape, and so has anything else with these attributes.
    """

    def __len__(self) -> int: ...

    @property
    def t(self) -> Array: ...

    @property
    def x(self) -> Array: ...

    @property
    def y(self) -> Array: ...

    @property
    def psi(self) -> Array: ...

    @property
    def u(self) -> Array: ...

    @property
    def v(self) -> Array: ...

    @property
    def r(self) -> Array: ...

    @property
    def phi(self) -> Array: ...

    @property
    def delta(self) -> Array: ...

    @property
    def n(self) -> Array: ...

    @property
    def name(self) -> str: ...

    @property
    def L(self) -> float: ...

    @property
    def speed(self) -> float: ...

    @property
    def Fn(self) -> float: ...

    @property
    def rudder_deg(self) -> float: ...

    @property
    def metrics(self) -> Mapping[str, float]: ...

    @property
    def orders(self) -> tuple[float, ...]: ...

    @property
    def settings(self) -> Mapping[str, Any]: ...
