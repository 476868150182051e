"""Terms that move together: what no regression on these records can tell apart."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from pmmkit.identification.prior import ALIKE
from pmmkit.inference import RANK_TOLERANCE, Equations
from pmmkit.numerics import Array

INFLATED: Final = 10.0
"""Variance inflation from which a term is named."""
ILL: Final = 30.0
"""Condition number of the columns of unit length from which it is named (Belsley 1980)."""


@dataclass(frozen=True, kw_only=True)
class Collinearity:
    """How far the terms of a library can be told apart on some records.

    `pairs`: terms whose columns are alike: the cosine of the angle between them, largest first.
    `inflation`: by how much the variance of each coefficient is larger than if its column stood
    at right angles to all others. `mixtures`: for terms with a large inflation, the terms that
    mimic them most. `condition`: condition number of the columns of unit length, by the
    channels solved together.

    Examples
    --------
    >>> v = np.linspace(-.3, .3, 50)
    >>> X = np.stack([v, v * np.abs(v), v**3], axis=1)
    >>> found = Collinearity.of(Equations.of((X, v)), ["Yv", "Yv|v|", "Yvvv"], ["Y"])
    >>> found.pairs[0][:2], round(found.condition["Y"])
    (('Yv|v|', 'Yvvv'), 51)
    """

    pairs: tuple[tuple[str, str, float], ...]
    inflation: Mapping[str, float]
    mixtures: Mapping[str, tuple[str, ...]]
    condition: Mapping[str, float]

    @classmethod
    def of(
        cls, equations: Equations, names: Sequence[str], channels: Sequence[str]
    ) -> Collinearity:
        """From the scaled columns of all runs."""
        X, _, _ = equations.scaled
        columns = X / np.linalg.norm(X, axis=0)
        cosines = columns.T @ columns
        singular = np.linalg.svd(columns, compute_uv=False)
        inverse = np.linalg.inv(np.linalg.qr(columns, mode="r"))
        inflation = np.sum(inverse**2, axis=1)
        order = [
            (i, j)
            for i in range(len(names))
            for j in range(i + 1, len(names))
            if abs(cosines[i, j]) > ALIKE
        ]
        order.sort(key=lambda pair: -abs(cosines[pair]))
        return cls(
            pairs=tuple((names[i], names[j], float(cosines[i, j])) for i, j in order),
            inflation=dict(zip(names, inflation.tolist(), strict=True)),
            mixtures={
                names[i]: _mimics(columns, i, names)
                for i in np.flatnonzero(inflation > INFLATED).tolist()
            },
            condition={", ".join(channels): float(singular[0] / singular[-1])},
        )

    @classmethod
    def joined(cls, reports: Sequence[Collinearity]) -> Collinearity:
        """Of several systems as one."""
        return cls(
            pairs=tuple(pair for report in reports for pair in report.pairs),
            inflation={k: x for report in reports for k, x in report.inflation.items()},
            mixtures={k: x for report in reports for k, x in report.mixtures.items()},
            condition={k: x for report in reports for k, x in report.condition.items()},
        )

    @property
    def warnings(self) -> tuple[str, ...]:
        """What a user must know before trusting the terms, in words with numbers."""
        said = [
            f"{a} and {b} move together on these records (cosine {cosine:.3f}, variance "
            f"inflation {self.inflation[a]:.3g} and {self.inflation[b]:.3g}): either can stand "
            f"for the other. Leave one out, put them in a group, or add runs of other amplitudes."
            for a, b, cosine in self.pairs
        ]
        paired = {name for a, b, _ in self.pairs for name in (a, b)}
        said += [
            f"{name} is close to a mixture of {', '.join(others)} on these records (variance "
            f"inflation {self.inflation[name]:.3g}): add runs that excite it alone, or hold one."
            for name, others in self.mixtures.items()
            if name not in paired
        ]
        said += [
            f"The terms of {channels} are hard to tell apart: condition number {number:.3g} of "
            f"the scaled columns (above {ILL:g} is much)."
            for channels, number in self.condition.items()
            if number > ILL
        ]
        return tuple(said)


def _mimics(columns: Array, place: int, names: Sequence[str]) -> tuple[str, ...]:
    """Terms with at least a fifth of the largest part in the mixture nearest to a column."""
    others = [j for j in range(len(names)) if j != place]
    parts = np.abs(np.linalg.lstsq(columns[:, others], columns[:, place], rcond=RANK_TOLERANCE)[0])
    order = np.argsort(-parts)
    return tuple(names[others[j]] for j in order if parts[j] > 0.2 * parts.max())
