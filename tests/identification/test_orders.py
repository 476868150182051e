"""Where a zigzag begins: rudder that kept the course before is no execute, nor is a slow start."""

from __future__ import annotations

import math

import numpy as np
import pytest

import pmmkit as pk
from pmmkit.identification import evaluate_trials
from pmmkit.identification.trials.orders import Order, rudder_orders
from pmmkit.identification.trials.path import PositionNoise, path_of
from pmmkit.identification.trials.record import Record

EXECUTES = (42.3, 57.6, 80.7, 117.4)


def zigzag(t: np.ndarray, rate: float, size: float = 15.0, rest: float = 0.0) -> np.ndarray:
    """A rudder [deg] that is ordered over at EXECUTES and moves at a rate [deg/s]."""
    goal = np.full(len(t), rest)
    for number, execute in enumerate(EXECUTES):
        goal[t >= execute] = size * (-1) ** number
    found = [rest]
    for order, step in zip(goal[1:], np.diff(t), strict=True):
        found.append(found[-1] + float(np.clip(order - found[-1], -rate * step, rate * step)))
    return np.array(found)


@pytest.mark.parametrize("rate", [2.3, 10.0, math.inf])
@pytest.mark.parametrize("rest", [0.0, 2.0, 5.0, -4.0])
def test_a_helmsman_who_kept_the_course_has_not_begun_the_zigzag(rate, rest):
    t = np.arange(0.0, 150.0, 0.1)
    delta = zigzag(t, rate, rest=rest)
    early = t < 9.0
    delta[early] = -19.0 * np.sin(np.pi * t[early] / 9.0) ** 2
    found = rudder_orders(t, np.radians(delta), math.radians(15.0))
    assert [order.t for order in found] == pytest.approx(EXECUTES, abs=0.11)
    assert [math.copysign(1, order.level) for order in found] == [1, -1, 1, -1]


def test_an_attempt_that_was_broken_off_is_not_the_zigzag():
    t = np.arange(0.0, 150.0, 0.1)
    delta = zigzag(t, 2.3)
    delta[(t > 5.0) & (t < 15.0)] = 15.0
    found = rudder_orders(t, np.radians(delta), math.radians(15.0))
    assert [order.t for order in found] == pytest.approx(EXECUTES, abs=0.11)


def test_a_record_that_begins_with_the_order_has_it_at_its_first_sample():
    t = np.arange(0.0, 60.0, 0.5)
    delta = np.clip(3.0 * t, 0.0, 25.0) + np.random.default_rng(2).normal(0.0, 0.05, len(t))
    (order,) = rudder_orders(t, np.radians(delta), math.radians(25.0), single=True)
    assert order.t == pytest.approx(0.0, abs=3 * order.std)
    assert math.degrees(order.rate) == pytest.approx(3.0, rel=0.02)


def accelerating(rate: float, L: float = 3.0) -> tuple[Record, float]:
    """A model from rest with 0.3 m/s at the order, after 60 s."""
    t = np.arange(0.0, 120.0, 0.1)
    pace = np.clip(0.3 + rate * (t - 60.0), 0.0, None)
    x = np.concatenate([[0.0], np.cumsum(0.05 * (pace[1:] + pace[:-1]))])
    noise = np.random.default_rng(1).normal(0.0, 0.003, (2, len(t)))
    record = Record(
        t=t, x=x + noise[0], y=noise[1], psi=np.zeros(len(t)), others={}, north=False, step=0.1,
        grid=0.0, notes=(),
    )  # fmt: skip
    return record, L


@pytest.mark.parametrize("rate", [0.0, 0.005, 0.02, -0.01])
def test_the_approach_speed_is_that_of_the_order(rate):
    record, L = accelerating(rate)
    order = Order(60.0, 0.03, math.radians(20.0))
    noise = PositionNoise(fast=0.003)
    found = path_of(record, order, L=L, speed=0.3, current=None, noise=noise).approach
    assert found.steady == (rate == 0.0)
    assert found.speed == pytest.approx(0.3, rel=0.05 if rate else 0.02)


def test_zigzags_of_the_esso_osaka_model_begin_where_the_command_steps(shared_data, datasets):
    """The rudder column is the command, which steps to the ordered angle within one sample."""
    if not (shared_data / "esso_osaka_free").is_dir():
        pytest.skip("the records of the Esso Osaka model are not on this machine")
    campaign = pk.open_campaign(datasets / "esso_osaka", data=shared_data)
    zigzags = [run for run in campaign if run.test == "zigzag"]
    found = {trial.run: trial for trial in evaluate_trials(campaign)}
    assert len(zigzags) == 6
    for run in zigzags:
        t, delta = run.data["t"].to_numpy(), np.degrees(run.data["delta"].to_numpy())
        size = abs(math.degrees(run.settings.rudder))
        steps = np.flatnonzero(np.abs(np.diff(delta)) > 0.5 * size)
        reached = [k for k in steps if abs(abs(delta[k + 1]) - size) < 0.5]
        trial = found[run.id]
        assert trial.order == pytest.approx(0.5 * (t[reached[0]] + t[reached[0] + 1]), abs=0.11)
        assert trial.metrics["overshoot_1_deg"] > 0
        assert trial.speed == pytest.approx(run.settings.speed, rel=0.2)
