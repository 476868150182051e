"""Motion sickness: by O'Hanlon and McCauley, and by the dose of ISO 2631-1."""

from __future__ import annotations

import math
from typing import Final

import numpy as np
from numpy.typing import ArrayLike

from pmmkit.numerics import Array

_KM: Final = 1 / 3
_HIGH_PASS: Final = (0.08, 1 / math.sqrt(2))  # f1 [Hz], Q1
_LOW_PASS: Final = (0.63, 1 / math.sqrt(2))  # f2
_TRANSITION: Final = (0.25, 0.86)  # f4, Q4; f3 is infinite
_STEP_UP: Final = (0.0625, 0.80, 0.1, 0.80)  # f5, Q5, f6, Q6


def dose_weight(omega: ArrayLike) -> Array:
    """The weighting Wf of ISO 2631-1 for motion sickness [-], largest about 0.17 Hz.

    Parameters
    ----------
    omega : array-like
        Frequency of encounter [rad/s].

    Examples
    --------
    >>> dose_weight(2 * np.pi * np.array([0.02, 0.1, 0.16, 0.315, 0.63])).round(3)
    array([0.024, 0.695, 1.006, 0.619, 0.116])
    """
    s = 1j * np.abs(np.asarray(omega, dtype=float))

    def quadratic(f: float, Q: float) -> Array:
        w = 2 * math.pi * f
        return np.asarray(1 + s / (Q * w) + (s / w) ** 2)

    f1, Q1 = _HIGH_PASS
    high = (s / (2 * math.pi * f1)) ** 2 / quadratic(f1, Q1)
    low = 1 / quadratic(*_LOW_PASS)
    transition = 1 / quadratic(*_TRANSITION)
    f5, Q5, f6, Q6 = _STEP_UP
    step = quadratic(f5, Q5) / quadratic(f6, Q6) * (f5 / f6) ** 2
    return np.asarray(np.abs(high * low * transition * step))


def vomiting_by_dose(dose: float) -> float:
    """Share of unadapted adults that vomit [%]: 1/3 of the dose MSDV [m/s^1.5], at most 100."""
    return min(_KM * dose, 100.0)


def incidence_in_waves(m0: float, m2: float, hours: float, g: float = 9.81) -> float:
    """Motion sickness incidence [%] by O'Hanlon and McCauley (1974).

    Share of people that vomit at least once within an exposure to vertical acceleration; the time
    enters as McCauley et al. 1976 have it, by Φ(z_a) Φ(z_t).

    Parameters
    ----------
    m0, m2 : float
        Moments of the spectrum of acceleration [m²/s⁴, m²/s⁶].
    hours : float
        Exposure [h].
    g : float
        Gravity [m/s²].

    Examples
    --------
    >>> round(incidence_in_waves(1.0, 1.1, 2.0), 1)
    32.8
    """
    if m0 <= 0.0:
        return 0.0
    from scipy.special import ndtr

    frequency = math.sqrt(m2 / m0) / (2 * math.pi)
    strength = math.sqrt(m0) / g
    octaves = math.log10(frequency)
    za = 2.128 * math.log10(strength) - 9.277 * octaves - 5.809 * octaves**2 - 1.851
    zt = 1.134 * za + 1.989 * math.log10(60 * hours) - 2.904
    return float(100 * ndtr(za) * ndtr(zt))
