"""Tables of a campaign file that stand once: the campaign, ship, water, source, axes and so on.

Every key says what it means in its description, from which docs/formats.md is made.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from datetime import date
from typing import Annotated, Any, Final, Literal

from pydantic import (
    AfterValidator,
    BaseModel,
    BeforeValidator,
    ConfigDict,
    Field,
    PlainValidator,
    field_validator,
    model_validator,
)
from pydantic_core import PydanticCustomError, PydanticUndefined

from pmmkit.base import Problem, Remedy, did_you_mean
from pmmkit.conventions import System, unit_factor
from pmmkit.readers import READERS

# What is wrong with a key of a campaign file, in words.


@dataclass
class Faults:
    """What is wrong with a file, as it is found.

    `file`: its name, for messages.
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


def said(text: str, default: Any = PydanticUndefined) -> Any:
    """A key with what it means; required where there is no default."""
    return Field(default, description=text)


def _as_tuple(value: Any) -> Any:
    """A list as a tuple, which can be hashed."""
    return tuple(value) if isinstance(value, list) else value


def _known_format(name: Any) -> Any:
    """A format that is read, asked when a file is read: readers of other packages count."""
    if name in tuple(READERS):
        return name
    raise PydanticCustomError(
        "literal_error", "Input should be {expected}", {"expected": ", ".join(READERS)}
    )


def in_range(least: float, most: float, unit: str) -> AfterValidator:
    """What holds a number to the limits that any test has; beyond them another unit was meant."""

    def within(value: float) -> float:
        if least <= value <= most:
            return value
        meant = (
            f"{value * factor:.6g} if it is in {other}"
            for other in OTHER_UNITS[unit]
            if least <= value * (factor := unit_factor(other)[1]) <= most
        )
        write = ", ".join(meant)
        raise ValueError(
            f"is {value:g} {unit}, and tests have {least:g} to {most:g} {unit}"
            f"{'; write ' if write else ''}{write}"
        )

    return AfterValidator(within)


OTHER_UNITS: Final = {"m": ("mm", "cm", "ft", "km"), "s": ("ms", "min"), "m/s": ("mm/s", "kn")}
"""Units in which a number is often given by mistake."""
Positive = Annotated[float, Field(gt=0)]
Length = Annotated[float, in_range(0.5, 500.0, "m")]
"""Of models and ships: the smallest models are of .8 m, the longest ship built is of 458 m."""
Count = Annotated[int, Field(ge=0)]
Listed = Annotated[list[str], BeforeValidator(lambda it: [it] if isinstance(it, str) else it)]
Widths = Annotated[
    tuple[Annotated[int, Field(ge=1)], ...], Field(min_length=2), BeforeValidator(_as_tuple)
]
Names = Annotated[tuple[str, ...], BeforeValidator(_as_tuple)]
Format = Annotated[str, PlainValidator(_known_format)]
Plain = str | float | int | bool
Pairs = Annotated[
    tuple[tuple[str, Plain], ...],
    BeforeValidator(lambda it: tuple(it.items()) if isinstance(it, dict) else it),
]


class StrictTable(BaseModel):
    """A table of the file: unknown keys, texts for numbers, inf and nan are refused."""

    model_config = ConfigDict(extra="forbid", strict=True, allow_inf_nan=False, frozen=True)


class CampaignEntry(StrictTable):
    """``[campaign]``."""

    title: str = said("title of reports", "")
    kind: Literal["captive", "free-running"] = said(
        "tests of a held model, or of one that sails by itself", "captive"
    )
    forces: Literal["hydrodynamic", "balance"] = said(
        "those of the water, or the reading of the balance: the model's inertia is still inside",
        "hydrodynamic",
    )
    rudder_positive: Literal["starboard", "port"] = said(
        "which way the ship turns for a positive rudder", "starboard"
    )
    drift_positive: Literal["starboard-bow", "port-bow"] | None = said(
        "on which bow of the way she points for a positive drift angle; if absent drift angles go "
        "with `[axes]`: starboard where none is turned",
        None,
    )
    moment_reference_x: float | None = said(
        "point to which moments refer, forward of midship [m]; midship if absent", None
    )
    moment_reference_z: float = said("the same, below the origin [m]", 0.0)
    side_gauges_x: Annotated[list[float], Field(min_length=2, max_length=2)] | None = said(
        "of two gauges of the side force, `Y_forward` and `Y_aft`: forward of midship [m]", None
    )
    motion_reference_x: float = said("point to which motions refer, forward of midship [m]", 0.0)
    free: list[Literal["surge", "heave", "pitch", "roll", "sway", "yaw", "trim", "sinkage"]] = said(
        "motions that the mount leaves free", []
    )
    data_folder: str | None = said(
        "folder below `--data` or `PMMKIT_DATA` where the files lie", None
    )
    closed: bool = said(
        "the last line of the file is `[end]`, and a file that lost it is refused as cut off", False
    )
    planned: bool = said("runs whose file is not there are not made yet, and left out", False)


