"""Intervals of a model that lacks something: widened by what its records say, and only then."""

from __future__ import annotations

import math
from dataclasses import replace
from types import MappingProxyType

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.stats import t as t_student
from test_filters import SENSORS, SPEED, TANKER, off, sailed

import pmmkit as pk
from pmmkit import FreeRecord, identify
from pmmkit.identification import Prior
from pmmkit.identification.lack import RecordPiece, colour_of, lack_of, lasting, stretches
from pmmkit.inference import Innovations
from pmmkit.models import Part, load_model

NAMES = ("Xvr", "Yv", "Yr", "Yvvv", "Yvvr", "Yvrr", "Nv", "Nr", "Nvvv", "Nvvr", "Nvrr", "Nrrr")
RUDDER = TANKER.parts["rudder_mmg"]
STALLING = replace(
    TANKER,
    parts=MappingProxyType(
        {
            **TANKER.parts,
            "rudder_mmg": replace(
                RUDDER,
                options=MappingProxyType({**RUDDER.options, "stall": "smooth"}),
                values=MappingProxyType({**RUDDER.values, "stall_deg": 18.0, "stall_loss": 0.4}),
            ),
        }
    ),
)
"""The tanker with a rudder that stalls, which no model here knows of."""


def campaign(ship, seed):
    """Two turns and two zigzags."""
    runs = [("turning", 35.0), ("turning", -35.0), ("zigzag", 20.0), ("zigzag", -10.0)]
    return [
        sailed(
            ship,
            kind,
            seed=seed + place,
            dt=0.8,
            rudder_deg=angle,
            **({"duration": 150.0} if kind == "turning" else {"switch_deg": abs(angle)}),
        ).with_(name=f"{kind} {angle:g}")
        for place, (kind, angle) in enumerate(runs)
    ]


def found_by(method, ship, seed):
    truth = Prior.of(TANKER, NAMES, SPEED, spread=0.2)
    return identify(
        TANKER,
        campaign(ship, 10 * seed),
        NAMES,
        method=method,
        prior=off(truth, seed),
        sensors=SENSORS,
    ), truth.mean


@pytest.mark.slow
@pytest.mark.parametrize("method", ["ekf", "trajectory"])
def test_a_complete_model_keeps_the_intervals_of_its_noise(method):
    found, truth = found_by(method, TANKER, 1)
    assert found.missing == ()
    assert not found.detail.lack.found
    assert np.mean(np.abs(found.values - truth) < 1.96 * found.std) > 0.8
    assert np.median(found.std / found.prior.std) < 0.3


@pytest.mark.slow
@pytest.mark.parametrize("method", ["ekf", "ukf", "trajectory"])
def test_a_rudder_that_stalls_unknown_widens_the_intervals_and_leads_to_diagnose(method):
    held = []
    for seed in (1, 3):
        found, truth = found_by(method, STALLING, seed)
        held.append(np.abs(found.values - truth) < 1.96 * found.std)
        assert any("pmmkit diagnose" in text for text in found.missing)
        assert any("Something is missing" in text for text in found.remarks())
        assert found.model.covariance == pytest.approx(found.covariance)
        assert np.median(found.std / found.prior.std) < 1.5
    assert np.mean(held) > 0.8


