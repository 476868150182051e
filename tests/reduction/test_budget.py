"""Budgets of uncertainty: closed forms, shares that add up, and the whole chain done anew."""

from __future__ import annotations

import json
import math
from dataclasses import replace
from itertools import permutations

import numpy as np
import pytest
import small_campaign
from commands import said
from hypothesis import given, settings
from hypothesis import strategies as st

import pmmkit as pk
from pmmkit import (
    Budget,
    derivative_budget,
    grid_study,
    grid_uncertainty,
    imo_budget,
    manoeuvre_budget,
    with_grids,
)
from pmmkit.base import DataError, UnknownNameError
from pmmkit.campaigns import TypeB
from pmmkit.cli import main
from pmmkit.reduction import reduce_campaign
from pmmkit.reduction.budgets.budget import BudgetResult, Source, beside
from pmmkit.simulation import sensitivities, simulate
from scripts.datasets.virtual_tank import SHIP, SON_NOMOTO, WATER, captive, programme

SPEED = 1.5
"""Of the carriage [m/s]."""
FULL = 9.0
"""The same speed of the ship [m/s], 36 times as long."""
DONOR = "s175-3dof"
SIZES = {"X": 0.2, "Y": 0.6, "N": 1.0}


def white(seed):
    def draw(channel, speed, n, number):
        return SIZES[channel] * np.random.default_rng([seed, ord(channel), number]).normal(size=n)

    return draw


def few(*kinds, **more):
    chosen = [x for x in programme((SPEED,)) if x[1] in kinds]
    return captive(runs=chosen, per_cycle=32, cycles=3.0, **more)


def drifted(structure="Yv", **more):
    return reduce_campaign(few("static_drift", **more), structure=structure, check=False)


def share(budget, result, title):
    frame = budget.of(result).to_pandas()
    return frame[frame["source"].str.startswith(title)]


# Closed forms


def test_a_gauge_that_shows_one_per_cent_too_much_moves_a_derivative_by_one_per_cent():
    source = TypeB(name="Y_gauge", std=0.01, relative=True, shared=True)
    found = derivative_budget(drifted(uncertainty=(source,)))
    (row,) = share(found, "Yv", "gauge of Y").to_dict("records")
    assert row["std"] == pytest.approx(0.01 * abs(row["value"]), rel=1e-9)
    assert (row["gum"], row["acts_as"]) == ("B", "bias")


def test_a_model_at_an_angle_to_its_carriage_has_a_side_force_at_rest():
    """Misalignment d moves Y0 by Yv d and leaves Yv."""
    d = math.radians(0.1)
    source = TypeB(name="drift", std=d, shared=True)
    truth = {"Yv": SON_NOMOTO["Yv"]}
    chosen = [x for x in programme((SPEED,)) if x[1] == "static_drift"]
    made = captive(truth, runs=chosen, uncertainty=(source,))
    found = derivative_budget(reduce_campaign(made, structure="Y0 Yv", check=False))
    (zero,) = share(found, "Y0", "drift angle: alignment").to_dict("records")
    (slope,) = share(found, "Yv", "drift angle: alignment").to_dict("records")
    assert zero["std"] == pytest.approx(abs(truth["Yv"]) * d, rel=0.02)
    assert slope["std"] < 0.01 * zero["std"]


def test_a_longer_model_has_smaller_derivatives():
    """Yv' = Yv / (½ρ L² U): 1 % of the length is 2 % of Yv', 3 % of Nv'."""
    source = TypeB(name="L", std=0.01, relative=True, shared=True)
    found = derivative_budget(drifted("Yv Nv", uncertainty=(source,)))
    for name, power in (("Yv", 2), ("Nv", 3)):
        (row,) = share(found, name, "length").to_dict("records")
        assert row["std"] == pytest.approx(abs(row["value"]) * (1.01**power - 1), rel=1e-6)


def test_a_phase_of_the_motion_turns_damping_into_added_mass():
    """The motion leads by δ: Yv moves by δ ω' Yv̇, and Yv̇ by δ Yv/ω'."""
    runs = [(f"PS{v}", "pure_sway", SPEED, {"v": v}) for v in (0.05, 0.1)]
    truth = {"Yv": -0.0116, "Yvdot": -0.007}
    source = TypeB(name="phase", std=0.02, shared=True)
    made = captive(truth, runs=runs, omega_prime=2.0, cycles=3.0, uncertainty=(source,))
    found = derivative_budget(reduce_campaign(made, structure="Yv Yvdot", check=False))
    for name, expected in (("Yv", 0.02 * 2.0 * 0.007), ("Yvdot", 0.02 * 0.0116 / 2.0)):
        (row,) = share(found, name, "phase").to_dict("records")
        assert row["std"] == pytest.approx(expected, rel=0.015)


