"""``pmmkit estimate``."""

from __future__ import annotations

from functools import partial
from typing import Annotated, Final

import typer

from pmmkit.cli.options import Out, results_folder
from pmmkit.cli.output import Outcome
from pmmkit.presentation import aligned

LINEAR: Final = ("Yv", "Yr", "Nv", "Nr", "Yvdot", "Nrdot")


def estimate(
    length: Annotated[float, typer.Option("--length", help="Between perpendiculars, m.")],
    breadth: Annotated[float, typer.Option("--breadth", help="m")],
    draught: Annotated[float, typer.Option("--draught", help="Mean, m.")],
    block: Annotated[float, typer.Option("--block", help="Block coefficient.")],
    speed: Annotated[float, typer.Option(help="Service speed in m/s.")],
    propeller: Annotated[float, typer.Option(help="Diameter of the propeller in m.")],
    rudder: Annotated[float, typer.Option(help="Area of the rudder in m².")],
    method: Annotated[str, typer.Option(help="yoshimura-masumoto or kijima.")] = (
        "yoshimura-masumoto"
    ),
    name: Annotated[str, typer.Option(help="Of the ship.")] = "ship",
    out: Out = None,
) -> Outcome:
    """A model from particulars alone, and its linear derivatives by every method."""
    import pandas as pd

    from pmmkit import empirical
    from pmmkit.files import write_results
    from pmmkit.models import estimated_model, save_model
    from pmmkit.ship import Ship, Water
    from pmmkit.simulation.simulate import simulate

    folder = results_folder(out, f"{name}-estimate")
    water = Water()
    volume = block * length * breadth * draught
    mass = water.rho * volume
    ship = Ship(
        name=name,
        L=length,
        B=breadth,
        d=draught,
        volume=volume,
        mass=mass,
        Izz=mass * (0.25 * length) ** 2,
    )
    model = estimated_model(
        ship, method, speed=speed, propeller_diameter=propeller, rudder_area=rudder, water=water
    )
    found = {item: empirical.estimate(ship, item) for item in empirical.METHODS}
    turn = simulate(model, "turning", speed=speed, compiled=False).metrics
    rows = [
        {"method": item, "system": guess.convention.system, "source": guess.source, **guess.values}
        for item, guess in found.items()
    ]
    write_results(
        folder, [("model.toml", partial(save_model, model)), ("estimates.csv", pd.DataFrame(rows))]
    )
    cells = [
        [item, guess.convention.system, guess.convention.sway]
        + [f"{guess.values[x]:.5f}" if x in guess.values else "-" for x in LINEAR]
        for item, guess in found.items()
    ]
    path = str(folder / "model.toml")
    lines = [
        f"{name}: L/B {length / breadth:.2f}, B/d {breadth / draught:.2f}, CB {block:.3f}. "
        f"Estimates, not verdicts.",
        aligned(["method", "system", "sway by", *LINEAR], cells),
        f"Turning circle at {speed:g} m/s by {method}: advance {turn['advance_L']:.2f} L, tactical "
        f"diameter {turn['tactical_diameter_L']:.2f} L.",
        f"Model: {path}",
    ]
    return Outcome(
        content={"out": str(folder), "model": path, "estimates": rows, "turning": dict(turn)},
        lines=lines,
    )
