"""Models as TOML files: read with every fault named, written without loss."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import MISSING, asdict, fields
from pathlib import Path
from types import MappingProxyType
from typing import Any, Final, get_args, get_type_hints

import numpy as np
from numpy.typing import NDArray

from pmmkit.conventions import Convention
from pmmkit.errors import ModelError, Problem
from pmmkit.files import write_text
from pmmkit.models.model import Model, Part, Value
from pmmkit.ship_library import number, read_ship, read_water, ship_file
from pmmkit.toml_files import read_toml, toml_text

SCHEMA: Final = 1
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
    "effects",
    "covariance",
)
_PART: Final = ("source", "options", "values", "sources")


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
        If the file is damaged or wrong, with all that is wrong. Nothing in a file is executed.

    Examples
    --------
    >>> model = load_model("s175-3dof")
    >>> model.rolls, model.values("hull_polynomial")["Yv"]
    (False, -0.0116)
    """
    text = str(name_or_path)
    is_name = (
        isinstance(name_or_path, str) and not text.endswith(".toml") and Path(text).name == text
    )
    path = ship_file(text) if is_name else Path(name_or_path)
    return model_from(read_toml(path), str(path))


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
    data: dict[str, Any] = {"schema": SCHEMA, "name": model.name}
    data |= {key: getattr(model, key) for key in ("title", "scale") if getattr(model, key)}
    data |= {key: list(getattr(model, key)) for key in ("notes", "history") if getattr(model, key)}
    if model.Fn:
        data["Fn"] = [float(x) for x in model.Fn]
    data["ship"] = {key: x for key, x in asdict(model.ship).items() if x is not None}
    data["water"] = {key: x for key, x in asdict(model.water).items() if x is not None}
    data["convention"] = asdict(model.convention)
    data["effects"] = {name: _part_data(part) for name, part in model.parts.items()}
    if model.covariance is not None:
        lower = [row[: i + 1].tolist() for i, row in enumerate(model.covariance)]
        data["covariance"] = {"names": list(model.covariance_names), "lower": lower}
    return toml_text(data)


def _part_data(part: Part) -> dict[str, Any]:
    data: dict[str, Any] = {"source": part.source} if part.source else {}
    if part.options:
        data["options"] = dict(part.options)
    data["values"] = {name: _plain(value) for name, value in part.values.items()}
    if part.sources:
        data["sources"] = dict(part.sources)
    return data


def _plain(value: Value) -> float | list[float]:
    return [float(x) for x in value] if isinstance(value, tuple) else float(value)


class _Reader:
    """Collects what is wrong with a file while taking out what is right."""

    def __init__(self, file: str) -> None:
        self.file = file
        self.problems: list[Problem] = []

    def fault(self, message: str, remedy: str | None = None) -> None:
        self.problems.append(Problem(message=message, file=self.file, remedy=remedy))

    def known(self, data: Mapping[str, Any], names: Iterable[str], place: str) -> None:
        stray = [key for key in data if key not in tuple(names)]
        if stray:
            self.fault(f"{place} has no {', '.join(map(repr, stray))}; it has {', '.join(names)}.")

    def section(self, data: Mapping[str, Any], key: str, place: str) -> Mapping[str, Any]:
        value = data.get(key, {})
        if isinstance(value, dict):
            return value
        self.fault(f"{place} must be a section.")
        return {}

    def text(self, data: Mapping[str, Any], key: str, place: str = "") -> str:
        value = data.get(key, "")
        if isinstance(value, str):
            return value
        self.fault(f"{place}{key} must be a text, not {value!r:.40}.")
        return ""

    def texts(self, data: Mapping[str, Any], key: str, place: str = "") -> tuple[str, ...]:
        value = data.get(key, [])
        if isinstance(value, list) and all(isinstance(item, str) for item in value):
            return tuple(value)
        self.fault(f"{place}{key} must be a list of texts.")
        return ()

    def words(self, data: Mapping[str, Any], key: str, place: str) -> Mapping[str, str]:
        content = self.section(data, key, place)
        wrong = [name for name, value in content.items() if not isinstance(value, str)]
        if wrong:
            self.fault(f"{place}.{', '.join(wrong)} must be a text.")
        return MappingProxyType({k: v for k, v in content.items() if isinstance(v, str)})

    def number(self, value: object, place: str) -> Value | None:
        if isinstance(value, list):
            read = [number(item) for item in value]
            kept = tuple(item for item in read if item is not None)
            if len(kept) == len(value):
                return kept
        else:
            single = number(value)
            if single is not None:
                return single
        self.fault(f"{place} must be a finite number or a list of them, not {value!r:.40}.")
        return None


def model_from(data: Mapping[str, Any], file: str) -> Model:
    """A model from the content of its file.

    Parameters
    ----------
    data : mapping
        What `tomllib` reads.
    file : str
        Name for messages.

    Raises
    ------
    ModelError
        With everything that is wrong.
    """
    reader = _Reader(file)
    title = "Not a model"
    schema = data.get("schema")
    if not isinstance(schema, int) or isinstance(schema, bool) or not 1 <= schema <= SCHEMA:
        reader.fault(
            f"schema is {schema!r:.40}; this pmmkit reads 1 to {SCHEMA}.",
            "A model file starts with schema = 1; a file of a newer pmmkit needs that version.",
        )
        raise ModelError(reader.problems, title=title)
    reader.known(data, _TOP, "A model file")
    name = reader.text(data, "name")
    if not name:
        reader.fault("The model has no name.")
    ship = read_ship(data, file, reader.problems)
    water = read_water(data, file, reader.problems)
    convention = _convention(reader, data)
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
    lists = {key: reader.texts(data, key) for key in ("notes", "history")}
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
            notes=lists["notes"],
            history=lists["history"],
        )
    except ModelError as error:
        found = [Problem(message=item.message, file=file) for item in error.problems]
        raise ModelError(found, title=title) from error


def _part(reader: _Reader, effect: str, data: Mapping[str, Any]) -> Part:
    place = f"effects.{effect}"
    reader.known(data, _PART, place)
    values: dict[str, Value] = {}
    for name, value in reader.section(data, "values", f"{place}.values").items():
        read = reader.number(value, f"{place}.values.{name}")
        if read is not None:
            values[name] = read
    return Part(
        effect=effect,
        values=MappingProxyType(values),
        options=reader.words(data, "options", f"{place}.options"),
        source=reader.text(data, "source", f"{place}."),
        sources=reader.words(data, "sources", f"{place}.sources"),
    )


def _convention(reader: _Reader, data: Mapping[str, Any]) -> Convention | None:
    content = reader.section(data, "convention", "convention")
    hints = get_type_hints(Convention)
    known = {field.name: field for field in fields(Convention)}
    assert all(field.default is not MISSING for field in known.values())
    reader.known(content, known, "convention")
    given: dict[str, Any] = {}
    for key in known:
        if key not in content:
            continue
        words = get_args(hints[key])
        value: Any = content[key] if words else number(content[key])
        if (words and value not in words) or value is None:
            allowed = ", ".join(words) if words else "a number"
            reader.fault(f"convention.{key} is {content[key]!r:.40}; possible: {allowed}.")
        else:
            given[key] = value
    return Convention(**given)


def _covariance(
    reader: _Reader, data: Mapping[str, Any]
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
