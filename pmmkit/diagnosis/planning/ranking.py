"""Runs in the order of what they gain for their time, whatever kind of run they are."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, Final, Protocol

import numpy as np

from pmmkit.diagnosis.evidence import RIVALS, SHOWS
from pmmkit.diagnosis.planning.options import Option
from pmmkit.diagnosis.planning.plan_file import entries_text
from pmmkit.diagnosis.planning.separation import Likely, expected_odds
from pmmkit.models import odds
from pmmkit.numerics import Array

if TYPE_CHECKING:
    import pandas as pd

    from pmmkit.diagnosis.planning.programme import TestPlan


# What to do next: a run, as often as it is to be made, and what is expected of it.


@dataclass(frozen=True, kw_only=True)
class NextRun:
    """One run that could be made next.

    `gain`: what it is made for: expected gain in ln odds of the true rival over the others; or,
    where effects are to be made visible, how many become so. `gains`: by rival, if it is the
    true one, its expected gain in ln odds over the nearest other; by effect, its squared signal
    over noise after the run. `resolves`: probability that the true rival stands alone
    afterwards; NaN where effects are to be shown. `repeats`: how often the run is to be made.
    `hours`: time of all repeats [h]. `words`: the run and what is expected of it. `after`:
    expected ln odds of the true rival over the nearest other once the run is made; NaN where
    effects are to be shown.
    """

    option: Option
    gain: float
    gains: Mapping[str, float]
    resolves: float
    repeats: int
    hours: float
    words: str
    after: float = math.nan


@dataclass(frozen=True, kw_only=True)
class Advice:
    """What to do next.

    Parameters
    ----------
    rivals : tuple of str
        Sets of effects that the tests cannot tell apart, or what is suspected and nothing; empty
        where effects are to be shown.
    wanted : tuple of str
        Effects that the advice is about.
    runs : tuple of NextRun
        Worth their time, the best first; repeats where no single run is.
    checks : mapping of str to str
        Checks at the bench or on the rig, by effect.
    words : str
        The advice.
    captive : TestPlan, optional
        Where no manoeuvre tells rivals apart: captive tests that do.
    notes : tuple of str
        What is taken for granted: how time is counted, the weather.
    """

    rivals: tuple[str, ...]
    wanted: tuple[str, ...]
    runs: tuple[NextRun, ...]
    checks: Mapping[str, str]
    words: str
    captive: TestPlan | None = None
    notes: tuple[str, ...] = ()

    @property
    def options(self) -> tuple[Option, ...]:
        """The best run, as often as it is to be made; captive tests where no run is worth it."""
        if self.captive is not None:
            return self.captive.options
        return tuple(item.option for item in self.runs[:1] for _ in range(item.repeats))

    @property
    def entries(self) -> str:
        """The runs as ``[[runs]]`` that can be pasted into a campaign file."""
        return entries_text(self.options)

    def to_dict(self) -> dict[str, Any]:
        """As plain data: what ``pmmkit plan --json`` prints of the next run."""
        return {
            "words": self.words,
            "rivals": self.rivals,
            "wanted": self.wanted,
            "runs": [
                {
                    **item.option.entry,
                    "repeats": item.repeats,
                    "gain": item.gain,
                    "gains": item.gains,
                    "after": item.after,
                    "resolves": item.resolves,
                    "hours": item.hours,
                    "words": item.words,
                }
                for item in self.runs
            ],
            "checks": self.checks,
            "notes": self.notes,
            **({} if self.captive is None else {"captive": self.captive.to_dict()}),
        }

    def to_pandas(self) -> pd.DataFrame:
        """A row per run: settings, gain, hours, probability that it resolves."""
        import pandas as pd

        return pd.DataFrame(
            [
                {
                    "run": item.option.id,
                    "test": item.option.test,
                    "speed": item.option.settings.speed,
                    "repeats": item.repeats,
                    "gain": item.gain,
                    "after": item.after,
                    "resolves": item.resolves,
                    "hours": item.hours,
                    "words": item.words,
                }
                for item in self.runs
            ]
        )


LEAST: Final = 3.0
"""Expected gain in ln odds below which a run is not worth its time."""
AT_A_NEW_SPEED: Final = "Twice: at a new speed one run would decide alone, and it may be wrong."
REPEATS: Final = 8
"""Repeats of one run that are thought of before a check at the bench is advised."""

Tried = Callable[[str, int], Array]
"""From a run and how often it is made to the expected gain in ln odds of each rival over each."""


class Offer(Protocol):
    """What could be made beside what is made, and what it would tell of effects."""

    @property
    def options(self) -> Mapping[str, Option]:
        """Runs that could be made, by name."""

    @property
    def names(self) -> tuple[str, ...]:
        """Effects that take part."""

    def check(self, name: str) -> str:
        """What settles an effect at the bench or on the rig; empty if nothing does."""

    def least(self, option: Option, /) -> int:
        """How often a run is to be made at least."""

    def likely(self, names: Sequence[str]) -> tuple[Likely, ...]:
        """A set of effects as what is made leaves it likely."""

    def added(self, run: str, times: int) -> Array:
        """Rows of unit covariance (m, k) that a run adds, in the columns of what is likely."""

    def signals(self, run: str | None = None, times: int = 1) -> Array:
        """Squared signal over noise of each effect (e,) at its usual size, after a run."""

    def separations(self, run: str | None = None, times: int = 1) -> Array:
        """The part of it that no size of another effect explains (e, e), after a run."""


def apart(
    offer: Offer, rivals: Sequence[Sequence[str]], against: Sequence[float], most: int
) -> Advice:
    """Runs that tell the rivals of a diagnosis apart, as the data have made them likely."""
    sets = [offer.likely(names) for names in rivals]
    weight = np.array(against)
    weight = weight / weight.sum()

    def tried(run: str, times: int) -> Array:
        return expected_odds(offer.added(run, times), sets)

    return _ranked(offer, rivals, weight, tried, most)


def apart_at_usual_size(offer: Offer, effects: Sequence[str], most: int) -> Advice:
    """Runs that tell effects apart which the user names, at their usual sizes."""
    at = np.array([offer.names.index(name) for name in effects])
    before = offer.separations()[np.ix_(at, at)]
    weight = np.full(len(at), 1.0 / len(at))

    def tried(run: str, times: int) -> Array:
        after = offer.separations(run, times)[np.ix_(at, at)]
        with np.errstate(invalid="ignore"):
            gains: Array = (after - before) / 2
        np.fill_diagonal(gains, np.inf)
        return gains

    return _ranked(offer, [(name,) for name in effects], weight, tried, most)


def resolved(gains: Array, ahead: Array, weight: Array) -> float:
    """Probability that the truth leads every other by 20 to 1, the least over its rivals."""
    from scipy.special import ndtr

    with np.errstate(invalid="ignore"):
        away = (gains + ahead - RIVALS) / np.sqrt(2.0 * np.maximum(gains, 1e-9))
    chance = np.where(np.isfinite(away), ndtr(away), 1.0).min(axis=1)
    return float(weight @ chance)


def checks_of(offer: Offer, names: Iterable[str]) -> Mapping[str, str]:
    """What settles effects at the bench or on the rig, where something does."""
    return MappingProxyType({name: check for name in names if (check := offer.check(name))})


def _ranked(
    offer: Offer, rivals: Sequence[Sequence[str]], weight: Array, tried: Tried, most: int
) -> Advice:
    """Options by how probably they resolve, over time; repeats where no single run is worth it."""
    names = tuple(" and ".join(own) for own in rivals)
    ahead = np.log(weight)[:, None] - np.log(weight)

    def made(run: str, times: int) -> NextRun:
        option = offer.options[run]
        each = tried(run, times)
        gains = each.min(axis=1)
        gain, resolves = float(weight @ gains), resolved(each, ahead, weight)
        return NextRun(
            option=option,
            gain=gain,
            gains=MappingProxyType(dict(zip(names, gains.tolist(), strict=True))),
            after=float(weight @ (each + ahead).min(axis=1)),
            resolves=resolves,
            repeats=times,
            hours=times * option.hours,
            words=f"{_often(times)}{option.words}: expected odds {odds(gain)} between "
            f"{' and '.join(names[:2])}{' …' if len(names) > 2 else ''}, decided with "
            f"{100 * resolves:.0f} %",
        )

    single = {run: made(run, offer.least(option)) for run, option in offer.options.items()}
    worth = [found for found in single.values() if found.gain >= LEAST]
    worth.sort(key=lambda item: (-item.resolves / item.hours, -item.gain))
    wanted = tuple(dict.fromkeys(name for own in rivals for name in own))
    checks = checks_of(offer, wanted)
    if not worth:
        worth = _repeated(single, made)
    return Advice(
        rivals=names,
        wanted=wanted,
        runs=tuple(worth[:most]),
        checks=checks,
        words=_advice(offer, worth, checks, " and ".join(names[:2])),
    )


def _repeated(single: Mapping[str, NextRun], made: Callable[[str, int], NextRun]) -> list[NextRun]:
    """The fewest repeats of one run that are worth their time; none within `REPEATS`."""
    best = sorted(single, key=lambda run: -single[run].gain / single[run].hours)[:REPEATS]
    for times in range(2, REPEATS + 1):
        worth = [item for run in best if (item := made(run, times)).gain >= LEAST]
        if worth:
            return sorted(worth, key=lambda item: -item.gain / item.hours)
    return []


def _often(times: int) -> str:
    return f"{times} times " if times > 1 else ""


def _advice(offer: Offer, runs: Sequence[NextRun], checks: Mapping[str, str], names: str) -> str:
    bench = "; ".join(f"{name}: {check}" for name, check in checks.items())
    if runs and runs[0].repeats == 1:
        return runs[0].words + "."
    if runs and runs[0].repeats == offer.least(runs[0].option):
        return f"{runs[0].words}. {AT_A_NEW_SPEED}"
    if runs:
        return f"No single run will do: {runs[0].words}. Or a check ({bench})."
    return f"No run within these limits tells {names} apart. A check will ({bench})."


def shown(offer: Offer, effects: Sequence[str], most: int) -> Advice:
    """Runs that make effects visible."""
    before = offer.signals()
    hidden = [
        i
        for i, name in enumerate(offer.names)
        if before[i] < SHOWS and (not effects or name in effects)
    ]
    wanted = tuple(offer.names[i] for i in hidden)
    if effects and not hidden:
        words = f"The tests that are made can show {' and '.join(effects)} already."
        return Advice(rivals=(), wanted=tuple(effects), runs=(), checks={}, words=words)
    runs = []
    for run, option in offer.options.items():
        times = offer.least(option)
        after = offer.signals(run, times)
        seen = [i for i in hidden if after[i] >= SHOWS]
        if seen:
            names = [offer.names[i] for i in seen]
            runs.append(
                NextRun(
                    option=option,
                    gain=float(len(seen)),
                    resolves=math.nan,
                    repeats=times,
                    hours=times * option.hours,
                    gains=MappingProxyType({offer.names[i]: float(after[i]) for i in seen}),
                    words=f"{_often(times)}{option.words}: makes {', '.join(names)} visible at "
                    "usual size",
                )
            )
    runs.sort(key=lambda item: (-item.gain / item.hours, -min(item.gains.values())))
    seen_names = {name for item in runs for name in item.gains}
    checks = checks_of(offer, [name for name in wanted if name not in seen_names])
    bench = "; ".join(f"{name}: {check}" for name, check in checks.items())
    words = f"{runs[0].words}." if runs else "No single run makes more visible."
    if runs and runs[0].repeats > 1:
        words += f" {AT_A_NEW_SPEED}"
    if bench:
        words += f" Not shown by a single run ({bench})."
    return Advice(rivals=(), wanted=wanted, runs=tuple(runs[:most]), checks=checks, words=words)
