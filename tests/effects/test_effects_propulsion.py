"""Cross-flow drag, propeller in four quadrants, shaft and waterjet: the physics of each."""

from __future__ import annotations

import inspect
import math
from types import MappingProxyType
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import quad

from pmmkit.effects import CATALOGUE, four_quadrant, shaft, waterjet
from pmmkit.effects.cross_flow import strip
from pmmkit.effects.four_quadrant import b4_70, estimate
from pmmkit.effects.primitives import interpolate, over_arrays
from pmmkit.equations import prepare
from pmmkit.models import Part, load_model

TIP = 0.7 * math.pi
SHIP = {"L": 175.0, "B": 25.4, "d": 8.5, "rho": 1025.0}
STATIONS, ENDS = (-0.5, -0.3, 0.3, 0.5), (1.6, 1.0, 1.0, 1.4)
S175_SCREW = {
    "D": 6.533,
    "t": 0.175,
    "wp": 0.184,
    "xp": -0.526,
    "kt0": 0.527,
    "kt1": -0.455,
    "kt2": 0.0,
}


def answer(name: str, **given: Any) -> dict[str, Any]:
    """Outputs of an effect by name; what is not given is its default, or zero."""
    effect = CATALOGUE[name]
    assert effect.force is not None
    words = effect.chosen({k: v for k, v in given.items() if k in effect.options})
    known = {item.name: item.default for item in effect.parameters if item.default is not None}
    known |= {item.name: (0.0,) for item in effect.parameters if item.table}
    known |= {k: list(effect.options[k]).index(word) for k, word in words.items()}
    known |= SHIP | {k: v for k, v in given.items() if k not in effect.options}
    if "u" in given:
        known["U"] = np.maximum(np.hypot(given["u"], given.get("v", 0.0)), 1e-9)
        known["beta"] = np.arctan2(-np.asarray(given.get("v", 0.0)), given["u"])
    arguments = inspect.signature(effect.force).parameters
    arrays = any(isinstance(value, np.ndarray) for value in given.values())
    function = over_arrays(effect.force) if arrays else effect.force
    values = function(**{argument: known.get(argument, 0.0) for argument in arguments})
    return dict(zip(effect.outputs, values, strict=True))


def integrated(v: float, slope: float, L: float, power: int) -> float:
    """∫ |v + slope x| (v + slope x) x^power dx over the length, by quadrature split at the zero."""
    zero = -v / slope if slope else math.inf
    points = [zero] if abs(zero) < 0.5 * L else None

    def integrand(x: float) -> float:
        return abs(v + slope * x) * (v + slope * x) * x**power

    return float(quad(integrand, -0.5 * L, 0.5 * L, points=points, epsabs=1e-8, epsrel=1e-10)[0])


SWAY, YAW = st.floats(-4.0, 4.0), st.floats(-0.08, 0.08)


@given(v=SWAY, r=YAW)
def test_cross_flow_drag_is_its_integral(v, r):
    found = answer("crossflow_drag", v=v, r=r, CD=0.8, CrY=1.2, CrN=0.7)
    area = -0.5 * 1025.0 * 8.5 * 0.8
    size = abs(area) * 175.0 * (abs(v) + 0.08 * 88) ** 2
    Y = area * integrated(v, 1.2 * r, 175.0, 0)
    N = area * integrated(v, 0.7 * r, 175.0, 1)
    assert found["Y"] == pytest.approx(Y, rel=1e-9, abs=1e-11 * size)
    assert found["N"] == pytest.approx(N, rel=1e-9, abs=1e-11 * size * 175.0)


def test_cross_flow_drag_of_pure_sway_and_pure_yaw_have_the_closed_forms():
    sway = answer("crossflow_drag", v=-2.0, r=0.0, CD=0.7)
    assert sway["Y"] == pytest.approx(0.5 * 1025 * 8.5 * 175 * 0.7 * 4.0)
    assert sway["N"] == 0.0
    yaw = answer("crossflow_drag", v=0.0, r=0.03, CD=0.7)
    assert yaw["Y"] == 0.0
    assert yaw["N"] == pytest.approx(-1025 * 8.5 * 0.7 * 0.03**2 * 175.0**4 / 64)


