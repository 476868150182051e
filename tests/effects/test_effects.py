"""Effects: one definition for histories and for the simulator, and the physics of each part."""

from __future__ import annotations

import inspect
import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from polynomials import polynomial_forces

from pmmkit import catalogue
from pmmkit.base import UnknownNameError
from pmmkit.conventions import STRUCTURES, Convention, Ship, Water
from pmmkit.effects import CATALOGUE, AddedMass, Regressors, State, propeller, roll, rudder

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
    columns = Regressors.at(
        NAMES,
        State.of(**motion),
        ship=SHIP,
        water=WATER,
        convention=convention,
        approach_speed=approach,
    ).columns
    forces = polynomial_forces(
        values,
        [motion[name] for name in ("u", "v", "r", "p", "phi", "delta")],
        ship=SHIP,
        water=WATER,
        convention=convention,
        approach=approach,
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
        column = Regressors.at(
            [name], state, ship=SHIP, water=WATER, convention=convention, approach_speed=approach
        ).columns
        factor = AddedMass.unit(name, ship=SHIP, water=WATER, convention=convention)
        assert factor * 0.3 == pytest.approx(column[0, 0], rel=1e-12)


def test_coriolis_terms_stand_apart_only_where_the_convention_says_so():
    values = {"Xudot": -0.0003, "Yvdot": -0.007, "lx": 0.03}
    inside = AddedMass.of(
        values, ship=SHIP, water=WATER, convention=Convention(coriolis="in-derivatives")
    )
    apart = AddedMass.of(values, ship=SHIP, water=WATER, convention=Convention(coriolis="separate"))
    unit = 0.5 * 1025.0 * 100.0**3
    assert (inside.coriolis_x, inside.coriolis_y, inside.coriolis_k) == (0.0, 0.0, 0.0)
    assert apart.coriolis_x == pytest.approx(0.007 * unit)
    assert apart.coriolis_y == pytest.approx(-0.0003 * unit)
    assert apart.coriolis_k == pytest.approx(0.0003 * 0.03 * unit * 100.0)


def screw(u=9.0, v=0.0, r=0.0, n=1.4, L=175.0, **changes):
    """X, inflow, thrust, torque and loading of a propeller like that of the S175."""
    given = {
        "D": 6.533,
        "t": 0.175,
        "wake": 0,
        "wp": 0.184,
        "xp": -0.526,
        "open_water": 0,
        "kt0": 0.527,
        "kt1": -0.455,
        "J": (0.0, 1.0),
        "KT": (0.0, 0.0),
        "KQ": (0.0, 0.0),
    }
    zeros = (
        "tau",
        "cpv",
        "cpr",
        "C1",
        "C2_positive",
        "C2_negative",
        "cp",
        "kt2",
        "kq0",
        "kq1",
        "kq2",
    )
    words = dict.fromkeys(zeros, 0.0) | given | changes
    U, beta = math.hypot(u, v), math.atan2(-v, u)
    return propeller.force(u=u, v=v, r=r, beta=beta, n=n, L=L, U=U, rho=1025.0, **words)


def test_thrust_is_rho_n2_d4_kt():
    n, J = 1.5, 0.7
    expected = 1025.0 * n**2 * 6.533**4 * (0.527 - 0.455 * J - 0.05 * J**2)
    X, inflow, thrust, _, loading = screw(u=J * n * 6.533, n=n, wp=0.0, kt2=-0.05)
    assert inflow == J * n * 6.533
    assert thrust == pytest.approx(expected, rel=1e-14)
    assert pytest.approx(0.825 * expected, rel=1e-14) == X
    assert loading == pytest.approx(expected / 1025.0 / 6.533**2, rel=1e-14)


def test_open_water_as_a_table_is_the_polynomial_at_its_points():
    J = np.linspace(0.0, 1.1, 12)
    table = {"J": tuple(J), "KT": tuple(0.527 - 0.455 * J), "KQ": tuple(0.07 - 0.05 * J)}
    for advance in J[1:]:
        u = advance * 1.4 * 6.533
        drawn = screw(u=u, wp=0.0, open_water=1, **table)
        written = screw(u=u, wp=0.0, kq0=0.07, kq1=-0.05)
        assert drawn == pytest.approx(written, rel=1e-12)


def test_torque_is_rho_n2_d5_kq():
    *_, torque, _ = screw(u=0.6 * 1.4 * 6.533, wp=0.0, kq0=0.07, kq1=-0.05)
    assert torque == pytest.approx(1025.0 * 1.4**2 * 6.533**5 * (0.07 - 0.05 * 0.6), rel=1e-14)


def test_astern_the_polynomial_is_bilinear_and_brakes():
    """T/(ρD⁴) = kt0 n|n| + kt1 |n| VA/D: bollard pull astern as ahead, more in water from ahead."""
    bollard = screw(u=0.0, n=-1.0)[2]
    assert bollard == pytest.approx(-screw(u=0.0, n=1.0)[2], rel=1e-14)
    assert screw(u=5.0, n=-1.0)[2] < bollard


def test_wake_of_son_nomoto_grows_with_the_square_of_the_cross_flow():
    u, v, r, L = 8.0, -1.5, 0.02, 175.0
    U = math.hypot(u, v)
    cross = v / U - 0.526 * r * L / U
    inflow = screw(u=u, v=v, r=r, wake=1, tau=1.09)[1]
    assert inflow == pytest.approx(u * (0.816 + 1.09 * cross**2))


def test_wake_of_mmg_fades_to_its_limits_on_each_side():
    form = {"wake": 2, "wp": 0.4, "xp": 0.0, "C1": 50.0, "C2_positive": 1.6, "C2_negative": 1.1}
    for v, limit in ((-6.0, 1.6), (6.0, 1.1)):
        assert screw(u=6.0, v=v, L=7.0, **form)[1] == pytest.approx(6.0 * 0.6 * limit, rel=1e-9)
    assert screw(u=6.0, L=7.0, **form)[1] == pytest.approx(3.6)


def blade(u=9.0, v=0.0, r=0.0, delta=0.0, L=175.0, inflow=0, uP=5.0, loading=0.0, **changes):
    """X, Y, N, K and the normal force of a rudder like that of the S175."""
    given = {
        "area": 33.0,
        "lift_slope": 2.743,
        "epsilon": 0.92,
        "kappa": 0.63,
        "xR": -0.5,
        "tR": 0.29,
        "aH": 0.237,
        "xH": -0.48,
        "zR": 0.033,
        "stall": 0,
    }
    zeros = (
        "eta",
        "gamma_positive",
        "gamma_negative",
        "lR",
        "gamma",
        "cRr",
        "cRrrr",
        "cRrrv",
        "stall_deg",
        "stall_loss",
    )
    return rudder.force(
        v=v,
        r=r,
        beta=math.atan2(-v, u),
        delta=delta,
        L=L,
        U=math.hypot(u, v),
        rho=1025.0,
        propeller_inflow=uP,
        loading=loading,
        inflow=inflow,
        **(dict.fromkeys(zeros, 0.0) | given | changes),
    )


def flow(u, v, r, L, uP, loading, inflow=0, **changes):
    given = dict.fromkeys(
        ("eta", "gamma_positive", "gamma_negative", "lR", "gamma", "cRr", "cRrrr", "cRrrv"), 0.0
    ) | {"epsilon": 0.92, "kappa": 0.63}
    return rudder.rudder_flow(
        v,
        r,
        math.atan2(-v, u),
        L,
        math.hypot(u, v),
        uP,
        loading,
        inflow=inflow,
        **(given | changes),
    )


def test_slipstream_speeds_up_the_rudder_flow_as_written_in_j():
    """The code avoids 1/J; the literature writes sqrt(1 + 8 κ KT/(π J²))."""
    uP, KT, J, D, n = 5.0, 0.17, 0.785, 6.533, 5.0 / (0.785 * 6.533)
    loading = KT * n**2 * D**2
    along, across = flow(9.0, 0.0, 0.0, 175.0, uP, loading)
    assert along == pytest.approx(0.92 * uP * math.sqrt(1 + 8 * 0.63 * KT / (math.pi * J**2)))
    assert across == 0.0
    along, _ = flow(9.0, 0.0, 0.0, 175.0, uP, loading, inflow=1, eta=0.626, kappa=0.5)
    grown = 1 + 0.5 * (math.sqrt(1 + 8 * KT / (math.pi * J**2)) - 1)
    assert along == pytest.approx(0.92 * uP * math.sqrt(0.626 * grown**2 + 0.374))


def test_flow_straightening_takes_the_side_of_the_inflow():
    form = {"inflow": 1, "eta": 0.6, "gamma_positive": 0.64, "gamma_negative": 0.395, "lR": -0.71}
    to_port = flow(6.0, -0.6, 0.0, 7.0, 3.0, 0.0, **form)[1]
    to_starboard = flow(6.0, 0.6, 0.0, 7.0, 3.0, 0.0, **form)[1]
    assert to_port < 0 < to_starboard
    assert to_port / to_starboard == pytest.approx(-0.64 / 0.395)


def test_a_positive_rudder_turns_to_starboard_and_brakes():
    X, Y, N, K, normal = blade(delta=math.radians(20))
    assert X < 0
    assert Y < 0
    assert N > 0
    assert K > 0
    assert normal < 0
    assert pytest.approx(175.0 * (-0.5 + 0.237 * -0.48) / 1.237) == N / Y


def test_a_rudder_along_the_flow_has_no_force():
    normal = rudder.normal_force(6.0, -2.0, math.atan(2.0 / 6.0), 1025.0, 33.0, 2.743, 0, 0.0, 0.0)
    assert normal == pytest.approx(0.0, abs=1e-6)


def test_a_stalled_rudder_loses_its_share_and_no_more():
    full, stalled = (
        rudder.normal_force(6.0, 0.0, math.radians(45), 1025.0, 33.0, 2.743, 1, 30.0, loss)
        for loss in (0.0, 0.3)
    )
    assert stalled == pytest.approx(0.7 * full)
    before = [
        rudder.normal_force(6.0, 0.0, math.radians(29), 1025.0, 33.0, 2.743, 1, 30.0, loss)
        for loss in (0.0, 0.3)
    ]
    assert before[0] == before[1]


def test_roll_is_righted_and_damped():
    given = {
        "rho": 1025.0,
        "g": 9.81,
        "volume": 6000.0,
        "GM": 0.5,
        "damping": 2e6,
        "damping_quadratic": 1e7,
        "restoring": 1,
    }
    weight = 1025.0 * 9.81 * 6000.0
    assert roll.force(0.0, 0.3, **given)[0] == pytest.approx(-weight * 0.5 * math.sin(0.3))
    assert roll.force(0.1, 0.0, **given)[0] == pytest.approx(-2e5 - 1e5)
    assert roll.force(-0.1, 0.0, **given)[0] == pytest.approx(2e5 + 1e5)


FORCES = [effect for effect in catalogue().values() if effect.force is not None]


def axes_of(effect, name, given):
    """The lists over which a table stands with the options that were drawn."""
    forms = {axis: effect.parameter(axis).form for axis in effect.parameter(name).over}
    return [
        axis
        for axis, form in forms.items()
        if form is None or effect.options[form[0]][given[form[0]]] in form[1:]
    ]


@pytest.mark.slow
@pytest.mark.parametrize("effect", FORCES, ids=lambda effect: effect.name)
@given(data=st.data())
def test_one_instant_and_whole_histories_have_the_same_forces(effect, data):
    """Each effect is one text: on floats it gives what it gives on arrays."""
    names = list(inspect.signature(effect.force).parameters)
    tables = effect.tables
    fixed = {
        "L": 100.0,
        "B": 16.0,
        "d": 5.0,
        "rho": 1000.0,
        "g": 9.81,
        "volume": 5000.0,
        "mass": 5e6,
        "GM": 1.0,
        "depth": 30.0,
    }
    rows = 3
    given = {}
    for name in names:
        if name in effect.options:
            given[name] = data.draw(st.integers(0, len(effect.options[name]) - 1), label=name)
        elif name in tables:
            size = 3 ** max(len(axes_of(effect, name, given)), 1)
            given[name] = (-0.5, 0.2, 1.5, 0.9, -0.3, 0.7, 0.1, -0.8, 1.2)[:size]
        elif name in fixed:
            given[name] = fixed[name]
        elif effect.parameter(name) is not None:
            given[name] = data.draw(st.floats(0.05, 0.9), label=name)
        else:
            size = st.floats(0.1, 5.0) if name == "U" else st.floats(-2.0, 5.0)
            given[name] = np.array(data.draw(st.lists(size, min_size=rows, max_size=rows)))
    together = effect.force_over_arrays(**given)
    for i in range(rows):
        alone = effect.force(
            **{name: float(x[i]) if isinstance(x, np.ndarray) else x for name, x in given.items()}
        )
        for one, many in zip(alone, together, strict=True):
            assert np.broadcast_to(many, rows)[i] == pytest.approx(one, rel=1e-12, abs=1e-9)


@pytest.mark.parametrize("effect", FORCES, ids=lambda effect: effect.name)
def test_an_effect_gives_what_it_says_and_asks_for_what_is_there(effect):
    from pmmkit.equations import GIVEN

    signals = {output for other in FORCES for output in other.outputs}
    own = {item.name for item in effect.parameters} | set(effect.options) | set(effect.states)
    asked = set(inspect.signature(effect.force).parameters)
    assert asked <= own | GIVEN | signals
    assert {f"{state}_rate" for state in effect.states} <= set(effect.outputs)


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
        CATALOGUE["hull"]


def test_an_effect_names_all_that_is_wrong_with_its_values():
    effect = CATALOGUE["propeller"]
    complete = {"D": 6.5, "t": 0.2, "kt0": 0.5, "kt1": -0.4, "wp": 0.2}
    assert effect.problems(complete, {}) == []
    found = effect.problems({"D": 6.5, "pitch": 1.0}, {"wake": "mmg"})
    assert len(found) == 2
    assert "pitch" in found[0]
    assert all(name in found[1] for name in ("kt0", "C1", "C2_positive"))
    assert "mmg" in effect.problems({}, {"wake": "mgm"})[0]
    assert not CATALOGUE["added_mass"].accepts("Yvvvdot")
    assert not CATALOGUE["hull_polynomial"].accepts("Yvdot")
