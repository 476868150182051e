"""KCS in shallow water as Flanders Hydraulics handed it in, from its workbook to derivatives.

    python -m scripts.studies.kcs_shallow [--workbook FILE] [--structure abkowitz3] [--rudder]

Each sheet (2.0, 1.5, 1.2 draughts) becomes a campaign by `pmmkit new-campaign`, with two lines
edited (density, sign of the rudder), and is reduced at each Froude number and pooled. Beside it
stands a least squares of its own: numpy, equal weights in newtons, straight from the cells, which
shares no line with the package. The laboratory's numbers stay where they are.

value, half : by pmmkit, with half of its 95 % interval, times 1000
own, wide : by the least squares, with 1.96 of its standard deviations, times 1000
apart : their difference over the larger of the two standard deviations

With --rudder the tests with a rudder that swings at constant drift are left out of the reduction
and predicted: rms of what is left, over the force and over the scatter of repeated runs. Below
stand the derivatives of the rudder by the steady tests, and by those tests as `harmonic_rudder`.
"""

from __future__ import annotations

import argparse
import math
import os
import re
import tempfile
from collections.abc import Iterator
from contextlib import redirect_stderr, redirect_stdout
from io import StringIO
from pathlib import Path
from typing import Any

import numpy as np

ROOT = Path(__file__).parents[2]
DATA = Path(os.environ.get("PMMKIT_DATA", ROOT.parent / "shared" / "data"))
BOOK = "kcs_fhr_shallow/App01_KCS_PMM_results_May2014.xlsx"
L, MASS, XG, IZZ, RHO = 4.367, 356.6, -0.0608, 445.8, 1000.0
WIDE = 1.96
SPEEDS = (0.248, 0.496, 0.62)
TERMS = ("v", "r", "vvv", "rrr", "vvr", "vrr", "vdot", "rdot")
SHOWN = ("Yv", "Nv", "Yr", "Nr", "Yvdot", "Nrdot")


def cells(book: Path, sheet: str) -> Iterator[tuple[str, str, list[float]]]:
    """Kind, name and numbers of each row of steady tests, sway and yaw at zero rudder."""
    import openpyxl

    rows = openpyxl.load_workbook(book, read_only=True, data_only=True)[sheet]
    seen = set()
    for row in rows.iter_rows(min_row=3, values_only=True):
        kind, name = str(row[1]).upper(), str(row[0]).upper()
        if kind not in ("STATX0", "PMMY2", "PMMPSI2") or not isinstance(row[5], (int, float)):
            continue
        if kind == "STATX0" and name in seen:
            continue
        seen.add(name)
        given = [x if isinstance(x, (int, float)) else math.nan for x in row]
        if given[22] == 0.0 and given[5] > 0.1:
            yield kind, name, given


def least_squares(book: Path, sheet: str, speed: float | None) -> dict[str, tuple[float, float]]:
    """Derivatives and standard deviations, equal weights in newtons, offsets of both channels."""
    rows = np.array([x[4:29] for _, _, x in cells(book, sheet)], float)
    u, v, r = rows[:, 1], rows[:, 2], np.radians(rows[:, 3])
    du, dv, dr = rows[:, 4], rows[:, 5], np.radians(rows[:, 6])
    U = np.hypot(u, v)
    near = np.argmin(np.abs(U[:, None] - SPEEDS), axis=1)
    at = np.full(len(U), True) if speed is None else near == SPEEDS.index(speed)
    del du
    force = {
        "Y": rows[:, 8] + MASS * (dv + u * r + XG * dr),
        "N": rows[:, 13] + IZZ * dr + MASS * XG * (dv + u * r),
    }
    found = {}
    for channel in force:
        names = [channel + term for term in TERMS]
        unit = 0.5 * RHO * L**2 * U**2 * (L if channel == "N" else 1.0)
        b, y, a, z = v / U, r * L / U, dv * L / U**2, dr * L**2 / U**2
        columns = np.stack([b, y, b**3, y**3, b * b * y, b * y * y, a, z], axis=1) * unit[:, None]
        X = np.column_stack([columns, np.ones(len(U))])[at]
        size = np.linalg.norm(X, axis=0)
        value, *_ = np.linalg.lstsq(X / size, force[channel][at], rcond=1e-10)
        left = force[channel][at] - X / size @ value
        cover = np.linalg.pinv((X / size).T @ (X / size)) * (left @ left) / (len(left) - X.shape[1])
        std = np.sqrt(np.diagonal(cover)) / size
        found |= dict(zip(names, zip(value / size, std, strict=False), strict=False))
    return found