@given(v=SWAY, r=YAW)
def test_cross_flow_drag_changes_sign_with_the_motion_and_takes_energy(v, r):
    one = answer("crossflow_drag", v=v, r=r, CD=0.9)
    other = answer("crossflow_drag", v=-v, r=-r, CD=0.9)
    assert other == pytest.approx({key: -value for key, value in one.items()}, abs=1e-6)
    assert one["Y"] * v + one["N"] * r <= 1e-6


def test_cross_flow_drag_without_sway_leaves_it_to_the_hull():
    moving = {"v": -1.5, "CD": 0.8, "form": "without-sway"}
    assert answer("crossflow_drag", r=0.0, **moving)["Y"] == pytest.approx(0.0, abs=1e-6)
    full = answer("crossflow_drag", v=-1.5, r=0.02, CD=0.8)
    less = answer("crossflow_drag", r=0.02, **moving)
    part = -0.5 * 1025 * 8.5 * 0.8 * 175 * 1.5 * -1.5
    assert full["Y"] - less["Y"] == pytest.approx(part)
    assert full["N"] == less["N"]


@pytest.mark.parametrize(("v", "r"), [(1.0, 0.0), (0.0, 0.03), (-1.0, 0.02), (0.4, 0.05)])
def test_forty_strips_hold_a_shape_of_the_coefficient(v, r):
    """Their largest error is 2 parts in 1000, for a shape with corners between the strips."""

    def drag(x: float, power: int) -> float:
        w = v + r * x
        return float(np.interp(x / 175.0, STATIONS, ENDS)) * abs(w) * w * x**power

    found = answer(
        "crossflow_drag", v=v, r=r, CD=0.8, shape="table", station=STATIONS, CD_station=ENDS
    )
    corners = [-0.3 * 175, 0.3 * 175, *([-v / r] if r else [])]
    for channel, power in (("Y", 0), ("N", 1)):
        exact = quad(drag, -87.5, 87.5, args=(power,), points=corners, limit=200)[0]
        size = quad(lambda x, p=power: abs(drag(x, p)), -87.5, 87.5, limit=200)[0]
        scale = 0.5 * 1025 * 8.5 * 0.8
        assert found[channel] == pytest.approx(-scale * exact, abs=2e-3 * scale * size)


@given(v=SWAY, r=YAW)
def test_strips_of_one_coefficient_are_the_closed_form(v, r):
    whole = answer("crossflow_drag", v=v, r=r, CD=0.8)
    strips = answer(
        "crossflow_drag", v=v, r=r, CD=0.8, shape="table", station=(-0.5, 0.5), CD_station=(1, 1)
    )
    assert strips == pytest.approx(whole, rel=1e-9, abs=1e-2)


def test_strip_has_no_step_where_the_flow_begins_to_turn():
    inside, outside = strip(1.0, 1.0 - 1e-12, 3.0), strip(1.0, 1.0 + 1e-12, 3.0)
    assert inside == pytest.approx(outside, rel=1e-10)


def kt(J: float, c: dict[str, float]) -> float:
    return c["kt0"] + c["kt1"] * J + c["kt2"] * J * J


@given(n=st.floats(0.2, 3.0), share=st.floats(0.0, 1.0), kt2=st.floats(-0.15, 0.05))
def test_first_quadrant_is_the_open_water_polynomial(n, share, kt2):
    c = S175_SCREW | {"kt2": kt2, "kq0": 0.07, "kq1": -0.05, "wp": 0.0}
    J0 = 2 * c["kt0"] / (-c["kt1"] + math.sqrt(c["kt1"] ** 2 - 4 * kt2 * c["kt0"]))
    J = share * J0
    found = answer("four_quadrant_propeller", u=J * n * c["D"], n=n, **c)
    unit = 1025 * n**2 * c["D"] ** 4
    assert found["thrust"] == pytest.approx(unit * kt(J, c), rel=1e-9, abs=1e-9 * unit)
    assert found["torque"] == pytest.approx(unit * c["D"] * (0.07 - 0.05 * J), rel=1e-9)
    assert found["loading"] * 1025 * c["D"] ** 2 == pytest.approx(found["thrust"])


