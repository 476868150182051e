"""Wind, current, shallow water, shafts and jets: what they do to a ship that manoeuvres."""

from __future__ import annotations

import math
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from pmmkit.base import DataError
from pmmkit.effects.shallow_water import factors
from pmmkit.effects.wind import force
from pmmkit.equations import prepare
from pmmkit.models import Part, load_model
from pmmkit.simulation import simulate

CONTAINER = load_model("s175-3dof")
AREAS = {"AF": 600.0, "AL": 3000.0}
STATES = ("x", "y", "psi", "u", "v", "r", "delta", "n")
ANGLES = tuple(float(angle) for angle in range(0, 181, 15))
DRAUGHTS = (50.0, 5.0, 4.0, 3.0, 2.5, 2.0)
ANGLE = st.floats(-3.1, 3.1)


def with_part(model, effect, options=None, **values):
    part = Part(effect=effect, values=values, options=options or {})
    return model.with_(parts={**model.parts, effect: part})


WINDY = with_part(CONTAINER, "wind", **AREAS)


def push(speed, direction, *, u=0.0, v=0.0, psi=0.0, form="simple", tables=None):
    """X, Y, N, K of a wind on a ship of 175 m; `tables` CX, CY, CN, CK over ANGLES."""
    CX, CY, CN, CK = tables or ((0.0,) * len(ANGLES),) * 4
    return force(
        u,
        v,
        psi,
        175.0,
        speed,
        direction,
        ("simple", "table", "table-with-roll").index(form),
        1.225,
        600.0,
        3000.0,
        1.05,
        9.0,
        0.7,
        0.8,
        0.1,
        ANGLES,
        CX,
        CY,
        CN,
        CK,
    )


# Forces of the wind


@given(speed=st.floats(1.0, 20.0), direction=ANGLE)
def test_wind_forces_go_with_the_square_of_the_speed(speed, direction):
    one, three = push(speed, direction), push(3.0 * speed, direction)
    assert three == pytest.approx([9.0 * x for x in one], rel=1e-9, abs=1e-6)


@given(speed=st.floats(1.0, 20.0), direction=ANGLE, form=st.sampled_from(["simple", "table"]))
def test_wind_from_port_is_the_mirror_image_of_wind_from_starboard(speed, direction, form):
    rng = np.random.default_rng(4)
    tables = tuple(tuple(rng.normal(size=len(ANGLES)).tolist()) for _ in range(4))
    X, Y, N, K = push(speed, direction, form=form, tables=tables)
    mirrored = push(speed, -direction, form=form, tables=tables)
    if abs(direction) > 1e-6:
        assert mirrored == pytest.approx((X, -Y, -N, -K), rel=1e-9, abs=1e-6)


@given(
    wind=st.floats(0.0, 20.0), direction=ANGLE, psi=ANGLE, u=st.floats(-5, 12), v=st.floats(-3, 3)
)
def test_the_ship_feels_the_wind_less_its_own_velocity(wind, direction, psi, u, v):
    """Air and ship as vectors over ground; the force is that of the difference at rest."""
    air = -wind * np.array([math.cos(direction), math.sin(direction)])
    turn = np.array([[math.cos(psi), -math.sin(psi)], [math.sin(psi), math.cos(psi)]])
    past = turn.T @ (air - turn @ np.array([u, v]))
    still = push(math.hypot(*past), math.atan2(-past[1], -past[0]))
    size = 0.5 * 1.225 * 3000.0 * (wind + 16.0) ** 2
    moving = push(wind, direction, u=u, v=v, psi=psi)
    np.testing.assert_allclose(moving, still, rtol=1e-9, atol=1e-9 * size * 175.0)


@pytest.mark.parametrize(
    ("direction_deg", "X", "Y", "N"),
    [(0, -1, 0, 0), (90, 0, -1, 0), (180, 1, 0, 0), (45, -1, -1, -1)],
)
def test_wind_pushes_away_from_where_it_comes(direction_deg, X, Y, N):
    found = push(10.0, math.radians(direction_deg))
    for value, sign in zip(found, (X, Y, N), strict=False):
        assert np.sign(round(value, 3)) == sign


