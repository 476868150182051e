"""The work behind the commands that make models."""

from __future__ import annotations

from pathlib import Path
from typing import Final

from pmmkit.cli.console import Outcome
from pmmkit.cli.tracks import check_folder
from pmmkit.empirical import METHODS
from pmmkit.empirical import estimate as estimate_of
from pmmkit.files import atomic_folder
from pmmkit.models import estimated_model, full_scale, load_model, save_model, scaled
from pmmkit.presentation import aligned
from pmmkit.ship import Ship, Water
from pmmkit.simulation.simulate import simulate

LINEAR: Final = ("Yv", "Yr", "Nv", "Nr", "Yvdot", "Nrdot")


def estimate(
    out: Path,
    *,
    name: str,
    L: float,
    B: float,
    d: float,
    block: float,
    speed: float,
    propeller: float,
    rudder: float,
    method: str,
) -> Outcome:
    """A model from particulars, and the linear derivatives by every method.

    Parameters
    ----------
    out : Path
        Folder for ``model.toml`` and ``estimates.csv``.
    name : str
        Of the ship.
    L, B, d : float
        Length, breadth, draught [m].
    block : float
        Block coefficient.
    speed : float
        Service speed [m/s].
    propeller : float
        Diameter [m].
    rudder : float
        Area [m²].
    method : str
        As for `estimated_model`.

    Returns
    -------
    Outcome
        With the table.
    """
    check_folder(out)
    water = Water()
    volume = block * L * B * d
    mass = water.rho * volume
    ship = Ship(name=name, L=L, B=B, d=d, volume=volume, mass=mass, Izz=mass * (0.25 * L) ** 2)
    model = estimated_model(
        ship, method, speed=speed, propeller_diameter=propeller, rudder_area=rudder, water=water
    )
    found = {item: estimate_of(ship, item) for item in METHODS}
    turn = simulate(model, "turning", speed=speed, compiled=False).metrics
    rows = [
        {"method": item, "system": guess.convention.system, "source": guess.source, **guess.values}
        for item, guess in found.items()
    ]
    import pandas as pd

    with atomic_folder(out) as folder:
        save_model(model, folder / "model.toml")
        pd.DataFrame(rows).to_csv(folder / "estimates.csv", index=False)
    cells = [
        [item, guess.convention.system, guess.convention.sway]
        + [f"{guess.values[x]:.5f}" if x in guess.values else "-" for x in LINEAR]
        for item, guess in found.items()
    ]
    lines = [
        f"{name}: L/B {L / B:.2f}, B/d {B / d:.2f}, CB {block:.3f}. Estimates, not verdicts.",
        aligned(["method", "system", "sway by", *LINEAR], cells),
        f"Turning circle at {speed:g} m/s by {method}: advance {turn['advance_L']:.2f} L, tactical "
        f"diameter {turn['tactical_diameter_L']:.2f} L.",
        f"Model: {out / 'model.toml'}",
    ]
    return Outcome(
        content={
            "out": str(out),
            "model": str(out / "model.toml"),
            "estimates": rows,
            "turning": dict(turn),
        },
        lines=lines,
    )


def scale(
    model: str,
    out: Path,
    *,
    length: float,
    speed: float | None,
    form: float | None,
    wetted: float | None,
    rho: float | None,
    froude_only: bool,
) -> Outcome:
    """A model at ship scale.

    Parameters
    ----------
    model : str
        Library ship or model file.
    out : Path
        Folder for ``model.toml``.
    length, speed, form, wetted
        As for `full_scale`.
    rho : float, optional
        Density of the ship's water [kg/m³].
    froude_only : bool
        Correct neither friction nor wake.

    Returns
    -------
    Outcome
        With the steps.
    """
    check_folder(out)
    loaded = load_model(model)
    if froude_only:
        made = scaled(loaded, length)
    else:
        water = None if rho is None else Water(rho=rho, g=loaded.water.g)
        made = full_scale(loaded, length, speed=speed, form=form, wetted=wetted, water=water)
    with atomic_folder(out) as folder:
        save_model(made, folder / "model.toml")
    steps = made.history[len(loaded.history) :]
    return Outcome(
        content={
            "out": str(out),
            "model": str(out / "model.toml"),
            "scale": made.scale,
            "steps": list(steps),
        },
        lines=[*steps, f"Scale: {made.scale}", f"Model: {out / 'model.toml'}"],
    )