def test_what_each_run_draws_averages_and_what_all_share_does_not():
    own, shared = (
        TypeB(name="Y_gauge", std=0.01, relative=True, shared=shared) for shared in (False, True)
    )
    found = derivative_budget(drifted(uncertainty=(own, shared)))
    frame = share(found, "Yv", "gauge of Y").set_index("acts_as")["std"]
    assert 1 / math.sqrt(6) < frame["precision"] / frame["bias"] < 0.75


def test_the_numerical_uncertainty_of_a_computation_is_a_source_of_its_name():
    found = derivative_budget(drifted("Y0 Yv", numerical={"Y": 2.0}))
    (row,) = share(found, "Y0", "U_SN of the computation: Y").to_dict("records")
    assert row["std"] == pytest.approx(2.0 / (0.5 * WATER.rho * SHIP.L**2 * SPEED**2), rel=0.01)


# Shares


@pytest.mark.slow
@settings(max_examples=30)
@given(
    st.lists(
        st.tuples(st.sampled_from(["", "weights", "clock"]), *[st.floats(-3.0, 3.0)] * 2),
        min_size=1,
        max_size=5,
    )
)
def test_shares_are_the_mean_over_all_orders_in_which_errors_come(drawn):
    """Shapley: what a source adds to the variance, averaged over all orders of the sources."""
    sources = tuple(
        Source(title=str(i), gum="B", acts="bias", factors=np.array([own]), common=cause)
        for i, (cause, *own) in enumerate(drawn)
    )
    results = (BudgetResult(name="a", value=1.0), BudgetResult(name="b", value=2.0))
    budget = Budget(subject="numbers", results=results, sources=sources)

    def variance(members):
        whole = np.zeros(2)
        for cause in {source.common for source in sources} - {""}:
            own = [sources[i].factors[0] for i in members if sources[i].common == cause]
            whole += np.sum(own, axis=0) ** 2 if own else 0.0
        return whole + sum(
            (sources[i].factors[0] ** 2 for i in members if not sources[i].common), np.zeros(2)
        )

    orders = list(permutations(range(len(sources))))
    for i in range(len(sources)):
        added = [
            variance(order[: order.index(i) + 1]) - variance(order[: order.index(i)])
            for order in orders
        ]
        np.testing.assert_allclose(
            budget.propagated.variances[i], np.mean(added, axis=0), atol=1e-9
        )
    np.testing.assert_allclose(budget.std**2, variance(range(len(sources))), atol=1e-9)
    for total, std in zip(budget.shares.sum(axis=0), budget.std, strict=True):
        assert total == pytest.approx(1.0) or std < 1e-6


def test_what_single_runs_draw_goes_to_their_kind_of_test_and_nothing_is_lost():
    """Two runs of sway and one of drift: 3² + 4² and 1² of noise, 2² of speed in the drift."""
    noise = Source(
        title="noise",
        gum="A",
        acts="precision",
        factors=np.array([[3.0], [1.0], [4.0]]),
        drawn=("pure_sway", "static_drift", "pure_sway"),
    )
    speed = Source(
        title="speed", gum="B", acts="precision", factors=np.array([[2.0]]), drawn=("static_drift",)
    )
    gauge = Source(title="gauge", gum="B", acts="bias", factors=np.array([[5.0]]))
    budget = Budget(
        subject="", results=(BudgetResult(name="a", value=1.0),), sources=(noise, speed, gauge)
    )
    by_test = budget.by_test()
    assert [(item.title, item.gum) for item in by_test.sources] == [
        ("pure_sway", "A"),
        ("static_drift", "A, B"),
        ("gauge", "B"),
    ]
    assert by_test.propagated.variances[:, 0].tolist() == [25.0, 5.0, 25.0]
    assert by_test.std == budget.std


