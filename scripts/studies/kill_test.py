"""Kill commands at random times and look at what is left: whole old output, whole new one, nothing.

    python -m scripts.studies.kill_test [--kills 200] [--runs 160] [--only reduce ...]

Each command is started, killed with SIGKILL (on Windows: terminated) at a random time of its usual
duration, and what lies in its folder is looked at: every file that a reader could take for a result
must be whole, and all of them the old or all the new ones. Hidden files that are left are counted.
Then the same command is let finish, and must give what it gives undisturbed.
"""

from __future__ import annotations

import argparse
import hashlib
import random
import shutil
import subprocess
import sys
import tempfile
import time
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

from scripts.datasets.make_large import make

SAVE = (
    "import sys, pmmkit as pk; from pmmkit.campaigns import save_campaign; "
    "save_campaign(pk.open_campaign(sys.argv[1]), sys.argv[2])"
)
Content = Mapping[str, str]
"""Names of files in a folder and the hashes of their bytes."""


@dataclass(frozen=True)
class Job:
    """A command that writes into a folder.

    Parameters
    ----------
    name : str
        What it is called in the table.
    command : callable
        Its arguments, from the folder that it writes to.
    before : callable
        Puts into that folder what is there before it starts.
    """

    name: str
    command: Callable[[Path], Sequence[str]]
    before: Callable[[Path], None] | None = None


@dataclass
class Tally:
    """What was found after the kills of one command.

    `states`: how often which state. `wrong`: what must not be. `hidden`: kills after which parts of
    files lay there under a hidden name.
    """

    states: Counter[str] = field(default_factory=Counter)
    wrong: list[str] = field(default_factory=list)
    hidden: int = 0


def content(folder: Path) -> Content:
    """Visible files of a folder; hidden ones are not results."""
    return {
        file.relative_to(folder).as_posix(): hashlib.sha256(file.read_bytes()).hexdigest()
        for file in sorted(folder.rglob("*"))
        if file.is_file() and not is_hidden(file.relative_to(folder))
    }


def is_hidden(file: Path) -> bool:
    """Whether a file, or a folder that holds it, has a name that begins with a dot."""
    return any(part.startswith(".") for part in file.parts)


def jobs(campaign: Path, base: Path) -> list[Job]:
    """The commands that are killed; a model of the campaign is in the folder `base`."""
    pmmkit = (sys.executable, "-m", "pmmkit")
    tests, model = str(campaign), str(base / "model.toml")

    def writes(
        *words: str, into: str = "--out", name: str = "out"
    ) -> Callable[[Path], Sequence[str]]:
        return lambda folder: [*pmmkit, *words, into, str(folder / name)]

    def old(folder: Path) -> None:
        (folder / "out").mkdir()
        for name in ("derivatives.csv", "report.html"):
            (folder / "out" / name).write_text(f"the old {name}", encoding="utf-8")

    reduce = writes("reduce", tests, "--structure", "cubic", "--jobs", "2")
    add = ("add", model, "cubic_hull_terms", "--fit", tests, "--no-figures")
    return [
        Job("reduce", reduce),
        Job("reduce over old results", reduce, old),
        Job("add", lambda folder: [*writes(*add)(folder), "-o", str(folder / "model.toml")]),
        Job("diagnose", writes("diagnose", model, tests)),
        Job("plan", writes("plan", model, tests)),
        Job(
            "save_campaign",
            lambda folder: [sys.executable, "-c", SAVE, tests, str(folder / "saved.h5")],
        ),
    ]


def run(command: Sequence[str], kill_after: float | None = None) -> bool:
    """Run a command, or kill it after some seconds; whether it ended by itself and well."""
    process = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE)
    try:
        _, said = process.communicate(timeout=kill_after)
    except subprocess.TimeoutExpired:
        process.kill()
        process.communicate()
        return False
    if process.returncode:
        raise RuntimeError(f"{' '.join(command)} failed:\n{said.decode(errors='replace')}")
    return True


def examine(found: Content, old: Content, new: Content) -> tuple[str, list[str]]:
    """What the state of a folder is, and what of it must not be."""
    if found in (new, old):
        return ("new" if found == new else "old"), []
    strange = [
        f"{name} is neither old nor new"
        for name, digest in found.items()
        if digest not in (old.get(name), new.get(name))
    ]
    return "neither", strange or ["some files are old, some new"]


def try_job(job: Job, kills: int, rng: random.Random) -> Tally:
    """Kill a command so many times."""
    tally = Tally()
    with tempfile.TemporaryDirectory(ignore_cleanup_errors=True) as name:
        place = Path(name) / "work"

        def fresh() -> Content:
            shutil.rmtree(place, ignore_errors=True)
            place.mkdir()
            if job.before is not None:
                job.before(place)
            return content(place)

        old = fresh()
        started = time.monotonic()
        run(job.command(place))
        usual = time.monotonic() - started
        new = content(place)
        for _ in range(kills):
            fresh()
            ended = run(job.command(place), kill_after=rng.uniform(0.0, 1.1 * usual))
            state, strange = examine(content(place), old, new)
            tally.states["done before the kill" if ended else state] += 1
            tally.wrong += strange
            tally.hidden += any(is_hidden(file.relative_to(place)) for file in place.rglob("*"))
            run(job.command(place))
            if content(place) != new:
                differ = {name for name, _ in content(place).items() ^ new.items()}
                tally.wrong.append(f"afterwards {sorted(differ)} differ")
            left = [path.name for path in place.iterdir() if path.name.endswith("-resume")]
            tally.wrong += [f"{name} was left behind" for name in left]
    return tally


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--kills", type=int, default=200, help="kills in all")
    parser.add_argument("--runs", type=int, default=160, help="runs of the campaign")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--only", nargs="*", help="names of commands")
    given = parser.parse_args()
    rng = random.Random(given.seed)
    with tempfile.TemporaryDirectory() as name:
        make(Path(name), runs=given.runs, mb=0.1)
        base = Path(name) / "base"
        reduction = ["reduce", name, "--structure", "linear", "--fn", "pooled", "--out", str(base)]
        run([sys.executable, "-m", "pmmkit", *reduction])
        chosen = [job for job in jobs(Path(name), base) if job.name in (given.only or [job.name])]
        each = -(-given.kills // len(chosen))
        tallies = {job.name: try_job(job, each, rng) for job in chosen}
    wrong = [f"{job}: {text}" for job, tally in tallies.items() for text in tally.wrong]
    for job, tally in tallies.items():
        states = ", ".join(f"{state} {count}" for state, count in tally.states.most_common())
        print(
            f"{job:26} {sum(tally.states.values()):4d} kills: {states}; "
            f"parts left {tally.hidden}; wrong {len(tally.wrong)}"
        )
    print("\n".join(wrong) or "All was old or all new, and every command finished afterwards.")
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
