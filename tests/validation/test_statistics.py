"""What is told of an error, over samples and over harmonics."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from pmmkit.validation.statistics import ChannelError, statistics, together

LABELS = ("C0", "C1", "S1", "C2", "S2")
SIZES = st.floats(-1e3, 1e3)


@given(harmonics=arrays(float, (3, 5), elements=SIZES))
def test_harmonics_and_the_cycle_that_they_describe_tell_the_same(harmonics):
    """Parseval: the mean square over a cycle is C0² and half of the other squares."""
    phase = np.linspace(0.0, 2.0 * np.pi, 48, endpoint=False)
    waves = np.stack(
        [np.ones_like(phase)] + [f(k * phase) for k in (1, 2) for f in (np.cos, np.sin)]
    )
    one = statistics(ChannelError.of_harmonics(*harmonics, LABELS))
    other = statistics(ChannelError.of_samples(*(harmonics @ waves)))
    for name in ("error", "bias", "measured", "uncertainty"):
        assert one[name] == pytest.approx(other[name], rel=1e-9, abs=1e-9), name


def test_a_position_is_off_by_both_its_parts_together():
    """3 m north and 4 m east, all the time."""
    error = np.array([np.full(9, 3.0), np.full(9, 4.0)])
    found = statistics(ChannelError.of_samples(error, 10.0 * error, 0.1 * error))
    assert found["error"] == found["bias"] == pytest.approx(5.0)
    assert (found["relative"], found["ratio"]) == (pytest.approx(0.1), pytest.approx(10.0))
    assert not found["within"]


def test_an_error_that_swings_about_zero_has_no_mean():
    swing = np.sin(np.linspace(0.0, 2.0 * np.pi, 100, endpoint=False))
    found = statistics(ChannelError.of_samples(swing, swing, np.full(100, 1.0)))
    assert found["bias"] == pytest.approx(0.0, abs=1e-12)
    assert found["error"] == pytest.approx(0.5**0.5)
    assert found["within"]


def test_a_motion_without_bound_is_within_nothing():
    with np.errstate(over="ignore"):
        lost = np.exp2(np.arange(0.0, 2000.0))
    found = statistics(ChannelError.of_samples(lost, np.ones(2000), np.ones(2000)))
    assert found["error"] == np.inf
    assert not found["within"]


def test_biases_of_runs_to_both_sides_cancel_and_errors_do_not():
    rows = [
        statistics(ChannelError.of_samples(x * np.ones(4), np.ones(4), 0.5 * np.ones(4)))
        for x in (0.3, -0.3)
    ]
    found = together(rows)
    assert found["bias"] == pytest.approx(0.0)
    assert found["error"] == pytest.approx(0.3)
    assert found["within"] == 2


def test_a_run_that_may_differ_by_much_hides_no_other():
    """The same error, ten times what may differ in one run and a hundredth of it in the other."""
    rows = [
        statistics(ChannelError.of_samples(np.ones(4), np.ones(4), np.full(4, doubt)))
        for doubt in (0.1, 100.0)
    ]
    assert together(rows)["ratio"] == pytest.approx(10.0 / 2.0**0.5, rel=1e-5)
