"""LabVIEW files (.tdms), read by npTDMS.

Channels are columns ``group/channel``, or the channel alone where its name is unique. The time is
counted from ``wf_increment``, which LabVIEW writes beside waveforms.
"""

from __future__ import annotations

import functools
import io
import logging
import math
import struct
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

import numpy as np

from pmmkit.base import CampaignError, PmmkitError
from pmmkit.conventions import split_unit
from pmmkit.numerics import Array
from pmmkit.readers.base import Cells, Choose, Columns, Request, first_line
from pmmkit.readers.bounds import limit_of, too_large
from pmmkit.readers.vectors import (
    Vector,
    checked,
    left_out_problem,
    same_length,
    small_table,
    with_unit,
)

# The segments of a TDMS file, their sizes checked against the file.
#
# Layout after National Instruments, "TDMS File Format Internal Structure" (2023): each segment
# begins with 28 bytes that tell where the next one begins and where its raw data begin.


TAG: Final = b"TDSm"
LEAD_IN: Final = 28
_META, _RAW, _BIG_ENDIAN, _DAQMX = 1 << 1, 1 << 3, 1 << 6, 1 << 7
_KNOWN: Final = 0b1110_1110
_UNFINISHED: Final = 0xFFFFFFFFFFFFFFFF
_VERSIONS: Final = (4712, 4713)


def walk(path: Path, request: Request) -> tuple[bool, bool]:
    """Whether the last segment was never closed, and whether there are raw data of DAQmx."""
    size = path.stat().st_size
    place, last, daqmx = 0, 0, False
    with path.open("rb") as stream:
        while place < size:
            stream.seek(place)
            lead = stream.read(LEAD_IN)
            if len(lead) < LEAD_IN or lead[:4] != TAG:
                raise _damaged(request, f"there is no segment at byte {place}, where one should be")
            mask = struct.unpack_from("<I", lead, 4)[0]
            order = ">" if mask & _BIG_ENDIAN else "<"
            version, length, data = struct.unpack_from(f"{order}IQQ", lead, 8)
            if version not in _VERSIONS or mask & ~_KNOWN:
                raise _damaged(request, f"the segment at byte {place} is damaged")
            daqmx = daqmx or bool(mask & _DAQMX)
            if length == _UNFINISHED:
                if place + LEAD_IN + data > size:
                    raise _damaged(request, f"the segment at byte {place} lacks its description")
                return True, daqmx
            if data > length:
                raise _damaged(request, f"the segment at byte {place} is damaged")
            last, place = place, place + LEAD_IN + length
    if place != size:
        raise _damaged(
            request,
            f"the segment at byte {last} should end at byte {place}, the file at byte {size}: "
            f"{place - size} bytes are missing",
        )
    return False, daqmx


def _damaged(request: Request, what: str) -> Exception:
    return request.error(
        f"{what}: the file is damaged or cut short.", remedy="Copy it again from the logger."
    )


_TIME: Final = "t [s]"
_SCALES: Final = frozenset(
    {
        "Polynomial",
        "Linear",
        "RTD",
        "Strain",
        "Table",
        "Thermistor",
        "Thermocouple",
        "Add",
        "Subtract",
        "AdvancedAPI",
    }
)
"""Scalings that npTDMS applies; any other it passes over in silence."""
_MOST_SCALES: Final = 100


def names(request: Request) -> tuple[str, ...]:
    """Headers of the columns."""
    with _contents(request) as contents:
        return contents.headers(request)


def columns(request: Request, choose: Choose) -> Columns:
    """Some channels as numbers, scaled as the file says."""
    with _contents(request) as contents:
        headers = contents.headers(request)
        try:
            positions = tuple(choose(headers, len(headers)))
        except CampaignError as error:
            raise request.error(
                *error.problems, *left_out_problem(contents.left_out, request)
            ) from error
        used = {place: contents.channels[place] for place in positions if headers[place] != _TIME}
        count, cut = _common_length(used, contents, headers, request)
        values: dict[int, Array] = {place: _numbers(used[place], request)[:count] for place in used}
        notes = [*cut, *_time_notes(used, headers)]
        timed = [place for place in positions if place not in used]
        if timed:
            step, start = _sampling(used, headers, request)
            values |= {place: start + step * np.arange(count, dtype=float) for place in timed}
            notes.append(f"t counted from wf_increment = {step:.10g} s, from {start:g} s")
        if request.options.sample_rate is not None:
            _check_rate(used, headers, request.options.sample_rate, request)
    kept, dropped = checked(
        [values[place] for place in positions], [headers[place] for place in positions], request
    )
    return Columns(
        headers=headers, positions=positions, values=kept, dropped=dropped, notes=tuple(notes)
    )


