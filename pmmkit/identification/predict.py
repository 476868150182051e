"""How well a model predicts records it has not seen: windows with the measured rudder."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np

from pmmkit.equations.code_generation import ESTIMATING
from pmmkit.equations.compilation import compiled
from pmmkit.equations.layouts import Constant, State
from pmmkit.errors import DataError
from pmmkit.identification.binding import bound, driven
from pmmkit.identification.filters import STEP
from pmmkit.identification.record import FreeRecord
from pmmkit.identification.smoother import Smoothed, smooth
from pmmkit.models import Model
from pmmkit.numerics import Array

if TYPE_CHECKING:
    import pandas as pd

STARTS: Final = 4
"""Windows begin at so many places in each length of a window."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Prediction:
    """Errors of a model over windows of records.

    Parameters
    ----------
    window : float
        Length of the windows [s].
    errors : mapping of str to Mapping of str to float
        By record: root mean square over all instants of all windows of ``position`` [m],
        ``position_end`` [m] at the end of a window, ``heading`` [deg], ``speed`` [m/s],
        ``yaw_rate`` [deg/s], and the number of ``windows``.
    """

    window: float
    errors: Mapping[str, Mapping[str, float]]

    def pooled(self) -> dict[str, float]:
        """Root mean square over all windows of all records."""
        weights = np.array([item["windows"] for item in self.errors.values()])
        names = [name for name in next(iter(self.errors.values())) if name != "windows"]
        found = {
            name: float(
                np.sqrt(
                    np.average([item[name] ** 2 for item in self.errors.values()], weights=weights)
                )
            )
            for name in names
        }
        return found | {"windows": float(weights.sum())}

    def to_pandas(self) -> pd.DataFrame:
        """A row per record, the last one pooled."""
        import pandas as pd

        rows = {**self.errors, "all": self.pooled()}
        return pd.DataFrame.from_dict(rows, orient="index")


def reference(
    model: Model,
    records: Sequence[FreeRecord],
    *,
    sensors: Mapping[str, float] | None = None,
    extrapolate: bool = False,
) -> tuple[Smoothed, ...]:
    """Smoothed records that predictions start from and are compared with, one for all models.

    Parameters
    ----------
    model : Model
        Any model of the ship: unknown forces are given room enough (0.1 of ½ρLdU²) that the
        smoothed motion is that of the sensors.
    records : sequence of FreeRecord
        Records that were held out.
    sensors : mapping of str to float, optional
        As for `smooth`.
    extrapolate : bool
        Allow a speed outside the range of the model's values.

    Returns
    -------
    tuple of Smoothed
    """
    return tuple(
        smooth(model, record, sensors=sensors, size=0.1, extrapolate=extrapolate)
        for record in records
    )


def predict(
    model: Model,
    references: Sequence[Smoothed],
    *,
    window: float = 60.0,
    current: tuple[float, float] = (0.0, 0.0),
    extrapolate: bool = False,
) -> Prediction:
    """Simulate windows from the smoothed motion with the measured rudder and revolutions.

    Parameters
    ----------
    model : Model
        To be judged.
    references : sequence of Smoothed
        From `reference`; the same for all models that are compared.
    window : float
        Length of the windows [s]; they begin four times in each such length.
    current : (float, float)
        Uniform current to north and east [m/s], as in `Identified.current`.
    extrapolate : bool
        Allow a speed outside the range of the model's values.

    Returns
    -------
    Prediction

    Raises
    ------
    DataError
        If no record is as long as a window.
    """
    ready = driven(model)
    errors = {}
    for item in references:
        record = item.record
        binding = bound(
            ready, (), record.speed, conditions=record.conditions, extrapolate=extrapolate
        )
        functions = compiled(binding.structure, ESTIMATING)
        k = binding.base.copy()
        k[Constant.current_x], k[Constant.current_y] = current
        functions.complete(k)
        states = binding.structure.states
        truth = np.stack([item.motion[name] for name in states], axis=1)
        t = record.t - record.t[0]
        begins = np.arange(0.0, t[-1] - window + 1e-9, window / STARTS)
        squares = []
        for begin in begins:
            at = np.flatnonzero((t >= begin - 1e-9) & (t <= begin + window + 1e-9))
            if len(at) < 3:
                continue
            out = np.empty((len(at), len(states)))
            functions.windows(
                record.t[at],
                record.inputs[at],
                np.array([0, len(at)]),
                truth[at[:1]].copy(),
                k,
                STEP * ready.ship.L / record.speed,
                out,
            )
            squares.append(_squares(out, truth[at]))
        if squares:
            mean = np.sqrt(np.mean(squares, axis=0))
            errors[item.name] = dict(zip(NAMES, mean.tolist(), strict=True)) | {
                "windows": float(len(squares))
            }
    if not errors:
        raise DataError(f"No record is as long as a window of {window:g} s.")
    return Prediction(window=window, errors=errors)


POSITION: Final = [State.x, State.y]
NAMES: Final = ("position", "position_end", "heading", "speed", "yaw_rate")


@np.errstate(over="ignore")
def _squares(out: Array, truth: Array) -> list[float]:
    """Mean squares of the errors of one window, in the order of `NAMES`; infinite of a motion that
    grows without bound."""
    away = np.sum((out[:, POSITION] - truth[:, POSITION]) ** 2, axis=1)
    speed = np.hypot(out[:, State.u], out[:, State.v]) - np.hypot(
        truth[:, State.u], truth[:, State.v]
    )
    return [
        float(np.mean(away)),
        float(away[-1]),
        float(np.mean(np.degrees(out[:, State.psi] - truth[:, State.psi]) ** 2)),
        float(np.mean(speed**2)),
        float(np.mean(np.degrees(out[:, State.r] - truth[:, State.r]) ** 2)),
    ]
