"""What the faults of a measurement have in common."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any, Final

from pmmkit.effects.definition import Effect, Parameter
from pmmkit.effects.seen import Acts, Forces, Observed
from pmmkit.effects.suspect import Suspect
from pmmkit.numerics import Array

STEP: Final = 1e-4
"""Small step [rad, m/s or a share] for derivatives: far above rounding, far below a curve."""
DEGREES: Final = math.degrees(STEP)
"""The same for angles in degrees."""
ITTC_CAPTIVE: Final = "ittc_7.5-02-06-02"
ITTC_UNCERTAINTY: Final = "ittc_7.5-02-06-04"
AT_SEA: Final = "free-running records hold no force: they do not know this fault"


def fault(
    name: str,
    family: str,
    summary: str,
    acts: Acts,
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
        acts=acts,
        sources=sources,
        check=check,
        **({} if "moves" in more else {"not_free_running": AT_SEA}) | more,
    )


def suspicion(
    name: str, family: str, summary: str, acts: Acts, suspects: tuple[Suspect, ...], **more: Any
) -> Effect:
    """A slip or fault that the checks look for, and no diagnosis."""
    more.setdefault("remark", "a slip that files hold, no formula of a source")
    return Effect(
        name=name,
        family=family,
        kind="fault",
        summary=summary,
        acts=acts,
        suspects=suspects,
        **more,
    )


def size(
    name: str, unit: str, typical: float, text: str, expected: float = 0.0, *, step: float = 1.0
) -> Parameter:
    """A coefficient of a fault; by default it acts in proportion."""
    return Parameter(name=name, unit=unit, typical=typical, text=text, expected=expected, step=step)


def beside(run: Observed, more: Mapping[str, Array]) -> Forces:
    """The forces of some channels with histories (n,) that the gauges show beside them."""
    return {
        channel: run.forces[channel] + run.project(history)
        for channel, history in more.items()
        if channel in run.forces
    }
