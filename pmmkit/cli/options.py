"""What all commands share: the application, the options they have in common, how they end."""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from pmmkit.version import __version__

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


def finish(result: Outcome, as_json: bool) -> None:
    """The outcome on standard output: words, or JSON with the words on standard error."""
    from pmmkit.cli.console import emit, say

    for line in result.lines:
        say(line) if as_json else typer.echo(line)
    if as_json:
        emit(result.content)


def stem(path: Path) -> str:
    """Name for a folder of results: that of the campaign's folder, or of the file."""
    full = path.resolve()
    named = full.parent if full.name == "campaign.toml" else full
    return named.stem if named.suffix in (".toml", ".h5", ".hdf5", ".nc", ".csv") else named.name


def numbers(text: str | None) -> Sequence[float] | None:
    """Numbers out of text such as 6,9,12."""
    if text is None:
        return None
    try:
        return [float(part) for part in text.replace(",", " ").split()]
    except ValueError:
        raise typer.BadParameter(f"{text!r}: write numbers such as 6,9,12.") from None


def patterns(given: Sequence[str] | None) -> list[str] | None:
    """Patterns of runs, each option holding one or several with commas between."""
    if not given:
        return None
    return [part.strip() for text in given for part in text.split(",") if part.strip()]


def sensors_of(text: str | None) -> dict[str, float] | None:
    """Standard deviations out of text such as x=0.03,psi_deg=0.1, angles in radians."""
    if text is None:
        return None
    found = {}
    for part in text.replace(",", " ").split():
        name, _, value = part.partition("=")
        try:
            number = float(value)
        except ValueError:
            number = math.nan
        if not number > 0.0:
            raise typer.BadParameter(f"{part!r}: write --sensors x=0.03,psi_deg=0.1.")
        bare = name.removesuffix("_deg")
        found[bare] = number if bare == name else math.radians(number)
    return found
