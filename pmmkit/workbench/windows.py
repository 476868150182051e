"""What counts of a record, drawn by a person and written into the campaign file with the reason."""

from __future__ import annotations

import tomllib
from collections.abc import Callable
from pathlib import Path
from typing import Any, Final

from pmmkit.base import DataError, FileExists
from pmmkit.campaigns import Campaign, CampaignFile, campaign_of, usable
from pmmkit.files import CAMPAIGN, datasets_folder, write_text
from pmmkit.reduction import PreparedRun
from pmmkit.views import window_entry

LONGEST: Final = 400
"""Characters of a reason."""


def drawn(
    place: Path, data: str, start: float, end: float, reason: str
) -> Callable[[Campaign, str], None]:
    """Writes a window of a run, in the place of one that was stated for it alone.

    start, end [s].
    """
    said = " ".join(reason.split())
    if not said or len(said) > LONGEST:
        raise DataError("Say why in a sentence: the reason stands in the campaign file.")
    if not start < end:
        raise DataError("The window ends before it begins.")
    file = _writable(place)

    def write(campaign: Campaign, run: str) -> None:
        entry: dict[str, Any] = {
            **window_entry(campaign, run),
            "t_start": round(start, 6),
            "t_end": round(end, 6),
            "reason": said,
        }
        _write(file, data, run, lambda it: it.with_correction(entry))

    return write


def taken_back(place: Path, data: str) -> Callable[[Campaign, str], None]:
    """Takes the window of a run out of the file: what counts is found again."""
    file = _writable(place)

    def write(campaign: Campaign, run: str) -> None:
        entry = window_entry(campaign, run)
        _write(file, data, run, lambda it: it.without_correction(entry))

    return write


def _write(file: Path, data: str, run: str, change: Callable[[CampaignFile], str]) -> None:
    """The file with the change, where the run can be used with it."""
    try:
        text = change(CampaignFile(file.read_bytes().decode("utf-8")))
    except (OSError, UnicodeDecodeError) as error:
        raise DataError(f"{file} cannot be read: {error}.") from error
    campaign = campaign_of(tomllib.loads(text), file, data=data or None)
    tried = campaign[run]
    if campaign.kind == "captive":
        PreparedRun.of(tried, campaign, noise=False)
    elif not usable(tried).segments:
        raise DataError("Nothing of the record that can be used is left.")
    try:
        write_text(file, text)
    except OSError as error:
        raise FileExists(f"{file} cannot be written: {error.strerror}.") from error


def _writable(place: Path) -> Path:
    file = place / CAMPAIGN.file if place.is_dir() else place
    if file.resolve().is_relative_to(datasets_folder().resolve()):
        raise DataError(
            f"{place} belongs to pmmkit and is not changed. Copy the folder, and open the copy."
        )
    if file.suffix != ".toml":
        raise DataError(
            f"{file.name} is a saved campaign and is not changed. Draft a campaign file for it "
            "(pmmkit new-campaign), and open that."
        )
    return file
