"""What may stand in a campaign file: runs, settings and corrections, and how a table is read.

Nothing else of pmmkit sees these classes: `pmmkit.campaigns.file.campaign_file` turns them into
Ship, Run and Campaign. The module is imported only when a campaign file is read.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from datetime import datetime
from typing import Annotated, Any, Final, Literal, TypeVar

from pydantic import Field, ValidationError, field_validator, model_validator

from pmmkit.base import DataError, Problem, Remedy
from pmmkit.campaigns.file.report_entry import GaugeEntry, ReportEntry
from pmmkit.campaigns.file.single_tables import (
    AxesEntry,
    CampaignEntry,
    CfdEntry,
    ColumnEntry,
    ComputedEntry,
    Degrees,
    EndEntry,
    ImoEntry,
    Listed,
    NumericalEntry,
    Plain,
    Positive,
    ShipEntry,
    SourceEntry,
    Steep,
    StrictTable,
    StrutsEntry,
    TrialEntry,
    WaterEntry,
    said,
)
from pmmkit.campaigns.test_kinds.registry import kinds, not_a_kind
from pmmkit.conventions import (
    CHANNEL_UNITS,
    CHANNELS,
    DEGREE_CHANNELS,
    FORCE_CHANNELS,
    SETTING_UNITS,
    did_you_mean,
    unit_of,
)

# What is wrong with a key of a campaign file, in words.


@dataclass
class Faults:
    """What is wrong with a file, as it is found.

    Parameters
    ----------
    file : str
        Its name, for messages.
    problems : list of Problem
        What was found.
    """

    file: str
    problems: list[Problem] = field(default_factory=list)

    def report(
        self, message: str, entry: str | None = None, remedy: str | Remedy | None = None
    ) -> None:
        """Note a problem of an entry, such as ``[ship], key 'L'``."""
        self.problems.append(Problem(message=message, file=self.file, entry=entry, remedy=remedy))


def fault_words(found: Mapping[str, Any], key: str, known: Sequence[str]) -> str:
    """What is wrong with a key, from an error of pydantic."""
    kind, given, extra = found["type"], found.get("input"), found.get("ctx", {})
    if kind == "extra_forbidden":
        return f"not known{did_you_mean(key, known) or '.'}"
    if kind == "missing":
        return "is missing."
    if kind == "literal_error":
        listed = extra["expected"].replace(" or ", ", ").split(", ")
        options = [option.strip("'") for option in listed]
        guess = did_you_mean(given, options) if isinstance(given, str) else ""
        return f"{shown(given)} is not one of {', '.join(options)}{guess or '.'}"
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
        return f"must be {bounds[kind]} {limit:g}, it is {shown(given)}."
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
        return f"must be {plain[kind]}, it is {shown(given)}."
    return f"{found['msg'].rstrip('.')}: {shown(given)}."


def shown(value: Any) -> str:
    """A value of a file in a sentence, as TOML writes it, cut where it is long."""
    text = {True: "true", False: "false"}.get(value, "") if isinstance(value, bool) else ""
    text = text or repr(value)
    return text if len(text) <= 60 else text[:57] + "..."


ACTIONS: Final = (
    "exclude",
    "scale",
    "shift",
    "flip",
    "trim",
    "window",
    "tare",
    "drop",
    "drop means",
    "set",
    "inertia still inside",
    "inertia already removed",
    "accept",
)

Where = dict[str, Plain | list[Plain]]
M = TypeVar("M", bound="StrictTable")


class SettingsEntry(StrictTable):
    """What a test was set to; keys of a run, of a table and of a correction that sets."""

    speed: Positive | None = said("of the carriage, or of the approach [m/s]", None)
    drift_deg: Degrees | None = said("drift angle, signed as `drift_positive` says", None)
    heel_deg: Steep | None = said("heel, positive to starboard", None)
    rudder_deg: Degrees | None = said("rudder angle, signed as `rudder_positive` says", None)
    propeller_rps: float | None = said("revolutions [1/s]", None)
    period: Positive | None = said("of an oscillation [s]", None)
    frequency_hz: Positive | None = said("its inverse [Hz]", None)
    amplitude_m: Positive | None = said("of surge or sway [m]", None)
    yaw_amplitude_deg: Annotated[float, Field(gt=0, lt=90)] | None = said("of the heading", None)
    rudder_amplitude_deg: Annotated[float, Field(gt=0, lt=90)] | None = said(
        "of a rudder that swings, about `rudder_deg`", None
    )
    path_amplitude_m: Positive | None = said(
        "of the path of a pure yaw test instead [m]: the heading is atan(aω/U)", None
    )
    strut_amplitude_m: Positive | None = said("of each of two struts [m]", None)
    strut_phase_deg: Degrees | None = said("by which the forward strut leads", None)
    phase_deg: float | None = said("of the displacement at t = 0", None)
    yaw_rate: float | None = said("of a circle [rad/s]", None)
    radius: float | None = said("of a circle instead [m]", None)
    depth: Positive | None = said("of the water, where it is not that of [water] [m]", None)
    switch_deg: Degrees | None = said("heading at which a zigzag puts the rudder over", None)
    wave_height: Annotated[float, Field(ge=0)] | None = said(
        "significant height of the sea, of a free-running test [m]", None
    )
    wave_period: Positive | None = said("its peak period [s]", None)
    waves_from_deg: Annotated[float, Field(ge=-360, le=360)] | None = said(
        "where it comes from, clockwise from where the heading is zero", None
    )
    vdot_amplitude: float | None = said("v̇' of pure sway, instead of the amplitude", None)
    v_amplitude: float | None = said("v' of pure sway, instead of it", None)
    r_amplitude: float | None = said("r' of pure yaw, instead of the heading", None)
    rdot_amplitude: float | None = said("ṙ' of pure yaw, instead of it", None)
    repeat_of: str | None = said("id of the run that this one repeats", None)

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


class TareEntry(StrictTable):
    """``tare`` of a run or of ``[defaults]``: true, false, or where the rest is."""

    channels: list[Literal[CHANNELS]] = said("those that are tared; all if absent", [])  # type: ignore[valid-type]
    t_start: float | None = said("begin of the rest [s]; found if absent", None)
    t_end: float | None = said("its end [s]", None)
    off: bool = said("not tared: `tare = false`", False)

    @model_validator(mode="before")
    @classmethod
    def _short_forms(cls, value: Any) -> Any:
        if isinstance(value, bool):
            return {"off": not value}
        if not isinstance(value, dict) or "off" in value:
            raise ValueError(
                "must be true, false, or a table such as { t_start = 0.0, t_end = 3.0 }; it is "
                f"{shown(value)}"
            )
        return value


class DefaultsEntry(SettingsEntry):
    """``[defaults]``, and what it says of one kind of test."""

    source: SourceEntry | None = said("how the file is read, over `[source]`", None)
    columns: dict[str, ColumnEntry] = said("our names = theirs, over `[columns]`", {})
    cfd: ComputedEntry | None = said("what it says of one run, over `[cfd]`", None)
    tare: TareEntry | None = said(
        "zeros of the gauges from the rest of the record: true, false, or where the rest is", None
    )

    @field_validator("columns")
    @classmethod
    def _names(cls, value: dict[str, ColumnEntry]) -> dict[str, ColumnEntry]:
        return known_columns(value)


class FileEntry(DefaultsEntry):
    """What runs and tables share."""

    id: Annotated[str, Field(min_length=1)] = said(
        "name of the run; of a table, with their columns in braces"
    )
    test: str = said("kind of test")
    file: Annotated[str, Field(min_length=1)] = said(
        "where its data lie: a file, a pattern, or a folder"
    )
    rows: Annotated[int, Field(ge=1)] | None = said(
        "how many rows of numbers the file has; another number is refused", None
    )

    @field_validator("test")
    @classmethod
    def _known_test(cls, value: str) -> str:
        if value not in kinds():
            raise ValueError(not_a_kind(value))
        return value


class RunEntry(FileEntry):
    """``[[runs]]``."""

    row: dict[str, Plain] | None = said(
        'takes one row of a table of means or harmonics: `{ "Run No." = 376 }`', None
    )
    motion: Annotated[str, Field(min_length=1)] | None = said(
        "file with the path of the hull beside the forces", None
    )
    started: datetime | None = said("when it was made, such as 2026-05-04T09:15:00", None)

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
        if self.row is not None and self.tare and not self.tare.off:
            raise ValueError("a row of a table has no rest to tare by: take row or tare away")
        return self


class TableEntry(FileEntry):
    """``[[tables]]``."""

    where: Where = said('takes some rows: `{ Type = "Schräg" }`, or a list of values', {})
    skip: list[Annotated[int, Field(ge=1)]] = said("leaves rows out, counted from 1", [])
    samples: Literal["cycle", "time"] | None = said(
        "rows of one id are the samples of one run: of one cycle at even steps, or at the times "
        "of a column t",
        None,
    )

    @model_validator(mode="after")
    def _no_rest(self) -> TableEntry:
        if self.tare and not self.tare.off:
            raise ValueError("rows of a table have no rest to tare by: take tare away")
        return self


class MatrixEntry(SettingsEntry):
    """``[[matrix]]``."""

    file: Annotated[str, Field(min_length=1)] = said(
        "the table: a sheet of a workbook, or a text file"
    )
    source: SourceEntry | None = said("how the table is read", None)
    id: Annotated[str, Field(min_length=1)] = said("name of each run, with their columns in braces")
    test: Annotated[str, Field(min_length=1)] = said("kind of test, or a column in braces")
    tests: dict[str, str] = said("their words = our kinds of test", {})
    run: Annotated[str, Field(min_length=1)] = said(
        "where the history of each row lies, with columns in braces"
    )
    run_sheet: Annotated[str, Field(min_length=1)] | None = said(
        "its sheet, with columns in braces", None
    )
    columns: dict[str, ColumnEntry] = said("our settings = their columns", {})
    where: Where = said("takes some rows", {})
    skip: list[Annotated[int, Field(ge=1)]] = said("leaves rows out, counted from 1", [])

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

    runs: Listed = said("ids or patterns of the runs")
    action: Literal[ACTIONS] = said("what is done")  # type: ignore[valid-type]
    reason: Annotated[str, Field(min_length=1)] = said("why; it stands in the report")
    channels: Listed = said("of `scale`, `shift`, `flip`, `drop`, `tare`", [])
    factor: float | None = said("of `scale`", None)
    value: float | None = said("of `shift`", None)
    unit: str | None = said("of `shift`", None)
    t_start: float | None = said("of `trim`, `window` and `tare` [s]", None)
    t_end: float | None = said("of `trim`, `window` and `tare` [s]", None)
    check: Annotated[str, Field(min_length=1)] | None = said(
        "of `accept`: the check that is overruled", None
    )

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
            "window": ("t_start", "t_end"),
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
        if self.action == "window" and not (self.t_start or 0.0) < (self.t_end or 0.0):
            raise ValueError("t_end must be later than t_start")
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


TABLES: Final[dict[str, type[StrictTable] | None]] = {
    "campaign": CampaignEntry,
    "ship": ShipEntry,
    "water": WaterEntry,
    "source": SourceEntry,
    "columns": None,
    "axes": AxesEntry,
    "struts": StrutsEntry,
    "cfd": CfdEntry,
    "propeller": None,
    "rudder": None,
    "trial": TrialEntry,
    "imo": ImoEntry,
    "uncertainty": None,
    "report": ReportEntry,
    "corrections": CorrectionEntry,
    "defaults": DefaultsEntry,
    "matrix": MatrixEntry,
    "runs": RunEntry,
    "tables": TableEntry,
    "end": EndEntry,
}
"""Top-level tables of a campaign file; None where the keys are names and not fixed."""


def read_entry(model: type[M], raw: Any, entry: str, out: Faults) -> M | None:
    """A validated table, or None with the reasons added to `out`.

    Parameters
    ----------
    model : type
        The class of the table.
    raw : object
        What the TOML file holds.
    entry : str
        Name of the table, for messages.
    out : Faults
        Gets a problem for each key that is wrong.
    """
    if not isinstance(raw, Mapping):
        out.report(f"must be a table, not {shown(raw)}.", entry)
        return None
    try:
        return model.model_validate(dict(raw))
    except ValidationError as error:
        for found in error.errors(include_url=False):
            _report(model, dict(found), entry, out)
    except DataError as error:
        out.report(str(error), entry)
    return None


def read_named(model: type[M], raw: Any, entry: str, out: Faults) -> dict[str, M]:
    """A table whose keys are names, each value validated."""
    if not isinstance(raw, Mapping):
        out.report(f"must be a table, not {shown(raw)}.", entry)
        return {}
    found: dict[str, M] = {}
    for name, value in raw.items():
        try:
            found[name] = model.model_validate(value)
        except ValidationError as error:
            for item in error.errors(include_url=False):
                _report(model, {**item, "loc": (name, *item["loc"])}, entry, out)
    return found


def _report(model: type[StrictTable], found: dict[str, Any], entry: str, out: Faults) -> None:
    place = [str(part) for part in found["loc"] if not str(part).startswith("function-")]
    key = ".".join(place)
    words = fault_words(found, place[-1] if place else "", _keys(model, place))
    out.report(words, f"{entry}, key {key!r}" if key else entry)


def _keys(model: type[StrictTable], place: list[str]) -> list[str]:
    nested: dict[str, type[StrictTable]] = {
        "source": SourceEntry,
        "cfd": ComputedEntry,
        "tare": TareEntry,
        "U_SN": NumericalEntry,
        "columns": ColumnEntry,
        "gauges": GaugeEntry,
    }
    if len(place) > 1 and place[0] in nested:
        return list(nested[place[0]].model_fields)
    return list(model.model_fields)
