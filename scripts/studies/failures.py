"""What goes wrong around a command, and what is left of it: a table of failures.

    python -m scripts.studies.failures [--only kills disk ...] [--kills 20] [--runs 40]

Each row is a command under a circumstance: how often tried, held, lost, what was left or said, and
the seconds of processor and the memory of the worst. Held is: the results of an undisturbed call to
the bit, or one line that says what is wrong and the old files, nothing between. Circumstances that
this machine cannot make (no tmpfs) are told as not tried.
"""

from __future__ import annotations

import argparse
import functools
import os
import random
import subprocess
import sys
import tempfile
import threading
import time
import zipfile
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import IO

from pmmkit.presentation import aligned
from scripts.datasets.campaign_text import S175
from scripts.datasets.make_large import make
from scripts.studies.cluster import cluster
from scripts.studies.cluster import kill as kill_group
from scripts.studies.kill_test import Content, content, jobs, try_job

MB = 1 << 20
BOMB_MB = 300
"""A command may take this memory and three times its largest file."""
GROWTH_MB = 20.0
"""Memory that a process may gain over the second half of its calls: pages of the allocator."""
TURNED_CLOCK = """
import time
real, calls = time.time, iter(range(10**9))
time.time = lambda: real() - (86400.0 if next(calls) > 50 else 0.0)
"""
MEMORY = """
import resource, sys
import pmmkit as pk

def size():
    return int(open("/proc/self/statm").read().split()[1]) * resource.getpagesize() / 2**20

campaign, model, each, count = sys.argv[1], sys.argv[2], sys.argv[3], int(sys.argv[4])
tests = pk.open_campaign(campaign)
for number in range(count):
    if each == "diagnose":
        pk.diagnose(pk.load_model(model), tests)
    else:
        pk.simulate(pk.load_model(model), "turning", speed=1.5, rudder_deg=10.0 + number % 26)
    if number == count // 2:
        early = size()
print(size() - early)
"""


@dataclass(frozen=True)
class Done:
    """A command that has ended: its status, its words, seconds of processor, most memory [MB]."""

    status: int
    said: str
    seconds: float
    peak: float


@dataclass(frozen=True)
class Row:
    """Of the table; `tried` 0: this machine cannot make the circumstance."""

    name: str
    tried: int
    held: int
    note: str = ""
    seconds: float = 0.0
    peak: float = 0.0


@dataclass(frozen=True)
class Bench:
    """A campaign, a linear model of it, and what the cubic reduction gives undisturbed."""

    campaign: Path
    base: Path
    usual: Content

    @property
    def reduce(self) -> tuple[str, ...]:
        """The command that most rows disturb; it writes to `out` where it is typed."""
        return ("reduce", str(self.campaign), "--structure", "cubic", "--jobs", "2", "--out", "out")


def run(
    words: Sequence[str],
    place: Path,
    env: Mapping[str, str | None] | None = None,
    python: Sequence[str] = ("-m", "pmmkit"),
) -> Done:
    """A command typed in a folder; variables that are None are not set."""
    with tempfile.TemporaryFile() as heard:
        out = subprocess.DEVNULL if python[0] == "-m" else heard
        process = start(words, place, env, python, out=out, heard=heard)
        _, status, used = os.wait4(process.pid, 0)
        process.returncode = os.waitstatus_to_exitcode(status)
        heard.seek(0)
        said = heard.read().decode(errors="replace").strip()
    seconds, peak = used.ru_utime + used.ru_stime, used.ru_maxrss / 1024
    return Done(process.returncode, said, seconds, peak)


def start(
    words: Sequence[str],
    place: Path,
    env: Mapping[str, str | None] | None = None,
    python: Sequence[str] = ("-m", "pmmkit"),
    *,
    out: int | IO[bytes] = subprocess.DEVNULL,
    heard: int | IO[bytes] = subprocess.DEVNULL,
) -> subprocess.Popen[bytes]:
    """Begin a command in a folder; `out` takes its standard output, `heard` its errors."""
    setting = {**os.environ, "PYTHONPATH": str(Path(__file__).parents[2]), **(env or {})}
    return subprocess.Popen(
        [sys.executable, *python, *words],
        cwd=place,
        env={name: value for name, value in setting.items() if value is not None},
        stdout=out,
        stderr=heard,
    )


