"""What a filter did not expect: its likelihood, and whether its size and whiteness are right."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType
from typing import TYPE_CHECKING, Final

import numpy as np
from numpy.typing import NDArray

from pmmkit.base import DataError
from pmmkit.numerics import Array

if TYPE_CHECKING:
    import pandas as pd

FEWEST: Final = 30
"""Samples of a channel below which nothing is said of it."""
LARGE: Final = 1.25
"""Innovations are called too large (too small) from this ratio to what the filter thinks."""
CERTAIN: Final = 0.01
"""Probability below which a test speaks."""
TIED: Final = 0.1
"""Autocorrelation from which innovations are said to hang together; large records make smaller
ones significant that harm nothing."""
LEANING: Final = 0.2
"""Mean over standard deviation from which innovations are said to lean to one side."""
GATED: Final = 0.01
"""Share of measurements beyond the gate from which it is said."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Innovations:
    """What a filter did not expect, per record and channel.

    Parameters
    ----------
    names : tuple of str
        Channels.
    residuals, variances : array (n, c)
        Measured less predicted, and the variance the filter gave it; NaN where nothing was.
    gate : float
        Residuals beyond so many standard deviations were not taken in.

    Examples
    --------
    >>> item = Innovations(names=("psi",), residuals=np.array([[2.0], [np.nan], [40.0]]),
    ...                    variances=np.full((3, 1), 4.0), gate=5.0)
    >>> item.gated.ravel()
    array([False, False,  True])
    >>> round(item.log_likelihood(), 6)
    -16.224171
    """

    names: tuple[str, ...]
    residuals: Array
    variances: Array
    gate: float = math.inf

    @property
    def squares(self) -> Array:
        """Residuals squared over their variance, array (n, c)."""
        return np.asarray(self.residuals**2 / self.variances)

    @property
    def gated(self) -> NDArray[np.bool_]:
        """Residuals that were not taken in, array (n, c)."""
        return np.asarray(self.residuals**2 > self.gate**2 * self.variances)

    @property
    def normalised(self) -> Array:
        """Residuals over their standard deviation, gated ones left out."""
        values = self.residuals / np.sqrt(self.variances)
        return np.where(self.gated, np.nan, values)

    def autocorrelation(self, name: str, lags: int) -> tuple[Array, NDArray[np.int64]]:
        """Of a channel, at lags of 1 and more, and the pairs behind each."""
        return autocorrelation([self.normalised[:, self.names.index(name)]], lags)

    @property
    def volume(self) -> float:
        """Sum of the logarithms of the variances, where something was measured."""
        return float(np.sum(np.log(self.variances[np.isfinite(self.residuals)])))

    def log_likelihood(self) -> float:
        """ln of the density of what was measured (prediction error decomposition; Harvey 1989).

        A residual beyond the gate counts as one at the gate, so that the likelihood has no step
        where one comes to lie beyond it.
        """
        squares = np.minimum(self.squares, self.gate**2)
        count = np.count_nonzero(np.isfinite(self.residuals))
        return float(-0.5 * (np.nansum(squares) + self.volume + count * math.log(2.0 * math.pi)))


@dataclass(frozen=True, kw_only=True, eq=False)
class ChannelTest:
    """Tests of the innovations of one channel.

    `samples`: innovations that were taken in. `nis`: mean of the squared innovations over the
    variance that the filter gave them; 1 is right. `band`: in which it lies in 95 of 100 cases
    if the filter is right. `mean`: mean innovation over its standard deviation; 0 is right.
    `correlation (lags,)`: autocorrelation from one sample to the next and further. `p_white`:
    probability of such correlations if the innovations are white (Ljung and Box 1978). `gated`:
    share of the measurements that were not taken in.
    """

    channel: str
    samples: int
    nis: float
    band: tuple[float, float]
    mean: float
    correlation: Array
    p_white: float
    gated: float

    @property
    def size(self) -> float:
        """How many times as large as the filter thinks."""
        return math.sqrt(self.nis)

    @property
    def tied(self) -> float:
        """The largest autocorrelation, with its sign."""
        return float(self.correlation[int(np.argmax(np.abs(self.correlation)))])

    def faults(self) -> dict[str, str]:
        """What is wrong with it: kind of fault and the number that shows it."""
        found = {}
        if self.nis > self.band[1] and self.size > LARGE:
            found["large"] = f"{self.size:.2g}"
        if self.nis < self.band[0] and self.size < 1.0 / LARGE:
            found["small"] = f"{self.size:.2g}"
        if self.p_white < CERTAIN and abs(self.tied) > TIED:
            found["tied"] = f"{self.tied:+.2f}"
        certain = 2.58 * math.sqrt(max(self.nis, 1e-300) / self.samples)
        if abs(self.mean) > certain and abs(self.mean) > LEANING:
            found["leaning"] = f"{self.mean:+.2f}"
        if self.gated > GATED:
            found["gated"] = f"{100 * self.gated:.1f}"
        return found


_WORDS: Final = {
    "large": "innovations are {} times as large as the filter thinks: the model lacks something, "
    "or the sensor is worse than stated; intervals that count on neither are too narrow.",
    "small": "innovations are only {} times as large as the filter thinks: the sensor is better "
    "than stated, or the process noise too large.",
    "tied": "innovations are not white (correlation {}): errors of the model or of the sensor last "
    "for several samples; intervals that do not allow for it are too narrow.",
    "leaning": "innovations lean to one side by {} of their standard deviation: a zero that is "
    "off, a current, or an asymmetry that the model lacks.",
    "gated": "{} % of the measurements were not taken in: outliers, or a record that should be "
    "cut.",
}
"""What the faults of channels mean."""


