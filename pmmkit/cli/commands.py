"""The commands and their options; what does the work is imported when a command runs."""

from __future__ import annotations

from collections.abc import Sequence
from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from pmmkit import __version__

if TYPE_CHECKING:
    from pmmkit.cli.console import Outcome

app = typer.Typer(
    name="pmmkit",
    help="Captive ship-model tests to hydrodynamic derivatives, a model and its manoeuvres.",
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
    rich_markup_mode=None,
)


class Fn(StrEnum):
    """A set of derivatives per Froude number, or one over all speeds."""

    each = "each"
    pooled = "pooled"


class Format(StrEnum):
    """Format of a derivative table."""

    csv = "csv"
    nc = "nc"
    xlsx = "xlsx"
    tex = "tex"


Json = Annotated[
    bool,
    typer.Option("--json", help="One JSON object on standard output, words on standard error."),
]
Out = Annotated[Path | None, typer.Option("--out", help="Folder of the results.")]
Data = Annotated[
    Path | None,
    typer.Option("--data", help="Folder of measurements that do not lie beside the campaign file."),
]
Model = Annotated[str, typer.Argument(help="Library ship (pmmkit ships) or model file (.toml).")]
Campaign = Annotated[Path, typer.Argument(help="Folder with campaign.toml, such a file, or .h5.")]
RudderDeg = Annotated[float, typer.Option("--rudder-deg", help="Rudder, positive to starboard.")]


def _version(asked: bool) -> None:
    if asked:
        typer.echo(f"pmmkit {__version__}")
        raise typer.Exit


@app.callback()
def _options(
    version: Annotated[
        bool, typer.Option("--version", callback=_version, is_eager=True, help="Show the version.")
    ] = False,
) -> None:
    """Captive ship-model tests to hydrodynamic derivatives, a model and its manoeuvres."""


@app.command()
def demo(out: Out = None, json: Json = False) -> None:
    """Reduce the synthetic S175 programme, compare it with Son and Nomoto, turn the ship."""
    from pmmkit.cli import reducing

    _finish(reducing.demo(out or Path("pmmkit-demo")), json)


@app.command()
def reduce(
    campaign: Campaign,
    structure: Annotated[
        str, typer.Option(help="Name of a structure, or derivatives such as 'Yv Yv|v| Nv'.")
    ] = "abkowitz3",
    fn: Annotated[Fn, typer.Option(help="A set per Froude number, or one over all.")] = Fn.each,
    cycles: Annotated[
        str | None,
        typer.Option(help="Cycles to take, such as 3 or 3-6; a test decides if absent."),
    ] = None,
    parts: Annotated[
        str | None,
        typer.Option(help="Library ship or model file that gives propeller and rudder."),
    ] = None,
    reference: Annotated[
        str | None, typer.Option(help="Library ship, model file or table to compare with.")
    ] = None,
    data: Data = None,
    out: Out = None,
    json: Json = False,
) -> None:
    """Reduce captive tests to a table of derivatives, a model and a report."""
    from pmmkit.cli import reducing

    result = reducing.reduce(
        campaign,
        out or Path(f"{_stem(campaign)}-reduced"),
        structure=structure,
        fn=fn.value,
        cycles=_cycles(cycles),
        data=data,
        parts=parts,
        reference=reference,
    )
    _finish(result, json)


@app.command()
def check(campaign: Campaign, data: Data = None, out: Out = None, json: Json = False) -> None:
    """Look for data that contradict themselves; exit status 1 if some do."""
    from pmmkit.cli import tasks

    result = tasks.check(campaign, data=data, out=out)
    _finish(result, json)
    if result.content["errors"]:
        raise typer.Exit(1)


