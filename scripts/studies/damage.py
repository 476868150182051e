"""Every reader against damaged files: an error of pmmkit's, or the right answer.

    python -m scripts.studies.damage [--versions 2000] [--readers csv tdms ...] [--jobs 2] \
        [--out FILE]

A good file of each format is damaged in ways that happen: cut off, bytes flipped, blocks of zeros,
columns in another order, missing values, text among numbers, absurd numbers, another encoding. Each
version is read as a user would read it, through a campaign file, in a process with a time limit and
a watch on its memory. A row of the table counts what came out:

right       what was measured, to the bit, or all whole rows that are left, and a note that says so
value       the same rows with another value where a byte of a number was hit: no reader can know
refused     an error that says what is wrong
lost        rows are gone and nobody said so          } must not happen
foreign     an exception of a library                 }
hung        more than ten seconds                     }
crashed     the process died                          }
memory      more than 64 MB and 30 times the file     }
"""

from __future__ import annotations

import argparse
import json
import shutil
import signal
import tempfile
from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from pmmkit.base import Registry
from scripts.datasets.campaign_text import S175

ROWS = 400
NAMES = ("t", "X", "Y", "N")
LIMIT_S = 10
MEMORY = (64_000_000, 30)
OUTCOMES = ("right", "value", "refused", "lost", "foreign", "hung", "crashed", "memory")
BAD = OUTCOMES[3:]
CAMPAIGN = (
    """[campaign]
title = "damage"
"""
    + S175
    + """[[runs]]
id = "SD"
test = "static_drift"
speed = 1.5
drift_deg = 8.0
"""
)


def truth() -> dict[str, NDArray[np.float64]]:
    """What all good files hold."""
    rng = np.random.default_rng(0)
    numbers = (rng.normal(size=(3, ROWS)) + 10.0).round(4)
    return {"t": (np.arange(ROWS) * 0.05).round(6), **dict(zip(NAMES[1:], numbers, strict=True))}


@dataclass(frozen=True, kw_only=True)
class Format:
    """A format and how a good file of it is made.

    Parameters
    ----------
    name : str
        In the table.
    file : str
        Below the campaign's folder.
    entry : str
        What the run says beside the file.
    write : callable
        Writes named columns to a path.
    damaged : str
        The file that is damaged; that of the entry where empty.
    text : bool
        Whether lines are rows.
    """

    name: str
    file: str
    entry: str
    write: Callable[[Path, dict[str, NDArray[np.float64]]], None]
    damaged: str = ""
    text: bool = False


def _csv(path: Path, columns: dict[str, NDArray[np.float64]]) -> None:
    _lines(path, ",".join(columns), columns, ",")


def _german(path: Path, columns: dict[str, NDArray[np.float64]]) -> None:
    _lines(path, ";".join(columns), columns, ";", decimal=",")


def _blanks(path: Path, columns: dict[str, NDArray[np.float64]]) -> None:
    _lines(path, " ".join(f"{name:>12}" for name in columns), columns, "", form="{:13.6f}")


def _star(path: Path, columns: dict[str, NDArray[np.float64]]) -> None:
    words = {
        "t": "Physical Time: Physical Time (s)",
        "X": "Fx Monitor: Force (N)",
        "Y": "Fy Monitor: Force (N)",
        "N": "Mz Monitor: Moment (N-m)",
    }
    _lines(path, ",".join(f'"{words[name]}"' for name in columns), columns, ",")


def _lines(
    path: Path,
    head: str,
    columns: dict[str, NDArray[np.float64]],
    mark: str,
    *,
    form: str = "{:.6f}",
    decimal: str = ".",
) -> None:
    rows = np.stack(list(columns.values()), axis=1)
    body = "".join(mark.join(form.format(x) for x in row) + "\n" for row in rows)
    path.write_text(head + "\n" + body.replace(".", decimal), encoding="utf-8", newline="")


def _tecplot(path: Path, columns: dict[str, NDArray[np.float64]]) -> None:
    names = ", ".join(f'"{name}"' for name in columns)
    head = f'TITLE = "damage"\nVARIABLES = {names}\nZONE T="SD", I={ROWS}, F=POINT'
    _lines(path, head, columns, " ", form="{:14.6f}")


def _foam_nested(path: Path, columns: dict[str, NDArray[np.float64]]) -> None:
    path.parent.mkdir(parents=True, exist_ok=True)
    head = (
        "# Forces      \n# CofR        : (0.000000e+00 0.000000e+00 0.000000e+00)\n"
        "# Time        forces(pressure viscous)\tmoments(pressure viscous)\n"
    )
    c = columns
    rows = zip(c["t"], c["X"], c["Y"], c["N"], strict=True)
    body = "".join(
        f"{t:.6g}          \t(({x:.6e} {y:.6e} 1.0e+00) (0 0 0)) ((0 0 {n:.6e}) (0 0 0))\n"
        for t, x, y, n in rows
    )
    path.write_text(head + body, encoding="utf-8", newline="")


