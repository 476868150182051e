"""The modular model (MMG): KVLCC2 and KCS."""

from __future__ import annotations

from functools import cache

from pmmkit.equations import prepare
from pmmkit.models import load_model
from scripts.validation import measurements
from scripts.validation.forces import polynomial
from scripts.validation.published import Published, Values, table
from scripts.validation.sailed import of_zigzag, turns, zigzags

KCS_SPEED, L7_SPEED, FULL_SPEED = 24 * 0.514444, 1.179, 15.5 * 0.514444
KCS = {
    "sources": ("simman_2008",),
    "place": "the values of that study, sailed by another program",
    "nature": "recomputed",
    "part": "program",
    "how": "library ship `kcs` at 24 knots",
    "within": 0.015,
}
STEPS = (
    "That program steps by 0.2 s, so that events come up to a step late, and has sin β where the "
    "source has β."
)
KVLCC2 = {
    "sources": ("yasukawa_yoshimura_2015",),
    "place": "its values, sailed by another program",
    "nature": "recomputed",
    "part": "program",
    "within": 0.015,
}
HSVA = {
    "sources": ("simman_2008",),
    "place": "free-running tests of a 7 m model by HSVA, from the report of the tests",
    "nature": "measured",
    "part": "prediction",
}


@cache
def xdyn() -> Values:
    """Forces of the hull of KVLCC2 at u 1, v 2 m/s in the centre of gravity and r 3 rad/s."""
    model = load_model("kvlcc2")
    values = {k: x for k, x in model.values("hull_polynomial").items() if k != "Xuu"}
    return polynomial(values, model.ship, model.convention, u=1.0, v=2.0 - 3.0 * 11.1, r=3.0)


@cache
def revolutions() -> Values:
    """Of self-propulsion [rpm]."""
    return {"KCS at 24 knots": 60 * prepare(load_model("kcs"), KCS_SPEED).self_propulsion()}


FIGURES: tuple[Published, ...] = (
    *turns(
        "KCS, turning circles",
        "kcs",
        KCS_SPEED,
        {
            (35.0, "advance_L"): 3.365, (35.0, "transfer_L"): 1.578,
            (35.0, "tactical_diameter_L"): 3.587, (35.0, "steady_diameter_L"): 2.994,
            (35.0, "speed_ratio"): 0.501,
            (-35.0, "advance_L"): 3.251, (-35.0, "transfer_L"): 1.479,
            (-35.0, "tactical_diameter_L"): 3.361,
        },
        why=STEPS,
        **KCS,
    ),
    *zigzags(
        "KCS, zigzags",
        "kcs",
        KCS_SPEED,
        {(10, 10): (6.17, 12.3), (-10, 10): (7.88, 9.48),
         (20, 20): (14.0, 16.5), (-20, 20): (16.4, 14.2)},
        why=STEPS,
        **KCS,
    ),
    *table(
        "KCS, self-propulsion",
        {"KCS at 24 knots": 115.5},
        revolutions,
        unit="rpm",
        sources=("simman_2008",),
        place="as a public program quotes it",
        nature="printed",
        part="program",
        how="library ship `kcs`",
        within=5e-4,
    ),
    *turns(
        "KVLCC2, 7 m model, turning circles",
        "kvlcc2-l7",
        L7_SPEED,
        {
            (35.0, "advance_L"): 3.080, (35.0, "transfer_L"): 1.331,
            (35.0, "tactical_diameter_L"): 3.118, (35.0, "steady_diameter_L"): 2.32,
            (35.0, "speed_ratio"): 0.383,
            (-35.0, "advance_L"): 3.091, (-35.0, "transfer_L"): 1.332,
            (-35.0, "tactical_diameter_L"): 3.105, (-35.0, "steady_diameter_L"): 2.26,
        },
        how="library ship `kvlcc2-l7` at 1.179 m/s",
        **KVLCC2,
    ),
    *turns(
        "KVLCC2, full scale, turning circles",
        "kvlcc2",
        FULL_SPEED,
        {
            (35.0, "advance_L"): 2.976, (35.0, "tactical_diameter_L"): 3.004,
            (-35.0, "advance_L"): 3.001, (-35.0, "tactical_diameter_L"): 3.013,
        },
        how="library ship `kvlcc2` at 15.5 knots",
        **KVLCC2,
    ),
    *zigzags(
        "KVLCC2, 7 m model, zigzags",
        "kvlcc2-l7",
        L7_SPEED,
        {(10, 10): (4.98, 13.6), (-10, 10): (7.03, 8.81),
         (20, 20): (10.5, 15.7), (-20, 20): (13.7, 11.7)},
        how="library ship `kvlcc2-l7` at 1.179 m/s",
        **KVLCC2,
    ),
    *table(
        "KVLCC2, forces of the hull",
        {"X": 35918728522.330902, "Y": 2003246596640.8945, "N": -455883858001617.88},
        xdyn,
        unit={"X": "N", "Y": "N", "N": "N m"},
        sources=("xdyn", "yasukawa_yoshimura_2015"),
        place="expected values of its test of the MMG model, without resistance, ρ = 1000 kg/m³",
        nature="computed",
        part="program",
        how="the hull polynomial of library ship `kvlcc2`",
        within=1e-9,
    ),
    *zigzags(
        "KVLCC2, zigzags of HSVA, by the published model",
        "kvlcc2-l7",
        L7_SPEED,
        measurements.HSVA,
        how="library ship `kvlcc2-l7`, from captive tests of another model in another tank",
        within=0.65,
        why="Another model with another propeller and rudder gear; the published values are known "
        "to give too small a first overshoot at 10/10. Nothing is tuned to these tests.",
        **HSVA,
    ),
    *table(
        "KVLCC2, zigzags of HSVA, by captive tests of HMRI",
        {
            of_zigzag(*angles, number): angle
            for angles, found in measurements.HSVA.items()
            for number, angle in enumerate(found, start=1)
        },
        measurements.kept("hsva"),
        unit="°",
        how="the model that HMRI's captive tests give, carried to HSVA's scale, propeller and "
        "rudder ([cases.md](cases.md)); made with the measurements",
        within=0.65,
        why="A model of one laboratory sails the tests of another, and nothing is tuned. The "
        "captive tests lack the asymmetry of the rudder and its force at large angles "
        "([cases.md](cases.md) finds them).",
        **HSVA,
    ),
)  # fmt: skip
