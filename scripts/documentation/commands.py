"""Run the commands of a page and say what the page shows of them that they do not print.

    python -m scripts.documentation.commands docs/tutorial.md

Lines indented by four spaces count: those that begin with ``pmmkit`` are commands, the others,
up to the next commands, what these print: whole lines, however they are spaced, ``…`` for what is
left out. Takes minutes. The exit status is 1 if a line is not printed.
"""

from __future__ import annotations

import argparse
import re
import shlex
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from pmmkit.files import datasets_folder

FENCED = re.compile(r"^```.*?^```", re.M | re.S)


@dataclass(frozen=True)
class Step:
    """Commands of a page, and the lines that it shows of what they print."""

    commands: tuple[str, ...]
    shown: tuple[str, ...]


def steps(page: str) -> Iterator[Step]:
    """Commands in their order, each with what is shown up to the next ones.

    Examples
    --------
    >>> text = "Do\\n\\n    pmmkit ships\\n\\nand see\\n\\n    kvlcc2   tanker\\n    …\\n\\nSo.\\n"
    >>> list(steps(text))
    [Step(commands=('pmmkit ships',), shown=('kvlcc2 tanker',))]
    """
    commands: list[str] = []
    shown: list[str] = []
    for line in FENCED.sub("", page).splitlines():
        if not line.startswith("    ") or not line.strip():
            continue
        if line.startswith("    pmmkit "):
            if shown:
                yield Step(tuple(commands), tuple(shown))
                commands, shown = [], []
            commands.append(spaced(line))
        elif commands and "…" not in line:
            shown.append(spaced(line))
    if commands:
        yield Step(tuple(commands), tuple(shown))


def spaced(line: str) -> str:
    """A line with single spaces, without the mark of a list."""
    return " ".join(line.split()).removeprefix("- ")


def missing(step: Step, folder: Path) -> list[str]:
    """Lines that a step shows and does not print, run in a folder."""
    printed: set[str] = set()
    for command in step.commands:
        words = [sys.executable, "-m", "pmmkit", *shlex.split(command, comments=True)[1:]]
        done = subprocess.run(words, cwd=folder, capture_output=True, text=True, check=False)
        if done.returncode:
            return [f"{command}: exit status {done.returncode}: {done.stderr.strip()}"]
        printed |= {spaced(line) for line in done.stdout.splitlines()}
    return [line for line in step.shown if line not in printed]


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("page", type=Path)
    options = parser.parse_args()
    wrong = 0
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        (folder / "datasets").symlink_to(datasets_folder(), target_is_directory=True)
        for step in steps(options.page.read_text(encoding="utf-8")):
            print("\n".join(step.commands), flush=True)
            for line in missing(step, folder):
                wrong += 1
                print(f"   not printed: {line}", flush=True)
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
