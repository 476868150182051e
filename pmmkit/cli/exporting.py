"""The work behind the command that writes for other programs."""

from __future__ import annotations

from pathlib import Path

from pmmkit import exports
from pmmkit.cli.console import Outcome
from pmmkit.cli.options import stem
from pmmkit.exports.subject import read_subject
from pmmkit.exports.write import file_name


def export(
    what: str, *, to: str | None, output: Path | None, speed: float | None, data: Path | None
) -> Outcome:
    """Write something for other programs.

    Parameters
    ----------
    what : str
        Library ship or path.
    to : str, optional
        The format; one of it and `output` is there.
    output : Path, optional
        File or folder; by default in the present folder, with the name of `what`.
    speed, data
        As for `exports.export`.

    Returns
    -------
    Outcome
        With the files.
    """
    target = output
    if target is None:
        assert to is not None
        target = Path(file_name(read_subject(what, data=data), stem(Path(what)), to))
    files = exports.export(what, target, to, speed=speed, data=data)
    return Outcome(
        content={"files": [str(file) for file in files]},
        lines=[f"{target}: {len(files)} files." if target.is_dir() else f"Written: {target}"],
    )
