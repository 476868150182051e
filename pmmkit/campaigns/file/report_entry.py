"""``[report]``: what a test report says and no other table of the campaign file holds."""

from __future__ import annotations

from datetime import date
from typing import Annotated, Any

from pydantic import BeforeValidator

from pmmkit.campaigns.file.single_tables import Listed, Positive, StrictTable, said


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
