"""A whole programme of tests: run after run, the one that shows and separates most for its time."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from pmmkit.base import DataError
from pmmkit.campaigns import Campaign
from pmmkit.diagnosis.captive.candidate import Candidate
from pmmkit.diagnosis.captive.diagnose import derivatives_of
from pmmkit.diagnosis.captive.system import FEATURES
from pmmkit.diagnosis.evidence import RIVALS, SHOWS, could_hide
from pmmkit.diagnosis.planning.ground import Asked, Ground, ground_of
from pmmkit.diagnosis.planning.information import Reduced, RunInformation, known
from pmmkit.diagnosis.planning.options import Limits, Option
from pmmkit.diagnosis.planning.plan_file import entries_text
from pmmkit.diagnosis.planning.planned import base_of
from pmmkit.diagnosis.planning.separation import UsualEffects, usual
from pmmkit.intake import Untold
from pmmkit.models import Model
from pmmkit.numerics import Array, one_thread

if TYPE_CHECKING:
    import pandas as pd

RUNS: Final = 24
"""Runs of a programme where nobody says how many, or how long."""
FINE: Final = 100.0
"""How much the first part of a step towards a goal counts: progress is ln(1 + 100 x)/ln 101."""
SMALL: Final = 0.3
"""Share of their usual size at which effects are to be visible and told apart in the end."""
KNOWN_TO: Final = 0.01
"""Share of a channel's force to which the part of each derivative is to be known."""
EACH: Final = 4
"""All options are looked at anew at each fourth step, at others those that promised most."""
TRIED: Final = 16
"""How many those are at least."""
TIMES: Final = 2
"""How often a plan makes a run: once, and one repeat that shows the scatter."""
ABSORBED: Final = 1e-3
"""Share of a signal below which what is left of it counts as absorbed by the base."""
WORTH: Final = 1e-3
"""Progress, in effects, below which another run is not worth its time."""


@dataclass(frozen=True, kw_only=True)
class PlannedRun:
    """One run of a plan.

    `hours`: time of the plan up to its end [h]. `shown`: effects that become visible with it.
    `visible`: effects that are visible after it. `separated`: share of the pairs of effects
    that are told apart after it.
    """

    option: Option
    hours: float
    shown: tuple[str, ...]
    visible: int
    separated: float


@dataclass(frozen=True, kw_only=True)
class Sight:
    """What runs show of one effect at its usual size.

    `signal`: squared signal over noise. `hides`: share of the usual size that could hide.
    `shown`: whether it is visible. `twins`: effects that cannot be told from it. `why`: why it
    is not visible, and what to do about it.
    """

    name: str
    family: str
    signal: float
    hides: float
    shown: bool
    twins: tuple[str, ...]
    why: str


@dataclass(frozen=True, kw_only=True)
class TestPlan:
    """A programme of tests.

    Parameters
    ----------
    steps : tuple of PlannedRun
        Its runs, in the order in which they are best made.
    sights : tuple of Sight
        What all runs together show, the most visible first.
    before : tuple of str
        Effects that tests already made show.
    made : int
        Number of those tests.
    untold : tuple of Untold
        What all these runs, in this order, will not tell of their own errors.
    """

    steps: tuple[PlannedRun, ...]
    sights: tuple[Sight, ...]
    before: tuple[str, ...]
    made: int
    untold: tuple[Untold, ...] = ()

    @property
    def options(self) -> tuple[Option, ...]:
        """The runs."""
        return tuple(step.option for step in self.steps)

    @property
    def entries(self) -> str:
        """The runs as ``[[runs]]`` that can be pasted into a campaign file."""
        return entries_text(self.options)

    @property
    def hours(self) -> float:
        """Time it takes [h]."""
        return self.steps[-1].hours if self.steps else 0.0

    @property
    def invisible(self) -> tuple[Sight, ...]:
        """What stays invisible, and why."""
        return tuple(item for item in self.sights if not item.shown)

    def to_dict(self) -> dict[str, Any]:
        """As plain data: what ``pmmkit plan --json`` prints of a programme."""
        return {
            "hours": self.hours,
            "made": self.made,
            "before": self.before,
            "steps": [
                {
                    **step.option.entry,
                    "duration_h": step.option.hours,
                    "hours": step.hours,
                    "shown": step.shown,
                    "visible": step.visible,
                    "separated": step.separated,
                }
                for step in self.steps
            ],
            "effects": [asdict(item) for item in self.sights],
            "untold": [item.to_dict() for item in self.untold],
        }

    def to_pandas(self) -> pd.DataFrame:
        """A row per run: settings as in a campaign file, hours, what becomes visible."""
        import pandas as pd

        rows = []
        for number, step in enumerate(self.steps, start=1):
            entry = step.option.entry
            del entry["file"]
            rows.append(
                {
                    "number": number,
                    **entry,
                    "cycles": step.option.cycles,
                    "record_s": step.option.record,
                    "duration_h": step.option.hours,
                    "hours": step.hours,
                    "shown": " ".join(step.shown),
                    "visible": step.visible,
                    "separated": step.separated,
                }
            )
        return pd.DataFrame(rows)


