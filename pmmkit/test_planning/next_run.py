"""The next run: which one tells rivals apart, or shows what is invisible, for the least time."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, Final

import numpy as np
from threadpoolctl import threadpool_limits

from pmmkit.campaigns.run import Campaign
from pmmkit.diagnosis.captive.verdict import RIVALS, answer
from pmmkit.diagnosis.evidence import SHOWS
from pmmkit.diagnosis.findings import Diagnosis
from pmmkit.models.step import odds
from pmmkit.numerics import Array
from pmmkit.observations.whitening import FLOOR
from pmmkit.test_planning.ground import Asked, Ground, ground_of
from pmmkit.test_planning.information import Reduced
from pmmkit.test_planning.options import Limits, Option, limits_of, timed
from pmmkit.test_planning.separation import expected_odds, likely, usual

if TYPE_CHECKING:
    import pandas as pd

LEAST: Final = 3.0
"""Expected gain in ln odds below which a run is not worth its time."""
NOTHING: Final = "nothing"
"""The rival of what one run alone shows."""
TWICE: Final = 2
"""Runs that are asked for at a speed at which none is made."""
AT_A_NEW_SPEED: Final = "Twice: at a new speed one run would decide alone, and it may be wrong."
REPEATS: Final = 8
"""Repeats of one run that are thought of before a check at the bench is advised."""


@dataclass(frozen=True, kw_only=True)
class NextRun:
    """One run that could be made next.

    Parameters
    ----------
    option : Option
        The run.
    gain : float
        What it is made for: expected gain in ln odds of the true rival over the others; or, where
        effects are to be made visible, how many become so.
    gains : mapping of str to float
        By rival, if it is the true one, its expected gain in ln odds over the nearest other; by
        effect, its squared signal over noise after the run.
    resolves : float
        Probability that the true rival stands alone afterwards; NaN where effects are to be shown.
    repeats : int
        How often the run is to be made.
    hours : float
        Time of all repeats [h].
    words : str
        The run and what is expected of it.
    """

    option: Option
    gain: float
    gains: Mapping[str, float]
    resolves: float
    repeats: int
    hours: float
    words: str


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
    """

    rivals: tuple[str, ...]
    wanted: tuple[str, ...]
    runs: tuple[NextRun, ...]
    checks: Mapping[str, str]
    words: str

    @property
    def options(self) -> tuple[Option, ...]:
        """The best run, as often as it is to be made."""
        return tuple(item.option for item in self.runs[:1] for _ in range(item.repeats))

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
                    "resolves": item.resolves,
                    "hours": item.hours,
                    "words": item.words,
                }
                for item in self.runs
            ],
            "checks": self.checks,
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
                    "resolves": item.resolves,
                    "hours": item.hours,
                    "words": item.words,
                }
                for item in self.runs
            ]
        )


