"""Models as TOML files: read with every fault named, written without loss."""

from __future__ import annotations

import os
import re
from collections.abc import Iterable, Mapping
from dataclasses import asdict
from pathlib import Path
from types import MappingProxyType
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from pmmkit.base import DataError, ModelError, Problem, UnknownNameError, did_you_mean
from pmmkit.conventions import STRUCTURES, Convention
from pmmkit.effects import is_fault
from pmmkit.files import CAMPAIGN, MODEL, read_toml, refuse_other, toml_text, write_text
from pmmkit.models.library import SHIPS, read_ship, read_water, ships
from pmmkit.models.model import Model
from pmmkit.models.part import Part
from pmmkit.models.records import FileReader
from pmmkit.models.step import Step, Value
from pmmkit.presentation import quoted

# Older files: a history in sentences as steps, a drift at rest and at a speed as one table.


_ADDED: Final = re.compile(
    r"Added (?P<effect>[^:(]+?)(?: \((?P<why>.*)\))?: error of left-out conditions "
    r"(?P<before>[\d.]+|nan) % to (?P<after>[\d.]+|nan) % of the rms forces of (?P<tests>.*)\.",
    re.DOTALL,
)


def steps_of_sentences(history: Iterable[str]) -> tuple[Step, ...]:
    """The steps that a ``history`` of sentences tells.

    Examples
    --------
    >>> line = ("Added memory (over 1000 to 1): error of left-out conditions 3.10 % to 1.90 % of "
    ...         "the rms forces of S175.")
    >>> (step,) = steps_of_sentences([line])
    >>> step.action, step.effect, step.error_after
    ('effect_added', 'memory', 0.019)
    >>> str(step) == line
    True
    """
    return tuple(_step(line) for line in history)


def _step(line: str) -> Step:
    found = _ADDED.fullmatch(line)
    if found is None:
        return Step(action="noted", note=line)
    before, after = (
        None if found[name] == "nan" else round(float(found[name]) / 100.0, 6)
        for name in ("before", "after")
    )
    return Step(
        action="fault_corrected" if is_fault(found["effect"]) else "effect_added",
        effect=found["effect"],
        error_before=before,
        error_after=after,
        campaign=found["tests"],
        note=found["why"] or "",
    )


def drift_over_speeds(values: Mapping[str, Value]) -> dict[str, Value]:
    """Values of the mean drift of waves, of which older files state those at rest apart.

    Examples
    --------
    >>> rest, moving = ("DX_rest", "DY_rest", "DN_rest"), ("DX", "DY", "DN")
    >>> old = dict.fromkeys(rest, (0.0, 0.1)) | dict.fromkeys(moving, (0.2, 0.3)) | {"speed": 8.0}
    >>> new = drift_over_speeds(old)
    >>> new["speeds"], new["DN"], "DX_rest" in new
    ((0.0, 8.0), (0.0, 0.1, 0.2, 0.3), False)
    """
    found, speed = dict(values), values.get("speed")
    tables = {name: (values.get(f"{name}_rest"), values.get(name)) for name in ("DX", "DY", "DN")}
    if not isinstance(speed, float):
        return found
    for name, (rest, moving) in tables.items():
        if not isinstance(rest, tuple) or not isinstance(moving, tuple):
            return dict(values)
        found[name] = (*rest, *moving)
        del found[f"{name}_rest"]
    del found["speed"]
    return found | {"speeds": (0.0, speed)}


SCHEMA: Final = 2
"""The second has ``steps``; a file without them is one of the first."""
_TOP: Final = (
    "schema",
    "name",
    "title",
    "scale",
    "notes",
    "history",
    "Fn",
    "ship",
    "water",
    "convention",
    "steps",
    "effects",
    "covariance",
    "closed",
    "end",
)
_PART: Final = ("source", "references", "text", "options", "values", "sources", "std")


