"""Propeller, rudder and hull taken apart from captive tests; whose tests make the uncertainty.

The virtual tests are made with the MMG standard model (Yasukawa and Yoshimura 2015), written out
here. HMRI's measurements of KVLCC2 are not part of the repository; those tests skip without them.
"""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
import reduced as large
import xarray as xr

from pmmkit import Campaign, Run
from pmmkit.base import MissingPartError
from pmmkit.campaigns import Settings, TypeB
from pmmkit.conventions import Ship, Water
from pmmkit.reduction import Parts, contributions, reduce_campaign
from scripts.datasets.virtual_tank import SON_NOMOTO, captive, programme
from scripts.validation import measurements
from scripts.validation.derivatives import PARTS

SHIP = Ship(name="KVLCC2 L7", L=7.0, B=1.27, d=0.46, volume=3.27, mass=3270.0, Izz=10000.0)
WATER = Water(rho=1000.0, g=9.81)
U0, REVOLUTIONS = 1.179, 10.4
HULL = {
    "R0": 0.022,
    "Xvv": -0.040,
    "Xvr": 0.225,
    "Xrr": 0.011,
    "Xvvvv": 0.771,
    "Yv": -0.315,
    "Yr": 0.061,
    "Yvvv": -1.607,
    "Yvvr": 0.379,
    "Yvrr": -0.391,
    "Yrrr": 0.008,
    "Nv": -0.137,
    "Nr": -0.049,
    "Nvvv": -0.030,
    "Nvvr": -0.294,
    "Nvrr": 0.055,
    "Nrrr": -0.013,
}
"""Of ½ρLdU², as captive tests measure them: Yr - mx, Xvr + my."""
SCREW = {
    "D": 0.216,
    "t": 0.22,
    "wp": 0.40,
    "xp": -0.48,
    "C1": 2.0,
    "C2_positive": 1.6,
    "C2_negative": 1.1,
    "kt0": 0.2931,
    "kt1": -0.2753,
    "kt2": -0.1385,
}
BLADE = {
    "area": 0.0539,
    "height": 0.345,
    "lift_slope": 2.747,
    "epsilon": 1.09,
    "kappa": 0.50,
    "gamma_positive": 0.640,
    "gamma_negative": 0.395,
    "lR": -0.710,
    "tR": 0.387,
    "aH": 0.312,
    "xH": -0.464,
}
KNOWN = {
    "area": 0.0539,
    "height": 0.345,
    "lift_slope": 2.747,
    "lR": -0.710,
    "rate_deg_s": 15.8,
    "assumed": "library: Yasukawa and Yoshimura 2015",
}


def kt(J):
    return SCREW["kt0"] + SCREW["kt1"] * J + SCREW["kt2"] * J * J


def mmg(U, beta=0.0, yaw=0.0, delta=0.0, n=REVOLUTIONS):
    """Forces on a towed KVLCC2, thrust, and what the gauge at the rudder shows: the MMG model."""
    v, r = -math.sin(beta), yaw
    at_screw = beta - SCREW["xp"] * r
    limit = SCREW["C2_positive"] if at_screw > 0 else SCREW["C2_negative"]
    faster = 1.0 + (1.0 - math.exp(-SCREW["C1"] * abs(at_screw))) * (limit - 1.0)
    uP = U * math.cos(beta) * (1.0 - SCREW["wp"]) * faster
    D = SCREW["D"]
    J = uP / (n * D)
    thrust = 1000.0 * n**2 * D**4 * kt(J)
    eta = D / BLADE["height"]
    jet = 1.0 + BLADE["kappa"] * (math.sqrt(1.0 + 8.0 * kt(J) / (math.pi * J**2)) - 1.0)
    uR = BLADE["epsilon"] * uP * math.sqrt(eta * jet**2 + 1.0 - eta)
    at_rudder = beta - BLADE["lR"] * r
    vR = U * BLADE["gamma_positive" if at_rudder > 0 else "gamma_negative"] * at_rudder
    FN = 0.5 * 1000.0 * BLADE["area"] * BLADE["lift_slope"] * (uR**2 + vR**2)
    FN *= math.sin(delta - math.atan2(vR, uR))
    q = 0.5 * 1000.0 * 7.0 * 0.46 * U**2
    h = HULL
    X = -h["R0"] * math.cos(beta) ** 2 + h["Xvv"] * v**2 + h["Xvvvv"] * v**4
    X += h["Xvr"] * v * r + h["Xrr"] * r**2
    Y, N = (
        h[f"{a}v"] * v
        + h[f"{a}r"] * r
        + h[f"{a}vvv"] * v**3
        + h[f"{a}vvr"] * v**2 * r
        + h[f"{a}vrr"] * v * r**2
        + h[f"{a}rrr"] * r**3
        for a in "YN"
    )
    side, arm = 1.0 + BLADE["aH"], -0.5 + BLADE["aH"] * BLADE["xH"]
    return {
        "X": q * X + (1 - SCREW["t"]) * thrust - (1 - BLADE["tR"]) * FN * math.sin(delta),
        "Y": q * Y - side * FN * math.cos(delta),
        "N": 7.0 * (q * N - arm * FN * math.cos(delta)),
        "T": thrust,
        "FY_rudder": -FN,
    }


