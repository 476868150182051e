"""The application: its commands, found in their folder, and how a command ends."""

from __future__ import annotations

import functools
import inspect
import pkgutil
from collections.abc import Callable
from importlib import import_module
from typing import Annotated, Any

import typer

from pmmkit.cli import commands
from pmmkit.cli.output import Outcome, tell
from pmmkit.version import __version__

Json = Annotated[
    bool,
    typer.Option("--json", help="One JSON object on standard output, words on standard error."),
]


def application(asked: str = "") -> typer.Typer:
    """The application with the command that is asked for, else with all of them.

    Parameters
    ----------
    asked : str
        First word of a command line. A name of a command spares the time to load the others.
    """
    app = typer.Typer(
        name="pmmkit",
        help="Captive ship-model tests to hydrodynamic derivatives, a model and its manoeuvres.",
        no_args_is_help=True,
        add_completion=False,
        pretty_exceptions_enable=False,
        rich_markup_mode=None,
    )
    app.callback()(_options)
    found = {
        module.name.replace("_", "-"): module.name
        for module in pkgutil.iter_modules(commands.__path__)
    }
    for name in [asked] if asked in found else found:
        module = import_module(f"{commands.__name__}.{found[name]}")
        app.command(name)(_ending(getattr(module, found[name])))
    return app


def _ending(command: Callable[..., Outcome]) -> Callable[..., None]:
    """A command with the option --json that tells its outcome and ends with its status."""

    @functools.wraps(command)
    def run(*, json: bool, **options: Any) -> None:
        outcome = command(**options)
        tell(outcome, as_json=json)
        if outcome.status:
            raise typer.Exit(outcome.status)

    own = inspect.signature(command, eval_str=True)
    asked = inspect.Parameter(
        "json", inspect.Parameter.KEYWORD_ONLY, default=False, annotation=Json
    )
    run.__signature__ = own.replace(parameters=[*own.parameters.values(), asked])  # type: ignore[attr-defined]
    return run


def _version(asked: bool) -> None:
    if asked:
        typer.echo(f"pmmkit {__version__}")
        raise typer.Exit


def _options(
    version: Annotated[
        bool, typer.Option("--version", callback=_version, is_eager=True, help="Show the version.")
    ] = False,
) -> None:
    """Captive ship-model tests to hydrodynamic derivatives, a model and its manoeuvres."""
