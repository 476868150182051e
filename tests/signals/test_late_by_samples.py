"""Channels that are late or early by whole samples from some sample on, beside all else."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.signal import lfilter

from pmmkit.base import DataError
from pmmkit.signals import shifts_within

SAMPLES = 100
"""Of a cycle on average."""


def uneven(cycles: int, samples: int = SAMPLES, seed: int = 0) -> np.ndarray:
    """Phase of a motion whose cycles last a percent longer or shorter than each other."""
    lengths = 1 + 0.01 * np.random.default_rng(seed).normal(size=cycles + 1)
    ends = samples * np.append(0.0, np.cumsum(lengths))
    return np.interp(np.arange(int(ends[-1])), ends, 2 * np.pi * np.arange(cycles + 2))


def side_force(theta: np.ndarray) -> np.ndarray:
    """Damping, added mass, and a third harmonic of cross flow."""
    return 3.0 + 10 * np.cos(theta) - 4 * np.sin(theta) + 1.5 * np.cos(3 * theta)


def surge_force(theta: np.ndarray) -> np.ndarray:
    """A mean and twice the frequency of the motion."""
    return -20.0 + 2 * np.cos(2 * theta) + 0.5 * np.sin(2 * theta)


def late(x: np.ndarray, samples: int, start: int) -> np.ndarray:
    """Values repeated (late) or lost (early) once; the rest of the motion follows."""
    return np.concatenate((x[:start], x[start - samples :]))[: x.size]


def noise(size: int, seed: int = 1) -> np.ndarray:
    return np.random.default_rng(seed).normal(size=size)


@given(
    samples=st.sampled_from((-3, -2, -1, 1, 2, 3)),
    share=st.floats(0.3, 0.7),
    cycles=st.integers(4, 12),
    seed=st.integers(0, 10_000),
)
def test_the_number_of_samples_and_the_place_are_found(samples, share, cycles, seed):
    """In noise of 1 % of the amplitude, of which white noise hides nothing at 100 samples a cycle.

    One record in thirty is not told, as three tests at 1 % each ask whether more has changed.
    """
    theta = uneven(cycles, seed=seed)
    start = int(share * theta.size)
    record = late(side_force(theta) + 0.1 * noise(theta.size, seed), samples, start)
    (found,) = shifts_within(theta[: record.size], record)
    if found is not None:
        assert found.samples == samples
        assert abs(found.start - start) < SAMPLES / 4


def test_nearly_all_are_told_in_little_noise():
    told = 0
    for seed in range(60):
        theta = uneven(6, seed=seed)
        samples, start = 1 + seed % 3, theta.size // (2 + seed % 2)
        record = late(side_force(theta) + 0.1 * noise(theta.size, seed), samples, start)
        (found,) = shifts_within(theta, record)
        told += found is not None and found.samples == samples
    assert told >= 54


def test_each_channel_is_told_for_itself():
    theta = uneven(6)
    waves = np.stack([surge_force(theta), side_force(theta), side_force(theta)])
    record = waves + 0.05 * np.stack([noise(theta.size, seed) for seed in range(3)])
    record[0] = late(record[0], 2, 250)
    record[2] = late(record[2], 3, 300)
    surge, side, moment = shifts_within(theta, record)
    assert (surge.samples, side, moment.samples) == (2, None, 3)


def test_a_computation_without_noise_is_told_to_the_sample():
    theta = uneven(5)
    (found,) = shifts_within(theta, late(side_force(theta), 1, 240))
    assert (found.samples, found.start) == (1, 240)


@pytest.mark.parametrize("memory", [0.0, 0.05, 0.33])
def test_sound_records_are_silent(memory):
    """Noise that remembers nothing, a twentieth or a third of a cycle."""
    rho = np.exp(-1.0 / (memory * SAMPLES)) if memory else 0.0
    for seed in range(60):
        theta = uneven(3 + seed % 8, seed=seed)
        alike = lfilter([1.0], [1.0, -rho], noise(theta.size + 400, seed))[-theta.size :]
        record = side_force(theta) + 0.5 * alike / alike.std()
        assert shifts_within(theta, record) == (None,)


def about_half(theta: np.ndarray) -> np.ndarray:
    return np.arange(theta.size) > theta.size // 2


OTHERS = {
    "size from some time on": lambda x: side_force(x) * (1 + 0.1 * about_half(x)),
    "size little by little": lambda x: side_force(x) * np.linspace(1.0, 1.1, x.size),
    "third harmonic": lambda x: side_force(x) + 1.0 * about_half(x) * np.sin(3 * x),
    "zero": lambda x: side_force(x) + 2.0 * about_half(x),
    "phase little by little": lambda x: side_force(x - 0.2 * np.linspace(0, 1, x.size)),
    "half a sample": lambda x: side_force(x - about_half(x) * np.pi / SAMPLES),
    "phase of the first harmonic alone": lambda x: (
        side_force(x) - side_force(0 * x) + 6 * np.sin(x - 0.2 * about_half(x))
    ),
    "start": lambda x: side_force(x) + 3.0 * np.cos(x + 1) * np.exp(-x / 5),
    "four samples": lambda x: side_force(x - about_half(x) * 8 * np.pi / SAMPLES),
}


@pytest.mark.parametrize("change", OTHERS)
def test_other_changes_are_no_shift(change):
    for seed in range(10):
        theta = uneven(8, seed=seed)
        record = OTHERS[change](theta) + 0.1 * noise(theta.size, seed)
        assert shifts_within(theta, record) == (None,)


def test_what_is_late_throughout_shows_in_no_record_alone():
    """It is a phase, like that of damping and added mass."""
    theta = uneven(6)
    record = late(side_force(theta) + 0.1 * noise(theta.size), 3, 3)
    assert shifts_within(theta, record) == (None,)


def test_one_sample_of_a_thousand_is_lost_in_noise_of_a_tenth():
    """Told in 4 % of such records and in 33 % at half the noise (`scripts.studies.late_channels`):
    the phase of half a record is known to a sample only."""
    told = 0
    for seed in range(30):
        theta = uneven(6, samples=1000, seed=seed)
        record = late(side_force(theta) + 1.1 * noise(theta.size, seed), 1, theta.size // 2)
        told += shifts_within(theta, record) != (None,)
    assert told <= 6


def test_too_few_cycles_or_samples_tell_nothing():
    short = uneven(2)[:-SAMPLES]
    assert shifts_within(short, late(side_force(short), 2, 120)) == (None,)
    coarse = uneven(6, samples=12)
    assert shifts_within(coarse, late(side_force(coarse), 1, 36)) == (None,)


def test_damage_is_told_as_everywhere():
    theta = uneven(4)
    record = side_force(theta)
    record[7] = np.nan
    with pytest.raises(DataError, match="not finite"):
        shifts_within(theta, record)
