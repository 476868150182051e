"""Turning the text of a structure into functions: interpreted, or compiled and kept on disk."""

from __future__ import annotations

import hashlib
import importlib.util
import os
import sys
from functools import cache
from pathlib import Path
from types import FunctionType, ModuleType
from typing import Any

from pmmkit.effects import primitives
from pmmkit.equations.code_generation import ENGINE, module_text
from pmmkit.equations.structure import Structure
from pmmkit.files import atomic_path
from pmmkit.version import __version__


def cache_folder() -> Path:
    """Where compiled equations are kept: ``PMMKIT_CACHE``, or the user's folder for such things."""
    if given := os.environ.get("PMMKIT_CACHE"):
        return Path(given)
    if sys.platform == "win32":
        base = Path(os.environ.get("LOCALAPPDATA") or Path.home() / "AppData" / "Local")
    elif sys.platform == "darwin":
        base = Path.home() / "Library" / "Caches"
    else:
        base = Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache")
    return base / "pmmkit"


@cache
def interpreted(structure: Structure) -> ModuleType:
    """The functions of a structure, run by Python itself; lists stand for their arrays."""
    module = ModuleType("pmmkit_equations")
    module.__dict__.update(entry=_same, inner=_same, use=_same, vector=lambda size: [0.0] * size)
    exec(compile(module_text(structure), "<equations of a model>", "exec"), module.__dict__)
    return module


@cache
def compiled(structure: Structure, files: tuple[str, ...] = ENGINE) -> ModuleType:
    """The functions of a structure, compiled; the second session finds them on disk.

    The text is written to `cache_folder` under its hash and imported from there. Where that
    folder cannot be written the functions are compiled in each session.
    """
    text = _HEAD + module_text(structure, files)
    name = f"pmmkit_equations_{_fingerprint(structure, text)}"
    path = cache_folder() / f"v{__version__}" / f"{name}.py"
    try:
        if not path.is_file() or path.read_text(encoding="utf-8") != text:
            path.parent.mkdir(parents=True, exist_ok=True)
            with atomic_path(path) as part:
                part.write_text(text, encoding="utf-8", newline="\n")
    except OSError:
        module = ModuleType(name)
        exec(compile(text.replace("cache=True", "cache=False"), name, "exec"), module.__dict__)
        return module
    spec = importlib.util.spec_from_file_location(name, path)
    assert spec is not None
    assert spec.loader is not None
    module = sys.modules[name] = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def _same(function: Any) -> Any:
    return function


def _fingerprint(structure: Structure, text: str) -> str:
    """Hash of all that the compiled code depends on."""
    digest = hashlib.sha256(text.encode())
    digest.update(Path(str(primitives.__file__)).read_bytes())
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


_HEAD = '''"""Equations of motion of one structure of model, written by pmmkit."""

import numba
import numpy
import numpy as np

from pmmkit.equations.compiled_effects import use


def entry(function):
    return numba.njit(function, cache=True, nogil=True, error_model="numpy")


def inner(function):
    return numba.njit(function, nogil=True, error_model="numpy", forceinline=True)


@inner
def vector(size):
    return numpy.zeros(size)


'''
