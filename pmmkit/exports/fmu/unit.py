"""A model as a Functional Mock-up Unit."""

from __future__ import annotations

import hashlib
import inspect
import io
import os
import platform
import shlex
import shutil
import subprocess
import sys
import tempfile
import uuid
from collections.abc import Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Final, Literal

from pmmkit.base import DataError, ModelError, Problem, Remedy, Way
from pmmkit.equations import Prepared, prepare
from pmmkit.exports.fmu.description import build_text, description_text
from pmmkit.exports.fmu.variables import BEGIN, GEAR, Table, table_of
from pmmkit.exports.text import WHICH_SPEED, write_archive, written_by
from pmmkit.models import Model
from pmmkit.presentation import printable
from pmmkit.syntax import CProgram, Unwritable, c_number, comment, matlab_name

# The equations of one model as C, with its variables and numbers.


_MOMENT: Final = ("list", "double", "double", "double", "list", "list")
_FUNCTIONS: Final[dict[str, Sequence[str]]] = {
    "complete": ("list",),
    "rates": _MOMENT,
    "forces": _MOMENT,
    "self_propulsion": ("double", "list", "list", "list"),
    "flow": ("double",) * 2,
    "wind_over_current": ("double",) * 4,
    "gear_rate": ("double",) * 4,
    "ordered": ("list", "int", *("double",) * 5),
    "controlled": ("double", "list", "int"),
    "carried": ("double", "double", "double", "list", "list", "list", "double", "double"),
}
"""What ship.h calls, with the kinds of the arguments."""
_CLOSEST: Final = 1e-13
"""Least relative tolerance, as `simulate` has it."""
_ONLY_FOR: Final = {"self_propulsion": "n_approach", "wind_over_current": "wind_speed"}
"""Functions that only an FMU with a certain variable calls."""
_ASKED: Final = (
    *("time", "delta", "n", "n_approach", "delta_order", "n_order", "bucket"),
    *("current_speed", "current_direction", "wind_speed", "wind_direction"),
    *("wave_height", "wave_direction", "steering_gear", "delta_rate", "delta_max", "delta_lag"),
)
"""Variables that ship.h knows by their names; it does without those that a model has not."""
_SURROUNDINGS: Final = (
    *("current_x", "current_y", "wind_speed", "wind_direction", "wave_height", "wave_direction"),
)


def equations_text(model: Model, ready: Prepared, table: Table, *, token: str) -> str:
    """The text of equations.h."""
    lines = [
        *(line.replace("%", "//", 1) for line in written_by("//")),
        *comment(f"{model.title or model.name}: equations and numbers.", "//"),
        "",
        "#include <math.h>",
        "",
        _program(ready, table).text,
        *_numbers(table),
        "",
        *_defined(ready, table, token),
    ]
    return "\n".join(lines) + "\n"


def _program(ready: Prepared, table: Table) -> CProgram:
    text, module = ready.program()
    program = CProgram(text, module)
    problems = []
    for item in ready.structure.used:
        name = f"effect_{item.effect}"
        tables = {own for own, _ in item.tables}
        options = {own for own, _ in item.options}
        asked = [
            "table" if x in tables else "int" if x in options else "double"
            for x in inspect.signature(getattr(module, name)).parameters
        ]
        try:
            program.take(name, asked)
        except Unwritable as error:
            problems.append(
                Problem(
                    message=f"{item.effect}: it is written with {error}.",
                    remedy="Leave it out to export the rest.",
                )
            )
    if problems:
        raise ModelError(problems, title=f"Model {ready.name!r} cannot be written as C")
    for name, kinds in _FUNCTIONS.items():
        if _ONLY_FOR.get(name, "time") in table.places:
            program.take(name, kinds)
    return program


def _numbers(table: Table) -> Iterator[str]:
    yield "struct slope { int place; int variable; double size; };"
    starts = [0.0 if item.start is None else item.start for item in table.variables]
    yield from _listed("double START", starts)
    yield from _listed("double BASE", table.base)
    nominal = (item.nominal for item in table.variables if item.name in table.states)
    yield from _listed("double NOMINAL", [size or 1.0 for size in nominal])
    slopes = [
        f"{{{place}, {variable}, {c_number(size)}}}"
        for variable, item in enumerate(table.variables)
        for place, size in item.slopes
    ]
    yield f"static const struct slope SLOPE[{len(slopes)}] = {{"
    yield from _rows(slopes)
    yield "};"


def _listed(name: str, values: Iterable[float]) -> list[str]:
    texts = [c_number(float(value)) for value in values]
    return [f"static const {name}[{len(texts)}] = {{", *_rows(texts), "};"]


def _rows(texts: list[str]) -> list[str]:
    return [f"    {', '.join(texts[i : i + 6])}," for i in range(0, len(texts), 6)]


