"""``pmmkit inspect``."""

from __future__ import annotations

from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Final

import typer

from pmmkit.cli.output import Outcome
from pmmkit.cli.outputs import Out
from pmmkit.presentation import quoted

if TYPE_CHECKING:
    from pmmkit.intake import Look


EXAMPLE: Final = "pmmkit inspect my-files"


def inspect(
    path: Annotated[Path, typer.Argument(help="File of measurements, or a folder with many.")],
    out: Out = None,
) -> Outcome:
    """Say what a file or a folder holds: format, columns, units, and what they probably are."""
    from pmmkit.files import check_folder
    from pmmkit.intake import look, look_content, look_lines

    if out:
        check_folder(out)
    found = look(path)
    lines = look_lines(found)
    files = [str(out / name) for name in _write(found, out)] if out else []
    lines += [f"Written: {file}" for file in files]
    if found.groups and not any(item.file == "campaign.toml" for item in found.campaigns):
        folder = path if path.is_dir() else path.parent
        lines += ["", f"Next: pmmkit new-campaign {quoted(folder)}"]
    return Outcome(content={"path": str(path), **look_content(found), "files": files}, lines=lines)


def _write(found: Look, out: Path) -> list[str]:
    from pmmkit.files import write_results
    from pmmkit.intake import columns_csv
    from pmmkit.plotting import save
    from pmmkit.views import first_look

    results: list[tuple[str, Any]] = []
    if found.groups:
        results.append(("inspect.csv", columns_csv(found)))
    if figure := first_look(found):
        results.append(("inspect.png", partial(save, figure)))
    return write_results(out, results)
