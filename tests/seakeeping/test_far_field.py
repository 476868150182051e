"""Waves that a ship sends out, and what their momentum does."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from pmmkit.base import DataError
from pmmkit.seakeeping import Loading, added_resistance, hull_from_particulars, rao, read_hull
from pmmkit.seakeeping.second_order.far_field import (
    Answers,
    Path,
    asked_of,
    kochin,
    momentum_drift,
    sent_by_sections,
)
from pmmkit.seakeeping.second_order.mean_drift import drift

G = 9.81
SHIP = hull_from_particulars(name="ship", L=150.0, B=24.0, d=9.0, block=0.7)
ANGLES = np.linspace(0.0, 2 * math.pi, 120, endpoint=False)


def kochin_along(found, case, m, l):
    """H of one of the waves of `found` along wave vectors (m, ℓ) at her frequency aboard."""
    asked = asked_of(found, np.ones(found.omega.size, dtype=bool))
    strips = found.strips
    sent = sent_by_sections(strips, Answers.of(strips, asked.encounter), asked)
    m, l = np.atleast_1d(m)[None], np.atleast_1d(l)[None]
    kappa = (asked.encounter[case] + asked.speed[case] * m) ** 2 / found.g
    path = Path(which=np.array([case]), m=m, l=np.abs(l), kappa=kappa, share=np.ones_like(m))
    port, starboard = kochin(strips.x, asked, sent, path)[0]
    return np.where(l >= 0.0, port, starboard)[0]


def sent_at_rest(found, row, place, angles):
    """H of a ship at rest over directions."""
    k = found.wavenumber[place]
    case = row * found.omega.size + place
    return kochin_along(found, case, k * np.cos(angles), k * np.sin(angles))


def at(ratio, L=150.0):
    """ω of waves of these lengths over that of the ship, rising."""
    return np.sqrt(2 * math.pi * G / (np.sort(ratio)[::-1] * L))


@pytest.fixture(scope="module")
def still():
    return rao(SHIP, speeds=0.0, headings_deg=[180, 120, 90, 60, 0], omega=at([10, 3, 1, 0.7, 0.4]))


@pytest.mark.parametrize("ratio", [1.0, 0.7, 0.4])
def test_a_fixed_ship_takes_no_energy_from_the_waves(still, ratio):
    """∫|H|² dθ = 4π Im H(α): what goes all round is missing behind her. Sections answer each by
    itself: beam waves keep it to 6 % and oblique ones to 9 in waves up to the length of the ship,
    head waves not at all (a fixed ship there by 33 %)."""
    fixed = replace(still, motion=np.zeros_like(still.motion))
    place = int(np.argmin(np.abs(still.omega - at([ratio])[0])))
    for row, most in ((1, 0.1), (2, 0.07), (3, 0.1)):
        around = np.abs(sent_at_rest(fixed, row, place, ANGLES)) ** 2
        behind = sent_at_rest(fixed, row, place, -still.heading[row])[0]
        # D̄f(α) of f = i√(k/2π) e^(iπ/4) H is iH(α), and |f|² is k/2π |H|²
        missing = 4 * math.pi / still.wavenumber[place] * float(behind.imag)
        assert np.mean(around) * 2 * math.pi == pytest.approx(missing, rel=most)


@pytest.mark.parametrize("mode", range(6))
def test_waves_of_a_motion_tell_the_force_of_waves_that_come_from_there(mode):
    """Haskind: X(β) = -ρg H(π - β)/k, with forces from another solution of
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
    angles = math.pi - np.radians(headings)
    for place in range(omega.size):
        H = sent_at_rest(moving, 0, place, angles) - sent_at_rest(fixed, 0, place, angles)
        force = -beam.rho * beam.g * H / beam.wavenumber[place]
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

    ours, alone = (apart(drift(found, method=name)) for name in ("momentum", "sections"))
    assert (np.array(ours) < [0.3, 0.15, 0.2]).all()
    assert (np.array(ours) < 0.6 * np.array(alone)).all()


