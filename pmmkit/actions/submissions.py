"""What is compared with tests and is no model: the campaign or the table of somebody else."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from pmmkit.actions.outcome import Outcome, written
from pmmkit.actions.places import figure_files
from pmmkit.actions.setting import SettingError
from pmmkit.base import TableError

if TYPE_CHECKING:
    from pmmkit.campaigns import Campaign
    from pmmkit.models import DerivativeTable


def submitted(what: str, data: Path | None) -> Campaign | DerivativeTable | None:
    """A campaign or a derivative table by its path; None where a model is meant."""
    from pmmkit.campaigns import Campaign
    from pmmkit.exports import read_subject
    from pmmkit.files import Url
    from pmmkit.models import DerivativeTable, ships

    here = Url.of(what) is None
    if what in ships() or (here and not Path(what).expanduser().exists()):
        return None
    found = read_subject(what, data=data)
    return found if isinstance(found, Campaign | DerivativeTable) else None


def compare_tables(
    table: DerivativeTable, measured: Path, folder: Path, names: tuple[str, str], *, drawn: bool
) -> Outcome:
    """A derivative table beside another: differences with their uncertainty, bars side by side."""
    from pmmkit.exports import read_subject
    from pmmkit.models import DerivativeTable, compare

    reference = read_subject(measured)
    if not isinstance(reference, DerivativeTable):
        raise SettingError(f"A table is compared with a table, and {measured} is none.")
    beside = compare(table, reference)
    try:
        worst = [f"Farthest apart: {worst_deviation(table, reference)}."]
    except ValueError:
        worst = []
    inside = int(beside["inside"].sum())
    known = int(beside["std"].notna().sum())
    lines = [
        f"{names[0]} beside {names[1]}: {len(beside)} derivatives; {inside} of {known} 95 % "
        "intervals hold the value compared with.",
        *worst,
        "",
    ]
    results = _files(beside, table, reference, names, drawn)
    return written(folder, results, {"derivatives": beside.to_dict("records")}, lines)


def _files(
    beside: Any,
    table: DerivativeTable,
    reference: DerivativeTable,
    names: tuple[str, str],
    drawn: bool,
) -> Iterator[tuple[str, Any]]:
    from pmmkit.views import beside_reference, derivative_bars

    yield "derivatives_beside.csv", beside
    if drawn:
        figures = {
            "derivative_bars": derivative_bars({names[1]: reference, names[0]: table}),
            "derivatives_beside": beside_reference(table, reference, reference_name=names[1]),
        }
        yield from figure_files(figures, "png")


@dataclass(frozen=True)
class Deviation:
    """The largest deviation of a table from its reference.

    `Fn`: at which Froude number; NaN in a pooled table. `std`: the deviation in standard
    uncertainties, with its sign. `compared`: how many values were compared.
    """

    derivative: str
    Fn: float
    std: float
    compared: int

    def __str__(self) -> str:
        place = "" if math.isnan(self.Fn) else f" at Fn {self.Fn:.4g}"
        return (
            f"{self.derivative}{place}: {self.std:+.2f} standard deviations, "
            f"the largest of {self.compared}"
        )


def worst_deviation(
    table: DerivativeTable,
    reference: DerivativeTable | Mapping[str, float | Sequence[float]],
    *,
    names: Sequence[str] | None = None,
) -> Deviation:
    """The value that is farthest from its reference, in standard uncertainties.

    Values whose uncertainty is not known do not count.

    Examples
    --------
    >>> from pmmkit.conventions import Ship, Water
    >>> from pmmkit.models import from_values
    >>> ship = Ship(name="m", L=4.0, B=1.0, d=.25, volume=.5, mass=500., Izz=500.)
    >>> table = from_values({"Yv": -.0118}, std={"Yv": .0001}, ship=ship, water=Water())
    >>> print(worst_deviation(table, {"Yv": -.0116}))
    Yv: -2.00 standard deviations, the largest of 1
    """
    from pmmkit.models import compare

    frame = compare(table, reference, names=names)
    frame = frame[frame["difference_std"].notna()]
    if frame.empty:
        raise TableError("No value has an uncertainty and a reference to compare it with.")
    row = frame.iloc[int(frame["difference_std"].abs().to_numpy().argmax())]
    return Deviation(
        str(row["derivative"]), float(row["Fn"]), float(row["difference_std"]), len(frame)
    )
