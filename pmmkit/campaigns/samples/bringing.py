"""Files behind URLs, brought to this machine when they are read."""

from __future__ import annotations

from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from typing import Final

from pmmkit.errors import DataError
from pmmkit.readers import recognise
from pmmkit.readers.base import Request
from pmmkit.remote import Origin, local_copy

AT_ONCE: Final = 8
"""Files that are fetched side by side, as each waits for its store most of the time."""


def at_hand(request: Request, *, proven: bool = True) -> Request:
    """The request with its file on this machine: as it is, or copied from its URL.

    Parameters
    ----------
    request : Request
        The file.
    proven : bool
        As for `local_copy`.

    Raises
    ------
    CampaignError
        If it cannot be fetched, with the run that it is for.
    """
    if request.origin is None:
        return request
    try:
        path = local_copy(request.origin, proven=proven)
    except DataError as error:
        shown = replace(request, withheld=False)
        raise request.error(
            *(shown.problem(item.message, remedy=item.remedy) for item in error.problems)
        ) from error
    withheld = request.withheld and recognise(path) is None
    return replace(request, path=path, origin=None, withheld=withheld)


def bring(requests: Sequence[Request]) -> None:
    """Fetch several files side by side; what cannot be fetched is told when it is read.

    Parameters
    ----------
    requests : sequence of Request
        The files; those of this machine are left alone.
    """
    afar = {request.origin for request in requests if request.origin is not None}
    if not afar:
        return

    def fetch(origin: Origin) -> None:
        try:
            local_copy(origin)
        except DataError:
            return

    with ThreadPoolExecutor(min(AT_ONCE, len(afar))) as pool:
        list(pool.map(fetch, afar))
