"""Wave drift: a wall that reflects, mirror images, and a turn that a sea carries along."""

from __future__ import annotations

import math

import numpy as np
import pytest
from few_stations import thinned
from hypothesis import given
from hypothesis import strategies as st

from pmmkit.base import DataError
from pmmkit.effects.waves import drift
from pmmkit.models import Part, load_model
from pmmkit.models.library import SHIPS
from pmmkit.seakeeping import Sea, frequencies, in_waves, load_hull, rao
from pmmkit.seakeeping.second_order.mean_drift import drift_table
from pmmkit.simulation import Track, simulate

MODEL = load_model("s175-3dof")
NONE = (0.0,)
FORCES = ("DX", "DY", "DN")
FACTORS = {"kx": 1.0, "ky": 1.0, "kn": 1.0}
ANGLES = {"angle_deg": (0.0, 90.0, 180.0)}
TABLES = {**ANGLES, "DX": (-0.03, 0.0, 0.01), "DY": (0.0, -0.06, 0.0), "DN": (0.0, 0.004, 0.0)}
RESTING = {**ANGLES, "DX": (-0.01, 0.0, 0.01), "DY": (0.0, -0.05, 0.0), "DN": (0.0, -0.001, 0.0)}


@pytest.fixture(scope="module")
def table():
    hull, sea = thinned(load_hull("s175")), Sea(Hs=1.0, Tp=8.0)
    found = rao(
        hull, speeds=8.0, headings_deg=np.arange(0, 181, 15), omega=frequencies(hull.L, sea)
    )
    return drift_table(found, sea)


def sailed(from_deg, height, table=None, **options):
    values = {"Hs": height, "from_deg": from_deg, **FACTORS, **(table or {})}
    part = Part(
        effect="wave_drift", values=values, options={"coefficients": "table"} if table else {}
    )
    model = MODEL.with_(parts={**MODEL.parts, "wave_drift": part})
    return simulate(model, "turning", rudder_deg=20, speed=8.0, **options)


def over_speeds(tables):
    """A table with a row for each speed, one after the other."""
    rows = {name: sum((table[name] for table in tables.values()), ()) for name in FORCES}
    return {**ANGLES, "speeds": tuple(tables), **rows}


def push(form, bearing, table, speed=8.0, factors=None):
    names = ("speeds", "angle_deg", "DX", "DY", "DN")
    tables = [(table or {}).get(name, NONE) for name in names]
    ship = (175.0, 25.4, 1025.0, 9.81)
    factors = (*[1.0] * 3, *[0.0] * 6) if factors is None else factors
    return drift(speed, 0.0, *ship, -1.0, 0.0, form, 3.0, bearing, *factors, *tables)


@given(st.floats(1.0, 179.0))
def test_waves_from_port_are_the_mirror_image_of_those_from_starboard(bearing):
    X, Y, N = push(0, bearing, None)
    assert push(0, -bearing, None) == pytest.approx((X, -Y, -N))
    assert Y < 0


def test_the_table_pushes_along_the_waves(table):
    """From ahead backward, from starboard to port; from astern it does little in short waves."""
    assert len(table["angle_deg"]) == 13
    X = [push(1, angle, table)[0] for angle in (0.0, 45.0)]
    assert max(X) < 0
    assert push(1, 90.0, table)[1] < -0.15 * abs(push(0, 90.0, None)[1])
    assert push(1, 180.0, table)[1] == pytest.approx(0.0, abs=1.0)


@given(st.floats(-179.0, 179.0))
def test_a_factor_goes_with_the_angle_by_its_harmonics(bearing):
    """Alike from both sides: at 60° cos γ is 1/2 and cos 2γ -1/2."""
    factors = (1.0, 0.9, 0.8, 0.3, 0.2, 0.1, -0.2, 0.4, 0.5)
    c = math.cos(math.radians(bearing))
    wanted = [
        force * (at + first * c + second * (2 * c * c - 1))
        for force, at, first, second in zip(
            push(1, bearing, TABLES), factors[:3], factors[3:6], factors[6:], strict=True
        )
    ]
    np.testing.assert_allclose(push(1, bearing, TABLES, factors=factors), wanted, rtol=1e-9)


def centre(track):
    """Middle of the last whole circle."""
    turned = np.abs(np.unwrap(track.psi))
    last = turned > turned[-1] - 2 * math.pi
    return np.array([track.x[last].mean(), track.y[last].mean()])


def test_a_turn_is_carried_down_wave(table):
    """Waves from north: the circle moves south, beside the calm one."""
    calm, rough = (
        sailed(0.0, height, table, duration=1500.0, compiled=False) for height in (0.0, 5.0)
    )
    moved = centre(rough) - centre(calm)
    assert moved[0] < -0.1 * MODEL.ship.L


def test_no_waves_change_nothing():
    still = sailed(30.0, 0.0, compiled=False)
    plain = simulate(MODEL, "turning", rudder_deg=20, speed=8.0, compiled=False)
    assert still.metrics["tactical_diameter_L"] == plain.metrics["tactical_diameter_L"]


@pytest.fixture(scope="module")
def hull():
    return thinned(load_hull("s175"))


@given(st.floats(0.0, 180.0), st.floats(0.0, 1.0))
def test_between_rest_and_the_speed_of_the_table_lies_a_straight_line(bearing, share):
    both = over_speeds({0.0: RESTING, 8.0: TABLES})
    ends = np.array([push(1, bearing, RESTING), push(1, bearing, TABLES)])
    wanted = (1 - share) * ends[0] + share * ends[1]
    np.testing.assert_allclose(push(2, bearing, both, speed=8.0 * share), wanted, atol=1e-6)
    np.testing.assert_allclose(push(2, bearing, both, speed=12.0), ends[1], atol=1e-6)


