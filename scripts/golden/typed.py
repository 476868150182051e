"""Commands as they are typed, and everything that they leave: status, words, JSON, files."""

from __future__ import annotations

import io
import json
import shlex
from collections.abc import Callable, Sequence
from contextlib import redirect_stderr, redirect_stdout
from pathlib import Path
from typing import Any

from scripts.golden.files import content
from scripts.golden.job import ROOT, empty_folder, masked, measurements
from scripts.golden.values import text


def typed(*lines: str, made: Callable[[Path], object] | None = None) -> dict[str, Any]:
    """What commands leave, one after another in an empty folder.

    Parameters
    ----------
    *lines : str
        Each without the word pmmkit. `datasets/` is that of the repository, DATA the folder of
        measurements.
    made : callable, optional
        Puts files into the folder before.

    Returns
    -------
    dict
        By line: status, words on both streams, and the files that are new.
    """
    found: dict[str, Any] = {}
    with empty_folder() as folder:
        if made is not None:
            made(folder)
        (folder / "datasets").symlink_to(ROOT / "datasets", target_is_directory=True)
        seen = _files(folder)
        for line in lines:
            words = shlex.split(line.replace("DATA/", f"{measurements()}/"))
            words = [str(measurements()) if word == "DATA" else word for word in words]
            status, out, err = run(words)
            files = _files(folder)
            found[line] = {
                "status": status,
                "out": _told(masked(out, folder)),
                "err": text(masked(err, folder)),
                "files": {
                    path.relative_to(folder).as_posix(): content(path, folder)
                    for path in sorted(files - seen)
                },
            }
            seen = files
    return found


def run(words: Sequence[str]) -> tuple[int, str, str]:
    """Status and both streams of a command, in this process."""
    from pmmkit.cli import main

    with redirect_stdout(io.StringIO()) as out, redirect_stderr(io.StringIO()) as err:
        try:
            status = main(list(words))
        except SystemExit as stop:
            status = int(stop.code or 0)
    return status, out.getvalue(), err.getvalue()


def _files(folder: Path) -> set[Path]:
    """All files of a folder; links, which lead to the repository, are not followed."""
    return {
        path
        for path in folder.rglob("*")
        if path.is_file() and path.relative_to(folder).parts[0] != "datasets"
    }


def _told(out: str) -> Any:
    """JSON as values, other words by line."""
    if out.startswith("{"):
        try:
            return json.loads(out)
        except ValueError:
            pass
    return text(out)
