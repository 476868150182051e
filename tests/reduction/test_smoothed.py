"""Cycles that a laboratory filtered, averaged and fitted before it handed them in."""

import math

import numpy as np
import pytest
import xarray as xr

from pmmkit.campaigns import Campaign, Run, Settings
from pmmkit.conventions import Ship, Water
from pmmkit.reduction import reduce_campaign

SHIP = Ship(name="model", L=4.367, B=0.611, d=0.205, volume=0.3566, mass=356.5, Izz=445.8)
WATER = Water(rho=1000.0)
TRUE = {"Yv": -15e-3, "Yr": 2.3e-3, "Yvvv": -0.3, "Yvdot": -10.6e-3,
        "Nv": -6.7e-3, "Nr": -2.3e-3, "Nvvv": -0.03, "Nrdot": -0.43e-3}  # fmt: skip
REPEATABILITY = {"Y": 0.15, "N": 0.2}
POINTS = 24


def force(channel, U, v, r, dv, dr):
    """Of the water, by the true hull [N, N m]."""
    L = SHIP.L
    unit = 0.5 * WATER.rho * L**2 * U**2 * (L if channel == "N" else 1.0)
    terms = {"v": v / U, "r": r * L / U, "vvv": (v / U) ** 3, "vdot": dv * L / U**2,
             "rdot": dr * L**2 / U**2}  # fmt: skip
    return unit * sum(TRUE.get(channel + name, 0.0) * x for name, x in terms.items())


def fitted(values, order=3):
    """The laboratory's short Fourier series of a cycle, written to four decimals."""
    spectrum = np.fft.rfft(values)
    spectrum[order + 1 :] = 0.0
    return np.round(np.fft.irfft(spectrum, len(values)), 4)


def cycle(rng, name, test, speed, period, **motion):
    """One cycle of 24 points; each harmonic has an error that does not shrink with the speed."""
    omega, theta = 2 * math.pi / period, 2 * math.pi * np.arange(POINTS) / POINTS
    v = motion.get("v", 0.0) * np.cos(theta)
    r = motion.get("r", 0.0) * np.cos(theta)
    dv, dr = (
        -omega * motion.get("v", 0.0) * np.sin(theta),
        -omega * motion.get("r", 0.0) * np.sin(theta),
    )
    u = np.full(POINTS, speed)
    data = {"u": u, "v": v, "r": r, "udot": 0 * u, "vdot": dv, "rdot": dr}
    basis = np.column_stack(
        [np.ones(POINTS)] + [f(k * theta) for k in (1, 2, 3) for f in (np.cos, np.sin)]
    )
    for channel, size in REPEATABILITY.items():
        truth = force(channel, np.hypot(u, v), v, r, dv, dr)
        data[channel] = fitted(truth + basis @ (size * rng.normal(size=7)))
    table = xr.Dataset({key: ("t", x) for key, x in data.items()}, coords={"t": theta / omega})
    settings = (
        {"amplitude": motion["v"] / omega}
        if test == "pure_sway"
        else {"yaw_amplitude": motion["r"] / omega}
    )
    return Run(id=name, test=test, kind="history", forces="hydrodynamic", loader=lambda: table,
               settings=Settings(speed=speed, period=period, **settings))  # fmt: skip


def steady(rng, name, speed, drift):
    u, v = speed * math.cos(drift), -speed * math.sin(drift)
    data = {
        channel: round(force(channel, speed, v, 0.0, 0.0, 0.0) + size * rng.normal(), 4)
        for channel, size in REPEATABILITY.items()
    }
    return Run(id=name, test="static_drift", kind="means", forces="hydrodynamic",
               loader=lambda: xr.Dataset(data | {"u": u, "v": v}),
               settings=Settings(speed=speed, drift=drift))  # fmt: skip


def programme(seed):
    """Drift, sway and yaw at three speeds, the fastest with repeats, as shallow tests of KCS go."""
    rng = np.random.default_rng(seed)
    runs = []
    for k, U in enumerate((0.25, 0.5, 0.62)):
        for beta in (-16, -12, -8, -4, -2, 0, 2, 4, 8, 12, 16):
            runs.append(steady(rng, f"D{k}_{beta}", U, math.radians(beta)))
        for n, size in enumerate((0.04, 0.08, 0.12)):
            runs.append(cycle(rng, f"S{k}_{n}", "pure_sway", U, 25.0, v=size * U / 0.62))
            runs.append(cycle(rng, f"Y{k}_{n}", "pure_yaw", U, 40.0, r=0.3 * size))
    runs += [cycle(rng, f"Y2_2{x}", "pure_yaw", 0.62, 40.0, r=0.036) for x in "abcd"]
    return Campaign(title="", ship=SHIP, water=WATER, runs=tuple(runs), forces="hydrodynamic")


@pytest.mark.slow
@pytest.mark.parametrize("fn", ["each", "pooled"])
def test_intervals_of_smoothed_cycles_hold_the_truth(fn):
    """Their own noise, that of rounding, would make them ten thousand times too sure."""
    inside = []
    for seed in range(5):
        found = reduce_campaign(
            programme(seed), structure=list(TRUE), fn=fn, check=False, executor=1
        )
        low, high = found.table.interval()
        for name, value in TRUE.items():
            at = found.table.index(name)
            inside += ((low[:, at] <= value) & (value <= high[:, at])).tolist()
        assert found.verdict.use != "not usable"
        assert any("smoothed before they were handed in" in note for note in found.notes)
    assert 0.85 < np.mean(inside) <= 1.0


def test_harmonics_above_the_fitted_order_say_nothing():
    found = reduce_campaign(programme(0), structure=list(TRUE), check=False, executor=1)
    swung = [item for item in found.runs if item.run.dynamic]
    assert {item.smoothed for item in swung} == {3}
    for item in swung:
        assert np.isfinite(item.measured["Y"][:7]).all()
        assert np.isnan(item.measured["Y"][7:]).all()


def test_a_record_with_noise_of_its_own_is_not_smoothed():
    rng = np.random.default_rng(1)
    run = cycle(rng, "S", "pure_sway", 0.62, 25.0, v=0.1)
    noisy = run.data.assign(Y=run.data["Y"] + 0.01 * rng.normal(size=POINTS))
    made = programme(0)
    made = made.with_(runs=(*made.runs, replace_data(run, noisy)))
    found = reduce_campaign(made, structure=list(TRUE), check=False, executor=1)
    assert next(item for item in found.runs if item.run.id == "S").smoothed is None


def replace_data(run, data):
    return run.with_(loader=lambda: data)


def test_a_run_across_the_flow_is_left_out_with_the_reason():
    made = programme(0)
    across = steady(np.random.default_rng(2), "across", 0.25, math.pi / 2)
    found = reduce_campaign(
        made.with_(runs=(*made.runs, across)), structure=list(TRUE), check=False, executor=1
    )
    plain = reduce_campaign(made, structure=list(TRUE), check=False, executor=1)
    assert np.array_equal(found.table.value, plain.table.value, equal_nan=True)
    (left,) = found.campaign.excluded
    assert left[0].id == "across"
    assert "above 45°" in left[1]
