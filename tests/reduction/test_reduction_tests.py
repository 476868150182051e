"""Every kind of captive test gives its derivatives: rudder, heel, circles, surge, propulsion."""

from __future__ import annotations

import math

import numpy as np
import pytest
import xarray as xr

from pmmkit import Campaign, Run
from pmmkit.campaigns import Settings
from pmmkit.conventions import Water
from pmmkit.reduction import reduce_campaign
from scripts.datasets.virtual_tank import SHIP, SON_NOMOTO, WATER, captive, history, water_forces

T = np.arange(400) * 0.1


def unit(speed, channel="Y"):
    arm = SHIP.L if channel in "NK" else 1.0
    return 0.5 * WATER.rho * SHIP.L**2 * speed**2 * arm


def still(name, test, forces, *, speed=1.5, kind="history", **settings):
    """A run with constant forces; extra channels ride along."""
    if kind == "history":
        data = history(T, {channel: np.full(len(T), value) for channel, value in forces.items()})
    else:
        data = xr.Dataset({channel: ((), value) for channel, value in forces.items()})
    return Run(
        id=name,
        test=test,
        kind=kind,
        loader=lambda: data,
        settings=Settings(speed=speed, **settings),
    )


def of(*runs, **more):
    return Campaign(title="t", ship=SHIP, water=more.pop("water", WATER), runs=runs, **more)


def test_static_rudder_and_drift_with_rudder():
    truth = {"Yd": -0.0027, "Yddd": 0.0045, "Nd": 0.0013, "Nddd": -0.0022, "Xdd": -0.002}
    runs = []
    for number, (beta, delta) in enumerate(
        [(b, d) for b in (-8, 0, 4, 8) for d in (-30, -20, -10, 0, 10, 20, 30)]
    ):
        v, d = -math.sin(math.radians(beta)), math.radians(delta)
        hull = water_forces(SON_NOMOTO, 1.5 * math.cos(math.radians(beta)), 1.5 * v, 0, 0, 0, 0)
        rudder = {
            "X": unit(1.5) * truth["Xdd"] * d**2,
            "Y": unit(1.5) * (truth["Yd"] * d + truth["Yddd"] * d**3 - 0.06 * v**2 * d),
            "N": unit(1.5, "N") * (truth["Nd"] * d + truth["Nddd"] * d**3),
        }
        runs.append(
            still(
                f"r{number}",
                "drift_rudder" if beta else "static_rudder",
                {channel: hull[channel] + rudder[channel] for channel in hull},
                drift=math.radians(beta),
                rudder=d,
            )
        )
    found = reduce_campaign(of(*runs), structure="Xuu Xvv Yv Yvvv Nv Nvvv", check=False)
    values = found.table.at()
    for name, value in truth.items():
        assert values[name] == pytest.approx(value, rel=1e-6)
    assert values["Yvvd"] == pytest.approx(-0.06, rel=1e-6)
    assert values["Yv"] == pytest.approx(SON_NOMOTO["Yv"], rel=1e-6)
    assert {"static rudder"} <= set(found.families)


def test_heel_runs_add_heel_derivatives_and_the_roll_moment():
    runs = []
    for number, (beta, phi) in enumerate([(b, f) for b in (-6, 0, 6) for f in (-10, -5, 0, 5, 10)]):
        v, p = -math.sin(math.radians(beta)), math.radians(phi)
        runs.append(
            still(
                f"h{number}",
                "static_heel",
                {
                    "Y": unit(1.5) * (-0.0116 * v - 0.000063 * p),
                    "N": unit(1.5, "N") * (-0.0038545 * v - 0.0001424 * p),
                    "K": unit(1.5, "K") * (0.0003026 * v - 0.000021 * p),
                },
                drift=math.radians(beta),
                heel=p,
            )
        )
    values = reduce_campaign(of(*runs), structure="Yv Nv Kv Kphi", check=False).table.at()
    assert values["Yphi"] == pytest.approx(-0.000063)
    assert values["Nphi"] == pytest.approx(-0.0001424)
    assert values["Kphi"] == pytest.approx(-0.000021)


