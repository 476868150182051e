"""The application: its commands, made from actions, and how a command ends."""

from __future__ import annotations

import inspect
import os
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager, nullcontext, redirect_stderr
from pathlib import Path
from typing import Annotated, Any, Final

import typer

from pmmkit.actions import (
    Action,
    JobSetting,
    SettingError,
    about,
    action,
    by_stage,
    first_steps,
    names,
    say,
)
from pmmkit.base import __version__
from pmmkit.cli.output import tell
from pmmkit.presentation import counted, listed

Json = Annotated[
    bool,
    typer.Option("--json", help="One JSON object on standard output, words on standard error."),
]
Quiet = Annotated[
    bool, typer.Option("--quiet", "-q", help="No words but errors: results are in their files.")
]
LISTING: Final = ("--help", "--version")
"""First words after which no command runs."""


class Command(typer.core.TyperCommand):
    """A command whose help has the options of a group below each other, with a heading."""

    def sections(self, ctx: Any) -> dict[str, list[tuple[str, str]]]:
        """Arguments and options with what is told of them, by their headings."""
        found: dict[str, list[tuple[str, str]]] = {}
        for item in self.get_params(ctx):
            plain = "Arguments" if item.param_type_name == "argument" else "Options"
            if (told := item.get_help_record(ctx)) is not None:
                heading = getattr(item, "rich_help_panel", None) or plain
                found.setdefault(heading, []).append(told)
        return found

    def parse_args(self, ctx: Any, args: list[str]) -> list[str]:
        """Read what was typed; words beyond the arguments are told with those that there are."""
        ctx.allow_extra_args = True  # click's own sentence does not say what there is
        if stray := super().parse_args(ctx, args):
            taken = [item.name for item in self.params if item.param_type_name == "argument"]
            known = (
                f"{counted(len(taken), 'argument')}, {listed(taken)}" if taken else "no argument"
            )
            words = listed([repr(word) for word in stray])
            verb = "is" if len(stray) == 1 else "are"
            ctx.fail(f"{self.name} takes {known}: {words} {verb} too much.")
        return stray

    def format_options(self, ctx: Any, formatter: Any) -> None:
        """Write them."""
        for heading, rows in self.sections(ctx).items():
            with formatter.section(heading):
                formatter.write_dl(rows)


class Commands(typer.core.TyperGroup):
    """All commands, whose help tells each in whole sentences under its stage of the work."""

    def format_commands(self, ctx: Any, formatter: Any) -> None:  # noqa: ARG002
        """Write them."""
        for stage, own in by_stage().items():
            rows = [(name, about(name).split("\n\n")[0]) for name in own if name in self.commands]
            if rows:
                with formatter.section(stage.capitalize()):
                    formatter.write_dl(rows)


def application(asked: str = "") -> typer.Typer:
    """The application with the command that is asked for, else with all of them."""
    app = typer.Typer(
        name="pmmkit",
        cls=Commands,
        help="Captive ship-model tests to hydrodynamic derivatives, a model and its manoeuvres.",
        invoke_without_command=True,
        pretty_exceptions_enable=False,
        rich_markup_mode=None,
    )
    app.callback()(_options)
    if asked in LISTING:
        for name in names():
            app.command(name, help=about(name))(_listed)
        return app
    for name in [asked] if asked in names() else names():
        own = action(name)
        made = app.command(name, cls=Command, help=own.about, epilog=f"Example: {own.example}")
        made(_command(own))
    return app


def _listed() -> None:
    """A command of a list, which does not run."""
    raise NotImplementedError


def _command(own: Action) -> Callable[..., None]:
    """A command that does an action, tells its outcome and ends with its status."""

    def run(*, quiet: bool, json: bool, **given: Any) -> None:
        with _silence() if quiet else nullcontext():
            try:
                outcome = own.do(own.asked(_stated(own, given)))
            except SettingError as error:
                hint = error.option or None
                raise typer.BadParameter(str(error), param_hint=hint) from error
            tell(outcome, as_json=json, quiet=quiet)
        if outcome.status:
            raise typer.Exit(outcome.status)

    parameters = [*map(_parameter, own.fields)]
    for name, option in (("quiet", Quiet), ("json", Json)):
        parameters.append(_keyword(name, option, False))
    run.__signature__ = inspect.Signature(parameters)  # type: ignore[attr-defined]
    return run


def _stated(own: Action, given: Mapping[str, Any]) -> dict[str, Any]:
    """What was typed, several values as they are kept; the rest is as if absent."""
    several = {item.name for item in own.fields if item.several}
    return {
        name: tuple(value) if name in several else value
        for name, value in given.items()
        if value is not None
    }


def _parameter(item: JobSetting) -> inspect.Parameter:
    """A setting as typer takes it."""
    told = item.help
    more: dict[str, Any] = {"help": told.text, "min": told.least, "max": told.most}
    more |= {"metavar": told.metavar, "rich_help_panel": item.heading or None}
    if told.read is not None:
        more["parser"] = _reader(told.read)
    made = typer.Argument(**more) if told.argument else typer.Option(*item.options, **more)
    kind = list[item.bare] if item.several else item.type  # type: ignore[name-defined]
    if item.several and not item.required:
        kind = kind | None
    default = None if item.several else item.default
    return _keyword(
        item.name, Annotated[kind, made], inspect.Parameter.empty if item.required else default
    )


def _keyword(name: str, annotation: Any, default: Any) -> inspect.Parameter:
    kind = inspect.Parameter.KEYWORD_ONLY
    return inspect.Parameter(name, kind, default=default, annotation=annotation)


def _reader(read: Callable[[str], Any]) -> Callable[[str], Any]:
    """What reads a value out of its text; what cannot be read is told with the option."""

    def value(text: str) -> Any:
        try:
            return read(text)
        except SettingError as error:
            raise typer.BadParameter(str(error)) from error

    return value


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
        say(first_steps(Path.cwd()))
        raise typer.Exit(2)
