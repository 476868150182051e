"""The command about identification; what does the work is imported when it runs."""

from __future__ import annotations

from enum import StrEnum
from pathlib import Path
from typing import Annotated

import typer

from pmmkit.cli.options import Campaign, Data, Json, Out, app, finish, patterns, sensors_of, stem


class Method(StrEnum):
    """A method of identification, or all of them."""

    ekf = "ekf"
    ukf = "ukf"
    trajectory = "trajectory"
    regression = "regression"
    sindy = "sindy"
    all = "all"


class Rudder(StrEnum):
    """What the rudder column is."""

    auto = "auto"
    measured = "measured"
    ordered = "ordered"


@app.command()
def identify(
    campaign: Campaign,
    model: Annotated[
        str,
        typer.Option(
            help="Library ship or model file of the ship, at its scale: what is not identified "
            "keeps its values."
        ),
    ],
    method: Annotated[Method, typer.Option(help="all compares the methods.")] = Method.ekf,
    derivatives: Annotated[
        str | None,
        typer.Option(
            help="What to identify, such as 'Yv Yr Nv Nr rudder_mmg.aH current_x'; all derivatives "
            "of the hull if absent."
        ),
    ] = None,
    prior: Annotated[
        str | None,
        typer.Option(
            help="Library ship, model file or derivative table with what was known before; the "
            "model itself if absent."
        ),
    ] = None,
    spread: Annotated[
        float | None,
        typer.Option(
            help="Relative standard deviation before, in place of any covariance; 0.3 where "
            "nothing is known."
        ),
    ] = None,
    runs: Annotated[
        list[str] | None,
        typer.Option(
            help="Runs to identify from, such as 'turn_*,ZZ10'; may be repeated. All but those "
            "held out if absent."
        ),
    ] = None,
    test_runs: Annotated[
        list[str] | None,
        typer.Option("--test-runs", help="Runs held out, which the result has to predict."),
    ] = None,
    channels: Annotated[
        str | None, typer.Option(help="Measurements to use, such as x,y,psi,r; all if absent.")
    ] = None,
    sensors: Annotated[
        str | None,
        typer.Option(
            help="Standard deviations of channels, SI or with _deg, such as x=0.03,y=0.03,"
            "psi_deg=0.1; told from the noise of the records if absent."
        ),
    ] = None,
    rudder: Annotated[
        Rudder,
        typer.Option(
            help="Whether the column delta is the angle, or the order that the gear follows."
        ),
    ] = Rudder.auto,
    wind: Annotated[bool, typer.Option(help="Use the measured wind.")] = True,
    shortest: Annotated[
        float | None,
        typer.Option(
            min=0.1, help="Leave out segments shorter than this, in s; ten ship lengths if absent."
        ),
    ] = None,
    window: Annotated[
        float, typer.Option(min=0.1, help="Length in s of the windows that are predicted.")
    ] = 60.0,
    extrapolate: Annotated[
        bool, typer.Option("--extrapolate", help="Allow speeds outside the model's range.")
    ] = False,
    data: Data = None,
    out: Out = None,
    json: Json = False,
) -> None:
    """Identify derivatives from free-running records, and predict runs that were held out."""
    from pmmkit.cli import identifying

    if spread is not None and spread <= 0.0:
        raise typer.BadParameter(f"--spread {spread:g}: it is a positive share, such as 0.3.")
    finish(
        identifying.identify(
            campaign,
            out or Path(f"{stem(campaign)}-identified"),
            model=model,
            method=method.value,
            derivatives=None if derivatives is None else derivatives.replace(",", " ").split(),
            prior=prior,
            spread=spread,
            runs=patterns(runs),
            test_runs=patterns(test_runs),
            channels=None if channels is None else channels.replace(",", " ").split(),
            sensors=sensors_of(sensors),
            rudder=rudder.value,
            wind=wind,
            shortest=shortest,
            window=window,
            extrapolate=extrapolate,
            data=data,
        ),
        json,
    )
