"""Derivatives between Froude numbers: values, their uncertainty, and the edges of the table."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.interpolate import PchipInterpolator

from pmmkit.base import ExtrapolationError, TableError
from pmmkit.conventions import Ship, Water
from pmmkit.models import from_values, interpolate
from pmmkit.models.tables.compare import identical

SHIP = Ship(name="m", L=4.861, B=0.7, d=0.236, volume=0.4549, mass=454.5, Izz=618.0)
METHODS = ("linear", "pchip", "quadratic")
SPEEDS = [0.145, 0.19, 0.217, 0.25, 0.29]


def table_of(values, Fn=SPEEDS, std=None):
    return from_values(values, Fn=Fn, std=std, ship=SHIP, water=Water())


def correlated(seed: int, k: int = 5):
    rng = np.random.default_rng(seed)
    table = table_of({"Yv": rng.normal(size=k), "Nv": rng.normal(size=k)}, Fn=SPEEDS[:k])
    root = rng.normal(size=(2 * k, 2 * k))
    return table.with_(covariance=(root @ root.T).reshape(k, 2, k, 2))


@pytest.mark.parametrize("method", METHODS)
def test_rows_of_the_table_come_back_as_they_are(method):
    table = correlated(0)
    assert identical(interpolate(table, SPEEDS, method=method), table)


@pytest.mark.parametrize("method", METHODS)
def test_a_straight_trend_is_met_by_every_method(method):
    table = table_of({"Yv": [-0.01 - 0.05 * x for x in SPEEDS]})
    at = np.linspace(0.145, 0.29, 23)
    np.testing.assert_allclose(interpolate(table, at, method=method)["Yv"], -0.01 - 0.05 * at)


@pytest.mark.parametrize("k", [3, 4, 5])
def test_a_trend_in_the_square_of_the_froude_number_is_met_by_parabolas(k):
    def truth(x):
        return -0.0116 * (1 + 1.7 * np.asarray(x) ** 2)

    table = table_of({"Yv": truth(SPEEDS[:k])}, Fn=SPEEDS[:k])
    at = np.linspace(0.145, SPEEDS[k - 1], 23)
    np.testing.assert_allclose(interpolate(table, at, method="quadratic")["Yv"], truth(at))
    beyond = interpolate(table, 0.35, method="quadratic", extrapolate=True)
    np.testing.assert_allclose(beyond["Yv"], truth(0.35))


@pytest.mark.slow
@given(
    y=st.lists(st.floats(-1, 1).map(lambda v: round(v, 3)), min_size=3, max_size=5),
    at=st.lists(st.floats(0, 1), min_size=1, max_size=6),
)
@settings(max_examples=150, deadline=None)
def test_pchip_is_that_of_scipy(y, at):
    x = SPEEDS[: len(y)]
    place = np.unique(x[0] + np.array(at) * (x[-1] - x[0]))
    ours = interpolate(table_of({"Yv": y}, Fn=x), place, method="pchip")["Yv"]
    np.testing.assert_allclose(ours, PchipInterpolator(x, y)(place), rtol=1e-9, atol=1e-12)


def test_pchip_covariance_is_that_of_its_local_slopes():
    """Differences of scipy's curve with respect to each value, away from its kinks."""
    table = correlated(3)
    place = np.array([0.16, 0.2, 0.23, 0.28])
    jacobian = np.zeros((4, 2, 5, 2))
    for column in range(2):
        for row in range(5):
            shift = np.zeros((5, 2))
            shift[row, column] = 1e-6
            up, down = (
                PchipInterpolator(SPEEDS, table.value + sign * shift)(place) for sign in (1, -1)
            )
            jacobian[:, :, row, column] = (up - down) / 2e-6
    J = jacobian.reshape(8, 10)
    expected = (J @ table.covariance.reshape(10, 10) @ J.T).reshape(4, 2, 4, 2)
    stated = interpolate(table, place, method="pchip").covariance
    np.testing.assert_allclose(stated, expected, rtol=1e-6, atol=1e-8)


def test_independent_errors_average_out_and_shared_errors_do_not():
    half = 0.5 * (SPEEDS[0] + SPEEDS[1])
    table = table_of({"Yv": [1.0, 2.0]}, Fn=SPEEDS[:2], std={"Yv": 0.1})
    assert interpolate(table, half).std[0, 0] == pytest.approx(0.1 / np.sqrt(2))
    shared = table.with_(covariance=np.full((2, 1, 2, 1), 0.01))
    assert interpolate(shared, half).std[0, 0] == pytest.approx(0.1)