def blown(seed):
    """The container ship in a wind of 12 m/s of which her model and her records know nothing."""
    ship = load_model("s175-3dof")
    values = {"AF": 500.0, "AL": 2000.0, "cx": 0.7, "cy": 0.8, "cn": 0.1}
    wind = Part(effect="wind", source="test", values=MappingProxyType(values))
    truth = ship.with_(parts={**ship.parts, "wind": wind})
    runs = [
        *[("turning", 7.0, 25.0), ("turning", 7.0, -35.0), ("turning", 10.0, 20.0)],
        *[("zigzag", 7.0, 15.0), ("zigzag", 7.0, -25.0), ("zigzag", 10.0, 10.0)],
    ]
    rng, found = np.random.default_rng(seed), []
    noise = {"x": 0.3, "y": 0.3, "psi": 2e-3, "u": 0.02, "v": 0.02, "r": 2e-4}
    for kind, speed, angle in runs:
        track = pk.simulate(
            truth, kind, speed=speed, rudder_deg=angle, dt=1.0, wind_speed=12.0,
            wind_direction_deg=40.0,
            **({"duration": 600.0} if kind == "turning" else {"switch_deg": abs(angle)}),
        )  # fmt: skip
        seen = {k: getattr(track, k) + s * rng.normal(size=len(track)) for k, s in noise.items()}
        found.append(
            FreeRecord(
                name=f"{kind} {angle:g}", t=track.t, delta=track.delta, turns=track.n,
                measured=seen, speed=speed,
            )
        )  # fmt: skip
    return ship, found, noise


@pytest.mark.slow
def test_a_regression_in_unknown_wind_says_so_and_widens_its_intervals():
    """Forces of the wind last through a record: they are in no difference of its windows."""
    for seed in (0, 1, 2):
        ship, records, noise = blown(seed)
        found = identify(ship, records, method="regression", spread=0.2, sensors=noise)
        assert any("pmmkit diagnose" in text for text in found.missing)
        assert found.detail.lack.colour["X"] > 2.0


def test_residuals_that_last_are_seen_and_those_that_do_not_are_not():
    rng = np.random.default_rng(3)
    white = [(np.repeat(rng.normal(size=60), 12), 12) for _ in range(6)]
    assert lasting({"X": white}) == {}
    slow = [(x + rng.normal(), count) for x, count in white]
    assert lasting({"X": slow})["X"] > 3.0


def ridge(rows):
    """Least squares beside a prior of unit variance about zero: values, covariance."""
    X, y = (np.concatenate([item[i] for item in rows]) for i in (0, 1))
    covariance = np.linalg.inv(np.eye(X.shape[1]) + X.T @ X)
    return covariance @ X.T @ y, covariance


def test_the_scatter_between_records_is_that_of_fits_without_each_of_them():
    """Jackknife over six records by six fits (CV3 of MacKinnon, Nielsen and Webb 2023)."""
    rng = np.random.default_rng(5)
    rows = []
    for _ in range(6):
        X = rng.normal(size=(50, 2)) * [3.0, 1.0]
        rows.append((X, X @ (np.ones(2) + rng.normal(size=2)) + rng.normal(size=50)))
    values, narrow = ridge(rows)
    pieces = [
        RecordPiece(record=i, information=X.T @ X, score=X.T @ (y - X @ values))
        for i, (X, y) in enumerate(rows)
    ]
    found = lack_of(unit_prior(2), narrow, pieces, {}, clustered=True).covariance
    moved = np.array([ridge(rows[:i] + rows[i + 1 :])[0] - values for i in range(6)])
    few = (t_student.isf(0.025, 5) / 1.96) ** 2
    right = few * 5.0 / 6.0 * moved.T @ moved
    assert np.linalg.eigvalsh(found - right)[0] > -1e-3 * right.max()
    two = lack_of(unit_prior(2), narrow, pieces[:2], {}, clustered=True)
    np.testing.assert_array_equal(
        two.covariance, lack_of(unit_prior(2), narrow, pieces[:2], {}).covariance
    )


def test_intervals_by_the_scatter_of_few_records_hold_what_they_say():
    """Four records, each off by its own values: 96 % of 1000 campaigns; by noise alone 50 %."""
    rng, held, alone = np.random.default_rng(6), [], []
    for _ in range(1000):
        truth, rows = 0.3 * rng.normal(size=2), []
        for _ in range(4):
            X = rng.normal(size=(30, 2))
            rows.append((X, X @ (truth + 0.5 * rng.normal(size=2)) + rng.normal(size=30)))
        values, narrow = ridge(rows)
        pieces = [
            RecordPiece(record=i, information=X.T @ X, score=X.T @ (y - X @ values))
            for i, (X, y) in enumerate(rows)
        ]
        found = lack_of(unit_prior(2), narrow, pieces, {}, clustered=True).covariance
        away = np.abs(values - truth)
        held.append(away < 1.96 * np.sqrt(np.diagonal(found)))
        alone.append(away < 1.96 * np.sqrt(np.diagonal(narrow)))
    assert 0.93 < np.mean(held) < 0.985
    assert np.mean(alone) < 0.6


