"""Comparison error against validation uncertainty, as at SIMMAN, with what may be said of it."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Final

import numpy as np

from pmmkit.plotting.bars import Bar, errors_and_uncertainties
from pmmkit.validation.captive import CaptiveRun
from pmmkit.validation.comparison import Comparison
from pmmkit.validation.uncertainty import rms_of

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_MOST: Final = 40
"""Runs of which each has a bar; of more, each kind of test has one at each speed."""


def errors_beside_uncertainty(comparison: Comparison) -> Figure:
    """The comparison error E of captive tests beside its validation uncertainty U_V.

    Parameters
    ----------
    comparison : Comparison
        Of captive tests.

    Returns
    -------
    Figure
        A panel a channel, both in per cent of the channel's root mean square force over all runs.
        Where there are more than 40 runs a bar is the root mean square of a kind of test at a
        speed. Where E is within U_V nothing can be said of the model: such bars are pale.
    """
    bars = {
        channel: _bars([run for run in comparison.captive if channel in run.channels], channel)
        for channel in dict.fromkeys(x for run in comparison.captive for x in run.channels)
    }
    return errors_and_uncertainties(bars)


def _bars(runs: Sequence[CaptiveRun], channel: str) -> list[Bar]:
    size = _rms([rms_of(run.view.force[channel], run.view.labels) for run in runs])
    groups: dict[str, list[CaptiveRun]] = {}
    for run in runs:
        kind = run.view.run.kind_of_test.title
        name = run.view.run.id if len(runs) <= _MOST else f"{kind}, Fn {run.Fn:.3f}"
        groups.setdefault(name, []).append(run)
    return [
        Bar(
            name=name,
            error=100 * _rms([rms_of(x.error(channel), x.view.labels) for x in own]) / size,
            doubt=100 * _rms([rms_of(x.uncertainty(channel), x.view.labels) for x in own]) / size,
        )
        for name, own in groups.items()
    ]


def _rms(values: Sequence[float]) -> float:
    return float(np.sqrt(np.mean(np.square(values))))
