"""Ours where it takes other people's files: computed where they are, kept in measurements.toml.

The files belong to their laboratories and are no part of the repository; what comes of them stands
in the table beside this file, so that the page is the same with them and without.
"""

from __future__ import annotations

import tomllib
from collections.abc import Callable, Mapping
from functools import cache, partial
from pathlib import Path
from typing import Final

import numpy as np

import pmmkit as pk
from pmmkit.files import write_text
from pmmkit.models import converted, hull_table
from pmmkit.seakeeping import Loading, added_resistance, rao, read_hull
from scripts.studies import kvlcc2_hsva
from scripts.validation.forces import MMG
from scripts.validation.published import Values
from scripts.validation.sailed import Zigzags, of_zigzag, sailed

STORE: Final = Path(__file__).with_name("measurements.toml")
VERES_SPEEDS: Final = {"0": 0.0, "0.186": 7.7167, "0.248": 10.2889}
LENGTHS: Final = (0.7, 0.8, 0.9, 1.0, 1.1, 1.2, 1.3, 1.4, 1.5, 1.75, 2.0, 2.5, 3.0)
"""Of the waves, over that of the ship."""
HSVA: Final[Zigzags] = {
    (10, 10): (9.69, 20.5), (-10, 10): (9.73, 17.8), (20, 10): (11.7, 15.6, 12.4),
    (-20, 10): (12.0, 13.9), (10, 5): (5.28, 13.33), (20, 5): (8.05, 13.85), (35, 5): (15.1, 19.2),
}  # fmt: skip
"""Overshoots of KVLCC2 [°] from the report of HSVA's free-running tests."""


def kept(section: str) -> Callable[[], Values]:
    """A section of the table."""
    return partial(_section, section)


def _section(name: str) -> Values:
    return _store()[name]


@cache
def _store() -> Mapping[str, Values]:
    return tomllib.loads(STORE.read_text(encoding="utf-8"))


@cache
def captive(data: Path) -> tuple[pk.Model, Values]:
    """The model of HMRI's captive tests; its hull, propeller and rudder as numbers."""
    model, parts = kvlcc2_hsva.captive_model(data)
    hull = converted(hull_table(model), MMG).at()
    given = {**parts.propeller.values, **parts.rudder.values, **hull}
    return model, {name: x for name, x in given.items() if isinstance(x, (int, float))}


def hmri(data: Path) -> Values:
    """Hull, propeller and rudder of KVLCC2 by HMRI's captive tests."""
    return captive(data)[1]


def static_drift(data: Path) -> Values:
    """The cubic of HMRI's static drift, about midship."""
    campaign = pk.open_campaign(kvlcc2_hsva.ROOT / "datasets" / "kvlcc2_hmri", data=data)
    found = pk.reduce_campaign(campaign, structure="Yv Yvvv Nv Nvvv").families["static drift"].at()
    return {name: found[name] for name in ("Yv", "Yvvv", "Nv", "Nvvv")}


def hsva(data: Path) -> Values:
    """Overshoots of the captive model at HSVA's scale."""
    model = kvlcc2_hsva.as_at_hsva(captive(data)[0], data)
    return {
        of_zigzag(rudder, switch, number): found[f"overshoot_{number}_deg"]
        for (rudder, switch), angles in HSVA.items()
        for found in [sailed(model, 1.179, rudder, switch, len(angles), None)]
        for number in range(1, len(angles) + 1)
    }


def _s175(data: Path) -> pk.seakeeping.Hull:
    return read_hull(data / "s175_seakeeping_veres" / "shipx_geometry.mgf", draught=9.5)


def hydrostatics(data: Path) -> Values:
    """S175 at 9.5 m."""
    found = _s175(data).hydrostatics
    return {
        "displacement": 1.025 * found.volume,
        "LCB from the after perpendicular": found.xB + 87.5,
        "KB": found.KB,
        "GM": found.KM - 9.55,
        "waterplane coefficient": found.waterplane / (175.0 * 25.4),
    }


def _loading() -> Loading:
    return Loading(KG=9.55, kxx=8.331, kyy=42.0, kzz=42.0)


def head_seas(data: Path) -> Values:
    """Heave and pitch of S175 in head seas."""
    k = 2 * np.pi / (175.0 * np.array(LENGTHS[::-1]))
    speeds = list(VERES_SPEEDS.values())
    found = rao(_s175(data), speeds=speeds, omega=np.sqrt(9.81 * k), loading=_loading())
    values = {}
    for place, Fn in enumerate(VERES_SPEEDS):
        for mode, unit in (("heave", 1.0), ("pitch", k)):
            sizes = np.abs(found.mode(mode)[place, 0]) / unit
            for length, size in zip(LENGTHS, sizes[::-1], strict=True):
                values[of_wave(mode, Fn, length)] = float(size)
    return values


def of_wave(mode: str, Fn: str, length: float) -> str:
    """What a motion in waves is called."""
    return f"{mode}, Fn {Fn}, λ/L {length:g}"


def resistance(data: Path) -> Values:
    """Largest added resistance of S175 in head seas over ρgζ²B²/L."""
    omega = np.linspace(0.4, 0.8, 41)
    found = added_resistance(
        rao(_s175(data), speeds=[7.7167, 10.2889], omega=omega, loading=_loading())
    )
    peaks = found.methods["with reflection"][:, 0].max(axis=-1) / found.unit
    return {"Fn 0.186": float(peaks[0]), "Fn 0.248": float(peaks[1])}


RECIPES: Final[Mapping[str, Callable[[Path], Values]]] = {
    "hmri": hmri,
    "static_drift": static_drift,
    "hsva": hsva,
    "hydrostatics": hydrostatics,
    "head_seas": head_seas,
    "resistance": resistance,
}
"""What each section comes from."""


def compute(data: Path) -> None:
    """Write the table anew."""
    lines = ["# Written by python -m scripts.validation --data FOLDER; not by hand."]
    for name, recipe in RECIPES.items():
        lines += ["", f"[{name}]"]
        lines += [f'"{key}" = {float(f"{x:.6g}")!r}' for key, x in recipe(data).items()]
    write_text(STORE, "\n".join(lines) + "\n")
