"""How often chance alone gives an effect so good."""

from __future__ import annotations

import numpy as np

from pmmkit.diagnosis.free_running.hypotheses import Screen


def chance_of(found: Screen, best: float, *, draws: int = 4000, seed: int = 0) -> float:
    """Probability that records without any effect give a single candidate so good.

    Parameters
    ----------
    found : Screen
        The linear problem.
    best : float
        ln evidence of what is in front, no price taken off.
    draws, seed : int
        Number of drawn records, and of the draws.
    """
    sizes, vectors = np.linalg.eigh(found.gram)
    root = vectors * np.sqrt(np.maximum(sizes, 0.0))
    h = np.random.default_rng(seed).normal(size=(draws, len(sizes))) @ root.T
    reached = np.full(draws, -np.inf)
    for at in found.columns.values():
        H = np.eye(len(at)) + found.gram[np.ix_(at, at)]
        own = h[:, at]
        value = 0.5 * np.sum(own * np.linalg.solve(H, own.T).T, axis=1)
        reached = np.maximum(reached, value - 0.5 * float(np.linalg.slogdet(H)[1]))
    return float((np.sum(reached >= best) + 1) / (draws + 1))
