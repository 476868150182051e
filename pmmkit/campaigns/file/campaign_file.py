"""Opening a campaign: the campaign file, or a campaign that pmmkit saved."""

from __future__ import annotations

import hashlib
import re
import tomllib
from collections.abc import Mapping
from pathlib import Path, PurePath
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, Final

from pmmkit.base import CampaignError, did_you_mean
from pmmkit.campaigns.campaign import Campaign
from pmmkit.campaigns.file.search import InArchive, Search, folder_name, folder_of, origin_of
from pmmkit.files import CAMPAIGN, Origin, check_numbers, datasets_folder, local_copy, refuse_other
from pmmkit.presentation import quoted
from pmmkit.readers import SIGNATURE

if TYPE_CHECKING:
    from pmmkit.campaigns.file.assembly import Assembled, Setup

_TESTS: Final = ("runs", "matrix", "tables", "corrections")
_SAVED: Final = (".h5", ".hdf5", ".nc")
PACKED: Final = ".zip"
"""Ending of an archive that holds a campaign."""


def open_campaign(
    path: str | Path, *, data: str | Path | None = None, runs: bool = True
) -> Campaign:
    """Open a campaign; samples are read only when a run is asked for.

    Parameters
    ----------
    path : path
        A folder with ``campaign.toml``, such a file itself, a campaign saved by pmmkit
        (``.h5``, ``.nc``), or a zip archive that holds a ``campaign.toml`` and its text files; or
        the URL of one (``https://…``, ``s3://…``), whose files are copied when they are read.
    data : path, optional
        Folder of measurements that do not lie beside the campaign file. Files are looked for in
        ``data/data_folder`` (the key of ``[campaign]``), then in ``data``, then beside the
        campaign file. It may be a URL. Default: the environment variable PMMKIT_DATA.
    runs : bool
        False leaves the tests out and asks for none: ship, water and rig alone.

    Returns
    -------
    Campaign
        Everything SI, in ship axes and pmmkit's signs. Tables whose rows are runs have been read;
        of histories it is only known that the files are there.

    Raises
    ------
    CampaignError
        With everything that is wrong with the campaign file and with the tables it names.
    DataError
        If what stands behind a URL cannot be fetched.

    Examples
    --------
    >>> import tempfile
    >>> folder = Path(tempfile.mkdtemp())
    >>> rows = "beta,X,Y,N\\n0,-20.1,0.2,0.1\\n4,-21.0,35.5,60.2\\n"
    >>> _ = (folder / "drift.csv").write_text(rows)
    >>> _ = (folder / "campaign.toml").write_text('''
    ... [campaign]
    ... title = "Drift"
    ... [ship]
    ... name = "box"
    ... L = 4.0
    ... B = 1.0
    ... d = 0.25
    ... volume = 0.5
    ... Izz = 500.0
    ... [water]
    ... rho = 1000.0
    ... [columns]
    ... drift_deg = "beta"
    ... [[tables]]
    ... id = "SD_{beta}"
    ... test = "static_drift"
    ... file = "drift.csv"
    ... speed = 1.0
    ... ''')
    >>> campaign = open_campaign(folder)
    >>> [run.id for run in campaign], float(campaign["SD_4"].data["Y"])
    (['SD_0', 'SD_4'], 35.5)
    """
    origin = origin_of(path, (".toml", *_SAVED, PACKED))
    place = _place(Path(path).expanduser()) if origin is None else local_copy(origin)
    if place.suffix.lower() in _SAVED:
        from pmmkit.campaigns.store import load_campaign

        stored = _traced(load_campaign(place), origin)
        return stored if runs else stored.with_(runs=(), excluded=(), check_loads=())
    if place.suffix.lower() == PACKED:
        from pmmkit.campaigns.file.search import packed_campaign

        packed = packed_campaign(place)
        raw, digest = _content(packed.text(), packed.place)
        search: Search = InArchive(own=place.parent, data=None, archive=place, origin=origin)
        content = _asked(packed.pointed(raw), runs)
        return _assemble(content, packed.place, search, digest, origin, runs)
    raw, digest = _content(_bytes(place), place)
    content = _asked(raw, runs)
    search = Search.of(place, data, folder_of(origin))
    return _assemble(content, place, search, digest, origin, runs)