def row(name: str, done: Sequence[tuple[Done, bool]], note: str = "") -> Row:
    """A row of commands and whether each held; what the first that did not said."""
    lost = [item for item, held in done if not held]
    return Row(
        name,
        len(done),
        len(done) - len(lost),
        f"status {lost[0].status}: {lost[0].said[-200:]}" if lost else note,
        max(item.seconds for item, _ in done),
        max(item.peak for item, _ in done),
    )


@functools.cache
def folder() -> Path:
    """Where places of commands are made; removed at the end by `main`."""
    return Path(tempfile.mkdtemp(prefix="failures-"))


def empty() -> Path:
    """A new empty folder."""
    return Path(tempfile.mkdtemp(dir=folder()))


def refused(done: Done, place: Path, word: str) -> bool:
    """Whether a command failed in few words, without traceback or visible file."""
    error = done.said.partition("pmmkit: ")[2]
    plain = "Traceback" not in done.said and len(error.splitlines()) <= 3
    return done.status != 0 and plain and word in error and not content(place)


def kills(bench: Bench, count: int) -> Iterator[Row]:
    """SIGKILL at random times."""
    rng = random.Random(0)
    for job in jobs(bench.campaign, bench.base):
        began = sum(os.times()[2:4])
        tally = try_job(job, count, rng)
        states = ", ".join(f"{state} {number}" for state, number in tally.states.most_common())
        note = "; ".join([states, f"parts left {tally.hidden}", *tally.wrong])
        seconds = sum(os.times()[2:4]) - began
        yield Row(f"kill {job.name}", count, max(count - len(tally.wrong), 0), note, seconds)
    before = content(bench.campaign)
    place, held = empty(), 0
    serve = ("workbench", str(bench.campaign), str(bench.base / "model.toml"), "--out", "out")
    for _ in range(count):
        process = start([*serve, "--no-browser"], place)
        time.sleep(rng.uniform(0.2, 8.0))
        process.kill()
        process.wait()
        held += content(bench.campaign) == before
    done = run([*serve, "--save", "page.html"], place)
    yield Row(
        "kill workbench",
        count + 1,
        held + (done.status == 0),
        done.said[-200:] if done.status else "campaign as before; it starts again",
        done.seconds,
        done.peak,
    )


def disk(bench: Bench, _: int) -> Iterator[Row]:
    """No space, no right to write, nobody to read."""
    for name, option, word in (
        ("full disk", "size=64k", "No space left"),
        ("read-only folder", "ro", "no permission"),
    ):
        place = empty()
        mount = ["mount", "-t", "tmpfs", "-o", option, "tmpfs", str(place)]
        if subprocess.run(mount, capture_output=True, check=False).returncode:
            yield Row(name, 0, 0, "no tmpfs here")
            continue
        try:
            done = run(bench.reduce, place)
            said = done.said.partition("pmmkit: ")[2]
            yield row(name, [(done, refused(done, place, word))], said)
        finally:
            subprocess.run(["umount", str(place)], check=True)
    place = empty()
    with os.fdopen(os.open(os.devnull, os.O_RDONLY), "rb") as unwritable:
        process = start(bench.reduce, place, out=unwritable, heard=subprocess.PIPE)
        said = process.communicate()[1].decode(errors="replace")
    same = content(place / "out") == bench.usual
    held = same and process.returncode != 0 and "Traceback" not in said
    yield Row("standard output that cannot be written", 1, int(held), said.strip()[-200:])