def _foam_flat(path: Path, columns: dict[str, NDArray[np.float64]]) -> None:
    path.parent.mkdir(parents=True, exist_ok=True)
    names = "\t".join(f"{p}_x {p}_y {p}_z" for p in ("total", "pressure", "viscous"))
    c, zero = columns, np.zeros(ROWS)
    for word, file, (x, y, z) in (
        ("Force ", path, (c["X"], c["Y"], zero)),
        ("Moment", path.with_name("moment.dat"), (zero, zero, c["N"])),
    ):
        rows = np.stack([c["t"], x, y, z, x, y, z, zero, zero, zero], axis=1)
        head = f"# {word}      \n# CofR        : (0.0 0.0 0.0)\n#\n# Time        \t{names}\n"
        body = "".join(" ".join(f"{v:.6e}" for v in row) + "\n" for row in rows)
        file.write_text(head + body, encoding="utf-8", newline="")


def _excel(path: Path, columns: dict[str, NDArray[np.float64]]) -> None:
    import pandas as pd

    pd.DataFrame(columns).to_excel(path, index=False)


def _matlab5(path: Path, columns: dict[str, NDArray[np.float64]]) -> None:
    from scipy.io import savemat

    savemat(path, columns, do_compression=True)


def _matlab73(path: Path, columns: dict[str, NDArray[np.float64]]) -> None:
    import h5py

    with h5py.File(path, "w", userblock_size=512) as file:
        for name, values in columns.items():
            stored = file.create_dataset(name, data=values[None, :])
            stored.attrs["MATLAB_class"] = np.bytes_("double")
    head = b"MATLAB 7.3 MAT-file, Platform: GLNXA64, Created on: Sat Nov 21 2026 HDF5 schema 1.00 ."
    with path.open("rb+") as file:
        file.write(head.ljust(116) + bytes(8) + b"\x00\x02IM")


def _hdf5(path: Path, columns: dict[str, NDArray[np.float64]]) -> None:
    import h5py

    with h5py.File(path, "w") as file:
        for name, values in columns.items():
            file.create_dataset(name, data=values, compression="gzip")


def _netcdf3(path: Path, columns: dict[str, NDArray[np.float64]]) -> None:
    from scipy.io import netcdf_file

    with netcdf_file(path, "w") as file:
        file.createDimension("sample", len(columns["t"]))
        for name, values in columns.items():
            file.createVariable(name, "d", ("sample",))[:] = values


