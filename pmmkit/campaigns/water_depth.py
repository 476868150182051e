"""Depth of the water as a dimension of a campaign: its runs at each."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace

from pmmkit.base import CampaignError
from pmmkit.campaigns.run import Campaign, Run
from pmmkit.campaigns.setting import LENGTH


def depths(campaign: Campaign) -> tuple[float | None, ...]:
    """Depths of the water of a campaign's runs [m], the deepest first; None where none is stated.

    Depths within a millimetre are one.

    Examples
    --------
    >>> from pmmkit.campaigns.run import Run
    >>> from pmmkit.campaigns.settings import Settings
    >>> from pmmkit.conventions import Ship, Water
    >>> ship = Ship(name="m", L=4.0, B=1.0, d=.25, volume=.5, mass=500., Izz=500.)
    >>> runs = tuple(Run(id=str(h), test="static_drift", kind="means", loader=None,
    ...                  settings=Settings(speed=1.0, depth=h)) for h in (.3, .5, .4998, None))
    >>> depths(Campaign(title="", ship=ship, water=Water(depth=1.0), runs=runs))
    (1.0, 0.5, 0.3)
    """
    found: list[float | None] = []
    stated = sorted(
        (campaign.depth_of(run) for run in campaign.runs),
        key=lambda depth: float("-inf") if depth is None else -depth,
    )
    for depth in stated:
        if not found or not _same(depth, found[-1]):
            found.append(depth)
    return tuple(found)


def by_depth(campaign: Campaign) -> tuple[Campaign, ...]:
    """A campaign for each depth of the water, the deepest first: its runs, in water of that depth.

    Parameters
    ----------
    campaign : Campaign
        Runs at one depth or several.

    Returns
    -------
    tuple of Campaign
        Each with `water.depth`; the campaign as it is where it has no runs.
    """
    found = depths(campaign)

    def here(run: Run, depth: float | None) -> bool:
        return next((x for x in found if _same(campaign.depth_of(run), x)), ()) == depth

    return tuple(
        campaign.with_(
            runs=tuple(run for run in campaign.runs if here(run, depth)),
            excluded=tuple((run, why) for run, why in campaign.excluded if here(run, depth)),
            water=replace(campaign.water, depth=depth),
        )
        for depth in found
    ) or (campaign,)


def one_depth(campaign: Campaign) -> Campaign:
    """The campaign, its water as deep as it was for all of its runs.

    Raises
    ------
    CampaignError
        If they were made at several depths.
    """
    found = by_depth(campaign)
    if len(found) > 1:
        raise CampaignError(
            f"The runs of {campaign.title or campaign.ship.name!r} were made in water "
            f"of {in_words(depths(campaign))}; derivatives and forces hold at one depth.",
            remedy="`pmmkit reduce` reduces each depth by itself, in Python reduce_depths(). "
            "Elsewhere take the runs of one depth: a campaign file for each, or "
            "pmmkit.campaigns.water_depth.by_depth(campaign).",
        )
    return found[0]


def in_words(found: Iterable[float | None]) -> str:
    """Depths as a person lists them.

    Examples
    --------
    >>> in_words((0.72, 0.54, None))
    '0.72 m, 0.54 m and no stated depth'
    """
    *most, last = ["no stated depth" if depth is None else f"{depth:.4g} m" for depth in found]
    return f"{', '.join(most)} and {last}" if most else last


def _same(one: float | None, other: float | None) -> bool:
    if one is None or other is None:
        return one is other
    return abs(one - other) <= LENGTH[0]