def test_the_bias_of_a_ridge_is_that_of_many_truths():
    """Rows that are nearly alike: errors without noise over all errors, in truths of the prior."""
    rng, n = np.random.default_rng(7), 4000
    X = rng.normal(size=(20, 1)) * [1.0, 0.98] + 0.1 * rng.normal(size=(20, 2))
    truths, noise = rng.normal(size=(n, 2)), rng.normal(size=(n, 20))
    narrow = np.linalg.inv(np.eye(2) + X.T @ X)
    bias = truths @ X.T @ X @ narrow - truths
    whole = bias + noise @ X @ narrow
    found = unit_prior(2).ridge_biases(narrow)
    assert [item.name for item in found] == ["Yv", "Yvv"]
    for i, item in enumerate(found):
        assert item.share == pytest.approx(
            np.mean(bias[:, i] ** 2) / np.mean(whole[:, i] ** 2), rel=0.06
        )
        assert item.like == ("Yvv", "Yv")[i]
    longer = found[0].longer
    much = np.linalg.inv(np.eye(2) + longer * X.T @ X)
    assert (much @ much)[0, 0] / much[0, 0] == pytest.approx(0.1, rel=1e-6)
    assert unit_prior(2).ridge_biases(np.linalg.inv(np.eye(2) + 100.0 * np.eye(2))) == ()
    unheard = unit_prior(2).ridge_biases(np.diag([1.0, 1e-3]))
    assert [(item.name, item.longer, item.like) for item in unheard] == [("Yv", math.inf, "")]


def unit_prior(size):
    return Prior(
        names=tuple(f"Y{'v' * (i + 1)}" for i in range(size)),
        mean=np.zeros(size),
        covariance=np.eye(size),
    )


def test_records_that_agree_leave_the_covariance_to_the_bit():
    rng = np.random.default_rng(0)
    pieces = [
        RecordPiece(record=i, information=np.eye(2) * 100.0, score=10.0 * rng.normal(size=2))
        for i in range(6)
    ]
    covariance = np.eye(2) / 601.0
    found = lack_of(unit_prior(2), covariance, pieces, {})
    assert not found.found
    assert found.words() == ()
    np.testing.assert_array_equal(found.covariance, covariance)


@pytest.mark.parametrize(("size", "sharp"), [(0.4, 1e6), (1e-3, 1e10), (90.0, 1e2)])
def test_the_scatter_between_many_sharp_records_is_that_of_their_mean(size, sharp):
    """With windows that determine all, the variance is that of a mean of as many draws."""
    rng = np.random.default_rng(1)
    drawn = size * rng.normal(size=200)
    drawn -= drawn.mean()
    pieces = [
        RecordPiece(record=i, information=np.array([[sharp]]), score=np.array([sharp * x]))
        for i, x in enumerate(drawn)
    ]
    found = lack_of(unit_prior(1), np.array([[1.0 / (1.0 + 200 * sharp)]]), pieces, {})
    assert found.shift == pytest.approx(drawn.std(), rel=1e-3)
    assert found.covariance[0, 0] == pytest.approx(drawn.var() / 200, rel=2e-3)


