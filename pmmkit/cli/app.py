"""The application: its commands, found in their folder, and how a command ends."""

from __future__ import annotations

import functools
import inspect
import os
import pkgutil
from collections.abc import Callable, Iterator
from contextlib import contextmanager, nullcontext, redirect_stderr
from importlib import import_module
from typing import Annotated, Any, Final

import typer

from pmmkit.base import __version__
from pmmkit.cli import commands
from pmmkit.cli.output import Outcome, say, tell

Json = Annotated[
    bool,
    typer.Option("--json", help="One JSON object on standard output, words on standard error."),
]
Quiet = Annotated[
    bool, typer.Option("--quiet", "-q", help="No words but errors: results are in their files.")
]
FIRST: Final = """\
Captive ship-model tests to hydrodynamic derivatives, a model and its manoeuvres. Type first:

  pmmkit inspect FOLDER   what your own files hold; its last line says what to type next
  pmmkit demo             a demonstration: tests of a container ship to derivatives and a turn
  pmmkit demo --my-data FOLDER
                          the same with your own files, as far as they go, and what is missing
  pmmkit --help           all commands; pmmkit COMMAND --help has the options and an example"""
"""What to type first."""
LISTING: Final = ("--help", "--version")
"""First words after which no command runs."""


def application(asked: str = "") -> typer.Typer:
    """The application with the command that is asked for, else with all of them."""
    app = typer.Typer(
        name="pmmkit",
        help="Captive ship-model tests to hydrodynamic derivatives, a model and its manoeuvres.",
        invoke_without_command=True,
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
        whole = getattr(module, found[name])
        command = _summary(whole) if asked in LISTING else _ending(whole)
        app.command(name, epilog=f"Example: {module.EXAMPLE}")(command)
    return app


def _summary(command: Callable[..., Outcome]) -> Callable[[], None]:
    """What a list of commands shows of one."""

    def run() -> None:
        raise NotImplementedError

    run.__doc__ = command.__doc__
    return run


def _ending(command: Callable[..., Outcome]) -> Callable[..., None]:
    """A command with --quiet and --json that tells its outcome and ends with its status."""

    @functools.wraps(command)
    def run(*, quiet: bool, json: bool, **options: Any) -> None:
        with _silence() if quiet else nullcontext():
            outcome = command(**options)
            tell(outcome, as_json=json, quiet=quiet)
        if outcome.status:
            raise typer.Exit(outcome.status)

    own = inspect.signature(command, eval_str=True)
    asked = [
        inspect.Parameter(name, inspect.Parameter.KEYWORD_ONLY, default=False, annotation=option)
        for name, option in (("quiet", Quiet), ("json", Json))
    ]
    run.__signature__ = own.replace(parameters=[*own.parameters.values(), *asked])  # type: ignore[attr-defined]
    return run


@contextmanager
def _silence() -> Iterator[None]:
    """Words and progress, which go to standard error, are not shown; errors come after."""
    with open(os.devnull, "w", encoding="utf-8") as nowhere, redirect_stderr(nowhere):
        yield


def _options(
    context: typer.Context,
    version: Annotated[bool, typer.Option("--version", help="Show the version.")] = False,
) -> None:
    """Captive ship-model tests to hydrodynamic derivatives, a model and its manoeuvres."""
    if version:
        typer.echo(f"pmmkit {__version__}")
        raise typer.Exit
    if context.invoked_subcommand is None:
        say(FIRST)
        raise typer.Exit(2)
