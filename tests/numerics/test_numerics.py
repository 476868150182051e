"""Least squares on a basis whose columns differ in size or are nearly alike; rounded clocks."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from pmmkit.numerics import coefficients, even_clock, last_digits, projector


@pytest.mark.parametrize("apart", [1.0, 1e-3, 1e-5])
@pytest.mark.parametrize("units", [np.ones(3), np.array([1e-8, 1e8, 1e-2])])
def test_coefficients_do_not_hang_on_the_units_of_columns(apart, units):
    """A third column that differs from the first by `apart`: exact values come back."""
    rng = np.random.default_rng(0)
    one, two, other = rng.normal(size=(3, 60))
    basis = np.stack([one, two, one + apart * other], axis=1) * units
    right = np.array([3.0, -2.0, 1.0]) / units
    for found in (
        projector(basis) @ (basis @ right),
        coefficients(basis, (basis @ right)[None])[0],
    ):
        np.testing.assert_allclose(found, right, rtol=1e-8)


def written(values: np.ndarray, how: str) -> np.ndarray:
    """Numbers as a file has them: with so many digits, or so many decimals."""
    return np.array([float(format(x, how)) for x in values])


@given(
    step=st.floats(0.02, 0.4),
    how=st.sampled_from([".2E", ".1E", ".0f", ".1f"]),
    start=st.floats(0.0, 30.0),
    count=st.integers(400, 3000),
)
# From .1 to 1 s the stamps lie half way between two numbers and are all rounded down.
@example(step=0.1, how=".1f", start=0.75, count=1355)
@example(step=0.020000000000000084, how=".2E", start=0.0625, count=569)
def test_an_even_clock_is_told_from_stamps_of_few_digits(step, how, start, count):
    exact = start + step * np.arange(count)
    stamps = written(exact, how)
    worth = last_digits(stamps)
    found = even_clock(stamps)
    if np.mean(np.diff(stamps) == 0) < 0.1:
        assert found is None
    else:
        # Steps of whole or half digits, as of .75 + .1 i s, leave stamps always as far off.
        halves = 2 * step / worth.max()
        tied = abs(halves - round(halves)) < 1e-6
        assert np.max(np.abs(found - exact)) < (0.5 if tied else 0.2) * worth.max()


@given(row=st.integers(50, 150), lost=st.integers(15, 60))
def test_rows_written_twice_or_lost_are_no_rounding(row, lost):
    exact = 0.1 * np.arange(200)
    assert even_clock(np.insert(exact, row, exact[row])) is None
    seconds = np.floor(0.01 * np.arange(4000))
    gap = np.delete(seconds, slice(10 * row, 10 * row + 10 * lost))
    assert even_clock(gap) is None
    assert even_clock(seconds[::-1]) is None


def test_last_digits_of_decimals_and_of_digits():
    exact = np.linspace(0.1, 2550.0, 500)
    assert set(last_digits(written(exact, ".1f"))) == {0.1}
    three = written(exact, ".2E")
    assert last_digits(three)[-1] == 10.0
    assert last_digits(three)[three < 10.0].max() == pytest.approx(0.01)
    assert not last_digits(exact).any()
    assert not last_digits(np.zeros(4)).any()