def test_tables_of_the_simple_form_are_the_simple_form_at_their_angles():
    gamma = np.radians(ANGLES)
    tables = tuple(
        tuple(x.tolist())
        for x in (-0.7 * np.cos(gamma), -0.8 * np.sin(gamma), -0.1 * np.sin(2 * gamma), 0 * gamma)
    )
    for angle in (*gamma[:-1], *(-gamma[1:-1])):
        table, simple = (push(12.0, angle, form=x, tables=tables) for x in ("table", "simple"))
        assert table == pytest.approx(simple, rel=1e-9, abs=1e-3)


def test_roll_by_a_table_is_over_the_mean_height_of_the_lateral_area():
    """K = q CK AL AL/Loa; with CK = CY lever Loa/AL it is the side force on its lever."""
    CY = tuple(-0.8 * math.sin(math.radians(angle)) for angle in ANGLES)
    none = (0.0,) * len(ANGLES)
    CK = tuple(c * 9.0 * 1.05 * 175.0 / 3000.0 for c in CY)
    lever = push(15.0, 1.0, form="table", tables=(none, CY, none, CK))
    given_ = push(15.0, 1.0, form="table-with-roll", tables=(none, CY, none, CK))
    assert lever[3] == pytest.approx(9.0 * lever[1])
    assert given_ == pytest.approx(lever)


# Wind in a manoeuvre


@pytest.mark.slow
def test_a_ship_without_a_part_wind_feels_none_bit_for_bit():
    calm = simulate(CONTAINER, speed=6.0, duration=300.0)
    gale = simulate(CONTAINER, speed=6.0, duration=300.0, wind_speed=20.0, wind_direction_deg=50.0)
    for name in STATES:
        np.testing.assert_array_equal(getattr(gale, name), getattr(calm, name))


@pytest.mark.slow
def test_no_area_no_wind_bit_for_bit():
    bare = with_part(CONTAINER, "wind", AF=0.0, AL=0.0)
    calm = simulate(CONTAINER, speed=6.0, duration=300.0)
    gale = simulate(bare, speed=6.0, duration=300.0, wind_speed=20.0, wind_direction_deg=50.0)
    for name in STATES:
        np.testing.assert_array_equal(getattr(gale, name), getattr(calm, name))


def test_still_air_is_the_air_resistance_and_nothing_else():
    """½ ρair CX AF u² beside the resistance of the water."""
    plain, aired = (prepare(model, 6.0) for model in (CONTAINER, WINDY))
    mass = 1025.0 * 21222.0 + 0.000238 * 0.5 * 1025.0 * 175.0**3
    for u in (3.0, 6.0):
        a, b = (x.accelerations(u, 0.0, 0.0, n=1.0) for x in (plain, aired))
        drag = 0.5 * 1.225 * 0.7 * 600.0 * u**2
        assert a[0] - b[0] == pytest.approx(drag / mass, rel=1e-3)
        assert b[1:] == a[1:]


@pytest.mark.slow
def test_more_revolutions_against_the_wind_fewer_before_it():
    rpm = [
        60 * simulate(WINDY, speed=6.0, duration=1.0, wind_speed=w, wind_direction_deg=d).n[0]
        for w, d in ((15.0, 0.0), (0.0, 0.0), (15.0, 180.0))
    ]
    assert rpm[0] > rpm[1] > rpm[2]


@pytest.mark.slow
@pytest.mark.parametrize("direction", [30.0, 90.0, 145.0])
def test_a_turn_in_wind_is_mirrored_with_wind_and_rudder(direction):
    one, other = (
        simulate(
            WINDY,
            speed=6.0,
            rudder_deg=side * 35.0,
            wind_speed=12.0,
            wind_direction_deg=side * direction,
        )
        for side in (1, -1)
    )
    np.testing.assert_allclose(other.x, one.x, atol=1e-6)
    np.testing.assert_allclose(other.y, -one.y, atol=1e-6)
    for name in ("advance", "transfer", "tactical_diameter"):
        assert other.metrics[name] == pytest.approx(one.metrics[name], rel=1e-9)


