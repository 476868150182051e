"""Library ships: sensitivities, a misprint, linearisations and equations written out again.

Their turns, zigzags and revolutions stand beside published figures in scripts/validation.
"""

from __future__ import annotations

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from pmmkit import stability
from pmmkit.equations import Conditions, prepare
from pmmkit.models import load_model
from pmmkit.simulation import simulate

MARINER_SPEED, TANKER_SPEED = 7.7175, 8.23


@pytest.mark.parametrize(
    ("name", "advance", "tactical", "diameter"),
    [
        ("Nr", 3.644, 4.521, 3.668),
        ("Nvvr", 3.567, 4.485, 3.658),
        ("Nrrr", 3.528, 4.399, 3.582),
        ("Nv", 3.426, 4.253, 3.464),
    ],
)
def test_ten_per_cent_more_of_one_derivative_changes_the_s175_as_tabulated(
    name, advance, tactical, diameter
):
    """The tabulated diameter is at the end of a full circle, .2 % above the steady one."""
    model = load_model("s175-3dof")
    value = model.values("hull_polynomial")[name]
    found = simulate(
        model.with_values("hull_polynomial", **{name: 1.1 * value}), speed=6.0, rudder_rate_deg=2.34
    ).metrics
    assert found["advance_L"] == pytest.approx(advance, rel=2e-3)
    assert found["tactical_diameter_L"] == pytest.approx(tactical, rel=2e-3)
    assert found["steady_diameter_L"] == pytest.approx(diameter, rel=5e-3)


def test_the_old_misprint_of_the_added_mass_of_the_s175_turns_wide():
    """my' = .000238 in copies before July 2001: 4.72 L instead of 4.37 L at 9 m/s."""
    model = load_model("s175-3dof")
    misprint = model.with_values(
        "added_mass", Yvdot=-0.000238, Yrdot=-0.000238 * 0.05, Nvdot=-0.000238 * 0.05
    )
    right, wrong = (
        simulate(x, speed=9.0, rudder_rate_deg=2.34).metrics["tactical_diameter_L"]
        for x in (model, misprint)
    )
    assert right == pytest.approx(4.37, abs=0.01)
    assert wrong == pytest.approx(4.72, abs=0.02)


@pytest.mark.parametrize("name", ["s175-3dof", "s175"])
def test_linear_s175_with_rudder_is_that_of_another_linearisation(name):
    """At 7 m/s: Yδ -.00298, Nδ .00148, Yv -.01189, Nv -.00371, Yr - m - mx -.00522, Nr -.00248."""
    found = stability(name, 7.0)
    Yd, Nd = found.rudder
    assert Yd == pytest.approx(-0.00298, abs=5e-6)
    assert Nd == pytest.approx(0.00148, abs=5e-6)
    assert found.lever_sway == pytest.approx(0.00371 / 0.01189, rel=2e-3)
    assert found.lever_yaw == pytest.approx(0.00248 / 0.00522, rel=3e-3)
    assert pytest.approx(0.01189 * 0.00248 - 0.00371 * 0.00522, rel=1e-2) == found.C


# The 190 000 dwt tanker


def van_berlekom_goddard(u, v, r, delta, n, depth):
    """Accelerations by the equations of Appendix A, rudder positive to port; written out again."""
    L, T, t = 304.8, 18.46, 0.22
    z = T / (depth - T)
    beta = math.atan(v / u)
    thrust = -0.00695 * u * u / L - 0.00063 * u * n + L * 3.54e-5 * n * abs(n)
    c2 = 0.605 * u * n + 38.2 * n * n
    bent = c2 * beta * abs(beta) * abs(delta)
    Yuvz = -0.85 * (1 - 0.8 / z) if z >= 0.8 else 0.0
    X = (
        -0.0377 * u * u
        + 2.020 * L * v * r
        + 0.3 * v * v
        - 0.093 * c2 * delta**2
        + 0.152 * c2 * beta * delta
        + L * thrust * (1 - t)
        + z * (-0.0061 * u * u + 0.387 * L * v * r + 0.0125 * v * v * z)
    ) / L
    Y = (
        -1.205 * u * v
        - 2.4 * v * abs(v)
        - 0.752 * L * u * r
        + 0.208 * c2 * delta
        - 2.16 * bent
        + 0.04 * L * thrust
        + z * (0.182 * L * u * r + Yuvz * u * v - 1.5 * v * abs(v) - 0.191 * bent)
    ) / L
    N = (
        -0.451 * u * v
        - 0.3 * L * abs(v) * r
        - 0.231 * L * u * r
        - 0.098 * c2 * delta
        + 0.688 * bent
        - 0.02 * L * thrust
        + z * (-0.047 * L * u * r - 0.241 * u * v - 0.120 * L * abs(v) * r + 0.344 * bent)
    ) / L**2
    return X / (1.05 + 0.05 * z), Y / (2.02 + 0.387 * z), N / (0.1232 + 0.0045 * z)


@pytest.mark.slow
@given(
    u=st.floats(2.0, 9.0),
    v=st.floats(-2.0, 2.0),
    r=st.floats(-0.01, 0.01),
    delta=st.floats(-0.6, 0.6),
    n=st.floats(0.3, 1.4),
    depth=st.sampled_from([1e6, 100.0, 45.0, 30.0, 23.0]),
)
def test_the_tanker_moves_by_the_equations_as_printed(u, v, r, delta, n, depth):
    """Van Berlekom and Goddard 1972, deep and shallow; ζ = T/(h - T) above and below 0.8."""
    ready = prepare(load_model("esso190k"), TANKER_SPEED, conditions=Conditions(depth=depth))
    found = ready.accelerations(u, v, r, delta=delta, n=n)[:3]
    printed = van_berlekom_goddard(u, v, r, -delta, n, depth)
    for mine, theirs, size in zip(found, printed, (0.05, 0.1, 5e-4), strict=True):
        assert mine == pytest.approx(theirs, rel=1e-6, abs=1e-6 * size)


def test_revolutions_of_the_tanker_follow_their_order_within_50_seconds():
    """Half astern: n = n0 (-.5 + 1.5 exp(-t/50 s)), whatever the ship does meanwhile."""
    track = simulate("esso190k", "stopping", speed=TANKER_SPEED, turns=-0.5)
    for t, n in zip(track.t[::20], track.n[::20], strict=True):
        assert n / track.n[0] == pytest.approx(-0.5 + 1.5 * math.exp(-t / 50.0), abs=1e-6)


def test_the_tanker_does_not_keep_its_course():
    """A full tanker is unstable; the ships of slender form in the library are not."""
    assert not stability("esso190k", TANKER_SPEED).stable
    assert stability("mariner", MARINER_SPEED).stable
