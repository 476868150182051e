"""The commands about what a model lacks; what does the work is imported when they run."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from pmmkit.cli.options import (
    Campaign,
    Data,
    Json,
    Out,
    app,
    finish,
    numbers,
    patterns,
    sensors_of,
    stem,
)

Base = Annotated[
    str, typer.Argument(help="Model file, library ship, or a structure such as cubic.")
]
Floor = Annotated[
    float | None,
    typer.Option(
        min=0.0,
        max=0.5,
        help="What is smooth and too small to matter, over the rms force of a channel: your own "
        "uncertainty. U_SN of the campaign file, 0.005 for measured forces, 0.02 for free-running "
        "records if absent.",
    ),
]
Noise = Annotated[
    float | None,
    typer.Option(
        min=0.0,
        max=0.5,
        help="Standard uncertainty of a mean or harmonic, over the rms force, of runs that state "
        "none (tables, CFD).",
    ),
]
Own = Annotated[
    Path | None, typer.Option("--own", help="File of your own effects (.toml), who take part.")
]
Drawn = Annotated[bool, typer.Option("--figures/--no-figures", help="Draw figures.")]


@app.command()
def diagnose(
    model: Base,
    campaign: Campaign,
    floor: Floor = None,
    noise: Noise = None,
    given: Annotated[
        str | None,
        typer.Option(help="Effects that are known to be there, such as fault_misalignment,memory."),
    ] = None,
    own: Own = None,
    runs: Annotated[
        list[str] | None,
        typer.Option(help="Free-running runs to diagnose, such as 'turn_*'; may be repeated."),
    ] = None,
    test_runs: Annotated[
        list[str] | None,
        typer.Option("--test-runs", help="Free-running runs held out, to be predicted."),
    ] = None,
    channels: Annotated[
        str | None,
        typer.Option(
            help="Channels of free-running records to use, such as x,y,psi,r where the checks "
            "find fault with the velocities; all if absent."
        ),
    ] = None,
    spread: Annotated[
        float | None,
        typer.Option(
            min=1e-6,
            help="Relative standard deviation of the model's values before free-running records "
            "are looked at; its covariance and 0.05 beside it if absent.",
        ),
    ] = None,
    shortest: Annotated[
        float | None,
        typer.Option(
            min=0.1,
            help="Leave out free-running segments shorter than this, in s; ten ship "
            "lengths if absent.",
        ),
    ] = None,
    sensors: Annotated[
        str | None,
        typer.Option(
            help="Standard deviations of channels of free-running records, such as "
            "x=0.03,y=0.03,psi_deg=0.1; told from their noise if absent."
        ),
    ] = None,
    windage: Annotated[
        str | None,
        typer.Option(help="Frontal and lateral area above water in m2, such as 0.135,0.52."),
    ] = None,
    judged: Annotated[
        float | None,
        typer.Option(
            min=0.1,
            help="Length in s of the windows by which effects are judged; five ship "
            "lengths if absent.",
        ),
    ] = None,
    window: Annotated[
        float, typer.Option(min=0.1, help="Length in s of the windows of runs held out.")
    ] = 60.0,
    figures: Drawn = True,
    data: Data = None,
    out: Out = None,
    json: Json = False,
) -> None:
    """Name the effect, or the fault of the measurement, that the model lacks."""
    from pmmkit.cli import diagnosing
    from pmmkit.cli.diagnosing_records import Asked

    finish(
        diagnosing.diagnose(
            model,
            campaign,
            out or Path(f"{stem(campaign)}-diagnosed"),
            floor=floor,
            noise=noise,
            given=(given or "").replace(",", " ").split(),
            own=own,
            drawn=figures,
            data=data,
            records=Asked(
                runs=patterns(runs),
                test_runs=patterns(test_runs),
                spread=spread,
                channels=None if channels is None else channels.replace(",", " ").split(),
                sensors=sensors_of(sensors),
                shortest=shortest,
                windage=_areas(windage),
                judged=judged,
                window=window,
            ),
        ),
        json,
    )


def _areas(text: str | None) -> tuple[float, float] | None:
    found = numbers(text)
    if found is None:
        return None
    if len(found) != 2 or min(found) <= 0.0:
        raise typer.BadParameter(f"{text!r}: write two areas such as 0.135,0.52.")
    return found[0], found[1]


@app.command()
def add(
    model: Annotated[str, typer.Argument(help="Library ship or model file.")],
    effects: Annotated[
        list[str] | None, typer.Argument(help="Effects to add, one after another.")
    ] = None,
    fit: Annotated[
        Path, typer.Option("--fit", help="Campaign to which the model is fitted with them.")
    ] = ...,  # type: ignore[assignment]
    target: Annotated[
        Path | None, typer.Option("-o", "--output", help="Model file to write.")
    ] = None,
    undo: Annotated[
        bool, typer.Option("--undo", help="Take the effect that was added last out again.")
    ] = False,
    why: Annotated[str, typer.Option(help="A remark for the model's history.")] = "",
    floor: Floor = None,
    noise: Noise = None,
    own: Own = None,
    figures: Drawn = True,
    data: Data = None,
    out: Out = None,
    json: Json = False,
) -> None:
    """Add effects to a model, fit them together with it, and show how the error falls."""
    from pmmkit.cli import adding

    if undo == bool(effects):
        raise typer.BadParameter("Name an effect to add, or say --undo.")
    finish(
        adding.add(
            model,
            effects or [],
            fit,
            target or Path(f"{Path(model).stem}-extended.toml"),
            undo=undo,
            why=why,
            floor=floor,
            noise=noise,
            own=own,
            drawn=figures,
            data=data,
            out=out,
        ),
        json,
    )
