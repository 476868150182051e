"""Files that may have lost their end: campaign files and text files without a last line end."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Final

from pmmkit.base import DataError
from pmmkit.intake.checks.finding import Check, CheckFinding
from pmmkit.readers import Request, reader_for

if TYPE_CHECKING:
    from pmmkit.campaigns import Campaign, Run
    from pmmkit.intake.checks.finding import Summary

_NAME: Final = "whole files"
_SERIES: Final = 5
"""Runs of a kind from which a common length is a rule."""


def examine_ends(campaign: Campaign, summaries: Sequence[Summary]) -> Iterator[CheckFinding]:
    """The end of the campaign file, files that no run names, the end and length of records."""
    yield from _campaign_file(campaign)
    files = {run.id: _text_files(run) for run in campaign.runs}
    yield from _line_ends(files)
    yield from _left_alone(campaign)
    yield from _lengths(summaries)


def _campaign_file(campaign: Campaign) -> Iterator[CheckFinding]:
    name = campaign.provenance.get("campaign_file")
    if campaign.folder is None or name is None:
        return
    end = _end_of(campaign.folder / str(name))
    if end is not None and not end.endswith(b"\n") and end.split(b"\n")[-1].strip() != b"[end]":
        yield CheckFinding(
            check=_NAME,
            severity="warning",
            message=f"The last line of {name} has no line end: the file may be cut off, and the "
            f"last entry or further runs lost.",
            remedy="See whether all runs are there, then end the last line with a line end.",
            numbers={"runs": float(len(campaign.runs))},
        )


def _line_ends(files: Mapping[str, Sequence[Path]]) -> Iterator[CheckFinding]:
    """Text files whose last line has no end, unless none of several has one."""
    ends = {path: _end_of(path) for paths in files.values() for path in paths}
    open_ended = {path for path, end in ends.items() if end and end[-1:] not in (b"\n", b"\r")}
    if not open_ended or (len(ends) > 1 and len(open_ended) == len(ends)):
        return
    runs = tuple(name for name, paths in files.items() if open_ended.intersection(paths))
    names = ", ".join(sorted(path.name for path in open_ended)[:_SERIES])
    yield CheckFinding(
        check=_NAME,
        severity="warning",
        message=f"The last line of {names} has no line end"
        + (", those of the other files have one" if len(ends) > 1 else "")
        + ": the file may be cut off within its last number.",
        runs=runs,
        remedy="Copy it again; if it is complete, end its last line with a line end.",
        numbers={"files": float(len(open_ended))},
    )


def _left_alone(campaign: Campaign) -> Iterator[CheckFinding]:
    """Files beside those of histories that are of the same kind and that no run names."""
    left = (run for run, _ in campaign.excluded)
    every = (*campaign.runs, *left, *campaign.check_loads)
    named = {path.resolve() for run in every for path in _text_files(run)}
    used = {
        path.resolve()
        for run in campaign.runs
        if run.kind == "history"
        for path in _text_files(run)
    }
    if len(used) < 2:
        return
    kinds = {(path.parent, path.suffix) for path in used}
    lost = sorted(
        path.name
        for folder, suffix in kinds
        for path in folder.glob(f"*{suffix}")
        if path.suffix == suffix and path.is_file() and path not in named
    )
    if lost:
        more = f" and {len(lost) - _SERIES} more" if len(lost) > _SERIES else ""
        yield CheckFinding(
            check=_NAME,
            severity="info",
            message=f"No run names {', '.join(lost[:_SERIES])}{more}, beside files that runs name.",
            remedy="If they are runs of this campaign, the campaign file may have lost its end.",
            numbers={"files": float(len(lost))},
        )


def _lengths(summaries: Sequence[Summary]) -> Iterator[CheckFinding]:
    """A record shorter than all the others of its kind, which have one length."""
    series: dict[str, list[tuple[int, str]]] = defaultdict(list)
    for item in summaries:
        if "samples" in item.facts:
            series[item.run.test].append((int(item.facts["samples"]), item.run.id))
    for test, counted in series.items():
        (shortest, run), *others = sorted(counted)
        rest = {count for count, _ in others}
        if len(counted) >= _SERIES and len(rest) == 1 and shortest < min(rest):
            yield CheckFinding(
                check=_NAME,
                severity="warning",
                message=f"The record has {shortest} samples, the {len(others)} others of the test "
                f"{test} have {min(rest)} each: it may be cut off.",
                runs=(run,),
                remedy="Copy its file again, or make sure that the run was ended so soon.",
                numbers={"samples": float(shortest), "others": float(min(rest))},
            )


def _text_files(run: Run) -> tuple[Path, ...]:
    """Files of text columns that a run is read from."""
    try:
        found = run.files()
    except DataError:
        return ()
    return tuple(
        path
        for shown, path in found.items()
        if reader_for(Request(path=path, shown=shown)).name == "csv"
    )


def _end_of(path: Path) -> bytes | None:
    """The last bytes of a file; None where it cannot be read."""
    try:
        with path.open("rb") as stream:
            stream.seek(max(0, path.stat().st_size - 64))
            return stream.read()
    except OSError:
        return None


CHECKS: Final = (
    Check(
        _NAME, "campaign files and records that may be cut off, files without a run", examine_ends
    ),
)