def run(name, test, forces, **settings):
    data = xr.Dataset({channel: ((), value) for channel, value in forces.items()})
    return Run(id=name, test=test, kind="means", loader=lambda: data, settings=Settings(**settings))


def towed(test, U=U0, drift_deg=0.0, rudder_deg=0.0, yaw=0.0, gauge=True):
    """A run of the virtual ship with its propeller turning."""
    beta, delta = math.radians(drift_deg), math.radians(rudder_deg)
    forces = mmg(U, beta, yaw, delta)
    if not gauge:
        del forces["FY_rudder"]
    settings = {"speed": U, "drift": beta, "rudder": delta, "propeller_rps": REVOLUTIONS}
    if yaw:
        settings["yaw_rate"] = yaw * U / 7.0
    name = f"{test}_{U}_{drift_deg}_{rudder_deg}_{yaw}"
    return run(name, test, forces, **settings)


def resistance_tests():
    q = 0.5 * 1000.0 * 7.0 * 0.46
    return [
        run(f"R{U}", "resistance", {"X": -q * HULL["R0"] * U**2}, speed=U)
        for U in (0.8, 0.9, 1.0, 1.1, 1.2)
    ]


def rudder_tests():
    for U in (1.179, 0.9, 0.6):
        for delta in (-30, -20, -10, 0, 10, 20, 30):
            yield towed("static_rudder", U, rudder_deg=delta)


def drift_tests():
    for beta in (-20, -14, -8, -4, 4, 8, 14, 20):
        yield towed("static_drift", drift_deg=beta)
        for delta in (-15, 15):
            yield towed("drift_rudder", drift_deg=beta, rudder_deg=delta)


def circle_tests(gauge):
    for beta in (-12, -6, 0, 6, 12):
        for yaw in (-0.6, -0.4, -0.2, 0.2, 0.4, 0.6):
            yield towed("circular_motion", drift_deg=beta, yaw=yaw, gauge=gauge)


def campaign(*runs, **more):
    J = np.linspace(0.0, 1.0, 41)
    curve = {"J": J, "KT": kt(J), "KQ": 0.03 - 0.02 * J}
    propeller = more.pop("propeller", {"D": SCREW["D"], "open_water": curve})
    return Campaign(title="virtual", ship=SHIP, water=WATER, runs=runs, propeller=propeller, **more)


def reduced(*runs, **more):
    return reduce_campaign(campaign(*runs, **more), structure="mmg", check=False)


@pytest.fixture(scope="module")
def virtual():
    return Parts.of(reduced(*resistance_tests(), *rudder_tests(), *drift_tests()), **KNOWN)


# A virtual ship


def test_the_propeller_of_a_virtual_ship_is_found_again(virtual):
    found = virtual.propeller.values
    for name, value in SCREW.items():
        assert found[name] == pytest.approx(value, rel=1e-6), name


def test_the_rudder_of_a_virtual_ship_is_found_again(virtual):
    found = virtual.rudder.values
    for name in ("epsilon", "kappa", "gamma_positive", "gamma_negative", "tR", "aH", "xH"):
        assert found[name] == pytest.approx(BLADE[name], rel=1e-6), name
    assert found["eta"] == pytest.approx(0.216 / 0.345)