def test_first_quadrant_agrees_with_the_simple_propeller():
    motion = {"u": 8.0, "v": -1.5, "r": 0.012, "n": 1.6, "wake": "son-nomoto", "tau": 1.09}
    simple = answer("propeller", **motion, **S175_SCREW)
    found = answer("four_quadrant_propeller", **motion, **S175_SCREW)
    for name in ("X", "propeller_inflow", "thrust", "loading"):
        assert found[name] == pytest.approx(simple[name], rel=1e-12)
    assert found["Y"] == found["N"] == 0.0


def test_bollard_pull_is_kt_at_rest():
    found = answer("four_quadrant_propeller", u=0.0, n=1.5, **S175_SCREW)
    assert found["thrust"] == pytest.approx(1025 * 1.5**2 * 6.533**4 * 0.527)
    assert found["X"] == pytest.approx(0.825 * found["thrust"])


CURVES = st.sampled_from([(0.0, 0.527, -0.455, 0.0), (0.7, 0.2931, -0.2753, -0.1359)])


@given(beta=st.floats(-math.pi, math.pi), curve=CURVES)
def test_estimated_curves_have_no_steps(beta, curve):
    near = estimate(beta + 1e-7, *curve, 0.06, -0.04, 0.0)
    assert near == pytest.approx(estimate(beta, *curve, 0.06, -0.04, 0.0), abs=1e-6)


@given(curve=CURVES)
def test_estimated_curves_close_at_half_a_turn(curve):
    one = estimate(math.pi, *curve, 0.0, 0.0, 0.0)
    other = estimate(-math.pi, *curve, 0.0, 0.0, 0.0)
    assert one == pytest.approx(other, abs=1e-12)


@pytest.mark.parametrize("pitch", [0.6, 0.8, 1.0, 1.2])
def test_polynomial_alone_gives_back_the_propeller_it_came_from(pitch):
    """From KT of a B4-70 only, without its pitch or KQ, to its curves in all quadrants.

    The pitch found from the J of no thrust is off by up to 0.05, hence the tolerance.
    """
    J = np.linspace(0.0, 1.0, 21) * pitch
    angles = np.arctan2(J, TIP)
    curve = over_arrays(b4_70)(angles, pitch)[0] * math.pi / 8 * (J**2 + TIP**2)
    kt2, kt1, kt0 = np.polyfit(J, curve, 2)
    around = np.radians(np.arange(-180.0, 181.0, 5.0))
    found = over_arrays(estimate)(around, 0.0, kt0, kt1, kt2, 0.0, 0.0, 0.0)
    truth = over_arrays(b4_70)(around, pitch)
    assert np.abs(found[0] - truth[0]).max() < 0.05
    assert np.abs(found[1] - truth[1]).max() < 0.02


@pytest.mark.parametrize("known", [{"pitch": 0.0}, {"pitch": 0.9}])
def test_signs_in_the_four_quadrants(known):
    """Bollard ahead, crash stop, bollard astern, backing ship with the propeller ahead."""
    signs = {(5.0, 1.2): 1, (0.0, 1.2): 1, (8.0, -0.8): -1, (0.0, -1.2): -1, (-3.0, 1.2): 1}
    for (u, n), sign in signs.items():
        found = answer("four_quadrant_propeller", u=u, n=n, **S175_SCREW, **known)
        assert found["thrust"] * sign > 0
        assert found["torque"] * n > 0, "the engine must drive the propeller here"