def surroundings(bench: Bench, _: int) -> Iterator[Row]:
    """What must not move a bit of the results."""
    clock = empty()
    (clock / "sitecustomize.py").write_text(TURNED_CLOCK, encoding="utf-8")
    path = f"{clock}{os.pathsep}{Path(__file__).parents[2]}"
    cases: Mapping[str, Sequence[Mapping[str, str | None]]] = {
        "no HOME": [{"HOME": None, "XDG_CACHE_HOME": None}, {"HOME": "/nowhere"}],
        "locale C, UTF-16 output": [
            {"LC_ALL": "C", "PYTHONUTF8": "0", "PYTHONCOERCECLOCALE": "0"},
            {"PYTHONIOENCODING": "utf-16"},
            {"PYTHONIOENCODING": "cp1252"},
        ],
        "clock a day back while it runs": [{"PYTHONPATH": path}],
        "threads 1 and 4": [{"OPENBLAS_NUM_THREADS": x, "OMP_NUM_THREADS": x} for x in "14"],
        "hash seeds 0, 1, 77": [{"PYTHONHASHSEED": seed} for seed in ("0", "1", "77")],
    }
    for name, settings in cases.items():
        tried = []
        for env in settings:
            place = empty()
            done = run(bench.reduce, place, env)
            tried.append((done, done.status == 0 and content(place / "out") == bench.usual))
        yield row(name, tried, "the same to the bit")


def side_by_side(bench: Bench, _: int) -> Iterator[Row]:
    """Two that write one folder; workers and scheduler that are gone."""
    place, tried = empty(), []
    for _ in range(3):
        first = start(bench.reduce, place)
        done = run(bench.reduce, place)
        held = first.wait() == 0 and done.status == 0 and content(place / "out") == bench.usual
        tried.append((done, held))
    yield row("two writers of one folder", tried, "the same to the bit")
    for name in ("worker", "scheduler"):
        same, tried = 0, []
        for seconds in (1.0, 3.0, 5.0, 7.0):
            place = empty()
            with cluster(2) as own:
                victim = own.workers[0] if name == "worker" else own.scheduler
                timer = threading.Timer(seconds, kill_group, [victim])
                timer.start()
                words = [x for x in bench.reduce if x not in ("--jobs", "2")]
                done = run([*words, "--scheduler", own.address], place)
                timer.join()
            finished = done.status == 0 and content(place / "out") == bench.usual
            same += finished
            # Before the command has found it a scheduler that is gone is no scheduler.
            gone = name == "scheduler" and refused(done, place, "No dask scheduler")
            tried.append((done, finished or gone))
        note = f"the same to the bit {same}, told that there is none {len(tried) - same}"
        yield row(f"dask {name} killed", tried, note)


def bombs(*_: object) -> Iterator[Row]:
    """Small files that would become large, or lead elsewhere."""
    makers: Mapping[str, Callable[[Path], str]] = {
        "zip of 2 GB of zeros": _zip,
        "entities of a workbook": _entities,
        "HDF5 link to another file": _link,
        "HDF5 values of a terabyte": _terabyte,
        "TDMS of 2^60 values": _tdms,
    }
    for name, maker in makers.items():
        place = empty()
        file = maker(place)
        text = (
            '[campaign]\ntitle = "bomb"\n' + S175 + '[[runs]]\nid = "SD"\ntest = "static_drift"\n'
            f'speed = 1.5\ndrift_deg = 8.0\nfile = "{file}"\n'
        )
        if file != "campaign.zip":
            (place / "campaign.toml").write_text(text, encoding="utf-8")
        made = content(place)
        done = run(["check", file if file == "campaign.zip" else "."], place)
        held = done.status != 0 and "Traceback" not in done.said and content(place) == made
        most = BOMB_MB + 3 * (place / file).stat().st_size / MB
        yield row(name, [(done, held and done.peak < most)], done.said.splitlines()[0][-160:])


def _zip(place: Path) -> str:
    with zipfile.ZipFile(place / "campaign.zip", "w", zipfile.ZIP_DEFLATED) as packed:
        packed.writestr("campaign.toml", '[campaign]\ntitle = "bomb"\n' + S175)
        with packed.open("SD.csv", "w", force_zip64=True) as stream:
            for _ in range(2048):
                stream.write(bytes(MB))
    return "campaign.zip"