def test_what_is_assumed_says_so(virtual):
    for name in ("lift_slope", "lR", "rate_deg_s"):
        assert virtual.rudder.source_of(name) == KNOWN["assumed"]
    for name in ("epsilon", "gamma_positive", "aH"):
        assert virtual.rudder.source_of(name).startswith("measured")
    assert virtual.propeller.source_of("wp").startswith("measured")
    assert virtual.runs == {"straight ahead": 21, "in drift": 24}


@pytest.mark.slow
def test_a_rudder_not_quite_amidships_is_noticed_and_costs_nothing():
    """A rudder that stands 2° to starboard of its mark: a note, and the same ε, κ and aH."""
    shifted = [
        towed("static_rudder", U, rudder_deg=delta + 2).with_(
            settings=Settings(speed=U, rudder=math.radians(delta), propeller_rps=REVOLUTIONS)
        )
        for U in (1.179, 0.9, 0.6)
        for delta in (-30, -20, -10, 0, 10, 20, 30)
    ]
    found = Parts.of(reduced(*resistance_tests(), *shifted, *drift_tests()), **KNOWN)
    assert any("+2.00°" in note for note in found.notes)
    assert found.rudder.values["epsilon"] == pytest.approx(1.09, rel=1e-6)
    assert found.rudder.values["kappa"] == pytest.approx(0.5, rel=1e-6)
    assert found.rudder.values["aH"] == pytest.approx(0.312, rel=0.02)


@pytest.mark.slow
def test_only_the_product_of_lift_slope_and_inflow_squared_is_measured():
    """A lift slope assumed 20 % too large makes ε smaller by its square root, κ stays."""
    runs = (*resistance_tests(), *rudder_tests(), *drift_tests())
    found = Parts.of(reduced(*runs), **{**KNOWN, "lift_slope": 1.2 * 2.747}).rudder.values
    assert found["epsilon"] == pytest.approx(1.09 / math.sqrt(1.2), rel=1e-6)
    assert found["kappa"] == pytest.approx(0.50, rel=1e-6)
    assert found["gamma_positive"] == pytest.approx(0.64 / math.sqrt(1.2), rel=1e-6)


@pytest.mark.slow
def test_what_is_missing_is_named():
    with pytest.raises(MissingPartError, match=r"static_rudder.*resistance"):
        Parts.of(reduced(*drift_tests()), **KNOWN)
    runs = (*resistance_tests(), *rudder_tests(), *drift_tests())
    with pytest.raises(MissingPartError, match="open_water"):
        Parts.of(reduced(*runs, propeller={"D": 0.216}), **KNOWN)


@pytest.mark.slow
def test_a_rotating_arm_changes_nothing_in_the_thrust_deduction():
    """Circles without drift are no straight runs: their X holds Xrr r'²."""
    runs = (*resistance_tests(), *rudder_tests(), *drift_tests(), *circle_tests(gauge=False))
    found = reduced(*runs).propulsion
    assert found.thrust_deduction == pytest.approx(0.22, rel=1e-6)


@pytest.mark.slow
def test_a_rotating_arm_changes_nothing_in_wake_and_rudder():
    runs = (*resistance_tests(), *rudder_tests(), *drift_tests(), *circle_tests(gauge=True))
    found = Parts.of(reduced(*runs), **KNOWN)
    for name in ("epsilon", "kappa", "gamma_positive", "tR", "aH"):
        assert found.rudder.values[name] == pytest.approx(BLADE[name], rel=1e-6), name
    for name in ("wp", "C2_positive", "C2_negative"):
        assert found.propeller.values[name] == pytest.approx(SCREW[name], rel=1e-6), name


@pytest.fixture(scope="module")
def hulls(virtual):
    """Derivatives with the rudder amidships, and of the hull alone, of the virtual ship."""
    static = [x for x in drift_tests() if x.test == "static_drift"]
    straight = towed("static_drift")
    table = reduced(*static, straight, *circle_tests(gauge=False)).table
    alone = virtual.hull_alone(table, speed=U0, revolutions=REVOLUTIONS)
    return table.at(), alone.at()


def test_the_hull_alone_of_a_virtual_ship_is_found_again(hulls):
    """The rudder's forces are no polynomial, so that its fit leaves some thousandths."""
    _, alone = hulls
    for name in ("Yv", "Yr", "Nv", "Nr"):
        assert alone[name] == pytest.approx(HULL[name], rel=4e-3), name
    for name in ("Yvvv", "Yvvr", "Yvrr", "Nvvr", "Nvrr"):
        assert alone[name] == pytest.approx(HULL[name], rel=0.03), name


