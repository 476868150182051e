"""Speed and memory of the readers, measured side by side with other programs on the same files.

    python -m scripts.benchmarks.benchmark_reading [--mb 20] [--rounds 7]

Our csv reader beside ``pandas.read_csv``; our reader of OpenFOAM's forces, in both layouts, beside
fluidfoam, foamlib and a plain ``pandas.read_csv``, where they are installed. The others give the
numbers as they stand; ours checks every row, and gives forces and moments joined. Rounds alternate,
so that a busy machine hits all alike. Memory is the growth of a fresh process above what it takes
after its imports.
"""

from __future__ import annotations

import argparse
import importlib.util
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Mapping
from pathlib import Path

import pmmkit as pk
from scripts.datasets.make_large import make

Read = Callable[[], object]


def ours(folder: Path) -> Read:
    run = pk.open_campaign(folder).runs[0]
    return lambda: run.data


def by_pandas(folder: Path) -> Read:
    """Files of numbers between commas or blanks; brackets are no numbers."""
    import pandas as pd

    csv = sorted((folder / "runs").rglob("*.csv"))
    if csv:
        return lambda: [pd.read_csv(path) for path in csv]
    dat = sorted((folder / "runs").rglob("*.dat"))
    return lambda: [pd.read_csv(path, sep=r"\s+", comment="#", header=None) for path in dat]


def by_fluidfoam(folder: Path) -> Read:
    from fluidfoam.readpostpro import readforce

    case = next((folder / "runs").iterdir())
    nested = any(folder.rglob("forces.dat"))
    names = ("forces",) if nested else ("force", "moment")
    return lambda: [
        readforce(str(case), namepatch="forces", time_name="0", name=name) for name in names
    ]


def by_foamlib(folder: Path) -> Read:
    from foamlib.postprocessing.table_reader import TableReader

    files = sorted((folder / "runs").rglob("*.dat"))
    return lambda: [TableReader().read(str(path)) for path in files]


WAYS: Mapping[str, Callable[[Path], Read]] = {
    "pmmkit": ours,
    "pandas": by_pandas,
    "fluidfoam": by_fluidfoam,
    "foamlib": by_foamlib,
}
CASES: Mapping[str, tuple[str, int, tuple[str, ...]]] = {
    "csv, 9 columns, 7 used": ("csv", 9, ("pandas", "pmmkit")),
    "csv, 40 columns, 7 used": ("csv", 40, ("pandas", "pmmkit")),
    "OpenFOAM, flat": ("foam-flat", 0, ("pandas", "pmmkit", "fluidfoam", "foamlib")),
    "OpenFOAM, brackets": ("foam-nested", 0, ("pmmkit", "fluidfoam", "foamlib")),
}
"""Format, columns and programs, the first of which the others are compared with."""


def seconds(work: Read) -> float:
    start = time.perf_counter()
    work()
    return time.perf_counter() - start


def memory(way: str, folder: Path, small: Path) -> float:
    """Growth of a fresh process by reading [MB], after a small file has been read (Linux)."""
    code = (
        "import re, sys; from pathlib import Path; import benchmark_reading as b\n"
        "status = Path('/proc/self/status')\n"
        "peak = lambda: int(re.search(r'VmHWM:\\s*(\\d+)', status.read_text())[1]) / 1024\n"
        "b.WAYS[sys.argv[1]](Path(sys.argv[3]))(); before = peak()\n"
        "b.WAYS[sys.argv[1]](Path(sys.argv[2]))(); print(peak() - before)"
    )
    command = [sys.executable, "-c", code, way, str(folder), str(small)]
    done = subprocess.run(
        command, cwd=Path(__file__).parent, capture_output=True, text=True, check=True
    )
    return float(done.stdout.split()[-1])


def installed(way: str) -> bool:
    return importlib.util.find_spec(way) is not None


def works(way: str, folder: Path) -> bool:
    """Whether a program reads a file at all; its error is shown if not."""
    try:
        WAYS[way](folder)()
    except Exception as error:
        print(f"  {way} cannot read this: {type(error).__name__}: {str(error)[:90]}")
        return False
    return True


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--mb", type=float, default=20.0)
    parser.add_argument("--rounds", type=int, default=7)
    given = parser.parse_args()
    with tempfile.TemporaryDirectory() as name:
        for case, (form, width, ways) in CASES.items():
            folder, small = Path(name) / case, Path(name) / f"small {case}"
            size = make(folder, runs=1, mb=2 * given.mb, form=form, width=width) / 1e6
            make(small, runs=1, mb=0.1, form=form, width=width)
            print(f"{case}: {size:.1f} MB, median of {given.rounds}")
            chosen = [way for way in ways if installed(way) and works(way, small)]
            work = {way: WAYS[way](folder) for way in chosen}
            times: dict[str, list[float]] = {way: [] for way in chosen}
            for _ in range(given.rounds):
                for way in chosen:
                    times[way].append(seconds(work[way]))
            base = statistics.median(times["pmmkit"])
            for way in chosen:
                median = statistics.median(times[way])
                print(
                    f"  {way:10} {median:7.3f} s  {size / median:7.1f} MB/s  "
                    f"{median / base:6.2f} x pmmkit's time  "
                    f"{memory(way, folder, small) / size:5.1f} x the file in memory"
                )


if __name__ == "__main__":
    main()