def test_values_that_an_overconfident_filter_holds_to_six_digits_may_wander():
    """An unscented filter of a stalling rudder told 14 values with a condition of 2e10: inverted
    twice its covariance was not positive."""
    rng, n = np.random.default_rng(0), 14
    axes = np.linalg.qr(rng.normal(size=(n, n)))[0]
    told = (axes * np.geomspace(1e-3, 1e10, n)) @ axes.T
    narrow = np.linalg.inv(np.eye(n) + 4.0 * told)
    narrow = 0.5 * (narrow + narrow.T)
    pieces = [
        RecordPiece(record=i, information=told, score=told @ rng.normal(size=n)) for i in range(4)
    ]
    found = lack_of(unit_prior(n), narrow, pieces, {})
    assert 0.5 < found.shift < 2.0
    assert np.all(np.diagonal(found.covariance) >= np.diagonal(narrow))


@pytest.mark.parametrize("colour", [{}, {"psi": 1.65}])
def test_an_axis_that_sigma_points_alone_are_sure_of_is_as_wide_as_records_tell(colour):
    """4e-11 of the prior's variance came of a stalling rudder: inverted twice it was negative, and
    intervals that were found with it 20 times as wide as the prior's."""
    rng, n = np.random.default_rng(1), 14
    axes = np.linalg.qr(rng.normal(size=(n, n)))[0]
    told = [(axes * np.geomspace(1e-3, 1e4, n) * s) @ axes.T for s in (0.2, 0.3, 0.5)]
    pieces = [
        RecordPiece(record=i, information=x, score=x @ rng.normal(size=n))
        for i, x in enumerate(told)
    ]
    sound = np.linalg.inv(np.eye(n) + sum(told))
    sure = axes[:, -1:] @ axes[:, -1:].T
    narrow = sound - (axes[:, -1] @ sound @ axes[:, -1] - 4e-11) * sure
    prior = unit_prior(n)
    plain, mended = (
        lack_of(prior, narrow, pieces, colour, sigma_points=points) for points in (False, True)
    )
    assert np.linalg.eigvalsh(plain.covariance)[0] > 0.0
    np.testing.assert_allclose(mended.alone, sound, rtol=1e-6, atol=1e-10)
    assert np.max(np.diagonal(mended.covariance)) < 3.0


@pytest.mark.slow
@given(st.integers(0, 10_000), st.floats(1.0, 1e3))
def test_no_interval_becomes_narrower_nor_wider_than_what_lasting_errors_leave(seed, colour):
    rng = np.random.default_rng(seed)
    root = rng.normal(size=(3, 3))
    told = root @ root.T * 10.0 ** rng.uniform(-2, 4)
    narrow = np.linalg.inv(np.eye(3) + told)
    found = lack_of(unit_prior(3), narrow, [], {"r": colour})
    more = found.covariance - narrow
    assert np.linalg.eigvalsh(more)[0] > -1e-9 * np.max(np.diagonal(found.covariance))
    np.testing.assert_allclose(
        found.covariance, np.linalg.inv(np.eye(3) + told / colour), rtol=1e-5, atol=1e-9
    )


def test_colour_is_the_long_run_variance_of_an_autoregression():
    """x(t) = a x(t-1) + e(t) of unit variance: sums grow by (1 + a)/(1 - a) (Priestley 1981)."""
    rng, a, n = np.random.default_rng(2), 0.5, 20_000
    noise = rng.normal(size=n) * np.sqrt(1.0 - a * a)
    from scipy.signal import lfilter

    x = np.stack([lfilter([1.0], [1.0, -a], noise), rng.normal(size=n)], axis=1)
    item = Innovations(names=("r", "psi"), residuals=x, variances=np.ones_like(x))
    found = colour_of({"zigzag": item}, {"zigzag": 25.0})
    assert set(found) == {"r"}
    assert found["r"] == pytest.approx(3.0, rel=0.25)


def test_stretches_hold_every_instant_once():
    record = sailed(dt=0.5)
    parts = stretches(record, 20.0)
    assert len(parts) == round((record.t[-1] - record.t[0]) / 20.0)
    np.testing.assert_array_equal(np.concatenate([part.t for part in parts]), record.t)
