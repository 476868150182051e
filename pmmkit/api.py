"""The words a user starts with, where they are more than a name of a room."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Literal

from pmmkit.reduction import reduce_campaign
from pmmkit.structures import Structure
from pmmkit.tables import DerivativeTable

if TYPE_CHECKING:
    from pmmkit.reduction.prepare import CycleChoice
    from pmmkit.runs.run import Campaign


def reduce(
    campaign: Campaign,
    structure: str | Sequence[str] | Structure = "abkowitz3",
    fn: Literal["each", "pooled"] = "each",
    *,
    cycles: CycleChoice = None,
    carriage_speed: bool = False,
) -> DerivativeTable:
    """Derivatives from a campaign of captive tests.

    The short form of `reduction.reduce_campaign`, which also gives what stands behind the table.

    Parameters
    ----------
    campaign : Campaign
        Captive tests, as `open_campaign` gives them.
    structure : str, sequence of str or Structure
        Name of a structure (``abkowitz3``, ``modulus``, ``mmg`` …) or a list of derivatives.
    fn : {"each", "pooled"}
        A set of derivatives per Froude number, or one over all speeds.
    cycles : int or (int, int), optional
        Take only this cycle, or these (the first is 1), of oscillating runs; by default a
        cycle-to-cycle test decides.
    carriage_speed : bool
        Make non-dimensional with the carriage speed instead of the instantaneous one.

    Returns
    -------
    DerivativeTable
        With covariance, 95 % intervals by `interval`, and notes on what the runs do not tell.

    Raises
    ------
    ContradictionError
        If the data contradict themselves or the campaign file.
    CampaignError
        If runs cannot be read.
    """
    return reduce_campaign(
        campaign, structure=structure, fn=fn, cycles=cycles, carriage_speed=carriage_speed
    ).table
