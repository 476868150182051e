"""Make large campaigns of synthetic histories, to measure what reading them costs.

    python -m scripts.datasets.make_large FOLDER [--runs 2000] [--mb 0.5] [--columns 9] [--format csv]

Static drift, pure sway, pure yaw and yaw with drift at five speeds, as many runs as asked for, each
of about the size asked for. The forces follow from the true derivatives of ``datasets/s175``
through the plain formulas of ``virtual_tank.py``, with noise. Formats: ``csv``; ``foam-flat`` and
``foam-nested``, the two layouts of OpenFOAM's force files (``force.dat`` and ``moment.dat`` of ESI
v2212 and later without brackets; one ``forces.dat`` with nested brackets of Foundation 10 and 11).
The same arguments give the same bytes.
"""

from __future__ import annotations

import argparse
import math
import shutil
from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from scripts.datasets.s175_programme import CHANNEL_SIZE, NOISE, SWAY_FREQUENCY, YAW_FREQUENCY, noise
from scripts.datasets.s175_truth import load_truth
from scripts.datasets.virtual_tank import SHIP, WATER, motion, water_forces

SPEEDS = (1.0, 1.25, 1.5, 1.75, 2.0)
TESTS = ("static_drift", "pure_sway", "pure_yaw", "yaw_drift")
CYCLES, STATIC_LENGTHS = 6, 16.0
GOLDEN = (math.sqrt(5) - 1) / 2
BLOCK = 2000
"""Rows that are formatted at once."""
FORMATS = ("csv", "foam-flat", "foam-nested")


@dataclass(frozen=True)
class Test:
    """One run: its settings as the campaign file states them."""

    number: int
    test: str
    speed: float
    drift_deg: float | None = None
    period: float | None = None
    amplitude_m: float | None = None
    yaw_amplitude_deg: float | None = None

    @property
    def id(self) -> str:
        return f"{self.test}_{self.number:04d}"

    @property
    def duration(self) -> float:
        if self.period is None:
            return STATIC_LENGTHS * SHIP.L / self.speed
        return CYCLES * self.period

    def entry(self, file: str) -> str:
        """Its [[runs]] in the campaign file."""
        settings = {
            "speed": self.speed, "drift_deg": self.drift_deg, "period": self.period,
            "amplitude_m": self.amplitude_m, "yaw_amplitude_deg": self.yaw_amplitude_deg,
        }
        lines = [f"{key} = {value}" for key, value in settings.items() if value is not None]
        head = ["[[runs]]", f'id = "{self.id}"', f'test = "{self.test}"', f'file = "{file}"']
        return "\n".join([*head, *lines]) + "\n"


