"""Whose the effects of a set are, by the coefficients that each campaign measures."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from pmmkit.diagnosis.captive.system import WIDER
from pmmkit.diagnosis.joint.belongs import (
    SCATTER,
    LaboratoryValues,
    found_size,
    log_shared,
    owner,
    third,
)
from pmmkit.diagnosis.joint.captive_vote import CaptiveVote, Vote
from pmmkit.diagnosis.joint.records_vote import RecordsVote
from pmmkit.diagnosis.joint.result import Belonging, JointEntry


def belongings(votes: Sequence[Vote], best: JointEntry) -> tuple[Belonging, ...]:
    """Whose each effect of the best set is.

    Of an effect that comes to values which the model has, the captive tests say nothing by
    themselves; the model, which is taken to be of the first of them, says how well these are known.
    """
    sizes = [
        item.sizes(best.names, best.ballots[item.name].faults)
        for item in votes
        if item.name in best.ballots
    ]
    tests = [item.name for item in votes if isinstance(item, CaptiveVote)]
    records = [item for item in votes if isinstance(item, RecordsVote)]
    stated = records[0].stated(tests[0]) if tests and records else {}
    if stated:
        measured = {name for own in sizes for name, x in own.items() if x.laboratory in tests}
        sizes = [{name: x for name, x in stated.items() if name not in measured}, *sizes]
    return tuple(
        _belonging(name, [own[name] for own in sizes if name in own]) for name in best.names
    )


def _belonging(name: str, found: Sequence[LaboratoryValues]) -> Belonging:
    """Whose an effect is, by the coefficients that all have."""
    common = (
        [x for x in found[0].coefficients if all(x in own.coefficients for own in found)]
        if found
        else []
    )
    measured = tuple(own.only(common) for own in found)
    typical = dict(zip(found[0].coefficients, found[0].typical, strict=True)) if found else {}
    usual = np.array([abs(typical[x]) for x in common])
    size = found_size(measured, usual) if common else 1.0
    asked = len(found) > 1 and bool(common)
    prior = np.diag((WIDER * usual) ** 2)
    ratio = log_shared(measured, prior) if asked else math.nan
    return Belonging(
        effect=name,
        owner=owner(ratio) if asked else "cannot tell",
        log_odds=ratio,
        coefficients=tuple(common),
        usual=tuple(usual.tolist()),
        size=size,
        measured=measured,
        thirds=tuple(
            third(measured, prior, size * usual, scale=x)
            for x in (SCATTER, SCATTER / 2, SCATTER * 2)
        )
        if common
        else (),
    )