def test_a_stopped_propeller_brakes_and_is_driven_by_the_water():
    found = answer("four_quadrant_propeller", u=8.0, n=0.0, **(S175_SCREW | {"wp": 0.0}))
    assert found["thrust"] == pytest.approx(
        -0.78 * 0.5 * 1025 * 64 * math.pi / 4 * 6.533**2, rel=0.05
    )
    assert found["torque"] < 0
    assert all(
        value == 0.0
        for value in answer("four_quadrant_propeller", u=0.0, n=0.0, **S175_SCREW).values()
    )


@given(u=st.floats(-4.0, 9.0), n=st.floats(-2.0, 2.0))
def test_forces_of_the_propeller_have_no_steps(u, n):
    c = S175_SCREW | {
        "t_astern": 0.4,
        "wp_astern": 0.05,
        "astern": "table",
        "J_astern": (-2.0, 0.0),
        "Yp": (0.1, 0.05),
        "Np": (-0.05, -0.02),
    }
    one = answer("four_quadrant_propeller", u=u, n=n, **c)
    other = answer("four_quadrant_propeller", u=u + 1e-8, n=n + 1e-8, **c)
    size = 1025 * 6.533**2 * (u * u + (n * 6.533) ** 2 + 1)
    for name in ("X", "Y", "N", "thrust", "torque"):
        assert one[name] == pytest.approx(other[name], abs=1e-4 * size)


def test_side_force_only_while_the_propeller_turns_astern():
    c = S175_SCREW | {
        "astern": "table",
        "J_astern": (-1.0, 0.0),
        "Yp": (0.1, 0.06),
        "Np": (-0.05, -0.03),
    }
    ahead = answer("four_quadrant_propeller", u=5.0, n=1.0, **c)
    assert ahead["Y"] == ahead["N"] == 0.0
    astern = answer("four_quadrant_propeller", u=0.5 * 6.533, n=-1.0, **c)
    unit = 0.5 * 1025 * 6.533**4
    assert astern["Y"] == pytest.approx(unit * 0.08)
    assert astern["N"] == pytest.approx(-unit * 175 * 0.04)


@pytest.mark.parametrize("first", [-180, 0])
def test_tables_may_begin_at_minus_180_or_at_0(first):
    angles = np.arange(first, first + 361, 1.0)
    curves = over_arrays(b4_70)(np.radians(angles), 0.9)
    tables = {"beta_deg": tuple(angles), "CT": tuple(curves[0]), "CQ": tuple(curves[1])}
    for u, n in ((6.0, 1.2), (6.0, -1.0), (-3.0, -1.0), (-3.0, 1.0)):
        motion = {"u": u, "n": n, **S175_SCREW}
        read = answer("four_quadrant_propeller", characteristics="table", **motion, **tables)
        direct = answer("four_quadrant_propeller", characteristics="b4-70", pitch=0.9, **motion)
        assert read["thrust"] == pytest.approx(direct["thrust"], rel=2e-3)
        assert read["torque"] == pytest.approx(direct["torque"], rel=2e-3)


DIESEL = {"inertia": 1e5, "torque_max": 8e5, "time_constant": 2.0}


def test_a_governor_holds_its_order_without_droop():
    assert answer("shaft", n=1.5, n_order=1.5, torque=6e5, friction=1e4, **DIESEL)["n_rate"] == 0.0


def test_a_governor_closes_a_small_gap_with_its_time_constant():
    rate = answer("shaft", n=1.5, n_order=1.51, torque=4e5, **DIESEL)["n_rate"]
    assert rate == pytest.approx(0.01 / 2.0)


def test_too_much_load_slows_the_shaft_by_what_the_engine_lacks():
    rate = answer("shaft", n=1.5, n_order=1.5, torque=9e5, **DIESEL)["n_rate"]
    assert rate == pytest.approx(-1e5 / (2 * math.pi * 1e5))


@pytest.mark.parametrize(
    ("given", "most"),
    [
        ({"limit": "constant"}, 8e5),
        ({"limit": "falling", "n_rated": 2.0, "torque_at_rest": 0.5}, 8e5 * 0.75),
        ({"limit": "power", "power_max": 2 * math.pi * 5e5}, 5e5),
        ({"limit": "power", "power_max": 1e9}, 8e5),
    ],
)
def test_limits_of_an_engine(given, most):
    rate = answer("shaft", n=1.0, n_order=9.0, torque=1e5, **DIESEL, **given)["n_rate"]
    assert rate == pytest.approx((most - 1e5) / (2 * math.pi * 1e5))