@pytest.mark.slow
def test_a_turn_drifts_to_leeward():
    """After a full circle in beam wind from starboard the ship is to port of where it would be."""
    calm, blown = (
        simulate(WINDY, speed=6.0, wind_speed=w, wind_direction_deg=90.0, duration=1500.0)
        for w in (0.0, 15.0)
    )
    ends = [
        np.interp(4 * math.pi, t.psi, t.y) - np.interp(2 * math.pi, t.psi, t.y)
        for t in (calm, blown)
    ]
    assert abs(ends[0]) < 0.02 * 175.0
    assert ends[1] < -0.5 * 175.0


# Adrift

LOW_SPEED = load_model("esso-osaka-3m")
ADRIFT = with_part(
    LOW_SPEED.with_values("rudder_mmg", lift_slope=0.0).with_values("propeller", kt2=0.0),
    "wind",
    AF=0.05,
    AL=0.3,
)


def adrift(direction, wind=5.0, **air):
    """A 3 m model, its propeller and rudder without force, left to the wind."""
    model = ADRIFT.with_values("wind", **air) if air else ADRIFT
    return simulate(
        model,
        speed=0.05,
        rudder_deg=1e-9,
        revolutions=1e-9,
        duration=2e4 / wind,
        compiled=False,
        wind_speed=wind,
        wind_direction_deg=direction,
    )


@pytest.mark.slow
@pytest.mark.parametrize("direction", [90.0, -90.0, 30.0, 170.0])
@pytest.mark.parametrize("wind", [2.0, 5.0])
def test_a_ship_adrift_lies_across_the_wind_and_drifts_where_the_forces_balance(direction, wind):
    """½ ρa AL cy (V - v)² = ½ ρ L d CD v²: v = V k/(1 + k), k² = ρa AL cy/(ρ L d CD)."""
    track = adrift(direction, wind)
    k = math.sqrt(1.225 * 0.3 * 0.8 / (998.0 * 3.0 * 0.20114 * 0.9665))
    assert abs(track.v[-1]) == pytest.approx(wind * k / (1 + k), rel=1e-6)
    assert abs(track.u[-1]) < 1e-5 * wind
    assert abs(track.r[-1]) < 1e-6
    bearing = math.radians(direction) - track.psi[-1]
    assert abs(math.sin(bearing)) == pytest.approx(1.0, abs=1e-6)
    assert math.copysign(1.0, track.v[-1]) == -math.copysign(1.0, math.sin(bearing))


@pytest.mark.slow
def test_the_wind_does_the_work_that_the_water_takes_from_a_ship_adrift():
    """Steady: the forces of the wind at the end are those of the cross-flow drag, turned round."""
    track = adrift(90.0, wind=8.0, cy=0.9)
    v = float(track.v[-1])
    drag = 0.5 * 998.0 * 3.0 * 0.20114 * 0.9665 * v * abs(v)
    Y = -0.5 * 1.225 * 0.9 * 0.3 * (8.0 + v) ** 2
    assert drag == pytest.approx(Y, rel=1e-6)


# Current


@pytest.mark.slow
@pytest.mark.parametrize("manoeuvre", ["turning", "zigzag"])
def test_a_current_displaces_the_track_only(manoeuvre):
    speed, towards = 1.3, math.radians(70.0)
    still = simulate(CONTAINER, manoeuvre, speed=6.0)
    drifted = simulate(
        CONTAINER, manoeuvre, speed=6.0, current_speed=speed, current_direction_deg=70.0
    )
    for name in ("psi", "u", "v", "r", "delta", "n"):
        np.testing.assert_allclose(getattr(drifted, name), getattr(still, name), atol=1e-7)
    np.testing.assert_allclose(drifted.x - still.x, speed * math.cos(towards) * still.t, atol=1e-4)
    np.testing.assert_allclose(drifted.y - still.y, speed * math.sin(towards) * still.t, atol=1e-4)


@pytest.mark.slow
def test_still_air_over_a_current_is_a_wind_against_it():
    """Drifting with the water at 1.5 m/s towards 40° one feels 1.5 m/s from 40°."""
    carried = simulate(
        WINDY, speed=6.0, duration=400.0, current_speed=1.5, current_direction_deg=40.0
    )
    blown = simulate(WINDY, speed=6.0, duration=400.0, wind_speed=1.5, wind_direction_deg=40.0)
    for name in ("psi", "u", "v", "r"):
        np.testing.assert_allclose(getattr(carried, name), getattr(blown, name), atol=1e-7)