def programme(runs: int) -> Iterator[Test]:
    """So many runs, their settings spread evenly over the usual ranges."""
    for number in range(runs):
        speed = SPEEDS[number % len(SPEEDS)]
        test = TESTS[number // len(SPEEDS) % len(TESTS)]
        share, other = (number * GOLDEN) % 1.0, (number * GOLDEN**2) % 1.0
        drift = round(-12 + 24 * share, 3)
        if test == "static_drift":
            yield Test(number, test, speed, drift_deg=drift)
            continue
        prime = SWAY_FREQUENCY if test == "pure_sway" else YAW_FREQUENCY
        period = round(2 * math.pi * SHIP.L / (prime * speed), 4)
        omega = 2 * math.pi / period
        if test == "pure_sway":
            amplitude = round((0.08 + 0.16 * share) * speed / omega, 5)
            yield Test(number, test, speed, period=period, amplitude_m=amplitude)
            continue
        rate = (0.2 + 0.4 * other) * speed / SHIP.L
        heading = round(math.degrees(rate / omega), 4)
        combined = None if test == "pure_yaw" else round(0.8 * drift, 3)
        yield Test(
            number, test, speed, drift_deg=combined, period=period, yaw_amplitude_deg=heading
        )


def record(test: Test, rows: int) -> dict[str, np.ndarray]:
    """Its history: time, forces of the water with noise, and the motion."""
    rng = np.random.default_rng([6, test.number])
    t = np.arange(rows) * (test.duration / rows)
    omega = 2 * math.pi / test.period if test.period else 1.0
    given = {"drift": math.radians(test.drift_deg or 0.0)}
    if test.amplitude_m is not None:
        given = {"v": test.amplitude_m * omega / test.speed}
    if test.yaw_amplitude_deg is not None:
        given["r"] = math.radians(test.yaw_amplitude_deg) * omega * SHIP.L / test.speed
    state = motion(test.test, test.speed, omega * t, omega, **given)
    truth = load_truth().at(SHIP.froude(test.speed, WATER.g))
    columns = {"t": t}
    for channel, values in water_forces(truth, *state).items():
        arm = SHIP.L if channel == "N" else 1.0
        size = CHANNEL_SIZE[channel] * 0.5 * WATER.rho * SHIP.L**2 * test.speed**2 * arm
        columns[channel] = values + noise(rng, rows, NOISE * size)
    return columns | dict(zip("uvr", state[:3], strict=True))


def csv_table(columns: Mapping[str, np.ndarray], width: int) -> tuple[str, np.ndarray]:
    """Header and numbers of a CSV file: the channels, then gauges that nobody reads."""
    rows = len(columns["t"])
    names = [*columns, *(f"gauge_{k:02d}" for k in range(1, width - len(columns) + 1))]
    table = np.empty((rows, width))
    for place, values in enumerate(list(columns.values())[:width]):
        table[:, place] = values
    for place in range(len(columns), width):
        table[:, place] = 1.7 * columns["Y"] + place * columns["N"]
    return ",".join(names[:width]) + "\n", table


def foam_vectors(columns: Mapping[str, np.ndarray], kind: str) -> np.ndarray:
    """Total, pressure and viscous part of the force or the moment, three components each.

    The model floats without heel or trim.
    """
    none = np.zeros_like(columns["t"])
    if kind == "force":
        total = np.stack([columns["X"], columns["Y"], none], axis=1)
    else:
        total = np.stack([none, none, columns["N"]], axis=1)
    viscous = 0.1 * total
    return np.concatenate([total, total - viscous, viscous], axis=1)


def write_rows(path: Path, head: str, pattern: str, table: np.ndarray) -> None:
    """A header and rows by one printf pattern, formatted in blocks."""
    path.parent.mkdir(parents=True, exist_ok=True)
    with path.open("w", encoding="ascii", newline="\n") as stream:
        stream.write(head)
        for start in range(0, len(table), BLOCK):
            part = table[start : start + BLOCK]
            stream.write(pattern * len(part) % tuple(part.ravel().tolist()))


def write_csv(folder: Path, test: Test, rows: int, width: int) -> str:
    """The run as CSV; gives the name that the campaign file says."""
    file = f"runs/{test.id}.csv"
    head, table = csv_table(record(test, rows), width)
    write_rows(folder / file, head, ",".join(["%.7g"] * width) + "\n", table)
    return file


def write_foam_flat(folder: Path, test: Test, rows: int, _: int) -> str:
    """The run as ``postProcessing/forces/0/force.dat`` and ``moment.dat`` without brackets."""
    columns = record(test, rows)
    place = folder / "runs" / test.id / "postProcessing"
    parts = "\t".join(" ".join(f"{p}_{a}" for a in "xyz") for p in ("total", "pressure", "viscous"))
    for kind in ("force", "moment"):
        head = (
            f"# {kind.capitalize():<12}\n# {'CofR':<12}: (0.000000e+00 0.000000e+00 0.000000e+00)"
            f"\n#\n# {'Time':<12}\t{parts}\n"
        )
        table = np.column_stack([columns["t"], foam_vectors(columns, kind)])
        write_rows(place / f"forces/0/{kind}.dat", head, "%-14.8g" + " %.6e" * 9 + "\n", table)
    return place.relative_to(folder).as_posix()


def write_foam_nested(folder: Path, test: Test, rows: int, _: int) -> str:
    """The run as ``postProcessing/forces/0/forces.dat`` with nested brackets."""
    columns = record(test, rows)
    place = folder / "runs" / test.id / "postProcessing"
    head = (
        f"# {'Forces':<12}\n# {'CofR':<12}: (0.000000e+00 0.000000e+00 0.000000e+00)\n"
        f"# {'Time':<12}forces(pressure viscous)\tmoments(pressure viscous)\n"
    )
    vector = "(%.6e %.6e %.6e)"
    pattern = f"%-14.8g\t({vector} {vector}) ({vector} {vector})\n"
    vectors = [foam_vectors(columns, kind)[:, 3:] for kind in ("force", "moment")]
    table = np.column_stack([columns["t"], *vectors])
    write_rows(place / "forces/0/forces.dat", head, pattern, table)
    return place.relative_to(folder).as_posix()


WRITERS: Mapping[str, Callable[[Path, Test, int, int], str]] = dict(
    zip(FORMATS, (write_csv, write_foam_flat, write_foam_nested), strict=True)
)


def bytes_a_row(folder: Path, form: str, width: int) -> float:
    """Size of a row, from a short run that is thrown away."""
    test, rows = next(programme(1)), 400
    WRITERS[form](folder / "trial", test, rows, width)
    size = sum(file.stat().st_size for file in (folder / "trial").rglob("*") if file.is_file())
    shutil.rmtree(folder / "trial")
    return size / rows


def _write(job: tuple[Path, str, Test, int, int]) -> str:
    folder, form, test, rows, width = job
    return WRITERS[form](folder, test, rows, width)


def make(
    folder: Path,
    *,
    runs: int = 2000,
    mb: float = 0.5,
    form: str = "csv",
    width: int = 9,
    jobs: int = 1,
) -> int:
    """Write a campaign; gives its size in bytes.

    Half of the runs have a size between half of `mb` and `mb`, the others up to twice of it, so
    that a reader meets files of different sizes.
    """
    folder.mkdir(parents=True, exist_ok=True)
    row = bytes_a_row(folder, form, width)
    tests = list(programme(runs))
    sizes = [mb * 2 ** (2 * ((k * GOLDEN**3) % 1.0) - 1) for k in range(runs)]
    rows = [max(600, int(1e6 * size / row)) for size in sizes]
    work = [(folder, form, test, n, width) for test, n in zip(tests, rows, strict=True)]
    if jobs > 1:
        with ProcessPoolExecutor(jobs) as pool:
            files: Sequence[str] = list(pool.map(_write, work, chunksize=1))
    else:
        files = [_write(job) for job in work]
    head = (
        f'[campaign]\ntitle = "{runs} synthetic runs"\nkind = "captive"\n'
        f'forces = "hydrodynamic"\n\n[ship]\nname = "S175 model"\nL = {SHIP.L}\nB = {SHIP.B}\n'
        f"d = {SHIP.d}\nmass = {SHIP.mass}\nIzz = {SHIP.Izz}\nvolume = {SHIP.volume}\n\n"
        f"[water]\nrho = {WATER.rho}\ng = {WATER.g}\n\n"
    )
    if form != "csv":
        head += '[source]\nformat = "openfoam"\n\n'
    entries = [test.entry(file) for test, file in zip(tests, files, strict=True)]
    (folder / "campaign.toml").write_text(head + "\n".join(entries), encoding="utf-8")
    return sum(file.stat().st_size for file in (folder / "runs").rglob("*") if file.is_file())


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("folder", type=Path)
    parser.add_argument("--runs", type=int, default=2000)
    parser.add_argument("--mb", type=float, default=0.5, help="size of a usual run")
    parser.add_argument("--columns", type=int, default=9, help="columns of a CSV file, 7 or more")
    parser.add_argument("--format", choices=FORMATS, default="csv")
    parser.add_argument("--jobs", type=int, default=1, help="processes that write")
    given = parser.parse_args()
    size = make(
        given.folder, runs=given.runs, mb=given.mb, form=given.format, width=given.columns,
        jobs=given.jobs,
    )
    print(f"{given.runs} runs, {size / 1e6:.0f} MB in {given.folder}")


if __name__ == "__main__":
    main()
