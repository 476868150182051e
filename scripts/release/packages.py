"""Wheel and sdist: built, looked into, installed in empty environments and tried.

    python -m scripts.release.packages [--out dist] [--python PYTHON …]

Builds both, says what is missing in the wheel or has no business there, installs each of them into
an environment of its own for each Python that is named (else this one), and runs the commands of
``TRIALS`` there in an empty folder. Beside them it puts ``recipe.yaml``, what conda-forge needs.
Asks for ``build`` (the group ``release``) and the package registry.
"""

from __future__ import annotations

import argparse
import os
import shlex
import subprocess
import sys
import tempfile
import time
import zipfile
from collections.abc import Iterable
from pathlib import Path
from typing import Final

from scripts.release.recipe import recipe_of

ROOT: Final = Path(__file__).resolve().parents[2]
TRIALS: Final = (
    ("pmmkit --help", ""),
    ("pmmkit inspect {datasets}/s175", ""),
    ("pmmkit reduce {datasets}/s175 --parts s175-3dof --out reduced", "reduced/report.html"),
    (
        "pmmkit simulate reduced/model.toml --rudder-deg 35 --speed 8 --out turn",
        "turn/metrics.json",
    ),
    ("pmmkit report {datasets}/s175 --standard ittc -o tests.html", "tests.html"),
    ("pmmkit imo kvlcc2 --speed 8 --out imo", "imo/imo_form.html"),
    ("pmmkit seakeeping tanker-320 --speeds 8 --headings 180 --no-figures --out waves", "waves"),
    ("pmmkit export kvlcc2 --to fmu -o kvlcc2.fmu", "kvlcc2.fmu"),
    ("pmmkit demo", "pmmkit-demo/report.html"),
)
"""Commands that need what is not Python in the wheel, each with a file that it writes."""


def build(folder: Path) -> tuple[Path, Path]:
    """Wheel and sdist of this tree, in a folder."""
    run([sys.executable, "-m", "build", "--outdir", str(folder), str(ROOT)])
    (wheel,) = folder.glob("*.whl")
    (sdist,) = folder.glob("*.tar.gz")
    return wheel, sdist


def files(folder: str) -> Iterable[str]:
    """Files of a folder of the repository that belong into the wheel."""
    for path in (ROOT / folder).rglob("*"):
        if path.is_file() and "__pycache__" not in path.parts:
            yield path.relative_to(ROOT).as_posix()


def strangers(wheel: Path) -> list[str]:
    """What the wheel lacks, and what it has too much."""
    with zipfile.ZipFile(wheel) as opened:
        found = {name for name in opened.namelist() if ".dist-info/" not in name}
    wanted = {*files("pmmkit"), *(f"pmmkit/{name}" for name in files("datasets"))}
    return [
        *(f"{name} is missing in {wheel.name}" for name in sorted(wanted - found)),
        *(f"{name} has no business in {wheel.name}" for name in sorted(found - wanted)),
    ]


def tried(package: Path, python: str) -> list[str]:
    """What goes wrong when a package is installed in an empty environment and used."""
    with tempfile.TemporaryDirectory() as name:
        home, empty = Path(name) / "environment", Path(name) / "empty"
        empty.mkdir()
        run([python, "-m", "venv", str(home)])
        programs = home / ("Scripts" if sys.platform == "win32" else "bin")
        own = str(programs / "python")
        run([own, "-m", "pip", "install", "--quiet", "--disable-pip-version-check", str(package)])
        run([own, "-m", "pip", "check"])
        asked = "from pmmkit.files import datasets_folder; print(datasets_folder())"
        environment = {key: value for key, value in os.environ.items() if key != "PYTHONPATH"}
        place = {"cwd": empty, "env": environment | {"PMMKIT_CACHE": str(Path(name) / "cache")}}
        datasets = Path(subprocess.check_output([own, "-c", asked], text=True, **place).strip())
        # The temporary folder may be a link (macOS) or a short name (Windows).
        own_data = home.resolve() in datasets.resolve().parents
        wrong = [] if own_data else [f"its datasets are {datasets}"]
        for command, written in TRIALS:
            words = shlex.split(command.format(datasets=datasets.as_posix()))
            done = subprocess.run(
                [str(programs / words[0]), *words[1:]], capture_output=True, text=True, **place
            )
            if done.returncode or not (empty / written).exists():
                wrong.append(f"{command}: exit status {done.returncode}: {done.stderr.strip()}")
    return [f"{package.name}: {text}" for text in wrong]


def run(command: list[str]) -> None:
    """Run a program whose failure ends everything."""
    subprocess.run(command, check=True, stdout=subprocess.DEVNULL)


def main() -> int:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--out", type=Path, default=ROOT / "dist", help="folder of the packages")
    parser.add_argument("--python", nargs="+", default=[sys.executable], help="Pythons to try")
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as name:
        fresh = build(Path(name))
        wrong = strangers(fresh[0])
        for python in options.python:
            for package in fresh:
                started = time.monotonic()
                found = tried(package, python)
                told = "; ".join(found) or "all commands ran"
                took = f"{time.monotonic() - started:.0f} s"
                print(f"{python}: {package.name}: {took}, {told}", flush=True)
                wrong += found
        options.out.mkdir(parents=True, exist_ok=True)
        for package in fresh:
            (options.out / package.name).write_bytes(package.read_bytes())
        text = recipe_of(fresh[1], ROOT / "pyproject.toml")
        (options.out / "recipe.yaml").write_text(text, encoding="utf-8")
    print("\n".join(wrong or [f"Both are in {options.out}, with recipe.yaml."]))
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
