"""Commands as they are typed, and everything that they leave: status, words, JSON, files."""

from __future__ import annotations

import csv
import io
import json
import re
import shlex
import tomllib
import zipfile
from collections.abc import Sequence
from contextlib import redirect_stderr, redirect_stdout
from pathlib import Path
from typing import Any

from scripts.golden.differences import lines_of
from scripts.golden.job import ROOT, empty_folder, masked, measurements

SKIPPED = (".png", ".svg", ".nc", ".h5", ".docx", ".pdf")
"""Pictures, and files whose numbers stand in another one beside them."""
PROGRESS = re.compile(r"\s*\d+ of \d+: ")
"""Lines that come by the clock."""
PACKED = (".zip", ".fmu", ".xlsx")


def typed(*lines: str) -> dict[str, Any]:
    """What commands leave, one after another in an empty folder.

    Parameters
    ----------
    *lines : str
        Each without the word pmmkit. DATASETS and DATA stand for the folders of both.

    Returns
    -------
    dict
        By line: status, words on both streams, and the files that are new.
    """
    found: dict[str, Any] = {}
    with empty_folder() as folder:
        (folder / "datasets").symlink_to(ROOT / "datasets", target_is_directory=True)
        seen: set[Path] = set()
        for line in lines:
            words = shlex.split(line.replace("DATA/", f"{measurements()}/"))
            words = [str(measurements()) if word == "DATA" else word for word in words]
            status, out, err = _run(words)
            files = {
                path
                for path in folder.rglob("*")
                if path.is_file() and "datasets" not in path.relative_to(folder).parts
            }
            found[line] = {
                "status": status,
                "out": _told(masked(out, folder)),
                "err": [x for x in masked(err, folder).splitlines() if not PROGRESS.match(x)],
                "files": {
                    path.relative_to(folder).as_posix(): _content(path, folder)
                    for path in sorted(files - seen)
                },
            }
            seen = files
    return found


def _run(words: Sequence[str]) -> tuple[int, str, str]:
    from pmmkit.cli import main

    with redirect_stdout(io.StringIO()) as out, redirect_stderr(io.StringIO()) as err:
        try:
            status = main(list(words))
        except SystemExit as stop:
            status = int(stop.code or 0)
    return status, out.getvalue(), err.getvalue()


def _told(text: str) -> Any:
    """JSON as values, other words by line."""
    if text.startswith("{"):
        try:
            return json.loads(text)
        except ValueError:
            pass
    return text.splitlines()


def _content(path: Path, folder: Path) -> Any:
    """What a file holds: numbers where it has some, texts by line."""
    suffix = path.suffix.lower()
    if suffix in SKIPPED:
        return "there"
    if suffix in PACKED:
        with zipfile.ZipFile(path) as archive:
            return sorted(name for name in archive.namelist() if "docProps" not in name)
    text = masked(path.read_text(encoding="utf-8"), folder)
    if suffix == ".json":
        return json.loads(text)
    if suffix == ".toml":
        return tomllib.loads(text)
    if suffix == ".csv":
        return columns_of(text)
    if suffix in (".html", ".htm"):
        text = re.sub(r"<(style|script|svg)\b.*?</\1>", "", text, flags=re.DOTALL)
        text = re.sub(r"<[^>]+>", "\n", text)
        return lines_of("\n".join(line.strip() for line in text.splitlines() if line.strip()))
    return lines_of(text)


def columns_of(text: str) -> dict[str, list[Any]]:
    """The columns of a CSV file, numbers as numbers; those below no name by their place."""
    rows = [row for row in csv.reader(io.StringIO(text)) if row]
    width = max(map(len, rows), default=0)
    names = [f"{k} {rows[0][k] if k < len(rows[0]) else ''}" for k in range(width)]
    return {
        name: [_number(row[k]) if k < len(row) else "" for row in rows[1:]]
        for k, name in enumerate(names)
    }


def _number(text: str) -> Any:
    try:
        return float(text)
    except ValueError:
        return text
