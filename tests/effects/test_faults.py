"""Faults of a measurement: what they show, against closed forms that are written here by hand."""

from __future__ import annotations

import numpy as np
import pytest

from pmmkit.diagnosis.captive.columns import columns_of
from pmmkit.diagnosis.captive.signature import standard_tests
from pmmkit.effects.catalogue import effect_of

VIEWS, BASE = standard_tests()


def column(name, view, value=0.0):
    """What a unit of a fault with one coefficient changes in a run, by channel."""
    return {
        channel: shown[:, 0]
        for channel, shown in columns_of(effect_of(name))(view, BASE, value).items()
    }


@pytest.mark.parametrize("view", VIEWS[:12], ids=lambda view: view.run.id)
def test_moments_about_a_point_forward_are_smaller_by_the_lever_of_the_side_force(view):
    # A force Y at x acts with x Y about midship, and with (x - 0.02 L) Y about 0.02 L forward.
    shown = 0.02 * column("fault_moment_point", view)["N"]
    expected = -0.02 * BASE.ship.L * BASE.expected(view)["Y"]
    np.testing.assert_allclose(shown, expected, rtol=1e-12, atol=1e-12)
