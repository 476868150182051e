"""Whether the advised run tells rivals apart, and whether a planned programme shows what it says.

    python -m scripts.studies.next_run [--programme small] [--size 1] [--seeds 4] [--first 0]
                               [--effects asymmetry fault_gauge_zero …] [--plans]

Campaigns of the virtual tank in which one effect is hidden are diagnosed. Where the answer is a
group, the advised run is made in the tank and the diagnosis repeated: how often the truth stands
alone then, and the gain in ln odds that was expected beside the one that came. With --plans,
programmes of the tank and plans of as many runs are compared: effects visible by design, and
effects detected and named exactly in the tank.
"""

from __future__ import annotations

import argparse
import math
from collections import Counter
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from pmmkit.diagnosis import Advice, Diagnosis, Limits, next_runs, plan
from pmmkit.diagnosis.captive.diagnose import diagnose_captive
from pmmkit.diagnosis.planning.ground import ground_of
from pmmkit.diagnosis.planning.options import USUAL, options_of
from pmmkit.diagnosis.planning.programme import sights
from pmmkit.models import Model, load_model
from scripts.studies.hidden_effects import ABSORBED, programmes, tank

RIVALLED = (
    "asymmetry",
    "fault_gauge_zero",
    "memory",
    "fault_pmm_amplitude",
    "fault_misalignment",
    "current",
    "fault_time_lag",
    "fault_filter_lag",
)
LIMITS = Limits(
    speeds=(1.0, 1.5, 2.0),
    drift=math.radians(12),
    rudder=math.radians(25),
    sway=0.8,
    yaw=math.radians(20),
    sway_velocity=0.25,
    yaw_rate=0.5,
    tests=(*USUAL, "sway_yaw"),
)
"""What the rig of the tank's programmes does."""


def cubic_model() -> Model:
    """The tank's model with linear and cubic terms alone."""
    made = load_model("s175-3dof")
    part = made.parts["hull_polynomial"]
    hull = replace(part, values={name: x for name, x in part.values.items() if name in tank().BASE})
    return made.with_(
        ship=tank().SHIP, water=tank().WATER, parts={**made.parts, "hull_polynomial": hull}
    )


@dataclass(frozen=True)
class Loop:
    """One campaign: its diagnosis, the advice, the diagnosis with the advised runs."""

    effect: str
    before: Diagnosis
    advice: Advice | None
    after: Diagnosis | None

    @property
    def resolved(self) -> bool:
        """Whether the truth stands alone."""
        return self.after is not None and [x for x, _ in self.after.group] == [(self.effect,)]

    def gains(self) -> tuple[float, float] | None:
        """Expected and observed gain in ln odds of the truth over its nearest rival."""
        truth = (self.effect,)
        if self.after is None or self.advice is None or not self.advice.runs:
            return None
        expected = self.advice.runs[0].gains
        rivals = [names for names, _ in self.before.group if names != truth]
        if self.effect not in expected or len(rivals) != 1:
            return None
        lead = [
            {item.names: item.log_evidence for item in found.entries}
            for found in (self.before, self.after)
        ]
        if rivals[0] not in lead[1] or truth not in lead[1]:
            return None
        first, last = (x[truth] - x[rivals[0]] for x in lead)
        return expected[self.effect], last - first


def closed(effect: str, programme: str, size: float, seed: int) -> Loop:
    """Diagnose, make the advised run, diagnose again."""
    hidden = {effect: size}
    campaign = tank().hidden_campaign(programme, hidden, seed=seed)
    before = diagnose_captive(campaign, tank().BASE)
    if len(before.group) < 2:
        return Loop(effect, before, None, None)
    advice = next_runs(tank().BASE, campaign, before)
    if not advice.runs:
        return Loop(effect, before, advice, None)
    best = advice.runs[0]
    added = [programmes().asked(best.option, number) for number in range(best.repeats)]
    runs = (*programmes().plans(programme), *added)
    after = diagnose_captive(tank().hidden_campaign(runs, hidden, seed=seed), tank().BASE)
    return Loop(effect, before, advice, after)


