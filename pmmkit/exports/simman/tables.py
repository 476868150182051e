"""The files of results: ASCII, comma separated, ``name [unit]`` over each column."""

from __future__ import annotations

import csv
import io
import math
from collections.abc import Iterable, Mapping, Sequence

from pmmkit.conventions import CHANNEL_UNITS, CHANNELS
from pmmkit.exports.simman.results import HELD, MOTION, SimmanResult, cycle_of
from pmmkit.numerics import Array
from pmmkit.presentation import safe_cell
from pmmkit.syntax import plain

Row = dict[str, str | float]


def static_means(results: Sequence[SimmanResult]) -> str:
    """A row per static run: means of forces and motions, standard uncertainties of the means."""
    rows = []
    for item in results:
        if item.run.dynamic:
            continue
        means = {_titled(name): float(x[0]) for name, x in item.force.items()}
        doubts = {_titled(f"{name}_std", name): float(x[0]) for name, x in item.std.items()}
        rows.append(
            {
                **_head(item),
                _titled("psi"): item.run.settings.drift,
                **means,
                **doubts,
                **{_titled(name): float(item.motion[name][0]) for name in MOTION},
                **_held(item, results),
                **{_titled(name): x for name, x in item.extras.items()},
                "samples": item.samples or math.nan,
                "t_start [s]": item.begin,
                "t_end [s]": item.end,
            }
        )
    return _text(rows)


def fourier_coefficients(results: Sequence[SimmanResult]) -> str:
    """A row per oscillating run: means, cosines and sines of forces and velocities."""
    return _text(
        {
            **_head(item),
            "period [s]": item.run.settings.period or math.nan,
            "cycles": item.cycles or math.nan,
            **_coefficients(item, {**item.force, **{x: item.motion[x] for x in ("u", "v", "r")}}),
            **_held(item, results),
            **{_titled(f"{name}_mean", name): x for name, x in item.extras.items()},
        }
        for item in results
        if item.run.dynamic
    )


def fourier_uncertainties(results: Sequence[SimmanResult]) -> str:
    """The same, of the coefficients of forces: standard uncertainties from the noise of the record.

    Runs of which nothing is known are left out; the text is empty where that is all of them.
    """
    return _text(
        {**_head(item), **_coefficients(item, item.std)}
        for item in results
        if item.run.dynamic and item.std
    )


def one_cycle_series(result: SimmanResult, results: Sequence[SimmanResult]) -> str:
    """One cycle of a run over time."""
    values = cycle_of(result)
    shown = _shown(results)
    kept = {name: x for name, x in values.items() if name not in HELD or name in shown}
    return _series({_titled(name): x for name, x in kept.items()})


def _head(item: SimmanResult) -> Row:
    run = item.run
    return {"run": safe_cell(plain(run.id)), "test": run.test, _titled("speed"): run.settings.speed}


def _coefficients(item: SimmanResult, values: Mapping[str, Array]) -> Row:
    parts = {"C": "cos", "S": "sin"}
    found: Row = {}
    for name, numbers in values.items():
        for label, number in zip(item.labels, numbers.tolist(), strict=True):
            part = "mean" if label == "C0" else f"{parts[label[0]]}{label[1:]}"
            found[_titled(f"{name}_{part}", name)] = number
    return found


def _held(item: SimmanResult, results: Sequence[SimmanResult]) -> Row:
    """Heel, rudder and revolutions, those that are not zero in all runs."""
    return {_titled(name): float(item.motion[name][0]) for name in _shown(results)}


def _shown(results: Iterable[SimmanResult]) -> list[str]:
    every = list(results)
    return [name for name in HELD if any(item.motion[name].any() for item in every)]


def _titled(name: str, channel: str | None = None) -> str:
    return f"{name} [{CHANNEL_UNITS[channel or name]}]"


def _text(rows: Iterable[Mapping[str, str | float]]) -> str:
    """Rows under all their columns; what a run does not have is left empty."""
    every = list(rows)
    titles = _in_order(dict.fromkeys(title for row in every for title in row))
    if not every:
        return ""
    room = io.StringIO(newline="")
    writer = csv.writer(room, lineterminator="\n")
    writer.writerow(titles)
    for row in every:
        writer.writerow([_cell(row.get(title, math.nan)) for title in titles])
    return room.getvalue()


def _in_order(titles: Iterable[str]) -> list[str]:
    """Columns of K, which few runs have, beside those of X, Y and N."""
    every = list(titles)
    forces = [title for title in every if title.partition(" ")[0].partition("_")[0] in CHANNELS]
    first = min((every.index(title) for title in forces), default=0)
    rest = [title for title in every if title not in forces]
    ordered = [
        title for name in CHANNELS for title in forces if title.startswith((f"{name} ", f"{name}_"))
    ]
    return [*rest[:first], *ordered, *rest[first:]]


def _series(columns: Mapping[str, Array]) -> str:
    lines = [",".join(columns)]
    lines += [
        ",".join(map(repr, row))
        for row in zip(*(x.tolist() for x in columns.values()), strict=True)
    ]
    return "\n".join(lines) + "\n"


def _cell(value: str | float) -> str:
    if isinstance(value, str):
        return value
    return "" if math.isnan(value) else repr(value)
