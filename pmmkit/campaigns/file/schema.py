"""What may stand in a campaign file: runs, settings and corrections, and how a table is read.

Nothing else of pmmkit sees these classes: `pmmkit.campaigns.file.campaign_file` turns them into
Ship, Run and Campaign. The module is imported only when a campaign file is read.
"""

from __future__ import annotations

from collections.abc import Mapping
from datetime import datetime
from typing import TYPE_CHECKING, Annotated, Any, Final, Literal, TypeVar

from pydantic import (
    AfterValidator,
    Field,
    ValidationError,
    create_model,
    field_validator,
    model_validator,
)

from pmmkit.base import DataError, did_you_mean
from pmmkit.campaigns.file.single_tables import (
    OTHER_UNITS,
    AxesEntry,
    CampaignEntry,
    CfdEntry,
    ColumnEntry,
    ComputedEntry,
    Faults,
    GaugeEntry,
    ImoEntry,
    Listed,
    NumericalEntry,
    Plain,
    ReportEntry,
    ShipEntry,
    SourceEntry,
    StrictTable,
    StrutsEntry,
    TrialEntry,
    WaterEntry,
    fault_words,
    in_range,
    said,
    shown,
)
from pmmkit.campaigns.run_settings import RUN_SETTINGS, unit_of
from pmmkit.campaigns.setting import RunSetting
from pmmkit.campaigns.test_kinds.kind import TEST_KINDS
from pmmkit.conventions import CHANNEL_UNITS, CHANNELS, DEGREE_CHANNELS, FORCE_CHANNELS

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


class _StatedSettings(StrictTable):
    """What a test was set to; keys of a run, of a table and of a correction that sets."""

    def settings(self) -> dict[str, Any]:
        """The settings that are given, by key."""
        return {
            name: getattr(self, name)
            for name in SettingsEntry.model_fields
            if getattr(self, name) is not None
        }


def _not_zero(value: float) -> float:
    if value == 0:
        raise ValueError("must not be 0")
    return value


def _without_control(text: str) -> str:
    if not "".join(text.split()).isprintable():
        raise ValueError(f"{shown(text)} holds a sign that would control a terminal")
    return text


def _number_of(setting: RunSetting) -> Any:
    """The type of a setting in a file, with its bounds."""
    bounds = setting.bounds
    if setting.unit in OTHER_UNITS and bounds.least and bounds.most:
        return Annotated[float, in_range(bounds.least, bounds.most, setting.unit)]
    limits = {"gt": bounds.above, "ge": bounds.least, "lt": bounds.below, "le": bounds.most}
    given: dict[str, Any] = {name: limit for name, limit in limits.items() if limit is not None}
    number: Any = Annotated[float, Field(**given)] if given else float
    return number if bounds.zero else Annotated[number, AfterValidator(_not_zero)]


if TYPE_CHECKING:
    SettingsEntry = _StatedSettings
else:
    SettingsEntry = create_model(
        "SettingsEntry",
        __base__=_StatedSettings,
        __doc__=_StatedSettings.__doc__,
        **{
            key: (_number_of(item) | None, said(item.meaning, None))
            for key, item in RUN_SETTINGS.by_key.items()
        },
        repeat_of=(str | None, said("id of the run that this one repeats", None)),
    )


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

    id: Annotated[str, Field(min_length=1), AfterValidator(_without_control)] = said(
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
        if value not in TEST_KINDS:
            raise ValueError(TEST_KINDS.unknown(value))
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
        wrong = [name for name in value if name not in RUN_SETTINGS.units]
        if wrong:
            raise ValueError(
                "; ".join(
                    f"{name!r} is no setting of a test{did_you_mean(name, RUN_SETTINGS.units)}"
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
    known = [*CHANNEL_UNITS, *DEGREE_CHANNELS, *RUN_SETTINGS.units]
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
    "end": StrictTable,
}
"""Top-level tables of a campaign file; None where the keys are names and not fixed."""


def read_entry(model: type[M], raw: Any, entry: str, out: Faults) -> M | None:
    """A validated table, or None with the reasons added to `out`."""
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
