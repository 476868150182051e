"""A model as a Functional Mock-up Unit."""

from __future__ import annotations

import hashlib
import io
import uuid
from collections.abc import Mapping
from pathlib import Path
from typing import Final, Literal

from pmmkit.base import DataError, ModelError, Remedy, Way
from pmmkit.equations import prepare
from pmmkit.exports.archive import write_archive
from pmmkit.exports.fmu.compiler import library
from pmmkit.exports.fmu.description import build_text, description_text
from pmmkit.exports.fmu.equations import equations_text
from pmmkit.exports.fmu.variables import table_of
from pmmkit.exports.text import WHICH_SPEED
from pmmkit.models import Model
from pmmkit.syntax import matlab_name

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
