"""Turning the text of a structure into functions: interpreted, or compiled and kept on disk."""

from __future__ import annotations

import hashlib
import os
import sys
import warnings
from collections.abc import Callable
from functools import cache
from math import atan2, cos, exp, sin
from pathlib import Path
from types import FunctionType, ModuleType, SimpleNamespace
from typing import Any, Final

import numpy as np

from pmmkit.base import __version__
from pmmkit.effects import rebound
from pmmkit.equations.code_generation import ENGINE, module_text
from pmmkit.equations.structure import EquationStructure
from pmmkit.files import atomic_path, cache_folder


@cache
def interpreted(structure: EquationStructure, files: tuple[str, ...] = ENGINE) -> ModuleType:
    """The functions of a structure, run by Python itself; lists stand for their arrays."""
    return _plain(structure, files, lambda size: [0.0] * size)


@cache
def compiled(structure: EquationStructure, files: tuple[str, ...] = ENGINE) -> ModuleType:
    """The functions of a structure, compiled; the second session finds them on disk.

    The text is written to `cache_folder` under its hash, with the machine code beside it. Where
    that folder cannot be written, or others could have written into it, the functions are compiled
    in each session; what is damaged is compiled again. Where numba cannot be imported, Python
    itself runs them, on arrays.
    """
    try:
        import numba

        from pmmkit.equations import compiled_cache, lane_functions
    except ImportError as error:
        warnings.warn(
            f"Equations are interpreted, which takes many times as long: {error}. Install numba.",
            stacklevel=2,
        )
        return _plain(structure, files, np.zeros)

    text, name = _text_and_name(structure, files)
    entry, place = compiled_cache.kept, name
    try:
        path = _folder() / f"{name}.py"
        if not path.is_file() or path.read_bytes() != text.encode():
            with atomic_path(path) as part:
                part.write_text(text, encoding="utf-8", newline="\n")
        place = str(path)
    except OSError:
        entry = compiled_cache.not_kept
    module = sys.modules[name] = ModuleType(name)
    # Numba runs everything as Python where it is told not to compile.
    of_lanes = _PLAIN if vars(numba.config)["DISABLE_JIT"] else lane_functions
    module.__dict__.update(entry=entry, lane_functions=of_lanes)
    exec(compile(text, place, "exec"), module.__dict__)
    return module


@cache
def is_compiled(structure: EquationStructure, files: tuple[str, ...] = ENGINE) -> bool:
    """Whether a session before compiled a manoeuvre of a structure, and left it on the disk."""
    _, name = _text_and_name(structure, files)
    return any((cache_folder() / f"v{__version__}").glob(f"{name}.run-*.nbi"))


def _text_and_name(structure: EquationStructure, files: tuple[str, ...]) -> tuple[str, str]:
    text = _HEAD + module_text(structure, files)
    return text, f"pmmkit_equations_{_fingerprint(structure, text)}"


def _plain(
    structure: EquationStructure, files: tuple[str, ...], vector: Callable[[int], Any]
) -> ModuleType:
    """The functions of a structure for Python itself, with what makes their empty arrays."""
    module = ModuleType("pmmkit_equations")
    given = {"entry": _same, "inner": _same, "use": _same, "vector": vector}
    module.__dict__.update(given, lane_functions=_PLAIN, np=np, numpy=np)
    exec(compile(module_text(structure, files), "<equations of a model>", "exec"), module.__dict__)
    return module


def _folder() -> Path:
    """The folder of this version, which nobody else can write."""
    folder = cache_folder().resolve() / f"v{__version__}"
    for place in (folder.parent, folder):
        place.mkdir(mode=0o700, parents=True, exist_ok=True)
        if why := _open_to_others(place):
            warnings.warn(
                f"Compiled equations are not kept: {place} {why}. Remove it, or name another "
                f"folder with PMMKIT_CACHE.",
                stacklevel=2,
            )
            raise PermissionError(why)
    return folder


def _open_to_others(folder: Path) -> str | None:
    """Who else could have put code into a folder; Windows keeps that from the user's own."""
    if sys.platform == "win32":
        return None
    state = folder.stat()
    if state.st_uid not in (os.getuid(), 0):
        return "belongs to another user"
    return "can be written by other users" if state.st_mode & 0o022 else None


def _same(function: Any) -> Any:
    return function


def _part(values: Any, first: int, size: int) -> Any:
    return values[first : first + size]


def _fingerprint(structure: EquationStructure, text: str) -> str:
    """Hash of all that the compiled code depends on."""
    digest = hashlib.sha256(text.encode())
    for file in (
        str(sys.modules[rebound.__module__].__file__),
        Path(__file__).with_name("lane_functions.py"),
    ):
        digest.update(Path(file).read_bytes())
    for item in structure.used:
        if not item.text:
            for code in sorted(_codes_of(item.known.force)):
                digest.update(code)
    return digest.hexdigest()[:20]


def _codes_of(function: Any) -> set[bytes]:
    """The files of a function and of those that it calls; their code where there is no file."""
    assert isinstance(function, FunctionType)
    code = function.__code__
    file = Path(code.co_filename)
    written = file.read_bytes() if file.is_file() else repr((code.co_code, code.co_consts)).encode()
    found = {written}
    for name in code.co_names:
        other = function.__globals__.get(name)
        if isinstance(other, FunctionType):
            found |= _codes_of(other)
    return found


_PLAIN: Final = SimpleNamespace(use=_same, part=_part, sin=sin, cos=cos, atan2=atan2, exp=exp)
_HEAD = '''"""Equations of motion of one structure of model; pmmkit wrote it; it gives the rest."""

import numba
import numpy
import numpy as np

from pmmkit.equations.compiled_effects import use


def inner(function):
    return numba.njit(
        function, nogil=True, error_model="numpy", forceinline=True, no_cfunc_wrapper=True
    )


@inner
def vector(size):
    return numpy.zeros(size)


'''