def test_an_engine_waits_for_the_shaft_before_it_reverses():
    c = DIESEL | {"reverse_below": 0.5, "astern_share": 0.8}
    waiting = answer("shaft", n=1.2, n_order=-1.0, torque=-1e5, **c)["n_rate"]
    assert waiting == pytest.approx(1e5 / (2 * math.pi * 1e5)), "only the water moves the shaft"
    started = answer("shaft", n=0.3, n_order=-1.0, torque=-1e5, **c)["n_rate"]
    demanded = -1.3 / 2.0
    assert started == pytest.approx(max(demanded, (-0.8 * 8e5 + 1e5) / (2 * math.pi * 1e5)))
    rates = [
        answer("shaft", n=n, n_order=-1.0, torque=-1e5, **c)["n_rate"] for n in (0.39, 0.45, 0.51)
    ]
    assert rates[0] < rates[1] < rates[2]


@given(n=st.floats(-2.0, 2.0), order=st.floats(0.1, 2.0), load=st.floats(0.0, 5e5))
def test_a_shaft_does_the_same_astern_as_ahead(n, order, load):
    c = DIESEL | {"reverse_below": 0.5, "friction": 2e4}
    ahead = answer("shaft", n=n, n_order=order, torque=load, **c)["n_rate"]
    astern = answer("shaft", n=-n, n_order=-order, torque=-load, **c)["n_rate"]
    assert astern == pytest.approx(-ahead, rel=1e-12, abs=1e-15)


@pytest.mark.parametrize(("n", "Tm"), [(1.13, 5.0), (0.5, 11.3), (0.2, 18.83), (0.0, 18.83)])
def test_time_constant_by_turns_is_that_of_the_container_ship(n, Tm):
    """Tm = 5.65/n above 0.3 revolutions per second, else 18.83 s."""
    rate = answer("shaft_lag", n=n, n_order=n + 0.1, law="by-turns")["n_rate"]
    assert 0.1 / rate == pytest.approx(Tm, rel=1e-3)


def test_a_lag_may_have_a_largest_rate():
    c = {"time_constant": 5.0, "n_step": 0.5}
    assert answer("shaft_lag", n=1.0, n_order=-1.0, **c)["n_rate"] == pytest.approx(-0.1)
    assert answer("shaft_lag", n=1.0, n_order=0.9, **c)["n_rate"] == pytest.approx(-0.02)


def test_a_governor_is_not_stiff():
    """Explicit Euler with steps of half a second and a propeller on the shaft settles smoothly."""
    n, n_order, seen = 0.5, 1.2, []
    for _ in range(400):
        load = answer("four_quadrant_propeller", u=5.0, n=n, pitch=0.9, **S175_SCREW)["torque"]
        c = DIESEL | {"torque_max": 3e6}
        n += 0.5 * answer("shaft", n=n, n_order=n_order, torque=load, **c)["n_rate"]
        seen.append(n)
    assert seen[-1] == pytest.approx(n_order, rel=1e-9)
    assert max(seen) < n_order * (1 + 1e-9)


JET = {"number": 3.0, "nozzle": 0.12, "D": 0.62, "phi0": 0.62, "w": 0.05, "turning": 0.0}


def test_thrust_of_a_waterjet_is_the_momentum_it_gives_to_the_water():
    found = answer("waterjet", u=10.0, n=30.0, **JET)
    flow = 0.62 * 30 * 0.62**3
    expected = 3 * 1025 * flow * (flow / 0.12 - 0.95 * 10.0)
    assert found["thrust"] == pytest.approx(expected)
    assert found["X"] == pytest.approx(expected)