def _traced(campaign: Campaign, origin: Origin | None) -> Campaign:
    """A saved campaign that says behind which URL it was."""
    if origin is None:
        return campaign
    provenance = MappingProxyType({**campaign.provenance, "url": origin.shown})
    return campaign.with_(provenance=provenance)


def _content(data: bytes, place: Path) -> tuple[dict[str, Any], str]:
    """What a campaign file holds, and the hash of its bytes."""
    raw = _toml(_text(data, place), place)
    refuse_other(raw, CAMPAIGN, place.name, CampaignError)
    check_numbers(raw, place.name, CampaignError)
    _check_end(raw, place)
    return raw, hashlib.sha256(data).hexdigest()


def _asked(raw: dict[str, Any], runs: bool) -> dict[str, Any]:
    """The content with or without the tests."""
    return raw if runs else {name: item for name, item in raw.items() if name not in _TESTS}


def campaign_of(raw: Mapping[str, Any], place: Path, *, data: str | Path | None = None) -> Campaign:
    """The campaign of a file that is not written yet.

    Parameters
    ----------
    raw : mapping
        What the file would hold, as `tomllib` reads it.
    place : Path
        Where it would lie: its files are looked for from there.
    data : path, optional
        As for `open_campaign`.

    Raises
    ------
    CampaignError
        As `open_campaign`.
    """
    return _assemble(raw, place, Search.of(place, data), "", None, runs=True)


def _place(path: Path) -> Path:
    """The file that is meant by a path."""
    if not path.exists() and not path.is_absolute() and path.parts[:1] == ("datasets",):
        packed = datasets_folder().joinpath(*path.parts[1:])
        path = packed if packed.exists() else path
    if path.is_dir():
        if (path / CAMPAIGN.file).is_file():
            return path / CAMPAIGN.file
        raise CampaignError(
            f"there is no {CAMPAIGN.file} in this folder.", file=str(path), remedy=_remedy_in(path)
        )
    if not path.is_file():
        raise CampaignError(
            "there is no such file or folder.",
            file=str(path),
            remedy=f"Name a folder with {CAMPAIGN.file}, a .toml file, a saved campaign (.h5) or a "
            f"zip archive with a {CAMPAIGN.file}.",
        )
    return path


def _remedy_in(folder: Path) -> str:
    """What to do in a folder without a campaign file: what lies there, or how one is drafted."""
    others = sorted(file.name for file in folder.glob("*.toml"))
    if others:
        return f"It has {', '.join(others[:5])}: name the file itself."
    inside = sorted(file.parent.as_posix() for file in folder.glob(f"*/{CAMPAIGN.file}"))
    if inside:
        more = f" and {len(inside) - 5} more" if len(inside) > 5 else ""
        return f"There is one in {', '.join(inside[:5])}{more}: name that folder."
    return _draft(folder)


def _draft(folder: Path) -> str:
    return f"The command pmmkit new-campaign {quoted(folder)} drafts one from its files."


def _bytes(place: Path) -> bytes:
    try:
        return place.read_bytes()
    except OSError as error:
        raise CampaignError(f"cannot be read: {error.strerror}.", file=place.name) from error


def _text(data: bytes, place: Path) -> str:
    try:
        return data.removeprefix(b"\xef\xbb\xbf").decode("utf-8")
    except UnicodeDecodeError as error:
        if data.startswith(SIGNATURE):
            raise CampaignError(
                "this is an HDF5 file and no campaign file.",
                file=place.name,
                remedy=f"If it is a saved campaign, call it {place.stem}.h5.",
            ) from error
        raise CampaignError(
            f"byte {data[error.start]:#04x} is not UTF-8 text.",
            file=place.name,
            row=data.count(b"\n", 0, error.start) + 1,
            remedy="Save the campaign file as UTF-8.",
        ) from error


