"""Noise-free tests give the truth back, whichever way they are reduced."""

from __future__ import annotations

import math

import numpy as np
import pytest
from few_runs import few

from pmmkit.conventions import Ship
from pmmkit.reduction import reduce_campaign
from pmmkit.signals import harmonics
from scripts.datasets.virtual_tank import (
    SHIP,
    SON_NOMOTO,
    WATER,
    balance_reading,
    captive,
    history,
    state_of,
    water_forces,
)

MODULUS = {name: value for name, value in SON_NOMOTO.items() if name[1:] not in ("vvv", "rrr")} | {
    "Yv|v|": -0.02,
    "Yr|r|": 0.0022,
    "Nv|v|": 0.004,
    "Nr|r|": -0.0017,
}


def worst(table, truth=SON_NOMOTO) -> float:
    """Largest relative error of the values that a table has."""
    values = {name: value for name, value in table.at().items() if not math.isnan(value)}
    assert values
    return max(abs(value / truth[name] - 1) for name, value in values.items())


@pytest.mark.slow
@pytest.mark.parametrize("balance", [False, True], ids=["hydrodynamic", "balance"])
def test_all_methods_agree_with_the_truth(balance):
    found = reduce_campaign(captive(balance=balance, runs=few()), check=False)
    assert set(found.table.names) == set(SON_NOMOTO)
    assert worst(found.table) < 1e-10
    assert set(found.families) == {"static drift", "pure sway", "pure yaw", "yaw with drift"}
    for table in (*found.families.values(), *found.single_runs.values()):
        assert worst(table) < 1e-10


@pytest.mark.slow
def test_modulus_form():
    found = reduce_campaign(captive(MODULUS, runs=few()), structure="modulus", check=False)
    assert worst(found.table, MODULUS) < 1e-10


@pytest.mark.slow
def test_uneven_sampling_is_as_good_as_even():
    def jittered(t):
        step = t[1] - t[0]
        return t + 0.4 * step * np.random.default_rng(5).uniform(-1, 1, len(t))

    found = reduce_campaign(captive(times=jittered, runs=few()), check=False)
    assert worst(found.table) < 1e-10


@pytest.mark.slow
def test_carriage_speed_option_is_exact_for_forces_made_with_it():
    found = reduce_campaign(captive(carriage=True, runs=few()), carriage_speed=True, check=False)
    sway = found.families["pure sway"]
    assert worst(sway) < 1e-10
    assert sway.convention.U == "carriage"


@pytest.mark.slow
def test_carriage_speed_shortcut_has_its_known_bias():
    """Amplitudes V from .05 to .25 reduced with U = Uc give Yvvv -.1113 and Nvvv -.00045 for the
    S175, whose forces follow the instantaneous U with -.109 and +.001492: the sign flips."""
    sway = [(f"{V}", "pure_sway", 1.5, {"v": V}) for V in (0.05, 0.10, 0.15, 0.20, 0.25)]
    found = reduce_campaign(captive(runs=sway), carriage_speed=True, check=False)
    several = _first_harmonics_only(found)
    assert several["Yvvv"] == pytest.approx(-0.1113, abs=2e-4)
    assert several["Nvvv"] == pytest.approx(-0.00045, abs=2e-5)
    assert found.families["pure sway"].at()["Nvvv"] < 0
    right = reduce_campaign(captive(runs=sway), check=False).families["pure sway"].at()
    assert right["Nvvv"] == pytest.approx(0.001492, rel=1e-9)


def test_third_harmonic_of_primed_forces_is_not_the_cubic_derivative():
    """Forces primed with the instantaneous U at V = .2: the single-run formula 4 a3/V³ gives
    Yvvv -.0957 and Nvvv +.0032, since v' = v/U is no sine."""
    V = 0.2
    run = captive(runs=[("a", "pure_sway", 1.5, {"v": V})]).runs[0]
    u, v, *_ = state_of(run)
    for channel, arm, expected in (("Y", 1.0, -0.0957), ("N", SHIP.L, 0.0032)):
        unit = 0.5 * WATER.rho * SHIP.L**2 * (u**2 + v**2) * arm
        theta = run.settings.omega * run.data["t"].values
        third = harmonics(theta, (run.data[channel].values / unit)[None]).coefficients[0, 5]
        assert 4 * third / V**3 == pytest.approx(expected, abs=1e-4)


