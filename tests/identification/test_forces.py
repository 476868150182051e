"""Forces along histories, and values fitted to forces."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from pmmkit.base import DataError, UnknownNameError
from pmmkit.equations import prepare
from pmmkit.identification import fit_to_forces
from pmmkit.identification.forces import ForceRecord
from pmmkit.models import load_model

SHIPS = [
    ("s175", 9.0),
    ("s175-3dof", 9.0),
    ("kvlcc2-l7", 1.2),
    ("kcs", 12.0),
    ("esso190k", 8.0),
    ("mariner", 7.7),
    ("esso-osaka-3m", 0.5),
]


def random_motion(ready, size=40, seed=1):
    draw = np.random.default_rng(seed).uniform
    V, L = ready.speed, ready.L
    motion = {
        "u": V * draw(0.4, 1.1, size),
        "v": V * draw(-0.3, 0.3, size),
        "r": V / L * draw(-0.6, 0.6, size),
        "delta": draw(-0.6, 0.6, size),
        "n": draw(0.8, 1.2, size) * ready.self_propulsion(),
    }
    if ready.rolls:
        motion |= {"p": draw(-0.01, 0.01, size), "phi": draw(-0.2, 0.2, size)}
    return motion


@pytest.mark.parametrize(("name", "speed"), SHIPS)
def test_the_water_gives_the_ship_the_accelerations_of_newton(name, speed):
    """m(u' - vr - xG r²) = X and so on, with the accelerations of the equations of motion."""
    model = load_model(name)
    ready = prepare(model, speed)
    m = random_motion(ready)
    size = len(m["u"])
    states = ("u", "v", "r", "p", "phi", "delta", "n")
    found = np.array(
        [
            ready.accelerations(*(float(m.get(x, np.zeros(size))[i]) for x in states))
            for i in range(size)
        ]
    )
    m |= dict(zip(("udot", "vdot", "rdot", "pdot"), found.T, strict=True))
    force = ready.water_forces(m)
    s, zG = model.ship, model.ship.zG or 0.0
    expected = {
        "X": s.mass * (m["udot"] - m["v"] * m["r"] - s.xG * m["r"] ** 2),
        "Y": s.mass * (m["vdot"] + m["u"] * m["r"] + s.xG * m["rdot"] - zG * m["pdot"]),
        "N": s.Izz * m["rdot"] + s.mass * s.xG * (m["vdot"] + m["u"] * m["r"]),
    }
    if ready.rolls:
        expected["K"] = s.Ixx * m["pdot"] - s.mass * zG * (m["vdot"] + m["u"] * m["r"])
    for channel, values in expected.items():
        np.testing.assert_allclose(
            force[channel], values, rtol=1e-11, atol=1e-12 * np.max(np.abs(values))
        )


def test_sway_from_rest_feels_the_added_mass_alone():
    """Sway from rest: the force is minus the added mass times the acceleration, nothing else."""
    ready = prepare(load_model("kvlcc2-l7"), 1.2)
    force = ready.water_forces({"vdot": np.array([0.3]), "u": np.array([1e-6])})
    unit = 0.5 * 1000.0 * 7.0**2 * 0.46
    assert force["Y"][0] == pytest.approx(-0.223 * unit * 0.3, rel=1e-6)
    assert force["X"][0] == pytest.approx(0.0, abs=1e-6)


def by_hand(u, v, delta, n, aH, epsilon):
    """Side force of KVLCC2 in drift with rudder, MMG standard, straight from the paper's formulas.

    Yasukawa and Yoshimura (2015), equations 18 to 26, L = 7 m.
    """
    rho, L, d, U = 1000.0, 7.0, 0.46, math.hypot(u, v)
    beta = math.atan2(-v, u)
    wake = 1 - (1 - 0.4) * (1 + (1 - math.exp(-2.0 * abs(beta))) * ((1.6 if beta > 0 else 1.1) - 1))
    uP = (1 - wake) * u
    J = uP / (n * 0.216)
    KT = 0.2931 - 0.2753 * J - 0.1385 * J**2
    eta = 0.216 / 0.345
    jet = 1 + 0.5 * (math.sqrt(1 + 8 * KT / (math.pi * J**2)) - 1)
    uR = epsilon * uP * math.sqrt(eta * jet**2 + 1 - eta)
    vR = -U * (0.64 if beta > 0 else 0.395) * beta
    FN = 0.5 * rho * 0.0539 * (uR**2 + vR**2) * 2.747 * math.sin(delta + math.atan2(vR, uR))
    vp = v / U
    hull = 0.5 * rho * L * d * U**2 * (-0.315 * vp - 1.607 * vp**3)
    return hull - (1 + aH) * FN * math.cos(delta)


def rudder_tests(noise=0.0):
    rng = np.random.default_rng(5)
    u, v, delta, n = (
        rng.uniform(0.8, 1.2, 60),
        rng.uniform(-0.3, 0.3, 60),
        rng.uniform(-0.6, 0.6, 60),
        rng.uniform(1.5, 2.5, 60),
    )
    Y = np.array([by_hand(*row, aH=0.25, epsilon=1.2) for row in zip(u, v, delta, n, strict=True)])
    return ForceRecord(
        name="rudder",
        motion={"u": u, "v": v, "delta": delta, "n": n},
        speed=1.1,
        forces={"Y": Y + noise * rng.normal(size=60)},
        std={"Y": max(noise, 1e-3)},
    )


def test_nonlinear_parameters_of_a_rudder_are_found():
    found = fit_to_forces(
        load_model("kvlcc2-l7"), [rudder_tests()], ["rudder_mmg.aH", "rudder_mmg.epsilon"]
    )
    assert found.values == pytest.approx([0.25, 1.2], rel=1e-6)
    assert found.undetermined == ()


@pytest.mark.slow
def test_the_covariance_of_a_fit_is_that_of_its_scatter():
    names = ["rudder_mmg.aH", "rudder_mmg.epsilon", "Yv"]
    model = load_model("kvlcc2-l7")
    clean = rudder_tests()
    stated = fit_to_forces(model, [replace(clean, std={"Y": 2.0})], names).covariance
    drawn = []
    for seed in range(60):
        scatter = 2.0 * np.random.default_rng(seed).normal(size=60)
        noisy = replace(clean, forces={"Y": clean.forces["Y"] + scatter}, std={"Y": 2.0})
        drawn.append(fit_to_forces(model, [noisy], names).values)
    ratio = np.std(drawn, axis=0, ddof=1) / np.sqrt(np.diagonal(stated))
    assert np.all((ratio > 0.75) & (ratio < 1.3))


def test_what_the_records_do_not_excite_is_named_and_left_alone():
    found = fit_to_forces(load_model("kvlcc2-l7"), [rudder_tests()], ["rudder_mmg.aH", "Yr", "Nv"])
    assert found.undetermined == ("Yr", "Nv")
    assert found.values[1:] == pytest.approx([0.083, -0.137], rel=1e-12)
    assert np.isnan(found.std[1:]).all()


def test_gaps_in_a_record_do_not_count():
    full = rudder_tests()
    Y = full.forces["Y"].copy()
    Y[::3] = np.nan
    found = fit_to_forces(
        load_model("kvlcc2-l7"),
        [replace(full, forces={"Y": Y})],
        ["rudder_mmg.aH", "rudder_mmg.epsilon"],
    )
    assert found.values == pytest.approx([0.25, 1.2], rel=1e-6)


def test_names_without_a_value_are_refused_together():
    with pytest.raises(UnknownNameError, match=r"Zv, rudder_mmg\.charm"):
        fit_to_forces(load_model("kvlcc2-l7"), [rudder_tests()], ["Zv", "rudder_mmg.charm"])
    with pytest.raises(DataError, match="standard deviation"):
        fit_to_forces(load_model("kvlcc2-l7"), [replace(rudder_tests(), std={})], ["Yv"])
