"""From a reduction to the test report, chapter by chapter in the order of a standard."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from types import MappingProxyType
from typing import Final

from pmmkit.base import UnknownNameError, did_you_mean
from pmmkit.campaigns import Campaign
from pmmkit.conventions import cite
from pmmkit.reduction import Reduction
from pmmkit.views.report.captive import appendices, campaign_chapters, result_chapters
from pmmkit.views.report.captive.document import Document, Item
from pmmkit.views.report.captive.repeatability import repeatability
from pmmkit.views.report.captive.stated import of_report


@dataclass(frozen=True, kw_only=True)
class Standard:
    """By what a report is ordered.

    `sources`: keys of the bibliography, the first the one whose order it has. `basis`: what the
    report says of it.
    """

    sources: tuple[str, ...]
    basis: tuple[str, ...]


STANDARDS: Final[Mapping[str, Standard]] = MappingProxyType(
    {
        "ittc": Standard(
            sources=("ittc_7.5-02-06-02", "ittc_7.5-02-06-04"),
            basis=(
                "This report is structured after what the ITTC's recommended procedure "
                "7.5-02-06-02, captive model test, asks a report to document (contents of the "
                "revision of 2017), with uncertainty as 7.5-02-06-04 treats it. It does not claim "
                "to comply with them: who signs it reads the texts in force and compares.",
                "What the campaign file does not say is printed as not supplied, and listed at "
                "the end.",
            ),
        )
    }
)
"""What a report can be structured after, by name."""
COVER: Final = (
    "number",
    "revision",
    "issued",
    "customer",
    "laboratory",
    "authors",
    "approved_by",
    "tested",
)
"""Keys of ``[report]`` that stand on the cover."""


def captive_document(reduction: Reduction, *, standard: str = "ittc") -> Document:
    """The test report of captive tests.

    Parameters
    ----------
    reduction : Reduction
        As `reduce_campaign` gives it.
    standard : str
        What it is structured after, of `STANDARDS`.

    Returns
    -------
    Document
        Everything that is printed, as data; `write_report` writes it.

    Raises
    ------
    UnknownNameError
        If there is no such standard.
    """
    if standard not in STANDARDS:
        raise UnknownNameError(
            f"There is no standard {standard!r}{did_you_mean(standard, STANDARDS) or '.'} "
            f"There are {', '.join(STANDARDS)}."
        )
    after, campaign = STANDARDS[standard], reduction.campaign
    made: Sequence[Item] = [
        Item(what="Analysed with", value=cite("pmmkit")),
        Item(what="Structured after", value=cite(after.sources[0])),
    ]
    return Document(
        title=campaign.title or campaign.ship.name,
        subtitle="Report of captive model tests",
        items=[*(_dated(item, campaign) for item in of_report(campaign, *COVER)), *made],
        basis=after.basis,
        chapters=[
            campaign_chapters.technique(reduction),
            campaign_chapters.ship_model(reduction),
            campaign_chapters.facility(reduction),
            campaign_chapters.mount(reduction),
            campaign_chapters.measured(reduction),
            campaign_chapters.programme(reduction),
            campaign_chapters.procedure(reduction),
            repeatability(reduction),
            result_chapters.analysis(reduction),
            result_chapters.derivatives(reduction),
            result_chapters.uncertainty(reduction),
            result_chapters.checks(reduction),
            result_chapters.use(reduction),
            appendices.runs(reduction),
            appendices.origin(reduction, after.sources),
        ],
    )


def _dated(item: Item, campaign: Campaign) -> Item:
    """When the tests were made, by the starts of the runs where the report does not say it."""
    days = sorted(run.started[:10] for run in campaign.runs if run.started)
    if item.key != "tested" or item.value is not None or not days:
        return item
    return replace(item, value=days[0] if days[0] == days[-1] else f"{days[0]} to {days[-1]}")
