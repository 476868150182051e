"""Terms that sparse regression chooses in made campaigns, and how often its intervals hold.

    python -m scripts.studies.terms [--replicates 60] [--bags 40]

Fifteen runs (drift, pure sway, pure yaw, yaw with drift) of a force with five of twelve terms, in
units that differ by twelve orders of magnitude. Four kinds of errors: white noise; small forces,
every run twice; an offset of each run; autocorrelated noise. By rule: the true terms that are found
and the false ones that are taken per replicate, how often the set is the true one, and how often
value ± 1.96 std holds the truth, by term.
"""

from __future__ import annotations

import argparse
from collections import defaultdict

import numpy as np

from pmmkit.inference import EffectiveSample, Equations, Resampling, Selection, SparseProblem
from pmmkit.numerics import Array

TERMS = ["v", "r", "v|v|", "vvr", "vrr", "vdot", "rdot", "vvv", "rrr", "r|r|", "one", "vvvvv"]
TRUE = {"v": 12.0, "r": 8.0, "v|v|": 6.0, "vrr": 2.0, "vdot": 5.0}
"""Rms forces in standard deviations of a sample."""
UNITS = np.geomspace(1e-6, 1e6, len(TERMS))
SAMPLES = 120
KINDS = {
    "white noise": {},
    "forces of 0.3, each run twice": {"force": 0.3, "times": 2},
    "offsets of runs of 0.3": {"offset": 0.3},
    "noise of lag-one correlation 0.8": {"lag": 0.8},
}


def runs_of(times: int = 1) -> list[Array]:
    """Columns (n, p) of each run."""
    t, zero = np.linspace(0.0, 6 * np.pi, SAMPLES), np.zeros(SAMPLES)
    sine, cosine = np.sin(t), np.cos(t)
    runs = [(zero + v, zero, zero, zero) for v in (-0.3, -0.15, -0.05, 0.05, 0.15, 0.3)]
    runs += [(a * sine, zero, a * cosine, zero) for a in (0.1, 0.2, 0.35)]
    runs += [
        (zero + v, a * sine, zero, a * cosine) for a in (0.2, 0.4, 0.6) for v in (0.0, -0.2, 0.15)
    ]
    found = []
    for v, r, vdot, rdot in runs * times:
        even = [v * abs(v), v * v * r, v * r * r]
        found.append([v, r, *even, vdot, rdot, v**3, r**3, r * abs(r), zero + 1.0, v**5])
    return [np.stack(columns, axis=1) / UNITS for columns in found]


def made(
    rng: np.random.Generator,
    force: float = 1.0,
    times: int = 1,
    offset: float = 0.0,
    lag: float = 0.0,
) -> tuple[list[Equations], Array]:
    """Equations of a campaign, and the true coefficients (p,)."""
    designs = runs_of(times)
    size = np.sqrt(np.mean(np.concatenate(designs) ** 2, axis=0))
    theta = force * np.array([TRUE.get(name, 0.0) for name in TERMS]) / size
    runs = []
    for X in designs:
        noise = rng.normal(size=SAMPLES)
        for i in range(1, SAMPLES):
            noise[i] = lag * noise[i - 1] + np.sqrt(1 - lag**2) * noise[i]
        runs.append(Equations.of((X, X @ theta + noise + offset * rng.normal())))
    return runs, theta


def study(replicates: int, bags: int) -> list[str]:
    """What the module says, a paragraph by kind of errors."""
    lines = []
    for title, kind in KINDS.items():
        sets: dict[str, list[tuple[int, int, bool]]] = defaultdict(list)
        holds: dict[str, dict[str, list[bool]]] = defaultdict(lambda: defaultdict(list))
        for seed in range(replicates):
            runs, theta = made(np.random.default_rng(1000 + seed), **kind)
            sample, whole = EffectiveSample.of(runs), Equations.joined(runs)
            for rule in ("stlsq", "stepwise", "elimination"):
                problem = SparseProblem.single("Y", len(TERMS), rule)
                resampling = Resampling.of(len(runs), bags, np.random.default_rng(seed))
                found = Selection.of(problem, runs, resampling)
                there = theta != 0
                sets[rule].append(
                    (
                        int(np.sum(found.stays & there)),
                        int(np.sum(found.stays & ~there)),
                        bool(np.array_equal(found.stays, there)),
                    )
                )
                away = (whole.least_squares(found.stays) - theta)[found.stays]
                std = np.sqrt(np.diagonal(found.covariance(runs, sample)))
                for place, far in zip(np.flatnonzero(found.stays), away / std, strict=True):
                    if there[place]:
                        holds[rule][TERMS[place]].append(bool(abs(far) < 1.96))
        lines.append(f"{title}:")
        for rule, item in sets.items():
            right, wrong, same = np.mean(np.array(item, float), axis=0)
            own = {name: 100 * np.mean(holds[rule][name]) for name in TRUE}
            every = 100 * np.mean([x for hits in holds[rule].values() for x in hits])
            lines.append(
                f"  {rule:12} {right:.2f} of {len(TRUE)} found, {wrong:.2f} false, the true set in "
                f"{100 * same:.0f} %; intervals hold {every:.1f} %: "
                + ", ".join(f"{name} {share:.0f}" for name, share in own.items())
            )
        print("\n".join(lines[-4:]), flush=True)
    return lines


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--replicates", type=int, default=60)
    parser.add_argument("--bags", type=int, default=40)
    options = parser.parse_args()
    study(options.replicates, options.bags)


if __name__ == "__main__":
    main()