def campaign(book: Path, sheet: str, folder: Path) -> Path:
    """A campaign of a sheet by the command, two lines edited."""
    from pmmkit.cli import main

    (folder / book.name).write_bytes(book.read_bytes())
    file = folder / f"{sheet}.toml"
    with redirect_stdout(StringIO()), redirect_stderr(StringIO()):
        assert main(["new-campaign", str(folder), "--sheet", sheet, "-o", str(file)]) == 0
    text = re.sub(r"(?m)^rho = .*", f"rho = {RHO}", file.read_text(encoding="utf-8"))
    text = re.sub(r"(?m)^rudder_positive = .*", 'rudder_positive = "port"', text)
    file.write_text(text, encoding="utf-8")
    return file


def swinging(made: Any, structure: str, book: Path, sheet: str) -> None:
    """How well steady tests, sway and yaw predict the forces while the rudder swings."""
    from pmmkit.reduction import reduce_campaign

    swung = [run.id for run in made.runs if re.search(r"_M\w+_\d+$", run.id, re.I)]
    rest = made.with_(runs=tuple(run for run in made.runs if run.id not in swung))
    known = reduce_campaign(rest, structure=structure, fn="each", check=False)
    every = reduce_campaign(made, structure=structure, fn="each", check=False)
    left: dict[str, list[tuple[float, float]]] = {}
    for item in every.rows:
        if item.result.run.id not in swung:
            continue
        group = int(np.argmin(np.abs(known.table.Fn - item.result.froude)))
        own = dict(zip(known.solution.joint.labels, known.solution.joint.value, strict=True))
        for channel, names in item.names.items():
            told = np.array([np.nan_to_num(own.get((group, name), 0.0)) for name in names])
            predicted = item.design[channel] @ told
            left.setdefault(channel, []).append(
                (float(item.force[channel][0]), float(predicted[0]))
            )
    scatter = repeats(book, sheet)
    for channel in ("X", "Y", "N"):
        measured, predicted = np.array(left[channel]).T
        rms = float(np.sqrt(np.mean((predicted - measured) ** 2)))
        size = float(np.sqrt(np.mean(measured**2)))
        print(
            f"  swinging rudder, {len(measured)} points, {channel}: rms left {rms:.3f} of "
            f"{size:.3f} ({100 * rms / size:.0f} %), {rms / scatter[channel]:.1f} times the "
            f"{scatter[channel]:.3f} by which repeated steady tests scatter"
        )


def harmonic(file: Path) -> Path:
    """The campaign with the tests of a swinging rudder as cycles.

    Their period is not listed. No derivative of the rudder hangs on it; the place x, whose slope
    would be a speed by it, is left out.
    """
    head, swung = file.read_text(encoding="utf-8").split('[[tables]]\nid = "{Test ()}_{row}"\n')
    swung = swung.replace(
        'test = "drift_rudder"', 'test = "harmonic_rudder"\nsamples = "cycle"\nperiod = 100.0', 1
    )
    held = 'drift_deg = "psi (°)", x = false, psi = false, v = false, speed = "u (m/s)", u = false'
    swung = re.sub(r"(?m)^columns = .*", f"columns = {{ {held} }}", swung, count=1)
    made = file.with_stem(f"{file.stem}_harmonic")
    made.write_text(f'{head}[[tables]]\nid = "{{Test ()}}"\n{swung}', encoding="utf-8")
    return made


