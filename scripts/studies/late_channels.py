"""Which channels that are late by whole samples from some time on are told, and what else is.

    python -m scripts.studies.late_channels [--count 400] [--seed 0]

Records of one channel with three harmonics over 4 to 12 cycles whose length scatters by a percent.
First sound ones and those that change in another way: none may be told. Then those that lose or
repeat one to three values somewhere between the first and the last cycle.
"""

from __future__ import annotations

import argparse
from collections.abc import Callable, Mapping

import numpy as np
from numpy.typing import NDArray
from scipy.signal import lfilter

from pmmkit.signals import shifts_within

Array = NDArray[np.float64]
SAMPLES = (30, 100, 300, 1000)
NOISES = (0.005, 0.02, 0.05, 0.1)


def phase_of(rng: np.random.Generator, cycles: int, samples: int) -> Array:
    """Phase of the motion, cycles of uneven length."""
    lengths = 1 + 0.01 * rng.normal(size=cycles + 1)
    ends = samples * np.append(0.0, np.cumsum(lengths))
    return np.interp(np.arange(int(ends[-1])), ends, 2 * np.pi * np.arange(cycles + 2))


def wave(rng: np.random.Generator) -> Callable[[Array], Array]:
    """Three harmonics, the higher ones smaller, and a mean."""
    c = rng.normal(size=(3, 2)) * np.array([[1.0], [0.2], [0.15]])
    c /= np.hypot(*c[0])
    mean = rng.normal()
    return lambda theta: (
        mean
        + sum(
            a * np.cos((n + 1) * theta) + b * np.sin((n + 1) * theta) for n, (a, b) in enumerate(c)
        )
    )


def noise(rng: np.random.Generator, size: int, samples: int, kind: str) -> Array:
    """Of unit variance: white, of a memory of a twentieth or a third of a cycle, or of waves."""
    e = rng.normal(size=size + 4 * samples)
    if kind == "white":
        return e[-size:]
    if kind == "waves":
        turn = 2 * np.pi * rng.uniform(4.3, 9.7) / samples
        e = lfilter([1.0], [1.0, -2 * 0.985 * np.cos(turn), 0.985**2], e)
    else:
        rho = np.exp(-1.0 / (samples * (0.05 if kind == "red" else 0.33)))
        e = lfilter([1.0], [1.0, -rho], e)
    return np.asarray(e[-size:] / e.std())


def other_changes(rng: np.random.Generator, theta: Array, f: Callable[[Array], Array]) -> dict:
    """Waves that change otherwise than by a shift."""
    x = np.linspace(0, 1, theta.size)
    after = x > rng.uniform(0.3, 0.7)
    g = wave(rng)
    cycles = theta / (2 * np.pi)
    slow = rng.uniform(0.01, 0.3)
    return {
        "sound": f(theta),
        "larger from some time on": f(theta) * (1 + slow * after),
        "another form from some time on": f(theta) + slow * after * g(theta),
        "third harmonic from some time on": f(theta) + slow * after * np.cos(3 * theta),
        "zero jumps": f(theta) + slow * after,
        "phase creeps": f(theta + slow * (x - 0.5)),
        "grows": f(theta) * (1 + slow * x),
        "transient": f(theta) + slow * g(theta) * np.exp(-cycles / rng.uniform(0.3, 2.0)),
        "phase swings": f(theta + slow * np.sin(theta / rng.uniform(3.0, 9.0))),
        "size swings": f(theta) * (1 + slow * np.sin(theta / rng.uniform(3.0, 9.0))),
    }


def shifted(x: Array, samples: int, start: int) -> Array:
    """Late: values repeated; early: values lost, with a record that much shorter."""
    if samples > 0:
        return np.concatenate((x[:start], x[start - samples : x.size - samples]))
    return np.concatenate((x[:start], x[start - samples :]))


def told(theta: Array, x: Array) -> int:
    """By how many samples the channel is said to be late."""
    (found,) = shifts_within(theta[: x.size], x)
    return found.samples if found else 0


def alarms(rng: np.random.Generator, count: int) -> None:
    print("told although not late by samples, of", count, "records each")
    for kind in ("white", "red", "slow", "waves"):
        found: dict[str, int] = {}
        for _ in range(count):
            samples, size = int(rng.choice(SAMPLES)), float(rng.choice((1e-6, *NOISES)))
            theta = phase_of(rng, int(rng.integers(3, 13)), samples)
            e = size * noise(rng, theta.size, samples, kind)
            for name, x in other_changes(rng, theta, wave(rng)).items():
                found[name] = found.get(name, 0) + (told(theta, x + e) != 0)
        print(f"  {kind:6}", said(found))


def said(found: Mapping[str, int]) -> str:
    return ", ".join(f"{name} {number}" for name, number in found.items())


def power(rng: np.random.Generator, count: int, kind: str) -> None:
    print(
        f"told with the right number (wrong), % of {count}, noise {kind}; late or early by 1, 2, 3"
    )
    for samples in SAMPLES:
        for size in NOISES:
            cells = []
            for late in (1, 2, 3):
                right = wrong = 0
                for _ in range(count):
                    theta = phase_of(rng, int(rng.integers(4, 13)), samples)
                    x = wave(rng)(theta) + size * noise(rng, theta.size, samples, kind)
                    by = late * int(rng.choice((-1, 1)))
                    start = int(theta.size * rng.uniform(0.3, 0.7))
                    got = told(theta, shifted(x, by, start))
                    right += got == by
                    wrong += got not in (0, by)
                cells.append(f"{100 * right / count:4.0f} ({100 * wrong / count:.0f})")
            print(f"  {samples:5} samples a cycle, noise {100 * size:4.1f} %:", *cells)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--count", type=int, default=400, help="records of each kind")
    parser.add_argument("--seed", type=int, default=0)
    o = parser.parse_args()
    rng = np.random.default_rng(o.seed)
    alarms(rng, o.count)
    for kind in ("white", "red"):
        power(rng, o.count // 4, kind)


if __name__ == "__main__":
    main()
