"""Commands about models: manoeuvres, verdicts, sweeps, uncertainty, estimates, scale."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

import typer

from pmmkit.cli.options import Json, Model, Out, app, finish, numbers, stem

Speed = Annotated[float, typer.Option(help="Approach speed in m/s at the model's scale.")]
Manoeuvre = Annotated[
    str,
    typer.Option(
        help="turning, initial_turning, zigzag, spiral, pull_out, stopping, accelerating, "
        "course_change or williamson."
    ),
]
RudderDeg = Annotated[
    float | None,
    typer.Option(
        "--rudder-deg",
        help="Rudder, positive to starboard; 35 in a turn, 10 in a zigzag, else as usual in that "
        "manoeuvre.",
    ),
]
SwitchDeg = Annotated[float | None, typer.Option(help="Heading of a zigzag's order.")]
Depth = Annotated[float | None, typer.Option(help="Depth of the water in m.")]
Extrapolate = Annotated[
    bool, typer.Option("--extrapolate", help="Allow a speed outside the tested range.")
]
Spread = Annotated[
    float | None,
    typer.Option(
        help="Relative standard deviation of every derivative, where the model has no covariance "
        "or in its place, such as 0.05."
    ),
]


@app.command()
def simulate(
    model: Model,
    speed: Speed,
    manoeuvre: Manoeuvre = "turning",
    rudder_deg: RudderDeg = None,
    switch_deg: SwitchDeg = None,
    heading_deg: Annotated[
        float | None, typer.Option(help="Change of heading of a course change or initial turn.")
    ] = None,
    step_deg: Annotated[float | None, typer.Option(help="Rudder step of a spiral.")] = None,
    turns: Annotated[
        float | None,
        typer.Option(help="Revolutions over those of the approach: stopping, accelerating."),
    ] = None,
    duration: Annotated[
        float | None, typer.Option(help="Seconds of a turn; until it is steady if absent.")
    ] = None,
    rudder_rate_deg: Annotated[
        float | None, typer.Option(help="Rate of the steering gear in deg/s; the ship's if absent.")
    ] = None,
    wind_speed: Annotated[float, typer.Option(help="True wind in m/s.")] = 0.0,
    wind_direction_deg: Annotated[
        float, typer.Option(help="Where it comes from, from the bow of the approach.")
    ] = 0.0,
    current_speed: Annotated[float, typer.Option(help="Current in m/s.")] = 0.0,
    current_direction_deg: Annotated[
        float, typer.Option(help="Where it flows to, from the bow of the approach.")
    ] = 0.0,
    depth: Depth = None,
    extrapolate: Extrapolate = False,
    figures: Annotated[
        bool, typer.Option(help="Draw figures, which takes most of the time.")
    ] = True,
    out: Out = None,
    json: Json = False,
) -> None:
    """Simulate a manoeuvre: track, metrics and figures."""
    from pmmkit.cli import simulating

    folder = out or Path(f"{stem(Path(model))}-{manoeuvre}")
    given = stated(
        rudder_deg=rudder_deg,
        switch_deg=switch_deg,
        heading_deg=heading_deg,
        step_deg=step_deg,
        turns=turns,
        duration=duration,
    )
    finish(
        simulating.simulate_manoeuvre(
            model,
            folder,
            manoeuvre=manoeuvre,
            speed=speed,
            rudder_rate_deg=rudder_rate_deg,
            wind_speed=wind_speed,
            wind_direction_deg=wind_direction_deg,
            current_speed=current_speed,
            current_direction_deg=current_direction_deg,
            depth=depth,
            extrapolate=extrapolate,
            drawn=figures,
            **given,
        ),
        json,
    )


@app.command()
def sweep(
    model: Model,
    speeds: Annotated[
        str | None,
        typer.Option(help="Approach speeds in m/s, such as 6,9,12; those of the tests if absent."),
    ] = None,
    over: Annotated[
        str | None,
        typer.Option(help="What to vary in place of the speed: rudder_deg, depth, wind_speed …"),
    ] = None,
    values: Annotated[str | None, typer.Option(help="Its values, such as 10,20,35.")] = None,
    manoeuvre: Manoeuvre = "turning",
    rudder_deg: RudderDeg = None,
    switch_deg: SwitchDeg = None,
    depth: Depth = None,
    ships: Annotated[int, typer.Option(help="Ships drawn per value for 95 % intervals.")] = 0,
    spread: Spread = None,
    extrapolate: Extrapolate = False,
    out: Out = None,
    json: Json = False,
) -> None:
    """Metrics of a manoeuvre over the approach speed, or over --over."""
    from pmmkit.cli import simulating

    asked = numbers(speeds)
    if over is not None and (values is None or asked is None or len(asked) != 1):
        raise typer.BadParameter("--over needs --values and one approach speed, --speeds 8.")
    given = stated(rudder_deg=rudder_deg, switch_deg=switch_deg, depth=depth)
    finish(
        simulating.sweep(
            model,
            out or Path(f"{stem(Path(model))}-sweep"),
            speeds=asked,
            over=over,
            values=numbers(values),
            manoeuvre=manoeuvre,
            ships=ships,
            spread=spread,
            extrapolate=extrapolate,
            **given,
        ),
        json,
    )


@app.command()
def imo(
    model: Model,
    speed: Speed,
    ships: Annotated[int, typer.Option(help="Ships drawn for the probability of passing.")] = 2000,
    spread: Spread = None,
    depth: Depth = None,
    extrapolate: Extrapolate = False,
    out: Out = None,
    json: Json = False,
) -> None:
    """Judge a ship by every criterion of IMO MSC.137(76), to both sides."""
    from pmmkit.cli import judging

    folder = out or Path(f"{stem(Path(model))}-imo")
    finish(
        judging.imo(
            model,
            folder,
            speed=speed,
            ships=ships,
            spread=spread,
            depth=depth,
            extrapolate=extrapolate,
        ),
        json,
    )


@app.command()
def stability(
    model: Model,
    speed: Speed,
    depth: Depth = None,
    extrapolate: Extrapolate = False,
    out: Out = None,
    json: Json = False,
) -> None:
    """Straight-line stability, Nomoto's constants and the curve of steady turns."""
    from pmmkit.cli import judging

    folder = out or Path(f"{stem(Path(model))}-stability")
    finish(
        judging.stability(model, folder, speed=speed, depth=depth, extrapolate=extrapolate), json
    )