def plan(
    model: Asked,
    campaign: Campaign | None = None,
    *,
    runs: int | None = None,
    hours: float | None = None,
    effects: Sequence[str] = (),
    limits: Limits | None = None,
    options: Sequence[Option] | None = None,
    **settings: Any,
) -> TestPlan:
    """A programme of tests, before any is made or in addition to those of a campaign.

    Parameters
    ----------
    model : Model, str, path, sequence of str or Structure
        The base, as for `diagnose`; before any test a model with values.
    campaign : Campaign, optional
        Tests that are made. One without runs gives ship and water.
    runs : int, optional
        Most runs; 24 where neither runs nor hours are given.
    hours : float, optional
        Most time [h].
    effects : sequence of str
        Effects that matter; all by default.
    limits : Limits, optional
        What tank and rig allow; what the campaign has done by default.
    options : sequence of Option, optional
        Runs that could be made; all within the limits by default.
    **settings
        ``floor``, ``noise``, ``record_noise``, ``candidates`` and ``given``, as for `ground_of`.

    Returns
    -------
    TestPlan

    Raises
    ------
    DataError
        If there are neither tests nor a model with values, no limits, or no possible run.
    UnknownNameError
        If an effect is not known.

    Notes
    -----
    Each step takes the run with the largest progress per hour: of effects towards being visible at
    0.3 of their usual size, of pairs of such effects towards 20 to 1, of derivatives towards being
    known to 1 % of the forces; the first part of each way counts most. What all runs together
    cannot show or separate at usual size does not count.
    """
    if (runs is not None and runs < 1) or (hours is not None and not hours > 0):
        raise DataError("A plan needs one run at least, and some time.")
    with one_thread():
        ground = ground_of(model, campaign, limits=limits, options=options, **settings)
        ground.require(effects)
        most = runs if runs is not None else RUNS if hours is None else 10**6
        longest = math.inf if hours is None else hours
        made = _planned(ground, _goal(ground, effects), most, longest)
    return replace(made, untold=_untold(made, model, campaign))


def _untold(made: TestPlan, model: Asked, campaign: Campaign | None) -> tuple[Untold, ...]:
    """What the runs made and those of a plan leave open, whatever they will measure."""
    source, _, _ = derivatives_of(model)
    known = source if isinstance(source, Model) else None
    if campaign is None and known is not None:
        campaign = Campaign(title="", ship=known.ship, water=known.water, runs=())
    if campaign is None:
        return ()
    runs = (*campaign.runs, *(option.run() for option in made.options))
    speeds = [run.settings.speed for run in runs]
    values = base_of(known, speeds).values if known is not None and runs else None
    return Untold.of(campaign.with_(runs=runs), values=values, recorded=bool(campaign.runs))


@dataclass(frozen=True, kw_only=True, eq=False)
class _Goal:
    """What counts as progress.

    `usual`: effects at their usual sizes. `visible (e,)`: weight of each effect's visibility: 1
    where it matters and some run can show it. `apart (e, e)`: weight of each pair: one in all
    for an effect that can be told from others. `precision (p,)`: precision of each derivative
    at which it is known well enough.
    """

    usual: UsualEffects
    visible: Array
    apart: Array
    precision: Mapping[str, Array]

    def progress(self, gram: Array, precision: Mapping[str, Array]) -> float:
        """How far runs have come, in effects."""
        signals = SMALL**2 * self.usual.signals(gram)
        apart = SMALL**2 * self.usual.separations(gram)
        found = float(self.visible @ _part(signals / SHOWS))
        found += float(np.sum(self.apart * _part(apart / (2 * RIVALS))))
        parts = np.concatenate([_part(x / self.precision[c]) for c, x in precision.items()])
        return found + float(self.visible.sum() * parts.mean())


def _part(x: Array) -> Array:
    found: Array = np.minimum(np.log1p(FINE * x) / math.log1p(FINE), 1.0)
    return found


def _goal(ground: Ground, effects: Sequence[str]) -> _Goal:
    """What all options together could reach."""
    sizes = usual(ground.rows)
    all_runs = known(ground.rows, [*ground.made, *ground.options]).reduced()
    matters = np.array([not effects or name in effects for name in sizes.names])
    can = matters & (sizes.signals(all_runs.normal.information) >= SHOWS)
    apart = (sizes.separations(all_runs.normal.information) >= 2 * RIVALS) & can[:, None]
    np.fill_diagonal(apart, False)
    precision = {}
    for name, count in ground.rows.null.items():
        force = [rows[name][:, -1] for rows in ground.rows.of_run.values() if name in rows]
        size = float(np.linalg.norm(np.concatenate(force)))
        precision[name] = np.full(count - FEATURES, 1.0 / (KNOWN_TO * max(size, 1e-9)) ** 2)
    return _Goal(
        usual=sizes,
        visible=can.astype(float),
        precision=MappingProxyType(precision),
        apart=apart / np.maximum(apart.sum(axis=1, keepdims=True), 1),
    )