def cells(request: Request) -> Cells:
    """Channels of the main length as a table, those of texts among them."""
    with _contents(request) as contents:
        titles = _titles([channel.name for channel in contents.every], contents.every)
        vectors = [
            Vector(
                name=title,
                length=len(channel),
                read=functools.partial(_numbers, channel, request),
                texts=functools.partial(_texts, channel) if channel.dtype.kind == "O" else None,
            )
            for title, channel in zip(titles, contents.every, strict=True)
        ]
        return small_table(vectors, contents.left_out, request)


@dataclass(frozen=True, kw_only=True)
class _Contents:
    """What an open file holds.

    `channels` are those of numbers, `every` those of texts too; `short` are values that the last
    segment lacks, by the path of a channel.
    """

    channels: Sequence[Any]
    every: Sequence[Any]
    left_out: Sequence[str]
    short: Mapping[str, int]

    def headers(self, request: Request) -> tuple[str, ...]:
        """Headers of the channels, and of the time where their sampling is stated."""
        titles = _titles([channel.name for channel in self.channels], self.channels)
        own = any(split_unit(title)[0] == "t" for title in titles)
        stated = any(_increment(channel) for channel in self.channels)
        counted = stated and not own and request.options.sample_rate is None
        return (*titles, _TIME) if counted else titles


@contextmanager
def _quiet() -> Iterator[None]:
    """What the library logs of damaged files is told by our own errors."""
    loggers = [
        logging.getLogger(name)
        for name in sorted(logging.root.manager.loggerDict)
        if name.partition(".")[0] == "nptdms"
    ]
    before = [logger.disabled for logger in loggers]
    for logger in loggers:
        logger.disabled = True
    try:
        yield
    finally:
        for logger, told in zip(loggers, before, strict=True):
            logger.disabled = told


@contextmanager
def _contents(request: Request) -> Iterator[_Contents]:
    """The channels of a file; every fault of the library becomes an error of ours."""
    import nptdms

    try:
        unfinished, daqmx = walk(request.path, request)
        if daqmx:
            raise request.error(
                "there are raw data of DAQmx, which are not read.",
                remedy="Let the logger write scaled waveforms.",
            )
        stream = io.BytesIO(request.path.read_bytes())
        with _quiet(), nptdms.TdmsFile.open(stream) as file:
            yield _looked_over(file, unfinished, request)
    except PmmkitError:
        raise
    except Exception as error:
        raise request.error(
            f"cannot be read as TDMS: damaged or cut short ({first_line(error)}).",
            remedy="Copy it again from the logger.",
        ) from error


def _looked_over(file: Any, unfinished: bool, request: Request) -> _Contents:
    size = request.path.stat().st_size
    for segment in file._reader._segments[: -1 if unfinished else None]:
        if segment.final_chunk_lengths_override is not None:
            raise request.error(
                f"the segment at byte {segment.position} does not hold what it declares: the "
                "file is damaged.",
                remedy="Copy it again from the logger.",
            )
    statuses = file.file_status.channel_statuses or {}
    groups = [item for item in file.groups() if request.options.group in (None, item.name)]
    if not groups:
        there = [group.name for group in file.groups()]
        if not there:
            raise request.error("there are no groups of channels.")
        raise request.absent("group", request.options.group or "", there)
    found = [channel for group in groups for channel in group.channels()]
    for channel in found:
        _check_scales(channel, file, request)
        status = statuses.get(channel.path)
        expected = len(channel) if status is None else max(len(channel), status.expected_length)
        if expected * max(1, channel.dtype.itemsize) > limit_of(size):
            raise too_large(request, expected * channel.dtype.itemsize, size, channel.path)
    every = [item for item in found if len(item) > 1 and item.dtype.kind in "fiubMO"]
    return _Contents(
        channels=[channel for channel in every if channel.dtype.kind != "O"],
        every=every,
        left_out=[
            f"{channel.group_name}/{channel.name} "
            f"({'texts' if channel.dtype.kind == 'O' else f'{len(channel)} values'})"
            for channel in found
            if channel not in every or channel.dtype.kind == "O"
        ],
        short={
            path: status.expected_length - status.read_length for path, status in statuses.items()
        },
    )


def _check_scales(channel: Any, file: Any, request: Request) -> None:
    """Refuse scalings that npTDMS does not know, and more of them than there can be."""
    group = file[channel.group_name].properties
    for properties in (channel.properties, group, file.properties):
        scales = [
            str(value)
            for key, value in properties.items()
            if key.startswith("NI_Scale[") and key.endswith("]_Scale_Type")
        ]
        count = properties.get("NI_Number_Of_Scales", len(scales))
        done = properties.get("NI_Scaling_Status") == "scaled"
        unknown = sorted(set(scales) - _SCALES)
        if (unknown and not done) or not 0 <= float(count) <= _MOST_SCALES:
            what = f"a scaling {', '.join(unknown)}" if unknown else f"{count} scalings"
            raise request.error(
                f"channel {channel.name} has {what}, which cannot be applied.",
                remedy="Let the logger write scaled values.",
            )