def _first_harmonics_only(found):
    """The classical multiple-run fit: a1 over V and 3/4 V³."""
    values = {}
    for channel, arm in (("Y", 1.0), ("N", SHIP.L)):
        rows = []
        for item in found.runs:
            U, V = item.run.settings.speed, float(item.run.id)
            q = 0.5 * 999.1 * SHIP.L**2 * U**2 * arm
            rows.append((V, 0.75 * V**3, item.measured[channel][1] / q))
        a, b, y = np.array(rows).T
        values[f"{channel}vvv"] = np.linalg.lstsq(np.stack([a, b], 1), y, rcond=None)[0][1]
    return values


def test_classical_closed_forms_of_pure_sway_agree_with_the_balance():
    """Yvvv = 4 a3/V³, Yv = (a1 - 3 a3)/V, X* = a0 - a2, Xvv = 2 a2/V² for carriage-U forces."""
    V, U = 0.2, 1.5
    found = reduce_campaign(
        captive(carriage=True, runs=[("a", "pure_sway", U, {"v": V})]),
        structure="Yv Yvvv Yvdot Xuu Xvv",
        carriage_speed=True,
        check=False,
    )
    q = 0.5 * 999.1 * SHIP.L**2 * U**2
    item = found.runs[0]
    y, x = item.measured["Y"] / q, item.measured["X"] / q
    values = found.single_runs["a"].at()
    assert values["Yvvv"] == pytest.approx(4 * y[5] / V**3, rel=1e-9)
    assert values["Yv"] == pytest.approx((y[1] - 3 * y[5]) / V, rel=1e-9)
    omega = item.frequency * SHIP.L / U
    assert values["Yvdot"] == pytest.approx(-y[2] / (V * omega), rel=1e-9)
    assert values["Xuu"] == pytest.approx(x[0] - x[3], rel=1e-9)
    assert values["Xvv"] == pytest.approx(2 * x[3] / V**2, rel=1e-9)


@pytest.mark.slow
@pytest.mark.parametrize("reference", [-0.4, 0.243])
def test_moments_about_another_point(reference):
    """The balance states moments about a point forward of midship: N_ref = N - x Y."""
    plain = captive(runs=few())
    runs = tuple(
        run.with_(loader=lambda data=run.data: data.assign(N=data["N"] - reference * data["Y"]))
        for run in plain
    )
    moved = plain.with_(runs=runs, moment_reference_x=reference)
    assert worst(reduce_campaign(moved, check=False).table) < 1e-10


@pytest.mark.slow
def test_motions_about_another_point():
    """The mechanism drives a point forward of midship: v there is v + x r at midship."""
    x = 0.3
    plain = captive(runs=few())
    runs = []
    for run in plain:
        u, v, r, udot, vdot, rdot = state_of(run)
        force = water_forces(SON_NOMOTO, u, v - x * r, r, udot, vdot - x * rdot, rdot)
        data = history(run.data["t"].values, force)
        runs.append(run.with_(loader=lambda data=data: data))
    moved = plain.with_(runs=tuple(runs), motion_reference_x=x)
    assert worst(reduce_campaign(moved, check=False).table) < 1e-10


@pytest.mark.slow
def test_inertia_of_what_hangs_on_the_balance():
    """Centre of gravity off midship, and another mass on the balance than the displacement."""
    heavy = Ship(
        **{**SHIP.__dict__, "balance_mass": 520.0, "balance_Izz": 700.0, "balance_xG": 0.2}
    )
    hung = Ship(**{**SHIP.__dict__, "mass": 520.0, "Izz": 700.0, "xG": 0.2})
    plain = captive(runs=few())
    runs = []
    for run in plain:
        state = state_of(run)
        data = history(
            run.data["t"].values,
            balance_reading(water_forces(SON_NOMOTO, *state), *state, ship=hung),
        )
        runs.append(run.with_(loader=lambda data=data: data, forces="balance"))
    found = reduce_campaign(plain.with_(ship=heavy, runs=tuple(runs)), check=False)
    assert worst(found.table) < 1e-10


@pytest.mark.slow
def test_pooled_speeds_give_one_set():
    found = reduce_campaign(captive(runs=few((1.0, 2.0))), fn="pooled", check=False)
    assert found.table.pooled
    assert worst(found.table) < 1e-10


@pytest.mark.slow
def test_each_speed_has_its_own_set():
    found = reduce_campaign(captive(runs=few((1.0, 1.5, 2.0))), check=False)
    assert found.table.Fn == pytest.approx([0.1448, 0.2172, 0.2896], abs=1e-4)
    assert found.table["Nvvr"] == pytest.approx([-0.0424] * 3, rel=1e-9)