@pytest.mark.parametrize("given", ["yaw_rate", "radius"])
def test_circular_motion_with_drift(given):
    """A rotating arm gives the yaw derivatives without any acceleration."""
    runs = []
    for number, (beta, rate) in enumerate([(b, r) for b in (-8, 0, 4, 8) for r in (0.2, 0.4, 0.6)]):
        b, r = math.radians(beta), rate * 1.5 / SHIP.L
        force = water_forces(SON_NOMOTO, 1.5 * math.cos(b), -1.5 * math.sin(b), r, 0, 0, 0)
        setting = {"yaw_rate": r} if given == "yaw_rate" else {"radius": 1.5 / r}
        runs.append(still(f"c{number}", "circular_motion", force, drift=b, **setting))
    found = reduce_campaign(of(*runs), check=False)
    values = found.table.at()
    for name in ("Yr", "Nr", "Nrrr", "Nvvr", "Yvrr", "Xvr", "Xrr"):
        assert values[name] == pytest.approx(SON_NOMOTO[name], rel=1e-6)
    assert math.isnan(values["Yvdot"])


def test_circular_motion_on_a_balance_has_the_centrifugal_force():
    runs = []
    for number, (beta, rate) in enumerate([(b, r) for b in (-8, 0, 4, 8) for r in (0.2, 0.4, 0.6)]):
        b, r = math.radians(beta), rate * 1.5 / SHIP.L
        u, v = 1.5 * math.cos(b), -1.5 * math.sin(b)
        force = dict(water_forces(SON_NOMOTO, u, v, r, 0, 0, 0))
        force["Y"] -= SHIP.mass * r * u
        force["X"] += SHIP.mass * r * v
        runs.append(
            still(f"c{number}", "circular_motion", force, drift=b, yaw_rate=r).with_(
                forces="balance"
            )
        )
    values = reduce_campaign(of(*runs, forces="balance"), check=False).table.at()
    assert values["Yr"] == pytest.approx(SON_NOMOTO["Yr"], rel=1e-6)
    assert values["Xvr"] == pytest.approx(SON_NOMOTO["Xvr"], rel=1e-6)


def test_pure_surge_gives_the_surge_added_mass():
    period, a, U = 8.0, 0.3, 1.5
    t = np.arange(320) * 0.1
    omega = 2 * math.pi / period
    u, udot = U + a * omega * np.cos(omega * t), -a * omega**2 * np.sin(omega * t)
    q = 0.5 * WATER.rho * SHIP.L**2
    X = q * -0.0004226 * u**2 + 0.5 * WATER.rho * SHIP.L**3 * -0.000238 * udot
    run = Run(
        id="s",
        test="pure_surge",
        kind="history",
        loader=lambda: history(t, {"X": X}),
        settings=Settings(speed=U, period=period, amplitude=a),
    )
    values = reduce_campaign(of(run), structure="Xuu Xudot", check=False).table.at()
    assert values["Xuu"] == pytest.approx(-0.0004226, rel=1e-8)
    assert values["Xudot"] == pytest.approx(-0.000238, rel=1e-8)


def test_resistance_and_self_propulsion():
    """R = 9 U² + U³ and t = .18; the wake by thrust identity is .25 on a straight KT curve."""
    rho, D, t = WATER.rho, 0.18, 0.18
    speeds = (1.2, 1.4, 1.6, 1.8)

    def resistance(U):
        return 9 * U**2 + U**3

    runs = [still(f"R{U}", "resistance", {"X": -resistance(U)}, speed=U) for U in speeds]
    for rps in (7.0, 8.0, 9.0):
        J = 0.75 * 1.5 / (rps * D)
        thrust = rho * rps**2 * D**4 * (0.527 - 0.455 * J)
        force = {"X": (1 - t) * thrust - resistance(1.5), "T": thrust}
        runs.append(still(f"P{rps}", "propulsion", force, speed=1.5, propeller_rps=rps))
    J = np.linspace(0, 1.1, 23)
    curve = {"J": J, "KT": 0.527 - 0.455 * J, "KQ": 0.06 - 0.04 * J}
    found = reduce_campaign(
        of(*runs, propeller={"D": D, "open_water": curve}), structure="Xuu", check=False
    )
    assert found.resistance.at(np.array([1.5]))[0] == pytest.approx(resistance(1.5), rel=1e-9)
    assert np.isnan(found.resistance.at(np.array([2.5]))[0])
    assert found.propulsion.thrust_deduction == pytest.approx(t, abs=1e-9)
    assert found.propulsion.wake[1.5] == pytest.approx(0.25, abs=1e-3)


