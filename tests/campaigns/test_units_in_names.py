"""Columns whose name ends in its unit are read in that unit, or named as unread."""

from __future__ import annotations

import math

import numpy as np
import pytest
from small_campaign import write_campaign

import pmmkit as pk
from pmmkit.campaigns import unit_of
from pmmkit.conventions import CHANNEL_UNITS, DEGREE_CHANNELS, channel_of, unit_in_name

KNOT = 1852 / 3600


def with_columns(folder, **columns):
    """A campaign whose first run has further columns, and that run."""
    write_campaign(folder)
    run = pk.open_campaign(folder).runs[0]
    path = next((folder / "runs").glob(f"{run.id}.csv"))
    head, *rows = path.read_text(encoding="utf-8").splitlines()
    made = [",".join([row, *(repr(x) for x in columns.values())]) for row in rows]
    path.write_text("\n".join([",".join([head, *columns]), *made, ""]), encoding="utf-8")
    return next(item for item in pk.open_campaign(folder).runs if item.id == run.id)


@pytest.mark.parametrize(
    ("column", "channel", "factor"),
    [
        ("r_deg_s", "r", math.pi / 180),
        ("p_deg_s", "p", math.pi / 180),
        ("u_knots", "u", KNOT),
        ("u_kn", "u", KNOT),
        ("n_rpm", "n", 1 / 60),
        ("sinkage_mm", "sinkage", 1e-3),
        ("phi_rad", "phi", 1.0),
    ],
)
def test_a_unit_in_the_name_is_the_unit_of_the_column(column, channel, factor, tmp_path):
    data = with_columns(tmp_path / "a", **{column: 1.5}).data
    np.testing.assert_allclose(data[channel], 1.5 * factor, rtol=1e-12)


def test_the_plain_channel_goes_before_the_one_with_a_unit(tmp_path):
    data = with_columns(tmp_path / "a", u_knots=3.0, u=1.5).data
    np.testing.assert_array_equal(data["u"], 1.5)


def test_a_column_like_a_channel_that_is_not_read_is_named(tmp_path):
    data = with_columns(tmp_path / "a", r_degs=1.5, Y_filtered=2.0).data
    assert "r" not in data
    said = data.attrs["conversions"]
    assert "column 'r_degs' is not read, for 'degs' is no unit of r" in said
    assert "Y_filtered" not in said  # Y itself is there


def test_names_that_were_known_mean_what_they_meant():
    for name, unit in CHANNEL_UNITS.items():
        assert (channel_of(name), unit_of(name, table=False)) == (name, unit)
    for name, channel in DEGREE_CHANNELS.items():
        assert unit_in_name(name) == (channel, "deg")
    assert unit_in_name("x_in") is None
