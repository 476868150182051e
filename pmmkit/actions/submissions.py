"""What is compared with tests and is no model: the campaign or the table of somebody else."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

from pmmkit.actions.outcome import Outcome, written
from pmmkit.actions.setting import SettingError

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
    from pmmkit.models import DerivativeTable, compare, worst_deviation

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
    from pmmkit.plotting import figure_files
    from pmmkit.views import beside_reference, derivative_bars

    yield "derivatives_beside.csv", beside
    if drawn:
        figures = {
            "derivative_bars": derivative_bars({names[1]: reference, names[0]: table}),
            "derivatives_beside": beside_reference(table, reference, reference_name=names[1]),
        }
        yield from figure_files(figures, "png")
