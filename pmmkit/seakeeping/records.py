"""Records of motions in waves: from a file to transfer functions."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from glob import glob
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, Final, Literal

import numpy as np

from pmmkit.base import DataError, Problem
from pmmkit.conventions import split_unit, unit_factor
from pmmkit.numerics import Array
from pmmkit.readers import Request, reader_for
from pmmkit.seakeeping.explanation import Explained, explained
from pmmkit.seakeeping.figures import beside_measured
from pmmkit.seakeeping.measured import (
    MeasuredTransfer,
    RaoComparison,
    beside,
    from_irregular,
    from_regular,
)
from pmmkit.seakeeping.transfer import MODES, Rao
from pmmkit.signals import design_matrix

if TYPE_CHECKING:
    from pmmkit.plotting import Figure


WAVE: Final = "wave"
UNITS: Final[Mapping[str, str]] = MappingProxyType(
    {"t": "s", WAVE: "m", **dict.fromkeys(MODES[:3], "m"), **dict.fromkeys(MODES[3:], "rad")}
)
"""Columns of a record, and their units where a header states none."""
_REGULAR: Final = 0.8
_ORDER: Final = 3


@dataclass(frozen=True, kw_only=True, eq=False)
class MotionRecord:
    """Motions of a ship in waves over time, with a probe of the waves that moves with it.

    `t, wave`: time [s], elevation at the probe [m]. `motions`: some of surge, sway, heave [m],
    roll, pitch, yaw [rad].
    """

    name: str
    t: Array
    wave: Array
    motions: Mapping[str, Array]

    @property
    def regular(self) -> tuple[float, bool]:
        """Frequency of the largest wave [rad/s], and whether it and its harmonics are all."""
        even = np.linspace(self.t[0], self.t[-1], self.t.size)
        wave = np.interp(even, self.t, self.wave) - np.mean(self.wave)
        padded = 8 * wave.size
        size = np.abs(np.fft.rfft(wave * np.hanning(wave.size), padded))
        size[0] = 0.0
        omega = 2 * math.pi * int(size.argmax()) / (padded * (even[1] - even[0]))
        terms = design_matrix(omega * even, _ORDER)
        rest = wave - terms @ np.linalg.lstsq(terms, wave, rcond=None)[0]
        return omega, bool(np.var(rest) < (1 - _REGULAR) * np.var(wave))

    def transfer(self) -> tuple[Literal["regular", "irregular"], dict[str, MeasuredTransfer]]:
        """The transfer function of each motion, and as what kind of waves the record was taken."""
        omega, regular = self.regular
        if regular:
            return "regular", {
                name: from_regular(self.t, self.wave, values, encounter=omega)
                for name, values in self.motions.items()
            }
        return "irregular", {
            name: from_irregular(self.t, self.wave, values) for name, values in self.motions.items()
        }


def read_record(path: str | Path, *, scale: float = 1.0) -> MotionRecord:
    """A record of motions from a file of columns."""
    file = Path(path)
    request = Request(path=file, shown=file.name)
    picked: list[tuple[str, float]] = []

    def choose(headers: Sequence[str], _: int) -> list[int]:
        places = []
        for place, header in enumerate(headers):
            name, unit = split_unit(header)
            if name.lower() in UNITS:
                own = UNITS[name.lower()]
                kind, factor = unit_factor(own if unit is None else unit)
                if kind != own:
                    raise _wrong(file, f"{header}: {name} is in {own}, or what leads to it.")
                picked.append((name.lower(), factor))
                places.append(place)
        names = [name for name, _ in picked]
        twice = sorted({name for name in names if names.count(name) > 1})
        lost = [name for name in ("t", WAVE) if name not in names]
        if twice:
            raise _wrong(file, f"{', '.join(twice)} stands in more than one column.")
        if lost or len(names) < 3:
            absent = ", ".join(lost) or "any motion"
            raise _wrong(
                file,
                f"has no column {absent}; there are {', '.join(filter(None, headers)) or 'none'}.",
                f"Name the columns t, {WAVE} and some of {', '.join(MODES)}, such as heave [mm].",
            )
        return places

    read = reader_for(request).columns(request, choose)
    grown = {"s": math.sqrt(scale), "m": scale, "rad": 1.0}
    values = {
        name: numbers * factor * grown[UNITS[name]]
        for (name, factor), numbers in zip(picked, read.values, strict=True)
    }
    if values["t"].size < 2 or (np.diff(values["t"]) <= 0.0).any():
        raise _wrong(file, "Time must rise from row to row.")
    motions: dict[str, Array] = {
        name: values[name] - np.mean(values[name]) for name in MODES if name in values
    }
    return MotionRecord(
        name=file.name, t=values["t"], wave=values[WAVE], motions=MappingProxyType(motions)
    )


def together(records: Sequence[Mapping[str, MeasuredTransfer]]) -> dict[str, MeasuredTransfer]:
    """Transfer functions of several records as one for each motion, in rising frequency."""
    found = {}
    for name in MODES:
        parts = [record[name] for record in records if name in record]
        if not parts:
            continue
        encounter = np.concatenate([part.encounter for part in parts])
        order = np.argsort(encounter, kind="stable")
        found[name] = MeasuredTransfer(
            encounter=encounter[order],
            transfer=np.concatenate([part.transfer for part in parts])[order],
            std=np.concatenate([part.std for part in parts])[order],
        )
    return found


def _wrong(file: Path, message: str, remedy: str | None = None) -> DataError:
    return DataError(Problem(message=message, file=file.name, remedy=remedy))


# Records of motions in waves beside what was computed.


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

        tables = [item.to_pandas() for item in self.motions]
        yield "measured.csv", pd.concat(tables, ignore_index=True)
        if figures:
            yield "measured.svg", self.plot().save

    def plot(self) -> Figure:
        """Measured points beside computed curves."""
        return beside_measured(
            {
                f"{item.mode} / ζ": (item.encounter, item.measured, item.std, item.computed)
                for item in self.motions
            }
        )


def beside_records(given: Sequence[str], found: Rao, *, scale: float = 1.0) -> RecordsBeside:
    """Records beside the motions of one speed and heading, and what would explain the difference.

    Parameters
    ----------
    given : sequence of str
        Files, or patterns such as ``runs/*.csv``.
    found : Rao
        The computed motions.
    scale : float
        Of a model in the records: 50 for one of 1:50.

    Returns
    -------
    RecordsBeside
    """
    names = [name for text in given for name in sorted(glob(text)) or [text]]
    read = {name: read_record(name, scale=scale).transfer() for name in names}
    measured = together([transfer for _, transfer in read.values()])
    return RecordsBeside(
        kinds={name: kind for name, (kind, _) in read.items()},
        motions=tuple(beside(one, found, mode) for mode, one in measured.items()),
        cause=explained(measured, found),
    )
