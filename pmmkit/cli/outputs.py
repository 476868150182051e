"""Where a command writes: nothing that is there is overwritten unless it was named, and said."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path
from typing import Annotated

import typer

from pmmkit.cli.output import say
from pmmkit.escaping import quoted

Out = Annotated[
    Path | None,
    typer.Option(
        "--out",
        help="Folder of the results, whose files of the same name are replaced; a new one beside "
        "those of former calls if absent.",
    ),
]
Force = Annotated[
    bool, typer.Option("--force", help="Let the output replace the very file that was read.")
]


def results_folder(
    out: Path | None,
    default: str | Path,
    *,
    read: Iterable[str | Path | None] = (),
    force: bool = False,
) -> Path:
    """The folder of the results, which can be written.

    Parameters
    ----------
    out : Path, optional
        The folder that was named: it is taken, with a word on results that stand there.
    default : str or Path
        Its name otherwise; the next free one where that is taken.
    read : iterable of str or Path
        Model files that the command reads, of a command that writes a model.
    force : bool
        Allow the model that is written to replace one of them.

    Raises
    ------
    FileExists
        If the folder cannot be written, or its model is one that the command reads.
    """
    from pmmkit.files import check_folder, free_folder, is_empty_place
    from pmmkit.toml_files import MODEL

    folder = out or free_folder(Path(default))
    check_folder(folder)
    if out is not None:
        keep_what_was_read(out / MODEL.file, read, force=force, option="--out")
        if not is_empty_place(out):
            say(f"{quoted(out)} is not empty: files of the same names are replaced.")
    elif folder != Path(default):
        say(f"{quoted(Path(default))} holds former results: these go to {quoted(folder)}.")
    return folder


def results_file(
    target: Path | None,
    default: str | Path,
    *,
    read: Iterable[str | Path | None] = (),
    force: bool = False,
    option: str = "--output",
) -> Path:
    """The file of the result.

    Parameters
    ----------
    target : Path, optional
        The file that was named: one that is there is replaced, with a word.
    default : str or Path
        Its name otherwise; the next free one where that is taken.
    read : iterable of str or Path
        What the command reads, which is replaced only by `force`.
    force : bool
        Allow that.
    option : str
        By which the file is named.

    Raises
    ------
    FileExists
        If the file is one that the command reads.
    """
    from pmmkit.files import free_file

    if target is None:
        file = free_file(Path(default))
        if file != Path(default):
            say(f"{quoted(Path(default))} is there: this goes to {quoted(file)}.")
        return file
    keep_what_was_read(target, read, force=force, option=option)
    if target.is_file():
        say(f"{quoted(target)} is there: it is replaced.")
    return target


def keep_what_was_read(
    target: Path, read: Iterable[str | Path | None], *, force: bool, option: str
) -> None:
    """Refuse to write over what the command reads, unless `force` is set."""
    from pmmkit.errors import FileExists

    if force or not target.exists():
        return
    if any(item is not None and Path(item).resolve() == target.resolve() for item in read):
        raise FileExists(
            f"{target} is what is read: it was not replaced. Name another {option}, or --force."
        )
