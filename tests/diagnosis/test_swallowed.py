"""Effects whose values the base may move too: it must not keep what it swallowed, unpaid for."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest
from free_tank.campaigns import Setup, hidden_in, write

import pmmkit as pk
from pmmkit.diagnosis.free_running.findings import Named
from pmmkit.loop.session import begin


@pytest.mark.parametrize(
    ("z", "named"), [((0.0, 0.0), False), ((0.3, -0.3), False), ((0.3, 0.5), True)]
)
def test_no_set_is_named_that_holds_an_effect_without_a_size(z, named):
    """Two coefficients known to ± .2 beside one of 2: evidence alone does not make them."""
    fit = SimpleNamespace(
        z=np.array([2.0, *z]),
        covariance=0.2**2 * np.eye(3),
        place=SimpleNamespace(
            question=SimpleNamespace(
                numbers=SimpleNamespace(
                    columns={"current": np.array([0]), "asymmetry": np.array([1, 2])}
                )
            )
        ),
    )
    assert Named(names=("current",), gain=9.0, fit=fit).has_sizes
    assert Named(names=("current", "asymmetry"), gain=99.0, fit=fit).has_sizes is named


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
