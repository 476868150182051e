"""Checks: data that contradict themselves are refused before anything is fitted."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from concurrent.futures import Executor
from dataclasses import replace
from functools import partial
from typing import Final

from pmmkit.base import CampaignError, DataError, Problem, Registry, Workers, each, opened
from pmmkit.campaigns import Campaign, Run
from pmmkit.effects import CATALOGUE
from pmmkit.intake.checks import gauges, late, particulars, record
from pmmkit.intake.checks.finding import Check, CheckFinding, Summary, accepted, refuse
from pmmkit.intake.checks.reading import KnownHistory, summarise
from pmmkit.numerics import one_thread

__all__ = [
    "CHECKS",
    "Check",
    "CheckFinding",
    "KnownHistory",
    "Summary",
    "examine",
    "refuse",
    "summarise",
]

CHECKS: Final = Registry(
    Check,
    what="check",
    listed="pmmkit.intake.checks:CHECKS",
    first=(
        *("inertia", "signs", "reference", "scales", "copies", "motion", "carriage", "stated"),
        *("clock", "gauges", "late", "agreement.examine", "record", "particulars", "frequency"),
        *("static", "rest", "positions", "free_running", "density", "whole_files"),
        "reach",
    ),
)
"""All checks by name, each with a line on what it looks for, in the order of their findings; those
of a new file come last."""
RECORDS: Final[tuple[Check, ...]] = (*gauges.CHECKS, *late.CHECKS, *record.SATURATION)
"""Checks of single channels of single records; what they find at fault the others do not see."""


def examine(
    campaign: Campaign, summaries: Sequence[Summary] | None = None, *, executor: Workers = None
) -> tuple[CheckFinding, ...]:
    """Every check on a campaign, all at once.

    Parameters
    ----------
    campaign : Campaign
        The runs, as the campaign file describes them. Each is read once; only a summary of a few
        kilobytes is kept, so that thousands of runs fit in little memory.
    summaries : sequence of Summary, optional
        Summaries already made by `summarise`, one for each run; nothing is read then.
    executor : int, str or concurrent.futures.Executor, optional
        Who reads the runs, as for `reduce_campaign`; by default this process alone.

    Returns
    -------
    tuple of CheckFinding
        Errors first, then warnings, then what is worth knowing, among it what the campaign file
        accepts with its reason. Give it to `refuse` to stop on errors.

    Raises
    ------
    DataError
        If runs cannot be read, with the problems of all of them, or if the campaign file accepts
        what no check says.

    Examples
    --------
    >>> from pmmkit.conventions import Ship, Water
    >>> hull = Ship(name="hull", L=5.0, B=0.7, d=0.25, volume=0.5, mass=5.0, Izz=800.0)
    >>> for finding in examine(Campaign(title="", ship=hull, water=Water(rho=1000.0), runs=())):
    ...     print(finding.severity, finding.check, finding.message[:48])
    error particulars The mass 5.000 kg is 0.0100 times the displaced
    info particulars Not examined until the particulars are right: in
    """
    _known_checks(campaign)
    if summaries is None:
        summaries = _read_all(campaign, executor)
    return tuple(sorted(_by_depth(campaign, summaries), key=lambda item: item.rank))


def _by_depth(campaign: Campaign, summaries: Sequence[Summary]) -> Iterator[CheckFinding]:
    """What the checks find at each depth; what all depths say alike is said once."""
    parts = campaign.by_depth()
    said: set[str] = set()
    for part in parts:
        ids = {run.id for run in part.runs}
        own = _examined(part, [item for item in summaries if item.run.id in ids])
        for found in own:
            if len(parts) == 1:
                yield found
            elif ids.issuperset(found.runs) and found.runs:
                depth = part.depth_in_words
                yield replace(found, message=f"In water of {depth}: {found.message}")
            elif found.message not in said:
                said.add(found.message)
                yield found


def _examined(campaign: Campaign, summaries: Sequence[Summary]) -> list[CheckFinding]:
    """Every check on runs at one depth."""
    ship = [
        accepted(campaign, x)
        for check in particulars.CHECKS
        for x in check.examine(campaign, summaries)
    ]
    consistent = not any(x.check == "particulars" and x.severity == "error" for x in ship)
    gauges_first = [x for check in RECORDS for x in check.examine(campaign, summaries)]
    sound = without_channels(summaries, gauges_first)
    others = [check for check in CHECKS.values() if check not in (*RECORDS, *particulars.CHECKS)]
    made = [check for check in others if consistent or not check.by_particulars]
    rest = [x for check in made for x in check.examine(campaign, sound)]
    found = [accepted(campaign, x) for x in settled([*gauges_first, *rest])]
    return [*ship, *found, *_not_made([c for c in others if c not in made])]


def _not_made(checks: Sequence[Check]) -> list[CheckFinding]:
    """What is not examined while the particulars contradict themselves."""
    if not checks:
        return []
    names = ", ".join(check.name for check in checks)
    return [
        CheckFinding(
            check="particulars",
            severity="info",
            message=f"Not examined until the particulars are right: {names}.",
        )
    ]


def _known_checks(campaign: Campaign) -> None:
    """Raise where the campaign file accepts a check that there is not."""
    asked = {
        str(item.values.get("check"))
        for run in campaign.runs
        for item in run.corrections
        if item.action == "accept"
    }
    wrong = sorted(asked - set(CHECKS))
    if wrong:
        raise CampaignError(
            f"A correction accepts the check {wrong[0]!r}, which there is not. The checks are "
            f"{', '.join(CHECKS)}."
        )


def without_channels(
    summaries: Sequence[Summary], findings: Sequence[CheckFinding]
) -> list[Summary]:
    """Summaries without the channels that are at fault in a run, errors and warnings alike."""
    blind: dict[str, set[str]] = {}
    for finding in findings:
        for run in finding.runs:
            blind.setdefault(run, set()).update(finding.channels)
    return [
        item.without(blind[item.run.id]) if blind.get(item.run.id) else item for item in summaries
    ]


def settled(findings: Sequence[CheckFinding]) -> list[CheckFinding]:
    """Findings without those that another cause explains and that would advise the wrong cure.

    Doubts about the moment reference go where any other cause is named; what is said of inertia
    goes where all runs have one slip.
    """
    causes = {item.cause for item in findings if item.cause}
    slips = {x.cause for x in findings if x.severity == "error" and x.cause and len(x.runs) > 1}
    known = CATALOGUE
    own = {check for cause in causes if cause in known for check in known[cause].own_checks}
    gone = set()
    if causes and "moment reference" not in own:
        gone.add(("moment reference", "warning"))
    if slips and not own & {"moment reference", "inertia"}:
        gone |= {("moment reference", "warning"), ("inertia", "error")}
    return [x for x in findings if (x.check, x.severity) not in gone]


def _read_all(campaign: Campaign, executor: Workers) -> list[Summary]:
    work = partial(summarise, campaign=campaign.with_(runs=(), excluded=()))

    def here(run: Run) -> Summary | DataError:
        try:
            return work(run)
        except DataError as error:
            return error

    names = [f"run {run.id}" for run in campaign.runs]
    if not isinstance(executor, (str, Executor)):
        Run.fetch(campaign.runs)
    with opened(executor) as ready, one_thread():
        found = dict(each(work, campaign.runs, ready, names=names, here=here))
    summaries: list[Summary] = []
    problems: list[Problem] = []
    for place, run in enumerate(campaign.runs):
        result = found[place]
        if isinstance(result, DataError):
            problems += [problem for problem in result.problems if problem not in problems]
        else:
            summaries.append(replace(result, run=run))
    if problems:
        raise CampaignError(problems, title="Some runs cannot be read")
    return summaries
