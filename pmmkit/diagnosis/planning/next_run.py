"""The next run: which one tells rivals apart, or shows what is invisible, for the least time."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from types import MappingProxyType
from typing import Any, Final

import numpy as np

from pmmkit.campaigns import Campaign
from pmmkit.diagnosis.captive.verdict import answer
from pmmkit.diagnosis.findings import Diagnosis
from pmmkit.diagnosis.planning.ground import Asked, Ground, ground_of
from pmmkit.diagnosis.planning.manoeuvres import next_manoeuvres
from pmmkit.diagnosis.planning.options import Limits, Option, timed
from pmmkit.diagnosis.planning.ranking import (
    Advice,
    NextRun,
    apart,
    apart_at_usual_size,
    checks_of,
    resolved,
    shown,
)
from pmmkit.diagnosis.planning.separation import expected_odds
from pmmkit.identification import FreeRecord
from pmmkit.models import odds
from pmmkit.numerics import one_thread
from pmmkit.reduction import FLOOR

NOTHING: Final = "nothing"
"""The rival of what one run alone shows."""


def next_runs(
    model: Asked,
    campaign: Campaign | Sequence[FreeRecord],
    found: Diagnosis | None = None,
    *,
    effects: Sequence[str] = (),
    limits: Limits | None = None,
    options: Sequence[Option] | None = None,
    most: int = 10,
    floor: float | None = None,
    **settings: Any,
) -> Advice:
    """Which run, or which check, to make next.

    Parameters
    ----------
    model : Model, str, path, sequence of str or Structure
        The base, as for `diagnose`.
    campaign : Campaign or sequence of FreeRecord
        The tests that are made, captive or free running.
    found : Diagnosis, optional
        Of that model and campaign; made if absent.
    effects : sequence of str
        What to ask about: two effects or more are told apart at their usual sizes, one is made
        visible. By default the rivals of the diagnosis; where it has none, the run that alone
        decides what is suspected, and else what its runs cannot show.
    limits : Limits, optional
        What tank and rig allow; what the campaign has done by default. Of manoeuvres speeds,
        rudder and wait count.
    options : sequence of Option, optional
        Captive runs that could be made; all within the limits by default.
    most : int
        Runs that are listed.
    floor : float, optional
        What is too small to matter, over the rms force of a channel; as for the diagnosis if
        absent.
    **settings
        ``candidates``, ``given`` and ``noise``, as for `diagnose_captive`; of free-running records
        those of `next_manoeuvres`.

    Returns
    -------
    Advice

    Raises
    ------
    DataError
        If no run is possible, or an argument does not fit the tests.
    UnknownNameError
        If an effect is not known.

    Notes
    -----
    A rival's prediction of a run, with base and floor refitted and its own coefficients as
    uncertain as the data leave them, is a normal distribution; so is the other's. The gain in ln
    odds to be expected of the run is the divergence of one from the other. It holds within the
    catalogue and for the noise and scatter of the campaign. Its standard deviation is about the
    root of twice its size. At a speed at which nothing is made yet one run would decide alone, and
    may be wrong: two are asked for.
    """
    if not isinstance(campaign, Campaign) or campaign.kind == "free-running":
        own = {} if floor is None else {"floor": floor}
        return next_manoeuvres(
            model,
            campaign,
            found,
            effects=effects,
            limits=limits,
            options=options,
            most=most,
            **own,
            **settings,
        )
    floor = FLOOR if floor is None else floor
    with one_thread():
        ground = ground_of(model, campaign, limits=limits, options=options, floor=floor, **settings)
        ground.require(effects)
        if len(effects) > 1:
            return apart_at_usual_size(ground, effects, most)
        if not effects and found is None and ground.system is not None:
            found = answer(ground.system, ground.given, floor=floor)
        if not effects and found is not None and found.suspected and not found.findings:
            return _again(ground, campaign, found, limits)
        if not effects and found is not None:
            group = [item for item in found.group if set(item[0]) <= set(ground.candidates)]
            if len(group) > 1:
                rivals, against = zip(*group, strict=True)
                return apart(ground, rivals, against, most)
        return shown(ground, effects, most)


def _again(ground: Ground, campaign: Campaign, found: Diagnosis, limits: Limits | None) -> Advice:
    """Runs that alone decide what is suspected: each again."""
    runs = []
    for item in found.suspected:
        run = campaign[item.run]
        settings = replace(run.settings, repeat_of=item.run)
        option = timed(run.test, settings, limits or Limits.of(campaign), campaign.ship)
        if option is None or item.effect not in ground.candidates:
            continue
        sets = [ground.likely(names) for names in ((item.effect,), ())]
        gains = expected_odds(ground.added(item.run, 1), sets).min(axis=1)
        gain = float(gains.mean())
        told = dict(zip((item.effect, NOTHING), gains.tolist(), strict=True))
        runs.append(
            NextRun(
                option=option,
                gain=gain,
                after=gain,
                gains=MappingProxyType(told),
                resolves=resolved(gains[:, None], np.zeros((2, 1)), np.full(2, 0.5)),
                repeats=1,
                hours=option.hours,
                words=f"{item.run} again ({option.words}): it alone shows {item.effect}; expected "
                f"odds {odds(gain)} for it or for nothing",
            )
        )
    wanted = tuple(item.effect for item in found.suspected)
    checks = checks_of(ground, [name for name in wanted if name in ground.candidates])
    words = f"{runs[0].words}." if runs else f"Look at the run {found.suspected[0].run}."
    return Advice(
        rivals=(*wanted, NOTHING), wanted=wanted, runs=tuple(runs), checks=checks, words=words
    )
