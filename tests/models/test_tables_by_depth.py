"""Derivatives between two depths of the water."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from pmmkit.base import ExtrapolationError, TableError
from pmmkit.conventions import Ship, Water
from pmmkit.models import TablesByDepth, TableVerdict, from_values
from pmmkit.models.tables.compare import identical

SHIP = Ship(name="m", L=4.0, B=0.6, d=0.2, volume=0.3, mass=300.0, Izz=300.0)


def table(ratio, Yv, Nv=-0.004, Fn=(0.05, 0.1), std=0.001):
    return from_values(
        {"Yv": Yv, "Nv": Nv}, std={"Yv": std, "Nv": std}, Fn=Fn, ship=SHIP,
        water=Water(depth=ratio * SHIP.d),
    )  # fmt: skip


def test_a_depth_of_the_tests_gives_their_table():
    tables = (table(2.0, [-0.01, -0.011]), table(1.2, [-0.03, -0.031]))
    for one in tables:
        ratio = one.water.depth / SHIP.d
        assert identical(TablesByDepth(tables=tables).at(ratio), one)


@given(slope=st.floats(-0.05, 0.05), start=st.floats(-0.05, 0.05), ratio=st.floats(1.21, 1.98))
def test_what_is_straight_over_the_draught_over_the_depth_is_found(slope, start, ratio):
    def law(ratio):
        return start + slope / ratio

    both = TablesByDepth(tables=(table(2.0, law(2.0)), table(1.2, law(1.2))))
    found = both.at(ratio)
    np.testing.assert_allclose(found["Yv"], law(ratio), atol=1e-15)
    assert found.water.depth == pytest.approx(ratio * SHIP.d)
    share = (1 / ratio - 1 / 2.0) / (1 / 1.2 - 1 / 2.0)
    np.testing.assert_allclose(found.std, 0.001 * np.hypot(share, 1 - share))


def test_the_middle_of_three_depths_is_between_its_neighbours():
    three = TablesByDepth(tables=(table(3.0, -0.01), table(2.0, -0.02), table(1.5, -0.06)))
    assert three.at(1 / (0.5 * (1 / 3 + 1 / 2)))["Yv"] == pytest.approx(-0.015)
    assert three.at(1 / (0.5 * (1 / 2 + 1 / 1.5)))["Yv"] == pytest.approx(-0.04)


def test_a_speed_of_one_depth_alone_is_interpolated_in_the_other():
    deep = table(2.0, [-0.01, -0.02, -0.03], Fn=(0.05, 0.1, 0.15))
    shallow = table(1.2, [-0.05, -0.06], Fn=(0.0502, 0.1501))
    found = TablesByDepth(tables=(deep, shallow)).at(1.5)
    assert len(found.Fn) == 3
    middle = float(np.interp(0.1, [0.0502, 0.1501], [-0.05, -0.06]))
    share = (1 / 1.5 - 1 / 2.0) / (1 / 1.2 - 1 / 2.0)
    assert found["Yv"][1] == pytest.approx((1 - share) * -0.02 + share * middle, rel=1e-3)


def test_beyond_the_tests_nothing_is_made_up():
    both = TablesByDepth(tables=(table(2.0, -0.01), table(1.2, -0.03)))
    for ratio in (2.1, 1.1, 0.9):
        with pytest.raises(ExtrapolationError, match=r"1\.2 to 2"):
            both.at(ratio)
    apart = TablesByDepth(
        tables=(table(2.0, [-0.01, -0.01]), table(1.2, [-0.03, -0.03], Fn=(0.2, 0.3)))
    )
    with pytest.raises(ExtrapolationError, match="no Froude number in common"):
        apart.at(1.5)


def test_what_is_no_series_over_the_depth_is_refused():
    deep, shallow = table(2.0, -0.01), table(1.2, -0.03)
    for wrong in (
        (), (shallow, deep), (deep, deep), (deep, shallow.with_(water=Water())),
        (deep, shallow.with_(ship=replace(SHIP, d=0.21))),
    ):  # fmt: skip
        with pytest.raises(TableError):
            TablesByDepth(tables=wrong)


def test_a_table_that_is_not_usable_spoils_what_lies_beside_it():
    fault = TableVerdict(faults=("Yv is positive, which no hull has.",)).to_dict()
    deep, shallow = table(2.0, -0.01), table(1.2, 0.03).with_(provenance={"verdict": fault})
    both = TablesByDepth(tables=(deep, shallow))
    assert both.at(1.5).verdict.faults


def test_the_frame_has_the_depth_before_each_row():
    frame = TablesByDepth(tables=(table(2.0, -0.01), table(1.2, -0.03))).to_pandas()
    assert frame.columns[0] == TablesByDepth.RATIO
    assert frame[TablesByDepth.RATIO].round(6).tolist() == [2.0] * 4 + [1.2] * 4
