"""The file that describes model and tests: what the instructions ask for, and how to read the rest.

The items are those of the instructions of SIMMAN 2014 for model tests, a to j. What a campaign does
not state is said to be missing.
"""

from __future__ import annotations

import math
import textwrap
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Final

import numpy as np

from pmmkit.campaigns import Campaign
from pmmkit.exports.simman.tables import SimmanResult
from pmmkit.exports.text import written_by
from pmmkit.presentation import counted, number
from pmmkit.syntax import plain

if TYPE_CHECKING:
    from collections.abc import Iterator

LAYOUT: Final = 1
"""Version of the layout of the archive."""
MISSING: Final = "not supplied"
_WIDTH: Final = 88
_DIGITS: Final = 6


def metadata(
    campaign: Campaign,
    results: Sequence[SimmanResult],
    files: Mapping[str, str],
    rates: Sequence[float],
) -> str:
    """The text of ``metadata.txt``, ASCII.

    rates [Hz].
    """
    left = f", {len(campaign.excluded)} left out" if campaign.excluded else ""
    tests = f"{campaign.kind} tests, {counted(len(campaign), 'run')}{left}"
    chapters = {
        "Title": [campaign.title or MISSING, tests],
        "Asked for by the instructions": [
            f"{letter}. {what}: {_answer(campaign, letter, key, rates)}"
            for letter, (what, key) in ASKED.items()
        ],
        "Ship and water": _particulars(campaign),
        "Conventions": _conventions(campaign),
        "Files": [f"{name}: {what}" for name, what in files.items()],
        "Results": _results(campaign, results),
        "Not supplied": [
            f"{letter}. {what}: state it as {key} in [report] of the campaign file"
            for letter, (what, key) in ASKED.items()
            if key and campaign.report.get(key) is None and letter != "j"
        ],
        "What was not checked": [
            "The public instructions (SIMMAN 2014, format of model test results) say what is to be "
            "handed in. They give no names of files, no order of columns and no headers: those of "
            "this archive are pmmkit's. Whether a workshop's own programs read them is not known."
        ],
    }
    lines = [
        "SIMMAN model test results: model and test conditions",
        f"Layout of the archive: {LAYOUT}",
        *(line.removeprefix("# ") for line in written_by("#")),
    ]
    for title, points in chapters.items():
        if points:
            lines += ["", title, "-" * len(title)]
            for point in points:
                lines += textwrap.wrap(
                    plain(point), _WIDTH, initial_indent="- ", subsequent_indent="  "
                )
    return "\n".join(lines) + "\n"


ASKED: Final = {
    "a": ("model scale", "scale"),
    "b": ("model weight", ""),
    "c": ("model moment of inertia Izz", ""),
    "d": ("deviations in model geometry from the benchmark", "geometry_deviations"),
    "e": ("deviations in test conditions from the benchmark", "condition_deviations"),
    "f": ("method of turbulence stimulation", "turbulence_stimulation"),
    "g": ("method of frictional force correction", "friction_correction"),
    "h": ("strategy for adjusting the revolutions of the propeller", "revolutions"),
    "i": ("water temperature", "water_temperature"),
    "j": ("logging frequency", "sample_rate"),
}
"""The items of the instructions, and the key of ``[report]`` that answers each."""


def _answer(campaign: Campaign, letter: str, key: str, rates: Sequence[float]) -> str:
    ship = campaign.ship
    if letter == "b":
        weight = ship.mass * campaign.water.g
        return f"mass {number(ship.mass, _DIGITS)} kg, weight {number(weight, _DIGITS)} N"
    if letter == "c":
        gyration = math.sqrt(ship.Izz / ship.mass) / ship.L
        return (
            f"{number(ship.Izz, _DIGITS)} kg m2 about midship, radius of gyration "
            f"{number(gyration, 4)} L"
        )
    stated = campaign.report.get(key)
    if stated is None and letter == "j" and rates:
        found = ", ".join(number(rate, 5) for rate in rates)
        return f"{found} Hz, told from the records"
    if stated is None:
        return MISSING
    shown = number(stated, _DIGITS) if isinstance(stated, int | float) else str(stated)
    return {"a": f"1:{shown}", "i": f"{shown} deg C", "j": f"{shown} Hz"}.get(letter, shown)


