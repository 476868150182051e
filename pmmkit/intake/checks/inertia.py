"""Is the model's inertia inside the forces, and does the campaign file say so?"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np

from pmmkit.intake.checks.expected import expected, is_shallow, round_factor
from pmmkit.intake.checks.finding import Check, CheckFinding, figure, share_of
from pmmkit.numerics import Array
from pmmkit.presentation import WIDE

if TYPE_CHECKING:
    from pmmkit.campaigns import Campaign
    from pmmkit.intake.checks.finding import Summary

INSIDE: Final = 0.6
REMOVED: Final = 0.4
PLAUSIBLE: Final = (-1.0, 2.2)
ADDED: Final = 0.15
"""Doubt of the estimated added mass, over itself: a hull with little of it is no contradiction."""
IN_SHALLOW_WATER: Final = 0.6
"""The same near the bottom: of KCS at 2, 1.5 and 1.2 draughts (Flanders Hydraulics) added masses
are 0.7 to 1.1 of the estimates, Yr 0.4 to 0.6."""


@dataclass(frozen=True)
class _Question:
    """One place where inertia shows: a force that goes with a motion that is swung alone."""

    key: str
    name: str
    moves: tuple[str, ...]
    words: str
    inside: str
    removed: str
    unit: str


_QUESTIONS: Final = (
    _Question(
        "Y",
        "inertia in Y",
        ("v",),
        "Y in phase with the displacement over the sway acceleration",
        "-(m + my)",
        "-my",
        "kg",
    ),
    _Question(
        "N",
        "inertia in N",
        ("r",),
        "N in phase with the heading over the yaw acceleration",
        "-(Izz + Jz)",
        "-Jz",
        "kg m²",
    ),
    _Question(
        "Yr",
        "inertia in Y r",
        ("r",),
        "Y in phase with the yaw rate over r u",
        "Yr - m",
        "Yr",
        "kg",
    ),
    _Question(
        "X",
        "inertia in X",
        ("r", "u"),
        "X in phase with the surge acceleration over that acceleration",
        "-(m + mx)",
        "-mx",
        "kg",
    ),
)


def examine_inertia(campaign: Campaign, summaries: Sequence[Summary]) -> Iterator[CheckFinding]:
    """Compare what the forces hold with what the campaign file says they hold.

    The share ``s`` of the model's own inertia inside a force follows from the measured ratio and
    an estimate of the added mass: about 1 where it is inside, about 0 where it was removed. Above
    0.6 it counts as inside, below 0.4 as removed; between them, or where the scatter reaches
    across, nothing is said.
    """
    for forces in ("hydrodynamic", "balance"):
        claimed = [item for item in summaries if item.run.forces == forces]
        verdicts = [
            verdict
            for question in _QUESTIONS
            if (verdict := _ask(question, campaign, claimed)) is not None
        ]
        inside = [verdict.question.key for verdict in verdicts if verdict.share > INSIDE]
        removed = [verdict.question.key for verdict in verdicts if verdict.share < REMOVED]
        for verdict in verdicts:
            finding = _judge(verdict, forces, campaign, inside, removed)
            if finding is not None:
                yield finding


@dataclass(frozen=True)
class _Verdict:
    question: _Question
    runs: tuple[str, ...]
    slope: float
    error: float
    own: float
    added: float
    share: float
    share_error: float


@dataclass(frozen=True)
class Ratio:
    """A force over the motion that it goes with, from all runs in which that swings alone.

    `slope, error`: the ratio and its standard error from scatter and noise; nan of a single run
    without noise.
    """

    slope: float
    error: float
    runs: tuple[str, ...]


def inertia_ratio(key: str, summaries: Sequence[Summary]) -> Ratio | None:
    """Force over acceleration (``"Y"``, ``"N"``, ``"X"``), or Y over r u (``"Yr"``); None
    without."""
    question = next(item for item in _QUESTIONS if item.key == key)
    pairs = [(item, *_pair(key, item)) for item in summaries if _fits(question, item)]
    pairs = [
        (item, motion, force) for item, motion, force in pairs if motion and np.isfinite(force)
    ]
    if not pairs:
        return None
    motions: Array = np.array([motion for _, motion, _ in pairs])
    forces: Array = np.array([force for _, _, force in pairs])
    slope, error = share_of(motions, forces)
    noise = math.sqrt(sum(_noise(key, item) ** 2 * motion**2 for item, motion, _ in pairs))
    error = float(np.nanmax([error, noise / float(motions @ motions)]))
    return Ratio(slope, error, tuple(item.run.id for item, _, _ in pairs))


def _ask(question: _Question, campaign: Campaign, summaries: Sequence[Summary]) -> _Verdict | None:
    ratio = inertia_ratio(question.key, summaries)
    if ratio is None:
        return None
    slope, error = ratio.slope, ratio.error
    guess, ship, rho = expected(campaign), campaign.ship, campaign.water.rho
    own, added = {
        "Y": (-guess.m, -guess.my),
        "N": (-guess.Izz, -guess.Jz),
        "Yr": (-guess.m, guess.Yr * 0.5 * rho * ship.L**3),
        "X": (-guess.m, -guess.mx),
    }[question.key]
    return _Verdict(
        question, ratio.runs, slope, error, own, added, (slope - added) / own, abs(error / own)
    )


def _fits(question: _Question, item: Summary) -> bool:
    pure = item.run.kind_of_test.pure
    return pure in question.moves and abs(item.run.settings.drift) < math.radians(0.2)


def _pair(key: str, item: Summary) -> tuple[float, float]:
    """The motion and the force that goes with it."""
    if key == "Y":
        return item.s("vdot", 1), item.s("Y", 1)
    if key == "N":
        return item.s("rdot", 1), item.s("N", 1)
    if key == "Yr":
        return item.c("r", 1) * item.c("u", 0), item.c("Y", 1)
    order = 1 if item.run.kind_of_test.surges else 2
    return item.s("udot", order), item.s("X", order)


def _noise(key: str, item: Summary) -> float:
    channel = key[0]
    return item.harmonic_noise.get(channel, 0.0)


def inertia_beside_mass(campaign: Campaign, summaries: Sequence[Summary]) -> bool | None:
    """Whether the model's inertia is inside Y of yaw tests, by its stated mass; None untold.

    Of all forces Y over r u tells it best near the bottom: added mass grows there, Yr stays small
    beside the mass.
    """
    question = next(item for item in _QUESTIONS if item.key == "Yr")
    verdict = _ask(question, campaign, summaries)
    if verdict is None or not _is_told(verdict, campaign):
        return None
    return verdict.share - _spread(verdict, campaign) > REMOVED


def unasked_inertia(campaign: Campaign, summaries: Sequence[Summary]) -> tuple[str, ...]:
    """Channels of oscillating tests in which no run tells whether the model's inertia is inside.

    Nothing moves alone that would show it, or the added mass is not known well enough.
    """
    moved = {"Y": ("v", "r"), "N": ("r",)}
    open_: list[str] = []
    for channel, motions in moved.items():
        swung = [
            x for x in summaries if x.run.dynamic and set(x.run.kind_of_test.varies) & set(motions)
        ]
        questions = [item for item in _QUESTIONS if item.key.startswith(channel)]
        verdicts = [found for item in questions if (found := _ask(item, campaign, swung))]
        if swung and not any(_is_told(found, campaign) for found in verdicts):
            open_.append(channel)
    return tuple(open_)


def _is_told(verdict: _Verdict, campaign: Campaign) -> bool:
    """Whether the share of the inertia lies on one side, by noise and doubt of the added mass."""
    spread = _spread(verdict, campaign)
    return verdict.share - spread > REMOVED or verdict.share + spread < INSIDE


def _spread(verdict: _Verdict, campaign: Campaign) -> float:
    """How far the share of the inertia may be off: noise, and doubt of the added mass."""
    doubt = IN_SHALLOW_WATER if is_shallow(campaign) else ADDED
    return 2 * verdict.share_error + doubt * abs(verdict.added / verdict.own)


def _judge(
    verdict: _Verdict, forces: str, campaign: Campaign, inside: list[str], removed: list[str]
) -> CheckFinding | None:
    question, share = verdict.question, verdict.share
    noise = 2 * verdict.share_error
    spread = _spread(verdict, campaign)
    unit = question.unit
    both = verdict.own + verdict.added
    ratio = (
        f"{question.words} is {figure(verdict.slope)} ± {figure(WIDE * verdict.error, 2)} {unit}"
        f"{_in_prime(verdict, campaign)}. With the model's inertia inside it would be about "
        f"{question.inside} = {figure(both)} {unit}, without it about "
        f"{question.removed} = {figure(verdict.added)} {unit}"
    )
    numbers = {
        "ratio": verdict.slope,
        "std": verdict.error,
        "if_inside": both,
        "if_removed": verdict.added,
        "share_of_inertia": share,
    }
    if not PLAUSIBLE[0] - noise < share < PLAUSIBLE[1] + noise:
        near = round_factor(verdict.slope / (both if forces == "balance" else verdict.added))
        sign = (
            " The sign is against physics: the force and the displacement, or the channels called "
            "in phase and out of phase, may be exchanged."
            if share < 0
            else ""
        )
        factor = f" The ratio to what is claimed is near {near}." if near else ""
        return CheckFinding(
            check="inertia",
            severity="error",
            message=f"{ratio}: it is neither.{sign}{factor}",
            runs=verdict.runs,
            remedy="Look at the units, at in_phase_with and at the signs of the axes.",
            numbers=numbers,
        )
    if forces == "hydrodynamic" and share - spread > INSIDE:
        others = _agreement(inside, removed, "inside")
        return CheckFinding(
            check="inertia",
            severity="error",
            message=f'{ratio}. The campaign file says forces = "hydrodynamic", but the inertia of '
            f"the model is still inside.{others}",
            runs=verdict.runs,
            remedy='Write forces = "balance", or a correction "inertia still inside" for these '
            "runs; the reduction then removes it.",
            numbers=numbers,
        )
    if forces == "balance" and share + spread < REMOVED:
        others = _agreement(removed, inside, "removed")
        return CheckFinding(
            check="inertia",
            severity="error",
            message=f'{ratio}. The campaign file says forces = "balance", but the inertia of the '
            f"model was already removed.{others}",
            runs=verdict.runs,
            remedy='Write forces = "hydrodynamic", or a correction "inertia already removed" for '
            "these runs.",
            numbers=numbers,
        )
    return None


def _in_prime(verdict: _Verdict, campaign: Campaign) -> str:
    power = 5 if verdict.question.key == "N" else 3
    unit = 0.5 * campaign.water.rho * campaign.ship.L**power
    return f" ({figure(verdict.slope / unit)} in the prime system)"


def _agreement(same: list[str], other: list[str], word: str) -> str:
    text = f" The same is seen in {', '.join(same)}" if len(same) > 1 else ""
    if other and text:
        return f"{text}, the reverse in {', '.join(other)}: no single claim fits all channels."
    if other:
        return f" The reverse is seen in {', '.join(other)}: no single claim fits all channels."
    return f"{text}: one claim, {word}, fits them all." if text else ""


CHECKS = (
    Check(
        "inertia",
        "the model's inertia inside Y, N, X and Y r, against what the campaign file says",
        examine_inertia,
        by_particulars=True,
    ),
)