class ShipEntry(StrictTable):
    """``[ship]``: the name of a library ship, or particulars in full."""

    name: str = said("of the ship; alone: a ship of the library", "")
    L: Length | None = said("length between perpendiculars [m]", None)
    B: Positive | None = said("breadth [m]", None)
    d: Positive | None = said("draught [m]", None)
    volume: Positive | None = said("displaced volume [m³]; mass over density if absent", None)
    mass: Positive | None = said("mass as tested [kg]; density times volume if absent", None)
    Izz: Positive | None = said("inertia of yaw [kg m²]", None)
    Izz_about: Literal["midship", "centre of gravity"] = said(
        "point to which Izz refers", "midship"
    )
    xG: float | None = said(
        "centre of gravity forward of midship [m]; if absent 0, of a balance's forces ± 0.04 L",
        None,
    )
    zG: float | None = said("centre of gravity below the origin [m]", None)
    GM: float | None = said("metacentric height [m], of a model that rolls", None)
    Ix: Positive | None = said("inertia of roll [kg m²], of a model that rolls", None)
    balance_mass: Positive | None = said(
        "mass that hangs on the balance, if it is another [kg]", None
    )
    balance_Izz: Positive | None = said("its inertia of yaw [kg m²]", None)
    balance_xG: float | None = said("its centre of gravity forward of midship [m]", None)
    CB: Annotated[float, Field(gt=0, le=1)] | None = said(
        "block coefficient as published; volume over L B d if absent", None
    )


class WaterEntry(StrictTable):
    """``[water]``."""

    rho: Positive | None = said("density [kg/m³]", None)
    g: Positive = said("gravity [m/s²]", 9.81)
    nu: Positive | None = said("kinematic viscosity [m²/s]", None)
    depth: Positive | None = said("depth of the water [m]; deep if absent", None)
    tank_width: Positive | None = said("width of the tank [m]", None)
    tank_depth: Positive | None = said("depth of the tank [m]", None)


class SourceEntry(StrictTable):
    """``[source]``, of the campaign or of a run."""

    format: Format | None = said(
        "one of those below; otherwise by the suffix, else by content", None
    )
    skip_rows: Count = said("rows before the names of the columns", 0)
    last_row: Annotated[int, Field(ge=1)] | None = said(
        "last row of a sheet that is read, counted from 1: below it stands something else", None
    )
    encoding: str | None = said("of text, such as `cp1252`; found if absent", None)
    delimiter: Literal[",", ";", "\t", " ", "|"] | None = said(
        "between columns; found if absent", None
    )
    decimal: Literal[".", ","] | None = said("decimal point; found if absent", None)
    header: bool | None = said("whether there are names of columns; found if absent", None)
    units_row: bool | None = said("whether a row of units follows the names", None)
    comment: Annotated[str, Field(min_length=1)] | None = said("what comments begin with", None)
    widths: Widths | None = said("columns of fixed width [characters]", None)
    order: Names = said("exports of one run in the order in which they were computed", ())
    sheet: str | Annotated[int, Field(ge=1)] | None = said(
        "sheet of a workbook, by name or number", None
    )
    group: str | None = said("struct, group or run of a MATLAB, TDMS or HDF5 file", None)
    where: Pairs = said("rows of a text that are the run's: `{ Run = 7 }`", ())
    sample_rate: Positive | None = said("samples a second [Hz] where no column is a time", None)
    missing: Literal["error", "drop"] = said(
        "`drop` leaves out rows with empty values; else they are errors", "error"
    )
    nondimensional: System | None = said(
        "system in which the forces of the file are non-dimensional", None
    )
    in_phase_with: Literal["displacement", "velocity", "acceleration"] | None = said(
        'what the source\'s "in phase" means', None
    )

    @field_validator("encoding")
    @classmethod
    def _known_encoding(cls, name: str | None) -> str | None:
        try:
            if name is not None and "az09".encode(name).decode(name) != "az09":
                raise LookupError(name)
        except (LookupError, UnicodeError, ValueError) as error:
            raise ValueError(f"{name!r} is not an encoding of text, such as 'cp1252'") from error
        return name