@pytest.mark.slow
def test_gauges_of_one_calibration_share_what_they_have_in_common():
    """Weights that are 1 % off leave Nv/Yv as it is; two errors of 1 % are √2 % of it."""

    def ratio(**common):
        gauges = tuple(
            TypeB(name=f"{x}_gauge", std=0.01, relative=True, shared=True, **common) for x in "YN"
        )
        found = derivative_budget(drifted("Yv Nv", uncertainty=gauges))
        joint = reduce_campaign(few("static_drift", uncertainty=gauges), structure="Yv Nv",
                                check=False).table  # fmt: skip
        Y, N = joint.value[0, joint.index("Yv")], joint.value[0, joint.index("Nv")]
        slope = np.zeros(2)
        slope[joint.index("Yv")], slope[joint.index("Nv")] = -N / Y**2, 1 / Y
        stated = [x for x in found.sources if x.title.startswith("gauge")]
        return joint, slope, sum(x.factors for x in stated), N / Y

    joint, slope, together, value = ratio(common="weights")
    assert abs(together @ slope).item() < 1e-6 * abs(value)
    C = joint.covariance[0, :, 0, :]
    other = ratio()[0].covariance[0, :, 0, :]
    assert np.sqrt(slope @ (other - C) @ slope) == pytest.approx(
        math.sqrt(2) * 0.01 * abs(value), rel=1e-3
    )


def test_a_cause_that_not_all_runs_share_is_refused():
    with pytest.raises(DataError, match="shared = true"):
        TypeB(name="Y_gauge", std=0.1, common="weights")


@pytest.fixture(scope="module")
def whole():
    """A programme with noise and what a laboratory states."""
    stated = (
        TypeB(name="Y_gauge", std=0.01, relative=True, shared=True),
        TypeB(name="N_gauge", std=0.01, relative=True, shared=True, common="weights"),
        TypeB(name="X_gauge", std=0.01, relative=True, shared=True, common="weights"),
        TypeB(name="drift", std=math.radians(0.2), shared=True),
        TypeB(name="drift", std=math.radians(0.1)),
        TypeB(name="rho", std=2.0, shared=True),
    )
    kinds = ("static_drift", "pure_sway", "pure_yaw", "yaw_drift")
    return few(*kinds, noise=white(1), uncertainty=stated)


@pytest.fixture(scope="module")
def reduced(whole):
    return reduce_campaign(whole, check=False)


@pytest.fixture(scope="module")
def ship(reduced):
    return pk.model_of(reduced, DONOR)


@pytest.mark.slow
def test_a_budget_is_the_covariance_of_its_table(reduced):
    found = derivative_budget(reduced)
    table = reduced.table
    assert [x.name for x in found.results] == list(table.names)
    np.testing.assert_allclose(found.std, table.std[0], rtol=1e-9)
    np.testing.assert_allclose(found.shares.sum(axis=0), 1.0)
    assert {"period", "length of the model", "cross-talk: N of Y"} <= set(found.not_stated)
    assert not any("rudder" in told or "mass" in told for told in found.not_stated)


@pytest.mark.slow
def test_a_budget_of_a_manoeuvre_is_the_variance_that_its_slopes_give(reduced, ship):
    found = manoeuvre_budget(reduced, ship, "turning", speed=FULL)
    slopes = sensitivities(ship, "turning", speed=FULL)
    assert found.results[0].name == "tactical_diameter_L"
    for item, std in zip(found.results, found.std, strict=True):
        assert std == pytest.approx(slopes.std(item.name), rel=1e-6)
    np.testing.assert_allclose(found.shares.sum(axis=0), 1.0)
    lent = {x.title for x in found.sources} - {x.title for x in found.of_tests().sources}
    assert lent
    assert all(title.endswith("not tested") for title in lent)


@pytest.mark.slow
def test_the_numbers_of_the_standard_have_their_budget(reduced, ship):
    found = imo_budget(reduced, ship, speed=FULL)
    names = [x.name for x in found.results]
    assert names[:3] == ["advance", "tactical_diameter", "initial_turning"]
    assert len(names) == 6
    np.testing.assert_allclose(found.shares.sum(axis=0), 1.0)
    turn = manoeuvre_budget(reduced, ship, "turning", speed=FULL, rudder_deg=35.0)
    assert found.std[1] == pytest.approx(turn.std[0], rel=1e-9)


# The whole chain done anew