def test_linear_covariance_over_derivatives_and_froude_numbers_is_that_of_the_weights():
    table = correlated(5, k=2)
    t = np.array([0.25, 0.75])
    place = SPEEDS[0] + t * (SPEEDS[1] - SPEEDS[0])
    weights = np.stack([1 - t, t], axis=1)
    expected = np.einsum("ab,biej,ce->aicj", weights, table.covariance, weights)
    np.testing.assert_allclose(interpolate(table, place).covariance, expected)


@pytest.mark.parametrize("method", METHODS)
def test_a_gap_is_bridged_only_within_the_range_of_the_values_that_are_there(method):
    values = {"Yv": 1 + np.array(SPEEDS), "Yr": [np.nan, 2.0, np.nan, 4.0, np.nan], "Nv": np.nan}
    result = interpolate(
        table_of(values, std={"Yv": 0.1, "Yr": 0.1}), [0.15, 0.217, 0.28], method=method
    )
    np.testing.assert_allclose(result["Yv"], [1.15, 1.217, 1.28])
    np.testing.assert_allclose(result["Yr"], [np.nan, 2 + 2 * 0.027 / 0.06, np.nan])
    assert np.isnan(result["Nv"]).all()
    assert np.isnan(result.std[[0, 2], 1]).all()
    assert np.isfinite(result.std[:, 0]).all()
    assert np.isfinite(result.std[1, 1])


@pytest.mark.parametrize("method", METHODS)
def test_no_extrapolation_unless_told(method):
    table = correlated(7)
    with pytest.raises(ExtrapolationError, match=r"0\.32.*0\.145 to 0\.29"):
        interpolate(table, [0.2, 0.32], method=method)
    result = interpolate(table, [0.2, 0.32], method=method, extrapolate=True)
    assert np.isfinite(result.value).all()
    assert "0.32" in result.notes[-1]
    assert "0.2 " not in result.notes[-1]


def test_lines_go_on_along_the_last_two_values():
    table = table_of({"Yv": [1.0, 2.0, 4.0]}, Fn=[0.1, 0.2, 0.3], std={"Yv": 0.1})
    result = interpolate(table, 0.4, extrapolate=True)
    assert result["Yv"] == pytest.approx([6.0])
    assert result.std[0, 0] == pytest.approx(0.1 * np.hypot(2, 1))


def test_pchip_goes_on_along_its_end_slope():
    y = [1.0, 2.0, 4.0]
    curve = PchipInterpolator([0.1, 0.2, 0.3], y)
    table = table_of({"Yv": y}, Fn=[0.1, 0.2, 0.3])
    for place, end in ((0.4, 0.3), (0.05, 0.1)):
        result = interpolate(table, place, method="pchip", extrapolate=True)
        assert result["Yv"] == pytest.approx([curve(end) + curve(end, 1) * (place - end)])


def test_the_rounding_of_a_speed_is_no_extrapolation():
    table = correlated(8)
    assert interpolate(table, 0.14499)["Yv"] == pytest.approx(table["Yv"][:1], abs=1e-14)


def test_one_froude_number_holds_there_only():
    table = table_of({"Yv": [-0.01]}, Fn=[0.2])
    assert interpolate(table, 0.2)["Yv"] == [-0.01]
    with pytest.raises(ExtrapolationError, match=r"at Fn 0\.2 only"):
        interpolate(table, 0.21)
    told = interpolate(table, [0.1, 0.21], extrapolate=True)
    assert told["Yv"].tolist() == [-0.01, -0.01]
    assert told.notes


def test_a_pooled_table_holds_at_any_froude_number():
    table = from_values({"Yv": -0.01}, ship=SHIP, water=Water())
    assert interpolate(table, 0.3) is table


def test_the_weakest_part_gives_the_degrees_of_freedom_and_the_runs():
    table = table_of({"Yv": [1.0, 2.0]}, Fn=[0.1, 0.2], std={"Yv": 0.1}).with_(
        dof=np.array([[5.0], [30.0]]), runs=np.array([[4], [9]])
    )
    result = interpolate(table, [0.15, 0.2])
    assert result.dof.tolist() == [[5.0], [30.0]]
    assert result.runs.tolist() == [[4], [9]]


@pytest.mark.parametrize("bad", [[], np.nan, [0.2, np.inf]])
def test_what_is_no_froude_number(bad):
    with pytest.raises(TableError, match="Froude number"):
        interpolate(correlated(0), bad)


def test_an_unknown_method():
    with pytest.raises(TableError, match="linear, pchip, quadratic"):
        interpolate(correlated(0), 0.2, method="spline")