def _defined(ready: Prepared, table: Table, token: str) -> Iterator[str]:
    """The names by which ship.h knows all that."""
    places, states = table.places, table.states
    known = {
        "TOKEN": f'"{token}"',
        "TOLERANCE": c_number(Prepared.RTOL),
        "CLOSEST": c_number(_CLOSEST),
        "LONGEST_STEP": c_number(ready.longest_step),
        "VARIABLES": len(table.variables),
        "CONSTANTS": len(table.base),
        "STATES": len(states),
        **ready.gears(),
        "SLOPES": sum(len(item.slopes) for item in table.variables),
        "FIRST_STATE": places[states[0]],
        "U_STATE": states.index("u"),
        "FIRST_RATE": places[f"der({states[0]})"],
        "GEAR_STATE": places[GEAR],
        "GEAR_RATE": places[f"der({GEAR})"],
        "FIRST_FORCE": places["X"],
        "FIRST_INPUT": places["delta_order"],
        "FIRST_BEGIN": places[f"{states[0]}{BEGIN}"],
        "FIRST_PARAMETER": places[f"{states[0]}{BEGIN}"],
        **{f"V_{name.upper()}": places[name] for name in _ASKED if name in places},
        **{f"K_{name.upper()}": ready.place(name) for name in _SURROUNDINGS},
    }
    for name, value in known.items():
        yield f"#define {name} {value}"


# The sources of an FMU as a library for this machine.


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


Version = Literal[2, 3]
VERSIONS: Final[tuple[Version, ...]] = (3, 2)
"""Versions of FMI that are written; the first by default."""
_ANY_FROUDE: Final = 0.2
"""Froude number of the approach where none is asked for and the values depend on none."""
_SOURCES: Final = Path(__file__).with_name("sources")
_SHARED: Final = ("calls.h", "ship.h")


def model_to_fmu(
    model: Model, *, speed: float | None = None, fmi: Version = 3, compile: bool = False
) -> bytes:
    """The bytes of an FMU for Model Exchange and Co-Simulation.

    speed [m/s].

    Notes
    -----
    The C code is made from the functions that simulate here: equations, effects, steering gear,
    and for Co-Simulation the integrator. docs/export.md tells the variables.

    Examples
    --------
    >>> import io, zipfile
    >>> from pmmkit.models import load_model
    >>> archive = zipfile.ZipFile(io.BytesIO(model_to_fmu(load_model("kvlcc2-l7"), speed=1.179)))
    >>> archive.namelist()  # doctest: +NORMALIZE_WHITESPACE
    ['modelDescription.xml', 'sources/buildDescription.xml', 'sources/calls.h',
     'sources/equations.h', 'sources/fmi3.c', 'sources/ship.h']
    """
    if fmi not in VERSIONS:
        known = " and ".join(map(str, sorted(VERSIONS)))
        raise DataError(
            f"FMI {fmi} is not written: versions {known} are.",
            remedy=Remedy(
                "Leave {} out for FMI 3, or say {} for programs that read no other.",
                (Way.setting("fmi"), Way.setting("fmi", 2)),
            ),
        )
    at = approach_of(model, speed)
    ready = prepare(model, at)
    table = table_of(model, ready, at)
    identifier = matlab_name(model.name, stem="ship")
    main = f"fmi{fmi}.c"
    written = {name: (_SOURCES / name).read_text(encoding="utf-8") for name in (main, *_SHARED)}
    parts = {
        **written,
        "equations.h": equations_text(model, ready, table, token=""),
        "description": description_text(
            model, table, fmi=fmi, identifier=identifier, token="", pace=at / ready.L
        ),
    }
    token = f"{{{_token(parts)}}}"
    sources = {**written, "equations.h": equations_text(model, ready, table, token=token)}
    files: dict[str, bytes] = {
        "modelDescription.xml": description_text(
            model, table, fmi=fmi, identifier=identifier, token=token, pace=at / ready.L
        ).encode()
    }
    if fmi == 3:
        files["sources/buildDescription.xml"] = build_text(identifier, main).encode()
    files |= {f"sources/{name}": text.encode() for name, text in sorted(sources.items())}
    if compile:
        place, made = library(sources, main, identifier, fmi=fmi)
        files[place] = made
    room = io.BytesIO()
    write_archive(room, files.items())
    return room.getvalue()


def approach_of(model: Model, speed: float | None) -> float:
    """The approach speed of an FMU [m/s]: the one that is asked for, or that of Fn 0.2.

    Parameters
    ----------
    model : Model
        The ship.
    speed : float or None
        The speed that is asked for [m/s].

    Raises
    ------
    ModelError
        If none is asked for and the values of the model depend on it.

    Examples
    --------
    >>> from pmmkit.models import load_model
    >>> round(approach_of(load_model("kvlcc2-l7"), None), 3)
    1.657
    """
    if speed is not None:
        return speed
    about = model.convention.surge == "delta-u"
    if model.Fn or about or (model.convention.U == "carriage" and model.convention.system != "bis"):
        why = f"has values at {len(model.Fn)} Froude numbers"
        if not model.Fn:
            why = "is written about the approach speed"
        raise ModelError(f"Model {model.name!r} {why}.", remedy=WHICH_SPEED)
    return model.ship.speed(_ANY_FROUDE, model.water.g)


def _token(parts: Mapping[str, str]) -> uuid.UUID:
    """What tells this FMU from every other, from all that stands in it."""
    digest = hashlib.sha256()
    for name, text in sorted(parts.items()):
        digest.update(f"{name}\0{text}\0".encode())
    return uuid.UUID(bytes=digest.digest()[:16], version=5)