def load_model(name_or_path: str | Path) -> Model:
    """A model from a file, or one of the library.

    Parameters
    ----------
    name_or_path : str or path
        A library name (``s175``), or the path of a TOML file.

    Returns
    -------
    Model

    Raises
    ------
    UnknownNameError
        If neither a file nor a library ship is meant.
    ModelError
        If the file is damaged or wrong, with all that is wrong, or something else is given. Nothing
        in a file is executed.

    Examples
    --------
    >>> model = load_model("s175-3dof")
    >>> model.rolls, model.values("hull_polynomial")["Yv"]
    (False, -0.0116)
    """
    try:
        text = os.fspath(name_or_path)
    except TypeError:
        kind = type(name_or_path).__name__
        raise ModelError(
            f"A model is a Model, a name of the library or a file, not a {kind}: "
            "model_of(reduction) makes one of tests, to_model(table) of derivatives."
        ) from None
    is_name = (
        isinstance(name_or_path, str) and not text.endswith(".toml") and Path(text).name == text
    )
    if Path(text).is_dir() and not (is_name and text in ships()):
        raise _folder(Path(text))
    if is_name and text not in SHIPS:
        raise _no_ship(text)
    path = SHIPS[text].file if is_name else Path(name_or_path)
    content = read_toml(path)
    refuse_other(content, MODEL, str(path), ModelError)
    return model_from(content, str(path))


def _no_ship(name: str) -> UnknownNameError:
    """The error of a name that no ship has; a structure may be meant."""
    if name in STRUCTURES:
        return UnknownNameError(
            f"{name!r} is a structure and no ship: pmmkit reduce --structure {name} makes a model "
            "of tests with it; diagnose, plan and workbench take it as it is."
        )
    near = did_you_mean(name, STRUCTURES)
    said = f" Structures are taken by diagnose, plan and workbench{near}" if near else ""
    return UnknownNameError(SHIPS.unknown(name) + said)


def _folder(path: Path) -> ModelError:
    """The error of a folder that stands where a model is asked for, with what lies in it."""
    if (path / MODEL.file).is_file():
        remedy = f"It holds one: write {quoted(path / MODEL.file)}."
    elif (path / CAMPAIGN.file).is_file():
        remedy = f"It holds tests: the command pmmkit reduce {quoted(path)} makes a model of them."
    else:
        remedy = "Name the model file in it (.toml), or a ship of the library."
    return ModelError(
        Problem(message="this is a folder and no model.", file=str(path), remedy=remedy)
    )


def save_model(model: Model, path: str | Path) -> None:
    """Write a model as TOML, all or nothing; `load_model` gives it back without loss.

    Parameters
    ----------
    model : Model
        The model.
    path : path
        File to write; one that is there is replaced.

    Examples
    --------
    >>> import tempfile
    >>> model = load_model("s175")
    >>> path = Path(tempfile.mkdtemp()) / "ship.toml"
    >>> save_model(model, path)
    >>> model_text(load_model(path)) == model_text(model)
    True
    """
    write_text(path, model_text(model))


def model_text(model: Model) -> str:
    """The text of a model's file; equal for equal models.

    Parameters
    ----------
    model : Model
        The model.
    """
    data: dict[str, Any] = {"schema": SCHEMA if model.steps else 1, "name": model.name}
    data["closed"] = True
    data |= {key: getattr(model, key) for key in ("title", "scale") if getattr(model, key)}
    if model.notes:
        data["notes"] = list(model.notes)
    if model.Fn:
        data["Fn"] = [float(x) for x in model.Fn]
    data["ship"] = {key: x for key, x in asdict(model.ship).items() if x is not None}
    data["water"] = {key: x for key, x in asdict(model.water).items() if x is not None}
    data["convention"] = asdict(model.convention)
    if model.steps:
        data["steps"] = [step.entries for step in model.steps]
    data["effects"] = {name: _part_data(part) for name, part in model.parts.items()}
    if model.covariance is not None:
        lower = [row[: i + 1].tolist() for i, row in enumerate(model.covariance)]
        data["covariance"] = {"names": list(model.covariance_names), "lower": lower}
    data["end"] = {}
    return toml_text(data)


def _part_data(part: Part) -> dict[str, Any]:
    data: dict[str, Any] = {"source": part.source} if part.source else {}
    if part.references:
        data["references"] = list(part.references)
    if part.options:
        data["options"] = dict(part.options)
    data["values"] = {name: _plain(value) for name, value in part.values.items()}
    if part.sources:
        data["sources"] = dict(part.sources)
    if part.std:
        data["std"] = {name: float(x) for name, x in part.std.items()}
    if part.text:
        data["text"] = part.text
    return data


def _plain(value: Value) -> float | list[float]:
    return [float(x) for x in value] if isinstance(value, tuple) else float(value)


