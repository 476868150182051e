"""What the runs of a campaign cannot tell of their own errors, and what would."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING

from pmmkit.intake.checks.inertia import unasked_inertia
from pmmkit.presentation import listed

if TYPE_CHECKING:
    from pmmkit.campaigns import Campaign
    from pmmkit.intake.checks.finding import Summary


def untold(campaign: Campaign, summaries: Sequence[Summary]) -> tuple[str, ...]:
    """Properties of the data that no comparison of these runs checks, each with what would.

    Parameters
    ----------
    campaign : Campaign
        Captive tests; of others nothing is said.
    summaries : sequence of Summary
        Their summaries.

    Returns
    -------
    tuple of str
        Sentences for the notes of a table.
    """
    if campaign.kind != "captive" or not summaries:
        return ()
    return tuple(_sentences(campaign, summaries))


def _sentences(campaign: Campaign, summaries: Sequence[Summary]) -> Iterator[str]:
    channels = [name for name in ("X", "Y", "N") if any(name in item.means for item in summaries)]
    if channels:
        yield (
            f"Not checked by these runs: a gain or a unit that is off by less than about half in "
            f"all runs alike (gauges of {', '.join(channels)}); the length L, density and carriage "
            f"speed that make the derivatives non-dimensional. Weights on the balance, a tape and "
            f"an independent speed log check them."
        )
    yaws = [item for item in summaries if item.run.kind_of_test.yaws]
    if yaws:
        weighed = any(item.run.forces == "balance" for item in summaries)
        what = "balance_Izz (Izz)" if weighed else "the moment of inertia Izz that was taken off"
        yield (
            f"Not checked by these runs: {what}, which goes into Nrdot one to one, and the centre "
            f"of gravity. Swinging the dry model on the balance checks them."
        )
    unasked = unasked_inertia(campaign, summaries)
    if unasked:
        yield (
            f"Not told by these runs: whether the model's inertia is inside {listed(unasked)}, as "
            f"the campaign file says or not: nothing moves alone there, or the added mass is not "
            f"known well enough. A run of the dry model on the balance tells it."
        )
    swung = [item for item in summaries if item.run.dynamic]
    recorded = any("v_mean" in item.facts or "r_mean" in item.facts for item in swung)
    statics = any(item.run.test == "static_drift" for item in summaries)
    if swung and not recorded and not statics:
        yield (
            "Not checked by these runs: the amplitude of the oscillations, as nothing but the "
            "settings tells the motion. Recording it, or static drift beside sway, checks it."
        )
    if len({item.run.settings.omega for item in swung}) == 1:
        yield (
            "Not told apart by these runs: a lag in seconds, a filter and a phase, as all "
            "oscillate at one frequency. A run at another frequency tells them apart."
        )
