"""Records of motions in waves beside what was computed, as a command takes and writes them."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import partial
from glob import glob
from typing import TYPE_CHECKING, Any

from pmmkit.actions.setting import setting, settings

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from pmmkit.seakeeping import Explained, MeasuredTransfer, Rao, RaoComparison


@settings
class MotionRecordSettings:
    """Records of motions in waves."""

    record: tuple[str, ...] = setting(
        "Records of motions in waves, such as 'runs/*.csv', beside the computed ones: "
        "columns t, wave, heave, pitch …, such as 'heave [mm]'; may be repeated.",
        default=(),
    )
    record_scale: float = setting(
        "Of a model in the records: 50 for one of 1:50.", default=1.0, least=1e-3
    )


@dataclass(frozen=True, kw_only=True)
class RecordsBeside:
    """Records beside the computed motions.

    `kinds`: regular or irregular waves, by file. `cause`: what would explain the difference.
    """

    kinds: Mapping[str, str]
    motions: tuple[RaoComparison, ...]
    cause: Explained

    @property
    def told(self) -> tuple[RaoComparison | Explained, ...]:
        """What tells its own state, in the order in which it is printed."""
        return (*self.motions, self.cause)

    @property
    def lines(self) -> list[str]:
        """What is printed."""
        read = [f"{name}: {kind} waves" for name, kind in self.kinds.items()]
        told = [text for item in self.told for text in ("", str(item))]
        return ["", "Records", *(f"  {text}" for text in read), *told]

    def content(self) -> dict[str, Any]:
        """What ``--json`` says of it."""
        best = self.cause.best
        return {
            "kinds": dict(self.kinds),
            "misfit": self.cause.misfit,
            "explained": None
            if best is None
            else {"name": best.name, "given": best.before, "best": best.after},
        }

    def files(self, *, figures: bool) -> Iterator[tuple[str, Any]]:
        """The files that are written."""
        import pandas as pd

        from pmmkit.plotting import save

        tables = [item.to_pandas() for item in self.motions]
        yield "measured.csv", pd.concat(tables, ignore_index=True)
        if figures:
            yield "measured.svg", partial(save, self.plot())

    def plot(self) -> Figure:
        """Measured points beside computed curves."""
        from pmmkit.seakeeping import beside_measured

        return beside_measured(
            {
                f"{item.mode} / ζ": (item.encounter, item.measured, item.std, item.computed)
                for item in self.motions
            }
        )


Transfers = Mapping[str, tuple[str, Mapping[str, "MeasuredTransfer"]]]
"""Of each file the kind of waves, and transfer functions by motion."""


def read_records(asked: MotionRecordSettings) -> Transfers:
    """Transfer functions of records from files and patterns."""
    if not asked.record:
        return {}
    from pmmkit.seakeeping import read_record

    names = [name for text in asked.record for name in sorted(glob(text)) or [text]]
    return {name: read_record(name, scale=asked.record_scale).transfer() for name in names}


def beside_records(read: Transfers, found: Rao) -> RecordsBeside:
    """Records beside the motions of one speed and heading."""
    from pmmkit.seakeeping import beside, explained, together

    measured = together([transfer for _, transfer in read.values()])
    return RecordsBeside(
        kinds={name: kind for name, (kind, _) in read.items()},
        motions=tuple(beside(one, found, mode) for mode, one in measured.items()),
        cause=explained(measured, found),
    )