@app.command()
def simulate(
    model: Model,
    speed: Annotated[float, typer.Option(help="Approach speed in m/s at the model's scale.")],
    manoeuvre: Annotated[
        str,
        typer.Option(
            help="turning, initial_turning, zigzag, spiral, pull_out, stopping, accelerating, "
            "course_change or williamson."
        ),
    ] = "turning",
    rudder_deg: Annotated[
        float | None,
        typer.Option("--rudder-deg", help="Rudder, positive to starboard; 35 in a turn, 10 in a "
                     "zigzag, else as usual in that manoeuvre."),
    ] = None,
    switch_deg: Annotated[float | None, typer.Option(help="Heading of a zigzag's order.")] = None,
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
    depth: Annotated[float | None, typer.Option(help="Depth of the water in m.")] = None,
    extrapolate: Annotated[
        bool, typer.Option("--extrapolate", help="Allow a speed outside the tested range.")
    ] = False,
    figures: Annotated[
        bool, typer.Option(help="Draw figures, which takes most of the time.")
    ] = True,
    out: Out = None,
    json: Json = False,
) -> None:  # fmt: skip
    """Simulate a manoeuvre: track, metrics and figures."""
    from pmmkit.cli import simulating

    folder = out or Path(f"{_stem(Path(model))}-{manoeuvre}")
    own = {
        "rudder_deg": rudder_deg, "switch_deg": switch_deg, "heading_deg": heading_deg,
        "step_deg": step_deg, "turns": turns, "duration": duration,
    }  # fmt: skip
    given = {name: value for name, value in own.items() if value is not None}
    _finish(
        simulating.simulate_manoeuvre(
            model, folder, manoeuvre=manoeuvre, speed=speed, rudder_rate_deg=rudder_rate_deg,
            wind_speed=wind_speed, wind_direction_deg=wind_direction_deg,
            current_speed=current_speed, current_direction_deg=current_direction_deg, depth=depth,
            extrapolate=extrapolate, drawn=figures, **given,
        ),
        json,
    )  # fmt: skip


@app.command()
def sweep(
    model: Model,
    speeds: Annotated[
        str | None,
        typer.Option(help="Approach speeds in m/s, such as 6,9,12; those of the tests if absent."),
    ] = None,
    rudder_deg: RudderDeg = 35.0,
    out: Out = None,
    json: Json = False,
) -> None:
    """Measures of the turning circle over the approach speed."""
    from pmmkit.cli import simulating

    folder = out or Path(f"{_stem(Path(model))}-sweep")
    _finish(simulating.sweep(model, folder, speeds=_numbers(speeds), rudder_deg=rudder_deg), json)


@app.command()
def convert(
    table: Annotated[Path, typer.Argument(help="Derivative table: .csv, .nc, .h5 or .xlsx.")],
    system: Annotated[str | None, typer.Option(help="prime, prime-d or bis.")] = None,
    coriolis: Annotated[str | None, typer.Option(help="in-derivatives or separate.")] = None,
    sway: Annotated[str | None, typer.Option(help="v or beta.")] = None,
    surge: Annotated[str | None, typer.Option(help="u or constant.")] = None,
    format: Annotated[Format | None, typer.Option(help="That of the table if absent.")] = None,
    out: Out = None,
    json: Json = False,
) -> None:
    """Convert a table between systems, conventions and file formats."""
    from pmmkit.cli import tasks

    wanted = {"system": system, "coriolis": coriolis, "sway": sway, "surge": surge}
    changes = {name: value for name, value in wanted.items() if value is not None}
    ending = f".{format.value}" if format else table.suffix
    _finish(tasks.convert(table, out or table.parent, ending, changes), json)


@app.command()
def ships(json: Json = False) -> None:
    """The library of ships."""
    from pmmkit.cli import tasks

    _finish(tasks.ships_of_library(), json)


@app.command()
def effects(json: Json = False) -> None:
    """The catalogue of effects that models are made of."""
    from pmmkit.cli import tasks

    _finish(tasks.effects(), json)


def _finish(result: Outcome, as_json: bool) -> None:
    """The outcome on standard output: words, or JSON with the words on standard error."""
    from pmmkit.cli.console import emit, say

    for line in result.lines:
        say(line) if as_json else typer.echo(line)
    if as_json:
        emit(result.content)


def _stem(path: Path) -> str:
    """Name for a folder of results: that of the campaign's folder, or of the file."""
    full = path.resolve()
    named = full.parent if full.name == "campaign.toml" else full
    return named.stem if named.suffix in (".toml", ".h5", ".hdf5", ".nc") else named.name


def _cycles(text: str | None) -> int | tuple[int, int] | None:
    if text is None:
        return None
    first, dash, last = text.partition("-")
    try:
        return (int(first), int(last)) if dash else int(first)
    except ValueError:
        raise typer.BadParameter(f"{text!r}: write one cycle (3) or a range (3-6).") from None


def _numbers(text: str | None) -> Sequence[float] | None:
    if text is None:
        return None
    try:
        return [float(part) for part in text.replace(",", " ").split()]
    except ValueError:
        raise typer.BadParameter(f"{text!r}: write numbers such as 6,9,12.") from None
