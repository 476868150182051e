"""What every fault of a measurement must hold."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import product

import numpy as np

from pmmkit.diagnosis import candidate_of, standard_tests
from pmmkit.effects import Effect
from pmmkit.numerics import Array
from pmmkit.reduction import RunView


def declared_fault(effect: Effect) -> Iterator[str]:
    """What is wrong with what a fault says of itself."""
    if effect.acts is None and not effect.not_captive:
        yield "it does not act on records"
    if not (effect.coefficients or effect.suspects):
        yield "it has no size, and the checks do not suspect it"
    if effect.roles:
        yield "a fault has no role in a model"
    known = {item.name for item in effect.parameters}
    for form in effect.suspects:
        named = {form.unknown, *(name for value in form.grid for name in form.at(value))} - {""}
        lost = sorted(named - known)
        if lost:
            yield f"it is suspected by {', '.join(lost)}, which are none of its parameters"


def acts_on_records(effect: Effect) -> Iterator[str]:
    """Forces are shown in their form; nothing at zero, and in proportion where it says so."""
    if effect.acts is None or not effect.coefficients:
        return
    views, base = standard_tests()
    speeds = sorted({view.speed for view in views})
    for view, value in product(views, candidate_of(effect, speeds).grid):
        run = RunView(view, base)
        at = {effect.nonlinear.name: value} if effect.nonlinear else {}
        for item in effect.coefficients:
            none, once, twice = (
                effect.shown(run, {**at, item.name: times * item.step}) for times in (0, 1, 2)
            )
            for channel, shown in once.items():
                true = run.forces[channel]
                if shown.shape != true.shape:
                    yield f"what it shows of {channel} has the shape {shown.shape}"
                    continue
                change, size = shown - true, float(np.abs(true).max())
                if not _alike(none.get(channel, true), true, size):
                    yield f"it shows something of {channel} where {item.name} is zero"
                elif item.step == 1.0 and not _alike(twice[channel] - true, 2.0 * change, size):
                    yield f"it is not in proportion to {item.name}: state a step"


def _alike(one: Array, other: Array, size: float) -> bool:
    """Whether forces are the same but for rounding; what is not finite is told elsewhere."""
    finite = np.isfinite(one) & np.isfinite(other)
    return bool(np.allclose(one[finite], other[finite], rtol=1e-9, atol=1e-9 * size))
