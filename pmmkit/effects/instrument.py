"""Faults of a measurement: what the diagnosis weighs against physics, and the check at the bench.

They act on what is recorded, never on the ship: no model has one as a part. Their columns stand in
`pmmkit.diagnosis.captive.faults`, for they need the runs.
"""

from __future__ import annotations

from typing import Final

from pmmkit.effects.effect import Effect, Parameter

ITTC_CAPTIVE: Final = "ITTC 7.5-02-06-02, captive model tests"
ITTC_UNCERTAINTY: Final = "ITTC 7.5-02-06-04, uncertainty of captive model tests"


def fault(
    name: str,
    family: str,
    summary: str,
    sizes: tuple[Parameter, ...],
    *,
    check: str,
    source: str = ITTC_UNCERTAINTY,
    excites: tuple[str, ...] = (),
) -> Effect:
    """A fault of a measurement, with sizes that are usual in a towing tank."""
    return Effect(
        name=name,
        family=family,
        kind="observation",
        summary=summary,
        parameters=sizes,
        source=source,
        check=check,
        excites=excites,
    )


def _size(name: str, unit: str, typical: float, text: str) -> Parameter:
    return Parameter(name=name, unit=unit, typical=typical, text=text)


EFFECTS: Final = (
    fault(
        "fault_misalignment",
        "alignment",
        "The model stands turned on the carriage.",
        (_size("turned", "deg", 0.26, "angle of the model, bow to starboard"),),
        check="turn the model by 180° and repeat static drift",
    ),
    fault(
        "current",
        "alignment",
        "Water moves across the tank.",
        (_size("current", "m/s", 0.0075, "velocity of the water"),),
        check="static drift at low speed, or after a longer wait",
    ),
    fault(
        "fault_gauge_zero",
        "asymmetry",
        "Gauges that do not show zero at rest: constant newtons.",
        (_size("Y", "N", 2.4, "shown at rest"), _size("N", "N m", 3.5, "shown at rest")),
        check="zero records before and after, and a slow run",
    ),
    fault(
        "fault_time_lag",
        "timing",
        "Forces come later than the motion.",
        (_size("lag", "s", 0.04, "delay of the forces"),),
        check="a knock that both clocks see",
        source=ITTC_CAPTIVE,
    ),
    fault(
        "fault_filter_lag",
        "timing",
        "A filter on the forces and not on the motion.",
        (
            _size("share", "-", 0.1, "of a one-pole filter; 1 is the whole filter"),
            Parameter(name="corner", unit="1/s", text="corner [Hz]"),
        ),
        check="the filter's settings; a knock",
        source=ITTC_CAPTIVE,
    ),
    fault(
        "fault_cross_talk",
        "gauges",
        "One channel of the balance shows part of another.",
        (
            _size("share", "-", 0.010, "of the other channel"),
            Parameter(name="into", text="Y in X (0), X in Y (1)"),
        ),
        check="pull with weights along each axis",
    ),
    fault(
        "fault_gauge_gain",
        "gauges",
        "The side force gauge shows too much.",
        (_size("share", "-", 0.03, "of the side force"),),
        check="weights; oscillate the dry model",
    ),
    fault(
        "fault_moment_point",
        "gauges",
        "Moments about another point than stated.",
        (_size("x over L", "-", 0.01, "the point forward of the one stated"),),
        check="a weight at a known lever",
    ),
    fault(
        "fault_inertia",
        "gauges",
        "Part of the model's inertia left in the forces.",
        (_size("mass share", "-", 0.02, "of the mass"),),
        check="oscillate the dry model; weigh it",
    ),
    fault(
        "fault_pmm_amplitude",
        "rig",
        "Sway larger than stated.",
        (_size("share", "-", 0.03, "of the sway"),),
        check="measure the motion",
    ),
    fault(
        "fault_pmm_phase",
        "rig",
        "Rams out of step: pure yaw sways.",
        (
            _size("phase", "deg", 1.0, "between the rams"),
            Parameter(name="combined", text="in yaw alone (0), with sway too (1)"),
        ),
        check="record both rams",
    ),
    fault(
        "fault_gauge_drift",
        "gauges",
        "Gauges that creep during a run.",
        (
            _size("Y", "N/min", 2.0, "creep of the side force"),
            _size("N", "N m/min", 3.0, "creep of the moment"),
        ),
        check="zero records after each run",
    ),
    fault(
        "fault_carriage_speed",
        "rig",
        "The carriage is faster than stated at one speed.",
        (
            _size("share", "-", 0.010, "of the speed"),
            Parameter(name="speed", unit="m/s", text="speed [m/s]"),
        ),
        check="an independent speed log",
        excites=("several speeds",),
    ),
    fault(
        "fault_transient",
        "rig",
        "Forces of the start that have not died away.",
        (
            _size("share", "-", 0.08, "of the force of each run"),
            Parameter(name="decay", text="decay in L/U"),
        ),
        check="leave out more cycles",
        source=ITTC_CAPTIVE,
    ),
)