@pytest.mark.slow
def test_a_wind_that_goes_with_the_current_is_a_calm():
    calm = simulate(WINDY, speed=6.0, duration=400.0)
    together = simulate(
        WINDY,
        speed=6.0,
        duration=400.0,
        current_speed=2.0,
        current_direction_deg=30.0,
        wind_speed=2.0,
        wind_direction_deg=-150.0,
    )
    for name in ("psi", "u", "v", "r"):
        np.testing.assert_allclose(getattr(together, name), getattr(calm, name), atol=1e-7)


# Shallow water


def shallow(name):
    return with_part(load_model(name), "shallow_water")


@pytest.mark.slow
@pytest.mark.parametrize("name", ["kvlcc2", "kcs", "s175-3dof"])
def test_very_deep_water_is_deep_water(name):
    model, speed = load_model(name), load_model(name).ship.speed(0.1)
    deep = simulate(model, speed=speed).metrics
    found = simulate(shallow(name), speed=speed, depth=1e6 * model.ship.d).metrics
    for key, value in deep.items():
        assert found[key] == pytest.approx(value, rel=1e-5), key


@pytest.mark.slow
def test_without_a_depth_the_part_changes_no_bit():
    deep, there = (simulate(m, speed=4.0) for m in (load_model("kvlcc2"), shallow("kvlcc2")))
    np.testing.assert_array_equal(there.x, deep.x)


@pytest.mark.slow
@pytest.mark.parametrize("name", ["kvlcc2", "kcs", "s175-3dof", "esso190k"])
def test_a_ship_turns_wider_the_nearer_the_bottom(name):
    """Down to two draughts; the tanker has its own terms of the depth."""
    model = load_model(name) if name == "esso190k" else shallow(name)
    ship = model.ship
    found = [simulate(model, speed=ship.speed(0.1), depth=h * ship.d).metrics for h in DRAUGHTS]
    for key in ("tactical_diameter_L", "steady_diameter_L"):
        values = [x[key] for x in found]
        assert all(a < b for a, b in pairwise(values)), (key, values)


@pytest.mark.slow
def test_a_hull_with_crossflow_drag_turns_wider_at_last():
    """Its diameter falls by 1 % down to four draughts, by these formulas, before it grows."""
    model = shallow("esso-osaka-3m")
    ship = model.ship
    deep, two, less = (
        simulate(model, speed=ship.speed(0.1), depth=h * ship.d).metrics["steady_diameter_L"]
        for h in (50.0, 2.0, 1.5)
    )
    assert 1.05 * deep < two < 0.9 * less


@pytest.mark.slow
@given(draughts=st.floats(1.21, 20.0), nearer=st.floats(0.8, 0.99))
def test_linear_sway_and_added_mass_grow_towards_the_bottom(draughts, nearer):
    ship = load_model("kvlcc2").ship
    far, near = (
        factors(h * ship.d, ship.d, ship.L, ship.B, ship.block)
        for h in (draughts, max(draughts * nearer, 1.2))
    )
    for name in ("Yv", "Nv", "Xuu", "Nvvr", "Yvdot", "Nrdot"):
        assert near[name] > far[name] > 1.0 - 5e-3


@pytest.mark.parametrize("draughts", [1.5, 1.75, 2.0, 2.5, 3.0])
def test_shallow_water_of_a_full_tanker_agrees_with_kijima(draughts):
    """1/(1 - d/h)^n - d/h, n = .40 CB B/d for Yv and .425 CB B/d for Nv (Kijima et al. 1990)."""
    ship = load_model("kvlcc2").ship
    found = factors(draughts * ship.d, ship.d, ship.L, ship.B, ship.block)
    near = 1.0 / draughts
    for name, n in (("Yv", 0.40), ("Nv", 0.425)):
        power = n * ship.block * ship.B / ship.d
        assert found[name] == pytest.approx((1 - near) ** -power - near, rel=0.1)


@pytest.mark.parametrize("draughts", [0.5, 0.99, 1.0, 1.19])
def test_a_depth_below_the_range_of_the_formulas_is_refused(draughts):
    model = shallow("kvlcc2")
    with pytest.raises(DataError, match="draughts"):
        simulate(model, speed=4.0, depth=draughts * model.ship.d)


