"""Effects whose values the base may move too: it must not keep what it swallowed, unpaid for."""

from __future__ import annotations

import pytest
from free_tank.campaigns import Setup, hidden_in, write

import pmmkit as pk
from pmmkit.diagnosis import begin


@pytest.mark.slow
def test_an_effect_that_the_base_had_swallowed_has_its_size(tmp_path):
    """aH, xH and tR of an independent tank are off by .05, -.075 and .05; named with that size, and
    added with it."""
    setup = Setup(case="hull_rudder", runs=3, seed=1, ship="kvlcc2-l7", size=0.5)
    hidden = hidden_in(setup)
    truth = {"aH": hidden.hull_share, "xH": hidden.hull_point, "tR": hidden.steering_drag}
    session = begin(pk.load_model("kvlcc2-l7"), pk.open_campaign(write(setup, tmp_path)))
    (found,) = session.diagnose().findings
    assert found.effect == "rudder_hull_interaction"
    for name, size in truth.items():
        assert abs(found.coefficients[name] - size) < 3 * found.std[name]
    step = session.add(found.effect, "found").model().steps[-1]
    assert dict(step.coefficients) == pytest.approx(found.coefficients, rel=0.02)
