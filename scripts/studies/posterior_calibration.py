"""Whether the posterior is calibrated: ranks of the truth among its draws (Talts et al. 2018).

    python -m scripts.studies.posterior_calibration [--replicates 100] [--workers 1] [--seed 0]
                                                    [--save FILE] [--figure FILE]

Each replicate draws a ship from the prior (KVLCC2 of 7 m; Yv, Yr, Nv and Nr off by 20 %), process
noise and a factor of the sensors' standard deviations from theirs, sails two short records in the
tank of tests/support/free_tank, which shares no code with the package, and identifies the four from
them by the posterior, the extended Kalman filter and the fit to trajectories. If the posterior is
right, the truth is equally likely to have any rank among its draws. A replicate takes some seconds
of processor time. `--save` keeps replicates as they are done, and takes up what is kept there.
"""

from __future__ import annotations

import argparse
import json
import math
import time
from concurrent.futures import Executor
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from pmmkit.identification import FreeRecord, Prior, identify
from pmmkit.identification.posterior.density import DEGREES, ROUGHNESS
from pmmkit.models import load_model
from pmmkit.plotting import REFERENCE, Figure, colour
from scripts.studies.workers import add_workers, as_done, crew
from tests.support.free_tank.flow import Motion
from tests.support.free_tank.hidden import NOTHING
from tests.support.free_tank.tanker import BODY, IZZ, JZ, MASS, MY, XG, Tanker

SHIP, SPEED = "kvlcc2-l7", 1.179
NAMES = ("Yv", "Yr", "Nv", "Nr")
SPREAD = 0.2
SENSORS = {"x": 0.02, "y": 0.02, "psi": math.radians(0.1), "r": math.radians(0.05)}
INTERVAL, INSTANTS, FINE = 0.6, 45, 12
"""Seconds between instants, instants of a record, steps of the tank between them."""
RUDDERS = ((0, 20, 20, -20, -20, -20, 15, 15, 0, 0), (0, -10, -10, -25, -25, 10, 25, 25, 0, -10))
"""Rudder angles [deg] of the two records, evenly over their length, straight lines between."""
DRAWN = 99
BINS = 10
METHODS = ("posterior", "ekf", "trajectory")


