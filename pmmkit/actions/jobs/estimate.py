"""Make a model from particulars alone, with its linear derivatives by every method."""

from __future__ import annotations

from collections.abc import Mapping
from functools import partial
from typing import TYPE_CHECKING, Final

from pmmkit.actions.outcome import Outcome, results_folder
from pmmkit.actions.setting import setting, settings
from pmmkit.actions.shared import Out
from pmmkit.actions.speeds import WAYS, TypedSpeed, typed
from pmmkit.presentation import ABSENT, WIDE, aligned, fixed, plus_minus

if TYPE_CHECKING:
    from pmmkit.conventions import Ship
    from pmmkit.models import HullEstimate


STAGE: Final = ("model", 2)
EXAMPLE: Final = (
    "pmmkit estimate --length 320 --breadth 58 --draught 20.8 --block 0.81 --speed 8 "
    "--propeller 9.9 --rudder 137"
)
LINEAR: Final = ("Yv", "Yr", "Nv", "Nr", "Yvdot", "Nrdot")


@settings
class EstimateSettings:
    """What is asked."""

    length: float = setting("Between perpendiculars, m.")
    breadth: float = setting("m")
    draught: float = setting("Mean, m.")
    block: float = setting("Block coefficient.")
    speed: TypedSpeed = setting(f"Service speed of the ship: {WAYS}.", read=typed, metavar="SPEED")
    propeller: float = setting("Diameter of the propeller in m.")
    rudder: float = setting("Area of the rudder in m².")
    method: str = setting(
        "Of the model; linear ones hold for small rudder angles.", default="yoshimura-masumoto"
    )
    xg: float = setting("Centre of gravity forward of midship, m.", default=0.0)
    name: str = setting("Of the ship.", default="ship")
    out: Out = None


def estimate(job: EstimateSettings) -> Outcome:
    """Do what is asked."""
    import pandas as pd

    from pmmkit.conventions import Ship, Water
    from pmmkit.files import MODEL, write_results
    from pmmkit.models import HullEstimate, estimated_model, save_model
    from pmmkit.simulation import simulate

    folder = results_folder(job.out, f"{job.name}-estimate")
    water = Water()
    volume = job.block * job.length * job.breadth * job.draught
    mass = water.rho * volume
    ship = Ship(
        name=job.name,
        L=job.length,
        B=job.breadth,
        d=job.draught,
        volume=volume,
        mass=mass,
        Izz=mass * ((0.25 * job.length) ** 2 + job.xg**2),
        xG=job.xg,
    )
    service = job.speed.of(ship, water)
    model = estimated_model(
        ship,
        job.method,
        speed=service,
        propeller_diameter=job.propeller,
        rudder_area=job.rudder,
        water=water,
    )
    found = HullEstimate.by_method(ship)
    track = simulate(model, "turning", speed=service)
    turn = track.metrics
    warnings = [*track.notes, *track.standing.sentences]
    rows = [_row(item, guess, ship) for item, guess in found.items()]
    write_results(
        folder, [(MODEL.file, partial(save_model, model)), ("estimates.csv", pd.DataFrame(rows))]
    )
    path = str(folder / MODEL.file)
    lines = [
        f"{job.name}: L/B {job.length / job.breadth:.2f}, B/d {job.breadth / job.draught:.2f}, "
        f"CB {job.block:.3f}. Estimates, not verdicts. ± is half of the 95 % interval.",
        _linear(found),
        "",
        "Straight-line stability of the bare hull, stable where the lever of yaw is the larger "
        "(both over L from midship); C = Yv(Nr - m'xG) - Nv(Yr - m') in the prime system:",
        _stability(found, ship),
        "",
        f"Values of {job.method}:",
        aligned(
            ["", "value"],
            [[name, _told(found[job.method], name)] for name in found[job.method].values],
        ),
        f"Their uncertainty is how far ships lie from the formulas ("
        f"{_grounds(found[job.method])}).",
        "",
        f"Turning circle at {service:g} m/s by {job.method}: "
        f"advance {fixed(turn['advance_L'], 2)} L, "
        f"tactical diameter {fixed(turn['tactical_diameter_L'], 2)} L.",
        *(f"warning: {job.method}: {text}." for text in found[job.method].notes),
        *(f"warning: {text}" for text in warnings),
        f"Model: {path}",
    ]
    return Outcome(
        content={
            "out": str(folder),
            "model": path,
            "estimates": rows,
            "turning": dict(turn),
            "warnings": [*found[job.method].notes, *warnings],
        },
        lines=lines,
    )


def _row(method: str, guess: HullEstimate, ship: Ship) -> dict[str, str | float]:
    """An estimate as a row of a table."""
    straight = guess.straight_line(ship)
    return {
        "method": method,
        "system": guess.convention.system,
        "source": guess.source,
        **guess.values,
        **{f"{name}_std": std for name, std in guess.std.items()},
        "lever_yaw": straight.lever_yaw,
        "lever_sway": straight.lever_sway,
        "C": straight.C,
        "C_std": straight.std,
        "straight_line": straight.verdict,
    }


def _told(guess: HullEstimate, name: str) -> str:
    if name not in guess.values:
        return ABSENT
    return plus_minus(guess.values[name], WIDE * guess.std[name])


def _linear(found: Mapping[str, HullEstimate]) -> str:
    """The linear derivatives by every method."""
    rows = [
        [item, guess.convention.system, guess.convention.sway, *(_told(guess, x) for x in LINEAR)]
        for item, guess in found.items()
    ]
    return aligned(["method", "system", "sway by", *LINEAR], rows)


def _stability(found: Mapping[str, HullEstimate], ship: Ship) -> str:
    """The criterion by every method."""
    rows = [
        [
            item,
            f"{it.lever_yaw:.3f}",
            f"{it.lever_sway:.3f}",
            plus_minus(1e6 * it.C, 1e6 * WIDE * it.std),
            it.verdict,
        ]
        for item, it in ((item, guess.straight_line(ship)) for item, guess in found.items())
    ]
    return aligned(["method", "lever of yaw", "of sway", "C × 10⁶", "straight line"], rows)


def _grounds(guess: HullEstimate) -> str:
    """From what the uncertainties of the values were found, exceptions first."""
    grounds: dict[str, list[str]] = {}
    for name in guess.values:
        grounds.setdefault(guess.grounds[name], []).append(name)
    most = max(grounds, key=lambda source: len(grounds[source]))
    apart = [f"{', '.join(names)}: {text}" for text, names in grounds.items() if text != most]
    return "; ".join([*apart, f"all others: {most}" if apart else most])
