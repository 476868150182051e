"""Waves that a ship at rest sends out, and what their momentum does."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from pmmkit.seakeeping import Loading, added_resistance, hull_from_particulars, rao, read_hull
from pmmkit.seakeeping.second_order.far_field import momentum_drift, waves_sent
from pmmkit.seakeeping.second_order.mean_drift import drift, sectional_drift

G = 9.81
SHIP = hull_from_particulars(name="ship", L=150.0, B=24.0, d=9.0, block=0.7)
ANGLES = np.linspace(0.0, 2 * math.pi, 120, endpoint=False)


def at(ratio, L=150.0):
    """ω of waves of these lengths over that of the ship, rising."""
    return np.sqrt(2 * math.pi * G / (np.sort(ratio)[::-1] * L))


@pytest.fixture(scope="module")
def still():
    return rao(SHIP, speeds=0.0, headings_deg=[180, 120, 90, 60, 0], omega=at([10, 3, 1, 0.7, 0.4]))


@pytest.mark.parametrize("ratio", [1.0, 0.7, 0.4])
def test_a_fixed_ship_takes_no_energy_from_the_waves(still, ratio):
    """∫|f|² dθ = -2 Re D̄f(α): what goes all round is missing behind her. Sections answer each by
    itself: beam waves keep it to 6 % and oblique ones to 9 in waves up to the length of the ship,
    head waves not at all (a fixed ship there by 33 %)."""
    fixed = replace(still, motion=np.zeros_like(still.motion))
    place = int(np.argmin(np.abs(still.omega - at([ratio])[0])))
    k = still.wavenumber[place]
    ahead = np.sqrt(2 * math.pi / k) * np.exp(-0.25j * math.pi)
    for row, most in ((1, 0.1), (2, 0.07), (3, 0.1)):
        around = np.abs(waves_sent(fixed, place, ANGLES)[row]) ** 2
        behind = waves_sent(fixed, place, -still.heading[row : row + 1])[row, 0]
        missing = -2 * float(np.real(ahead * behind))
        assert np.mean(around) * 2 * math.pi == pytest.approx(missing, rel=most)


@pytest.mark.parametrize("mode", range(6))
def test_waves_of_a_motion_tell_the_force_of_waves_that_come_from_there(mode):
    """Haskind: X(β) = -ρg H(π - β), with forces from another solution of
    the sections, on a grid of frequencies."""
    omega = at([1.5, 0.8])
    headings = np.array([170.0, 120.0, 90.0, 35.0])
    forced = rao(SHIP, speeds=0.0, headings_deg=headings, omega=omega)
    beam = rao(SHIP, speeds=0.0, headings_deg=90.0, omega=omega)
    fixed = replace(beam, motion=np.zeros_like(beam.motion))
    unit = np.zeros_like(beam.motion)
    unit[mode] = 1.0
    moving = replace(beam, motion=unit)
    scale = np.abs(forced.force[mode]).max()
    for place, k in enumerate(beam.wavenumber):
        angles = math.pi - np.radians(headings)
        sent = (waves_sent(moving, place, angles) - waves_sent(fixed, place, angles))[0]
        kochin = sent / (1j * math.sqrt(k / (2 * math.pi)) * np.exp(0.25j * math.pi)) / k
        force = -beam.rho * beam.g * k * kochin / k
        assert np.abs(force - forced.force[mode, 0, :, place]).max() < 0.01 * scale


PANELS = {
    30: ((15.3, 49.8, 44.6, 58.5), (-5.2, -50.7, -141.0, -151.0), (2.51, 4.44, 1.91, 2.94)),
    60: ((5.44, 47.9, 141.0, 90.9), (-3.62, -55.5, -334.0, -500.0), (-0.399, 1.0, 5.58, 5.87)),
    90: (
        (-0.025, -0.808, -26.0, -53.3),
        (-3.16, -40.5, -379.0, -694.0),
        (-0.0319, -0.463, -3.62, -0.345),
    ),
    120: (
        (-6.95, -49.5, -126.0, -88.2),
        (-6.57, -64.9, -360.0, -507.0),
        (0.371, -1.06, -8.05, -8.38),
    ),
    150: (
        (-21.2, -55.7, -45.5, -40.7),
        (-8.86, -61.7, -171.0, -195.0),
        (-2.42, -4.21, -0.876, -0.459),
    ),
}
"""X, Y [kN/m²] and N about midship [MN m/m²] of the S175 at 9.5 m, assumed loading, in waves of 1,
.7, .5 and .4 of her length, by the far field of capytaine 3.0.0 with 640 panels and a lid: Kochin's
functions of its diffraction and radiation, motions by its coefficients; energy is kept to 2 %."""


def test_drift_of_s175_beside_a_panel_method(shared_data):
    """Over the rms, all headings: X .27, Y .13, N .16; by each section alone .51, .43, .44."""
    file = shared_data / "s175_seakeeping_veres" / "shipx_geometry.mgf"
    hull = read_hull(file, draught=9.5)
    omega = at([1.0, 0.7, 0.5, 0.4], hull.L)
    found = rao(hull, speeds=0.0, headings_deg=list(PANELS), omega=omega, loading=Loading.of(hull))
    theirs = np.moveaxis(np.array(list(PANELS.values())), 1, 0) * [[[1e3]], [[1e3]], [[1e6]]]

    def apart(ours):
        return [
            math.sqrt(np.mean((a - b) ** 2) / np.mean(b**2))
            for a, b in zip(ours[:, 0], theirs, strict=True)
        ]

    ours, alone = apart(drift(found)), apart(sectional_drift(found))
    assert (np.array(ours) < [0.3, 0.15, 0.2]).all()
    assert (np.array(ours) < 0.6 * np.array(alone)).all()


def test_a_ship_that_goes_with_long_waves_sends_none_out(still):
    X, Y, _ = momentum_drift(still) / (0.5 * still.rho * still.g * still.L)
    assert np.abs(X[:, 0]).max() < 1e-4
    assert np.abs(Y[:, 0]).max() < 1e-4
    fixed = momentum_drift(replace(still, motion=np.zeros_like(still.motion)))
    fixed = fixed / (0.5 * still.rho * still.g * still.L)
    assert np.abs(fixed[0, 0, 0]) > 100 * np.abs(X[0, 0])


def test_momentum_is_alike_on_both_sides_and_turns_no_ship_in_head_waves():
    found = rao(SHIP, speeds=0.0, headings_deg=[130.0, 230.0, 180.0], omega=[0.5, 0.9])
    X, Y, N = momentum_drift(found)
    np.testing.assert_allclose(X[0], X[1], rtol=1e-6)
    np.testing.assert_allclose(Y[0], -Y[1], rtol=1e-6)
    np.testing.assert_allclose(N[0], -N[1], rtol=1e-6)
    assert np.abs(Y[2]).max() < 1e-9 * np.abs(Y[0]).max()
    assert np.abs(N[2]).max() < 1e-9 * np.abs(N[0]).max()


def test_short_beam_waves_push_a_ship_at_rest_as_a_wall():
    found = rao(SHIP, speeds=0.0, headings_deg=90.0, omega=at([0.05]))
    wall = 0.5 * 1025 * G * (SHIP.x[-1] - SHIP.x[0])
    assert -drift(found)[1, 0, 0, 0] == pytest.approx(wall, rel=0.1)


def test_roll_that_is_damped_pushes_along_the_waves():
    """At the peak of roll the energy that damping takes comes out of the waves: k/ω of it."""
    found = rao(SHIP, speeds=0.0, headings_deg=90.0, omega=np.linspace(0.3, 0.7, 21))
    peak = int(np.abs(found.motion[3, 0, 0]).argmax())
    undamped = replace(found, loading=replace(found.loading, roll_damping=0.0))
    more = momentum_drift(undamped)[1, 0, peak] - momentum_drift(found)[1, 0, peak]
    assert more > 3 * -momentum_drift(undamped)[1, 0, peak] > 0


def test_resistance_by_momentum_is_told_at_rest_alone():
    found = added_resistance(rao(SHIP, speeds=[0.0, 5.0], omega=[0.5, 0.7])).methods["momentum"]
    assert np.isfinite(found[0]).all()
    assert np.isnan(found[1]).all()