class ColumnEntry(StrictTable):
    """One key of ``[columns]``: a header, a table, or false where there is no such column."""

    name: str | None = said("header of their column", None)
    column: Annotated[int, Field(ge=1)] | None = said("its number instead, counted from 1", None)
    unit: str | None = said("in which it is, where its header does not say", None)
    scale: float = said("factor on it", 1.0)
    offset: float = said("added to it after the factor", 0.0)
    absent: bool = said("not written: `x = false` says that there is no such column", False)

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


class AxesEntry(StrictTable):
    """``[axes]``: which way their axes point, seen in ours."""

    x: Literal["x", "+x", "-x"] = said("their x seen in ours", "x")
    y: Literal["y", "+y", "-y"] = said("their y seen in ours", "y")
    z: Literal["z", "+z", "-z"] = said("their z seen in ours", "z")


class StrutsEntry(StrictTable):
    """``[struts]``: a mechanism that swings the model by two struts."""

    spacing: Positive = said("between the struts along the rails [m]")
    centre_x: float = said("the point midway, forward of midship [m]", 0.0)
    slides: Literal["aft", "forward"] = said("the strut that slides along the hull", "aft")


class NumericalEntry(StrictTable):
    """``U_SN`` of ``[cfd]``."""

    X: Annotated[float, Field(ge=0)] | None = said("of the surge force [N]", None)
    Y: Annotated[float, Field(ge=0)] | None = said("of the sway force [N]", None)
    N: Annotated[float, Field(ge=0)] | None = said("of the yaw moment [N m]", None)
    K: Annotated[float, Field(ge=0)] | None = said("of the roll moment [N m]", None)


class ComputedEntry(StrictTable):
    """What ``[cfd]`` may say of one run."""

    rho_inf: Positive | None = said(
        "density that the solver had [kg/m³], where forces have to be scaled by it", None
    )
    symmetry_factor: Positive | None = said("2 if half a ship was computed; 1 if absent", None)
    moment_centre_moves: bool | None = said(
        "whether the point of the moments moves with the hull; `true` if absent", None
    )
    forces_in: Literal["body", "earth", "carriage"] | None = said(
        "along what forces are stated: the hull, axes that stay where they were, or the way of the "
        "carriage or arm; `body` if absent",
        None,
    )
    ramp_s: Annotated[float, Field(ge=0)] | None = said(
        "start-up that is cut off each history [s]", None
    )


class CfdEntry(ComputedEntry):
    """``[cfd]``."""

    moment_centre: float | None = said("where moments refer at rest, forward of midship [m]", None)
    U_SN: NumericalEntry | None = said(
        "numerical standard uncertainty of X, Y, N, K [N, N m], a zero error common to all runs",
        None,
    )


class TrialEntry(StrictTable):
    """``[trial]``: what a record of a sea trial needs."""

    antenna_x: float = said("antenna forward of midship [m]", 0.0)
    antenna_y: float = said("antenna to starboard [m]", 0.0)
    position_std: Annotated[float, Field(ge=0)] | None = said(
        "standard deviation of a position [m]", None
    )
    order: dict[str, float] = said("instant of the order [s] by run", {})


class UncertainEntry(StrictTable):
    """One standard uncertainty."""

    std: Annotated[float, Field(ge=0)] = said("standard uncertainty")
    unit: str | None = said("its unit, or `%`", None)
    shared: bool | None = said("the same error in all runs; else each draws its own", None)
    common: str = said("cause that it shares with others, such as the weights of a calibration", "")


# The table ``[imo]``: what the form of MSC/Circ.1053 asks for and no record holds.


class ImoEntry(StrictTable):
    """``[imo]``, of a campaign file or of a file of its own."""

    administration: str | None = said("to which the form goes", None)
    reference: str | None = said("reference number that the administration assigns", None)
    ship_type: str | None = said("such as container ship, tanker, bulk carrier", None)
    rudder_type: str | None = said("such as full spade, semi-spade, high lift", None)
    rudders: Annotated[int, Field(ge=0)] | None = said("how many", None)
    rudder_area: Positive | None = said("of all rudders together [m²]", None)
    propeller_type: str | None = said("such as fixed pitch, controllable pitch, with nozzle", None)
    propellers: Annotated[int, Field(ge=0)] | None = said("how many", None)
    engine_type: str | None = said("such as diesel, steam turbine, diesel-electric", None)
    full_load_draught: Positive | None = said("mean draught of full load [m]", None)
    full_load_trim: float | None = said("trim of full load, by the stern positive [m]", None)
    full_load_block: Annotated[float, Field(gt=0, le=1)] | None = said(
        "block coefficient of full load; that of `[ship]` where its draught is that of full load",
        None,
    )
    ballast: str | None = said("the ballast condition in words", None)
    draught_fore: Positive | None = said("draught forward as tried [m]", None)
    draught_aft: Positive | None = said("draught aft as tried [m]", None)
    wind_beaufort: Annotated[int, Field(ge=0, le=12)] | None = said(
        "wind of the trial; a recorded wind counts before it", None
    )
    sea_state: Annotated[int, Field(ge=0, le=9)] | None = said("waves of the trial", None)
    speed_85: Positive | None = said("speed at 85 % of the engine's largest output [m/s]", None)
    place: str | None = said("of the trial", None)
    date: str | None = said("of the trial", None)
    remarks: Names | None = said("sentences for the form", None)


