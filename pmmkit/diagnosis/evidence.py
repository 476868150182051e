"""Evidence and coverage, as captive tests and free-running records both give them."""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Container, Mapping, Sequence
from dataclasses import dataclass
from typing import Final, Literal, Protocol

import numpy as np
from numpy.typing import NDArray

from pmmkit.effects import CATALOGUE, Effect
from pmmkit.numerics import Array

PRICE: Final = math.log(80.0)
"""ln of the odds before any test against one entry of the catalogue: of some forty that can be
asked, one is missing in every second ship. It is the same whatever else is asked, so that the odds
of an effect do not hang on how many others the catalogue holds. scripts/studies/hidden_effects.py:
at ln 62 and more nothing is named in 160 empty campaigns, and 27 of 29 effects alone."""
RIVALS: Final = math.log(20.0)
"""Answers within these odds of the best cannot be told from it (docs/theory/evidence.md); more is
strong evidence (Kass and Raftery 1995, section 3.2)."""
DECISIVE: Final = math.log(150.0)
"""Odds from which evidence is very strong (Kass and Raftery 1995, section 3.2)."""
REMOVES: Final = 0.005
"""Share of the misfit from which a page does not show 0 %: an effect that is not named and takes
less away does not help."""
SHOWS: Final = 12.0
"""Squared signal over noise at its usual size from which an effect can be seen, whichever run is
left out."""
LEAST: Final = 1.0
"""Least ln evidence of a finding, `PRICE` taken off, without its best run too. With the price alone
two more of 84 effects at .3 of the usual size are named, but the fifth step of the S175 programme
is a misalignment that she has not."""
FOUND: Final = 0.95
"""Share of campaigns in which an effect larger than what could hide is found."""
DRAWS: Final = 1000
"""Draws of noise from which that size is told; it stands within 2 %."""
MIMICS: Final = 0.6
"""Share of a signature from which another effect is called its mimic."""
REPRODUCES: Final = 1e-9
"""Share of the largest eigenvalue of the products of an effect's columns below which a direction
is rounding: columns that are alike to 3e-5."""


ROUNDING: Final = 1e-6
"""Signal below which an effect is told from the base by rounding alone."""


def could_hide(
    information: Array, usual: Array, centre: Array | None = None, price: float = PRICE + LEAST
) -> float:
    """Share of its usual size from which an effect is found in `FOUND` of campaigns.

    information (k, k): products of its columns in units of the prior, all else projected off; or
    the diagonal (k,) of columns that have nothing in common. usual, centre (k,): coefficients at
    the usual size, and as they are expected, in the same units. Infinite where nothing shows it.

    Notes
    -----
    With λ the squared signals along the eigenvectors, a the usual and c the expected coefficients
    there, s the share of the usual size and z ~ N(0, 1), the score is b = λ a s + √λ z and ln E =
    bc - ½ λ c² + ½ (b - λ c)²/(1 + λ) - ½ ln(1 + λ), summed: a parabola in s, and each draw of z is
    found from its root on.
    """
    lam, a, c = information, usual, np.zeros(len(usual)) if centre is None else centre
    if information.ndim > 1:
        lam, vectors = np.linalg.eigh(information)
        a, c = vectors.T @ a, vectors.T @ c
    lam = np.maximum(lam, 0.0)
    if float(lam @ a**2) <= ROUNDING:
        return math.inf
    noise = np.sqrt(lam) * np.random.default_rng(0).standard_normal((DRAWS, len(lam)))
    rest = noise - lam * c
    grown = 0.5 * float(lam**2 / (1.0 + lam) @ a**2)
    slope = (lam * a * c).sum() + rest @ (lam * a / (1.0 + lam))
    level = noise @ c - 0.5 * float(lam @ c**2) + 0.5 * rest**2 @ (1.0 / (1.0 + lam))
    lacks = price + 0.5 * float(np.log1p(lam).sum()) - level
    root = (np.sqrt(slope**2 + 4.0 * grown * np.maximum(lacks, 0.0)) - slope) / (2.0 * grown)
    return float(np.quantile(np.where(lacks > 0.0, root, 0.0), FOUND))


def mimics(
    information: Array, across: Array, signals: Array, others: Mapping[str, NDArray[np.intp]]
) -> list[dict[str, float]]:
    """Effects that reproduce most of each of n signatures, with the share; the best first.

    information (q, q); across (q, n); signals (n,).
    """
    shares = {}
    for name, at in others.items():
        own = across[at]
        coefficients = np.linalg.lstsq(information[np.ix_(at, at)], own, rcond=REPRODUCES)[0]
        shares[name] = np.minimum(np.sum(own * coefficients, axis=0) / signals, 1.0).tolist()
    found = []
    for k in range(len(signals)):
        most = sorted(others, key=lambda name: -shares[name][k])
        found.append({name: shares[name][k] for name in most if shares[name][k] >= MIMICS})
    return found


Weight = Literal["decisive", "likely", "cannot be told", "does not help"]