def test_a_ship_that_goes_with_long_waves_sends_none_out(still):
    X, Y, _ = momentum_drift(still)[:, 0] / (0.5 * still.rho * still.g * still.L)
    assert np.abs(X[:, 0]).max() < 1e-4
    assert np.abs(Y[:, 0]).max() < 1e-4
    fixed = momentum_drift(replace(still, motion=np.zeros_like(still.motion)))[:, 0]
    fixed = fixed / (0.5 * still.rho * still.g * still.L)
    assert np.abs(fixed[0, 0, 0]) > 100 * np.abs(X[0, 0])


def test_momentum_is_alike_on_both_sides_and_turns_no_ship_in_head_waves():
    found = rao(SHIP, speeds=0.0, headings_deg=[130.0, 230.0, 180.0], omega=[0.5, 0.9])
    X, Y, N = momentum_drift(found)[:, 0]
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
    undamped = replace(found, roll_damping=np.zeros_like(found.roll_damping))
    without, with_it = (momentum_drift(each)[1, 0, 0, peak] for each in (undamped, found))
    assert without - with_it > 3 * -without > 0


@pytest.mark.parametrize(("omega", "loops"), [(0.22, True), (0.62, False)])
def test_resistance_at_speed_is_maruos_integral(omega, loops):
    """Over the direction θ of the waves sent out, whose lengths are the roots of
    U²κ² cos²θ + (2Uωₑ cos θ - g)κ + ωₑ² = 0, each weighed by κ/|1 - 2Uw cos θ/g|: one loop and two
    branches where 4Uωₑ < g, one branch beside the other where not. The branches end at 12/T."""
    U, g = 9.0, G
    found = rao(SHIP, speeds=U, headings_deg=180.0, omega=[omega])
    k, encounter = float(found.wavenumber[0]), float(found.encounter[0, 0, 0])
    assert (4 * U * encounter < g) == loops
    count = 40_000  # midpoints, where the edge of what is sent out is a root
    edge = 0.0 if loops else math.acos(g / (4 * U * encounter))
    angles = edge + (math.pi - edge) * np.sin(0.5 * math.pi * (np.arange(count) + 0.5) / count) ** 2
    slope = (
        (math.pi - edge)
        * 0.5
        * math.pi
        / count
        * np.sin(math.pi * (np.arange(count) + 0.5) / count)
    )
    ahead = np.cos(angles)
    half = (g - 2 * U * encounter * ahead) / (2 * (U * ahead) ** 2)
    root = np.sqrt(np.maximum(half**2 - (encounter / (U * ahead)) ** 2, 0.0))
    total = 0.0
    for kappa in ((encounter / (U * ahead)) ** 2 / (half + root), half + root):
        held = kappa < 12.0 / SHIP.draught
        m, l, size = (part[held] for part in (kappa * ahead, kappa * np.sin(angles), kappa))
        w = encounter + U * m
        weight = slope[held] * size / np.abs(1 - 2 * U * w * ahead[held] / g) * np.sign(w)
        H = kochin_along(found, 0, m, l)
        total += 2 * np.sum(weight * np.abs(H) ** 2 * (-k - m))
    force = found.rho * found.g / (8 * math.pi * k) * total
    assert momentum_drift(found)[0, 0, 0, 0] == pytest.approx(force, rel=4e-3)


def test_a_slow_ship_drifts_as_one_at_rest():
    headings = [180.0, 130.0, 80.0, 30.0]
    still, slow = (
        drift(rao(SHIP, speeds=U, headings_deg=headings, omega=at([2.0, 0.8, 0.4])))[:, 0]
        for U in (0.0, 1e-4)
    )
    largest = np.abs(still).max(axis=(1, 2), keepdims=True)
    assert (np.abs(slow - still) < 2e-3 * largest).all()


def test_resistance_by_momentum_is_told_at_every_speed_and_grows_with_it():
    motions = rao(SHIP, speeds=[0.0, 5.0, 8.0], omega=at([1.4, 1.2, 1.0, 0.8]))
    largest = added_resistance(motions).methods["momentum"][:, 0].max(axis=-1)
    assert (np.diff(largest) > 0.0).all()


def test_a_method_of_drift_that_is_not_there_is_refused(still):
    with pytest.raises(DataError, match=r"no drift by 'panels'\. There is momentum, and sections"):
        drift(still, method="panels")