def misread(made, *, Y=0.0, weights=0.0, drift=0.0, rho=0.0, runs=None):
    """The campaign as a laboratory with these errors would hand it in."""
    found = []
    for run, own in zip(made, runs if runs is not None else [0.0] * len(made.runs), strict=True):
        data = run.data
        gains = {"Y": 1 + Y, "N": 1 + weights, "X": 1 + weights}
        data = data.assign({name: data[name] * gain for name, gain in gains.items()})
        wrong = replace(run.settings, drift=run.settings.drift + drift + own)
        found.append(run.with_(loader=lambda data=data: data, settings=wrong))
    water = replace(made.water, rho=made.water.rho + rho)
    return made.with_(runs=tuple(found), water=water)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("title", "error"),
    [("gauge of Y: calibration", {"Y": 0.01}), ("density of the water", {"rho": 2.0})],
)
def test_a_source_does_to_a_turn_what_the_whole_chain_done_anew_says(
    whole, reduced, ship, title, error
):
    """The records misread by one standard uncertainty to either side, reduced, made a model and
    sailed: half of the difference is the entry of the budget."""
    found = manoeuvre_budget(reduced, ship, "turning", speed=FULL).of("tactical_diameter_L")
    (source,) = [x for x in found.sources if x.title == title]
    sailed = []
    for side in (1.0, -1.0):
        handed = misread(whole, **{name: side * std for name, std in error.items()})
        model = pk.model_of(reduce_campaign(handed, check=False), DONOR)
        sailed.append(simulate(model, "turning", speed=FULL).metrics["tactical_diameter_L"])
    assert abs(sailed[0] - sailed[1]) / 2 == pytest.approx(
        float(np.linalg.norm(source.factors)), rel=0.02, abs=2e-5
    )


@pytest.mark.slow
def test_derivatives_of_many_laboratories_scatter_as_the_budget_says():
    """Monte Carlo: errors and noise drawn, records written and reduced anew."""
    stated = (
        TypeB(name="Y_gauge", std=0.01, relative=True, shared=True),
        TypeB(name="N_gauge", std=0.005, relative=True, shared=True, common="weights"),
        TypeB(name="X_gauge", std=0.005, relative=True, shared=True, common="weights"),
        TypeB(name="drift", std=math.radians(0.05)),
        TypeB(name="rho", std=2.0, shared=True),
    )

    def made(seed):
        return few("static_drift", noise=white(seed), uncertainty=stated)

    said = derivative_budget(reduce_campaign(made(1), structure="Yv Yvvv Nv Nvvv", check=False))
    tables = []
    for seed in range(30):
        rng = np.random.default_rng([5, seed])
        handed = misread(
            made(1000 + seed),
            Y=0.01 * rng.normal(),
            weights=0.005 * rng.normal(),
            rho=2.0 * rng.normal(),
            runs=math.radians(0.05) * rng.normal(size=7),
        )
        tables.append(reduce_campaign(handed, structure="Yv Yvvv Nv Nvvv", check=False).table)
    scatter = np.std([table.value[0] for table in tables], axis=0, ddof=1)
    ratio = dict(zip(tables[0].names, scatter / said.std, strict=True))
    assert ratio["Yv"] == pytest.approx(1.0, abs=0.3)
    assert ratio["Nv"] == pytest.approx(1.0, abs=0.3)


# Grids


@pytest.mark.parametrize("ratios", [(2.0, 2.0), (1.4, 1.4), (1.3, 1.7)])
@pytest.mark.parametrize("order", [0.5, 1.0, 1.7, 2.0])
def test_three_grids_of_a_known_order_give_their_error_exactly(order, ratios):
    """f = f0 + a h^p: the error of the finest is a h^p, U is 1.25 of it."""
    steps = np.cumprod([0.1, *ratios])
    found = grid_uncertainty(-0.0116 - 0.003 * steps**order, steps)
    assert found.order == pytest.approx(order, rel=1e-9)
    assert found.extrapolated == pytest.approx(-0.0116, rel=1e-9)
    assert found.expanded == pytest.approx(1.25 * 0.003 * 0.1**order, rel=1e-8)
    assert found.std == pytest.approx(found.expanded / 2)


@pytest.mark.parametrize(("order", "counts"), [(0.3, 0.5), (3.0, 2.0)])
def test_an_order_that_is_not_believed_has_the_larger_factor(order, counts):
    """The order counts as the nearest that is believed, and the error three times."""
    steps = np.array([1.0, 2.0, 4.0])
    values = 5.0 + 0.3 * steps**order
    found = grid_uncertainty(values, steps)
    assert found.factor == 3.0
    assert found.expanded == pytest.approx(3 * (values[1] - values[0]) / (2**counts - 1))
    assert found.expanded > 0.3


def test_the_example_of_nasa_has_its_published_figures():
    """Slater, Examining spatial (grid) convergence, NPARC Alliance: the pressure recovery of an
    inlet, by the program verify in single precision."""
    found = grid_uncertainty([0.97050, 0.96854, 0.96178], [1.0, 2.0, 4.0])
    assert found.order == pytest.approx(1.78618479, abs=2e-5)
    assert found.extrapolated == pytest.approx(0.971300304, abs=1e-7)
    assert 100 * found.expanded / found.value == pytest.approx(0.103080, abs=5e-6)


