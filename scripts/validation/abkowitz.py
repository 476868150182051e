"""The polynomial of Abkowitz, and that of the 190 000 dwt tanker."""

from __future__ import annotations

from functools import cache

from pmmkit.equations import prepare
from pmmkit.models import load_model
from pmmkit.simulation import stability
from scripts.validation.published import Published, Values, table
from scripts.validation.sailed import turns

SPEED, TANKER_SPEED = 7.7175, 8.23
SAILED = {
    "sources": ("chislett_strom_tejsen_1965", "fossen_perez_2004"),
    "place": "their values as `mariner.m` has them, sailed by another program",
    "nature": "recomputed",
    "part": "program",
}


@cache
def linear() -> Values:
    """The Mariner straight ahead."""
    found = stability("mariner", SPEED)
    ahead = SPEED / load_model("mariner").ship.L
    return {
        "C = Yv Nr - Nv (Yr - m')": found.C,
        "lever of sway, Nv/Yv": found.lever_sway,
        "lever of yaw": found.lever_yaw,
        "Yδ": found.rudder[0],
        "Nδ": found.rudder[1],
        "K": found.K * ahead,
        "T1": found.T1 / ahead,
        "T2": found.T2 / ahead,
        "T3": found.T3 / ahead,
    }


@cache
def tanker() -> Values:
    """Revolutions of self-propulsion [rpm]."""
    n = prepare(load_model("esso190k"), TANKER_SPEED).self_propulsion()
    return {"190 000 dwt tanker at 16 knots": 60 * n}


FIGURES: tuple[Published, ...] = (
    *turns(
        "Mariner, turning circles at 35°",
        "mariner",
        SPEED,
        {
            (35.0, "transfer_L"): 2.61, (35.0, "tactical_diameter_L"): 6.39,
            (35.0, "steady_diameter_L"): 6.91, (35.0, "speed_ratio"): 0.779,
            (-35.0, "transfer_L"): 2.73, (-35.0, "tactical_diameter_L"): 6.65,
            (-35.0, "steady_diameter_L"): 7.15,
        },
        rate=2.32,
        how="library ship `mariner` at 15 knots, rudder at 2.32°/s",
        within=2e-3,
        **SAILED,
    ),
    *turns(
        "Mariner, advance",
        "mariner",
        SPEED,
        {(35.0, "advance_L"): 3.67, (-35.0, "advance_L"): 3.85},
        rate=2.32,
        how="library ship `mariner` at 15 knots, rudder at 2.32°/s, which fits that program",
        within=0.015,
        **SAILED,
    ),
    *turns(
        "Mariner, turning circles at 15°",
        "mariner",
        SPEED,
        {(15.0, "tactical_diameter_L"): 7.91, (-15.0, "tactical_diameter_L"): 8.52},
        how="library ship `mariner` at 15 knots",
        within=2e-3,
        **SAILED,
    ),
    *table(
        "Mariner, straight-line stability",
        {
            "C = Yv Nr - Nv (Yr - m')": 1160e-5 * 166e-5 - 264e-5 * 499e-5,
            "lever of sway, Nv/Yv": 264 / 1160, "lever of yaw": 166 / 499,
            "Yδ": -278e-5, "Nδ": 139e-5,
        },
        linear,
        sources=("chislett_strom_tejsen_1965",),
        place="the table of derivatives",
        nature="printed",
        part="program",
        how="the equations of the simulator made linear at 15 knots",
        within=1e-5,
    ),
    *table(
        "Mariner, Nomoto's constants",
        {"K": 0.185, "T1": 118.0, "T2": 7.8, "T3": 18.5},
        linear,
        unit={"K": "1/s", "T1": "s", "T2": "s", "T3": "s"},
        sources=("fossen_2011", "fossen_perez_2004"),
        place="`exNomoto.m` and the textbook",
        nature="computed",
        part="program",
        how="the equations of the simulator made linear at 15 knots",
        within=6e-3,
    ),
    *table(
        "190 000 dwt tanker, self-propulsion",
        {"190 000 dwt tanker at 16 knots": 80.0},
        tanker,
        unit="rpm",
        sources=("van_berlekom_goddard_1972",),
        place="Appendix A",
        nature="printed",
        part="program",
        how="library ship `esso190k`",
        within=1e-3,
    ),
)  # fmt: skip
