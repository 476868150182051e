"""Effects: one definition for histories and for the simulator, and the physics of each part."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from pmmkit.conventions import Convention
from pmmkit.effects import added_mass, propeller, roll, rudder
from pmmkit.effects.catalogue import catalogue, effect_of
from pmmkit.effects.hull import polynomial, polynomial_forces, regressors
from pmmkit.effects.state import State
from pmmkit.errors import UnknownNameError
from pmmkit.ship import Ship, Water
from pmmkit.structures import STRUCTURES

SHIP = Ship(name="box", L=100.0, B=20.0, d=5.0, volume=6000.0, mass=6.15e6, Izz=3.8e9, GM=0.5)
WATER = Water(rho=1025.0)
MOTION = st.fixed_dictionaries(
    {
        "u": st.floats(0.5, 9.0),
        "v": st.floats(-3.0, 3.0),
        "r": st.floats(-0.05, 0.05),
        "p": st.floats(-0.05, 0.05),
        "phi": st.floats(-0.4, 0.4),
        "delta": st.floats(-0.6, 0.6),
    }
)
CONVENTIONS = st.builds(
    Convention,
    system=st.sampled_from(["prime", "prime-d", "bis"]),
    U=st.sampled_from(["instantaneous", "carriage"]),
    surge=st.sampled_from(["u", "constant", "delta-u"]),
    sway=st.sampled_from(["v", "beta"]),
    rudder_positive=st.sampled_from(["starboard", "port"]),
)
NAMES = [
    name
    for name in dict.fromkeys(
        [
            *(name for structure in STRUCTURES.values() for name in structure.derivatives),
            *("Yur", "Yv|v|", "Nr|r|", "X0", "Yd", "Nddd", "Kp|p|"),
        ]
    )
    if not name.endswith("dot")
]


@given(motion=MOTION, convention=CONVENTIONS, seed=st.integers(0, 1000))
def test_histories_and_simulator_see_the_same_hull_force(motion, convention, seed):
    """The simulator's sum on floats equals regressors times values, in every convention."""
    numbers = np.random.default_rng(seed).normal(size=len(NAMES))
    values = dict(zip(NAMES, numbers.tolist(), strict=True))
    approach = 7.0
    columns = regressors(
        NAMES, State.of(**motion), ship=SHIP, water=WATER, convention=convention,
        approach_speed=approach,
    )  # fmt: skip
    bis = convention.system == "bis"
    speed = math.hypot(motion["u"], motion["v"]) if convention.U == "instantaneous" else approach
    reference = math.sqrt(WATER.g * SHIP.L) if bis else speed
    forces = polynomial_forces(
        **motion,
        reference=reference,
        square=1.0 if bis else speed**2,
        loss_from=approach if convention.surge == "delta-u" else 0.0,
        L=SHIP.L,
        monomials=polynomial(values, ship=SHIP, water=WATER, convention=convention),
    )
    for channel, force in zip("XYNK", forces, strict=True):
        mine = [i for i, name in enumerate(NAMES) if name[0] == channel]
        parts = columns[0, mine] * numbers[mine]
        assert force == pytest.approx(parts.sum(), abs=1e-12 * np.abs(parts).sum() + 1e-12)


@given(convention=CONVENTIONS, approach=st.floats(1.0, 9.0))
def test_added_mass_does_not_depend_on_speed(convention, approach):
    """Force per acceleration is the same constant as the regressors give at any speed."""
    for name in ("Xudot", "Yvdot", "Yrdot", "Nvdot", "Nrdot", "Kpdot", "Ypdot"):
        motion = name[1:]
        state = State.of(u=approach, **{motion: 0.3})
        column = regressors(
            [name], state, ship=SHIP, water=WATER, convention=convention, approach_speed=approach
        )
        factor = added_mass.dimensional(name, ship=SHIP, water=WATER, convention=convention)
        assert factor * 0.3 == pytest.approx(column[0, 0], rel=1e-12)