def model_from(data: Mapping[str, Any], file: str) -> Model:
    """A model from the content of its file."""
    reader = FileReader(file)
    title = "Not a model"
    schema = data.get("schema")
    if not isinstance(schema, int) or isinstance(schema, bool) or not 1 <= schema <= SCHEMA:
        reader.fault(
            f"schema is {schema!r:.40}; this pmmkit reads 1 to {SCHEMA}.",
            "A model file starts with schema = 1; a file of a newer pmmkit needs that version.",
        )
        raise ModelError(reader.problems, title=title)
    if data.get("closed") is True and "end" not in data:
        reader.fault(
            "The file is cut off: it says closed = true, and its last line [end] is missing.",
            "Take it from its source again; if nothing is missing, write [end] as its last line.",
        )
        raise ModelError(reader.problems, title=title)
    reader.known(data, _TOP, "A model file")
    name = reader.text(data, "name")
    if not name:
        reader.fault("The model has no name.")
    ship = read_ship(data, file, reader.problems)
    water = read_water(data, file, reader.problems)
    section = reader.section(data, "convention", "convention")
    convention = reader.record(Convention, section, "convention")
    rows = data.get("Fn", [])
    grid = reader.number(rows, "Fn")
    if grid is not None and not isinstance(grid, tuple):
        reader.fault("Fn must be a list.")
        grid = None
    parts = {}
    effects = reader.section(data, "effects", "effects")
    if not effects:
        reader.fault("The model has no effects.")
    for effect in effects:
        parts[effect] = _part(reader, effect, reader.section(effects, effect, f"effects.{effect}"))
    names, covariance = _covariance(reader, data)
    given = {key: reader.text(data, key) for key in ("title", "scale")}
    notes = reader.texts(data, "notes")
    steps = steps_of_sentences(reader.texts(data, "history")) + reader.steps(data)
    if reader.problems or ship is None or water is None or convention is None:
        raise ModelError(reader.problems, title=title)
    try:
        return Model(
            name=name,
            ship=ship,
            water=water,
            parts=MappingProxyType(parts),
            convention=convention,
            Fn=grid if isinstance(grid, tuple) else (),
            covariance=covariance,
            covariance_names=names,
            title=given["title"],
            scale=given["scale"],
            notes=notes,
            steps=steps,
        )
    except UnknownNameError:
        raise
    except DataError as error:
        found = [Problem(message=item.message, file=file) for item in error.problems]
        raise ModelError(found, title=title) from error


def _part(reader: FileReader, effect: str, data: Mapping[str, Any]) -> Part:
    place = f"effects.{effect}"
    reader.known(data, _PART, place)
    values: dict[str, Value] = {}
    for name, value in reader.section(data, "values", f"{place}.values").items():
        read = reader.number(value, f"{place}.values.{name}")
        if read is not None:
            values[name] = read
    std = {
        name: reader.number(value, f"{place}.std.{name}")
        for name, value in reader.section(data, "std", f"{place}.std").items()
    }
    return Part(
        effect=effect,
        values=MappingProxyType(drift_over_speeds(values)),
        std=MappingProxyType({k: x for k, x in std.items() if isinstance(x, float)}),
        options=reader.words(data, "options", f"{place}.options"),
        source=reader.text(data, "source", f"{place}."),
        text=reader.text(data, "text", f"{place}."),
        references=reader.texts(data, "references", f"{place}."),
        sources=reader.words(data, "sources", f"{place}.sources"),
    )


def _covariance(
    reader: FileReader, data: Mapping[str, Any]
) -> tuple[tuple[str, ...], NDArray[np.float64] | None]:
    if "covariance" not in data:
        return (), None
    content = reader.section(data, "covariance", "covariance")
    reader.known(content, ("names", "lower"), "covariance")
    names = reader.texts(content, "names", "covariance.")
    lower = content.get("lower", [])
    rows = lower if isinstance(lower, list) else []
    sound = all(
        isinstance(row, list)
        and len(row) == i + 1
        and all(isinstance(x, (int, float)) and not isinstance(x, bool) for x in row)
        for i, row in enumerate(rows)
    )
    if not rows or not sound:
        reader.fault(
            "covariance.lower must hold the rows of the lower triangle: 1, 2, 3 … numbers."
        )
        return names, None
    matrix = np.zeros((len(rows), len(rows)))
    try:
        for i, row in enumerate(rows):
            matrix[i, : i + 1] = matrix[: i + 1, i] = row
    except OverflowError:
        reader.fault("covariance.lower holds a number that is too large.")
    return names, matrix