def test_a_rudder_amidships_steadies_a_ship(hulls):
    """Behind the ship it adds sway force and yaw damping, and takes from the Munk moment."""
    whole, alone = hulls
    assert whole["Yv"] < 1.05 * alone["Yv"] < 0
    assert whole["Nr"] < 1.1 * alone["Nr"] < 0
    assert alone["Nv"] < 1.05 * whole["Nv"] < 0
    assert whole["Yr"] > 1.1 * alone["Yr"]


def test_a_rudder_without_lift_takes_nothing_off_the_hull(virtual):
    table = reduced(*[x for x in drift_tests() if x.test == "static_drift"]).table
    blade = replace(virtual.rudder, values={**virtual.rudder.values, "lift_slope": 0.0})
    alone = replace(virtual, rudder=blade).hull_alone(table, speed=U0, revolutions=REVOLUTIONS)
    np.testing.assert_array_equal(alone.value, table.value)
    np.testing.assert_array_equal(alone.covariance, table.covariance)


# KVLCC2 at HMRI


@pytest.fixture(scope="module")
def hmri(kept, shared_data, datasets):
    if not (shared_data / "kvlcc2_hmri_pmm").is_dir():
        pytest.skip("the HMRI measurements are not on this machine")
    return large.hmri(kept, datasets, shared_data)


@pytest.fixture(scope="module")
def measured(hmri):
    scale = 320.0 / hmri.campaign.ship.L
    given = KNOWN | {"area": 112.5 / scale**2, "height": 15.8 / scale}
    return Parts.of(hmri, **given)


@pytest.mark.slow
@pytest.mark.parametrize("name", PARTS)
def test_parts_of_kvlcc2_are_those_kept_for_the_page_of_published_figures(measured, name):
    values = {**measured.propeller.values, **measured.rudder.values}
    assert values[name] == pytest.approx(measurements.kept("hmri")()[name], rel=1e-4)


@pytest.mark.slow
def test_standard_errors_are_of_the_size_of_the_differences(measured):
    for name in ("t", "epsilon", "kappa", "gamma_positive", "gamma_negative", "tR", "aH", "wp"):
        assert 1e-3 < measured.std[name] < 0.1, name


@pytest.mark.slow
def test_bollard_pull_of_the_open_water_curve(measured):
    """KT .3113 at J = 0 in HMRI's table; the fit over J to 0.8 meets it to 1 %."""
    assert measured.propeller.values["kt0"] == pytest.approx(0.3113, rel=0.01)


@pytest.mark.slow
def test_wake_and_open_water_give_back_the_thrust_of_the_static_tests(measured):
    """T' = 1.22e-3 of ½ρL²U² straight ahead at 1.1702 m/s and 9.9 1/s."""
    c = measured.propeller.values
    J = (1 - c["wp"]) * 1.1702 / (9.9 * 0.2124)
    thrust = 9.9**2 * 0.2124**4 * (c["kt0"] + c["kt1"] * J + c["kt2"] * J**2)
    assert thrust / (0.5 * 6.8927**2 * 1.1702**2) == pytest.approx(1.22e-3, rel=0.02)


@pytest.mark.slow
def test_rudder_amidships_of_kvlcc2_steadies_it(hmri, measured):
    full = np.isfinite(hmri.table["Yv"])
    (place,) = np.flatnonzero(full)
    alone = measured.hull_alone(hmri.table, speed=1.1702, revolutions=9.9)
    change = {
        name: float(hmri.table[name][place] - alone[name][place])
        for name in ("Yv", "Yr", "Nv", "Nr")
    }
    assert change["Yv"] < 0 < change["Nv"]
    assert change["Nr"] < 0 < change["Yr"]
    assert float(alone["Nv"][place]) == pytest.approx(-0.137, rel=0.1)
    assert float(alone["Yv"][place]) == pytest.approx(-0.315, rel=0.1)


@pytest.mark.slow
def test_static_drift_of_kvlcc2_is_the_cubic_of_its_means(hmri):
    """What the page of published figures keeps of it."""
    found = reduce_campaign(hmri.campaign, structure="Yv Yvvv Nv Nvvv", check=False)
    wanted = measurements.kept("static_drift")()
    assert found.families["static drift"].at() == pytest.approx(wanted, rel=1e-4)


