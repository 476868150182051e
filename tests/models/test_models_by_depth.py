"""A model between two depths of the water."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import pmmkit as pk
from pmmkit.base import DataError, ExtrapolationError, ModelError
from pmmkit.models import Step, model_at_depth

KVLCC2 = pk.load_model("kvlcc2")


def made(ratio, factor=1.0, **changes):
    """The ship with linear derivatives that grow, in water of a depth."""
    hull = KVLCC2.values("hull_polynomial")
    grown = {name: factor * hull[name] for name in ("Yv", "Nv", "Yr", "Nr")}
    model = KVLCC2.with_values("hull_polynomial", **grown)
    return model.with_(water=replace(model.water, depth=ratio * model.ship.d), **changes)


def test_a_depth_of_the_tests_has_its_own_model():
    models = {2.0: made(2.0), 1.5: made(1.5, 1.4)}
    assert model_at_depth(models, 1.5) is models[1.5]
    assert model_at_depth(models, 2.0005) is models[2.0]


@given(ratio=st.floats(1.22, 1.98))
def test_values_lie_on_lines_over_the_draught_over_the_depth(ratio):
    found = model_at_depth({2.0: made(2.0), 1.2: made(1.2, 3.0)}, ratio)
    share = (1 / ratio - 1 / 2.0) / (1 / 1.2 - 1 / 2.0)
    hull, deep = (x.values("hull_polynomial") for x in (found, KVLCC2))
    for name in ("Yv", "Nv", "Yr", "Nr"):
        assert hull[name] == pytest.approx(deep[name] * (1.0 + 2.0 * share), rel=1e-12)
    assert hull["Nvvr"] == pytest.approx(deep["Nvvr"], rel=1e-12)
    assert found.water.depth == pytest.approx(ratio * KVLCC2.ship.d)


def test_beyond_the_tests_and_between_other_speeds_nothing_is_made_up():
    models = {2.0: made(2.0), 1.5: made(1.5, 1.4)}
    for ratio in (2.1, 1.4):
        with pytest.raises(ExtrapolationError, match=r"1\.5 to 2"):
            model_at_depth(models, ratio)
    with pytest.raises(ExtrapolationError, match="no two"):
        model_at_depth({2.0: made(2.0)}, 1.5)
    speeds = made(1.5).with_(Fn=(0.1, 0.15))
    with pytest.raises(ModelError, match="other Froude numbers"):
        model_at_depth({2.0: made(2.0), 1.5: speeds}, 1.7)


def test_a_model_by_force_marks_what_lies_beside_it():
    forced = Step(action="forced", ship="KVLCC2", names=("Yv is positive.",))
    shallow = made(1.5, 1.4, steps=(*KVLCC2.steps, forced))
    assert forced in model_at_depth({2.0: made(2.0), 1.5: shallow}, 1.9).steps


def test_formulas_carry_a_model_and_stop_at_their_edge():
    """Hirano's Yv at 2 and 1.5 draughts of a full tanker, 1.32 and 1.90 times that of deep water
    (the factors of public programs)."""
    found = model_at_depth({2.0: made(2.0)}, 1.5, by_formulas=True).values("hull_polynomial")
    assert found["Yv"] / KVLCC2.values("hull_polynomial")["Yv"] == pytest.approx(
        1.9 / 1.32, rel=0.01
    )
    assert np.isfinite(
        model_at_depth({2.0: made(2.0)}, 1.19, by_formulas=True).values("hull_polynomial")["Nv"]
    )
    with pytest.raises(DataError, match=r"1\.2"):
        model_at_depth({2.0: made(2.0)}, 1.1, by_formulas=True)
