"""Many ships in lanes: the functions they call, and that no ship depends on its neighbours."""

import math

import numpy as np
import pytest

from pmmkit.equations import run_plan
from pmmkit.simulation import Spread
from pmmkit.simulation.ensemble import batch_of

numba = pytest.importorskip("numba")
CASES = {"kvlcc2-l7": ("zigzag", 1.179, 8), "esso-osaka-3m": ("turning", 0.5, 1)}
"""A ship whose equations are straight, and one with a table; how many lanes each has."""


@pytest.fixture(scope="module")
def functions():
    """The functions of lanes, compiled; and run by Python, which has their bits."""
    from pmmkit.equations import lane_functions
    from pmmkit.equations.machine_code import written

    give = written(lambda: ({}, lane_functions), "lanes.")
    sin, cos, exp, tanh, atan2 = map(give, ("sin", "cos", "exp", "tanh", "atan2"))

    @numba.njit
    def found(x, y, out):
        for i in range(x.size):
            out[0, i], out[1, i], out[2, i] = sin((x[i],)), cos((x[i],)), exp((x[i],))
            out[3, i], out[4, i] = tanh((x[i],)), atan2((y[i], x[i]))

    return found, lane_functions


def test_functions_of_lanes_are_those_of_the_c_library(functions):
    compiled, plain = functions
    rng = np.random.default_rng(3)
    x = np.concatenate([rng.uniform(-30.0, 30.0, 4000), rng.uniform(-1e-3, 1e-3, 500), [0.0]])
    y = np.concatenate([rng.uniform(-30.0, 30.0, 4000), rng.uniform(-1e-3, 1e-3, 500), [0.0]])
    out = np.empty((5, x.size))
    compiled(x, y, out)
    truth = [[f(a) for a in x] for f in (math.sin, math.cos, math.exp, math.tanh)]
    truth.append([math.atan2(b, a) for a, b in zip(x, y, strict=True)])
    error = np.abs(out - truth)
    error[2] /= truth[2]
    assert error.max(axis=1) == pytest.approx(0.0, abs=1e-15)
    for row, f in zip(out, (plain.sin, plain.cos, plain.exp, plain.tanh), strict=False):
        assert row[:200].tolist() == [f(a) for a in x[:200].tolist()]


@pytest.fixture(scope="module", params=CASES)
def ships(request):
    """A batch of a ship, values of 30 like it, and their metrics when all sail together."""
    manoeuvre, speed, lanes = CASES[request.param]
    batch = batch_of(request.param, manoeuvre, speed=speed, rtol=1e-6)
    drawn = Spread.of(batch.model, speed, 0.05, extrapolate=False, fn="approach")
    values = drawn.draw(0, 0, 30)
    return batch, drawn.names, values, batch.run(drawn.names, values, executor=1)[0], lanes


def test_only_straight_equations_have_lanes(ships):
    from pmmkit.equations.code_generation import SAILING
    from pmmkit.equations.compilation import compiled

    batch, names, values, _, lanes = ships
    assert lanes == compiled(batch.ship(names, values[0]).structure, SAILING).LANES


@pytest.mark.parametrize("several", [slice(7, 8), slice(3, 20)])
def test_a_ship_does_not_depend_on_those_beside_it(ships, several):
    batch, names, values, together, _ = ships
    apart, _ = batch.run(names, values[several], executor=1)
    for name, all_ships in together.items():
        np.testing.assert_array_equal(apart[name], all_ships[several])


def test_lanes_sail_as_a_single_ship_does(ships):
    batch, names, values, together, _ = ships
    for i in (0, 11):
        alone = run_plan(
            batch.ship(names, values[i]), batch.plan, batch.gear, rtol=batch.rtol, fast=False
        )
        for name, value in batch.plan.metrics_of(alone.results).items():
            assert together[name][i] == pytest.approx(value, rel=1e-9, nan_ok=True)


def test_a_ship_that_cannot_sail_leaves_the_others_alone(ships):
    batch, names, values, together, _ = ships
    spoiled = values.copy()
    spoiled[4, names.index("Yvdot")] = 1e3
    found, status = batch.run(names, spoiled, executor=1)
    assert status[4] != 0
    assert np.count_nonzero(status) == 1
    for name, all_ships in together.items():
        assert math.isnan(found[name][4])
        np.testing.assert_array_equal(np.delete(found[name], 4), np.delete(all_ships, 4))