@pytest.mark.parametrize(
    ("values", "words"),
    [
        ((1.0, 1.1, 1.05), "oscillate"),
        ((1.0, 1.1, 1.15), "do not converge"),
        ((1.0, 1.1, 1.2), "do not converge"),
        ((1.0, 1.0, 1.2), "the same"),
        ((1.0, math.nan, 1.2), "finite"),
        ((1.0, 1.2), "three values"),
    ],
)
def test_grids_that_say_nothing_are_refused_with_their_reason(values, words):
    with pytest.raises(DataError, match=words):
        grid_uncertainty(values, (1.0, 2.0, 4.0))


def test_the_same_on_all_grids_has_no_error():
    assert grid_uncertainty([0.3, 0.3, 0.3], [1, 2, 4]).expanded == 0.0


def computed(step, wild=0.0):
    values = {"Yv": -0.0116 + 0.0004 * step**2, "Nv": -0.0038 + 0.0001 * step, "Yvvv": -0.1 + wild}
    return pk.from_values(values, ship=SHIP, water=WATER)


def test_three_tables_give_the_numerical_uncertainty_of_each_derivative():
    tables = [computed(1.0), computed(2.0, 0.01), computed(4.0)]
    study = grid_study(tables, (1, 2, 4))
    by_name = {name: item for (_, name), item in study.found.items()}
    assert by_name["Yv"].expanded == pytest.approx(1.25 * 0.0004)
    assert by_name["Nv"].order == pytest.approx(1.0)
    assert [name for _, name in study.refused] == ["Yvvv"]
    assert "oscillate" in str(study)


def test_a_grid_is_one_more_source_of_a_budget():
    found = derivative_budget(drifted("Yv Yvvv", noise=white(2)))
    tables = [computed(1.0), computed(2.0, 0.01), computed(4.0)]
    fuller = with_grids(
        replace(found, results=tuple(replace(x, Fn=math.nan) for x in found.results)),
        grid_study(tables, (1, 2, 4)),
    )
    assert fuller.std[0] == pytest.approx(math.hypot(found.std[0], 1.25 * 0.0004 / 2))
    assert fuller.std[1] == found.std[1]
    np.testing.assert_allclose(fuller.shares.sum(axis=0), 1.0)
    assert any("grid, Yvvv" in told for told in fuller.not_stated)


# What a user sees


def test_a_budget_says_what_it_lacks_and_an_unknown_name_its_neighbours():
    found = derivative_budget(drifted("Yv Nv", noise=white(2)))
    text = str(found)
    for words in ("noise, repeats and misfit", "together", "100.0 %", "Not stated", "scale effect"):
        assert words in text
    with pytest.raises(UnknownNameError, match="Yv"):
        found.of("Yw")
    assert [x.name for x in beside([found.of("Nv"), found.of("Yv")]).results] == ["Nv", "Yv"]
    np.testing.assert_allclose(
        beside([found.of("Nv"), found.of("Yv")]).std, found.of("Nv", "Yv").std
    )


@pytest.mark.slow
def test_the_command_writes_what_it_prints(tmp_path, capsys, monkeypatch):
    monkeypatch.chdir(tmp_path)
    folder = small_campaign.write_campaign(tmp_path / "small")
    for step, name in enumerate(("fine", "medium", "coarse")):
        pk.write_table(computed(2.0**step), tmp_path / f"{name}.csv")
    order = ["budget", folder, "--of", "Yv", "--fn", "pooled", "--steps", "1,2,4", "--grids"]
    status, content, words = said(capsys, *order, "fine.csv,medium.csv,coarse.csv")
    assert status == 0
    assert "Yv" in words
    sums = {}
    for row in content["budgets"]["derivatives"]:
        sums[row["result"]] = sums.get(row["result"], 0.0) + row["share"]
    assert sums == pytest.approx(dict.fromkeys(sums, 1.0))
    assert {"grid"} <= {row["source"] for row in content["budgets"]["derivatives"]}
    assert set(content["files"]) == {
        "budget.json",
        "budget_derivatives.csv",
        "budget_derivatives.svg",
        "grids.csv",
    }
    written = json.loads((tmp_path / "small-budget" / "budget.json").read_text(encoding="utf-8"))
    assert written["not_stated"] == content["not_stated"]
    assert main(["budget", str(folder), "--steps", "1,2,4"]) == 2