def test_coriolis_terms_stand_apart_only_where_the_convention_says_so():
    values = {"Xudot": -0.0003, "Yvdot": -0.007, "lx": 0.03}
    inside = added_mass.resolve(
        values, ship=SHIP, water=WATER, convention=Convention(coriolis="in-derivatives")
    )
    apart = added_mass.resolve(
        values, ship=SHIP, water=WATER, convention=Convention(coriolis="separate")
    )
    unit = 0.5 * 1025.0 * 100.0**3
    assert (inside.coriolis_x, inside.coriolis_y, inside.coriolis_k) == (0.0, 0.0, 0.0)
    assert apart.coriolis_x == pytest.approx(0.007 * unit)
    assert apart.coriolis_y == pytest.approx(-0.0003 * unit)
    assert apart.coriolis_k == pytest.approx(0.0003 * 0.03 * unit * 100.0)


def screw(**changes: float) -> propeller.Propeller:
    values = {"D": 6.533, "t": 0.175, "kt0": 0.527, "kt1": -0.455, "wp": 0.184, "xp": -0.526}
    wake = changes.pop("wake", 0)
    given = dict.fromkeys(propeller.Propeller._fields, 0.0) | values | changes
    return propeller.Propeller(**{**given, "wake": wake})


def test_thrust_is_rho_n2_d4_kt():
    c = screw(kt2=-0.05)
    J = 0.7
    n = 1.5
    expected = 1025.0 * n**2 * 6.533**4 * (0.527 - 0.455 * J - 0.05 * J**2)
    assert propeller.thrust(J * n * 6.533, n, 1025.0, c) == pytest.approx(expected, rel=1e-14)


@given(n=st.floats(0.3, 3.0), share=st.floats(0.0, 0.95))
def test_revolutions_undo_thrust(n, share):
    c = screw(kt2=-0.08)
    water = share * n * c.D
    force = propeller.thrust(water, n, 1025.0, c)
    assert propeller.revolutions(force, water, 1025.0, c) == pytest.approx(n, rel=1e-10)


def test_no_revolutions_pull_through_a_windmilling_screw():
    assert math.isnan(propeller.revolutions(1e4, 3.0, 1000.0, screw(kt0=-0.1)))


def test_wake_of_son_nomoto_grows_with_the_square_of_the_cross_flow():
    c = screw(wake=1, tau=1.09)
    u, v, r, L = 8.0, -1.5, 0.02, 175.0
    U = math.hypot(u, v)
    cross = v / U - 0.526 * r * L / U
    assert propeller.inflow(u, v, r, L, c) == pytest.approx(u * (0.816 + 1.09 * cross**2))


def test_wake_of_mmg_fades_to_its_limits_on_each_side():
    c = screw(wake=2, wp=0.4, xp=0.0, C1=50.0, C2_positive=1.6, C2_negative=1.1)
    for v, limit in ((-6.0, 1.6), (6.0, 1.1)):
        assert propeller.inflow(6.0, v, 0.0, 7.0, c) == pytest.approx(6.0 * 0.6 * limit, rel=1e-9)
    assert propeller.inflow(6.0, 0.0, 0.0, 7.0, c) == pytest.approx(3.6)


def blade(**changes: float) -> rudder.Rudder:
    given = dict.fromkeys(rudder.Rudder._fields, 0.0) | {
        "area": 33.0, "lift_slope": 2.743, "epsilon": 0.92, "kappa": 0.63, "xR": -0.5,
        "tR": 0.29, "aH": 0.237, "xH": -0.48, "zR": 0.033,
    }  # fmt: skip
    inflow = int(changes.pop("inflow", 0))
    return rudder.Rudder(**{**given, **changes, "inflow": inflow})


