"""Numbers in words: the same rule wherever one is told, on the page as in text."""

from __future__ import annotations

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from pmmkit.presentation import fixed, number, percent, plus_minus, with_uncertainty


@pytest.mark.parametrize("value", [0.0, -0.0, -0.0004, 1e-12])
def test_what_rounds_to_zero_has_no_sign(value):
    assert fixed(value, 2) == fixed(value, 2, signed=True) == "0.00"
    assert with_uncertainty(value, 0.1) == "0.00(10)"
    assert plus_minus(value, 0.1) == "0.00 ± 0.10"
    assert percent(value / 100.0) == "0.0 %"


def test_zero_has_no_sign_to_significant_digits():
    assert number(-0.0) == "0"
    assert plus_minus(-0.0, math.nan) == "0"


def test_what_rounds_to_a_thousand_is_no_power_of_ten():
    assert number(999.96, 3) == "1000"
    assert number(12345.678, 3) == "12300"


@pytest.mark.parametrize(
    ("value", "spread", "brief", "long"),
    [
        (12345678.0, 1234.0, "1.23457(12)e+07", "(1.23457 ± 0.00012)e+07"),
        (-2.5e9, 3e7, "-2.500(30)e+09", "(-2.500 ± 0.030)e+09"),
        (5.0, 2e8, "0.0(20)e+08", "(0.0 ± 2.0)e+08"),
        (9.9999999e7, 1e6, "1.000(10)e+08", "(1.000 ± 0.010)e+08"),
    ],
)
def test_a_long_value_keeps_the_digits_of_its_uncertainty(value, spread, brief, long):
    assert with_uncertainty(value, spread) == brief
    assert plus_minus(value, spread) == long


def test_an_infinite_value_has_no_digits():
    assert with_uncertainty(math.inf, 1.0) == "–"
    assert plus_minus(-math.inf, 1.0) == "–"


@given(st.floats(-1e12, 1e12).filter(lambda x: x == 0.0 or abs(x) > 1e-9), st.floats(1e-9, 1e12))
def test_a_value_is_told_to_a_tenth_of_its_uncertainty(value, spread):
    text = plus_minus(value, spread)
    body, _, power = text.partition(")e") if text.startswith("(") else (text, "", "0")
    told, half = (float(part) * 10.0 ** int(power) for part in body.strip("(").split(" ± "))
    assert abs(told - value) <= 0.051 * spread + 1e-9 * abs(value) or spread >= 1e2 * abs(value)
    assert half == pytest.approx(spread, rel=0.051)