@pytest.mark.slow
def test_means_and_harmonics_of_a_table_give_what_the_histories_give():
    """The same tests as histories and as a laboratory's table of means and harmonics."""
    full = captive()
    listed = []
    for run, result in zip(full, reduce_campaign(full, check=False).runs, strict=True):
        values = result.measured
        if run.test == "static_drift":
            data = xr.Dataset({channel: ((), row[0]) for channel, row in values.items()})
            kind = "means"
        else:
            order = np.arange(4)
            data = xr.Dataset(coords={"harmonic": order})
            for channel, row in values.items():
                data[f"{channel}_cos"] = ("harmonic", [row[0], row[1], row[3], row[5]])
                data[f"{channel}_sin"] = ("harmonic", [0.0, row[2], row[4], row[6]])
            kind = "harmonics"
        listed.append(run.with_(kind=kind, loader=lambda data=data: data))
    found = reduce_campaign(full.with_(runs=tuple(listed)), check=False)
    for name, value in found.table.at().items():
        assert value == pytest.approx(SON_NOMOTO[name], rel=2e-3)


@pytest.mark.slow
def test_a_missing_mean_is_left_out_not_taken_as_zero():
    full = captive()
    runs = tuple(run.with_(use_means=False) if run.dynamic else run for run in full)
    found = reduce_campaign(full.with_(runs=runs), check=False)
    assert np.isnan(next(r for r in found.runs if r.run.dynamic).measured["Y"][0])
    for name, value in found.table.at().items():
        assert value == pytest.approx(SON_NOMOTO[name], rel=1e-9)


def test_sinkage_and_trim_are_reported():
    run = still("a", "static_drift", {"Y": 1.0, "N": 2.0, "sinkage": 0.004, "trim": 0.001})
    frame = reduce_campaign(of(run), structure="Yv Nv", check=False).runs_to_pandas()
    assert frame["sinkage_mean"][0] == pytest.approx(0.004)
    assert frame["trim_mean"][0] == pytest.approx(0.001)
    assert frame["Y_mean"][0] == pytest.approx(1.0)


def test_blockage_is_reported_and_corrected_on_request():
    """A narrow tank: m/(1 - m - Fh²) faster water, forces follow with twice that."""
    tank = Water(rho=WATER.rho, g=WATER.g, tank_width=4.0, tank_depth=2.0)
    runs = tuple(r for r in captive() if r.test == "static_drift")
    plain = of(*runs, water=tank)
    reported = reduce_campaign(plain, structure="Yv Yvvv", check=False)
    note = next(note for note in reported.notes if note.startswith("Blockage"))
    assert "not corrected" in note
    corrected = reduce_campaign(plain, structure="Yv Yvvv", blockage="correct", check=False)
    section = SHIP.B * SHIP.d / 8.0
    faster = 1 + section / (1 - section - 1.5**2 / (9.81 * 2.0))
    assert corrected.table["Yv"][0] == pytest.approx(SON_NOMOTO["Yv"] / faster**2, rel=1e-9)


def test_only_the_third_cycle_as_in_the_cfd_paper():
    """Five cycles of which only the third is right."""
    run = next(r for r in captive(cycles=5.0) if r.test == "pure_sway")
    data = run.data
    factor = np.ones(data.sizes["t"])
    factor[:128] = 1.3
    factor[192:] = 0.7
    spoiled = run.with_(loader=lambda: data * factor)
    structure = "Yv Yvvv Yvdot"
    third = reduce_campaign(of(spoiled), structure=structure, cycles=3, check=False)
    assert third.runs[0].cycles == 1
    assert third.table.at()["Yvdot"] == pytest.approx(SON_NOMOTO["Yvdot"], rel=1e-9)


def test_a_wrong_period_is_found_in_the_record():
    full = captive(cycles=8.0)
    run = next(r for r in full if r.test == "pure_sway")
    said = run.with_(
        settings=Settings(**{**run.settings.__dict__, "period": run.settings.period * 1.02})
    )
    found = reduce_campaign(of(said), structure="Yv Yvvv Yvdot", check=False)
    assert any("the record counts" in note for note in found.notes)
    assert found.runs[0].frequency == pytest.approx(run.settings.omega, rel=1e-3)


@pytest.mark.slow
def test_a_few_derivatives_from_all_tests():
    """A list of sway derivatives leaves the yaw tests without anything to find."""
    found = reduce_campaign(captive(), structure="Yv Yvvv Nv Nvvv", check=False)
    assert "pure yaw" not in found.families
    assert found.families["static drift"].at()["Yv"] == pytest.approx(SON_NOMOTO["Yv"])