@app.command()
def uncertainty(
    model: Model,
    speed: Speed,
    manoeuvre: Manoeuvre = "turning",
    rudder_deg: RudderDeg = None,
    switch_deg: SwitchDeg = None,
    depth: Depth = None,
    metric: Annotated[
        str | None, typer.Option(help="Whose causes are listed, such as advance_L.")
    ] = None,
    ships: Annotated[int, typer.Option(help="Number of ships drawn.")] = 10_000,
    spread: Spread = None,
    seed: Annotated[int, typer.Option(help="Of the draws.")] = 0,
    extrapolate: Extrapolate = False,
    out: Out = None,
    json: Json = False,
) -> None:
    """How sure a manoeuvre is, and which derivatives decide it."""
    from pmmkit.cli import judging

    given = stated(rudder_deg=rudder_deg, switch_deg=switch_deg, depth=depth)
    finish(
        judging.uncertainty(
            model,
            out or Path(f"{stem(Path(model))}-uncertainty"),
            speed=speed,
            manoeuvre=manoeuvre,
            metric=metric,
            ships=ships,
            spread=spread,
            seed=seed,
            extrapolate=extrapolate,
            **given,
        ),
        json,
    )


@app.command()
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
    json: Json = False,
) -> None:
    """A model from particulars alone, and its linear derivatives by every method."""
    from pmmkit.cli import making

    finish(
        making.estimate(
            out or Path(f"{name}-estimate"),
            name=name,
            L=length,
            B=breadth,
            d=draught,
            block=block,
            speed=speed,
            propeller=propeller,
            rudder=rudder,
            method=method,
        ),
        json,
    )


@app.command()
def scale(
    model: Model,
    length: Annotated[float, typer.Option("--length", help="Of the ship, m.")],
    speed: Annotated[
        float | None,
        typer.Option(help="Of the ship in m/s, where the model has one set for all speeds."),
    ] = None,
    form: Annotated[float | None, typer.Option(help="Form factor k; estimated if absent.")] = None,
    wetted: Annotated[
        float | None, typer.Option(help="Wetted surface of the ship in m²; estimated if absent.")
    ] = None,
    rho: Annotated[float | None, typer.Option(help="Density of the ship's water in kg/m³.")] = None,
    froude_only: Annotated[
        bool, typer.Option("--froude-only", help="Correct neither friction nor wake.")
    ] = False,
    out: Out = None,
    json: Json = False,
) -> None:
    """Carry a model over to ship scale: Froude's law, friction and wake."""
    from pmmkit.cli import making

    finish(
        making.scale(
            model,
            out or Path(f"{stem(Path(model))}-ship"),
            length=length,
            speed=speed,
            form=form,
            wetted=wetted,
            rho=rho,
            froude_only=froude_only,
        ),
        json,
    )


def stated(**settings: Any) -> dict[str, Any]:
    """The settings that were given."""
    return {name: value for name, value in settings.items() if value is not None}
