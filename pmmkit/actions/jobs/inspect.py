"""Say what a file or a folder holds: format, columns, units, and what they probably are."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

from pmmkit.actions.outcome import Outcome, check_folder
from pmmkit.actions.setting import setting, settings
from pmmkit.actions.shared import Out
from pmmkit.presentation import quoted

if TYPE_CHECKING:
    from pmmkit.intake import Look


STAGE: Final = ("measure", 1)
EXAMPLE: Final = "pmmkit inspect my-files"


@settings
class InspectSettings:
    """What is asked."""

    path: Path = setting("File of measurements, or a folder with many.", argument=True)
    out: Out = None


def inspect(job: InspectSettings) -> Outcome:
    """Do what is asked."""
    from pmmkit.intake import look

    if job.out:
        check_folder(job.out)
    found = look(job.path)
    lines = found.lines()
    files = [str(job.out / name) for name in _write(found, job.out)] if job.out else []
    lines += [f"Written: {file}" for file in files]
    if found.groups and not any(item.file == "campaign.toml" for item in found.campaigns):
        folder = job.path if job.path.is_dir() else job.path.parent
        lines += ["", f"Next: pmmkit new-campaign {quoted(folder)}"]
    return Outcome(content={"path": str(job.path), **found.to_dict(), "files": files}, lines=lines)


def _write(found: Look, out: Path) -> list[str]:
    from pmmkit.files import write_results
    from pmmkit.views import first_look

    results: list[tuple[str, Any]] = []
    if found.groups:
        results.append(("inspect.csv", found.columns_csv()))
    if figure := first_look(found):
        results.append(("inspect.png", figure.save))
    return write_results(out, results)