def _listed(parts: Sequence[str]) -> str:
    return " and ".join(filter(None, (", ".join(parts[:-1]), parts[-1])))


@dataclass(frozen=True, kw_only=True, eq=False)
class Consistency:
    """Tests of all innovations of a filter.

    Parameters
    ----------
    channels : mapping of str to ChannelTest
        By channel, over all records.
    records : mapping of str to mapping of str to ChannelTest
        By record and channel.
    few : tuple of str
        Channels with too few samples to be judged.
    """

    channels: Mapping[str, ChannelTest]
    records: Mapping[str, Mapping[str, ChannelTest]]
    few: tuple[str, ...]

    @classmethod
    def of(cls, innovations: Mapping[str, Innovations], *, lags: int = 20) -> Consistency:
        """Test whether innovations are as large as their filter thinks, and white.

        Parameters
        ----------
        innovations : mapping of str to Innovations
            By record.
        lags : int
            Samples over which correlations are looked for.

        Raises
        ------
        DataError
            If `lags` is not positive.

        Examples
        --------
        >>> noise = np.random.default_rng(0).normal(size=(2000, 2))
        >>> slow = np.convolve(noise[:, 1], np.ones(5) / 5**0.5, "same")
        >>> item = Innovations(
        ...     names=("psi", "x"), residuals=np.stack([3.1 * noise[:, 0], slow], axis=1),
        ...     variances=np.ones((2000, 2)))
        >>> for text in Consistency.of({"zigzag": item}).words():
        ...     print(text.partition(": the")[0].partition(": errors")[0])
        psi: innovations are 3.1 times as large as the filter thinks
        x: innovations are not white (correlation +0.79)
        """
        if lags < 1:
            raise DataError(f"lags = {lags}: at least one sample is needed.")
        names = tuple(dict.fromkeys(name for item in innovations.values() for name in item.names))
        pooled = {
            name: _channel(
                name, [item for item in innovations.values() if name in item.names], lags
            )
            for name in names
        }
        own = {
            record: {
                name: test
                for name in item.names
                if (test := _channel(name, [item], lags)) is not None
            }
            for record, item in innovations.items()
        }
        return cls(
            channels=MappingProxyType({name: test for name, test in pooled.items() if test}),
            records=MappingProxyType({name: MappingProxyType(item) for name, item in own.items()}),
            few=tuple(name for name, test in pooled.items() if test is None),
        )

    def words(self) -> tuple[str, ...]:
        """What is wrong, in words; one line that says so where nothing is."""
        said = []
        for kind, text in _WORDS.items():
            faults = {
                name: number
                for name, item in self.channels.items()
                if (number := item.faults().get(kind))
            }
            if faults:
                numbers = _listed(list(faults.values()))
                said.append(f"{_listed(list(faults))}: {text.format(numbers)}")
        said += [f"{name}: too few samples to judge." for name in self.few]
        if not said:
            said.append("Innovations are as large as the filter thinks, and white.")
        return tuple(said)

    def to_pandas(self) -> pd.DataFrame:
        """A row per channel over all records (``all``), then per record and channel."""
        import pandas as pd

        rows = [
            {
                "record": record,
                "channel": item.channel,
                "samples": item.samples,
                "nis": item.nis,
                "nis_low": item.band[0],
                "nis_high": item.band[1],
                "mean": item.mean,
                "correlation_1": float(item.correlation[0]),
                "p_white": item.p_white,
                "gated": item.gated,
            }
            for record, own in (("all", self.channels), *self.records.items())
            for item in own.values()
        ]
        return pd.DataFrame(rows)


def autocorrelation(series: Iterable[Array], lags: int) -> tuple[Array, NDArray[np.int64]]:
    """Autocorrelation at lags of 1 and more, and the pairs behind each.

    Evenly sampled series, NaN in gaps; pairs are made within each.

    Examples
    --------
    >>> correlation, pairs = autocorrelation([np.array([1.0, -1.0, 1.0, -1.0])], 2)
    >>> correlation, pairs
    (array([-1.,  1.]), array([3, 2]))
    """
    parts = [np.asarray(item, float) for item in series]
    middle = np.nanmean(np.concatenate(parts))
    centred = [item - middle for item in parts]
    variance = np.nanmean(np.concatenate(centred) ** 2)
    sums, pairs = np.zeros(lags), np.zeros(lags, np.int64)
    for item in centred:
        for lag in range(1, min(lags, len(item) - 1) + 1):
            products = item[lag:] * item[:-lag]
            sums[lag - 1] += np.nansum(products)
            pairs[lag - 1] += int(np.isfinite(products).sum())
    return sums / np.maximum(pairs, 1) / max(variance, 1e-300), pairs


def _channel(name: str, items: Sequence[Innovations], lags: int) -> ChannelTest | None:
    """The tests of a channel over some records; None where there are too few samples."""
    from scipy.stats import chi2

    series = [item.normalised[:, item.names.index(name)] for item in items]
    values = np.concatenate(series)
    there = values[np.isfinite(values)]
    n = len(there)
    if n < max(FEWEST, 2 * lags):
        return None
    correlation, pairs = autocorrelation(series, lags)
    statistic = float(np.sum(pairs * correlation**2)) * (n + 2) / n
    gated = sum(int(item.gated[:, item.names.index(name)].sum()) for item in items)
    low, high = chi2.ppf([0.025, 0.975], n) / n
    return ChannelTest(
        channel=name,
        samples=n,
        nis=float(np.mean(there**2)),
        band=(float(low), float(high)),
        mean=float(np.mean(there)),
        correlation=correlation,
        p_white=float(chi2.sf(statistic, int(np.count_nonzero(pairs)))),
        gated=gated / (n + gated),
    )