def _toml(text: str, place: Path) -> dict[str, Any]:
    try:
        return tomllib.loads(text)
    except (ValueError, RecursionError) as error:
        _refuse_measurements(place, error)
        message = str(error) or "nested too deeply"
        line = re.search(r"at line (\d+)", message)
        row = int(line[1]) if line else None
        written = text.splitlines()[row - 1] if row and row <= len(text.splitlines()) else ""
        raise CampaignError(
            f"this is not valid TOML: {message}.",
            file=place.name,
            row=row,
            remedy=_toml_remedy(written, message),
        ) from error


def _refuse_measurements(place: Path, error: Exception) -> None:
    """Refuse a file of data that stands where the campaign file is asked for."""
    from pmmkit.readers import recognise

    if place.suffix.lower() != ".toml" and recognise(place) is not None:
        raise CampaignError(
            "this is a file of measurements; the campaign file says what it holds.",
            file=place.name,
            remedy=_draft(place.parent),
        ) from error


def _check_end(raw: Mapping[str, Any], place: Path) -> None:
    """Refuse a file that says that it is closed and has lost its end."""
    head = raw.get("campaign")
    if isinstance(head, Mapping) and head.get("closed") is True and "end" not in raw:
        raise CampaignError(
            f"the file is cut off: it says closed = true, and its last line [end] is "
            f"missing ({len(raw.get('runs', []))} runs are left).",
            file=place.name,
            remedy="Take it from its source again; if nothing is missing, write [end] as its "
            "last line.",
        )


def _toml_remedy(line: str, message: str) -> str | None:
    """The commonest slips in a line of TOML."""
    if message.startswith(("Cannot overwrite", "Cannot declare")):
        return "This name stands twice in its table: remove one."
    if re.search(r"[=\[,]\s*[+-]?\.\d", line):
        return "Write a digit before the point: 0.5, not .5."
    if re.search(r"=\s*[+-]?\d+,\d", line):
        return "Write numbers with a decimal point."
    if re.search(r'=\s*"[^"]*\\', line):
        return "In a path write / instead of \\, or put it in single quotes."
    if re.search(r"=\s*[A-Za-z_]", line):
        return "Put text in quotes."
    return None


def _assemble(
    raw: Mapping[str, Any],
    place: Path,
    search: Search,
    digest: str,
    origin: Origin | None,
    runs: bool,
) -> Campaign:
    from pmmkit.base import __version__
    from pmmkit.campaigns.file import particulars, schema
    from pmmkit.campaigns.file.assembly import Assembled

    out = Assembled(place.name)
    for name in raw:
        if name not in schema.TABLES:
            out.report(f"not known{did_you_mean(name, schema.TABLES) or '.'}", f"[{name}]")
    for name in ("campaign", "ship"):
        if name not in raw:
            out.report("this table is missing.", f"[{name}]")
    if runs and not any(raw.get(name) for name in ("runs", "matrix", "tables")):
        out.report("there are no runs: neither [[runs]], [[matrix]] nor [[tables]].")
    campaign, setup, labels = particulars.read_tables(raw, search, out)
    _add_all(raw, setup, out)
    _check_references(setup, out, labels)
    if out.problems:
        raise CampaignError(out.problems, title=f"{place} cannot be used")
    reasons = {
        run.id: next(item.reason for item in run.corrections if item.action == "exclude")
        for run in out.runs
        if any(item.action == "exclude" for item in run.corrections)
    }
    provenance: dict[str, Any] = {
        "pmmkit": __version__,
        "campaign_file": PurePath(place).name,
        "sha256": digest,
        **({} if origin is None else {"url": origin.shown}),
    }
    if out.left_out:
        provenance["left_out"] = dict(out.left_out)
    if out.not_made:
        provenance["not_made"] = list(out.not_made)
    used = [run for run in out.runs if run.id not in reasons]
    return campaign.with_(
        title=campaign.title or folder_name(place, origin),
        runs=tuple(run for run in used if not run.kind_of_test.at_rest),
        check_loads=tuple(run for run in used if run.kind_of_test.at_rest),
        excluded=tuple((run, reasons[run.id]) for run in out.runs if run.id in reasons),
        folder=place.parent,
        provenance=MappingProxyType(provenance),
    )