def _tdms(path: Path, columns: dict[str, NDArray[np.float64]]) -> None:
    from nptdms import ChannelObject, TdmsWriter

    with TdmsWriter(str(path)) as writer:
        for part in range(4):
            cut = slice(part * ROWS // 4, (part + 1) * ROWS // 4)
            writer.write_segment(
                [ChannelObject("run", name, x[cut].copy()) for name, x in columns.items()]
            )


FOAM = "postProcessing/forces/0/"
FORMATS = Registry(
    Format,
    lambda: (
        Format(name="csv", file="a.csv", entry="", write=_csv, text=True),
        Format(name="csv, decimal commas", file="a.txt", entry="", write=_german, text=True),
        Format(name="blanks", file="a.dat", entry="", write=_blanks, text=True),
        Format(
            name="star-ccm+",
            file="a.csv",
            entry='source = { format = "star-ccm+" }',
            write=_star,
            text=True,
        ),
        Format(
            name="openfoam, nested",
            file="postProcessing/forces",
            write=_foam_nested,
            entry='source = { format = "openfoam" }',
            damaged=FOAM + "forces.dat",
            text=True,
        ),
        Format(
            name="openfoam, flat",
            file="postProcessing/forces",
            write=_foam_flat,
            entry='source = { format = "openfoam" }',
            damaged=FOAM + "force.dat",
            text=True,
        ),
        Format(
            name="tecplot",
            file="a.plt",
            entry='source = { format = "tecplot" }',
            write=_tecplot,
            text=True,
        ),
        Format(name="excel", file="a.xlsx", entry="", write=_excel),
        Format(
            name="matlab 5", file="a.mat", entry='source = { format = "matlab" }', write=_matlab5
        ),
        Format(
            name="matlab 7.3", file="a.mat", entry='source = { format = "matlab" }', write=_matlab73
        ),
        Format(name="hdf5", file="a.h5", entry='source = { format = "hdf5" }', write=_hdf5),
        Format(name="netcdf 3", file="a.nc", entry='source = { format = "hdf5" }', write=_netcdf3),
        Format(name="tdms", file="a.tdms", entry='source = { format = "tdms" }', write=_tdms),
    ),
    what="format",
    listed="scripts.studies.formats:FORMATS",
)


Damage = Callable[[bytes, np.random.Generator], bytes]


def _cut(data: bytes, rng: np.random.Generator) -> bytes:
    return data[: int(rng.integers(1, len(data)))]


def _flip(data: bytes, rng: np.random.Generator) -> bytes:
    out = bytearray(data)
    for place in rng.integers(0, len(data), int(rng.choice([1, 1, 1, 3, 10]))):
        out[place] ^= 1 << int(rng.integers(8))
    return bytes(out)


def _zeros(data: bytes, rng: np.random.Generator) -> bytes:
    size = int(rng.choice([1, 16, 512, 4096]))
    at = int(rng.integers(0, max(len(data) - size, 1)))
    return data[:at] + bytes(min(size, len(data) - at)) + data[at + size :]


def _moved(data: bytes, rng: np.random.Generator) -> bytes:
    a, b = sorted(rng.integers(0, len(data), 2).tolist())
    size = min(int(rng.integers(1, 600)), b - a, len(data) - b)
    return (
        data[:a] + data[b : b + size] + data[a + size : b] + data[a : a + size] + data[b + size :]
    )


def _encoded(data: bytes, rng: np.random.Generator) -> bytes:
    if rng.random() < 0.5:
        at = int(rng.integers(0, len(data)))
        return data[:at] + rng.integers(128, 256, 3).astype(np.uint8).tobytes() + data[at:]
    return data.decode("latin-1").encode(
        str(rng.choice(["utf-16-le", "utf-16", "utf-32", "cp500"]))
    )


BYTES: dict[str, Damage] = {
    "cut off": _cut,
    "bytes flipped": _flip,
    "zeros": _zeros,
    "blocks moved": _moved,
    "encoding": _encoded,
}
CELLS = {"missing value": "nan", "text": "broken", "absurd number": "1e35"}
KINDS = (*BYTES, "columns moved", *CELLS, "empty")


def damaged(form: Format, good: bytes, folder: Path, kind: str, rng: np.random.Generator) -> None:
    """Write one damaged version of a good file over it."""
    path = folder / (form.damaged or form.file)
    if kind in BYTES:
        path.write_bytes(BYTES[kind](good, rng))
    elif kind == "empty":
        path.write_bytes(b"" if rng.random() < 0.5 else bytes(int(rng.integers(1, 5000))))
    elif kind == "columns moved":
        order = rng.permutation(NAMES)
        whole = truth()
        form.write(path, {str(name): whole[str(name)] for name in order})
    elif form.text:
        lines = good.decode().splitlines(keepends=True)
        rows = [i for i, line in enumerate(lines) if line[:1] in "-0123456789 " and line.strip()]
        at = int(rng.choice(rows[2:-2]))
        cells = [
            cell
            for cell in lines[at]
            .replace("(", " ")
            .replace(")", " ")
            .replace(",", " ")
            .replace(";", " ")
            .split()
            if cell
        ]
        lines[at] = lines[at].replace(cells[1], CELLS[kind], 1)
        path.write_text("".join(lines), encoding="utf-8", newline="")
    else:
        whole = truth()
        value = {"missing value": np.nan, "text": np.inf, "absurd number": 1e35}[kind]
        whole[str(rng.choice(NAMES))][int(rng.integers(2, ROWS - 2))] = value
        form.write(path, whole)


def outcome(form: Format, folder: Path, kind: str) -> str:
    """What reading the folder gives."""
    from pmmkit.base import PmmkitError
    from pmmkit.campaigns import open_campaign

    def late(*_: object) -> None:
        raise TimeoutError

    signal.signal(signal.SIGALRM, late)
    signal.alarm(LIMIT_S)
    before = _reset_peak()
    try:
        (run,) = open_campaign(folder).runs
        data = run.data.load()
    except PmmkitError:
        return "refused" if _within(before, form, folder) else "memory"
    except TimeoutError:
        return "hung"
    except BaseException:
        return "foreign"
    finally:
        signal.alarm(0)
    if not _within(before, form, folder):
        return "memory"
    whole = truth()
    count = data.sizes["t"]
    same = [np.array_equal(data[name].values, whole[name][:count]) for name in NAMES]
    noted = "left out" in data.attrs["conversions"] or "dropped" in data.attrs["conversions"]
    if count == ROWS:
        if all(same):
            return "right"
        return "lost" if kind in (*CELLS, "columns moved") else "value"
    if form.text and kind == "cut off":
        rest = (folder / (form.damaged or form.file)).read_bytes()
        return "right" if all(same) and (noted or _whole_rows(rest) == count) else "lost"
    return "right" if noted else "lost"


def _whole_rows(data: bytes) -> int:
    """Rows of numbers that a cut file holds whole."""
    lines = data.split(b"\n")
    return sum(line.strip()[:1].isdigit() for line in lines if line.strip())


def _reset_peak() -> int:
    """Resident memory now [bytes], the peak begun anew (Linux; elsewhere zero)."""
    try:
        Path("/proc/self/clear_refs").write_text("5")
        return _status("VmRSS:")
    except OSError:
        return 0


def _within(before: int, form: Format, folder: Path) -> bool:
    if not before:
        return True
    size = (folder / (form.damaged or form.file)).stat().st_size
    return _status("VmHWM:") - before <= max(MEMORY[0], MEMORY[1] * size)


def _status(word: str) -> int:
    lines = Path("/proc/self/status").read_text().splitlines()
    return next(int(line.split()[1]) * 1024 for line in lines if line.startswith(word))


def good_folder(form: Format, folder: Path) -> bytes:
    """A campaign with one good file of a format; the bytes that will be damaged."""
    folder.mkdir(parents=True, exist_ok=True)
    path = folder / (form.damaged or form.file)
    form.write(path, truth())
    text = CAMPAIGN + f'file = "{form.file}"\n{form.entry}\n'
    (folder / "campaign.toml").write_text(text, encoding="utf-8")
    return path.read_bytes()


def tried(name: str, kind: str, seeds: Sequence[int]) -> list[str]:
    """Outcomes of some damaged versions."""
    form = FORMATS[name]
    with tempfile.TemporaryDirectory() as place:
        good = good_folder(form, Path(place) / "good")
        outcome(form, Path(place) / "good", "none")  # imports take their memory once
        if outcome(form, Path(place) / "good", "none") != "right":
            raise AssertionError(f"The good file of {name} is not read right.")
        found = []
        for seed in seeds:
            folder = Path(place) / "damaged"
            shutil.copytree(Path(place) / "good", folder)
            rng = np.random.default_rng([KINDS.index(kind), seed])
            damaged(form, good, folder, kind, rng)
            found.append(outcome(form, folder, kind))
            shutil.rmtree(folder)
    return found


def counted(name: str, kind: str, versions: int, jobs: int) -> Counter[str]:
    """Outcomes of many versions, in processes of their own."""
    parts = [range(versions)[i::jobs] for i in range(jobs)]
    try:
        with ProcessPoolExecutor(jobs) as pool:
            return Counter(
                x for own in pool.map(tried, [name] * jobs, [kind] * jobs, parts) for x in own
            )
    except BrokenProcessPool:
        return _one_by_one(name, kind, versions)


def _one_by_one(name: str, kind: str, versions: int) -> Counter[str]:
    """The same where a version kills its process: smaller and smaller parts."""
    found: Counter[str] = Counter()
    todo = [range(versions)]
    while todo:
        part = todo.pop()
        try:
            with ProcessPoolExecutor(1) as pool:
                found.update(pool.submit(tried, name, kind, part).result())
        except BrokenProcessPool:
            if len(part) == 1:
                found["crashed"] += 1
                print(f"crashed: {name}, {kind}, seed {part[0]}", flush=True)
            else:
                todo += [part[: len(part) // 2], part[len(part) // 2 :]]
    return found


def kinds_of(form: Format) -> Iterator[str]:
    """Kinds of damage that a format can have."""
    for kind in KINDS:
        fixed = form.name.startswith("openfoam") and kind == "columns moved"
        if not fixed and (form.text or kind != "encoding"):
            yield kind


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--versions", type=int, default=2000, help="per reader, over all kinds")
    parser.add_argument("--readers", nargs="+", default=list(FORMATS), choices=list(FORMATS))
    parser.add_argument("--jobs", type=int, default=2)
    parser.add_argument("--out", type=Path)
    options = parser.parse_args()
    print(f"{'reader':20} {'damage':15} " + " ".join(f"{x:>7}" for x in OUTCOMES))
    table = []
    for name in options.readers:
        kinds = list(kinds_of(FORMATS[name]))
        each = -(-options.versions // len(kinds))
        for kind in kinds:
            found = counted(name, kind, each, options.jobs)
            print(
                f"{name:20} {kind:15} " + " ".join(f"{found[x] or '':>7}" for x in OUTCOMES),
                flush=True,
            )
            table.append({"reader": name, "damage": kind, **{x: found[x] for x in OUTCOMES}})
    bad = sum(row[x] for row in table for x in BAD)
    total = sum(row[x] for row in table for x in OUTCOMES)
    print(f"{total} versions, {bad} that must not happen")
    if options.out:
        options.out.write_text(json.dumps(table, indent=1), encoding="utf-8")


if __name__ == "__main__":
    main()
