"""One candidate of what may be missing, as the page reads it."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from pmmkit.effects.effect import Effect
from pmmkit.models.step import odds
from pmmkit.presentation import WIDE
from pmmkit.workbench.pages.numbers import short


def candidate_page(
    name: str, effect: Effect | None, *, log_odds: float, named: bool, kind: str, **more: Any
) -> dict[str, Any]:
    """A candidate.

    Parameters
    ----------
    name : str
        Its name.
    effect : Effect, optional
        Its entry; without one nothing is said of it but its name.
    log_odds : float
        ln of the odds for it.
    named : bool
        Whether the diagnosis names it.
    kind : {"physics", "fault"}
        What it is.
    **more
        ``family``, ``campaign``, ``votes``, ``said``, ``share``, ``lost``, ``rivals``, ``test``,
        ``coefficients``, ``shown``, ``why``, where there is something to say.
    """
    told: dict[str, Any] = {
        "family": effect.family if effect else "",
        "campaign": "",
        "votes": [],
        "said": "",
        "share": None,
        "lost": False,
        "rivals": [],
        "test": effect.check if effect else "",
        "coefficients": [],
        "shown": True,
        "why": "",
    }
    return {
        "effect": name,
        "kind": kind,
        "summary": (effect.summary or effect.text) if effect else "",
        "log_odds": short(log_odds),
        "evidence": odds(log_odds),
        "named": named,
        **told,
        **more,
    }


def coefficients_page(
    names: Sequence[str], values: Sequence[float], stds: Sequence[float], typical: Sequence[float]
) -> list[dict[str, Any]]:
    """Coefficients with half of their 95 % intervals and usual sizes."""
    rows = zip(names, values, stds, typical, strict=True)
    return [
        {"name": name, "value": short(value), "half": short(WIDE * std), "typical": short(usual)}
        for name, value, std, usual in rows
    ]
