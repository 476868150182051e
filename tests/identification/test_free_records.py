"""Runs of free-running campaigns as records: rudder, wind, positions, channels."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
import xarray as xr

import pmmkit as pk
from pmmkit import FreeRecord, Run, free_records
from pmmkit.base import DataError
from pmmkit.campaigns import Attitude, Settings
from pmmkit.identification.local_fits import true_wind
from pmmkit.identification.record import rate_limited
from pmmkit.models import load_model

TANKER, LINER, SPEED = load_model("kvlcc2-l7"), load_model("s175"), 1.179
RATE = math.radians(TANKER.values("rudder_mmg")["rate_deg_s"])


def columns(**settings) -> dict[str, np.ndarray]:
    """A simulated zigzag as the columns of a run."""
    track = pk.simulate(
        TANKER, "zigzag", speed=SPEED, rudder_deg=20.0, switch_deg=20.0, dt=0.1, **settings
    )
    names = ("t", "x", "y", "psi", "u", "v", "r", "delta", "n")
    return {name: getattr(track, name).copy() for name in names}


def run_of(values: dict[str, np.ndarray], name: str = "Z20") -> Run:
    data = xr.Dataset({k: ("t", x) for k, x in values.items() if k != "t"}, {"t": values["t"]})
    return Run(
        id=name,
        test="zigzag",
        kind="history",
        loader=lambda: data,
        settings=Settings(speed=SPEED, rudder=math.radians(20), switch=math.radians(20)),
    )


def without(values, *names):
    return {name: x for name, x in values.items() if name not in names}


def test_a_clean_run_is_one_record_with_all_of_its_channels():
    values = columns()
    (record,) = free_records(run_of(values), TANKER)
    assert (record.name, record.speed) == ("Z20", SPEED)
    assert set(record.measured) == {"x", "y", "psi", "u", "v", "r"}
    for name, x in record.measured.items():
        np.testing.assert_array_equal(x, values[name])
    np.testing.assert_array_equal(record.turns, values["n"])
    assert record.wind_speed is None


def test_a_slow_record_is_no_row_of_gaps():
    """Every fifteenth sample, 1.5 s apart; one that is lost is a gap of 3 s and no gap of one."""
    slow = {name: x[::15] for name, x in columns().items()}
    (record,) = free_records(run_of(slow), TANKER, shortest=20.0)
    np.testing.assert_array_equal(record.t, slow["t"])
    holed = {name: np.delete(x, slice(30, 34)) for name, x in slow.items()}
    assert len(free_records(run_of(holed), TANKER, shortest=20.0)) == 2


# The rudder


def ordered(values) -> np.ndarray:
    """The order that the gear of the simulated ship follows: steps of 20° to either side."""
    moving = np.sign(np.diff(values["delta"], append=values["delta"][-1]))
    order, last = np.empty(len(moving)), 1.0
    for i, way in enumerate(moving):
        last = way or last
        order[i] = math.radians(20.0) * last
    return order


def test_a_rudder_that_is_measured_is_taken_as_it_is():
    values = columns()
    for rudder in ("auto", "measured"):
        (record,) = free_records(run_of(values), TANKER, rudder=rudder)
        np.testing.assert_array_equal(record.delta, values["delta"])


def test_an_order_becomes_the_angle_of_the_gear():
    values = columns()
    order = {**values, "delta": ordered(values)}
    for rudder in ("auto", "ordered"):
        (record,) = free_records(run_of(order), TANKER, rudder=rudder)
        late = record.t > record.t[0] + 3.0
        assert np.max(np.abs(record.delta - values["delta"])[late]) < 2.1 * RATE * 0.1
        assert np.max(np.abs(np.diff(record.delta))) < 1.01 * RATE * 0.1
    (record,) = free_records(run_of(order), TANKER, rudder="measured")
    np.testing.assert_array_equal(record.delta, order["delta"])


def test_a_gear_moves_at_its_rate_until_it_is_there():
    t = np.arange(0.0, 10.0, 0.5)
    made = rate_limited(t, np.where(t < 4.0, 0.3, -0.3), 0.1)
    assert made[t <= 4.0] == pytest.approx(0.3)
    assert made[t > 4.0] == pytest.approx(np.maximum(0.3 - 0.1 * (t[t > 4.0] - 4.0), -0.3))


def test_single_gaps_of_rudder_and_revolutions_are_bridged():
    values = columns()
    gappy = {name: x.copy() for name, x in values.items()}
    gappy["delta"][200] = gappy["n"][300] = gappy["n"][0] = gappy["delta"][-3:] = np.nan
    (record,) = free_records(run_of(gappy), TANKER)
    mean = 0.5 * (values["delta"][199] + values["delta"][201])
    assert record.delta[200] == pytest.approx(mean)
    assert record.turns == pytest.approx(values["n"], rel=1e-12)
    assert np.all(record.delta[-3:] == values["delta"][-4])


@pytest.mark.parametrize(
    ("name", "gap"),
    [
        ("delta", slice(20)),
        ("delta", slice(300, 320)),
        ("delta", slice(-20, None)),
        ("n", slice(20)),
        ("n", slice(300, 320)),
    ],
)
def test_long_gaps_of_rudder_and_revolutions_are_not_made_up(name, gap):
    values = columns()
    values[name][gap] = np.nan
    with pytest.raises(DataError, match="fill the gaps or cut the record"):
        free_records(run_of(values), TANKER)


# The wind

TRUE_WIND = 4.0 * np.exp(1j * math.radians(130.0))
"""Where it comes from: north along the real axis, east along the imaginary one."""


def anemometer(values, drift=0.0):
    """Speed and direction over the moving deck of `TRUE_WIND`, from the bow."""
    over_ground = (values["u"] + 1j * values["v"]) * np.exp(1j * values["psi"]) + drift
    felt = (TRUE_WIND + over_ground) * np.exp(-1j * values["psi"])
    return {"wind_speed": np.abs(felt), "wind_direction": np.angle(felt)}


def test_the_wind_over_ground_comes_from_that_over_the_deck():
    values = columns()
    felt = anemometer(values)
    own = Attitude(psi=values["psi"]).over_ground(values["u"], values["v"])
    speed, direction = true_wind(values["psi"], *felt.values(), *own)
    assert speed == pytest.approx(4.0, rel=1e-9)
    assert np.degrees(direction) == pytest.approx(130.0, rel=1e-9)
    (record,) = free_records(run_of(values | felt), TANKER)
    assert record.wind_speed == pytest.approx(4.0, rel=1e-3)
    assert np.degrees(record.wind_direction) == pytest.approx(130.0, abs=0.05)
    np.testing.assert_array_equal(record.inputs[:, 3], record.wind_speed)
    assert np.all(record.calm().inputs[:, 3:5] == 0.0)


@pytest.mark.parametrize("absent", [(), ("u", "v")])
def test_the_positions_give_the_velocity_of_the_deck(absent):
    """In a current they alone are over ground: u and v are through the water."""
    values = columns(current_speed=0.5, current_direction_deg=40.0)
    drift = 0.5 * np.exp(1j * math.radians(40.0))
    seen = without(values | anemometer(values, drift), *absent)
    (record,) = free_records(run_of(seen), TANKER)
    assert record.wind_speed == pytest.approx(4.0, rel=1e-3)
    assert np.degrees(record.wind_direction) == pytest.approx(130.0, abs=0.05)


def test_the_wind_goes_on_after_a_sample_without_it():
    """It veers all along, and one sample has no direction."""
    values = columns()
    veers = values | anemometer(values)
    veers["wind_direction"] = veers["wind_direction"] + 0.02 * values["t"]
    whole = free_records(run_of(veers), TANKER)[0].wind_direction
    veers["wind_direction"] = np.where(np.arange(len(whole)) == 99, np.nan, veers["wind_direction"])
    holed = free_records(run_of(veers), TANKER)[0].wind_direction
    np.testing.assert_allclose(np.delete(holed, 99), np.delete(whole, 99), rtol=1e-12)
    assert holed[99] == pytest.approx(whole[98:101].mean(), abs=1e-3)


def test_a_wind_may_be_left_out():
    values = columns()
    windy = values | anemometer(values)
    (record,) = free_records(run_of(windy), TANKER, wind=False)
    assert record.wind_speed is None
    assert record.wind_direction is None


# Positions and channels


def test_repeated_positions_are_no_measurements():
    values = columns()
    for name in ("x", "y"):
        values[name][400:404] = values[name][399]
    (record,) = free_records(run_of(values), TANKER)
    for name in ("x", "y"):
        assert np.flatnonzero(np.isnan(record.measured[name])).tolist() == [400, 401, 402, 403]
    assert np.isfinite(record.measured["psi"]).all()


def test_a_run_with_a_jump_is_two_records():
    values = columns()
    values["x"][600:] += 2.0
    records = free_records(run_of(values), TANKER, shortest=10.0)
    assert [record.name for record in records] == ["Z20/1", "Z20/2"]
    assert [len(record) for record in records] == [600, len(values["t"]) - 600]
    spans = [record.t[-1] - record.t[0] for record in records]
    assert len(free_records(run_of(values), TANKER, shortest=0.5 * sum(spans))) == 1
    assert free_records(run_of(values), TANKER, shortest=1e4) == ()


def test_channels_are_chosen():
    values = columns()
    (record,) = free_records(run_of(values), TANKER, channels=["psi", "x", "y"])
    assert list(record.measured) == ["psi", "x", "y"]
    rolling = values | {"phi": 0.01 * values["r"], "p": 0.0 * values["r"]}
    (upright,) = free_records(run_of(rolling), TANKER)
    assert {"phi", "p"} & set(upright.measured) == set()
    (record,) = free_records(run_of(rolling), LINER, shortest=30.0)
    assert {"phi", "p"} < set(record.measured)
    over = values | {"sog": np.hypot(values["u"], values["v"])}
    assert "sog" in free_records(run_of(over), TANKER)[0].measured


def test_errors_say_what_to_do():
    values = columns()
    with pytest.raises(DataError, match=r"Z20: it has no delta and no n: .* under \[columns\]"):
        free_records(run_of(without(values, "delta", "n")), TANKER)
    with pytest.raises(DataError, match=r"Z20 has no sog to measure by\. It has x, y, psi"):
        free_records(run_of(values), TANKER, channels=["x", "sog"])
    with pytest.raises(DataError, match=r"has no phi to measure by"):
        free_records(run_of(values | {"phi": values["r"]}), TANKER, channels=["phi"])
    lost = values | {"delta": np.full(len(values["t"]), np.nan)}
    with pytest.raises(DataError, match=r"Z20: it has no delta: .* under \[columns\]"):
        free_records(run_of(lost), TANKER)


# Records


def test_a_record_is_cut_by_time():
    (record,) = free_records(run_of(columns() | anemometer(columns())), TANKER)
    cut = record.cut(10.0, 20.0)
    assert (cut.t[0], cut.t[-1]) == (pytest.approx(10.0), pytest.approx(20.0))
    assert len(cut) == len(cut.wind_speed) == len(cut.measured["psi"]) == len(cut.delta) == 101
    assert cut.bucket is None
    assert record.inputs[:, 2] == pytest.approx(0.0)
    open_bucket = replace(record, bucket=np.ones(len(record)))
    assert np.all(open_bucket.cut(10.0, 20.0).inputs[:, 2] == 1.0)


def test_a_record_of_one_instant_is_none():
    with pytest.raises(DataError, match="2 or more"):
        FreeRecord(
            name="one", t=np.zeros(1), delta=np.zeros(1), turns=np.zeros(1), measured={}, speed=1.0
        )


# A real one


@pytest.fixture(scope="module")
def hsva(shared_data, datasets):
    if not (shared_data / "kvlcc2_hsva_free").is_dir():
        pytest.skip("kvlcc2_hsva_free is not on this machine")
    return pk.open_campaign(datasets / "kvlcc2_hsva", data=shared_data)


@pytest.mark.slow
def test_zigzags_of_a_real_model_are_records(hsva):
    runs = {run.id: run for run in hsva.runs}
    (record,) = free_records(runs["Z_10_01"], TANKER)
    assert (len(record), record.t[-1], record.speed) == (3301, pytest.approx(165.0), 1.179)
    assert set(record.measured) == {"x", "y", "psi", "r", "xdot", "ydot"}
    assert np.degrees(np.max(np.abs(record.delta))) == pytest.approx(10.0, abs=0.1)
    for values in record.measured.values():
        assert np.isfinite(values).all()
    velocity = np.gradient(record.measured["x"], record.t)
    assert np.median(np.abs(velocity - record.measured["xdot"])) < 0.02
    every = [free_records(run, TANKER) for run in hsva.runs]
    assert [len(records) for records in every] == [1] * 13


@pytest.fixture(scope="module")
def osaka(shared_data, datasets):
    if not (shared_data / "esso_osaka_free").is_dir():
        pytest.skip("esso_osaka_free is not on this machine")
    return pk.open_campaign(datasets / "esso_osaka", data=shared_data)


def test_a_model_on_a_lake_has_wind_and_stale_positions(osaka):
    model = load_model("esso-osaka-3m")
    records = [record for run in osaka.runs for record in free_records(run, model)]
    assert records
    stale = sum(int(np.isnan(record.measured["x"]).sum()) for record in records)
    assert stale > 0
    for record in records:
        assert np.isfinite(record.inputs).all()
        assert np.all(np.diff(record.t) > 0)


def test_windows_start_with_velocities_through_the_water():
    """Of a record of positions and heading in a current that is known."""
    values = columns(current_speed=0.3, current_direction_deg=40.0)
    current = (0.3 * math.cos(math.radians(40.0)), 0.3 * math.sin(math.radians(40.0)))
    (record,) = free_records(run_of(without(values, "u", "v")), TANKER)
    begins = np.array([0, 300, len(record)])
    states = ("x", "y", "psi", "u", "v", "r")
    found = record.with_(current=current).first_states(begins, states, np.zeros(6), 0.5)
    for name, x in zip(states[3:], found.T[3:], strict=True):
        np.testing.assert_allclose(x, values[name][begins[:-1]], atol=0.01)
