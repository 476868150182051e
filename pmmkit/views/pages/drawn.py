"""What each candidate alone would do to the tests, before anything is added."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any, Final

from pmmkit.models import Step
from pmmkit.numerics import Array
from pmmkit.views.pages.numbers import short
from pmmkit.views.pages.records import MOTIONS

NUMBERS: Final = 120_000
"""Of all paths together, where a page holds one campaign: it stays small enough for one file."""


def drawn_over(
    evidence: Any,
    steps: Sequence[Step],
    chosen: Sequence[Any],
    heard: Callable[[float, str], None],
    *,
    numbers: int = NUMBERS,
) -> dict[str, dict[str, Any]]:
    """What each candidate would do, alone beside the base as it stands."""
    shares, overlays, base = evidence.alone(
        steps, chosen, lambda number, name: heard(number / len(chosen), name), numbers=numbers
    )
    return {
        "shares": {
            name: {
                "all": short(own["all"]),
                "channels": {key: short(x) for key, x in own.items() if key != "all"},
            }
            for name, own in shares.items()
        },
        "overlays": {
            name: {
                run: {key: values for key, values in _on_screen(own).items() if key != "t"}
                for run, own in runs.items()
            }
            for name, runs in overlays.items()
        },
        "base": {run: _on_screen(own) for run, own in base.items()},
    }


def _on_screen(columns: Mapping[str, Array]) -> dict[str, list[float]]:
    """Forces as they are, motions in the units of the screen; paths have their times."""
    return {
        name: short(MOTIONS[name][1] * values if name in MOTIONS else values)
        for name, values in columns.items()
    }
