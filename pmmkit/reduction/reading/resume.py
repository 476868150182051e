"""Results of runs kept on disk while a campaign is read, so that an interrupted command goes on.

One file a run: a checksum and JSON text, in which every number stands to the last bit. Its name is
a hash over the content of the run's files, the run, the settings and pmmkit's version, so a
result is only taken up for what it was made from. Nothing in a file is ever executed; a damaged
file counts as none.
"""

from __future__ import annotations

import hashlib
import os
import shutil
import threading
import uuid
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field, fields
from pathlib import Path
from typing import Any, Final

from pmmkit.base import PmmkitError, __version__
from pmmkit.campaigns import Run, Settings
from pmmkit.files import from_json, sha256, to_json
from pmmkit.intake import Summary
from pmmkit.reduction.observations.equations import Rows, Sensitivity
from pmmkit.reduction.observations.histories import RunHistory
from pmmkit.reduction.observations.prepare import RunResult
from pmmkit.reduction.reading.run import Reading, ReductionSettings

LAYOUT: Final = 4
"""Version of the files' content."""


def resume_folder(out: Path) -> Path:
    """Where the results of runs lie while the command that writes the folder `out` reads them.

    Examples
    --------
    >>> resume_folder(Path("work/my-campaign-reduced")).name
    '.my-campaign-reduced-resume'
    """
    target = out.resolve()
    return target.with_name(f".{target.name}-resume")


@contextmanager
def resumable(out: Path) -> Iterator[Path]:
    """The folder in which results of runs are kept while `out` is made; removed once it is.

    Parameters
    ----------
    out : path
        The folder that a command writes.
    """
    folder = resume_folder(out)
    yield folder
    shutil.rmtree(folder, ignore_errors=True)


@dataclass(frozen=True, kw_only=True)
class StoredResults:
    """Results of the runs of one campaign, kept in a folder.

    `folder`: the folder; it is made when there is something to keep. `settings`: how the runs
    are read.
    """

    folder: Path
    settings: ReductionSettings
    _digests: dict[Path, str] = field(default_factory=dict, repr=False)
    _lock: threading.Lock = field(default_factory=threading.Lock, repr=False)

    def load(self, run: Run) -> Reading | None:
        """The result of a run if its content was read before with the same settings."""
        if not self.folder.is_dir():
            return None
        file = self._file(run)
        if file is None:
            return None
        try:
            checksum, _, text = file.read_bytes().partition(b"\n")
            if _checksum(file, text) != checksum:
                return None
            return _restored(from_json(text.decode()), run, self.settings)
        except (OSError, PmmkitError, ValueError, TypeError, LookupError, RecursionError):
            return None

    def save(self, run: Run, reading: Reading) -> None:
        """Keep the result of a run; a folder that cannot be written keeps nothing."""
        file = self._file(run)
        if file is None:
            return
        text = to_json(_plain(reading)).encode()
        part = file.with_name(f".{uuid.uuid4().hex}.part")
        try:
            self.folder.mkdir(parents=True, exist_ok=True)
            part.write_bytes(_checksum(file, text) + b"\n" + text)
            os.replace(part, file)
        except OSError:
            part.unlink(missing_ok=True)

    def _file(self, run: Run) -> Path | None:
        """The file of a run; None for one that does not come from a history on disk."""
        if run.kind != "history":
            return None
        try:
            content = [self._digest(path) for path in run.files().values()]
        except (OSError, PmmkitError):
            return None
        if not content:
            return None
        campaign = self.settings.campaign.with_(runs=(), excluded=(), title="", provenance={})
        parts = (
            LAYOUT,
            __version__,
            content,
            campaign,
            self.settings.columns,
            self.settings.convention,
            self.settings.cycles,
            self.settings.blockage,
            self.settings.integrated,
            self.settings.library,
            run,
            run.loader,
        )
        return self.folder / f"{hashlib.sha256(repr(parts).encode()).hexdigest()}.json"

    def _digest(self, path: Path) -> str:
        """Hash of a file's content, found once."""
        with self._lock:
            known = self._digests.get(path)
        if known is None:
            known = sha256(path)
            with self._lock:
                self._digests[path] = known
        return known


def _checksum(file: Path, text: bytes) -> bytes:
    """Of a file's text and its name, so that no result passes for that of another run."""
    return hashlib.sha256(file.name.encode() + text).hexdigest().encode()


def _plain(reading: Reading) -> dict[str, Any]:
    """A result as mappings, tuples and arrays, without what the campaign gives anew."""
    rows, result = reading.rows, reading.rows.result
    return {
        "settings": result.run.settings.plain(),
        "result": _fields(result, "run"),
        "rows": _fields(rows, "result"),
        "sensitivities": [_fields(item, "source", "names") for item in reading.sensitivities],
        "summary": _fields(reading.summary, "run"),
        "history": reading.history and _fields(reading.history),
    }


def _fields(item: Any, *without: str) -> dict[str, Any]:
    return {
        each.name: getattr(item, each.name) for each in fields(item) if each.name not in without
    }


def _restored(plain: Mapping[str, Any], run: Run, settings: ReductionSettings) -> Reading:
    kept = run.with_(settings=Settings.of(plain["settings"]))
    rows = Rows(result=RunResult(run=kept, **plain["result"]), **plain["rows"])
    return Reading(
        rows=rows,
        sensitivities=tuple(
            Sensitivity(source=source, names=rows.names, **item)
            for source, item in zip(settings.sources, plain["sensitivities"], strict=True)
        ),
        summary=Summary(run=run, **plain["summary"]),
        history=plain["history"] and RunHistory(**plain["history"]),
    )
