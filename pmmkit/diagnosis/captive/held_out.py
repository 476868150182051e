"""How well a model predicts conditions that its fit had not seen."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final, Literal

import numpy as np

from pmmkit.campaigns.run import Run
from pmmkit.diagnosis.captive.least_squares import Stack, solved, stacked
from pmmkit.diagnosis.captive.system import Block, System
from pmmkit.numerics import Array
from pmmkit.observations.channels import Places
from pmmkit.observations.views import View

if TYPE_CHECKING:
    import pandas as pd

ALONE: Final = 1e-6
"""A condition whose rows have less than this to do with all others cannot be predicted."""
CHANGED: Final = 0.02
"""Share by which an error must change to count as changed."""


@dataclass(frozen=True, kw_only=True, eq=False)
class HeldOut:
    """Errors of predictions of conditions that a fit had not seen.

    Parameters
    ----------
    conditions : tuple of str
        What was left out, one after another: runs of one setting together.
    tests : tuple of str
        Test type of each.
    channels : tuple of str
        Columns of the arrays.
    error, force : array (conditions, channels)
        Root mean square of the error and of the measured force over a cycle [N, N m]; NaN where a
        condition has no such channel or the other conditions do not determine it.
    """

    conditions: tuple[str, ...]
    tests: tuple[str, ...]
    channels: tuple[str, ...]
    error: Array
    force: Array

    def of_channel(
        self, test: str | None = None, *, kind: Literal["error", "force"] = "error"
    ) -> dict[str, float]:
        """Root mean square of error or force by channel [N, N m], of one test type or of all."""
        at = [i for i, name in enumerate(self.tests) if test in (None, name)]
        values = self.error if kind == "error" else self.force
        return dict(zip(self.channels, _rms(values[at]).tolist(), strict=True))

    def share(self, test: str | None = None) -> float:
        """Errors of one test type or of all over the channels' rms forces, over the channels."""
        at = [i for i, name in enumerate(self.tests) if test in (None, name)]
        return float(_rms((_rms(self.error[at]) / _rms(self.force))[:, None])[0])

    def better_than(self, other: HeldOut) -> float:
        """Share of conditions and channels with a smaller error, of those that change at all."""
        known = np.isfinite(self.error) & np.isfinite(other.error)
        new, old = self.error[known], other.error[known]
        changed = np.abs(new - old) > CHANGED * old
        return float(np.mean(new[changed] < old[changed])) if changed.any() else 0.0

    def to_pandas(self) -> pd.DataFrame:
        """A row per condition and channel: condition, test, channel, error, force."""
        import pandas as pd

        return pd.DataFrame(
            [
                {
                    "condition": name,
                    "test": test,
                    "channel": channel,
                    "error": self.error[i, j],
                    "force": self.force[i, j],
                }
                for i, (name, test) in enumerate(zip(self.conditions, self.tests, strict=True))
                for j, channel in enumerate(self.channels)
            ]
        )


def _rms(values: Array) -> Array:
    """Root mean square down the columns, over what is known; NaN where nothing is."""
    known = np.isfinite(values)
    count = known.sum(axis=0)
    total = np.where(known, values, 0.0) ** 2
    with np.errstate(invalid="ignore"):
        found: Array = np.sqrt(total.sum(axis=0) / np.where(count > 0, count, np.nan))
    return found


def held_out(system: System, effects: Sequence[Block] = ()) -> HeldOut:
    """Errors of base and effects on each condition, fitted to all other conditions.

    Parameters
    ----------
    system : System
        Runs with the estimated scatter.
    effects : sequence of Block
        Effects at a value of their nonlinear parameter.

    Returns
    -------
    HeldOut
        Runs of one setting are left out together: repeats know each other.

    Notes
    -----
    Weighted least squares without the smooth floor. With the rows of a condition k, e their
    residuals and H the hat matrix, the residuals of a fit without them are (I - H_kk)⁻¹ e; one
    decomposition serves all.
    """
    stack = stacked(system, effects)
    found = solved(stack)
    residual = stack.white[:, -1] - stack.white[:, :-1] @ found.solution
    groups = _groups(system, stack)
    channels = tuple(stack.places)
    shape = (len(groups), len(channels))
    error, force = np.full(shape, np.nan), np.full(shape, np.nan)
    for number, own in enumerate(groups.values()):
        rows = np.concatenate([at for _, _, at in own])
        Q = found.Q[rows]
        inner = np.eye(len(rows)) - Q @ Q.T
        if np.linalg.eigvalsh(inner)[0] < ALONE:
            continue
        change = np.linalg.solve(found.R, Q.T @ np.linalg.solve(inner, residual[rows])) / found.size
        solution = found.solution - change
        for place, channel in enumerate(channels):
            mine = [(view, at) for name, view, at in own if name == channel and not view.early]
            if mine:
                left = [
                    _mean_square(stack.plain[at, -1] - stack.plain[at, :-1] @ solution)
                    for _, at in mine
                ]
                error[number, place] = np.sqrt(np.mean(left))
                force[number, place] = np.sqrt(
                    np.mean([_mean_square(stack.plain[at, -1]) for _, at in mine])
                )
    return HeldOut(
        conditions=tuple(groups),
        channels=channels,
        error=error,
        force=force,
        tests=tuple(own[0][1].run.test for own in groups.values()),
    )


def _mean_square(harmonics: Array) -> float:
    """Mean square over a cycle of a history with these harmonics."""
    return float(harmonics[0] ** 2 + 0.5 * np.sum(harmonics[1:] ** 2))


def _groups(system: System, stack: Stack) -> dict[str, list[tuple[str, View, Places]]]:
    """Channel, view and rows by condition."""
    found: dict[str, list[tuple[str, View, Places]]] = {}
    for c in system.channels:
        for i, rows in zip(c.views, c.rows, strict=True):
            view = system.views[i]
            begin = stack.places[c.name].start
            at = np.arange(begin + rows.start, begin + rows.stop)
            found.setdefault(condition(view.run), []).append((c.name, view, at))
    return found


def condition(run: Run) -> str:
    """The setting of a run in words: runs with one setting repeat each other.

    Parameters
    ----------
    run : Run
        A captive run.
    """
    s = run.settings
    parts = [run.test.replace("_", " "), f"{s.speed:.3g} m/s"]
    for name, value, unit in (
        ("drift", np.degrees(s.drift), "°"),
        ("heel", np.degrees(s.heel), "°"),
        ("rudder", np.degrees(s.rudder), "°"),
        ("yaw", np.degrees(s.yaw_amplitude or 0.0), "°"),
        ("sway", s.amplitude or 0.0, " m"),
        ("period", s.period or 0.0, " s"),
        ("yaw rate", np.degrees(s.yaw_rate or 0.0), "°/s"),
        ("propeller", s.propeller_rps or 0.0, "/s"),
    ):
        if value:
            parts.append(f"{name} {value:.3g}{unit}")
    return ", ".join(parts)