# Whose tests make the uncertainty

SLOPES = {"Yv": 1.0, "Nv": -2.0, "Yvdot": 0.5, "Yvvv": 0.02}
FEW = "Yv Yvvv Nv Nvvv Yvdot Nvdot"
SIZES = {"X": 0.4, "Y": 1.2, "N": 2.5}


def few_tests(**more):
    """Static drift and pure sway of the S175, at one speed."""
    chosen = [x for x in programme((1.5,)) if x[1] in ("static_drift", "pure_sway")]
    made = captive(runs=chosen, per_cycle=32, **more)
    return reduce_campaign(made, structure=FEW, check=False)


def noise(seed, of_sway=1.0):
    """White noise; that of static drift is the same for every seed."""

    def draw(channel, speed, n, number):
        sway = number >= 70
        generator = np.random.default_rng([seed if sway else 0, ord(channel), number])
        return (of_sway if sway else 1.0) * SIZES[channel] * generator.normal(size=n)

    return draw


def variance(found, slopes):
    """g' C g of the covariance of the table."""
    g = np.array([slopes.get(name, 0.0) for name in found.table.names])
    return float(g @ np.nan_to_num(found.table.covariance[0, :, 0, :]) @ g)


UNSURE = (
    TypeB(name="Y_gauge", std=0.15, shared=True),
    TypeB(name="N_gauge", std=0.002, relative=True, shared=True),
    TypeB(name="drift", std=math.radians(0.03), shared=True),
    TypeB(name="drift", std=math.radians(0.02)),
    TypeB(name="speed", std=0.001),
)


@pytest.mark.slow
@pytest.mark.parametrize("uncertainty", [(), UNSURE], ids=["noise", "noise and settings"])
def test_shares_sum_to_the_variance_of_the_result(uncertainty):
    found = few_tests(noise=noise(3), uncertainty=uncertainty)
    shares = contributions(found, SLOPES)
    assert shares["share"].sum() == pytest.approx(1.0)
    assert (shares["std"] ** 2).sum() == pytest.approx(variance(found, SLOPES), rel=1e-9)
    assert (shares["share"].diff().dropna() <= 0).all()
    assert shares.loc["static_drift", "runs"] == 7
    assert shares.loc["pure_sway", "runs"] == 3


def test_a_result_that_asks_nothing_of_a_test_owes_it_nothing():
    """Static drift says nothing about the added mass beyond the gain that a run of sway shares."""
    found = few_tests(noise=noise(3))
    shares = contributions(found, {"Yvdot": 1.0})
    assert shares.loc["pure_sway", "share"] > 0.9


def test_a_gauge_that_all_runs_share_has_the_closed_form():
    """1 % of every Y is 1 % of Yv, .2 % of the density .2 %; without noise they are nearly all."""
    found = few_tests(
        uncertainty=(
            TypeB(name="Y_gauge", std=0.01, relative=True, shared=True),
            TypeB(name="rho", std=0.002, relative=True, shared=True),
        )
    )
    shares = contributions(found, {"Yv": 1.0})
    gauge, water = "gauge of Y: calibration", "density of the water"
    assert shares.loc[gauge, "std"] == pytest.approx(-0.01 * SON_NOMOTO["Yv"], rel=1e-6)
    assert shares.loc[water, "std"] == pytest.approx(-0.002 * SON_NOMOTO["Yv"], rel=1e-6)
    assert shares.loc[gauge, "share"] == pytest.approx(25 / 26, rel=1e-4)


@pytest.mark.slow
@pytest.mark.parametrize("of_sway", [1.0, 2.0])
def test_the_share_of_a_test_is_the_scatter_that_its_noise_makes(of_sway):
    """Twenty programmes that differ in the noise of pure sway alone, as it is and doubled."""
    said = contributions(few_tests(noise=noise(1, of_sway)), SLOPES).loc["pure_sway", "std"]
    results = []
    for seed in range(100, 120):
        values = few_tests(noise=noise(seed, of_sway)).table.at()
        results.append(sum(slope * values[name] for name, slope in SLOPES.items()))
    assert np.std(results, ddof=1) == pytest.approx(said, rel=0.4)