def next_runs(
    model: Asked,
    campaign: Campaign,
    found: Diagnosis | None = None,
    *,
    effects: Sequence[str] = (),
    limits: Limits | None = None,
    options: Sequence[Option] | None = None,
    most: int = 10,
    floor: float = FLOOR,
    **settings: Any,
) -> Advice:
    """Which run, or which check, to make next.

    Parameters
    ----------
    model : Model, str, path, sequence of str or Structure
        The base, as for `diagnose`.
    campaign : Campaign
        The tests that are made.
    found : Diagnosis, optional
        Of that model and campaign; made if absent.
    effects : sequence of str
        What to ask about: two effects or more are told apart at their usual sizes, one is made
        visible. By default the rivals of the diagnosis; where it has none, the run that alone
        decides what is suspected, and else what its runs cannot show.
    limits : Limits, optional
        What tank and rig allow; what the campaign has done by default.
    options : sequence of Option, optional
        Runs that could be made; all within the limits by default.
    most : int
        Runs that are listed.
    floor : float
        What is too small to matter, over the rms force of a channel.
    **settings
        ``candidates``, ``given`` and ``noise``, as for `diagnose_captive`.

    Returns
    -------
    Advice

    Raises
    ------
    DataError
        If the campaign is free-running, or no run is possible.
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
    with threadpool_limits(1):
        ground = ground_of(model, campaign, limits=limits, options=options, floor=floor, **settings)
        ground.check(effects)
        reduced = ground.known().reduced()
        if len(effects) > 1:
            return _apart_at_usual_size(ground, reduced, effects, most)
        if not effects and found is None and ground.system is not None:
            found = answer(ground.system, ground.given, floor=floor)
        if not effects and found is not None and found.suspected and not found.findings:
            return _again(ground, reduced, campaign, found, limits)
        if not effects and found is not None:
            group = [item for item in found.group if set(item[0]) <= set(ground.candidates)]
            if len(group) > 1:
                rivals, against = zip(*group, strict=True)
                return _apart(ground, reduced, rivals, against, most)
        return _shown(ground, reduced, effects, most)


def _again(
    ground: Ground, reduced: Reduced, campaign: Campaign, found: Diagnosis, limits: Limits | None
) -> Advice:
    """Runs that alone decide what is suspected: each again."""
    runs = []
    for item in found.suspected:
        run = campaign[item.run]
        settings = replace(run.settings, repeat_of=item.run)
        option = timed(run.test, settings, limits or limits_of(campaign), campaign.ship)
        if option is None or item.effect not in ground.candidates:
            continue
        sets = [likely(reduced, names) for names in ((item.effect,), ())]
        gains = expected_odds(reduced.added(item.run), sets).min(axis=1)
        gain = float(gains.mean())
        told = dict(zip((item.effect, NOTHING), gains.tolist(), strict=True))
        runs.append(
            NextRun(
                option=option,
                gain=gain,
                gains=MappingProxyType(told),
                resolves=_resolved(gains[:, None], np.zeros((2, 1)), np.full(2, 0.5)),
                repeats=1,
                hours=option.hours,
                words=f"{item.run} again ({option.words}): it alone shows {item.effect}; expected "
                f"odds {odds(gain)} for it or for nothing",
            )
        )
    wanted = tuple(item.effect for item in found.suspected)
    checks = _checks(ground, [name for name in wanted if name in ground.candidates])
    words = f"{runs[0].words}." if runs else f"Look at the run {found.suspected[0].run}."
    return Advice(
        rivals=(*wanted, NOTHING), wanted=wanted, runs=tuple(runs), checks=checks, words=words
    )


def _apart(
    ground: Ground,
    reduced: Reduced,
    rivals: Sequence[Sequence[str]],
    against: Sequence[float],
    most: int,
) -> Advice:
    """Rivals of a diagnosis, as the data have made them likely."""
    sets = [likely(reduced, names) for names in rivals]
    weight = np.array(against)
    weight = weight / weight.sum()
    ahead = np.log(weight)[:, None] - np.log(weight)

    def tried(columns: Array) -> tuple[Array, float]:
        gains = expected_odds(columns, sets)
        return gains.min(axis=1), _resolved(gains, ahead, weight)

    return _ranked(ground, reduced, rivals, weight, tried, most)


def _apart_at_usual_size(
    ground: Ground, reduced: Reduced, effects: Sequence[str], most: int
) -> Advice:
    """Effects that the user names, at their usual sizes."""
    sizes = usual(ground.rows)
    at = np.array([sizes.names.index(name) for name in effects])
    before = sizes.separations(reduced.gram)[np.ix_(at, at)]
    weight = np.full(len(at), 1.0 / len(at))

    def tried(columns: Array) -> tuple[Array, float]:
        after = sizes.separations(reduced.gram + columns.T @ columns)[np.ix_(at, at)]
        with np.errstate(invalid="ignore"):
            gains = (after - before) / 2
        np.fill_diagonal(gains, np.inf)
        return gains.min(axis=1), _resolved(gains, np.zeros_like(gains), weight)

    return _ranked(ground, reduced, [(name,) for name in effects], weight, tried, most)


def _resolved(gains: Array, ahead: Array, weight: Array) -> float:
    """Probability that the truth leads every other by 20 to 1, the least over its rivals."""
    from scipy.special import ndtr

    with np.errstate(invalid="ignore"):
        away = (gains + ahead - RIVALS) / np.sqrt(2.0 * np.maximum(gains, 1e-9))
    chance = np.where(np.isfinite(away), ndtr(away), 1.0).min(axis=1)
    return float(weight @ chance)


def _ranked(
    ground: Ground,
    reduced: Reduced,
    rivals: Sequence[Sequence[str]],
    weight: Array,
    tried: Any,
    most: int,
) -> Advice:
    """Options by how probably they resolve, over time; repeats where no single run is worth it."""
    names = tuple(" and ".join(own) for own in rivals)

    def gains_of(run: str, times: int) -> tuple[float, dict[str, float], float]:
        gains, resolves = tried(reduced.added(run, times))
        return float(weight @ gains), dict(zip(names, gains.tolist(), strict=True)), resolves

    def made(run: str, times: int, found: tuple[float, dict[str, float], float]) -> NextRun:
        option = ground.options[run]
        gain, gains, resolves = found
        return NextRun(
            option=option,
            gain=gain,
            gains=MappingProxyType(gains),
            resolves=resolves,
            repeats=times,
            hours=times * option.hours,
            words=f"{_often(times)}{option.words}: expected odds {odds(gain)} between "
            f"{' and '.join(names[:2])}{' …' if len(names) > 2 else ''}, decided with "
            f"{100 * resolves:.0f} %",
        )

    least = {run: _least(ground, option) for run, option in ground.options.items()}
    single = {run: gains_of(run, times) for run, times in least.items()}
    worth = [made(run, least[run], found) for run, found in single.items() if found[0] >= LEAST]
    worth.sort(key=lambda item: (-item.resolves / item.hours, -item.gain))
    wanted = tuple(dict.fromkeys(name for own in rivals for name in own))
    checks = _checks(ground, wanted)
    if not worth:
        worth = _repeated(ground, single, gains_of, made)
    return Advice(
        rivals=names,
        wanted=wanted,
        runs=tuple(worth[:most]),
        checks=checks,
        words=_advice(ground, worth, checks, " and ".join(names[:2])),
    )


def _repeated(ground: Ground, single: Mapping[str, Any], gains_of: Any, made: Any) -> list[NextRun]:
    """The fewest repeats of one run that are worth their time; none within `REPEATS`."""
    best = sorted(
        single,
        key=lambda run: (
            -single[run][0] / _least(ground, ground.options[run]) / ground.options[run].hours
        ),
    )[:REPEATS]
    for times in range(2, REPEATS + 1):
        found = [made(run, times, gains_of(run, times)) for run in best]
        worth = [item for item in found if item.gain >= LEAST]
        if worth:
            return sorted(worth, key=lambda item: -item.gain / item.hours)
    return []


def _often(times: int) -> str:
    return f"{times} times " if times > 1 else ""


def _least(ground: Ground, option: Option) -> int:
    """How often a run is to be made at least."""
    return TWICE if ground.is_new_speed(option.settings.speed) else 1


def _advice(ground: Ground, runs: Sequence[NextRun], checks: Mapping[str, str], names: str) -> str:
    bench = "; ".join(f"{name}: {check}" for name, check in checks.items())
    if runs and runs[0].repeats == 1:
        return runs[0].words + "."
    if runs and runs[0].repeats == _least(ground, runs[0].option):
        return f"{runs[0].words}. {AT_A_NEW_SPEED}"
    if runs:
        return f"No single run will do: {runs[0].words}. Or a check ({bench})."
    return f"No run within these limits tells {names} apart. A check will ({bench})."


def _shown(ground: Ground, reduced: Reduced, effects: Sequence[str], most: int) -> Advice:
    """Runs that make effects visible."""
    sizes = usual(ground.rows)
    before = sizes.signals(reduced.gram)
    hidden = [
        i
        for i, name in enumerate(sizes.names)
        if before[i] < SHOWS and (not effects or name in effects)
    ]
    wanted = tuple(sizes.names[i] for i in hidden)
    if effects and not hidden:
        words = f"The tests that are made can show {' and '.join(effects)} already."
        return Advice(rivals=(), wanted=tuple(effects), runs=(), checks={}, words=words)
    found = []
    for run, option in ground.options.items():
        times = _least(ground, option)
        columns = reduced.added(run, times)
        after = before + np.sum((columns @ sizes.sizes) ** 2, axis=0)
        seen = [i for i in hidden if after[i] >= SHOWS]
        if seen:
            names = [sizes.names[i] for i in seen]
            found.append(
                NextRun(
                    option=option,
                    gain=float(len(seen)),
                    resolves=math.nan,
                    repeats=times,
                    hours=times * option.hours,
                    gains=MappingProxyType({sizes.names[i]: float(after[i]) for i in seen}),
                    words=f"{_often(times)}{option.words}: makes {', '.join(names)} visible at "
                    "usual size",
                )
            )
    found.sort(key=lambda item: (-item.gain / item.hours, -min(item.gains.values())))
    shown = {name for item in found for name in item.gains}
    checks = _checks(ground, [name for name in wanted if name not in shown])
    bench = "; ".join(f"{name}: {check}" for name, check in checks.items())
    words = f"{found[0].words}." if found else "No single run makes more visible."
    if found and found[0].repeats > 1:
        words += f" {AT_A_NEW_SPEED}"
    if bench:
        words += f" Not shown by a single run ({bench})."
    return Advice(rivals=(), wanted=wanted, runs=tuple(found[:most]), checks=checks, words=words)


def _checks(ground: Ground, names: Iterable[str]) -> Mapping[str, str]:
    return MappingProxyType(
        {name: ground.candidates[name].check for name in names if ground.candidates[name].check}
    )
