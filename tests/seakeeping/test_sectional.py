"""Sections at the free surface: known values, energy, symmetry, limits."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from pmmkit.seakeeping.mapping import at, lewis, lewis_area_range, slope
from pmmkit.seakeeping.second_order.mean_drift import scattering
from pmmkit.seakeeping.sectional import (
    HEAVE,
    NODES,
    ROLL,
    SWAY,
    multipoles,
    normals,
    solve,
    strengths,
)

CIRCLE = np.array([[1.0, 0.0, 0.0]])
SHAPES = st.tuples(st.floats(0.6, 2.5), st.floats(0.02, 0.7))
"""Half breadth over draught, and where the area lies within the range of Lewis forms."""


def section(shape):
    ratio, share = shape
    low, high = lewis_area_range(2 * ratio, 1.0)
    full = low + share * (min(high, 1.0) - low)
    return lewis(2 * ratio, 1.0, full * 2 * ratio)[None]


def damping(found, mode):
    return -found.added[mode, mode, :, 0].imag


def test_a_circle_does_not_feel_roll():
    found = solve(CIRCLE, np.array([0.3, 1.0, 3.0])).added
    assert np.abs(found[ROLL]).max() < 1e-12


@settings(max_examples=25)
@given(SHAPES, st.floats(0.01, 2.0))
def test_what_damps_is_the_energy_of_the_waves_sent_out(shape, Kb):
    """b = ρg²Ā²/ω³, that is b/(ρω) = |Ā|²/K², up to waves of three half breadths."""
    K = Kb / shape[0]
    found = solve(section(shape), np.array([K]))
    for mode in (HEAVE, SWAY):
        sent = np.abs(found.far[mode, :, 0]) ** 2 / K**2
        assert damping(found, mode) == pytest.approx(sent, rel=2e-3)


@settings(max_examples=25)
@given(SHAPES, st.floats(0.01, 2.0))
def test_coupling_is_the_same_both_ways(shape, Ka):
    """Timman and Newman (1962), without speed."""
    found = solve(section(shape), np.array([Ka])).added[..., 0, 0]
    scale = math.sqrt(found[SWAY, SWAY].real * max(abs(found[ROLL, ROLL]), 1e-3))
    assert abs(found[SWAY, ROLL] - found[ROLL, SWAY]) < 0.01 * scale


@settings(max_examples=15)
@given(SHAPES, st.floats(0.05, 1.5))
def test_force_of_waves_by_haskind_is_that_of_the_waves_sent_out(shape, Ka):
    """|F₃| = ρg²/ω² Ā, |F₂| as well: Haskind's relation between scattering and radiation.

    The force is built here from the pressure of the wave and Haskind's integral over the section;
    the other side of the identity from the strength of the source alone.
    """
    found = solve(section(shape), np.array([Ka]))
    w, steps = found.points[0], found.weights[0]
    up, out, _ = normals(w, steps)
    decay, phase = np.exp(-Ka * w.real), Ka * w.imag
    even = 2 * decay * (np.cos(phase) * up - np.sin(phase) * out)
    odd = 2j * decay * (np.sin(phase) * up + np.cos(phase) * out)
    direct = {HEAVE: 2 * np.sum(decay * np.cos(phase) * up)}
    direct[SWAY] = 2j * np.sum(decay * np.sin(phase) * out)
    for mode, wave in ((HEAVE, even), (SWAY, odd)):
        # over ρg, with ωω = gK
        force = -direct[mode] + Ka * np.sum(found.potentials[mode, 0, 0] * wave)
        assert abs(force) == pytest.approx(abs(found.far[mode, 0, 0]) / Ka, rel=8e-3)


def diffracted(maps, Ka):
    """A fixed section in the waves e^(-Ky) cos Kx and e^(-Ky) sin Kx: the diffraction solved."""
    nodes, gauss = np.polynomial.legendre.leggauss(NODES)
    theta = 0.25 * math.pi * (nodes + 1)
    w, steps = at(maps, theta), slope(maps, theta) * (0.25 * math.pi * gauss)
    K, wave = np.array([Ka]), np.exp(-Ka * w)
    even, source = strengths(multipoles(maps, theta, K, odd=False), (-wave.imag,))
    odd, dipole = strengths(multipoles(maps, theta, K, odd=True), (-wave.real,), free=True)
    up, out, turn = normals(w, steps)
    forces = [2 * np.sum(even[0, 0] * up), *(2 * np.sum(odd[0, 0] * n) for n in (out, turn))]
    return np.array(forces), -1j * math.pi * source.item(), -math.pi * Ka * dipole.item()


@settings(max_examples=15)
@given(SHAPES, st.floats(0.05, 1.5))
def test_diffraction_solved_directly_has_the_force_of_haskind_and_keeps_the_energy(shape, Ka):
    """Three ways to one force: the problem of the fixed section, Haskind, and both parts of a
    wave going out again whole, which is how the drift of a section sees it."""
    maps = section(shape)
    forces, even, odd = diffracted(maps, Ka)
    found = solve(maps, np.array([Ka]))
    w, steps = found.points[0], found.weights[0]
    up, out, _ = normals(w, steps)
    decay, phase = np.exp(-Ka * w.real), Ka * w.imag
    through = {
        HEAVE: 2 * decay * (np.cos(phase) * up - np.sin(phase) * out),
        SWAY: 2 * decay * (np.sin(phase) * up + np.cos(phase) * out),
    }
    through[ROLL] = through[SWAY]
    for mode, wave in through.items():
        haskind = -Ka * np.sum(found.potentials[mode, 0, 0] * wave)
        lift = 2 * shape[0] * (shape[0] if mode == ROLL else 1.0)  # of long waves
        assert abs(forces[mode] - haskind) < 1e-3 * lift
    assert abs(0.5 + even) == pytest.approx(0.5, rel=2e-3)
    assert abs(0.5j + odd) == pytest.approx(0.5, rel=2e-3)
    back, onward = scattering(found.far[:, 0, 0] * np.array([1.0, -1j, 1.0]))
    assert abs(even + 1j * odd) == pytest.approx(abs(back), abs=4e-3)
    assert abs(1 + even - 1j * odd) == pytest.approx(abs(onward), abs=4e-3)


@pytest.mark.parametrize("ratio", [0.4, 1.0, 3.0])
def test_long_waves_lift_by_the_breadth(ratio):
    """The force on a section in long waves is ρg times its breadth: Ā/K tends to 2·half breadth."""
    found = solve(lewis(2 * ratio, 1.0, 1.6 * ratio)[None], np.array([1e-4]))
    assert abs(found.far[HEAVE, 0, 0]) / 1e-4 == pytest.approx(2 * ratio, rel=5e-3)


def test_re_entrant_and_full_lewis_forms_are_sound_up_to_short_waves():
    """At the ends of the range of Lewis forms nothing is negative, up to Kb = 5."""
    K = np.geomspace(0.01, 5.0, 12)
    for ratio in (0.5, 1.0, 2.0):
        low, _ = lewis_area_range(2 * ratio, 1.0)
        for full in (low * 1.001, 0.97):
            found = solve(lewis(2 * ratio, 1.0, full * 2 * ratio)[None], K / ratio)
            for mode in (HEAVE, SWAY):
                assert (found.added[mode, mode].real > 0).all()
                assert (damping(found, mode) > -1e-3 * found.added[mode, mode].real.max()).all()


def test_many_sections_at_once_are_those_one_by_one():
    maps = np.concatenate([CIRCLE, section((1.3, 0.5)), section((0.8, 0.2))])
    K = np.array([0.2, 1.1])
    together = solve(maps, K)
    for k, one in enumerate(maps):
        alone = solve(one[None], K)
        np.testing.assert_allclose(
            alone.added[..., 0], together.added[..., k], rtol=1e-9, atol=1e-9
        )


def test_slope_is_the_derivative_of_the_map():
    map_, theta, h = section((1.7, 0.6)), np.linspace(0.1, 1.4, 9), 1e-6
    steps = (at(map_, theta + h) - at(map_, theta - h)) / (2 * h)
    np.testing.assert_allclose(slope(map_, theta), steps, rtol=1e-8)
