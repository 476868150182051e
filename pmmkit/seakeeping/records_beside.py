"""Records of motions in waves beside what was computed."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from glob import glob
from typing import TYPE_CHECKING, Any

from pmmkit.seakeeping.explanation import Explained, explained
from pmmkit.seakeeping.figures import beside_measured
from pmmkit.seakeeping.measured import MeasuredTransfer, RaoComparison, beside
from pmmkit.seakeeping.records import read_record, together
from pmmkit.seakeeping.transfer import Rao

if TYPE_CHECKING:
    from matplotlib.figure import Figure


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
        return beside_measured(
            {
                f"{item.mode} / ζ": (item.encounter, item.measured, item.std, item.computed)
                for item in self.motions
            }
        )


Transfers = Mapping[str, tuple[str, Mapping[str, MeasuredTransfer]]]
"""Of each file the kind of waves, and transfer functions by motion."""


def read_records(given: Sequence[str], scale: float) -> Transfers:
    """Transfer functions of records from files and patterns, by file, with the kind of waves.

    Parameters
    ----------
    given : sequence of str
        Files, or patterns such as ``runs/*.csv``.
    scale : float
        Of a model in the records: 50 for one of 1:50.

    Returns
    -------
    dict of str to (str, dict of str to MeasuredTransfer)
    """
    names = [name for text in given for name in sorted(glob(text)) or [text]]
    return {name: read_record(name, scale=scale).transfer() for name in names}


def beside_records(read: Transfers, found: Rao) -> RecordsBeside:
    """Records beside the motions of one speed and heading, and what would explain the difference.

    Parameters
    ----------
    read : mapping
        From `read_records`.
    found : Rao
        The computed motions.

    Returns
    -------
    RecordsBeside
    """
    measured = together([transfer for _, transfer in read.values()])
    return RecordsBeside(
        kinds={name: kind for name, (kind, _) in read.items()},
        motions=tuple(beside(one, found, mode) for mode, one in measured.items()),
        cause=explained(measured, found),
    )