def _entities(place: Path) -> str:
    import openpyxl

    book = openpyxl.Workbook()
    book.active.append(["t", "X", "Y", "N"])
    book.save(place / "plain.xlsx")
    grown = "".join(f'<!ENTITY a{n} "{f"&a{n - 1};" * 10}">' for n in range(1, 10))
    head = f'<!DOCTYPE worksheet [<!ENTITY a0 "lol">{grown}]>'
    with (
        zipfile.ZipFile(place / "plain.xlsx") as plain,
        zipfile.ZipFile(place / "SD.xlsx", "w", zipfile.ZIP_DEFLATED) as packed,
    ):
        for item in plain.infolist():
            text = plain.read(item)
            if "sheet1" in item.filename:
                text = head.encode() + text.replace(b">X<", b">&a9;<").replace(b">t<", b">&a9;<")
            packed.writestr(item.filename, text)
    (place / "plain.xlsx").unlink()
    return "SD.xlsx"


def _link(place: Path) -> str:
    import h5py

    with h5py.File(place / "elsewhere.h5", "w") as other:
        other["t"] = [0.0, 1.0, 2.0]
    with h5py.File(place / "SD.h5", "w") as file:
        for name in "tXYN":
            file[name] = h5py.ExternalLink(str(place / "elsewhere.h5"), "/t")
    return "SD.h5"


def _terabyte(place: Path) -> str:
    import h5py

    with h5py.File(place / "SD.h5", "w") as file:
        for name in "tXYN":
            file.create_dataset(
                name, shape=(1 << 37,), chunks=(1 << 20,), dtype="f8", compression=9
            )
    return "SD.h5"


def _tdms(place: Path) -> str:
    import numpy as np
    from nptdms import ChannelObject, TdmsWriter

    with TdmsWriter(place / "SD.tdms") as writer:
        writer.write_segment([ChannelObject("g", name, np.arange(64.0)) for name in "tXYN"])
    whole = (place / "SD.tdms").read_bytes()
    count = (64).to_bytes(8, "little")
    (place / "SD.tdms").write_bytes(whole.replace(count, (1 << 60).to_bytes(8, "little")))
    return "SD.tdms"


def memory(bench: Bench, _: int) -> Iterator[Row]:
    """Many calls in one process."""
    model = str(bench.base / "model.toml")
    for each, count in (("diagnose", 50), ("simulate", 2000)):
        words = [str(bench.campaign), model, each, str(count)]
        done = run(words, empty(), python=("-c", MEMORY))
        grown = float(done.said.splitlines()[-1]) if done.status == 0 else float("inf")
        note = f"grows by {grown:.1f} MB over the second half"
        yield row(f"{count} × {each} in one process", [(done, grown < GROWTH_MB)], note)


TRIALS: Mapping[str, Callable[[Bench, int], Iterator[Row]]] = {
    "kills": kills,
    "disk": disk,
    "surroundings": surroundings,
    "side_by_side": side_by_side,
    "bombs": bombs,
    "memory": memory,
}


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--only", nargs="+", default=list(TRIALS), choices=list(TRIALS))
    parser.add_argument("--kills", type=int, default=20, help="kills of each command")
    parser.add_argument("--runs", type=int, default=40, help="runs of the campaign")
    given = parser.parse_args()
    with tempfile.TemporaryDirectory() as name:
        os.environ["TMPDIR"] = name
        tempfile.tempdir = name
        campaign = Path(name) / "tests"
        make(campaign, runs=given.runs, mb=0.1)
        place = empty()
        bench = Bench(campaign, place / "base", {})
        linear = ["linear" if x == "cubic" else "base" if x == "out" else x for x in bench.reduce]
        for words in (linear, bench.reduce):
            begun = run(words, place)
            if begun.status:
                raise RuntimeError(begun.said)
        bench = Bench(campaign, place / "base", content(place / "out"))
        rows = []
        for trial in given.only:
            for item in TRIALS[trial](bench, given.kills):
                rows.append(item)
                print(f"{item.name}: {' '.join(item.note.split())}", flush=True)
    cells = [
        [
            item.name,
            str(item.tried or "not"),
            str(item.held),
            str(item.tried - item.held),
            f"{item.seconds:.1f}",
            f"{item.peak:.0f}" if item.peak else "",
        ]
        for item in rows
    ]
    print(aligned(["what", "tried", "held", "lost", "s", "MB"], cells))
    return int(any(item.held < item.tried for item in rows))


if __name__ == "__main__":
    sys.exit(main())
