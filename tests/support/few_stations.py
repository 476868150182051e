"""A hull with fewer stations, for tests that ask for no accuracy of a real ship."""

from __future__ import annotations

from dataclasses import replace

from pmmkit.seakeeping import Hull


def thinned(hull: Hull) -> Hull:
    """Every fourth station of a hull from particulars, which takes a quarter of the time."""
    return replace(hull, stations=hull.stations[::4])
