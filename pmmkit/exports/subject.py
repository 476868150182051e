"""What a name or a path stands for: a model, a table, a campaign or a track."""

from __future__ import annotations

import csv
import tomllib
from pathlib import Path
from typing import TYPE_CHECKING, Final

from pmmkit.base import DataError
from pmmkit.campaigns import Campaign, open_campaign
from pmmkit.exports.track import read_track
from pmmkit.files import CAMPAIGN, Url
from pmmkit.models import DerivativeTable, Model, load_model, read_table, ships
from pmmkit.readers import recognise

if TYPE_CHECKING:
    import xarray as xr

    Subject = Model | DerivativeTable | Campaign | xr.Dataset

_HDF5: Final = (".h5", ".hdf5", ".nc")
_REMEDY: Final = (
    "Name a library ship (pmmkit ships), a model file, a campaign, a derivative table or the "
    "track.csv of a simulation."
)


def read_subject(what: str | Path, *, data: str | Path | None = None) -> Subject:
    """Read what is to be exported, whatever it is.

    Parameters
    ----------
    what : str or path
        A library ship; a model file; a folder with ``campaign.toml``, such a file, a saved or
        a packed campaign, or the URL of one; a derivative table (``.csv``, ``.nc``, ``.h5``,
        ``.xlsx``); a ``track.csv``.
    data : path, optional
        Of a campaign, as for `open_campaign`.

    Returns
    -------
    Model, DerivativeTable, Campaign or Dataset
        A Dataset is a track.

    Raises
    ------
    DataError
        If it is nothing of these, or damaged.

    Examples
    --------
    >>> read_subject("kvlcc2-l7").name
    'kvlcc2-l7'
    """
    if Url.of(what) is not None:
        return open_campaign(what, data=data)
    path = Path(what).expanduser()
    if not path.exists():
        if str(what) in ships():
            return load_model(str(what))
        if path.parts[:1] != ("datasets",):
            raise DataError(
                "there is no such file, folder or library ship.", file=str(what), remedy=_REMEDY
            )
    suffix = path.suffix.lower()
    if path.is_file() and suffix == ".csv":
        return read_track(path) if _is_track(path) else read_table(path)
    if path.is_file() and suffix == ".xlsx":
        return read_table(path)
    if path.is_file() and suffix in _HDF5 and recognise(path) != "pmmkit":
        return read_table(path)
    if path.is_file() and suffix == ".toml" and _is_model(path):
        return load_model(path)
    if path.is_file() and suffix not in (".toml", ".zip", *_HDF5):
        raise DataError("is nothing that can be exported.", file=str(what), remedy=_REMEDY)
    return open_campaign(path, data=data)


def _is_track(path: Path) -> bool:
    """Whether a CSV file has a column of times and none of derivatives."""
    with path.open(encoding="utf-8-sig", errors="replace", newline="") as stream:
        titles = next(csv.reader([stream.readline(65536)]), [])
    names = {title.split("[")[0].strip() for title in titles}
    return "t" in names and "derivative" not in names


def _is_model(path: Path) -> bool:
    """Whether a TOML file has what only model files have; the rest are campaign files."""
    if path.name == CAMPAIGN.file:
        return False
    try:
        content = tomllib.loads(path.read_bytes().decode("utf-8-sig"))
    except (OSError, ValueError, RecursionError):
        return True
    return "campaign" not in content
