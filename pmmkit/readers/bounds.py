"""How far a packed file may expand."""

from __future__ import annotations

import zlib
from typing import Final

from pmmkit.base import CampaignError
from pmmkit.readers.base import Request

SMALL: Final = 200_000_000
"""Bytes that any file may expand to."""
RATIO: Final = 200
"""A file may expand to this many times its size."""
_PIECE: Final = 1 << 16


class Damaged(ValueError):
    """A file is not as its own sizes say; never leaves the reader."""


def limit_of(size: int) -> int:
    """Bytes that a file of that size may expand to.

    Examples
    --------
    >>> limit_of(1000), limit_of(10_000_000)
    (200000000, 2000000000)
    """
    return max(SMALL, RATIO * size)


def too_large(request: Request, declared: int, size: int, what: str) -> CampaignError:
    """The error of a file that would expand too far."""
    return request.error(
        f"{what} would take {declared:,} bytes, the file has {size:,}: damaged, or made to "
        f"exhaust the memory. At most {limit_of(size):,} are read.",
        remedy="If it is right, save it unpacked or as text.",
    )


def inflated_size(packed: bytes | memoryview, most: int, *, raw: bool = False) -> int:
    """Bytes that a deflated stream expands to, counted without keeping them.

    Examples
    --------
    >>> inflated_size(zlib.compress(bytes(1000)), 10_000)
    1000
    """
    stream = zlib.decompressobj(-15 if raw else 15)
    view = memoryview(packed)
    count = 0
    for place in range(0, len(view), _PIECE):
        rest: bytes | memoryview = view[place : place + _PIECE]
        while rest and not stream.eof and count <= most:
            count += len(stream.decompress(rest, _PIECE))
            rest = stream.unconsumed_tail
    while not stream.eof and count <= most and (more := stream.decompress(b"", _PIECE)):
        count += len(more)
    return count
