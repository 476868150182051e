"""What the faults of a measurement have in common."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any, Final

from pmmkit.effects.effect import Effect, Parameter
from pmmkit.effects.seen import Observed
from pmmkit.numerics import Array

STEP: Final = 1e-4
"""Small step [rad, m/s or a share] for derivatives: far above rounding, far below a curve."""
ITTC_CAPTIVE: Final = "ittc_7.5-02-06-02"
ITTC_UNCERTAINTY: Final = "ittc_7.5-02-06-04"
AT_SEA: Final = "free-running records hold no force: they do not know this fault"

Columns = Mapping[str, Sequence[Array]]
"""By channel, the harmonics of each coefficient."""


def fault(
    name: str,
    family: str,
    summary: str,
    columns: Callable[[Observed, float], Columns],
    sizes: tuple[Parameter, ...],
    *,
    check: str,
    sources: tuple[str, ...] = (ITTC_UNCERTAINTY,),
    **more: Any,
) -> Effect:
    """A fault of a measurement, with sizes that are usual in a towing tank."""
    return Effect(
        name=name,
        family=family,
        kind="fault",
        summary=summary,
        parameters=sizes,
        columns=columns,
        sources=sources,
        check=check,
        **({} if "moves" in more else {"not_free_running": AT_SEA}) | more,
    )


def size(name: str, unit: str, typical: float, text: str, expected: float = 0.0) -> Parameter:
    """A coefficient of a fault."""
    return Parameter(name=name, unit=unit, typical=typical, text=text, expected=expected)


def one(changes: Mapping[str, Array]) -> Columns:
    """Columns of a fault with one coefficient."""
    return {channel: (column,) for channel, column in changes.items()}
