"""What a job gives: content for programs, lines for people, how it ends, and where it writes."""

from __future__ import annotations

import os
import sys
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import chain, count
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

from pmmkit.base import DataError
from pmmkit.presentation import quoted

if TYPE_CHECKING:
    from pmmkit.campaigns import Campaign
    from pmmkit.intake import CheckFinding
    from pmmkit.models import Model
    from pmmkit.plotting import Figure


DONE: Final = 0
WRONG: Final = 1
"""Status of a job whose data, or whose request, is wrong."""
NAMED: Final = 30
"""Runs without a file that are named, more than a programme has by default."""
NOT_USABLE: Final = 3
"""Status of a job that did what was asked, with a result that is not usable."""


@dataclass(frozen=True, kw_only=True)
class Outcome:
    """What a job did.

    Parameters
    ----------
    content : mapping
        For programs.
    lines : sequence of str
        For people.
    status : int
        Of its end: 0 done, 1 the data are wrong, 3 done but not usable.
    """

    content: Mapping[str, Any]
    lines: Sequence[str]
    status: int = DONE

    def then(self, *lines: str) -> Outcome:
        """The same with lines below."""
        return replace(self, lines=[*self.lines, *lines])


def written(
    folder: Path,
    results: Iterable[tuple[str, Any]],
    content: Mapping[str, Any],
    lines: Sequence[str],
) -> Outcome:
    """The outcome of a job that writes its results to a folder: all of them, or nothing."""
    from pmmkit.files import write_results

    files = write_results(folder, results)
    return Outcome(
        content={"out": str(folder), "files": files, **content},
        lines=[*lines, f"Results: {folder}"],
    )


def marked(outcome: Outcome, model: Model | str) -> Outcome:
    """What a job did with a model, or what was typed for one; where that was made by force, this
    stands above it. A structure has no force."""
    if isinstance(model, str):
        from pmmkit.conventions import STRUCTURES
        from pmmkit.models import load_model

        if model in STRUCTURES:
            return outcome
        model = load_model(model)
    why = model.not_usable
    if not why:
        return outcome
    content = {"not_usable": why, **outcome.content}
    return replace(outcome, content=content, lines=[why, "", *outcome.lines], status=NOT_USABLE)


def say(text: str = "") -> None:
    """Print a line, `text`, for the person at the keyboard while a job runs, on standard error."""
    print(text, file=sys.stderr)


def words_of(error: Exception) -> str:
    """What an `error` says to who types commands."""
    return error.said("command") if isinstance(error, DataError) else str(error)


def warned(findings: Iterable[CheckFinding]) -> list[str]:
    """What the checks said, each once."""
    return list(dict.fromkeys(f"{item.severity}: {item.message}" for item in findings))


def not_made(campaign: Campaign) -> list[str]:
    """Which runs of a programme have no file yet, in a line: a name may be misspelt."""
    from pmmkit.intake import name_runs

    missing = campaign.not_made
    return [f"Not made yet (no file): {name_runs(missing, NAMED)}"] if missing else []


# Where a job writes: nothing that is there is overwritten unless it was named, and said.


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
) -> Path:
    """The file of the result."""
    if target is None:
        file = free_file(Path(default))
        if file != Path(default):
            say(f"{quoted(Path(default))} is there: this goes to {quoted(file)}.")
        return file
    keep_what_was_read(target, read, force=force, option="--output")
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

    return [(f"{name}.{ending}", own.save) for name, own in figures.items()]
