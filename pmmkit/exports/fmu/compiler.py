"""The sources of an FMU as a library for this machine."""

from __future__ import annotations

import os
import platform
import shlex
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Mapping
from pathlib import Path
from typing import Final

from pmmkit.base import DataError, Remedy, Way
from pmmkit.presentation import printable

_COMPILERS: Final = ("cc", "gcc", "clang", "cl")
_SYSTEMS: Final = {"win32": ("windows", "win", ".dll"), "darwin": ("darwin", "darwin", ".dylib")}
_OTHERS: Final = ("linux", "linux", ".so")
_MACHINES: Final = {"amd64": "x86_64", "x86_64": "x86_64", "arm64": "aarch64", "aarch64": "aarch64"}
_COMPILE: Final = Way.setting("compile", True)
_LONGEST: Final = 2000
"""Letters of a compiler's message that are shown."""


def library(
    sources: Mapping[str, str], main: str, identifier: str, *, fmi: int
) -> tuple[str, bytes]:
    """Compile the sources; gives the place of the library in the FMU, and its bytes."""
    compiler = _compiler()
    folder, ending = _place(fmi)
    name = f"{identifier}{ending}"
    with tempfile.TemporaryDirectory() as place:
        for file, text in sources.items():
            (Path(place) / file).write_text(text, encoding="utf-8", newline="\n")
        command = [*compiler, *_options(compiler[0], main, name)]
        try:
            done = subprocess.run(
                command, cwd=place, capture_output=True, text=True, errors="replace", check=False
            )
        except OSError as error:
            raise _failed(command, str(error)) from error
        made = Path(place) / name
        if done.returncode or not made.is_file():
            raise _failed(command, done.stderr or done.stdout)
        return f"binaries/{folder}/{name}", made.read_bytes()


def _compiler() -> list[str]:
    """The C compiler: that of the environment's ``CC``, or one of the usual names."""
    asked = shlex.split(os.environ.get("CC", ""))
    for command in [asked] if asked else [[name] for name in _COMPILERS]:
        if shutil.which(command[0]):
            return command
    said = f"CC names {asked[0]!r}, which is not there" if asked else "there is none of that name"
    raise DataError(
        f"No C compiler was found ({', '.join(_COMPILERS)}; {said}).",
        remedy=Remedy(
            "Install one, such as gcc, clang or Visual Studio's cl, or name yours in the "
            "environment variable CC. Without {} the FMU holds its sources alone, which some "
            "programs compile themselves.",
            (_COMPILE,),
        ),
    )


def _options(compiler: str, main: str, name: str) -> list[str]:
    if Path(compiler).stem.lower() == "cl":
        return ["/nologo", "/LD", "/O2", main, f"/Fe:{name}"]
    exact = ["-std=c99", "-O2", "-ffp-contract=off", "-fvisibility=hidden"]
    relocatable = [] if sys.platform == "win32" else ["-fPIC"]
    return [*exact, *relocatable, "-shared", "-o", name, main, "-lm"]


def _place(fmi: int) -> tuple[str, str]:
    """Folder of the libraries of this machine, and their ending."""
    system, short, ending = _SYSTEMS.get(sys.platform, _OTHERS)
    machine = _MACHINES.get(platform.machine().lower(), platform.machine().lower())
    if fmi == 2 and machine == "x86_64":
        return f"{short}64", ending
    return f"{machine}-{system}", ending


def _failed(command: list[str], said: str) -> DataError:
    return DataError(
        f"The C compiler failed: {shlex.join(command)}\n{printable(said, lines=True)[:_LONGEST]}",
        remedy=Remedy(
            "Name another compiler in the environment variable CC, or export without {}.",
            (_COMPILE,),
        ),
    )
