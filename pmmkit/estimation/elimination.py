"""Terms left out one by one, as long as an information criterion falls."""

from __future__ import annotations

from functools import cache
from typing import Any

import numpy as np

from pmmkit.numerics import Array


class Elimination:
    """Stepwise sparse regression of pysindy, stopped by the Bayesian information criterion.

    pysindy's SSR leaves out the term whose loss raises the misfit least, again and again
    (Boninsegna, Nüske and Clementi 2018). Unlike a threshold on the size of a term it sees that
    of several like terms one will do, however large their coefficients are against each other.
    Of the sets on its way the one with the least ``misfit + terms log(n)`` is taken (Schwarz
    1978), for equations whose errors have unit variance.

    Parameters
    ----------
    independent : float
        Independent measurements n behind the equations.

    Examples
    --------
    >>> rng = np.random.default_rng(0)
    >>> v = rng.uniform(-1, 1, 200)
    >>> x = np.stack([v, v**3, v * np.abs(v)], axis=1)
    >>> y = 50 * v - 40 * v**3 + rng.normal(size=200)
    >>> Elimination(200).fit(x, y[:, None]).coef_.round().ravel()
    array([ 50., -41.,   0.])
    """

    def __init__(self, independent: float) -> None:
        self.penalty = float(np.log(max(independent, 2.0)))
        self.coef_: Array = np.zeros((1, 0))

    def fit(self, x_: Array, y: Array) -> Elimination:
        """Fit one target (n, 1) on a library (n, m)."""
        count = x_.shape[1]
        found = [_solved(x_, y), np.zeros((1, count))]
        if count > 1:
            ssr = _stepwise()(
                criteria="model_residual", alpha=0.0, kappa=0.0, max_iter=count, unbias=False
            ).fit(x_, y)
            # pysindy 2.1 overwrites the first entry of its history, the fit with all terms
            found += [np.array(coefficients) for coefficients in ssr.history_[1:]]
        score = [
            float(np.sum((y - x_ @ own.T) ** 2)) + self.penalty * np.count_nonzero(own)
            for own in found
        ]
        self.coef_ = found[int(np.argmin(score))]
        return self


def _solved(x: Array, y: Array) -> Array:
    """Least squares of one target, array (1, m)."""
    return np.asarray(np.linalg.lstsq(x, y.reshape(-1, 1), rcond=None)[0].T)


@cache
def _stepwise() -> Any:
    """pysindy's SSR without the ridge that it solves by scikit-learn: ten times faster."""
    from pysindy.optimizers import SSR

    class Stepwise(SSR):  # type: ignore[misc]  # pysindy has no types
        def _regress(self, x: Array, y: Array) -> Array:
            self.iters += 1
            return _solved(x, y)

    return Stepwise
