"""The segments of a TDMS file, their sizes checked against the file.

Layout after National Instruments, "TDMS File Format Internal Structure" (2023): each segment begins
with 28 bytes that tell where the next one begins and where its raw data begin.
"""

from __future__ import annotations

import struct
from dataclasses import dataclass
from pathlib import Path
from typing import Final

from pmmkit.readers.base import Request

TAG: Final = b"TDSm"
LEAD_IN: Final = 28
_META, _RAW, _BIG_ENDIAN, _DAQMX = 1 << 1, 1 << 3, 1 << 6, 1 << 7
_KNOWN: Final = 0b1110_1110
_UNFINISHED: Final = 0xFFFFFFFFFFFFFFFF
_VERSIONS: Final = (4712, 4713)


@dataclass(frozen=True, kw_only=True)
class Segments:
    """What the beginnings of all segments tell.

    Parameters
    ----------
    unfinished : bool
        Whether the last one was never closed: the program that wrote it stopped.
    daqmx : bool
        Whether there are raw data of DAQmx.
    """

    unfinished: bool
    daqmx: bool


def walk(path: Path, request: Request) -> Segments:
    """Go through the beginnings of all segments.

    Raises
    ------
    CampaignError
        If one is damaged, or the file ends before or behind where it says.
    """
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
                return Segments(unfinished=True, daqmx=daqmx)
            if data > length:
                raise _damaged(request, f"the segment at byte {place} is damaged")
            last, place = place, place + LEAD_IN + length
    if place != size:
        raise _damaged(
            request,
            f"the segment at byte {last} should end at byte {place}, the file at byte {size}: "
            f"{place - size} bytes are missing",
        )
    return Segments(unfinished=False, daqmx=daqmx)


def _damaged(request: Request, what: str) -> Exception:
    return request.error(
        request.problem(
            f"{what}: the file is damaged or cut short.", remedy="Copy it again from the logger."
        )
    )
