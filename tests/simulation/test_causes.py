"""What decides a metric: derivatives with a covariance, and values of other parts beside them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from pmmkit.models import load_model
from pmmkit.simulation import sensitivities, simulate

SHIP = load_model("s175-3dof")
RUDDER = SHIP.parts["rudder_mmg"]
MEASURED = SHIP.with_(
    parts={**SHIP.parts, "rudder_mmg": replace(RUDDER, std={"aH": 0.05})},
    covariance=np.diag([1e-4, 4e-4]) ** 2,
    covariance_names=("Nr", "Nv"),
)


def test_an_estimate_of_a_part_has_its_slope_and_share_beside_the_measured_derivatives():
    found = sensitivities(MEASURED, speed=9.0)
    assert found.names == ("Nr", "Nv", "rudder_mmg.aH")
    aH, step = RUDDER.values["aH"], 1e-4
    ends = [
        simulate(
            MEASURED.with_values("rudder_mmg", aH=aH + side * step), speed=9.0, rtol=1e-11
        ).metrics["advance"]
        for side in (-1, 1)
    ]
    slope = found.slopes["advance"][2]
    assert slope == pytest.approx((ends[1] - ends[0]) / (2 * step), rel=1e-5)
    own = (found.slopes["advance"] * np.array([1e-4, 4e-4, 0.05])) ** 2
    shares = found.table("advance")["share_of_variance"]
    assert shares["rudder_mmg.aH"] == pytest.approx(own[2] / own.sum())
