"""Several campaigns of one ship: what each is called, and in which the ship sails by itself."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from pmmkit.campaigns.run import Campaign


def by_title(campaigns: Sequence[Campaign]) -> dict[str, Campaign]:
    """Campaigns by their titles, numbered where two have the same.

    Parameters
    ----------
    campaigns : sequence of Campaign
        One without a title goes by its ship.
    """
    found: dict[str, Campaign] = {}
    for number, item in enumerate(campaigns, 1):
        name = item.title or item.ship.name
        found[f"{name} ({number})" if name in found else name] = item
    return found


def sailing(campaigns: Mapping[str, Campaign]) -> str:
    """The first campaign of free-running records; the first of all where there is none.

    Parameters
    ----------
    campaigns : mapping of str to Campaign
        By name, at least one.
    """
    free = (name for name, item in campaigns.items() if item.kind == "free-running")
    return next(free, next(iter(campaigns)))
