"""A programme of the virtual tank with fewer runs, which still determine every derivative."""

from __future__ import annotations

from collections.abc import Sequence

from scripts.datasets.virtual_tank import programme

LEFT_OUT = ("SD_{}_-8", "SD_{}_4", "PS_{}_0.17", "PY_{}_0.4", "YD_{}_-8_0.5", "YD_{}_4_0.5")


def few(speeds: Sequence[float] = (1.5,)) -> list[tuple]:
    """Thirteen runs at each speed."""
    without = {name.format(speed) for name in LEFT_OUT for speed in speeds}
    return [run for run in programme(speeds) if run[0] not in without]
