"""A table beside its reference: differences in the table's own convention, and the worst one."""

from __future__ import annotations

import numpy as np
import pytest

from pmmkit.actions.jobs.compare import worst_deviation
from pmmkit.base import ExtrapolationError, TableError, UnknownNameError
from pmmkit.conventions import Convention, Ship, Water
from pmmkit.models import compare, from_values

MODEL = Ship(name="1:36", L=175 / 36, B=0.7056, d=8.5 / 36, volume=0.4549, mass=454.5, Izz=618.0)
FULL = Ship(name="S175", L=175.0, B=25.4, d=8.5, volume=21222.0, mass=2.12e7, Izz=2.9e10)
TRUTH = {
    "Yv": -0.0116,
    "Yr": 0.00242,
    "Nv": -0.0038545,
    "Nr": -0.00222,
    "Xudot": -0.000238,
    "Yvdot": -0.007049,
}


def measured(**changes):
    values = {"Yv": [-0.0118, -0.0120], "Nv": [-0.0039, -0.0038], "Yr": np.nan} | changes
    return from_values(
        values, std={"Yv": 1e-4, "Nv": 5e-5}, Fn=[0.145, 0.29], ship=MODEL, water=Water()
    )


def test_differences_against_plain_numbers():
    frame = compare(measured(), TRUTH).set_index(["derivative", "Fn"])
    row = frame.loc[("Yv", 0.29)]
    assert row["reference"] == -0.0116
    assert row["difference"] == pytest.approx(-0.0004)
    assert row["difference_std"] == pytest.approx(-4.0)
    assert row["difference_percent"] == pytest.approx(-100 * 0.0004 / 0.0116)
    assert not row["inside"]
    assert frame.loc[("Nv", 0.145), "inside"]
    assert set(frame.index.get_level_values(0)) == {"Yv", "Nv", "Yr"}


def test_a_number_per_froude_number():
    frame = compare(measured(), {"Yv": [-0.0118, -0.0121]})
    np.testing.assert_allclose(frame["difference_std"], [0, 1], atol=1e-9)


def test_the_reference_is_brought_to_the_convention_of_the_table():
    """Son and Nomoto's separate full-scale list against a model table that means other things."""
    separate = from_values(
        TRUTH, ship=FULL, water=Water(), convention=Convention(coriolis="separate")
    )
    table = from_values(
        {"Yv": 0.0, "Nv": 0.0, "Yr": 0.0},
        ship=MODEL,
        water=Water(),
        convention=Convention(system="prime-d", sway="beta", moment_reference_x=0.1),
    )
    reference = compare(table, separate).set_index("derivative")["reference"]
    scale, arm = 175 / 8.5, 0.1 / MODEL.L
    assert reference["Yv"] == pytest.approx(0.0116 * scale)
    assert reference["Nv"] == pytest.approx((0.0038545 - arm * 0.0116) * scale)
    assert reference["Yr"] == pytest.approx((0.00242 - 0.000238) * scale)


def test_the_uncertainty_of_the_reference_counts():
    reference = from_values({"Yv": -0.0116}, std={"Yv": 3e-4}, ship=FULL, water=Water())
    table = from_values({"Yv": -0.0116 + 5e-4}, std={"Yv": 4e-4}, ship=MODEL, water=Water())
    assert compare(table, reference)["difference_std"].tolist() == pytest.approx([1.0])


def test_a_reference_over_the_froude_number_is_interpolated_but_not_beyond():
    reference = from_values({"Yv": [-0.01, -0.02]}, Fn=[0.1, 0.3], ship=FULL, water=Water())
    table = from_values({"Yv": -0.01}, Fn=[0.2], ship=MODEL, water=Water())
    assert compare(table, reference)["reference"].tolist() == pytest.approx([-0.015])
    with pytest.raises(ExtrapolationError):
        compare(table.with_(Fn=np.array([0.4])), reference)


def test_the_worst_deviation_and_its_place():
    far, worst = worst_deviation(measured(), TRUTH)
    assert far == pytest.approx(-4.0)
    assert worst == "Yv at Fn 0.29: -4.00 standard deviations, the largest of 4"
    assert worst_deviation(measured(), TRUTH, names=["Nv"])[0] == pytest.approx(1.09)


def test_what_cannot_be_compared():
    with pytest.raises(TableError, match="in common"):
        compare(measured(), {"Kv": 1.0})
    with pytest.raises(TableError, match="3 reference values"):
        compare(measured(), {"Yv": [1.0, 2.0, 3.0]})
    with pytest.raises(UnknownNameError, match="no Nvvv"):
        compare(measured(), TRUTH, names=["Nvvv"])
    with pytest.raises(TableError, match="uncertainty"):
        worst_deviation(measured(), {"Yr": 1.0})
    pooled = from_values(TRUTH, ship=MODEL, water=Water())
    with pytest.raises(TableError, match="pooled"):
        compare(pooled, measured())
    separate = measured().with_(convention=Convention(coriolis="separate"))
    with pytest.raises(TableError, match="Xudot is needed"):
        compare(measured(), separate)


class TestBuildingTables:
    @pytest.mark.parametrize(
        ("values", "options", "words"),
        [
            ({"Yv": [1, 2, 3]}, {"Fn": [0.1, 0.2]}, "Yv: 3 numbers for 2"),
            ({"Yv": 1.0}, {"std": {"Yr": 0.1}}, "Yr has a std but no value"),
            ({}, {}, "No values"),
            ({"Yv": 1.0}, {"Fn": [0.2, 0.1]}, "ascending"),
            ({"Yv": 1.0}, {"Fn": [-0.2, 0.1]}, "none negative"),
            ({"Yv": 1.0}, {"Fn": [0.1, np.nan]}, "must be given"),
            ({"Xvr": 1.0, "Xrv": 2.0}, {}, "stand twice"),
        ],
    )
    def test_refused_with_the_reason(self, values, options, words):
        with pytest.raises(TableError, match=words):
            from_values(values, ship=MODEL, water=Water(), **options)

    def test_a_notebook_shows_a_row_per_derivative(self):
        html = measured()._repr_html_()
        forces = len({name[0] for name in measured().names})
        assert html.count("<tr") == 1 + forces + len(measured().names)
        assert "-11.8" in html
        assert "times 10³" in html