@given(delta=st.floats(0.01, 0.5), u=st.floats(0.0, 15.0))
def test_a_positive_angle_of_the_jet_turns_to_starboard(delta, u):
    found = answer("waterjet", u=u, n=30.0, delta=delta, zj=0.01, **JET)
    mirrored = answer("waterjet", u=u, n=30.0, delta=-delta, zj=0.01, **JET)
    assert found["Y"] < 0 < found["N"]
    assert found["K"] > 0
    assert found["N"] == pytest.approx(-0.5 * 175 * found["Y"])
    for name, sign in (("X", 1), ("Y", -1), ("N", -1), ("K", -1)):
        assert mirrored[name] == pytest.approx(sign * found[name])


@pytest.mark.parametrize("n", [30.0, -21.0])
def test_the_bucket_stops_the_ship_whatever_the_sign_of_the_order(n):
    """A crash stop orders revolutions astern and the bucket down; the pump runs on."""
    up, down = (answer("waterjet", u=0.0, n=n, bucket=b, **JET)["X"] for b in (0.0, 1.0))
    assert down == pytest.approx(-0.5 * up)
    assert answer("waterjet", u=5.0, n=n, bucket=1.0, **JET)["X"] < down


def test_the_bucket_turns_the_side_force_round_with_the_nozzle():
    ahead = answer("waterjet", u=0.0, n=30.0, delta=0.3, bucket=0.0, **JET)
    astern = answer("waterjet", u=0.0, n=30.0, delta=0.3, bucket=1.0, **JET)
    assert astern["Y"] / astern["X"] == pytest.approx(ahead["Y"] / ahead["X"])


def test_the_water_taken_in_damps_sway_and_yaw():
    c = JET | {"turning": 1.0}
    flow = 3 * 1025 * 0.62 * 30 * 0.62**3
    sway = answer("waterjet", u=10.0, v=0.5, n=30.0, **c)
    assert sway["Y"] == pytest.approx(-flow * 0.5)
    yaw = answer("waterjet", u=10.0, r=0.05, n=30.0, **c)
    assert yaw["N"] == pytest.approx(-flow * (0.4 * 175) ** 2 * 0.05)


def test_no_revolutions_no_force():
    assert all(value == 0.0 for value in answer("waterjet", u=8.0, v=0.4, n=0.0, **JET).values())


def test_three_jets_of_a_patrol_vessel_have_the_right_order_of_magnitude():
    """44 m, 330 t, 34 knots, 3 x 2720 kW: 85 % of it in jets 1.6 times as fast as the ship.

    The useful share of the power in a jet is Froude's 2/(1 + Vj/u); a planing hull at this speed
    takes about a tenth of its weight.
    """
    u, n, D = 34 * 0.5144, 2050 / 60, 0.62
    jet, power = 1.6 * u, 0.85 * 2.72e6
    nozzle = power / (0.5 * 1025 * jet * (jet**2 - u**2))
    flow = nozzle * jet / (n * D**3)
    c = {"number": 3.0, "nozzle": nozzle, "D": D, "phi0": flow, "turning": 0.0}
    found = answer("waterjet", u=u, n=n, **c)
    assert found["thrust"] * u == pytest.approx(3 * power * 2 / 2.6)
    assert 0.07 < found["thrust"] / (330e3 * 9.81) < 0.12


RANGES = {
    "crossflow_drag": {"CD": 0.8, "station": STATIONS, "CD_station": ENDS},
    "four_quadrant_propeller": S175_SCREW
    | {
        "pitch": 0.9,
        "tau": 1.0,
        "cp": 0.5,
        "C1": 2.0,
        "C2_positive": 1.6,
        "C2_negative": 1.1,
        "kq0": 0.06,
        "kq1": -0.04,
        "beta_deg": (-180.0, 0.0, 90.0, 180.0),
        "CT": (-0.2, 0.2, -0.8, -0.2),
        "CQ": (-0.03, 0.03, -0.1, -0.03),
        "J_astern": (-1.0, 0.0),
        "Yp": (0.1, 0.05),
        "Np": (-0.05, -0.02),
    },
    "shaft": DIESEL | {"n_rated": 2.0, "power_max": 4e6, "reverse_below": 0.5, "friction": 1e4},
    "shaft_lag": {"time_constant": 4.0, "n_step": 0.5},
    "waterjet": JET | {"turning": 0.7, "zj": 0.01, "kq": 0.02, "phi1": -0.1},
}