def weight(log_odds: float, share: float = math.nan) -> Weight:
    """Evidence in words. share: of the held-out misfit that goes; NaN where that does not matter.

    Examples
    --------
    >>> weight(6.0), weight(4.0), weight(-2.0), weight(-4.0), weight(6.0, 0.001)
    ('decisive', 'likely', 'cannot be told', 'does not help', 'does not help')
    """
    if share < REMOVES or log_odds < -RIVALS:
        return "does not help"
    if log_odds > DECISIVE:
        return "decisive"
    return "likely" if log_odds > RIVALS else "cannot be told"


class Ranked(Protocol):
    """A set of effects with its ln evidence against no effect."""

    @property
    def names(self) -> tuple[str, ...]:
        """Of its effects."""
        ...

    @property
    def log_evidence(self) -> float:
        """Less the price of each effect."""
        ...


def with_or_without(name: str, entries: Sequence[Ranked]) -> float:
    """ln odds of the best set with an effect against the best one without it, or no effect."""
    known = [x for x in entries if not math.isnan(x.log_evidence)]
    own = max((x.log_evidence for x in known if name in x.names), default=-math.inf)
    return own - max([0.0, *(x.log_evidence for x in known if name not in x.names)])


def weight_of(
    name: str, entries: Sequence[Ranked], best: Collection[str], share: float = math.nan
) -> Weight:
    """Evidence for an effect among sets in words; of one that is not named, `share` of the held-out
    misfit goes with it."""
    return weight(with_or_without(name, entries), math.nan if name in best else share)


def finite(value: float) -> float | None:
    """A number for plain data, which knows no infinity."""
    return value if math.isfinite(value) else None


@dataclass(frozen=True, kw_only=True)
class RankedSet:
    """A set of effects with its evidence.

    `log_evidence`: against no effect, averaged over the grids, less `PRICE` for each. `values`:
    best grid value of each. `terms`: number of coefficients that each has in its best form;
    empty where effects have one form.
    """

    names: tuple[str, ...]
    log_evidence: float
    values: tuple[float, ...]
    terms: tuple[int, ...] = ()


@dataclass(frozen=True, kw_only=True)
class Visible:
    """What the runs could show of one effect.

    `signal`: squared signal over noise at its usual size, what the base can absorb taken off.
    `without_a_run`: the same without the run that shows most of it. `hides`: share of the usual
    size that could hide. `shown`: whether these runs can show it. `why`: why not, in words.
    `mimics`: effects that can stand for it, with the share of its signature that they
    reproduce.
    """

    name: str
    family: str
    signal: float
    without_a_run: float
    hides: float
    shown: bool
    why: str
    mimics: Mapping[str, float]


def not_held(name: str, family: str, why: str) -> Visible:
    """An effect for which the tests hold nothing."""
    return Visible(
        name=name,
        family=family,
        signal=0.0,
        without_a_run=0.0,
        hides=math.inf,
        shown=False,
        why=why,
        mimics={},
    )


def not_asked(done: Container[str], why: Callable[[Effect], str]) -> dict[str, str]:
    """The catalogue without what was asked and what the base has, with the reason of each entry."""
    return {
        name: why(effect) or why_no_size(effect)
        for name, effect in CATALOGUE.items()
        if name not in done
    }


def why_no_size(effect: Effect) -> str:
    """Why no tests are asked for an entry that has no size of its own."""
    if effect.faulty:
        return "the checks of the runs look for it: pmmkit check"
    return "a part of the model, not a size: pmmkit compare shows where it fails"


def integrated_out(inner: Array, across: Array, rest: Array) -> tuple[Array, Array]:
    """Products of columns beside others whose coefficients are integrated out.

    inner (…, k, k): products of those that go, in units of their prior standard deviation about
    zero; across (…, k, p): theirs with those that stay, the data among these; rest (…, p, p): of
    those. Also by how much ln det of the covariance of the data grows, that of ``1 + inner`` (…).

    Examples
    --------
    >>> products, volume = integrated_out(np.array([[3.0]]), np.array([[2.0]]), np.array([[5.0]]))
    >>> products, round(float(np.exp(volume)), 12)
    (array([[4.]]), 4.0)
    """
    k, p = across.shape[-2:]
    whole = np.zeros((*inner.shape[:-2], k + p, k + p))
    whole[..., :k, :k] = inner
    whole[..., k:, :k] = np.swapaxes(across, -1, -2)
    # One decomposition makes both; below stands what keeps it positive whatever is across.
    diagonal = np.einsum("...ii->...i", whole)
    diagonal[..., :k] += 1.0
    diagonal[..., k:] = 1.0 + p * np.square(across).sum(axis=-2)
    lower = np.linalg.cholesky(whole)
    taken = lower[..., k:, :k]
    volume = 2.0 * np.log(np.diagonal(lower, axis1=-2, axis2=-1)[..., :k]).sum(axis=-1)
    return rest - taken @ np.swapaxes(taken, -1, -2), np.asarray(volume, float)