def _particulars(campaign: Campaign) -> list[str]:
    ship, water = campaign.ship, campaign.water
    values = {
        "length between perpendiculars L": (ship.L, "m"),
        "breadth B": (ship.B, "m"),
        "draught d": (ship.d, "m"),
        "displaced volume": (ship.volume, "m3"),
        "centre of gravity forward of midship xG": (ship.xG, "m"),
        "centre of gravity below the waterline zG": (ship.zG, "m"),
        "metacentric height GM": (ship.GM, "m"),
        "inertia of roll": (ship.Ixx, "kg m2"),
        "mass on the balance": (ship.balance_mass, "kg"),
        "its inertia of yaw about midship": (ship.balance_Izz, "kg m2"),
        "its centre of gravity forward of midship": (ship.balance_xG, "m"),
        "density": (water.rho, "kg/m3"),
        "gravity": (water.g, "m/s2"),
        "kinematic viscosity": (water.nu, "m2/s"),
        "water depth": (water.depth, "m"),
        "width of the tank": (water.tank_width, "m"),
    }
    known = [
        f"{what}: {number(value, _DIGITS)} {unit}"
        for what, (value, unit) in values.items()
        if value is not None
    ]
    free = f"free to move in {', '.join(campaign.free)}" if campaign.free else ""
    return [f"ship: {ship.name}", *known, *([free] if free else [])]


def _conventions(campaign: Campaign) -> list[str]:
    common = [
        "Model scale, SI units, angles in radians, revolutions in 1/s. Numbers have as many digits "
        "as give the same double-precision number again, 17 at most.",
        "Axes: right-handed, horizontal, fixed to the ship; x forward of midship, y to starboard "
        "of the centre line, z down from the waterline (ITTC Symbols and Terminology List, version "
        "2002, as the instructions say). N and r are positive from bow to starboard.",
        "delta, the rudder angle, is positive where it turns the ship to starboard; what was "
        "found of the instructions does not say which way.",
    ]
    if campaign.kind == "free-running":
        return [*common, "x, y, psi: place of midship on the earth, heading from the x axis."]
    return [
        *common,
        "psi in the tank: heading to starboard of the way of the carriage. Drift to this heading "
        "gives v = -U sin(psi).",
        "Forces in static_means.csv, fourier_*.csv and cycles/ are those of the water on the hull "
        "and all that is fitted to it, about midship; the inertia of the model is not in them.",
        f"Forces in records/ are {campaign.forces_in_words}, about the point that "
        "records/campaign.toml states.",
        "Phase: theta = omega t with the displacement (heading of yaw tests, sway of sway tests) "
        "going as sin(theta). f = mean + sum over k of cosk cos(k theta) + sink sin(k theta): "
        "cos1 is in phase with the velocity, sin1 with the displacement.",
        "X_std and so on: standard uncertainty of a mean from the noise of its record.",
        "Velocities and accelerations are measured ones where they were recorded, else those that "
        "the test was set to.",
    ]


def _results(campaign: Campaign, results: Sequence[SimmanResult]) -> list[str]:
    if campaign.kind == "free-running":
        return [
            "Fourier coefficients are not given: a free manoeuvre has no cycle.",
            *_excluded(campaign),
        ]
    return [*_cycles(results), *_tables(results), *_unknown(results), *_excluded(campaign)]


def _cycles(results: Sequence[SimmanResult]) -> Iterator[str]:
    recorded = [item for item in results if item.run.dynamic and item.recorded]
    if recorded:
        order = max(int(item.labels[-1][1:]) for item in recorded)
        least, most = (pick(item.cycles or 0 for item in recorded) for pick in (min, max))
        yield (
            f"Cycles and Fourier coefficients: least squares over {least} whole cycles"
            f"{f' or more, up to {most},' if most > least else ''} of a record, harmonics up to "
            f"{order}; a cycle is the sum of these harmonics, which is the only filter, at equal "
            "steps from the upcrossing of the displacement. The next row would be the first one "
            "again. x, y and psi are integrated from the velocities; x counts from the first row, "
            "y about a mean of 0."
        )


def _tables(results: Sequence[SimmanResult]) -> Iterator[str]:
    bare = [item.run.id for item in results if item.run.dynamic and not item.recorded]
    if bare:
        yield f"No time series: the source is a table of harmonics of {', '.join(bare)}."
    means = [item.run.id for item in results if not item.run.dynamic and not item.recorded]
    if means:
        yield f"No times: the source is a table of means of {', '.join(means)}."


def _unknown(results: Sequence[SimmanResult]) -> Iterator[str]:
    for item in results:
        lost = [name for name, x in item.force.items() if not np.isfinite(x).all()]
        if lost:
            yield (
                f"{item.run.id}: some coefficients of {', '.join(lost)} are not known or known to "
                "be wrong, and left empty; such a force has no cycle."
            )


def _excluded(campaign: Campaign) -> Iterator[str]:
    for run, reason in campaign.excluded:
        yield f"{run.id} is left out of the results: {reason or 'no reason stated'}."
