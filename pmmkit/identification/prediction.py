"""How well a model predicts records it has not seen: windows with the measured rudder."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from types import ModuleType
from typing import TYPE_CHECKING, Final

import numpy as np
from numpy.typing import NDArray

from pmmkit.base import DataError
from pmmkit.equations import State
from pmmkit.identification.binding import Binding, driven
from pmmkit.identification.prior import stated_covariance
from pmmkit.identification.record import FreeRecord
from pmmkit.identification.smoother import Smoothed
from pmmkit.inference import Stencil, root
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
    errors : mapping of str to mapping of str to float
        By record: root mean square over all instants of all windows of ``position`` [m],
        ``position_end`` [m] at the end of a window, ``heading`` [deg], ``speed`` [m/s],
        ``yaw_rate`` [deg/s], and the number of ``windows``.
    """

    window: float
    errors: Mapping[str, Mapping[str, float]]

    @classmethod
    def of(
        cls,
        model: Model,
        references: Sequence[Smoothed],
        *,
        window: float = 60.0,
        extrapolate: bool = False,
    ) -> Prediction:
        """Simulate windows from the smoothed motion with the measured rudder and revolutions.

        Parameters
        ----------
        model : Model
            To be judged.
        references : sequence of Smoothed
            From `Smoothed.references`; the same for all models that are compared.
        window : float
            Length of the windows [s]; they begin four times in each such length.
        extrapolate : bool
            Allow a speed outside the range of the model's values.

        Raises
        ------
        DataError
            If no record is as long as a window.
        """
        errors = {}
        for item in references:
            course = Course.of(model, item.record, extrapolate=extrapolate)
            truth = course.states_of(item)
            t = item.record.t - item.record.t[0]
            begins = np.arange(0.0, t[-1] - window + 1e-9, window / STARTS)
            squares = []
            for begin in begins:
                at = np.flatnonzero((t >= begin - 1e-9) & (t <= begin + window + 1e-9))
                if len(at) < 3:
                    continue
                (out,) = course.sail(at, truth[at[:1]])
                squares.append(_squares(out, truth[at]))
            if squares:
                mean = np.sqrt(np.mean(squares, axis=0))
                errors[item.name] = dict(zip(NAMES, mean.tolist(), strict=True)) | {
                    "windows": float(len(squares))
                }
        if not errors:
            raise DataError(f"No record is as long as a window of {window:g} s.")
        return cls(window=window, errors=errors)

    @staticmethod
    @np.errstate(over="ignore", invalid="ignore")
    def std(
        model: Model, item: Smoothed, at: NDArray[np.intp], *, extrapolate: bool = False
    ) -> dict[str, Array]:
        """Standard uncertainty of what a model sails from a measured start.

        Parameters
        ----------
        model : Model
            With the uncertainty of its values, if it states one.
        item : Smoothed
            The record; its covariance says how well the start is known.
        at : array (n,) of int
            Instants; the ship starts from the first.
        extrapolate : bool
            Allow a speed outside the range of the model's values.

        Returns
        -------
        dict of str to array (n,)
            By state [m, rad, m/s, rad/s]: to first order, from ships a standard deviation away to
            either side along each of the principal axes of the start and of the values of the model
            (JCGM 100:2008, 5.1.3, note 2). What the rudder's noise moves is left out: of a tanker
            0.01° of heading in two minutes.
        """
        names, C = _stated(model, item.record, extrapolate)
        course = Course.of(model, item.record, names, extrapolate=extrapolate)
        start = course.states_of(item)[at[0]]
        size = len(start)
        begun = Stencil().points(start, root(item.covariance[at[0]][:size, :size], thin=True).T)
        sailed = [
            course.sail(at, begun),
            *(
                course.sail(at, start[None], x)
                for x in Stencil().points(np.zeros(len(names)), root(C, thin=True).T)
            ),
        ]
        factors = Stencil().differences(np.concatenate(sailed))
        square = np.sum(factors**2, axis=0)
        std = np.sqrt(np.where(np.isnan(square), np.inf, square))
        return dict(zip(course.states, std.T, strict=True))

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


@dataclass(frozen=True, kw_only=True, eq=False)
class Course:
    """What sails along a record with its measured rudder, from states that are given.

    `binding`: constants of the equations over some of the model's values. `longest`: longest
    step of the integration [s].
    """

    record: FreeRecord
    binding: Binding
    functions: ModuleType
    longest: float

    @classmethod
    def of(
        cls, model: Model, record: FreeRecord, names: Sequence[str] = (), *, extrapolate: bool
    ) -> Course:
        """Of a model, whose values of some names may be changed."""
        ready = driven(model)
        binding = Binding.of(
            ready, names, record.speed, conditions=record.conditions, extrapolate=extrapolate
        )
        return cls(
            record=record,
            binding=binding,
            functions=binding.functions,
            longest=Binding.STEP * ready.ship.L / record.speed,
        )

    @property
    def states(self) -> tuple[str, ...]:
        """Names of the states."""
        return self.binding.states

    def states_of(self, item: Smoothed) -> Array:
        """The smoothed states (n, s) at the instants of the record."""
        return np.stack([item.motion[name] for name in self.states], axis=1)

    def sail(self, at: NDArray[np.intp], starts: Array, change: Array | None = None) -> Array:
        """States (w, n, s) at instants from each of w starts; NaN of a ship that cannot be.

        starts (w, s); change (m,).
        """
        out = np.full((len(starts) * len(at), len(self.states)), np.nan)
        moved = 0.0 if change is None else change
        k = self.binding.constants(self.binding.mean + moved)
        if self.functions.complete(k) == 0:
            self.functions.windows(
                np.tile(self.record.t[at], len(starts)),
                np.tile(self.record.inputs[at], (len(starts), 1)),
                np.arange(len(starts) + 1) * len(at),
                np.ascontiguousarray(starts),
                k,
                self.longest,
                out,
            )
        return out.reshape(len(starts), len(at), -1)


def _stated(model: Model, record: FreeRecord, extrapolate: bool) -> tuple[tuple[str, ...], Array]:
    """Values of a model that it is uncertain of and the equations are straight in: covariance."""
    ready = driven(model)
    known = stated_covariance(ready, record.speed, extrapolate=extrapolate)
    names = tuple(a for a, b in known if a == b and _straight(ready, a, record, extrapolate))
    C = np.array([known.get((a, b), 0.0) for a in names for b in names])
    return names, C.reshape(len(names), len(names))


def _straight(model: Model, name: str, record: FreeRecord, extrapolate: bool) -> bool:
    """Whether the equations are straight lines over a value."""
    try:
        Binding.of(
            model, (name,), record.speed, conditions=record.conditions, extrapolate=extrapolate
        )
    except DataError:
        return False
    return True


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