def _titles(names: Sequence[str], channels: Sequence[Any]) -> tuple[str, ...]:
    counts = Counter(names)
    return tuple(
        with_unit(
            name if counts[name] == 1 else f"{channel.group_name}/{name}",
            "s" if channel.dtype.kind == "M" else _text(channel.properties.get("unit_string")),
        )
        for name, channel in zip(names, channels, strict=True)
    )


def _text(value: Any) -> str | None:
    return value if isinstance(value, str) else None


def _texts(channel: Any) -> tuple[str, ...]:
    return tuple(map(str, channel[:]))


def _numbers(channel: Any, request: Request) -> Array:
    """Values of a channel; times as seconds from the first."""
    values = channel[:]
    if len(values) != len(channel):
        raise request.error(
            f"channel {channel.name} should have {len(channel)} values; {len(values)} are there."
        )
    if values.dtype.kind == "M":
        return np.asarray((values - values[0]) / np.timedelta64(1, "s"), dtype=np.float64)
    return np.asarray(values, dtype=np.float64)


def _common_length(
    used: Mapping[int, Any], contents: _Contents, headers: Sequence[str], request: Request
) -> tuple[int, list[str]]:
    """Values that all channels have, and the note of those cut at a segment never finished."""
    lengths = {place: len(channel) for place, channel in used.items()}
    whole = {
        headers[place]: lengths[place] + contents.short.get(channel.path, 0)
        for place, channel in used.items()
    }
    same_length(whole, request)
    count = min(lengths.values(), default=0)
    lacking = max(whole.values(), default=0) - count
    if not contents.short:
        return count, []
    return count, [
        "the last segment was never finished (the logger stopped): read to its last whole sample, "
        f"{lacking} less than it was laid out for"
    ]


def _increment(channel: Any) -> float | None:
    """Seconds between the samples of a waveform, None where they are not stated."""
    step = channel.properties.get("wf_increment")
    unit = channel.properties.get("wf_xunit_string", "s") or "s"
    if isinstance(step, (int, float)) and math.isfinite(step) and step > 0 and unit == "s":
        return float(step)
    return None


def _sampling(
    used: Mapping[int, Any], headers: Sequence[str], request: Request
) -> tuple[float, float]:
    """Seconds between samples and of the first one, the same for all channels that are used."""
    stated = {
        headers[place]: (step, _offset(channel))
        for place, channel in used.items()
        if (step := _increment(channel)) is not None
    }
    if not stated:
        raise request.error(
            "none of the channels that are used states its sampling (wf_increment).",
            remedy="State it under [source], e.g. sample_rate = 200.0 [Hz].",
        )
    if len(set(stated.values())) > 1:
        listed = ", ".join(
            f"{title} every {step:g} s from {start:g} s" for title, (step, start) in stated.items()
        )
        raise request.error(
            f"channels are sampled differently: {listed}.",
            remedy='Use channels of one task, or one group: group = "..." in [source].',
        )
    return next(iter(stated.values()))


def _offset(channel: Any) -> float:
    start = channel.properties.get("wf_start_offset", 0.0)
    return float(start) if isinstance(start, (int, float)) and math.isfinite(start) else 0.0


def _time_notes(used: Mapping[int, Any], headers: Sequence[str]) -> list[str]:
    """What is taken for granted about times."""
    notes = [
        f"{headers[place]}: times as seconds from the first"
        for place, channel in used.items()
        if channel.dtype.kind == "M"
    ]
    waves = [channel for channel in used.values() if _increment(channel) is not None]
    if any("wf_start_offset" not in channel.properties for channel in waves):
        notes.append("wf_start_offset is not stated: taken as 0")
    starts = [
        channel.properties["wf_start_time"]
        for channel in waves
        if isinstance(channel.properties.get("wf_start_time"), np.datetime64)
    ]
    if starts and (spread := (max(starts) - min(starts)) / np.timedelta64(1, "s")) > 0:
        notes.append(f"wf_start_time of the channels differ by {spread:g} s: taken as the same")
    return notes


def _check_rate(
    used: Mapping[int, Any], headers: Sequence[str], rate: float, request: Request
) -> None:
    """Refuse a stated sample rate that is not what the file says."""
    for place, channel in used.items():
        step = _increment(channel)
        if step is not None and abs(step * rate - 1.0) > 1e-4:
            raise request.error(
                f"sample_rate = {rate:g} Hz is stated, wf_increment of the file says "
                f"{1.0 / step:g} Hz.",
                column=headers[place],
                remedy="Leave sample_rate out, or correct it.",
            )
