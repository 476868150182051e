"""A model beside free-running records: track and histories, forces through the smoother."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from pmmkit.plotting import style
from pmmkit.validation.free_running import FORCE_UNITS, FreeRun
from pmmkit.validation.uncertainty import COVERAGE

if TYPE_CHECKING:
    from matplotlib.figure import Figure

MEASURED, SIMULATED = style.ORDERED[0], style.ORDERED[2]


def sailed(run: FreeRun) -> Figure:
    """Track, heading, speed and yaw rate, measured and with the measured rudder simulated.

    Parameters
    ----------
    run : FreeRun
        From `compare`.

    Returns
    -------
    Figure
    """
    m, p = run.measured, run.predicted
    t = run.t - run.t[0]
    histories = (
        ("heading ψ [deg]", np.degrees(m["psi"]), np.degrees(p["psi"])),
        ("speed [m/s]", np.hypot(m["u"], m["v"]), np.hypot(p["u"], p["v"])),
        ("yaw rate r [deg/s]", np.degrees(m["r"]), np.degrees(p["r"])),
    )
    with style.styled():
        figure = style.canvas(6.2)
        left, right = np.asarray(figure.subfigures(1, 2)).tolist()
        track = left.subplots()
        track.plot(m["y"], m["x"], color=MEASURED, label="measured")
        track.plot(p["y"], p["x"], color=SIMULATED, ls="--", label="simulated, measured rudder")
        track.plot(m["y"][:1], m["x"][:1], ls="", marker="o", color=style.INK, label="start")
        track.set_aspect("equal", adjustable="datalim")
        track.set_xlabel("y, east [m]")
        track.set_ylabel("x, north [m]")
        track.set_title(f"{run.run.kind_of_test.title} {run.name}")
        axes = right.subplots(4, 1, sharex=True)
        for axis, (what, measured, simulated) in zip(axes[:3], histories, strict=True):
            axis.plot(t, measured, color=MEASURED)
            axis.plot(t, simulated, color=SIMULATED, ls="--")
            axis.set_ylabel(what)
        axes[3].plot(t, np.degrees(run.delta), color=style.INK, lw=1.0)
        axes[3].set_ylabel("rudder δ [deg]")
        axes[3].set_xlabel("time [s]")
        left.legend(*track.get_legend_handles_labels(), loc="outside lower center", ncols=2)
    return figure


def force_residuals(run: FreeRun) -> Figure:
    """Forces that the measured motion implies and those of the model, in time.

    Parameters
    ----------
    run : FreeRun
        From `compare`.

    Returns
    -------
    Figure
        The band is the expanded uncertainty of what the motion implies.
    """
    t = run.t - run.t[0]
    with style.styled():
        figure = style.canvas(1.75 * len(run.force) + 0.9)
        axes = figure.subplots(len(run.force), 2, squeeze=False, sharex=True)
        style.in_powers(axes.flat)
        for (left, right), (channel, force) in zip(axes, run.force.items(), strict=True):
            half = COVERAGE * run.force_std[channel]
            predicted = run.force_predicted[channel]
            left.fill_between(t, force - half, force + half, color=MEASURED, alpha=0.18, lw=0)
            left.plot(t, force, color=MEASURED, lw=1.0, label="from the measured motion")
            left.plot(t, predicted, color=SIMULATED, ls="--", label="model on that motion")
            left.set_ylabel(f"{channel} [{FORCE_UNITS[channel]}]")
            right.fill_between(
                t, -half, half, color=MEASURED, alpha=0.18, lw=0, label="expanded uncertainty"
            )
            right.plot(
                t, predicted - force, color=style.LIMIT, lw=1.0, label="predicted less measured"
            )
        axes[0, 0].set_title(f"{run.run.kind_of_test.title} {run.name}")
        axes[0, 1].set_title("what is left")
        for axis in axes[-1]:
            axis.set_xlabel("time [s]")
        style.legend_below(figure, list(axes.ravel()))
    return figure