def _planned(ground: Ground, goal: _Goal, most: int, hours: float) -> TestPlan:
    state = ground.known()
    reduced = state.reduced()
    before = _shown(goal, reduced)
    promised: dict[str, float] = {}
    steps: list[PlannedRun] = []
    seen, spent = set(before), 0.0
    while len(steps) < most:
        if len(steps) % EACH == 0:
            promised = dict.fromkeys(ground.options, math.inf)
        made = Counter(step.option.id for step in steps)
        left = {
            run: promised.get(run, math.inf)
            for run, option in ground.options.items()
            if made[option.id] < TIMES and spent + option.hours <= hours
        }
        best, promised = _best(ground, goal, reduced, left)
        if best is None:
            break
        state = state.joined(best)
        reduced = state.reduced()
        spent += ground.options[best].hours
        after = _shown(goal, reduced)
        steps.append(
            PlannedRun(
                option=ground.options[best],
                hours=spent,
                visible=len(after),
                shown=tuple(name for name in after if name not in seen),
                separated=_separated(goal, reduced),
            )
        )
        seen |= set(after)
    return TestPlan(
        steps=tuple(steps), sights=sights(ground, state), before=before, made=len(ground.made)
    )


def _best(
    ground: Ground, goal: _Goal, reduced: Reduced, promised: Mapping[str, float]
) -> tuple[str | None, dict[str, float]]:
    """The option of most progress per hour, and what all promise; the rest keep their promise."""
    before = goal.progress(reduced.normal.information, reduced.precision())
    fresh: dict[str, float] = {}
    for run in sorted(promised, key=lambda name: -promised[name]):
        if len(fresh) >= TRIED and max(fresh.values()) >= promised[run]:
            break
        columns = reduced.added(run)
        gain = (
            goal.progress(reduced.normal.information + columns.T @ columns, reduced.precision(run))
            - before
        )
        fresh[run] = gain / ground.options[run].hours
    best = max(fresh, key=lambda name: fresh[name], default=None)
    if best is not None and fresh[best] * ground.options[best].hours < WORTH:
        best = None
    return best, {**promised, **fresh}


def _shown(goal: _Goal, reduced: Reduced) -> tuple[str, ...]:
    signals = goal.usual.signals(reduced.normal.information)
    return tuple(
        name for name, x in zip(goal.usual.names, signals.tolist(), strict=True) if x >= SHOWS
    )


def _separated(goal: _Goal, reduced: Reduced) -> float:
    apart = goal.usual.separations(reduced.normal.information) >= 2 * RIVALS
    count = len(apart)
    return float(apart.sum() - count) / max(count * (count - 1), 1)


def sights(ground: Ground, state: RunInformation | Iterable[str]) -> tuple[Sight, ...]:
    """What some runs together show of every effect."""
    state = state if isinstance(state, RunInformation) else known(ground.rows, state)
    reduced = state.reduced()
    sizes = usual(ground.rows)
    gram = reduced.normal.information
    signals = sizes.signals(gram)
    apart = sizes.separations(gram) >= 2 * RIVALS
    all_runs = known(ground.rows, [*ground.made, *ground.options])
    possible, plain = (
        sizes.signals(x) for x in (all_runs.reduced().normal.information, all_runs.plain())
    )
    found = []
    for i, name in enumerate(sizes.names):
        candidate, signal = ground.candidates[name], float(signals[i])
        at = np.flatnonzero(sizes.sizes[:, i])
        shown = signal >= SHOWS
        twins = [other for other, yes in zip(sizes.names, apart[i], strict=True) if not yes]
        found.append(
            Sight(
                name=name,
                family=candidate.family,
                signal=signal,
                shown=shown,
                hides=could_hide(gram[np.ix_(at, at)], sizes.sizes[at, i]),
                twins=tuple(twins) if shown else (),
                why="" if shown else _why(possible[i], plain[i], candidate),
            )
        )
    return tuple(sorted(found, key=lambda item: -item.signal))


def _why(possible: float, plain: float, candidate: Candidate) -> str:
    if possible >= SHOWS:
        return "other runs within the limits show it, with more time"
    if plain == 0.0 and candidate.excites:
        cause = f"no possible run holds {' and '.join(candidate.excites)}"
    elif possible < ABSORBED * plain:
        cause = "the base absorbs it in every possible run"
    else:
        cause = "too small beside noise, run scatter and floor"
    return f"{cause}; to be checked: {candidate.check}" if candidate.check else cause
