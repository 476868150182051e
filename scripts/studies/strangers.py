"""From the files of twenty strangers to a turn of their hulls, by typed commands.

    python -m scripts.studies.strangers [--out FOLDER] [NAME ...]

Each folder is made by `scripts.datasets.strangers`, which shares no code with pmmkit. A person who
knows the tests types the commands and edits the lines of the draft below; nothing else is touched.
The table says how many commands, how many lines (those of ship and water, and others), how many
seconds, how many derivatives hold the truth in their 95 % interval, and the tactical diameter
beside that of the truth: with propeller and rudder estimated, with the 95 % interval of the
prediction, and with those of the ship stated.
"""

from __future__ import annotations

import argparse
import csv
import difflib
import json
import shutil
import subprocess
import sys
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, fields
from pathlib import Path
from typing import Any

from scripts.datasets.strangers.houses import GAUGES
from scripts.datasets.strangers.hulls import Hull, turn
from scripts.datasets.strangers.laboratories import FAST, FOLDERS, HULLS, SLOW, SPEEDS

Typed = Callable[[Sequence[str]], dict[str, Any]]
"""A command without its first word, to its JSON; raises where it fails."""

BALANCE = ('forces = "hydrodynamic"', 'forces = "balance"')
EDITS: Mapping[str, tuple[tuple[str, str], ...]] = {
    "heeled": (("# speed = ...", f"speed = {FAST}"),),
    "rotating_arm": (
        BALANCE,
        ("# speed = ...", f"speed = {SLOW}"),
        ("[source]", '[cfd]\nforces_in = "carriage"\n\n[source]'),
    ),
}
"""What a person changes in some drafts besides ship and water: found, put in its place."""
OPTIONS: Mapping[str, tuple[str, ...]] = {"heeled": ("--structure", "auto")}
"""What is typed behind `pmmkit reduce FOLDER`."""
SCREW = ("D", "t", "wp")
"""Values of the truth's `Steering` that belong to the propeller; others are the rudder's."""
SHIPS = 1000
"""Drawn for the interval of the predicted turn."""


@dataclass(frozen=True)
class Played:
    """How far one stranger came."""

    name: str
    commands: int
    ship_lines: int
    other_lines: int
    seconds: float
    inside: int
    asked: int
    missed: tuple[str, ...]
    open: tuple[str, ...]
    estimated: float
    interval: tuple[float, float]
    stated: float
    true: float
    heel_deg: float
    true_heel_deg: float
    words: tuple[str, ...] = field(default=(), repr=False)


def typed(words: Sequence[str]) -> dict[str, Any]:
    """A command as it is typed, in a process of its own."""
    done = subprocess.run(
        [sys.executable, "-m", "pmmkit", *words, "--json"],
        capture_output=True,
        text=True,
        check=False,
    )
    if done.returncode:
        raise RuntimeError(f"pmmkit {' '.join(words)}: {done.stderr}")
    found: dict[str, Any] = json.loads(done.stdout)
    return found


def particulars(hull: Hull) -> Iterator[tuple[str, str]]:
    """The lines of the ship: found in a draft, put in its place; the water is fresh."""
    for key in ("L", "B", "d", "mass", "Izz"):
        yield f"# {key} = ...", f"{key} = {getattr(hull, key)}"
    yield "# xG = 0.0 ", f"xG = {hull.xG} "
    if hull.rolls:
        yield "# zG = 0.0 ", f"zG = {hull.zG} "
        yield "# GM = ...", f"GM = {hull.GM}"
        yield "# Ix = ...", f"Ix = {hull.Ix}"


PLACES: tuple[str, str] = ("# side_gauges_x = ...", f"side_gauges_x = {list(GAUGES)}")
"""The line of two gauges, where a draft asks for their places."""


def filled(draft: str, changes: Iterator[tuple[str, str]] | Sequence[tuple[str, str]]) -> str:
    """A draft with what a person puts in; every place must be there."""
    for old, new in changes:
        if old not in draft:
            raise ValueError(f"the draft has no {old!r}")
        draft = draft.replace(old, new, 1)
    return draft


def edited_lines(before: str, after: str) -> int:
    """Lines that are new or changed; empty ones do not count."""
    changed = difflib.ndiff(before.splitlines(), after.splitlines())
    return sum(line.startswith("+ ") and bool(line[2:].strip()) for line in changed)


