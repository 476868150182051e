"""What may stand in a campaign file: tables, keys, kinds and ranges of their values.

Nothing else of pmmkit sees these classes: `pmmkit.campaigns.file.campaign_file` turns them into
Ship, Run and Campaign. The module is imported only when a campaign file is read.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Annotated, Any, Final, Literal, TypeVar

from pydantic import (
    BaseModel,
    BeforeValidator,
    ConfigDict,
    Field,
    PlainValidator,
    ValidationError,
    field_validator,
    model_validator,
)
from pydantic_core import PydanticCustomError

from pmmkit.campaigns.test_kinds.registry import kinds, not_a_kind
from pmmkit.channels import (
    CHANNEL_UNITS,
    DEGREE_CHANNELS,
    FORCE_CHANNELS,
    SETTING_UNITS,
    did_you_mean,
    unit_of,
)
from pmmkit.conventions import SYSTEMS
from pmmkit.errors import DataError, Problem
from pmmkit.readers import readers


def _as_tuple(value: Any) -> Any:
    """A list as a tuple, which can be hashed."""
    return tuple(value) if isinstance(value, list) else value


def _known_format(name: Any) -> Any:
    """A format that is read, asked when a file is read: readers of other packages count."""
    if name in tuple(readers()):
        return name
    raise PydanticCustomError(
        "literal_error", "Input should be {expected}", {"expected": ", ".join(readers())}
    )


Positive = Annotated[float, Field(gt=0)]
Count = Annotated[int, Field(ge=0)]
Degrees = Annotated[float, Field(ge=-180, le=180)]
Steep = Annotated[float, Field(gt=-90, lt=90)]
Axis = Literal["x", "-x", "+x", "y", "-y", "+y", "z", "-z", "+z"]
Listed = Annotated[list[str], BeforeValidator(lambda it: [it] if isinstance(it, str) else it)]
Widths = Annotated[
    tuple[Annotated[int, Field(ge=1)], ...], Field(min_length=2), BeforeValidator(_as_tuple)
]
Names = Annotated[tuple[str, ...], BeforeValidator(_as_tuple)]
Format = Annotated[str, PlainValidator(_known_format)]
Plain = str | float | int | bool

ACTIONS: Final = (
    "exclude",
    "scale",
    "shift",
    "flip",
    "trim",
    "tare",
    "drop",
    "drop means",
    "set",
    "inertia still inside",
    "inertia already removed",
    "accept",
)

M = TypeVar("M", bound="Entry")


class Entry(BaseModel):
    """A table of the file: unknown keys, texts for numbers, inf and nan are refused."""

    model_config = ConfigDict(extra="forbid", strict=True, allow_inf_nan=False, frozen=True)


class CampaignEntry(Entry):
    """``[campaign]``."""

    title: str = ""
    kind: Literal["captive", "free-running"] = "captive"
    forces: Literal["hydrodynamic", "balance"] = "hydrodynamic"
    rudder_positive: Literal["starboard", "port"] = "starboard"
    drift_positive: Literal["starboard-bow", "port-bow"] | None = None
    moment_reference_x: float | None = None
    moment_reference_z: float = 0.0
    motion_reference_x: float = 0.0
    free: list[Literal["surge", "heave", "pitch", "roll", "sway", "yaw", "trim", "sinkage"]] = []
    data_folder: str | None = None
    closed: bool = False


class EndEntry(Entry):
    """``[end]``, the last line of files that say ``closed = true``."""


class ShipEntry(Entry):
    """``[ship]``: the name of a library ship, or particulars in full."""

    name: str = ""
    L: Positive | None = None
    B: Positive | None = None
    d: Positive | None = None
    volume: Positive | None = None
    mass: Positive | None = None
    Izz: Positive | None = None
    Izz_about: Literal["midship", "centre of gravity"] = "midship"
    xG: float = 0.0
    zG: float | None = None
    GM: float | None = None
    Ix: Positive | None = None
    balance_mass: Positive | None = None
    balance_Izz: Positive | None = None
    balance_xG: float | None = None
    CB: Annotated[float, Field(gt=0, le=1)] | None = None


class WaterEntry(Entry):
    """``[water]``."""

    rho: Positive | None = None
    g: Positive = 9.81
    nu: Positive | None = None
    depth: Positive | None = None
    tank_width: Positive | None = None
    tank_depth: Positive | None = None


class SourceEntry(Entry):
    """``[source]``, of the campaign or of a run."""

    format: Format | None = None
    skip_rows: Count = 0
    encoding: str | None = None
    delimiter: Literal[",", ";", "\t", " ", "|"] | None = None
    decimal: Literal[".", ","] | None = None
    header: bool | None = None
    units_row: bool | None = None
    comment: Annotated[str, Field(min_length=1)] | None = None
    widths: Widths | None = None
    order: Names = ()
    sheet: str | Annotated[int, Field(ge=1)] | None = None
    group: str | None = None
    sample_rate: Positive | None = None
    missing: Literal["error", "drop"] = "error"
    nondimensional: Literal[SYSTEMS] | None = None  # type: ignore[valid-type]
    in_phase_with: Literal["displacement", "velocity", "acceleration"] | None = None

    @field_validator("encoding")
    @classmethod
    def _known_encoding(cls, name: str | None) -> str | None:
        try:
            if name is not None and "az09".encode(name).decode(name) != "az09":
                raise LookupError(name)
        except (LookupError, UnicodeError, ValueError) as error:
            raise ValueError(f"{name!r} is not an encoding of text, such as 'cp1252'") from error
        return name


class ColumnEntry(Entry):
    """One key of ``[columns]``: a header, a table, or false where there is no such column."""

    name: str | None = None
    column: Annotated[int, Field(ge=1)] | None = None
    unit: str | None = None
    scale: float = 1.0
    offset: float = 0.0
    absent: bool = False

    @model_validator(mode="before")
    @classmethod
    def _short_forms(cls, value: Any) -> Any:
        if isinstance(value, str):
            return {"name": value}
        if value is False:
            return {"absent": True}
        if not isinstance(value, dict):
            raise ValueError(
                'must be their name in quotes, a table such as { column = 2, unit = "m" }, or '
                f"false; it is {value!r}"
            )
        if "absent" in value or ("name" in value) == ("column" in value):
            raise ValueError("needs either name or column (counted from 1)")
        return value

    @field_validator("scale")
    @classmethod
    def _not_zero(cls, value: float) -> float:
        if value == 0:
            raise ValueError("must not be 0")
        return value


class AxesEntry(Entry):
    """``[axes]``: which way their axes point, seen in ours."""

    x: Literal["x", "+x", "-x"] = "x"
    y: Literal["y", "+y", "-y"] = "y"
    z: Literal["z", "+z", "-z"] = "z"


class NumericalEntry(Entry):
    """``U_SN`` of ``[cfd]``."""

    X: Annotated[float, Field(ge=0)] | None = None
    Y: Annotated[float, Field(ge=0)] | None = None
    N: Annotated[float, Field(ge=0)] | None = None
    K: Annotated[float, Field(ge=0)] | None = None


class ComputedEntry(Entry):
    """What ``[cfd]`` may say of one run."""

    rho_inf: Positive | None = None
    symmetry_factor: Positive | None = None
    moment_centre_moves: bool | None = None
    forces_in: Literal["body", "earth"] | None = None
    ramp_s: Annotated[float, Field(ge=0)] | None = None


class CfdEntry(ComputedEntry):
    """``[cfd]``."""

    moment_centre: float | None = None
    U_SN: NumericalEntry | None = None


class TrialEntry(Entry):
    """``[trial]``: what a record of a sea trial needs."""

    antenna_x: float = 0.0
    antenna_y: float = 0.0
    position_std: Annotated[float, Field(ge=0)] | None = None
    order: dict[str, float] = {}


class UncertainEntry(Entry):
    """One standard uncertainty."""

    std: Annotated[float, Field(ge=0)]
    unit: str | None = None
    shared: bool | None = None


class SettingsEntry(Entry):
    """What a test was set to; keys of a run, of a table and of a correction that sets."""

    speed: Positive | None = None
    drift_deg: Degrees | None = None
    heel_deg: Steep | None = None
    rudder_deg: Degrees | None = None
    propeller_rps: float | None = None
    period: Positive | None = None
    frequency_hz: Positive | None = None
    amplitude_m: Positive | None = None
    yaw_amplitude_deg: Annotated[float, Field(gt=0, lt=90)] | None = None
    path_amplitude_m: Positive | None = None
    phase_deg: float | None = None
    yaw_rate: float | None = None
    radius: float | None = None
    switch_deg: Degrees | None = None
    vdot_amplitude: float | None = None
    v_amplitude: float | None = None
    r_amplitude: float | None = None
    rdot_amplitude: float | None = None
    repeat_of: str | None = None

    @field_validator("radius", "vdot_amplitude", "v_amplitude", "r_amplitude", "rdot_amplitude")
    @classmethod
    def _not_zero(cls, value: float | None) -> float | None:
        if value == 0:
            raise ValueError("must not be 0")
        return value

    def settings(self) -> dict[str, Any]:
        """The settings that are given, by key."""
        return {
            name: getattr(self, name)
            for name in SettingsEntry.model_fields
            if getattr(self, name) is not None
        }


class DefaultsEntry(SettingsEntry):
    """``[defaults]``, and what it says of one kind of test."""

    source: SourceEntry | None = None
    columns: dict[str, ColumnEntry] = {}
    cfd: ComputedEntry | None = None

    @field_validator("columns")
    @classmethod
    def _names(cls, value: dict[str, ColumnEntry]) -> dict[str, ColumnEntry]:
        return known_columns(value)


class FileEntry(DefaultsEntry):
    """What runs and tables share."""

    id: Annotated[str, Field(min_length=1)]
    test: str
    file: Annotated[str, Field(min_length=1)]
    rows: Annotated[int, Field(ge=1)] | None = None

    @field_validator("test")
    @classmethod
    def _known_test(cls, value: str) -> str:
        if value not in kinds():
            raise ValueError(not_a_kind(value))
        return value


class RunEntry(FileEntry):
    """``[[runs]]``."""

    row: dict[str, Plain] | None = None
    motion: Annotated[str, Field(min_length=1)] | None = None

    @field_validator("row")
    @classmethod
    def _not_empty(cls, value: dict[str, Plain] | None) -> dict[str, Plain] | None:
        if value is not None and not value:
            raise ValueError('must name a column, e.g. { "Run No." = 376 }')
        return value

    @model_validator(mode="after")
    def _motion_of_a_history(self) -> RunEntry:
        if self.row is not None and self.motion is not None:
            raise ValueError("a row of a table has no motion: take row or motion away")
        return self


class TableEntry(FileEntry):
    """``[[tables]]``."""

    where: dict[str, Plain] = {}
    skip: list[Annotated[int, Field(ge=1)]] = []


class MatrixEntry(SettingsEntry):
    """``[[matrix]]``."""

    file: Annotated[str, Field(min_length=1)]
    source: SourceEntry | None = None
    id: Annotated[str, Field(min_length=1)]
    test: Annotated[str, Field(min_length=1)]
    tests: dict[str, str] = {}
    run: Annotated[str, Field(min_length=1)]
    run_sheet: Annotated[str, Field(min_length=1)] | None = None
    columns: dict[str, ColumnEntry] = {}
    where: dict[str, Plain] = {}
    skip: list[Annotated[int, Field(ge=1)]] = []

    @field_validator("columns")
    @classmethod
    def _names(cls, value: dict[str, ColumnEntry]) -> dict[str, ColumnEntry]:
        wrong = [name for name in value if name not in SETTING_UNITS]
        if wrong:
            raise ValueError(
                "; ".join(
                    f"{name!r} is no setting of a test{did_you_mean(name, SETTING_UNITS)}"
                    for name in wrong
                )
            )
        return value


class CorrectionEntry(SettingsEntry):
    """``[[corrections]]``."""

    runs: Listed
    action: Literal[ACTIONS]  # type: ignore[valid-type]
    reason: Annotated[str, Field(min_length=1)]
    channels: Listed = []
    factor: float | None = None
    value: float | None = None
    unit: str | None = None
    t_start: float | None = None
    t_end: float | None = None
    check: Annotated[str, Field(min_length=1)] | None = None

    @field_validator("channels")
    @classmethod
    def _known(cls, value: list[str]) -> list[str]:
        for name in value:
            if name not in CHANNEL_UNITS:
                raise ValueError(f"{name!r} is not a channel{did_you_mean(name, CHANNEL_UNITS)}")
        return value

    @model_validator(mode="after")
    def _complete(self) -> CorrectionEntry:
        needs: dict[str, tuple[str, ...]] = {
            "scale": ("channels", "factor"),
            "shift": ("channels", "value", "unit?"),
            "flip": ("channels",),
            "drop": ("channels",),
            "accept": ("check",),
            "trim": ("t_start?", "t_end?"),
            "tare": ("channels?", "t_start?", "t_end?"),
            "set": tuple(f"{name}?" for name in SettingsEntry.model_fields),
        }
        wanted = needs.get(self.action, ())
        allowed = {name.rstrip("?") for name in wanted} | {"runs", "action", "reason"}
        given = {name for name in self.model_fields_set if getattr(self, name) not in (None, [])}
        missing = [name for name in wanted if not name.endswith("?") and name not in given]
        if missing:
            raise ValueError(f"action {self.action!r} needs {' and '.join(missing)}")
        if self.action in ("trim", "set") and given <= {"runs", "action", "reason"}:
            what = "t_start or t_end" if self.action == "trim" else "a setting, e.g. drift_deg"
            raise ValueError(f"action {self.action!r} needs {what}")
        if given - allowed:
            surplus = ", ".join(sorted(given - allowed))
            raise ValueError(f"action {self.action!r} does not use {surplus}")
        if self.action == "scale" and self.factor == 0:
            raise ValueError("factor must not be 0")
        return self


def known_columns(value: dict[str, ColumnEntry]) -> dict[str, ColumnEntry]:
    """The ``[columns]`` with only names that a history or a table can have."""
    known = [*CHANNEL_UNITS, *DEGREE_CHANNELS, *SETTING_UNITS]
    parts = [
        f"{channel}_{part}"
        for channel in FORCE_CHANNELS
        for part in ("mean", "std", *(f"{way}{n}" for way in ("sin", "cos") for n in (1, 2, 3)))
    ]
    wrong = [name for name in value if unit_of(name, table=True) is None]
    if wrong:
        raise ValueError(
            "; ".join(
                f"{name!r} is not a name of ours"
                f"{did_you_mean(name, [*known, *parts]) or ' (left of the = stands our name)'}"
                for name in wrong
            )
        )
    return value


TABLES: Final[dict[str, type[Entry] | None]] = {
    "campaign": CampaignEntry,
    "ship": ShipEntry,
    "water": WaterEntry,
    "source": SourceEntry,
    "columns": None,
    "axes": AxesEntry,
    "cfd": CfdEntry,
    "propeller": None,
    "rudder": None,
    "trial": TrialEntry,
    "uncertainty": None,
    "corrections": CorrectionEntry,
    "defaults": DefaultsEntry,
    "matrix": MatrixEntry,
    "runs": RunEntry,
    "tables": TableEntry,
    "end": EndEntry,
}
"""Top-level tables of a campaign file; None where the keys are names and not fixed."""


def read_entry(
    model: type[M], raw: Any, *, file: str, entry: str, problems: list[Problem]
) -> M | None:
    """A validated table, or None with the reasons added to `problems`.

    Parameters
    ----------
    model : type
        The class of the table.
    raw : object
        What the TOML file holds.
    file, entry : str
        Name of the file and of the table, for messages.
    problems : list of Problem
        Gets a problem for each key that is wrong.
    """
    if not isinstance(raw, Mapping):
        problems.append(
            Problem(message=f"must be a table, not {_shown(raw)}.", file=file, entry=entry)
        )
        return None
    try:
        return model.model_validate(dict(raw))
    except ValidationError as error:
        for found in error.errors(include_url=False):
            problems.append(_problem(model, dict(found), file, entry))
    except DataError as error:
        problems += [Problem(message=str(error), file=file, entry=entry)]
    return None


def read_named(
    model: type[M], raw: Any, *, file: str, entry: str, problems: list[Problem]
) -> dict[str, M]:
    """A table whose keys are names, each value validated."""
    if not isinstance(raw, Mapping):
        problems.append(
            Problem(message=f"must be a table, not {_shown(raw)}.", file=file, entry=entry)
        )
        return {}
    found: dict[str, M] = {}
    for name, value in raw.items():
        try:
            found[name] = model.model_validate(value)
        except ValidationError as error:
            for item in error.errors(include_url=False):
                item["loc"] = (name, *item["loc"])
                problems.append(_problem(model, dict(item), file, entry))
    return found


def _problem(model: type[Entry], found: dict[str, Any], file: str, entry: str) -> Problem:
    place = [str(part) for part in found["loc"] if not str(part).startswith("function-")]
    key = ".".join(place)
    where = f"{entry}, key {key!r}" if key else entry
    return Problem(message=_words(model, found, place), file=file, entry=where)


def _words(model: type[Entry], found: dict[str, Any], place: list[str]) -> str:
    kind, given, extra = found["type"], found.get("input"), found.get("ctx", {})
    if kind == "extra_forbidden":
        return f"not known{did_you_mean(place[-1], _keys(model, place)) or '.'}"
    if kind == "missing":
        return "is missing."
    if kind == "literal_error":
        options = [option.strip("'") for option in _options(extra["expected"])]
        guess = did_you_mean(given, options) if isinstance(given, str) else ""
        return f"{_shown(given)} is not one of {', '.join(options)}{guess or '.'}"
    if kind in ("value_error", "assertion_error"):
        return str(extra.get("error", found["msg"])).rstrip(".") + "."
    bounds = {
        "greater_than": "greater than",
        "greater_than_equal": "at least",
        "less_than": "less than",
        "less_than_equal": "at most",
    }
    if kind in bounds:
        limit = next(iter(extra.values()))
        return f"must be {bounds[kind]} {limit:g}, it is {_shown(given)}."
    plain = {
        "float_type": "a number",
        "int_type": "a whole number",
        "string_type": "text in quotes",
        "bool_type": "true or false",
        "list_type": "a list",
        "dict_type": "a table",
        "model_type": "a table",
        "model_attributes_type": "a table",
        "finite_number": "a finite number",
        "int_from_float": "a whole number",
        "string_too_short": "not empty",
    }
    if kind in plain:
        return f"must be {plain[kind]}, it is {_shown(given)}."
    return f"{found['msg'].rstrip('.')}: {_shown(given)}."


def _options(expected: str) -> Iterable[str]:
    return expected.replace(" or ", ", ").split(", ")


def _keys(model: type[Entry], place: list[str]) -> list[str]:
    nested: dict[str, type[Entry]] = {
        "source": SourceEntry,
        "cfd": ComputedEntry,
        "U_SN": NumericalEntry,
        "columns": ColumnEntry,
    }
    if len(place) > 1 and place[0] in nested:
        return list(nested[place[0]].model_fields)
    return list(model.model_fields)


def _shown(value: Any) -> str:
    text = {True: "true", False: "false"}.get(value, "") if isinstance(value, bool) else ""
    text = text or repr(value)
    return text if len(text) <= 60 else text[:57] + "..."
