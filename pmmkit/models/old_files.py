"""Older files: a history in sentences as steps, a drift at rest and at a speed as one table."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping
from typing import Final

from pmmkit.effects.catalogue import is_fault
from pmmkit.models.step import Step, Value

_ADDED: Final = re.compile(
    r"Added (?P<effect>[^:(]+?)(?: \((?P<why>.*)\))?: error of left-out conditions "
    r"(?P<before>[\d.]+|nan) % to (?P<after>[\d.]+|nan) % of the rms forces of (?P<tests>.*)\.",
    re.DOTALL,
)


def steps_of_sentences(history: Iterable[str]) -> tuple[Step, ...]:
    """The steps that a ``history`` of sentences tells.

    Parameters
    ----------
    history : iterable of str
        As the first release wrote it. An effect or a fault that a fit took in becomes a step that
        can be undone; any other sentence is noted as it is.

    Examples
    --------
    >>> line = ("Added memory (over 1000 to 1): error of left-out conditions 3.10 % to 1.90 % of "
    ...         "the rms forces of S175.")
    >>> (step,) = steps_of_sentences([line])
    >>> step.action, step.effect, step.error_after
    ('effect_added', 'memory', 0.019)
    >>> str(step) == line
    True
    """
    return tuple(_step(line) for line in history)


def _step(line: str) -> Step:
    found = _ADDED.fullmatch(line)
    if found is None:
        return Step(action="noted", note=line)
    before, after = (
        None if found[name] == "nan" else round(float(found[name]) / 100.0, 6)
        for name in ("before", "after")
    )
    return Step(
        action="fault_corrected" if is_fault(found["effect"]) else "effect_added",
        effect=found["effect"],
        error_before=before,
        error_after=after,
        campaign=found["tests"],
        note=found["why"] or "",
    )


def drift_over_speeds(values: Mapping[str, Value]) -> dict[str, Value]:
    """Values of the mean drift of waves, of which older files state those at rest apart.

    Parameters
    ----------
    values : mapping
        Of a part; what holds no ``DX_rest`` is left as it is.

    Examples
    --------
    >>> rest, moving = ("DX_rest", "DY_rest", "DN_rest"), ("DX", "DY", "DN")
    >>> old = dict.fromkeys(rest, (0.0, 0.1)) | dict.fromkeys(moving, (0.2, 0.3)) | {"speed": 8.0}
    >>> new = drift_over_speeds(old)
    >>> new["speeds"], new["DN"], "DX_rest" in new
    ((0.0, 8.0), (0.0, 0.1, 0.2, 0.3), False)
    """
    found, speed = dict(values), values.get("speed")
    tables = {name: (values.get(f"{name}_rest"), values.get(name)) for name in ("DX", "DY", "DN")}
    if not isinstance(speed, float):
        return found
    for name, (rest, moving) in tables.items():
        if not isinstance(rest, tuple) or not isinstance(moving, tuple):
            return dict(values)
        found[name] = (*rest, *moving)
        del found[f"{name}_rest"]
    del found["speed"]
    return found | {"speeds": (0.0, speed)}
