"""What is hidden, and what is said of it: captive, free-running and spoiled campaigns."""

from __future__ import annotations

from functools import partial
from typing import Any

from scripts.golden.job import ITERATED, Job
from scripts.studies import free_hidden, hidden_effects, spoiled

SEED = 0
FREE = (
    *("none", "roll", "asymmetry", "rudder_zero", "current", "wind", "straightening", "coupling"),
    *("resistance", "stall", "clock", "heading"),
)
"""Twelve of the cases of the free tank: hull, propeller, rudder, surroundings, clock, sensors."""
BEST = 25
"""Sets of a diagnosis whose evidence is kept, besides what its group says."""
BEYOND_SEEDS = (7000, 7001, 7002)
"""Eight kinds of truth that stand in no catalogue, three campaigns of each."""


def captive(names: tuple[str, ...], seeds: tuple[int, ...]) -> dict[str, Any]:
    """The diagnoses of campaigns with one hidden effect, whole."""
    import pmmkit as pk

    found = {}
    for name in names:
        for seed in seeds:
            hidden = ((name, 1.0),) if name else ()
            job = hidden_effects.Job(hidden, seed, "full", "standard", "catalogue")
            answer = pk.diagnose(list(hidden_effects.tank().BASE), job.campaign())
            found[f"{name or 'nothing'} {seed}"] = answer.to_dict() | {
                "log_evidence": {
                    " + ".join(entry.names): entry.log_evidence
                    for entry in sorted(answer.entries, key=lambda x: -x.log_evidence)[:BEST]
                }
            }
    return found


def free(case: str) -> dict[str, Any]:
    """The diagnosis of three records of a ship that sails free."""
    setup = free_hidden.Setup(case=case, size=1.0, runs=3, seed=SEED, ship="s175")
    answer = free_hidden.answered(free_hidden.Job(truth=setup.truth, setup=setup))
    return {
        "verdict": answer.verdict,
        "sets": answer.sets,
        "odds": answer.odds,
        "log_evidence": answer.log_evidence,
        "flags": answer.flags,
        "checks": answer.checks,
        "outcome": answer.outcome,
        "error": answer.error,
    }


def spoilt(programme: str) -> dict[str, Any]:
    """What the checks say of campaigns that somebody spoiled, and how far their tables move."""
    found = {}
    for case in spoiled.ways().cases(programme, SEED):
        answer = spoiled.answered(case)
        found[f"{case.name}, {case.scope}, {case.test}"] = {
            "verdict": answer.verdict,
            "said": answer.said,
            "worst": answer.worst,
            "moved": answer.moved,
        }
    return found


def quarter(number: int) -> dict[str, Any]:
    """A quarter of the hidden effects of captive tests."""
    inside = sorted(hidden_effects.tank().INSIDE)
    return captive(tuple(inside[number::4]), (SEED,))


def third(number: int) -> dict[str, Any]:
    """A third of the truths that stand in no catalogue."""
    beyond = tuple(sorted(hidden_effects.tank().BEYOND))
    return captive(beyond, (BEYOND_SEEDS[number],))


JOBS = (
    *(Job(f"free_{case}", partial(free, case), tolerance=1e-4) for case in FREE),
    *(Job(f"hidden_{k + 1}_of_4", partial(quarter, k), tolerance=ITERATED) for k in range(4)),
    *(Job(f"beyond_{k + 1}_of_3", partial(third, k), tolerance=ITERATED) for k in range(3)),
    Job("hidden_nothing", partial(captive, ("",), (10_000, 10_001, 10_002)), tolerance=ITERATED),
    Job("spoiled_small", partial(spoilt, "small")),
    Job("spoiled_full", partial(spoilt, "full")),
)