# ``[report]``: what a test report says and no other table of the campaign file holds.


def _as_text(value: Any) -> Any:
    """A date as it is written, in quotes or without."""
    return value.isoformat() if isinstance(value, date) else value


Day = Annotated[str, BeforeValidator(_as_text)]


class GaugeEntry(StrictTable):
    """``[report.gauges.NAME]``: one gauge of the balance, or any other instrument."""

    type: str | None = said("make and type", None)
    capacity: str | None = said("capacity, with its unit", None)
    calibrated: Day | None = said("date of the calibration, such as 2026-05-04", None)
    certificate: str | None = said("its certificate", None)


class ReportEntry(StrictTable):
    """``[report]``; each description is the label in the report."""

    number: str | None = said("number of the report", None)
    revision: str | None = said("revision", None)
    issued: Day | None = said("date of issue", None)
    customer: str | None = said("customer", None)
    laboratory: str | None = said("laboratory", None)
    authors: Listed = said("authors", [])
    approved_by: str | None = said("approved by", None)
    tested: Day | None = said("when the tests were made", None)
    purpose: str | None = said("purpose of the tests", None)

    scale: Positive | None = said("scale λ of the model, 36 for 1:36", None)
    model_number: str | None = said("number of the model", None)
    model_material: str | None = said("material of the model", None)
    model_made: str | None = said("maker of the model, and how its shape was checked", None)
    hull_lines: str | None = said("lines plan or other source of the geometry", None)
    draught_forward: Positive | None = said("draught at the forward perpendicular [m]", None)
    draught_aft: Positive | None = said("draught at the aft perpendicular [m]", None)
    wetted_surface: Positive | None = said("wetted surface at rest [m²]", None)
    appendages: str | None = said("appendages fitted, or none", None)
    propeller_fitted: str | None = said("propeller fitted, or none", None)
    rudder_fitted: str | None = said("rudder fitted, or none", None)
    turbulence_stimulation: str | None = said("turbulence stimulation", None)
    loading: str | None = said("how the model was loaded", None)
    inertia_found: str | None = said(
        "how mass, centre of gravity and inertia of the model were found", None
    )

    facility: str | None = said("tank or basin", None)
    tank_length: Positive | None = said("length of the tank [m]", None)
    bottom: str | None = said("bottom of the tank, and how level it is", None)
    wave_absorption: str | None = said("beaches and other means against waves", None)
    water_temperature: float | None = said("temperature of the water [°C]", None)

    carriage: str | None = said("carriage", None)
    mechanism: str | None = said("mechanism that moves the model (PMM, arm …), its range", None)
    mount: str | None = said("how the model is held", None)
    speed_regulation: str | None = said("how steady the speed of the carriage is", None)

    gauges: dict[str, GaugeEntry] = said("gauges, each a table under its name", {})
    acquisition: str | None = said("data acquisition", None)
    sample_rate: Positive | None = said("samples a second as recorded [Hz]", None)
    analogue_filter: str | None = said("filter before the record was sampled", None)

    waiting_time: Positive | None = said("time of waiting between runs [s]", None)
    zero_readings: str | None = said("when and how zeros were read", None)
    run_order: str | None = said("order in which the runs were made", None)
    revolutions: str | None = said("how the revolutions of the propeller were chosen", None)
    friction_correction: str | None = said("correction of friction during the tests", None)
    inspection: str | None = said("what was seen by eye: waves, spray, air, vibration", None)

    geometry_deviations: str | None = said(
        "deviations of the geometry from that of the benchmark", None
    )
    condition_deviations: str | None = said(
        "deviations of the test conditions from those of the benchmark", None
    )
    deviations: str | None = said("deviations from what was agreed", None)
    remarks: str | None = said("remarks and reservations", None)
