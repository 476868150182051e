"""The order of a day: which run came when."""

from __future__ import annotations

from collections.abc import Sequence
from datetime import UTC, datetime

from pmmkit.campaigns.run import Run


def places_in_day(runs: Sequence[Run]) -> tuple[float, ...]:
    """Where each run stands between the first (0) and the last (1) of a campaign.

    By the instants at which they started where all runs state them; else by their order.

    Parameters
    ----------
    runs : sequence of Run
        In the order of the campaign file.

    Examples
    --------
    >>> from pmmkit.campaigns.settings import Settings
    >>> runs = [Run(id=name, test="resistance", kind="means", settings=Settings(speed=1.0),
    ...             loader=None, started=f"2026-05-04T{hour}:00:00")
    ...         for name, hour in (("a", "12"), ("b", "09"), ("c", "10"))]
    >>> [round(place, 3) for place in places_in_day(runs)]
    [1.0, 0.0, 0.333]
    >>> places_in_day([run.with_(started="") for run in runs])
    (0.0, 0.5, 1.0)
    """
    if timed(runs):
        instants = [seconds_of(run.started) for run in runs]
        span = max(instants) - min(instants)
        if span > 0:
            return tuple((instant - min(instants)) / span for instant in instants)
    last = max(len(runs) - 1, 1)
    return tuple(number / last for number in range(len(runs)))


def timed(runs: Sequence[Run]) -> bool:
    """Whether all runs state when they started."""
    return bool(runs) and all(run.started for run in runs)


def seconds_of(started: str) -> float:
    """When a run started, in seconds of one clock.

    Parameters
    ----------
    started : str
        ISO 8601; without a zone it counts as UTC.

    Examples
    --------
    >>> seconds_of("2026-05-04T09:15:00") - seconds_of("2026-05-04T09:00:00")
    900.0
    """
    instant = datetime.fromisoformat(started)
    return (instant if instant.tzinfo else instant.replace(tzinfo=UTC)).timestamp()
