"""Diagnosis: evidence of every effect, what the runs could show, how the error falls."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Final

import numpy as np

from pmmkit.channels import CHANNEL_UNITS
from pmmkit.effects.catalogue import is_fault
from pmmkit.errors import DataError
from pmmkit.plotting import style

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from pmmkit.diagnosis.findings import Diagnosis
    from pmmkit.loop.session import ErrorFall

_MOST: Final = 14
"""Effects in the figure of evidence."""
_CERTAIN: Final = math.log(1000.0)
_KINDS: Final = {False: ("ship and water", style.ORDERED[0]), True: ("measurement", "#e3871c")}


def evidence(found: Diagnosis) -> Figure:
    """ln evidence of the best single effects and sets, the named group marked.

    Parameters
    ----------
    found : Diagnosis
        As `diagnose` gives it.

    Returns
    -------
    Figure
    """
    named = [names for names, _ in found.group]
    singles = [item for item in found.entries if len(item.names) == 1][:_MOST]
    sets = [item for item in found.entries if len(item.names) > 1 and item.names in named]
    shown = sorted([*sets, *singles], key=lambda item: -item.log_evidence)[:_MOST]
    with style.styled():
        figure = style.canvas(1.0 + 0.3 * len(shown))
        axis = figure.subplots()
        for place, item in enumerate(shown):
            label, colour = _KINDS[all(is_fault(name) for name in item.names)]
            axis.barh(
                place,
                item.log_evidence,
                height=0.62,
                color=colour,
                alpha=1.0 if item.names in named else 0.35,
            )
            axis.barh(place, 0.0, color=colour, label=label)
        axis.axvline(0.0, color=style.INK, lw=0.8)
        axis.axvline(_CERTAIN, color=style.LIMIT, lw=1.0, ls="--", label="1000 to 1")
        axis.set_yticks(range(len(shown)), [_words(item.names) for item in shown])
        axis.set_ylim(len(shown) - 0.4, -0.6)
        axis.set_xscale("symlog", linthresh=10.0)
        axis.grid(visible=False, axis="y")
        axis.set_xlabel("ln evidence against no effect [-]   (full colour: named)")
        style.legend_below(figure, [axis])
    return figure


def coverage(found: Diagnosis) -> Figure:
    """Share of its usual size that each effect could have and hide from these runs.

    Parameters
    ----------
    found : Diagnosis
        As `diagnose` gives it.

    Returns
    -------
    Figure
    """
    items = sorted(found.covered, key=lambda item: item.hides)
    sizes = [min(item.hides, _LARGEST) for item in items]
    with style.styled():
        figure = style.canvas(1.0 + 0.22 * len(items))
        axis = figure.subplots()
        for place, (item, size) in enumerate(zip(items, sizes, strict=True)):
            colour = style.ORDERED[1] if item.shown else style.REFERENCE
            axis.barh(
                place,
                size,
                height=0.62,
                color=colour,
                label="these runs can show it" if item.shown else "they cannot",
            )
        axis.axvline(1.0, color=style.INK, lw=0.8)
        axis.set_yticks(range(len(items)), [_words((item.name,)) for item in items])
        axis.set_ylim(len(items) - 0.4, -0.6)
        axis.set_xscale("log")
        axis.grid(visible=False, axis="y")
        axis.set_xlabel("size that could hide, over the usual size [-]")
        style.legend_below(figure, [axis])
    return figure


_LARGEST: Final = 30.0


def error_fall(fall: ErrorFall) -> Figure:
    """Held-out error after each step: by channel, and by test type.

    Parameters
    ----------
    fall : ErrorFall
        As `Session.fall` gives it.

    Returns
    -------
    Figure

    Raises
    ------
    DataError
        If there is no step.
    """
    if not fall.errors:
        raise DataError("There is no step to draw.")
    tests = list(dict.fromkeys(fall.errors[0].tests))
    channels = fall.errors[0].channels
    by_channel = [item.of_channel() for item in fall.errors]
    force = fall.errors[0].of_channel(kind="force")
    with style.styled():
        figure = style.canvas(4.2)
        left, right = figure.subplots(1, 2, sharey=True, width_ratios=(1.0, 1.4))
        _bars(
            left,
            fall.steps,
            [[100 * own[x] / force[x] for x in channels] for own in by_channel],
            [f"{x}\n{_in_newtons([own[x] for own in by_channel], x)}" for x in channels],
        )
        left.set_ylabel("error of left-out conditions,\n% of the channel's rms force")
        _bars(
            right,
            fall.steps,
            [[100 * item.share(test) for test in tests] for item in fall.errors],
            [test.replace("_", "\n") for test in tests],
        )
        left.set_title("by channel")
        right.set_title("by test type, root mean square of the channels")
        style.legend_below(figure, [left])
    return figure


def _bars(axis: Axes, steps: tuple[str, ...], values: list[list[float]], places: list[str]) -> None:
    width = 0.8 / len(steps)
    for number, (step, heights) in enumerate(zip(steps, values, strict=True)):
        at = np.arange(len(places)) + (number - 0.5 * (len(steps) - 1)) * width
        label = _words((step,)) if number == 0 else f"+ {_words((step,))}"
        axis.bar(at, heights, width=0.92 * width, color=style.colour(number), label=label)
    axis.set_xticks(range(len(places)), places)
    axis.grid(visible=False, axis="x")


def _in_newtons(errors: list[float], channel: str) -> str:
    """The fall of a channel in its unit."""
    unit = CHANNEL_UNITS[channel]
    ends = [errors[0], *errors[-1:]] if len(errors) > 1 else errors
    return f"{' → '.join(f'{x:.3g}' for x in ends)} {unit}"


def _words(names: tuple[str, ...]) -> str:
    return ",\n".join(name.replace("_", " ") for name in names)
