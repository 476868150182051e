"""What is missing, as several campaigns say together."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from typing import Any, Final

from pmmkit.diagnosis import Session, Together
from pmmkit.effects import CATALOGUE, Effect
from pmmkit.models import odds
from pmmkit.views.pages.drawn import NUMBERS, drawn_over
from pmmkit.views.pages.missing import candidate_page, coefficients_page
from pmmkit.views.pages.numbers import short

SHOWN: Final = 10
"""Effects beside those that are named."""


def joint_page(
    found: Together,
    session: Session[Together],
    heard: Callable[[float, str], None] = lambda _done, _: None,
) -> dict[str, Any]:
    """A diagnosis of several campaigns, with what each candidate would do to each of them."""
    own = {item.name: item for item in session.evidence.own}
    entries = {**CATALOGUE, **own}
    named = [item for item in found.singles if item.names[0] in found.best]
    others = [item for item in found.singles if item.names[0] not in found.best][:SHOWN]
    sentences = {item.effect: item.sentence for item in found.belongs}
    ship = [
        _candidate(
            item.names[0],
            entries,
            found,
            # Nothing of a campaign that cannot be asked for it.
            [_vote(name, ballot.log_evidence) for name, ballot in item.ballots.items()],
            sentences,
        )
        for item in (*named, *others)
    ]
    faults = [
        _fault(name, fault, entries, found)
        for name in found.names
        for fault in found.faults_of(name)
    ]
    candidates = [item for item in (*ship, *faults) if item["named"]]
    candidates += [item for item in ship if not item["named"]]
    return {
        "verdict": found.verdict,
        "sentence": found.sentence,
        "answer": found.answer,
        "remarks": [*found.flags, *sentences.values(), *found.notes],
        "floor": session.evidence.floor,
        "candidates": candidates,
        "sets": [{"effects": list(names), "odds": short(x)} for names, x in found.group],
        "suspected": [],
        "hidden": [{"effect": x.name, "why": x.why, "size": short(x.hides)} for x in found.hidden],
        "covered": [],
        "overlays": {},
        "base": {},
        "drawn": _drawn(session, found, candidates, heard),
        "unasked": [
            {"effect": name, "why": ""} for name in own if name not in session.evidence.kinds
        ],
    }


def _drawn(
    session: Session[Together],
    found: Together,
    candidates: Sequence[Mapping[str, Any]],
    heard: Callable[[float, str], None],
) -> list[dict[str, Any]]:
    """What candidates would do to each campaign; nothing of those that it is not asked for."""
    evidence: Any = session.evidence  # of several campaigns
    tables = []
    for number, (name, (item, asked)) in enumerate(evidence.each(session.steps).items()):
        singles = {x.names: x for x in found.diagnoses[name].entries}
        names = [x["effect"] for x in candidates if x["campaign"] in ("", name)]
        chosen = [singles[own,] for own in names if (own,) in singles]
        tables.append(
            drawn_over(
                item,
                asked,
                [x for x in chosen if math.isfinite(x.log_evidence)],
                partial(_told, heard, number, len(found.names)),
                numbers=NUMBERS // len(found.names),
            )
        )
    return tables


def _told(
    heard: Callable[[float, str], None], number: int, count: int, done: float, effect: str
) -> None:
    heard((number + done) / count, effect)


def _candidate(
    name: str,
    entries: Mapping[str, Effect],
    found: Together,
    votes: list[dict[str, Any]],
    sentences: Mapping[str, str],
) -> dict[str, Any]:
    """An effect of the ship, beside the others of the best set if it is one of them."""
    single = next(item for item in found.singles if item.names == (name,))
    measured = next((item for item in found.belongs if item.effect == name), None)
    third = measured.thirds[0] if measured and measured.thirds else None
    return candidate_page(
        name,
        entries.get(name),
        log_odds=found.added.get(name, single.log_evidence),
        named=name in found.best,
        kind="physics",
        votes=votes,
        rivals=[" + ".join(names) for names in found.rivals_of(name)],
        coefficients=coefficients_page(
            measured.coefficients, third.values.tolist(), third.std.tolist(), measured.usual
        )
        if measured and third
        else [],
        said=sentences.get(name, ""),
    )


def _fault(
    campaign: str, name: str, entries: Mapping[str, Effect], found: Together
) -> dict[str, Any]:
    """A fault of one campaign, as it alone says it."""
    own = next((x for x in found.diagnoses[campaign].findings if x.effect == name), None)
    size = own.log_odds if own else 0.0
    return candidate_page(
        name,
        entries.get(name),
        log_odds=size,
        named=True,
        kind="fault",
        campaign=campaign,
        votes=[_vote(campaign, size)],
    )


def _vote(campaign: str, log_odds: float) -> dict[str, Any]:
    return {"campaign": campaign, "log_odds": short(log_odds), "evidence": odds(log_odds)}