def _add_all(raw: Mapping[str, Any], setup: Setup, out: Assembled) -> None:
    """Every entry of ``[[runs]]``, ``[[matrix]]`` and ``[[tables]]``."""
    from pmmkit.campaigns.file import schema
    from pmmkit.campaigns.file.assembly import entries_of
    from pmmkit.campaigns.file.rows import add_run, add_table
    from pmmkit.campaigns.file.settings import read_defaults, with_defaults

    defaults = read_defaults(raw.get("defaults", {}), out)
    listed = [
        (_label("runs", index, item), item)
        for index, item in enumerate(_list(raw, "runs", out), start=1)
    ]
    for index, item in enumerate(_list(raw, "matrix", out), start=1):
        label = _label("matrix", index, item)
        matrix = schema.read_entry(schema.MatrixEntry, item, label, out)
        if matrix is not None:
            listed += entries_of(matrix, label, setup, out)
        else:
            out.incomplete = True
    for label, item in listed:
        entry = schema.read_entry(schema.RunEntry, with_defaults(item, defaults), label, out)
        if entry is not None:
            add_run(entry, label, setup, out)
        elif isinstance(item, Mapping) and isinstance(item.get("id"), str):
            out.claim(item["id"], label)
    for index, item in enumerate(_list(raw, "tables", out), start=1):
        label = _label("tables", index, item)
        own = item.get("columns", {}) if isinstance(item, Mapping) else {}
        table = schema.read_entry(
            schema.TableEntry,
            with_defaults(item, defaults, mapped={*setup.columns, *own}, histories=False),
            label,
            out,
        )
        if table is not None:
            add_table(table, label, setup, out)
        else:
            out.incomplete = True


def _list(raw: Mapping[str, Any], name: str, out: Assembled) -> list[Any]:
    listed = raw.get(name, [])
    if isinstance(listed, list):
        return listed
    out.report("must be written in double brackets.", f"[[{name}]]")
    return []


def _label(name: str, index: int, item: Any) -> str:
    shown = item.get("id", item.get("file")) if isinstance(item, Mapping) else None
    key = "id" if isinstance(item, Mapping) and "id" in item else "file"
    return f"[[{name}]] #{index}" + (f" ({key} {shown!r})" if isinstance(shown, str) else "")


def _check_references(setup: Setup, out: Assembled, labels: Mapping[int, str]) -> None:
    """Corrections and ``repeat_of`` must name runs that are there."""
    if out.incomplete:
        return
    for index, item in enumerate(setup.corrections):
        for pattern in item.runs:
            one = type(item)(runs=(pattern,), action=item.action, reason=item.reason)
            if not any(one.applies_to(run_id) for run_id in out.ids):
                guess = did_you_mean(pattern, out.ids) or "."
                out.report(f"no run has the id {pattern!r}{guess}", labels.get(index))
    for name in setup.trial.get("order", {}):
        if name not in out.ids:
            out.report(
                f"no run has the id {name!r}{did_you_mean(name, out.ids) or '.'}",
                "[trial], key 'order'",
            )
    for run in out.runs:
        other = run.settings.repeat_of
        if other is not None and other not in out.ids:
            out.report(
                f"repeat_of names {other!r}, which is not a run"
                f"{did_you_mean(other, out.ids) or '.'}",
                out.ids[run.id],
            )
