"""Texts in the layouts of OpenFOAM's releases, with numbers of our own."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np

from pmmkit.readers import Options, Request
from pmmkit.readers.openfoam import reader as openfoam

COFR = (0.35, 0.0, 0.02)
AXES = "xyz"


def numbers(rows: int = 40, seed: int = 4) -> tuple[np.ndarray, dict[str, np.ndarray]]:
    """Times, and parts of force and moment (rows, 3) as they stand in a file: seven digits."""
    rng = np.random.default_rng(seed)
    t = 0.05 * np.arange(1, rows + 1)
    size = np.array([[30.0, 80.0, 400.0]])
    parts = {
        f"{letter}_{group}": seven(share * size * rng.normal(size=(rows, 3)))
        for letter in "FM"
        for group, share in (("pressure", 1.0), ("viscous", 0.1), ("porous", 0.01))
    }
    return t, parts


def seven(values: np.ndarray) -> np.ndarray:
    """The numbers as seven printed digits hold them."""
    return np.array([[float(f"{x:.6e}") for x in row] for row in values])


def vector(row) -> str:
    return "(" + " ".join(f"{x:.6e}" for x in row) + ")"


def cofr() -> str:
    return f"# CofR        : {vector(COFR)}\n"


def old(t, parts, *, commas=False) -> str:
    """Old releases: three groups in brackets, a tab after the time."""
    names = "pressure, viscous, porous" if commas else "pressure viscous porous"
    head = f"# Forces     \n{cofr()}# Time       forces({names}) moment({names})\n"
    return head + "".join(line(t, parts, row) for row in range(len(t)))


def old_local(t, parts, turned) -> str:
    """Old releases with a local coordinate system: two rows for each time."""
    names = "(pressure viscous porous)"
    local = "(pressure,viscous,porous)"
    head = (
        f"# Forces     \n{cofr()}# Time       forces{names} moment{names}"
        f"\tlocalForces{local} localMoments{local}\n"
    )
    rows = (line(t, parts, row) + line(t, turned, row) for row in range(len(t)))
    return head + "".join(rows)


def line(t, parts, row, groups=("pressure", "viscous", "porous")) -> str:
    force, moment = (
        "(" + " ".join(vector(parts[f"{letter}_{group}"][row]) for group in groups) + ")"
        for letter in "FM"
    )
    return f"{t[row]:<13.8g}\t{force} {moment}\n"


def foundation(t, parts) -> str:
    """Foundation 10 and 11: two groups, plural moments."""
    names = "(pressure viscous)"
    head = f"# Forces      \n{cofr()}# Time        forces{names}\tmoments{names}\n"
    return head + "".join(line(t, parts, row, ("pressure", "viscous")) for row in range(len(t)))


def esi(t, parts, letter, *, brackets) -> str:
    """OpenCFD: forces or moments, the total first."""
    groups = ("pressure", "viscous")
    total = sum(parts[f"{letter}_{group}"] for group in groups)
    left, right = ("(", ")") if brackets else ("", "")
    names = "\t".join(
        left + " ".join(f"{group}_{axis}" for axis in AXES) + right for group in ("total", *groups)
    )
    title = "Force" if letter == "F" else "Moment"
    head = f"# {title:<14}\n{cofr()}#\n# Time          \t{names}\n"
    gap = "\t" if brackets else " "
    rows = []
    for row in range(len(t)):
        threes = [total[row], *(parts[f"{letter}_{group}"][row] for group in groups)]
        rows.append(
            f"{t[row]:<15.8g}{gap}"
            + gap.join(left + " ".join(f"{x:.6e}" for x in three) + right for three in threes)
            + "\n"
        )
    return head + "".join(rows)


def coefficients(t, values, names, *, title="# Force coefficients", gap="\t") -> str:
    """Columns of coefficients in any order."""
    head = (
        f"{title}\n# dragDir     : (1 0 0)\n# liftDir     : (0 0 1)\n# magUInf     : 1.5\n"
        f"# lRef        : 4.8\n# Aref        : 1.15\n{cofr()}"
        "# Time          \t" + gap.join(f"{name:<14}" for name in names) + "\n"
    )
    rows = (
        f"{t[row]:<15.8g}\t" + "\t".join(f"{values[name][row]:.6e}" for name in names) + "\n"
        for row in range(len(t))
    )
    return head + "".join(rows)


def body_state(t, centre, rotation, *, degrees=True) -> str:
    """``sixDoFRigidBodyState``: five vectors after the time."""
    head = (
        f"# Motion State\n# Angle Units : {'degrees' if degrees else 'radians'}\n"
        "# Time\tcentreOfRotation\tcentreOfMass\trotation\tvelocity\tomega\n"
    )
    zero = vector((0, 0, 0))
    exact = lambda row: "(" + " ".join(f"{x:.15g}" for x in row) + ")"  # noqa: E731
    return head + "".join(
        f"{t[row]:.15g}\t{exact(centre[row])}\t{exact(centre[row])}\t{exact(rotation[row])}"
        f"\t{zero}\t{zero}\n"
        for row in range(len(t))
    )


def written(folder: Path, files: dict[str, str]) -> Path:
    """The folder with files in it, bytes exactly as given."""
    for name, text in files.items():
        path = folder / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(text.encode())
    return folder


LAYOUTS: dict[str, tuple[Callable[..., dict[str, str]], tuple[str, ...]]] = {
    "old": (lambda t, p: {"forces.dat": old(t, p)}, ("pressure", "viscous", "porous")),
    "old, commas": (
        lambda t, p: {"forces.dat": old(t, p, commas=True)},
        ("pressure", "viscous", "porous"),
    ),
    "foundation": (lambda t, p: {"forces.dat": foundation(t, p)}, ("pressure", "viscous")),
    "esi, brackets": (
        lambda t, p: {f"{n}.dat": esi(t, p, n[0].upper(), brackets=True) for n in HALVES},
        ("pressure", "viscous"),
    ),
    "esi, flat": (
        lambda t, p: {f"{n}.dat": esi(t, p, n[0].upper(), brackets=False) for n in HALVES},
        ("pressure", "viscous"),
    ),
}
HALVES = ("force", "moment")


def request(path: Path, **options) -> Request:
    return Request(path=path, shown=path.name, run="R", options=Options(**options))


def every(path: Path, **options) -> dict[str, np.ndarray]:
    """All columns that a file or folder offers, by header."""
    found = openfoam.columns(request(path, **options), lambda headers, count: range(count))
    return dict(zip(found.headers, found.values, strict=True))


def notes(path: Path) -> str:
    return "\n".join(openfoam.columns(request(path), lambda headers, count: range(count)).notes)


def total(letter: str, axis: int, groups, parts=None) -> np.ndarray:
    held = numbers()[1] if parts is None else parts
    return sum(held[f"{letter}_{group}"][:, axis] for group in groups)