def test_slipstream_speeds_up_the_rudder_flow_as_written_in_j():
    """The code avoids 1/J; the literature writes sqrt(1 + 8 κ KT/(π J²))."""
    uP, KT, J, D, n = 5.0, 0.17, 0.785, 6.533, 5.0 / (0.785 * 6.533)
    loading = KT * n**2 * D**2
    along, across = rudder.flow(9.0, 0.0, 0.0, 175.0, uP, loading, blade())
    assert along == pytest.approx(0.92 * uP * math.sqrt(1 + 8 * 0.63 * KT / (math.pi * J**2)))
    assert across == 0.0
    c = blade(inflow=1, eta=0.626, kappa=0.5, gamma_positive=0.64, gamma_negative=0.395, lR=-0.71)
    along, _ = rudder.flow(9.0, 0.0, 0.0, 175.0, uP, loading, c)
    grown = 1 + 0.5 * (math.sqrt(1 + 8 * KT / (math.pi * J**2)) - 1)
    assert along == pytest.approx(0.92 * uP * math.sqrt(0.626 * grown**2 + 0.374))


def test_flow_straightening_takes_the_side_of_the_inflow():
    c = blade(inflow=1, eta=0.6, gamma_positive=0.64, gamma_negative=0.395, lR=-0.71)
    to_port = rudder.flow(6.0, -0.6, 0.0, 7.0, 3.0, 0.0, c)[1]
    to_starboard = rudder.flow(6.0, 0.6, 0.0, 7.0, 3.0, 0.0, c)[1]
    assert to_port < 0 < to_starboard
    assert to_port / to_starboard == pytest.approx(-0.64 / 0.395)


def test_a_positive_rudder_turns_to_starboard_and_brakes():
    c = blade()
    delta = math.radians(20)
    normal = rudder.normal_force(6.0, 0.0, delta, 1025.0, c)
    X, Y, N, K = rudder.forces(normal, delta, 175.0, c)
    assert X < 0
    assert Y < 0
    assert N > 0
    assert K > 0
    assert pytest.approx(175.0 * (-0.5 + 0.237 * -0.48) / 1.237) == N / Y


def test_a_rudder_along_the_flow_has_no_force():
    assert rudder.normal_force(6.0, -2.0, math.atan(2.0 / 6.0), 1025.0, blade()) == pytest.approx(
        0.0, abs=1e-6
    )


def test_roll_is_righted_and_damped():
    c = roll.resolve(
        {"damping": 2e6, "damping_quadratic": 1e7}, {"restoring": "sine"}, ship=SHIP, water=WATER
    )
    weight = 1025.0 * 9.81 * 6000.0
    assert roll.moment(0.0, 0.3, c) == pytest.approx(-weight * 0.5 * math.sin(0.3))
    assert roll.moment(0.1, 0.0, c) == pytest.approx(-2e5 - 1e5)
    assert roll.moment(-0.1, 0.0, c) == pytest.approx(2e5 + 1e5)


def test_catalogue_describes_every_effect():
    found = catalogue()
    wanted = {"hull_polynomial", "rudder_abkowitz", "added_mass", "propeller", "rudder_mmg", "roll"}
    assert wanted <= set(found)
    for name, effect in found.items():
        assert effect.name == name
        assert effect.summary.endswith(".")
        assert effect.source
        assert all(item.text for item in effect.parameters)
        for item in effect.parameters:
            assert item.form is None or item.form[1] in effect.options[item.form[0]]
            assert math.isfinite(item.scaling)


def test_an_unknown_effect_is_answered_with_those_there_are():
    with pytest.raises(UnknownNameError, match="hull_polynomial"):
        effect_of("hull")


def test_an_effect_names_all_that_is_wrong_with_its_values():
    effect = effect_of("propeller")
    complete = {"D": 6.5, "t": 0.2, "kt0": 0.5, "kt1": -0.4, "wp": 0.2}
    assert effect.problems(complete, {}) == []
    found = effect.problems({"D": 6.5, "pitch": 1.0}, {"wake": "mmg"})
    assert len(found) == 2
    assert "pitch" in found[0]
    assert all(name in found[1] for name in ("kt0", "C1", "C2_positive"))
    assert "mmg" in effect.problems({}, {"wake": "mgm"})[0]
    assert not effect_of("added_mass").accepts("Yvvvdot")
    assert not effect_of("hull_polynomial").accepts("Yvdot")