def tell_loops(loops: list[Loop]) -> None:
    """What came of the advice."""
    groups = [loop for loop in loops if loop.advice is not None]
    made = [loop for loop in groups if loop.after is not None]
    print(
        f"{len(loops)} campaigns, {len(groups)} groups, {len(made)} with an advised run; the truth "
        f"alone afterwards in {sum(loop.resolved for loop in made)}, expected "
        f"{sum(loop.advice.runs[0].resolves for loop in made if loop.advice):.1f}, repeats in "
        f"{sum(loop.advice.runs[0].repeats > 1 for loop in made if loop.advice)}"
    )
    for effect in dict.fromkeys(loop.effect for loop in groups):
        own = [loop for loop in groups if loop.effect == effect]
        tests = Counter(
            f"{loop.advice.runs[0].option.test} {loop.advice.runs[0].option.settings.speed:g} m/s"
            if loop.advice and loop.advice.runs
            else "check"
            for loop in own
        )
        print(f"  {effect}: {sum(loop.resolved for loop in own)} of {len(own)}; {dict(tests)}")
    pairs = np.array([pair for loop in made if (pair := loop.gains()) is not None])
    if len(pairs) > 2:
        expected, observed = pairs.T
        away = (observed - expected) / np.sqrt(2 * expected)
        print(
            f"gain in ln odds over {len(pairs)} groups of two: expected mean "
            f"{expected.mean():.1f}, median {np.median(expected):.1f}; observed "
            f"{observed.mean():.1f}, {np.median(observed):.1f}; correlation "
            f"{np.corrcoef(expected, observed)[0, 1]:.2f}, of the logarithms "
            f"{np.corrcoef(np.log(expected), np.log(np.maximum(observed, 0.1)))[0, 1]:.2f}; "
            f"difference over its expected deviation {away.mean():.1f}, standard "
            f"deviation {away.std():.1f}"
        )


def tell_plans(seeds: range) -> None:
    """Programmes of the tank and plans of as many runs, by design and in the tank."""
    model, offered = cubic_model(), options_of(LIMITS, tank().SHIP, tank().WATER)
    for name in ("small", "middle", "full"):
        theirs = programmes().options(name, LIMITS)
        made = plan(model, limits=LIMITS, runs=len(theirs))
        ground = ground_of(model, limits=LIMITS, options=[*offered, *theirs])
        for label, options, runs in (
            ("programme", theirs, programmes().plans(name)),
            (
                "plan",
                made.options,
                tuple(programmes().asked(x, number) for number, x in enumerate(made.options)),
            ),
        ):
            seen = sum(item.shown for item in sights(ground, [x.run().id for x in options]))
            print(f"{name}, {len(runs)} runs, {label}: {seen} effects visible")
            for size in (0.3, 1.0):
                print(f"  size {size:g}: {_named(runs, size, seeds)}")


def _named(runs: Any, size: float, seeds: range) -> str:
    count: Counter[str] = Counter()
    for effect in tank().INSIDE:
        for seed in seeds if effect not in ABSORBED else ():
            campaign = tank().hidden_campaign(runs, {effect: size}, seed=seed)
            found = [names for names, _ in diagnose_captive(campaign, tank().BASE).group]
            count["campaigns"] += 1
            count["detected"] += bool(found)
            count["exact"] += found == [(effect,)]
            count["wrong"] += bool(found) and not any(effect in names for names in found)
    return ", ".join(
        f"{name} {count[name]}" for name in ("campaigns", "detected", "exact", "wrong")
    )


def main() -> None:
    """Run the campaigns and tell what came of them."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawTextHelpFormatter
    )
    parser.add_argument("--programme", default="small")
    parser.add_argument("--size", type=float, default=1.0)
    parser.add_argument("--seeds", type=int, default=4)
    parser.add_argument("--first", type=int, default=0)
    parser.add_argument("--effects", nargs="*", default=RIVALLED)
    parser.add_argument("--plans", action="store_true")
    asked = parser.parse_args()
    seeds = range(asked.first, asked.first + asked.seeds)
    if asked.plans:
        tell_plans(seeds)
        return
    tell_loops(
        [
            closed(effect, asked.programme, asked.size, seed)
            for effect in asked.effects
            for seed in seeds
        ]
    )


if __name__ == "__main__":
    main()