def play(name: str, place: Path, run: Typed = typed) -> Played:
    """Make the folder of a stranger and bring it to a turn.

    Parameters
    ----------
    name : str
        One of `FOLDERS`.
    place : Path
        An empty folder.
    run : callable
        Types a command.
    """
    hull, speed = HULLS[name], SPEEDS[name]
    folder, reduced = place / name, place / f"{name}-reduced"
    FOLDERS[name](folder)
    began = time.perf_counter()
    run(["inspect", str(folder)])
    run(["new-campaign", str(folder)])
    file = folder / "campaign.toml"
    draft = file.read_text(encoding="utf-8")
    with_ship = filled(draft, [item for item in (*particulars(hull), PLACES) if item[0] in draft])
    whole = filled(with_ship, EDITS.get(name, ()))
    file.write_text(whole, encoding="utf-8")
    run(["check", str(folder)])
    told = run(["reduce", str(folder), "--out", str(reduced), *OPTIONS.get(name, ())])
    model = str(reduced / "model.toml")
    sail = ["--speed", str(speed), "--rudder-deg", "35"]
    first = run(["simulate", model, *sail, "--out", str(place / f"{name}-turn")])
    seconds = time.perf_counter() - began
    drawn = ["--ships", str(SHIPS), "--out", str(place / f"{name}-uncertainty")]
    spread = run(["uncertainty", model, *sail, *drawn])["metrics"]["tactical_diameter_L"]
    stated = str(place / f"{name}-stated.toml")
    run(["model", "set", model, *steering(hull), "--because", "as built", "-o", stated])
    second = run(["simulate", stated, *sail, "--out", str(place / f"{name}-stated-turn")])
    inside, missed, open_ = held(hull, reduced / "derivatives.csv")
    true = turn(hull, speed)
    return Played(
        name=name,
        commands=5,
        ship_lines=edited_lines(draft, with_ship),
        other_lines=edited_lines(with_ship, whole),
        seconds=seconds,
        inside=inside,
        asked=inside + len(missed),
        missed=tuple(missed),
        open=tuple(open_),
        estimated=first["tactical_diameter_L"],
        interval=(spread["low"], spread["high"]),
        stated=second["tactical_diameter_L"],
        true=true.tactical_diameter,
        heel_deg=second.get("heel_steady_deg", 0.0),
        true_heel_deg=abs(true.heel_deg),
        words=tuple(told["model_lacks"]),
    )


def steering(hull: Hull) -> list[str]:
    """The true propeller, of constant wake, and rudder, as `pmmkit model set` takes them."""
    own = hull.steering
    found = [f"propeller.{name}={value}" for name, value in zip(KT, own.kt, strict=True)]
    found += [f"propeller.C2_{side}=1" for side in ("positive", "negative")]
    for item in fields(own):
        value = getattr(own, item.name)
        if item.name in SCREW:
            found.append(f"propeller.{item.name}={value}")
        elif item.name == "gamma":
            found += [f"rudder.gamma_{side}={value}" for side in ("positive", "negative")]
        elif item.name != "kt":
            found.append(f"rudder.{item.name}={value}")
    return found


KT = ("kt0", "kt1", "kt2")


def held(hull: Hull, file: Path) -> tuple[int, list[str], list[str]]:
    """How many derivatives hold the truth in their interval, which do not, which have none."""
    with file.open(encoding="utf-8") as stream:
        rows = {row["derivative"]: row for row in csv.DictReader(stream)}
    inside, missed, open_ = 0, [], []
    for name, true in hull.truth.items():
        row = rows.get(name[0] + name[1:].replace("f", "phi"), {})
        if not row.get("value"):
            open_.append(name)
            continue
        value, low, high = (float(row[key]) for key in ("value", "ci_low", "ci_high"))
        if low <= true <= high:
            inside += 1
        else:
            missed.append(f"{name} {(value - true) / (0.5 * (high - low)):+.1f} half-widths")
    return inside, missed, open_


def table(found: Sequence[Played]) -> str:
    """What came out, a line a stranger."""
    head = "folder         commands  ship  other    s  inside  TD/L estimated [95 %]"
    lines = [head + "       stated  truth   heel / truth"]
    for each in found:
        low, high = each.interval
        heel = f"{each.heel_deg:.2f} / {each.true_heel_deg:.2f}" if each.true_heel_deg else ""
        lines.append(
            f"{each.name:14}{each.commands:9}{each.ship_lines:6}{each.other_lines:7}"
            f"{each.seconds:5.0f}{each.inside:5}/{each.asked:<3}{each.estimated:10.2f}"
            f" [{low:.2f}, {high:.2f}]{each.stated:15.3f}{each.true:7.3f}   {heel}".rstrip()
        )
        lines += [f"    outside: {text}" for text in each.missed]
        if each.open:
            lines.append(f"    not excited: {', '.join(each.open)}")
    return "\n".join(lines)


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("names", nargs="*", metavar="NAME", help=f"of {', '.join(FOLDERS)}")
    parser.add_argument("--out", type=Path, default=Path("strangers"))
    asked = parser.parse_args()
    unknown = set(asked.names) - set(FOLDERS)
    if unknown:
        parser.error(f"not known: {', '.join(sorted(unknown))}; there are {', '.join(FOLDERS)}")
    found = []
    for name in asked.names or FOLDERS:
        place = asked.out / name
        shutil.rmtree(place, ignore_errors=True)
        place.mkdir(parents=True)
        found.append(play(name, place))
        print(table(found[-1:]), flush=True)
    print()
    print(table(found))


if __name__ == "__main__":
    main()
