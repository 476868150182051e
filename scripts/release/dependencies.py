"""Dependencies at a release: lower bounds that are true, versions with hashes, a bill of materials.

    python -m scripts.release.dependencies lowest [options of pytest]
    python -m scripts.release.dependencies files [FOLDER]

``lowest`` makes an environment of its own with the lowest versions that pyproject.toml allows and
runs tests there: those that are fast, or those that are named. ``files`` writes constraints.txt
(every package with its version and hashes, for ``pip install --require-hashes -r``) and sbom.json
(CycloneDX) to a folder, ``dist`` if none is named. The tools (uv, cyclonedx-bom: the group
``release`` of pyproject.toml) are installed into an environment that is thrown away.
"""

from __future__ import annotations

import subprocess
import sys
import tempfile
import tomllib
from collections.abc import Callable, Sequence
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
PROJECT = ROOT / "pyproject.toml"
NOT_FOR_USERS = ("mypy", "ruff", "import-linter", "pandas-stubs", "fmpy")
"""Tools of the group ``dev`` that no test needs, or that ask for newer packages than we do."""


def lowest(options: Sequence[str], tools: Path) -> int:
    """Install the lowest versions and run tests with them; the status of pytest."""
    python = _environment(tools.parent / "lowest")
    wanted = [item for item in _group("dev") if not item.startswith(NOT_FOR_USERS)]
    install = [_program(tools, "uv"), "pip", "install", "--python", str(python)]
    _run([*install, "--resolution", "lowest-direct", "--editable", str(ROOT), *wanted])
    chosen = list(options) or ["-m", "not slow", "-n", "auto"]
    return subprocess.call([str(python), "-m", "pytest", "-q", *chosen], cwd=ROOT)


def files(options: Sequence[str], tools: Path) -> int:
    """Write constraints.txt and sbom.json."""
    folder = Path(options[0] if options else ROOT / "dist").resolve()
    folder.mkdir(parents=True, exist_ok=True)
    pinned, bill = folder / "constraints.txt", folder / "sbom.json"
    compiled = [_program(tools, "uv"), "pip", "compile", "--quiet", "--upgrade", "--universal"]
    _run([*compiled, "--generate-hashes", "--no-header", "-o", str(pinned), str(PROJECT)])
    described = [_program(tools, "cyclonedx-py"), "requirements", "--output-reproducible"]
    about = ["--pyproject", str(PROJECT), "--mc-type", "library", "--of", "JSON", "-o", str(bill)]
    _run([*described, *about, str(pinned)])
    print(f"{pinned}\n{bill}")
    return 0


def _environment(folder: Path) -> Path:
    """A fresh environment; gives its Python."""
    _run([sys.executable, "-m", "venv", str(folder)])
    return Path(_program(folder, "python"))


def _program(folder: Path, name: str) -> str:
    """Path of a program in an environment."""
    windows = sys.platform == "win32"
    return str(folder / ("Scripts" if windows else "bin") / (f"{name}.exe" if windows else name))


def _group(name: str) -> list[str]:
    """What a group of pyproject.toml asks for."""
    content = tomllib.loads(PROJECT.read_text(encoding="utf-8"))
    return list(content["dependency-groups"][name])


def _run(command: Sequence[str]) -> None:
    subprocess.run(command, cwd=ROOT, check=True)


TASKS: dict[str, Callable[[Sequence[str], Path], int]] = {"lowest": lowest, "files": files}


def main(arguments: Sequence[str]) -> int:
    """Run one of the tasks with its tools at hand."""
    if not arguments or arguments[0] not in TASKS:
        print(__doc__)
        return 2
    with tempfile.TemporaryDirectory() as folder:
        tools = Path(folder) / "tools"
        python = _environment(tools)
        _run([str(python), "-m", "pip", "install", "--quiet", *_group("release")])
        return TASKS[arguments[0]](arguments[1:], tools)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