def of_the_rudder(made: Any, structure: str) -> dict[str, dict[str, tuple[float, float]]]:
    """Derivatives of the rudder and their standard deviations, times 1000: by steady tests, and by
    tests in which it swings beside steady ones without rudder."""
    from pmmkit.reduction import reduce_campaign

    steady = [run for run in made.runs if not run.dynamic]
    swung = [run for run in made.runs if run.kind_of_test.swings_rudder]
    found = {}
    for words, runs in (
        ("steady", steady),
        ("swinging", [*swung, *(run for run in steady if not run.settings.rudder)]),
    ):
        own = made.with_(runs=tuple(runs))
        table = reduce_campaign(own, structure=structure, fn="pooled", check=False).table
        at = {name: table.index(name) for name in ("Yd", "Yddd", "Nd", "Nddd")}
        found[words] = {
            name: (1e3 * float(table.value[0, i]), 1e3 * float(table.std[0, i]))
            for name, i in at.items()
        }
    return found


def repeats(book: Path, sheet: str) -> dict[str, float]:
    """Pooled standard deviations of steady tests that were set alike, straight from the cells."""
    import openpyxl

    rows = openpyxl.load_workbook(book, read_only=True, data_only=True)[sheet]
    groups: dict[tuple[float, ...], list[list[float]]] = {}
    for row in rows.iter_rows(min_row=3, values_only=True):
        if str(row[1]).upper() == "STATX0" and isinstance(row[5], (int, float)):
            set_to = tuple(round(float(row[place]), 1) for place in (18, 22, 27))
            forces = [float(row[place]) for place in (11, 12, 17)]
            groups.setdefault((round(float(row[5]), 2), *set_to), []).append(forces)
    some = [np.array(group) for group in groups.values() if len(group) > 1]
    squares = sum(((group - group.mean(axis=0)) ** 2).sum(axis=0) for group in some)
    pooled = np.sqrt(squares / sum(len(group) - 1 for group in some))
    return dict(zip(("X", "Y", "N"), pooled.tolist(), strict=True))


def main() -> None:
    import pmmkit as pk
    from pmmkit.reduction import reduce_campaign

    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawTextHelpFormatter
    )
    parser.add_argument("--workbook", type=Path, default=DATA / BOOK)
    parser.add_argument("--structure", default="abkowitz3")
    parser.add_argument("--rudder", action="store_true")
    o = parser.parse_args()
    with tempfile.TemporaryDirectory() as place:
        for depth, sheet in ((2.0, "C0101A01"), (1.5, "C0101A02"), (1.2, "C0101A03")):
            made = pk.open_campaign(campaign(o.workbook, sheet, Path(place)))
            if o.rudder:
                print(f"depth {depth} draughts")
                swinging(made, o.structure, o.workbook, sheet)
                cycles = pk.open_campaign(harmonic(Path(place) / f"{sheet}.toml"))
                for words, values in of_the_rudder(cycles, o.structure).items():
                    told = (f"{n} {v:.2f} ± {WIDE * s:.2f}" for n, (v, s) in values.items())
                    print(f"  {words}: {', '.join(told)}")
                continue
            made = made.with_(runs=tuple(run for run in made.runs if run.settings.rudder == 0.0))
            for fn in ("each", "pooled"):
                found = reduce_campaign(made, structure=o.structure, fn=fn, check=False)
                table = found.table
                low, high = table.interval()
                print(f"depth {depth} draughts, {fn}: {found.verdict}")
                for row, Fn in enumerate(table.Fn.tolist()):
                    speed = (
                        None
                        if fn == "pooled"
                        else min(SPEEDS, key=lambda s: abs(s / math.sqrt(9.81 * L) - Fn))
                    )
                    own = least_squares(o.workbook, sheet, speed)
                    for name in SHOWN:
                        at = table.index(name)
                        value, std = 1e3 * table.value[row, at], 1e3 * table.std[row, at]
                        other, its = (1e3 * x for x in own[name])
                        half = 1e3 * (high[row, at] - low[row, at]) / 2
                        print(
                            f"  Fn {Fn:.3f} {name:6} {value:9.2f} ± {half:7.2f}   own {other:9.2f} "
                            f"± {WIDE * its:6.2f}   apart {abs(value - other) / max(std, its):.2f}"
                        )
                for channel in ("X", "Y", "N"):
                    fits = [x for _, x in found.solution.fits if x.channel == channel]
                    print("  between runs", found.solution.between.in_words(channel, fits))


if __name__ == "__main__":
    main()
