"""Turning the text of a structure into functions: interpreted, or compiled and kept on disk."""

from __future__ import annotations

import hashlib
import math
import os
import sys
import warnings
from collections.abc import Mapping
from functools import cache, partial
from pathlib import Path
from types import FunctionType, ModuleType
from typing import Any

import numpy as np

from pmmkit.base import __version__
from pmmkit.effects import rebound
from pmmkit.equations import lane_functions, stand_ins
from pmmkit.equations.code_generation import ENGINE, entries_text, module_parts, module_text
from pmmkit.equations.structure import EquationStructure
from pmmkit.files import atomic_path, cache_folder
from pmmkit.syntax import Function, LlvmProgram, Unwritable, functions


@cache
def interpreted(structure: EquationStructure, files: tuple[str, ...] = ENGINE) -> ModuleType:
    """The functions of a structure, run by Python itself; lists stand for their arrays."""
    return _plain(structure, files)


@cache
def compiled(structure: EquationStructure, files: tuple[str, ...] = ENGINE) -> ModuleType:
    """The functions of a structure, compiled; the second session finds them on disk.

    The text is written to `cache_folder` under its hash, with the machine code beside it. Where
    that folder cannot be written, or others could have written into it, the functions are compiled
    in each session; what is damaged is compiled again. Where numba cannot be imported, or an own
    effect holds what cannot be written for it, Python itself runs them, on arrays.
    """
    try:
        import numba

        from pmmkit.equations import compiled_cache, machine_code
    except ImportError as error:
        return _on_arrays(structure, files, f"{error}. Install numba.")
    name = _name(structure, files)
    if vars(numba.config)["DISABLE_JIT"]:
        # Numba runs everything as Python where it is told not to compile.
        module = _plain(structure, files, vector=np.zeros)
        module.__name__ = name
        return module
    text = _HEAD + entries_text(*module_parts(structure, files))
    entry, place = compiled_cache.kept, name
    try:
        path = _folder() / f"{name}.py"
        if not path.is_file() or path.read_bytes() != text.encode():
            if why := _unwritable(structure, files):
                return _on_arrays(structure, files, why)
            with atomic_path(path) as part:
                part.write_text(text, encoding="utf-8", newline="\n")
        place = str(path)
    except OSError:
        if why := _unwritable(structure, files):
            return _on_arrays(structure, files, why)
        entry = compiled_cache.not_kept
    module = sys.modules[name] = ModuleType(name)
    written = machine_code.written(partial(_source, structure, files), f"{name}.")
    module.__dict__.update(entry=entry, written=written)
    exec(compile(text, place, "exec"), module.__dict__)
    return module


def _on_arrays(structure: EquationStructure, files: tuple[str, ...], why: str) -> ModuleType:
    """The functions of a structure, run by Python itself on arrays, with a warning."""
    warnings.warn(f"Equations are interpreted, which takes many times as long: {why}", stacklevel=4)
    return _plain(structure, files, vector=np.zeros)


def _unwritable(structure: EquationStructure, files: tuple[str, ...]) -> str:
    """Why the rates cannot be compiled: an effect in Python may hold anything."""
    from pmmkit.equations.machine_code import absent

    program = LlvmProgram(*_source(structure, files), "")
    try:
        program.take("rates", ["list", "double", "double", "double", "list", "list"])
    except Unwritable as error:
        return f"they hold {error}. CONTRIBUTING.md names the words of an effect."
    missing = ", ".join(absent(program.outer))
    return f"this system has no function {missing}." if missing else ""


@cache
def is_compiled(structure: EquationStructure, files: tuple[str, ...] = ENGINE) -> bool:
    """Whether a session before compiled a manoeuvre of a structure, and left it on the disk."""
    name = _name(structure, files)
    return any((cache_folder() / f"v{__version__}").glob(f"{name}.run-*.nbi"))


def is_loaded(structure: EquationStructure, files: tuple[str, ...] = ENGINE) -> bool:
    """Whether this session has compiled a manoeuvre of a structure, or fetched it from the disk."""
    module = sys.modules.get(_name(structure, files))
    return bool(module and getattr(module.run, "overloads", ()))


@cache
def _source(
    structure: EquationStructure, files: tuple[str, ...]
) -> tuple[Mapping[str, Function], ModuleType]:
    """The functions of a structure as trees, and as Python runs them; those of lanes as they are.

    A session that finds the machine code on the disk does not need them.
    """
    of_lanes = {"lane_functions": lane_functions, "in_lanes": lane_functions.use}
    return functions(module_text(structure, files)), _plain(structure, files, **of_lanes)


@cache
def _name(structure: EquationStructure, files: tuple[str, ...]) -> str:
    return f"pmmkit_equations_{_fingerprint(structure, module_text(structure, files))}"


def _plain(structure: EquationStructure, files: tuple[str, ...], **given: Any) -> ModuleType:
    """The functions of a structure for Python itself; `given` replaces what they are given else."""
    module = ModuleType("pmmkit_equations")
    module.__dict__.update(entry=_same, inner=_same, in_lanes=_same, lane_functions=math, np=np)
    module.__dict__.update(vector=stand_ins.vector, part=stand_ins.part)
    module.__dict__.update(given)
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


def _fingerprint(structure: EquationStructure, text: str) -> str:
    """Hash of all that the compiled code depends on."""
    digest = hashlib.sha256(text.encode())
    for file in (
        Path(str(sys.modules[rebound.__module__].__file__)),
        *(Path(__file__).with_name(f"{name}.py") for name in ("lane_functions", "machine_code")),
        *sorted(Path(str(sys.modules[LlvmProgram.__module__].__file__)).parent.glob("*.py")),
    ):
        digest.update(file.read_bytes())
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


_HEAD = '''"""Entries to the equations of motion of one structure of model; pmmkit wrote them."""

import numba
import numpy as np


def inner(function):
    return numba.njit(
        function, nogil=True, error_model="numpy", forceinline=True, no_cfunc_wrapper=True
    )


'''
