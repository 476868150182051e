"""Transfer functions from measured records, beside those that were computed."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np
from numpy.typing import ArrayLike

from pmmkit.base import DataError
from pmmkit.numerics import Array, rms
from pmmkit.presentation import Described, Grid, Group, Section, number
from pmmkit.seakeeping.lengthwise import Complex
from pmmkit.seakeeping.transfer import Rao
from pmmkit.signals import estimate_frequency, harmonics

if TYPE_CHECKING:
    import pandas as pd

_ORDER: Final = 3
_COHERENT: Final = 0.3
_ENERGY: Final = 0.02  # of the peak of the spectrum, below which a frequency tells nothing


@dataclass(frozen=True, kw_only=True, eq=False)
class MeasuredTransfer:
    """A transfer function that was measured.

    `encounter`: frequencies of encounter [rad/s]. `transfer`: motion over the wave at the
    probe; it leads the wave where its phase is positive. `std`: standard uncertainty of its
    amplitude.
    """

    encounter: Array
    transfer: Complex
    std: Array


def from_regular(
    t: ArrayLike, wave: ArrayLike, motion: ArrayLike, *, encounter: float
) -> MeasuredTransfer:
    """The transfer function at one frequency from a run in regular waves.

    Harmonics and their uncertainty are those of captive tests: whole cycles, and noise that is
    correlated in time.

    t [s]; wave, motion [m]; encounter [rad/s].

    Examples
    --------
    >>> t = np.arange(0.0, 120.0, 0.05)
    >>> found = from_regular(t, np.cos(0.7 * t), 0.5 * np.cos(0.7 * t + 1.0), encounter=0.7)
    >>> abs(found.transfer).round(3), np.angle(found.transfer).round(3)
    (array([0.5]), array([1.]))
    """
    clock = np.asarray(t, dtype=float)
    channels = np.stack([np.asarray(wave, dtype=float), np.asarray(motion, dtype=float)])
    omega, _ = estimate_frequency(clock, channels[:1], encounter)
    cycle = 2 * math.pi / omega
    whole = clock - clock[0] < math.floor((clock[-1] - clock[0]) / cycle) * cycle - 1e-9
    found = harmonics(omega * clock[whole], channels[:, whole], order=_ORDER)
    size = found.coefficients[:, 1] - 1j * found.coefficients[:, 2]
    spread = np.sqrt(np.mean(found.std[:, 1:3] ** 2, axis=1)) / np.abs(size)
    if np.abs(size[0]) < 3 * np.abs(size[0]) * spread[0]:
        raise DataError(f"The probe shows no waves at {omega:.3f} rad/s.")
    transfer = size[1] / size[0]
    return MeasuredTransfer(
        encounter=np.array([omega]),
        transfer=np.array([transfer]),
        std=np.array([abs(transfer) * math.hypot(*spread)]),
    )


def from_irregular(
    t: ArrayLike, wave: ArrayLike, motion: ArrayLike, *, segments: int = 16
) -> MeasuredTransfer:
    """The transfer function from a run in irregular waves, by cross-spectra.

    t [s]; wave, motion [m].
    """
    from scipy.signal import csd

    clock = np.asarray(t, dtype=float)
    steps = np.diff(clock)
    step = float(np.mean(steps))
    if steps.size < 16 * segments or np.abs(steps - step).max() > 1e-3 * step:
        raise DataError(
            f"Cross-spectra need even time steps and 16 or more samples for each of {segments} "
            "segments: interpolate the record, or ask for fewer segments."
        )
    length = 2 * clock.size // (segments + 1)
    x, y = (np.asarray(values, dtype=float) for values in (wave, motion))
    settings = {"fs": 1 / step, "nperseg": length}
    frequency, across = csd(x, y, **settings)
    _, own = csd(x, x, **settings)
    _, moved = csd(y, y, **settings)
    own, moved = own.real, moved.real
    coherence = np.abs(across) ** 2 / np.maximum(own * moved, 1e-300)
    kept = (own > _ENERGY * own.max()) & (coherence > _COHERENT) & (frequency > 0)
    if not kept.any():
        raise DataError("No frequency has waves that the motion goes with.")
    transfer = (across[kept] / own[kept]).astype(np.complex128)
    # half overlapping Hann segments count for about .95 of as many that do not overlap
    noise = np.sqrt((1 - coherence[kept]) / (2 * 0.95 * segments * coherence[kept]))
    return MeasuredTransfer(
        encounter=2 * math.pi * frequency[kept], transfer=transfer, std=np.abs(transfer) * noise
    )


@dataclass(frozen=True, kw_only=True, repr=False, eq=False)
class RaoComparison(Described):
    """A measured transfer function beside the computed one.

    `name, mode`: the ship, and the motion. `encounter, measured, std, computed`: frequencies
    [rad/s]; amplitudes with their standard uncertainty, and what was computed.
    """

    name: str
    mode: str
    encounter: Array
    measured: Array
    std: Array
    computed: Array

    def to_pandas(self) -> pd.DataFrame:
        """One row for each frequency [rad/s; m/m or rad/m]."""
        import pandas as pd

        columns = {"encounter": self.encounter, "measured": self.measured, "std": self.std}
        return pd.DataFrame(
            {"motion": self.mode, **columns, "computed": self.computed, "score": self.score}
        )

    @property
    def score(self) -> Array:
        """Difference over the standard uncertainty of the measurement."""
        return (self.measured - self.computed) / self.std

    def _headline(self) -> str:
        off = rms(self.measured - self.computed)
        return f"{self.mode} of {self.name}: {self.encounter.size} frequencies, rms {off:.3g}"

    def _sections(self) -> Sequence[Section]:
        rows = [
            [f"{w:.3f}", number(m, 3), number(s, 2), number(c, 3), f"{z:+.1f}"]
            for w, m, s, c, z in zip(
                self.encounter, self.measured, self.std, self.computed, self.score, strict=True
            )
        ]
        head = ["ωe [rad/s]", "measured", "standard uncertainty", "computed", "off by (std)"]
        return [Section(tables=[Grid(head=head, groups=[Group(rows=rows[:60])])])]


def beside(
    measured: MeasuredTransfer,
    rao: Rao,
    mode: str,
    *,
    speed: float | None = None,
    heading_deg: float | None = None,
) -> RaoComparison:
    """Amplitudes that were measured beside those computed at the same frequency of encounter."""
    a, b = rao.case(speed, heading_deg)
    encounter = rao.encounter[a, b]
    if (np.diff(encounter) <= 0.0).any():
        raise DataError(
            "In following seas waves of several lengths share a frequency of encounter: a record "
            "of the ship alone does not tell them apart."
        )
    there = (measured.encounter >= encounter[0]) & (measured.encounter <= encounter[-1])
    if not there.any():
        raise DataError(
            f"No measured frequency lies between {encounter[0]:.3f} and {encounter[-1]:.3f} rad/s."
        )
    computed = np.interp(measured.encounter[there], encounter, np.abs(rao.mode(mode)[a, b]))
    return RaoComparison(
        name=rao.name,
        mode=mode,
        encounter=measured.encounter[there],
        measured=np.abs(measured.transfer[there]),
        std=measured.std[there],
        computed=computed,
    )
