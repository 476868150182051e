"""Where a job writes: nothing that is there is overwritten unless it was named, and said."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

from pmmkit.actions.outcome import say
from pmmkit.presentation import quoted


def results_folder(
    out: Path | None,
    default: str | Path,
    *,
    read: Iterable[str | Path | None] = (),
    force: bool = False,
) -> Path:
    """The folder of the results, which can be written."""
    from pmmkit.files import MODEL, check_folder, free_folder, is_empty_place

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
    """The file of the result."""
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
    """Refuse to write over what the job reads, unless `force` is set."""
    from pmmkit.base import FileExists

    if force or not target.exists():
        return
    if any(item is not None and Path(item).resolve() == target.resolve() for item in read):
        raise FileExists(
            f"{target} is what is read: it was not replaced. Name another {option}, or --force."
        )
