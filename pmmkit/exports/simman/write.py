"""A campaign as the archive that SIMMAN 2014 asks of those who made model tests."""

from __future__ import annotations

import tempfile
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Final

import numpy as np

from pmmkit.base import DataError
from pmmkit.campaigns import Campaign
from pmmkit.exports.campaign_csv import LONGEST, write_campaign_csv
from pmmkit.exports.simman import tables
from pmmkit.exports.simman.metadata import metadata
from pmmkit.exports.simman.tables import SimmanResult, results_of
from pmmkit.exports.text import write_archive
from pmmkit.files import CAMPAIGN, atomic_path
from pmmkit.readers import safe_names

METADATA: Final = "metadata.txt"
RECORDS: Final = "records"
CYCLES: Final = "cycles"
_TOLERANCE: Final = 1e-6
"""Share by which steps of a record may differ and still be of one sampling rate."""


def write_simman(campaign: Campaign, path: str | Path) -> None:
    """Write a zip archive of ASCII files: results, records, and a file that describes them.

    Notes
    -----
    ``static_means.csv``, ``fourier_coefficients.csv``, ``fourier_uncertainties.csv`` and
    ``cycles/`` hold what `reduce_campaign` finds in the runs; ``records/`` is the campaign itself,
    by which `open_campaign` opens the archive. The instructions [1]_ say what is handed in, not how
    files and columns are called.

    References
    ----------
    .. [1] SIMMAN 2014, Instructions, Model tests, Format of model test results.
    """
    target = Path(path)
    if target.suffix.lower() != ".zip":
        raise DataError(f"{path}: an archive for SIMMAN needs the ending .zip.")
    results = results_of(campaign) if campaign.kind == "captive" else []
    with tempfile.TemporaryDirectory() as room:
        folder = Path(room) / RECORDS
        names = write_campaign_csv(campaign, folder)
        found = dict(_result_files(results))
        listed = {**_told(found), **_records(names)}
        text = metadata(campaign, results, listed, _rates(campaign))
        with atomic_path(target) as part:
            write_archive(
                part,
                (
                    (name, content)
                    for source in (
                        [(METADATA, text.encode("ascii"))],
                        ((name, body.encode("ascii")) for name, body in found.items()),
                        ((f"{RECORDS}/{name}", _ascii(folder / name)) for name in names),
                    )
                    for name, content in source
                ),
            )


_RESULTS: Final = {
    "static_means.csv": "a row per static run: means of forces and motions",
    "fourier_coefficients.csv": "a row per oscillating run: Fourier coefficients of one cycle",
    "fourier_uncertainties.csv": "standard uncertainties of these, from the noise of the records",
}


def _result_files(results: Sequence[SimmanResult]) -> Iterator[tuple[str, str]]:
    """Names and texts of the results that there are."""
    makers = (tables.static_means, tables.fourier_coefficients, tables.fourier_uncertainties)
    for name, make in zip(_RESULTS, makers, strict=True):
        text = make(results)
        if text:
            yield name, text
    recorded = [item for item in results if item.run.dynamic and item.recorded]
    names = safe_names((item.run.id for item in recorded), "run")
    digits = len(str(len(recorded)))
    for place, (item, name) in enumerate(zip(recorded, names, strict=True), start=1):
        file = f"{CYCLES}/{place:0{digits}}_{name[:LONGEST]}.csv"
        yield file, tables.one_cycle_series(item, results)


def _told(found: dict[str, str]) -> dict[str, str]:
    told = {name: what for name, what in _RESULTS.items() if name in found}
    cycles = sum(name.startswith(CYCLES) for name in found)
    return told | (
        {f"{CYCLES}/": f"{cycles} files, the time series of one cycle of a run each"}
        if cycles
        else {}
    )


def _records(names: Sequence[str]) -> dict[str, str]:
    return {
        f"{RECORDS}/": f"{len(names) - 1} files, the full time series of every run that has one "
        "and the tables of those that have none, as they were measured",
        f"{RECORDS}/{CAMPAIGN.file}": "what each run was set to, ship, rig and stated "
        "uncertainties; pmmkit opens the archive by it",
    }


def _rates(campaign: Campaign) -> list[float]:
    """The sampling rates of records at even steps [Hz], each once."""
    found: dict[float, None] = {}
    for run in campaign.runs:
        if run.kind != "history":
            continue
        steps = np.diff(np.asarray(run.data["t"].values, float))
        step = float(np.median(steps)) if len(steps) else 0.0
        if step > 0 and np.abs(steps - step).max() <= _TOLERANCE * step:
            found[float(f"{1 / step:.5g}")] = None
    return sorted(found)


def _ascii(file: Path) -> bytes:
    """A text in which letters beyond ASCII stand as TOML writes them by their number."""
    text = file.read_text(encoding="utf-8")
    return "".join(
        x if x.isascii() else f"\\u{ord(x):04X}" if ord(x) <= 0xFFFF else f"\\U{ord(x):08X}"
        for x in text
    ).encode("ascii")
