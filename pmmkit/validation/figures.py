"""A model beside tests: the map of misfit, and a record with its simulation."""

from __future__ import annotations

import itertools
from collections.abc import Mapping, Sequence
from typing import Final

import numpy as np

from pmmkit.campaigns import TEST_KINDS
from pmmkit.numerics import Array
from pmmkit.plotting import INK, Axes, Figure, Shades, colour
from pmmkit.presentation import figure_text
from pmmkit.validation.misfit import MisfitCell, order_words

MEASURED, SIMULATED = colour(0), colour(2)
SHADES: Final = Shades(
    levels=(0.0, 0.5, 1.0, 2.0, 4.0, 8.0, 16.0, 1e9),
    colours=("#f4f4f4", "#e2e6ea", "#fbe3bd", "#f5b971", "#e3871c", "#c0501f", "#8f1f1f"),
)
"""Steps of the colours, in units of the expanded uncertainty."""
ENDINGS: Final = {1: "st", 2: "nd", 3: "rd"}


def misfit_map(cells: Sequence[MisfitCell]) -> Figure:
    """The map of misfit: a panel a channel, test types down, harmonics and speeds across."""
    channels = list(dict.fromkeys(cell.channel for cell in cells))
    rows = {
        channel: list(dict.fromkeys(cell.test for cell in cells if cell.channel == channel))
        for channel in channels
    }
    columns = sorted({_column(cell) for cell in cells})
    heights = [len(tests) for tests in rows.values()]
    figure = Figure(height=1.3 + 0.3 * len(channels) + 0.27 * sum(heights))
    grid = figure.subplots(len(channels), 1, squeeze=False, sharex=True, height_ratios=heights)
    axes = grid[:, 0]
    for axis, (channel, tests) in zip(axes, rows.items(), strict=True):
        values = np.full((len(tests), len(columns)), np.nan)
        for cell in cells:
            if cell.channel == channel:
                place = tests.index(cell.test), columns.index(_column(cell))
                values[place] = np.fmax(values[place], cell.ratio)
        shown = axis.mosaic(values, SHADES, gap=1.2)
        _write_numbers(axis, values)
        axis.set_xlim(0.0, len(columns))
        axis.set_ylim(len(tests), 0.0)
        axis.without_frame()
        axis.set_yticks(np.arange(len(tests)) + 0.5, [TEST_KINDS[test].title for test in tests])
        axis.set_ylabel(channel, level=True, fontsize=13, bold=True)
    _name_harmonics(axes[0], [harmonic for harmonic, _ in columns])
    for axis in axes:
        _part_harmonics(axis, [harmonic for harmonic, _ in columns])
    axes[-1].set_xticks(
        np.arange(len(columns)) + 0.5,
        [f"{speed:.3g}" for _, speed in columns],
        rotation=90 if len(columns) > 18 else 0,
    )
    axes[-1].set_xlabel("speed [m/s]")
    figure.colour_key(shown, "error over expanded uncertainty [-]")
    return figure


def _column(cell: MisfitCell) -> tuple[int, float]:
    """Harmonic and speed to three digits."""
    return cell.harmonic, float(f"{cell.speed:.3g}")


def _write_numbers(axis: Axes, values: Array) -> None:
    size = 7.5 if values.shape[1] <= 20 else 6.0
    for row, column in np.argwhere(np.isfinite(values)).tolist():
        value = float(values[row, column])
        axis.text(
            column + 0.5,
            row + 0.5,
            f"{value:.0f}" if value >= 9.95 else f"{value:.1f}",
            ha="center",
            va="center",
            fontsize=size,
            color="white" if value >= 8.0 else INK if value >= 1.0 else "#8a8a8a",
        )


def _name_harmonics(axis: Axes, harmonics: Sequence[int]) -> None:
    for harmonic in dict.fromkeys(harmonics):
        at = [place for place, other in enumerate(harmonics) if other == harmonic]
        words = order_words(harmonic)
        told = words if len(at) > 4 else words.split()[0]
        if len(at) < 2 < len(harmonics):
            told = f"{harmonic}{ENDINGS.get(harmonic, 'th')}" if harmonic else told
        axis.text(float(np.mean(at)) + 0.5, -0.25, told, ha="center", va="bottom", fontsize=9)
    axis.text(-0.2, -0.25, "harmonic", ha="right", va="bottom", fontsize=9)


def _part_harmonics(axis: Axes, harmonics: Sequence[int]) -> None:
    for place, (one, other) in enumerate(itertools.pairwise(harmonics), start=1):
        if one != other:
            axis.axvline(place, color="white", lw=4.0)


def sailed(
    title: str,
    t: Array,
    measured: Mapping[str, Array],
    predicted: Mapping[str, Array],
    delta: Array,
) -> Figure:
    """Track, heading, speed and yaw rate, measured and with the measured rudder simulated.

    t [s].
    """
    m, p, t = measured, predicted, t - t[0]
    histories = (
        ("heading ψ [deg]", np.degrees(m["psi"]), np.degrees(p["psi"])),
        ("speed [m/s]", np.hypot(m["u"], m["v"]), np.hypot(p["u"], p["v"])),
        ("yaw rate r [deg/s]", np.degrees(m["r"]), np.degrees(p["r"])),
    )
    figure = Figure(height=6.2)
    grid = figure.subplots(4, 2, sharex="col")
    track, axes = grid[0, 0], grid[:, 1]
    track.rows = (0, 3)
    for own in grid[1:, 0]:
        own.remove()
    track.plot(m["y"], m["x"], color=MEASURED, label="measured")
    track.plot(p["y"], p["x"], color=SIMULATED, ls="--", label="simulated, measured rudder")
    track.plot(m["y"][:1], m["x"][:1], ls="", marker="o", color=INK, label="start")
    track.set_aspect_equal()
    track.label_below("y, east [m]")
    track.set_ylabel("x, north [m]")
    track.set_title(figure_text(title))
    for axis, (what, own, simulated) in zip(axes[:3], histories, strict=True):
        axis.plot(t, own, color=MEASURED)
        axis.plot(t, simulated, color=SIMULATED, ls="--")
        axis.set_ylabel(what)
    axes[3].plot(t, np.degrees(delta), color=INK, lw=1.0)
    axes[3].set_ylabel("rudder δ [deg]")
    axes[3].set_xlabel("time [s]")
    figure.legend_below([track], columns=3)
    return figure
