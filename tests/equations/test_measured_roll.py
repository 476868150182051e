"""A ship that does not roll by itself goes along with the heel that was measured."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import pmmkit as pk
from pmmkit.base import MissingPartError, ModelError
from pmmkit.conventions import parse_derivative
from pmmkit.effects import HULL, INERTIA
from pmmkit.equations import Conditions, InputField, OverGround, State, prepare
from pmmkit.equations.code_generation import ESTIMATING, module_text
from pmmkit.equations.compilation import compiled
from pmmkit.equations.histories import water_forces
from pmmkit.equations.layouts import Constant
from pmmkit.equations.prepared import packed
from pmmkit.models import load_model

SPEED = 9.0
ROLLING, UPRIGHT = load_model("s175"), load_model("s175-3dof")
HEEL_TERMS = {name: x for name, x in ROLLING.values(HULL).items() if parse_derivative(name).heels}
HEELED = UPRIGHT.with_values(HULL, **HEEL_TERMS)


def estimating(model):
    """The functions of the estimators for a model, and its constants."""
    structure, k = packed(model, model.values_at(SPEED), SPEED, Conditions(), heeled=True)
    functions, constants = compiled(structure, ESTIMATING), np.array(k)
    assert functions.complete(constants) == 0
    return functions, structure, constants


def driven(size, **columns):
    inputs = np.zeros((size, len(InputField)))
    inputs[:, InputField.revolutions] = prepare(UPRIGHT, SPEED).self_propulsion()
    for name, values in columns.items():
        inputs[:, InputField[name]] = values
    return inputs


def some_states(size=7):
    draw = np.random.default_rng(2)
    middle = [0.0, 0.0, 0.3, SPEED, 0.0, 0.0]
    return middle + draw.normal(size=(size, 6)) * [50.0, 50.0, 1.0, 0.5, 0.6, 0.005]


def test_terms_of_the_measured_heel_act_with_their_forces():
    """m(v' + ur) = Y and so on, with the forces that the histories of captive tests give."""
    functions, structure, k = estimating(HEELED)
    states, draw = some_states(), np.random.default_rng(3)
    roll, p = draw.uniform(-0.2, 0.2, 7), draw.uniform(-0.02, 0.02, 7)
    inputs = driven(7, rudder=draw.uniform(-0.5, 0.5, 7), roll=roll, roll_rate=p)
    out = np.empty_like(states)
    functions.along(states, inputs, np.zeros((7, 3)), k, out)
    motion = dict(zip(("x", "y", "psi", "u", "v", "r"), states.T, strict=True))
    motion |= {f"{name}dot": out[:, State[name]] for name in ("u", "v", "r")}
    motion |= {"phi": roll, "p": p, "delta": inputs[:, 0], "n": inputs[:, 1]}
    force, ship = water_forces(structure, k, motion), UPRIGHT.ship
    u, v, r = motion["u"], motion["v"], motion["r"]
    np.testing.assert_allclose(force["X"], ship.mass * (motion["udot"] - v * r), rtol=1e-9)
    np.testing.assert_allclose(force["Y"], ship.mass * (motion["vdot"] + u * r), rtol=1e-9)
    np.testing.assert_allclose(force["N"], ship.Izz * motion["rdot"], rtol=1e-9)


def test_the_acceleration_of_the_measured_roll_pushes_sideways():
    """Y = m(v' + ur - zG p'), with the added mass of sway that the roll moves."""
    ship = replace(UPRIGHT.ship, zG=1.5)
    model = replace(HEELED, ship=ship).with_values(INERTIA, Ypdot=2.2e-4, Npdot=-4e-5)
    functions, structure, k = estimating(model)
    states, pdot = some_states(), np.random.default_rng(3).uniform(-0.005, 0.005, 7)
    out = np.empty_like(states)
    inputs = driven(7, roll_acceleration=pdot)
    functions.along(states, inputs, np.zeros((7, 3)), k, out)
    motion = dict(zip(("x", "y", "psi", "u", "v", "r"), states.T, strict=True))
    motion |= {f"{name}dot": out[:, State[name]] for name in ("u", "v", "r")}
    motion |= {"pdot": pdot, "n": inputs[:, 1]}
    force, body = water_forces(structure, k, motion), ship.rigid_body_forces(motion)
    for channel in "XYN":
        np.testing.assert_allclose(force[channel], body[channel], rtol=1e-9)
    still = np.empty_like(states)
    functions.along(states, driven(7), np.zeros((7, 3)), k, still)
    assert np.all(np.sign((out - still)[:, State.v]) == np.sign(pdot))


def test_the_compass_of_a_heeled_ship_turns_slower():
    functions, _, k = estimating(UPRIGHT)
    states, heel = some_states(), np.linspace(-0.3, 0.3, 7)
    out = np.empty_like(states)
    functions.along(states, driven(7, roll=heel), np.zeros((7, 3)), k, out)
    psi, u, v, r = (states[:, State[name]] for name in ("psi", "u", "v", "r"))
    level = v * np.cos(heel)
    np.testing.assert_allclose(out[:, State.psi], r * np.cos(heel), rtol=1e-14)
    np.testing.assert_allclose(out[:, State.x], u * np.cos(psi) - level * np.sin(psi), rtol=1e-14)
    np.testing.assert_allclose(out[:, State.y], u * np.sin(psi) + level * np.cos(psi), rtol=1e-14)


def test_heel_and_its_rates_are_straight_lines_between_instants():
    functions, _, k = estimating(HEELED)
    t = np.array([0.0, 3.0, 8.0])
    inputs = driven(3, rudder=0.2, roll=[0.0, 0.2, -0.1], roll_rate=[0.01, -0.02, 0.03])
    inputs[:, InputField.roll_acceleration] = 0.001, -0.003, 0.002
    start = some_states()[0]
    out = np.empty((3, 6))
    functions.windows(t, inputs, np.array([0, 3]), start[None], k.copy(), 0.05, out)

    def rates(time, y):
        found, here = np.empty(6), k.copy()
        here[Constant.roll] = np.interp(time, t, inputs[:, InputField.roll])
        for name in ("roll_rate", "roll_acceleration"):
            here[Constant[name]] = np.interp(time, t, inputs[:, InputField[name]])
        functions.rates(y, 0.2, inputs[0, 1], 0.0, here, found)
        return found

    truth = solve_ivp(rates, (0.0, 8.0), start, t_eval=t, rtol=1e-11, atol=1e-12, max_step=0.1).y.T
    np.testing.assert_allclose(out, truth, rtol=1e-7, atol=1e-9)


def test_a_ship_that_rolls_by_itself_does_not_look_at_the_input():
    functions, structure, k = estimating(ROLLING)
    t, found = np.linspace(0.0, 60.0, 61), []
    first = np.array([[0.0, 0.0, 0.0, SPEED, 0.0, 0.0, 0.0, 0.05]])
    for columns in ({}, {"roll": 0.3, "roll_rate": 0.02}):
        out = np.empty((61, len(structure.states)))
        inputs = driven(61, rudder=0.3, **columns)
        functions.windows(t, inputs, np.array([0, 61]), first, k.copy(), 0.5, out)
        found.append(out)
    np.testing.assert_array_equal(*found)


def test_a_simulation_knows_no_measured_heel():
    """Not a single operation more in the right-hand side of a ship that does not roll."""
    text = module_text(prepare(UPRIGHT, SPEED).structure)
    rates = text[text.index("def rates") : text.index("def", text.index("def rates") + 4)]
    assert "p, phi = 0.0, 0.0" in rates
    assert "upright" not in rates
    assert f"k[{int(Constant.roll)}]" not in rates


@pytest.mark.slow
@pytest.mark.parametrize("kind", OverGround)
def test_slopes_of_the_velocity_over_ground_of_a_rolling_ship(kind):
    functions, _, k = estimating(ROLLING)
    z, h = np.array([5.0, 6.0, 2.1, 8.1, -1.3, 0.05, 0.01, 0.4]), np.zeros(8)

    def by_hand(z):
        water = (z[State.u] + 1j * z[State.v] * math.cos(z[State.phi])) * np.exp(1j * z[State.psi])
        return {
            OverGround.north: water.real,
            OverGround.east: water.imag,
            OverGround.size: abs(water),
        }[kind]

    assert functions.expected(int(kind), z, k, h) == pytest.approx(by_hand(z), rel=1e-12)
    steps = 1e-5 * np.eye(8)
    slopes = [(by_hand(z + step) - by_hand(z - step)) / 2e-5 for step in steps]
    assert h == pytest.approx(slopes, abs=1e-8)


def test_terms_of_heel_without_roll_are_refused_in_a_manoeuvre():
    assert set(HEELED.heeled) == set(HEEL_TERMS)
    with pytest.raises(MissingPartError, match=r"derivatives of heel .*Yphi.* but does not roll"):
        pk.simulate(HEELED, "turning", speed=SPEED)
    with pytest.raises(MissingPartError, match="does not roll"):
        pk.simulation.monte_carlo(HEELED, "turning", speed=SPEED, n=2, spread=0.05)
    assert ROLLING.heeled == UPRIGHT.heeled == ()


def test_a_roll_moment_asks_for_a_ship_that_rolls():
    with pytest.raises(ModelError, match="Kv need roll"):
        UPRIGHT.with_values(HULL, Kv=1e-4)
