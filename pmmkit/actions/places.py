"""Where a job writes: nothing that is there is overwritten unless it was named, and said."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable, Mapping
from functools import partial
from itertools import chain, count
from pathlib import Path
from typing import TYPE_CHECKING

from pmmkit.actions.outcome import say
from pmmkit.presentation import quoted

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def results_folder(
    out: Path | None,
    default: str | Path,
    *,
    read: Iterable[str | Path | None] = (),
    force: bool = False,
) -> Path:
    """The folder of the results, which can be written."""
    from pmmkit.files import MODEL, free_folder, is_empty_place

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
    if target is None:
        file = free_file(Path(default))
        if file != Path(default):
            say(f"{quoted(Path(default))} is there: this goes to {quoted(file)}.")
        return file
    keep_what_was_read(target, read, force=force, option=option)
    if target.is_file():
        say(f"{quoted(target)} is there: it is replaced.")
    return target


def check_folder(path: Path) -> None:
    """Refuse a folder that cannot be written, before anything is computed."""
    from pmmkit.base import FileExists

    target = path.resolve()
    if target.exists() and not target.is_dir():
        raise FileExists(f"{path} is a file; the results need a folder. Choose another --out.")
    above = next(folder for folder in (target, *target.parents) if folder.exists())
    if not above.is_dir() or not os.access(above, os.W_OK):
        raise FileExists(f"{path} cannot be written: no permission. Choose another --out.")


def free_file(path: Path) -> Path:
    """A file, or the same name with a number where it is there.

    The number comes after an underscore unless the name has hyphens: some names, such as those of
    MATLAB's functions, must not have any.

    Examples
    --------
    >>> import tempfile
    >>> folder = Path(tempfile.mkdtemp())
    >>> (folder / "kvlcc2.m").touch()
    >>> free_file(folder / "kvlcc2.m").name
    'kvlcc2_2.m'
    """
    from pmmkit.files import is_empty_place

    join = "-" if "-" in path.stem else "_"
    numbered = (path.with_name(f"{path.stem}{join}{n}{path.suffix}") for n in count(2))
    return next(filter(is_empty_place, chain([path], numbered)))


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


def figure_files(
    figures: Mapping[str, Figure], ending: str = "svg"
) -> list[tuple[str, Callable[[Path], Path]]]:
    """Figures by name as results to be written (see `files.write_results`)."""
    from pmmkit.plotting import save

    return [(f"{name}.{ending}", partial(save, figure)) for name, figure in figures.items()]
