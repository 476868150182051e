"""Least squares on a basis whose columns differ in size or are nearly alike."""

from __future__ import annotations

import numpy as np
import pytest

from pmmkit.numerics import coefficients, projector


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