@given(st.floats(0.0, 180.0), st.sampled_from([2.0, 5.0, 9.0]))
def test_at_each_speed_of_a_table_stands_the_force_of_that_speed(bearing, speed):
    """Below the first and beyond the last of the speeds the table is held."""
    own = {2.0: RESTING, 5.0: TABLES, 9.0: RESTING}
    rows = over_speeds(own)
    wanted = push(1, bearing, own[speed])
    np.testing.assert_allclose(push(2, bearing, rows, speed=speed), wanted, atol=1e-6)
    for beyond, end in ((0.5, 2.0), (12.0, 9.0)):
        held = push(2, bearing, rows, speed=beyond)
        np.testing.assert_allclose(held, push(1, bearing, own[end]), atol=1e-6)


OLD = """
[effects.wave_drift.options]
coefficients = "speeds"
[effects.wave_drift.values]
Hs = 3.0
from_deg = 30.0
speed = 8.0
angle_deg = [0.0, 90.0, 180.0]
DX = [-0.03, 0.0, 0.01]
DY = [0.0, -0.06, 0.0]
DN = [0.0, 0.004, 0.0]
DX_rest = [-0.01, 0.0, 0.01]
DY_rest = [0.0, -0.05, 0.0]
DN_rest = [0.0, -0.001, 0.0]
"""


def test_an_older_file_with_tables_at_rest_apart_is_read(tmp_path):
    file = tmp_path / "old.toml"
    file.write_text(SHIPS["s175-3dof"].file.read_text(encoding="utf-8") + OLD, encoding="utf-8")
    found = load_model(file).values("wave_drift")
    rows = over_speeds({0.0: RESTING, 8.0: TABLES})
    assert {name: found[name] for name in rows} == rows


@pytest.mark.parametrize(
    ("wrong", "says"),
    [
        ({"DX": (0.0, 1.0)}, "DX of wave_drift has 2 numbers; angle_deg ask for 3"),
        ({"angle_deg": (0.0, 180.0, 90.0)}, "angle_deg of wave_drift must ascend"),
    ],
)
def test_a_table_that_does_not_fit_its_angles_is_refused(wrong, says):
    """Compiled equations would read beyond its end."""
    with pytest.raises(DataError, match=says):
        sailed(0.0, 1.0, {**TABLES, **wrong}, compiled=False)


def test_speeds_of_a_manoeuvre_must_rise():
    with pytest.raises(DataError, match=r"rise from 0 or more: 0, 8, 4"):
        in_waves(MODEL, Sea(Hs=3.0, Tp=8.0), speed=[0.0, 8.0, 4.0])


@pytest.mark.slow
def test_a_model_is_given_the_drift_of_a_sea_and_says_so(hull):
    rough = in_waves(MODEL, Sea(Hs=3.0, Tp=8.0), speed=[0.0, 4.0, 8.0], from_deg=40.0, hull=hull)
    assert rough.values("wave_drift")["Tp"] == 8.0
    assert any("at 0, 4, 8 m/s" in note for note in rough.notes)
    assert any("Lewis forms" in note for note in rough.notes)
    ways = (
        simulate(rough, rudder_deg=20, speed=8.0, compiled=compiled) for compiled in (False, True)
    )
    one, other = (track.metrics["tactical_diameter_L"] for track in ways)
    assert one == pytest.approx(other, rel=1e-9)


@pytest.mark.slow
def test_a_sea_that_is_asked_for_stands_for_that_of_the_model(table):
    """The same height and direction by the model and by the request; none is no waves."""
    own = sailed(30.0, 4.0, table, compiled=False)
    asked = sailed(0.0, 1.0, table, wave_height=4.0, waves_from_deg=30.0, compiled=False)
    np.testing.assert_array_equal(own.y, asked.y)
    calm = sailed(30.0, 4.0, table, wave_height=0.0, compiled=False)
    plain = simulate(MODEL, rudder_deg=20, speed=8.0, compiled=False)
    assert calm.metrics["advance"] == plain.metrics["advance"]


def test_the_lever_is_held_in_waves_and_the_speed_if_asked(table):
    """In head seas the ship slows down, or the propeller turns faster from the begin."""
    calm = sailed(0.0, 0.0, table, duration=60.0)
    lever, speed = (sailed(0.0, 3.0, table, duration=60.0, revolutions=x) for x in (None, "speed"))
    assert lever.n[0] == calm.n[0]
    assert Track.LEVER_HELD in lever.notes
    assert speed.n[0] > 1.015 * calm.n[0]
    assert Track.SPEED_HELD in speed.notes
    assert not {Track.LEVER_HELD, Track.SPEED_HELD} & set(calm.notes)
    before = slice(0, 2)  # the rudder has hardly begun to move
    assert np.ptp(speed.u[before]) < 0.4 * np.ptp(lever.u[before])


def test_waves_that_nothing_feels_are_said():
    track = simulate(MODEL, rudder_deg=20, speed=8.0, wave_height=3.0, compiled=False)
    assert any("does not feel the waves" in note for note in track.notes)
    with pytest.raises(DataError, match="wave_height"):
        simulate(MODEL, rudder_deg=20, speed=8.0, wave_height=-3.0)