@pytest.mark.slow
@pytest.mark.parametrize("name", RANGES)
@given(data=st.data())
def test_one_instant_and_whole_histories_agree(name, data):
    """The same function on floats and over arrays, with every option."""
    effect = CATALOGUE[name]
    words = {key: data.draw(st.sampled_from(choice)) for key, choice in effect.options.items()}
    limits = {
        "u": (-4, 9), "v": (-3, 3), "r": (-0.05, 0.05), "n": (-2, 2), "n_order": (-2, 2),
        "delta": (-0.6, 0.6), "bucket": (0, 1), "torque": (-9e5, 9e5),
    }  # fmt: skip
    rows = {k: [data.draw(st.floats(*limits[k])) for _ in range(4)] for k in limits}
    given_ = RANGES[name] | words
    history = answer(name, **{k: np.array(row) for k, row in rows.items()}, **given_)
    for i in range(4):
        instant = answer(name, **{k: row[i] for k, row in rows.items()}, **given_)
        for output, value in instant.items():
            there = np.broadcast_to(history[output], 4)[i]
            assert there == pytest.approx(value, rel=1e-9, abs=1e-6)


def with_parts(*parts: Part):
    model = load_model("s175")
    kept = {name: part for name, part in model.parts.items() if name != "propeller"}
    return model.with_(parts=MappingProxyType(kept | {part.effect: part for part in parts}))


@pytest.mark.slow
def test_simulator_runs_the_parts_interpreted_and_compiled():
    """S175 on its screw in four quadrants, with an engine: rates agree to 1e-9 in all quadrants."""
    screw = S175_SCREW | {"tau": 1.09}
    model = with_parts(
        Part(effect="four_quadrant_propeller", values=screw, options={"wake": "son-nomoto"}),
        Part(effect="shaft", values={**DIESEL, "reverse_below": 0.4}),
    )
    ready = prepare(model, 9.0)
    assert ready.self_propulsion() * 60 == pytest.approx(85.95, abs=0.01)
    states = ready.structure.states
    for u, n, order in ((9.0, 1.4, 1.4), (8.0, 0.3, -1.0), (6.0, -0.8, -1.0), (-1.0, -0.8, 1.0)):
        y = [0.0] * len(states)
        y[states.index("u")], y[states.index("v")], y[states.index("n")] = u, -0.4, n
        plain = ready.rates(y, 0.1, order)
        fast = np.zeros(len(states))
        ready.functions(fast=True).rates(
            np.array(y), 0.1, order, 0.0, np.array(ready.constants), fast
        )
        np.testing.assert_allclose(fast, plain, rtol=1e-9, atol=1e-15)


def test_the_files_of_these_effects_state_all_they_need():
    for module in (four_quadrant, shaft, waterjet):
        for effect in module.EFFECTS:
            assert effect.force is not None
            parameters = {item.name for item in effect.parameters}
            arguments = set(inspect.signature(effect.force).parameters)
            unused = parameters - arguments - {"rate_deg_s"}
            assert not unused


@given(
    steps=st.lists(st.tuples(st.floats(0.01, 50.0), st.floats(-5.0, 5.0)), min_size=2, max_size=8),
    share=st.floats(-0.2, 1.2),
)
def test_lines_through_points_are_the_same_on_floats_and_over_arrays(steps, share):
    """To the bit: near a zero of a table one last bit is many of the value."""
    xs, ys = np.cumsum([x for x, _ in steps]).tolist(), [y for _, y in steps]
    x = xs[0] + share * (xs[-1] - xs[0])
    assert interpolate(x, xs, ys) == np.interp(np.array([x]), xs, ys)[0]
