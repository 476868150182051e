"""The recorded speed of the carriage: it stands for the stated one, and is checked against both."""

from __future__ import annotations

import math

import numpy as np
import pytest
import xarray as xr
from own_tank import U, drift, sway, write, yaw

import pmmkit as pk
from pmmkit import Run
from pmmkit.campaigns import Settings
from pmmkit.intake import CheckFinding, look

T = np.arange(0.0, 40.0, 0.05)
OMEGA = 2 * math.pi / 10.0


def run_of(test: str, **settings: float) -> Run:
    return Run(
        id="A", test=test, kind="history", loader=None, settings=Settings(speed=1.5, **settings)
    )


def moved(run: Run, speed, **columns):
    named = {"U_carriage": speed + 0 * T, **columns}
    data = xr.Dataset({name: ("t", x) for name, x in named.items()}, coords={"t": T})
    return run.measured_motion(data, T)


def test_a_static_drift_is_towed_at_the_recorded_speed():
    """u = U cos β, v = -U sin β."""
    noise = 0.01 * np.random.default_rng(0).normal(size=T.size)
    found = moved(run_of("static_drift", drift=0.2), 1.46 + noise)
    mean = float(np.mean(1.46 + noise))
    np.testing.assert_allclose(found.u, mean * math.cos(0.2))
    np.testing.assert_allclose(found.v, -mean * math.sin(0.2))
    assert not found.udot.any()


def test_a_recorded_heading_counts_with_it():
    found = moved(run_of("static_drift", drift=0.2), 1.46, psi=0.21 + 0 * T, x=0 * T)
    np.testing.assert_allclose(found.v, -1.46 * math.sin(0.21))


def test_a_circle_of_a_radius_turns_as_fast_as_its_carriage_runs():
    found = moved(run_of("circular_motion", radius=12.0), 1.44)
    np.testing.assert_allclose(found.r, 0.12)


@pytest.mark.parametrize(
    ("test", "settings"),
    [
        ("pure_sway", {"amplitude": 0.3}),
        ("pure_surge", {"amplitude": 0.3}),
        ("sway_yaw", {"amplitude": 0.3, "yaw_amplitude": 0.1}),
        ("yaw_drift", {"yaw_amplitude": 0.2, "drift": 0.1}),
    ],
)
def test_an_oscillation_keeps_its_swing_on_a_carriage_that_is_faster(test, settings):
    """Along the tank the hull has 0.04 m/s more, across it what the oscillator does."""
    run = run_of(test, period=10.0, **settings)
    noise = 0.01 * np.random.default_rng(1).normal(size=T.size)
    found, set_to = moved(run, 1.54 + noise), run.nominal_motion(T)
    psi = run.kind_of_test.in_tank(run.settings, OMEGA * T).psi
    more = float(np.mean(1.54 + noise)) - 1.5
    np.testing.assert_allclose(found.u, set_to.u + more * np.cos(psi), atol=1e-12)
    np.testing.assert_allclose(found.v, set_to.v - more * np.sin(psi), atol=1e-12)
    np.testing.assert_allclose(found.r, set_to.r, atol=1e-12)


def test_the_speed_set_gives_the_nominal_motion():
    run = run_of("pure_yaw", period=10.0, yaw_amplitude=0.2)
    found, set_to = moved(run, 1.5), run.nominal_motion(T)
    for name in ("u", "v", "r", "udot", "vdot", "rdot"):
        np.testing.assert_allclose(getattr(found, name), getattr(set_to, name), atol=1e-12)


def test_a_carriage_that_keeps_the_hull_at_one_speed_in_yaw():
    """U = Uh cos ψ: u is constant, which the nominal motion at a constant carriage speed denies."""
    run = run_of("pure_yaw", period=10.0, yaw_amplitude=0.25)
    psi = 0.25 * np.sin(OMEGA * T)
    found = moved(run, 1.5 * np.cos(psi), y=np.cumsum(1.5 * np.sin(psi)) * 0.05, psi=psi)
    np.testing.assert_allclose(found.u, 1.5, rtol=2e-3)
    np.testing.assert_allclose(found.udot, 0.0, atol=5e-3)


def test_a_surge_that_the_carriage_makes_is_not_counted_twice():
    run = run_of("pure_surge", period=10.0, amplitude=0.3)
    found = moved(run, 1.5 + 0.3 * OMEGA * np.cos(OMEGA * T))
    np.testing.assert_allclose(found.u, 1.5 + 0.3 * OMEGA * np.cos(OMEGA * T), atol=1e-9)
    np.testing.assert_allclose(found.udot, -0.3 * OMEGA**2 * np.sin(OMEGA * T), atol=1e-9)


def test_a_recorded_u_counts_before_it():
    found = moved(run_of("static_drift", drift=0.1), 1.4, u=1.5 + 0 * T, v=-0.1 + 0 * T)
    np.testing.assert_allclose(found.u, 1.5)


def said(folder, check="carriage") -> list[CheckFinding]:
    return [item for item in pk.examine(pk.open_campaign(folder)) if item.check == check]


TESTS = (drift(8.0), sway(9.0, 0.3), yaw(9.0, 10.0))


def test_a_sound_record_has_nothing_to_tell(tmp_path):
    write(tmp_path / "c", TESTS, columns=("U_carriage", "u", "v", "r"), rest=2.0, ramp=4.0)
    assert said(tmp_path / "c") == []


@pytest.mark.parametrize(("factor", "severity"), [(1.05, "warning"), (3.6, "error")])
def test_another_speed_than_stated_is_told(factor, severity, tmp_path):
    write(tmp_path / "c", TESTS, extra=lambda x: {"U_carriage": factor * x["U_carriage"]}, ramp=4.0)
    (found,) = said(tmp_path / "c")
    assert found.severity == severity
    assert len(found.runs) == 3
    assert found.numbers["carriage"] == pytest.approx(factor * U, rel=2e-3)
    assert "state" in found.message


def test_velocities_that_are_not_the_hulls_are_told(tmp_path):
    """u and v along and across the hull's path, not its axes: 8° and 8 % too fast."""
    write(
        tmp_path / "c",
        TESTS,
        columns=("U_carriage",),
        extra=lambda x: {"u": 1.08 * x["u"], "v": 1.08 * x["v"], "r": x["r"]},
    )
    (found,) = said(tmp_path / "c")
    assert "u cos ψ - v sin ψ" in found.message
    assert found.numbers["other"] == pytest.approx(1.08 * U, rel=2e-3)


@pytest.mark.parametrize(
    "header",
    ["U_carriage [m/s]", "Carriage speed [m/s]", "Schleppgeschwindigkeit [m/s]", "台車速度"],
)
def test_it_is_found_by_its_usual_names(header, tmp_path):
    t = np.arange(0.0, 20.0, 0.05)
    rows = "\n".join(f"{x:.3f},-20.1,3.2,1.1,1.2" for x in t)
    text = f"t [s],X [N],Y [N],N [Nm],{header}\n{rows}\n"
    (tmp_path / "run.csv").write_text(text, encoding="utf-8")
    (group,) = look(tmp_path / "run.csv").groups
    assert "U_carriage" in group.first.known