@pytest.mark.parametrize("name", ["esso190k", "kvlcc2"])
def test_a_ship_aground_is_refused(name):
    model = load_model(name)
    with pytest.raises(DataError, match=r"draught|depth"):
        simulate(model, speed=model.ship.speed(0.1), depth=0.9 * model.ship.d)


# Shafts

ENGINE = {"inertia": 2e5, "time_constant": 1.0}


def with_engine(torque):
    """S175 whose revolutions are those of an engine with a largest torque."""
    model = CONTAINER.with_values("propeller", kq0=0.08, kq1=-0.06)
    return with_part(model, "shaft", torque_max=torque, **ENGINE)


def torque_at_approach(speed):
    """ρ n² D⁵ KQ at self-propulsion, J = (1 - w) u/(n D)."""
    n = prepare(CONTAINER, speed).self_propulsion()
    J = (1 - 0.184) * speed / (n * 6.533)
    return 1025.0 * n**2 * 6.533**5 * (0.08 - 0.06 * J)


@pytest.mark.slow
def test_an_engine_with_torque_to_spare_is_a_propeller_of_constant_revolutions():
    strong = simulate(with_engine(10 * torque_at_approach(9.0)), speed=9.0, compiled=False)
    constant = simulate(CONTAINER, speed=9.0)
    np.testing.assert_allclose(strong.n, constant.n[0], rtol=1e-6)
    for name in ("advance", "tactical_diameter", "steady_diameter"):
        assert strong.metrics[name] == pytest.approx(constant.metrics[name], rel=1e-6)


def test_an_engine_at_its_limit_slows_down_in_a_turn_to_the_torque_that_it_has():
    limit = 1.02 * torque_at_approach(9.0)
    track = simulate(with_engine(limit), speed=9.0, compiled=False)
    assert track.n[-1] < 0.9 * track.n[0]
    u, v, r, n = (float(getattr(track, name)[-1]) for name in ("u", "v", "r", "n"))
    U = math.hypot(u, v)
    across = v / U - 0.526 * r * 175.0 / U
    J = u * ((1 - 0.184) + 1.09 * across**2) / (n * 6.533)
    assert 1025.0 * n**2 * 6.533**5 * (0.08 - 0.06 * J) == pytest.approx(limit, rel=1e-3)


# Waterjets

JET = {
    "number": 2.0,
    "nozzle": 1.2,
    "D": 2.4,
    "phi0": 0.6,
    "w": 0.05,
    "t": 0.03,
    "turning": 1.0,
    "rate_deg_s": 5.0,
    "max_deg": 35.0,
}


def jet_ship():
    parts = {k: x for k, x in CONTAINER.parts.items() if k not in ("propeller", "rudder_mmg")}
    return CONTAINER.with_(parts={**parts, "waterjet": Part(effect="waterjet", values=JET)})


def test_jets_drive_a_ship_where_their_momentum_is_its_resistance():
    """2 ρ Q ((1 - t) Vj - (1 - t)(1 - w) u) = R with Q = phi0 n D³, Vj = Q/area."""
    n = prepare(jet_ship(), 9.0).self_propulsion()
    Q = 0.6 * n * 2.4**3
    pushed = 2 * 1025.0 * Q * (1 - 0.03) * (Q / 1.2 - 0.95 * 9.0)
    assert pushed == pytest.approx(0.0004226 * 0.5 * 1025.0 * 175.0**2 * 81.0, rel=1e-6)


def test_jets_turn_a_ship_alike_to_both_sides():
    one, other, less = (
        simulate(jet_ship(), speed=9.0, rudder_deg=d, compiled=False).metrics
        for d in (30.0, -30.0, 15.0)
    )
    for name in ("advance", "tactical_diameter", "steady_diameter"):
        assert other[name] == pytest.approx(one[name], rel=1e-8)
        assert less[name] > one[name]


@pytest.mark.slow
def test_jets_stop_a_ship_by_their_bucket():
    """Pumps that run on stop it sooner, and sooner with a bucket that turns more of the jet."""
    reach = [
        simulate(
            jet_ship().with_values("waterjet", reverse=x),
            "stopping",
            speed=9.0,
            turns=1.0,
            compiled=False,
        ).metrics["track_reach"]
        for x in (0.3, 0.6)
    ]
    assert reach[1] < 0.8 * reach[0]