@dataclass(frozen=True)
class Varied(Tanker):
    """The tanker of the tank with more of Yv, Yr, Nv and Nr, a column for each run."""

    more: np.ndarray = None

    def accelerations(
        self, now: Motion, delta: np.ndarray, n: np.ndarray, blows: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
        surge, sway, yaw, roll = super().accelerations(now, delta, n, blows)
        U, L = now.speed, BODY.L
        unit = 0.5 * BODY.rho * L * BODY.d
        v, r = now.v / U, now.r * L / U
        forces = unit * U**2 * np.stack([self.more[0] * v + self.more[1] * r] * 2)
        forces[1] = unit * U**2 * L * (self.more[2] * v + self.more[3] * r)
        whole = np.array([[MASS + MY * unit * L, XG * MASS], [XG * MASS, IZZ + JZ * unit * L**3]])
        gain = np.linalg.solve(whole, forces)
        return surge, sway + gain[0], yaw + gain[1], roll


def truth_of(seed: int) -> dict[str, Any]:
    """What is drawn from the priors: values, process noise, factor of the sensors."""
    rng = np.random.default_rng([seed, 101])
    prior = Prior.of(load_model(SHIP), NAMES, SPEED, spread=SPREAD)
    return {
        "values": prior.mean + prior.std * rng.standard_normal(len(NAMES)),
        "process_noise": float(rng.exponential(ROUGHNESS)),
        "sensor_scale": float(np.sqrt(DEGREES / rng.chisquare(DEGREES))),
    }


def sailed(seed: int, truth: dict[str, Any]) -> list[FreeRecord]:
    """The records of a replicate: steps of Runge and Kutta, a kick of white noise after each."""
    rng = np.random.default_rng([seed, 102])
    more = truth["values"] - Prior.of(load_model(SHIP), NAMES, SPEED).mean
    runs, L = len(RUDDERS), BODY.L
    ship = Varied(NOTHING, more=np.repeat(more[:, None], runs, axis=1))
    n = ship.revolutions(np.full(runs, SPEED))
    t = INTERVAL * np.arange(INSTANTS)
    delta = np.radians(
        [np.interp(t, np.linspace(0.0, t[-1], len(angles)), angles) for angles in RUDDERS]
    )
    state = np.zeros((6, runs))
    state[:3] = [[1.0], [1.0], [0.1]] * rng.standard_normal((3, runs))
    state[3:] = [[0.02], [0.03], [0.03 / L]] * rng.standard_normal((3, runs)) * SPEED
    state[3] += SPEED
    rough = truth["sensor_scale"] * truth["process_noise"] * SPEED**2 / L * math.sqrt(L / SPEED)
    kick = np.array([0.0, 0.0, 0.0, rough, rough, rough / L])[:, None]
    step, states = INTERVAL / FINE, [state]
    calm = np.zeros((4, runs))

    def change(state: np.ndarray, rudder: np.ndarray) -> np.ndarray:
        _, _, psi, u, v, r = state
        zero = np.zeros(runs)
        now = Motion(u, v, r, psi, zero, zero, zero, zero, zero)
        surge, sway, yaw, _ = ship.accelerations(now, rudder, n, calm)
        ahead, aside = np.cos(psi), np.sin(psi)
        return np.stack([u * ahead - v * aside, u * aside + v * ahead, r, surge, sway, yaw])

    for k in range(INSTANTS - 1):
        for i in range(FINE):
            at = [
                delta[:, k] + (delta[:, k + 1] - delta[:, k]) * (i + x) / FINE for x in (0, 0.5, 1)
            ]
            a = change(state, at[0])
            b = change(state + 0.5 * step * a, at[1])
            c = change(state + 0.5 * step * b, at[1])
            d = change(state + step * c, at[2])
            state = state + step / 6.0 * (a + 2.0 * b + 2.0 * c + d)
            state = state + kick * math.sqrt(step) * rng.standard_normal((6, runs))
        states.append(state)
    whole = np.stack(states)
    place = {"x": 0, "y": 1, "psi": 2, "r": 5}
    return [
        FreeRecord(
            name=f"record {run + 1}",
            t=t,
            delta=delta[run],
            turns=np.full(INSTANTS, float(n[run])),
            speed=SPEED,
            measured={
                name: whole[:, place[name], run]
                + truth["sensor_scale"] * std * rng.standard_normal(INSTANTS)
                for name, std in SENSORS.items()
            },
        )
        for run in range(runs)
    ]


def replicate(seed: int) -> dict[str, Any]:
    """One ship, its records, and what each method makes of them."""
    began = time.process_time()
    truth = truth_of(seed)
    records = sailed(seed, truth)
    model = load_model(SHIP)
    prior = Prior.of(model, NAMES, SPEED, spread=SPREAD)
    found: dict[str, Any] = {"seed": seed, "z": {}, "std": {}}
    for method in METHODS:
        settings = {"seed": seed} if method == "posterior" else {}
        told = identify(model, records, method=method, prior=prior, sensors=SENSORS, **settings)
        found["z"][method] = ((told.values - truth["values"]) / told.std).tolist()
        found["std"][method] = (told.std / prior.std).tolist()
        if method == "posterior":
            found |= ranked(told.detail, truth, seed)
            found["evaluations"] = told.detail.ensembles * told.detail.walkers * told.detail.steps
    return {**found, "seconds": time.process_time() - began}


def ranked(detail: Any, truth: dict[str, Any], seed: int) -> dict[str, Any]:
    """Ranks of the truth among draws, whether intervals hold it, and how the sampler did."""
    data = detail.tree["posterior"].to_dataset()
    right = dict(zip(NAMES, truth["values"].tolist(), strict=True)) | {
        name: truth[name] for name in ("process_noise", "sensor_scale")
    }
    order = np.random.default_rng([seed, 103]).permutation(data["Yv"].size)[:DRAWN]
    flat = {name: data[name].to_numpy().ravel() for name in right}
    return {
        "ranks": {name: int(np.sum(flat[name][order] < x)) for name, x in right.items()},
        "held": {
            name: bool(detail.quantiles[name][0] <= x <= detail.quantiles[name][2])
            for name, x in right.items()
        },
        "converged": detail.converged,
        "r_hat": float(np.max(detail.convergence.r_hat)),
        "ess": detail.convergence.least,
        "draws": int(data["Yv"].size),
    }


def study(
    replicates: int, executor: Executor | int | None, first: int, save: Path | None
) -> list[dict[str, Any]]:
    """All replicates; those that are kept in a file are not done again."""
    kept = {}
    if save is not None and save.is_file():
        kept = {item["seed"]: item for item in map(json.loads, save.read_text().splitlines())}
    asked = [seed for seed in range(first, first + replicates) if seed not in kept]
    for _, item in as_done(replicate, asked, executor):
        kept[item["seed"]] = item
        if save is not None:
            with save.open("a") as file:
                file.write(json.dumps(item) + "\n")
    return [kept[seed] for seed in sorted(kept) if first <= seed < first + replicates]


def report(found: list[dict[str, Any]]) -> str:
    """Ranks with their χ², then the intervals of all methods, then what it took."""
    from scipy.stats import binom, chi2

    n = len(found)
    low, high = binom.ppf([0.005, 0.995], n, 1.0 / BINS)
    lines = [
        f"{n} replicates, ranks among {DRAWN} draws in {BINS} bins of {n / BINS:g}; 99 % of bins "
        f"hold {low:.0f} to {high:.0f}",
        f"{'':14}{'ranks in bins':42}{'chi2':>6}{'p':>7}  95 % held",
    ]
    for name in found[0]["ranks"]:
        counts = histogram(found, name)
        size = float(np.sum((counts - n / BINS) ** 2) / (n / BINS))
        held = np.mean([item["held"][name] for item in found])
        cells = "".join(f"{x:4d}" for x in counts)
        p = chi2.sf(size, BINS - 1)
        lines.append(f"{name:14}{cells:42}{size:6.1f}{p:7.2f}  {100 * held:.0f} %")
    lines += ["", f"{'':14}{'held by 1.96 std':>18}{'rms error / std':>18}{'std / prior':>14}"]
    for method in METHODS:
        z = np.array([item["z"][method] for item in found])
        std = np.array([item["std"][method] for item in found])
        lines.append(
            f"{method:14}{100 * np.mean(np.abs(z) < 1.96):16.1f} %{np.sqrt(np.mean(z**2)):18.2f}"
            f"{np.median(std):14.3f}"
        )
    lines += [
        "",
        f"converged {sum(item['converged'] for item in found)} of {n}; R-hat at most "
        f"{max(item['r_hat'] for item in found):.4f}, effective sample size at least "
        f"{min(item['ess'] for item in found):.0f}, median "
        f"{np.median([item['ess'] for item in found]):.0f}; evaluations, median "
        f"{np.median([item['evaluations'] for item in found]):.0f}; processor time of a replicate, "
        f"median {np.median([item['seconds'] for item in found]):.1f} s, all "
        f"{sum(item['seconds'] for item in found):.0f} s",
    ]
    return "\n".join(lines)


def histogram(found: list[dict[str, Any]], name: str) -> np.ndarray:
    """Replicates in each bin of the ranks."""
    ranks = np.array([item["ranks"][name] for item in found])
    return np.bincount(ranks * BINS // (DRAWN + 1), minlength=BINS)


def drawn(found: list[dict[str, Any]]) -> Figure:
    """Histograms of the ranks with the band that 99 % of the bins of a right posterior keep."""
    from scipy.stats import binom

    n = len(found)
    low, high = binom.ppf([0.005, 0.995], n, 1.0 / BINS)
    figure = Figure(height=3.4, width=7.2)
    axes = figure.subplots(2, 3, sharey=True)
    for axis, name in zip(axes.ravel(), found[0]["ranks"], strict=True):
        axis.axhspan(low, high, color="#e6e6e6")
        axis.axhline(n / BINS, color=REFERENCE, lw=0.8)
        axis.bar(np.arange(BINS) + 0.5, histogram(found, name), width=0.9, color=colour(0))
        axis.set_title(name.replace("_", " "))
        axis.set_xticks([0, BINS], ["0", str(DRAWN)])
    for axis in axes[:, 0]:
        axis.set_ylabel("replicates")
    for axis in axes[1]:
        axis.set_xlabel("rank of the truth")
    return figure


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--replicates", type=int, default=100)
    add_workers(parser, usual=1)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--save", type=Path)
    parser.add_argument("--figure", type=Path)
    options = parser.parse_args()
    with crew(options) as executor:
        found = study(options.replicates, executor, options.seed, options.save)
    print(report(found))
    if options.figure is not None:
        drawn(found).save(options.figure)


if __name__ == "__main__":
    main()
