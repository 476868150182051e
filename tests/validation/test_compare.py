"""A model beside measurements: what is predicted, what may differ anyway, and what stands out."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pandas as pd
import pytest
import small_campaign
import xarray as xr
from hidden_effects import BASE, hidden_campaign

import pmmkit as pk
from pmmkit import Campaign, Run, begin, errors_in_percent
from pmmkit.base import DataError, ModelError, UnknownNameError
from pmmkit.campaigns import Settings, TypeB
from pmmkit.inference import COVERAGE
from pmmkit.models import Part
from pmmkit.plotting.marks import BarSeries
from pmmkit.reduction import View
from pmmkit.reduction.observations.views import repeat_scatter
from pmmkit.validation.captive import compare_captive
from pmmkit.validation.misfit import Standout, cells
from pmmkit.validation.uncertainty import SHARES
from pmmkit.views import comparison_figures
from pmmkit.views.figures.comparison import errors_beside_uncertainty, loops, worst_of_each_test
from pmmkit.views.figures.workshop import residuals_over
from scripts.datasets.s175_truth import load_truth

HALF = 0.5 * small_campaign.RHO * small_campaign.L**2
"""½ρL² of the small campaign's model."""


@pytest.fixture(scope="module")
def s175(datasets):
    return pk.open_campaign(datasets / "s175")


@pytest.fixture(scope="module")
def truth(s175):
    """The model that made the S175 programme, with values at its three speeds."""
    speeds = sorted({run.settings.speed for run in s175})
    table = load_truth().table([s175.ship.froude(speed, s175.water.g) for speed in speeds])
    return pk.to_model(table, parts="s175-3dof")


@pytest.fixture(scope="module")
def small(tmp_path_factory):
    return pk.open_campaign(small_campaign.write_campaign(tmp_path_factory.mktemp("c") / "small"))


@pytest.fixture(scope="module")
def one_set():
    """Son and Nomoto's derivatives at all speeds, total values."""
    return pk.to_model(
        pk.from_values(small_campaign.TRUTH, ship=pk.load_ship("s175-3dof"), water=pk.Water()),
        parts="s175-3dof",
    )


@pytest.fixture(scope="module")
def perfect(s175, truth):
    return pk.compare(truth, s175)


@pytest.fixture(scope="module")
def lacking(s175, truth):
    """The comparison with a model that lacks N_vvr."""
    return pk.compare(without(truth, "Nvvr"), s175)


def without(model, *names):
    """The model with some derivatives of the hull set to zero."""
    hull = model.parts["hull_polynomial"].values
    zero = {
        name: tuple(0.0 for _ in value) if isinstance(value := hull[name], tuple) else 0.0
        for name in names
    }
    return model.with_values("hull_polynomial", **zero)


def by_hand(view):
    m = view.motion
    return small_campaign.forces(m.u, m.v, m.r, m.udot, m.vdot, m.rdot)


# What is predicted


@pytest.mark.slow
def test_the_prediction_is_the_sum_of_terms_written_by_hand(small, one_set):
    runs, _ = compare_captive(one_set, small, floor=0.005)
    assert {run.view.run.test for run in runs} >= {"static_drift", "pure_sway", "pure_yaw"}
    for run in runs:
        expected = by_hand(run.view)
        for name in "XYN":
            np.testing.assert_allclose(run.history[name], expected[name], rtol=1e-9, atol=1e-9)
            np.testing.assert_allclose(
                run.predicted[name], run.view.projection @ expected[name], rtol=1e-9, atol=1e-9
            )


@pytest.mark.slow
def test_a_ship_of_full_scale_with_separate_coriolis_terms_predicts_the_same(small):
    """The library's S175 is 175 m long and has mx, my apart; captive tests measure both together.

    Son and Nomoto print four digits, so the totals agree to their rounding.
    """
    model = pk.load_model("s175-3dof")
    assert model.convention.coriolis == "separate"
    runs, notes = compare_captive(model, small, floor=0.005)
    assert any("Froude's law" in note for note in notes)
    assert any("propeller" in note and "rudder" in note for note in notes)
    for run in runs:
        expected = by_hand(run.view)
        for name in "YN":
            scale = np.max(np.abs(expected[name])) + 1.0
            assert np.max(np.abs(run.history[name] - expected[name])) < 2e-3 * scale


@pytest.mark.slow
def test_a_hull_towed_without_its_rudder_is_predicted_without_it(small):
    """Taking propeller and rudder off the model by hand changes nothing."""
    model = pk.load_model("s175-3dof")
    bare = model.with_(
        parts={name: model.parts[name] for name in ("hull_polynomial", "added_mass")}
    )
    one, _ = compare_captive(model, small, floor=0.005)
    two, _ = compare_captive(bare, small, floor=0.005)
    for a, b in zip(one, two, strict=True):
        for name in a.channels:
            np.testing.assert_array_equal(a.predicted[name], b.predicted[name])


def test_any_effect_of_the_model_is_predicted(small, one_set):
    """Cross-flow drag in static drift: Y' = -CD d/L sin β |sin β| for a constant CD."""
    parts = {**one_set.parts, "crossflow_drag": Part(effect="crossflow_drag", values={"CD": 0.8})}
    drifting = small.select("static_drift")
    more, _ = compare_captive(one_set.with_(parts=parts), drifting, floor=0.005)
    plain, _ = compare_captive(one_set, drifting, floor=0.005)
    ship = small.ship
    for a, b in zip(more, plain, strict=True):
        v = float(a.view.motion.v.mean())
        expected = -0.5 * small.water.rho * ship.L * ship.d * 0.8 * v * abs(v)
        assert a.predicted["Y"][0] - b.predicted["Y"][0] == pytest.approx(expected, rel=0.02)


@pytest.mark.slow
def test_a_memory_of_the_model_is_predicted(small, one_set):
    """Pure sway: with T = lag L/U the late part of Yv has (1 - 1/(1 + iωT)) of its force too much.

    The late part follows U v, a sine but for the change of U; in static drift nothing is late.
    """
    late, lag = 0.2 * small_campaign.TRUTH["Yv"], 0.5
    memory = Part(effect="memory", values={"Yv_late": late, "Nv_late": 0.0, "lag": lag})
    model = one_set.with_(parts={**one_set.parts, "memory": memory})
    tests = small.select("pure_sway", "static_drift")
    more, _ = compare_captive(model, tests, floor=0.005)
    plain, _ = compare_captive(one_set, tests, floor=0.005)
    for a, b in zip(more, plain, strict=True):
        found = a.predicted["Y"] - b.predicted["Y"]
        if not a.view.run.dynamic:
            np.testing.assert_allclose(found, 0.0, atol=1e-9)
            continue
        view = a.view
        m = view.motion
        driving = view.project(m.speed * m.v)
        turn = view.omega * lag * small.ship.L / view.speed
        response = 1.0 / (1.0 + 1j * turn) - 1.0
        place = view.labels.index("C1")
        wave = (driving[place] - 1j * driving[place + 1]) * response * HALF * late
        scale = abs(wave)
        assert found[place] == pytest.approx(wave.real, abs=0.02 * scale)
        assert found[place + 1] == pytest.approx(-wave.imag, abs=0.02 * scale)


def test_a_model_of_another_ship_is_refused(s175):
    with pytest.raises(ModelError, match=r"another ship .*B/L 0\.1400 against 0\.1451"):
        pk.compare("kcs", s175)


@pytest.mark.slow
def test_speeds_outside_the_model_are_named_and_left_out(s175, truth):
    low = load_truth().table([0.1448, 0.2172])
    found = pk.compare(pk.to_model(low, parts="s175-3dof"), s175.select("pure_yaw"))
    assert {run.view.speed for run in found.captive} == {1.0, 1.5}
    assert any("PY_U2.0_r0.6" in note and "Extrapolation" in note for note in found.notes)
    with pytest.raises(DataError, match="No run is left"):
        pk.compare(
            pk.to_model(load_truth().table([0.05, 0.06]), parts="s175-3dof"),
            s175.select("pure_yaw"),
        )


@pytest.mark.parametrize("floor", [-0.1, 1.0, math.nan])
def test_a_floor_is_a_share(s175, floor):
    with pytest.raises(DataError, match="share"):
        pk.compare("s175", s175, floor=floor)


# What may differ anyway


@pytest.mark.slow
def test_the_model_that_made_the_forces_differs_by_no_more_than_the_uncertainty(perfect):
    """Expanded uncertainties hold at least 95 % of the errors, and are not far too wide."""
    found = perfect.harmonics()
    assert len(found) > 1000
    assert (found["ratio"] < 1.0).mean() > 0.95
    assert np.sqrt((found["ratio"] ** 2).mean()) > 0.2
    assert perfect.standouts() == ()


@pytest.mark.slow
def test_the_rows_of_a_run_are_the_root_mean_squares_of_its_harmonics(s175, truth):
    found = pk.compare(truth, s175.select("pure_sway"))
    row = found.to_pandas().iloc[1]
    own = found.harmonics().query(f"run == '{row.run}' and channel == '{row.channel}'")
    weights = np.where(own["harmonic"] == "C0", 1.0, 0.5)
    for column in ("error", "measured", "uncertainty"):
        assert row[column] == pytest.approx(math.sqrt(weights @ own[column] ** 2))
    assert row["uncertainty"] == pytest.approx(
        COVERAGE * math.sqrt(sum(row[name] ** 2 for name in SHARES))
    )
    assert row["within"] == (row["error"] < row["uncertainty"])


@pytest.mark.slow
def test_labels_rows_and_runs_hold_the_same_numbers(s175, truth):
    """One harmonic of one force, as a label picks it, as a row, and in the run."""
    found = pk.compare(truth, s175.select("pure_sway"))
    data, run = found.to_xarray(), found.captive[0]
    at = {"run": run.view.run.id, "channel": "N", "harmonic": "S1"}
    one, place = data.sel(at), run.view.labels.index("S1")
    assert float(one["predicted"]) == run.predicted["N"][place]
    assert float(one["error"]) == run.error("N")[place]
    assert float(one["uncertainty"]) == run.uncertainty("N")[place]
    assert (str(one["unit"].values), bool(one["known"])) == ("N m", True)
    std = one["standard_uncertainty"]
    assert COVERAGE * math.sqrt(float((std**2).sum())) == pytest.approx(float(one["uncertainty"]))
    row = found.harmonics().set_index(list(at)).loc[tuple(at.values())]
    assert row["error"] == float(one["error"])
    assert row["speed"] == pytest.approx(run.view.speed)
    assert row["Fn"] == pytest.approx(run.Fn)


def test_an_uncertain_drift_angle_is_the_slope_of_the_force(small, one_set):
    """By hand: the change of the forces when the model is turned by one standard uncertainty."""
    std = math.radians(0.1)
    stated = small.select("static_drift").with_(uncertainty=(TypeB(name="drift", std=std),))
    runs, _ = compare_captive(one_set, stated, floor=0.0)
    for run in runs:
        speed, beta = run.view.speed, run.view.run.settings.drift

        def at(angle, speed=speed):
            return small_campaign.forces(
                speed * np.cos(angle), -speed * np.sin(angle), *np.zeros(4)
            )

        for name in "XYN":
            expected = abs(at(beta + std)[name] - at(beta)[name])
            assert run.shares["stated"][name][0] == pytest.approx(expected, rel=1e-6)


def test_gauges_act_on_means_or_in_proportion(small, one_set):
    stated = small.select("pure_sway").with_(
        uncertainty=(TypeB(name="Y_gauge", std=0.3), TypeB(name="N_gauge", std=0.01, relative=True))
    )
    runs, _ = compare_captive(one_set, stated, floor=0.0)
    for run in runs:
        share = run.shares["stated"]
        assert share["Y"][0] == pytest.approx(0.3)
        assert not np.any(share["Y"][1:])
        np.testing.assert_allclose(share["N"], 0.01 * np.abs(run.view.force["N"]))
        assert not np.any(share["X"])


def test_errors_of_one_cause_add_with_their_signs(small, one_set):
    """Two errors of one gauge; and a gain and a density that grow alike, which cancel."""

    def stated(*sources):
        runs, _ = compare_captive(
            one_set, small.select("static_drift").with_(uncertainty=sources), floor=0.0
        )
        return [(run, run.shares["stated"]["Y"][0]) for run in runs]

    def zero(std, common=""):
        return TypeB(name="Y_gauge", std=std, shared=True, common=common)

    independent = stated(zero(0.3), zero(0.4))
    together = stated(zero(0.3, "weights"), zero(0.4, "weights"))
    for (_, apart), (_, alike) in zip(independent, together, strict=True):
        assert apart == pytest.approx(0.5)
        assert alike == pytest.approx(0.7)
    gain, density = (
        TypeB(name=name, std=0.01, relative=True, shared=True, common="weights")
        for name in ("Y_gauge", "rho")
    )
    for run, share in stated(gain, density):
        assert share == pytest.approx(0.01 * abs(run.error("Y")[0]), rel=1e-6)


@pytest.mark.slow
@pytest.mark.parametrize("forces", ["hydrodynamic", "balance"])
def test_an_uncertain_point_of_the_motions_is_the_difference_when_it_is_moved(
    small, one_set, forces
):
    """Truth: the whole comparison once more with the point further forward."""
    std = 0.05
    here = small.with_(
        runs=tuple(run.with_(forces=forces) for run in small), motion_reference_x=0.12
    )
    source = TypeB(name="motion_reference_x", std=std, shared=True)
    stated, _ = compare_captive(one_set, here.with_(uncertainty=(source,)), floor=0.0)
    moved, _ = compare_captive(one_set, here.with_(motion_reference_x=0.12 + std), floor=0.0)
    turning = [run.view.run.test for run in stated if np.any(run.view.motion.r)]
    assert "pure_yaw" in turning
    for run, other in zip(stated, moved, strict=True):
        assert run.view.run.id == other.view.run.id
        for name in "XYN":
            change = np.abs(other.error(name) - run.error(name))
            largest = np.abs(run.predicted[name]).max()
            np.testing.assert_allclose(
                run.shares["stated"][name], change, rtol=1e-6, atol=1e-10 * largest
            )
            if run.view.run.test in turning and name in "YN":
                assert np.abs(change).max() > 1e-4 * largest


def test_the_covariance_of_a_model_counts(small, one_set):
    """Of Yv alone: σ ½ρL²U² |v'|, by hand."""
    known = one_set.with_(covariance=np.array([[0.001**2]]), covariance_names=("Yv",))
    runs, _ = compare_captive(known, small.select("static_drift"), floor=0.0)
    for run in runs:
        expected = 0.001 * HALF * run.view.speed**2 * abs(math.sin(run.view.run.settings.drift))
        assert run.shares["model"]["Y"][0] == pytest.approx(expected, rel=1e-6, abs=1e-12)
        assert run.shares["model"]["N"][0] == 0.0


def test_values_of_parts_count_beside_derivatives_and_with_what_they_have_in_common(small, one_set):
    """J = (∂Y/∂Yv, ∂Y/∂CD) by hand, C with a correlation: what a fit of both leaves unknown."""
    std, alike = np.array([0.001, 0.02]), np.array([[1.0, -0.8], [-0.8, 1.0]])
    drag = Part(effect="crossflow_drag", values={"CD": 0.8})
    model = one_set.with_(
        parts={**one_set.parts, "crossflow_drag": drag},
        covariance=alike * np.outer(std, std),
        covariance_names=("Yv", "crossflow_drag.CD"),
    )
    ship = small.ship
    runs, _ = compare_captive(model, small.select("static_drift"), floor=0.0)
    for run in runs:
        v = float(run.view.motion.v.mean())
        slopes = np.array(
            [HALF * run.view.speed * v, -0.5 * small.water.rho * ship.L * ship.d * v * abs(v)]
        )
        expected = math.sqrt(slopes @ model.covariance @ slopes)
        assert run.shares["model"]["Y"][0] == pytest.approx(expected, rel=0.02, abs=1e-12)


def test_an_estimate_of_a_part_counts_as_a_stated_one(small, one_set):
    """σ of CD, without covariance: σ/CD of its force."""
    drag = Part(effect="crossflow_drag", values={"CD": 0.8}, std={"CD": 0.04})
    model = one_set.with_(parts={**one_set.parts, "crossflow_drag": drag})
    runs, _ = compare_captive(model, small.select("static_drift"), floor=0.0)
    plain, _ = compare_captive(one_set, small.select("static_drift"), floor=0.0)
    for run, bare in zip(runs, plain, strict=True):
        force = run.predicted["Y"][0] - bare.predicted["Y"][0]
        assert run.shares["model"]["Y"][0] == pytest.approx(0.05 * abs(force), rel=2e-3, abs=1e-12)


def test_a_part_that_the_tests_do_not_hold_takes_nothing_else_of_the_covariance_with_it(
    small, one_set
):
    """Towed without its rudder a hull is as uncertain as if nothing were told of the rudder."""
    alone = one_set.with_(covariance=np.array([[0.001**2]]), covariance_names=("Yv",))
    both = one_set.with_(
        covariance=np.array([[1e-6, 2e-5], [2e-5, 2.5e-3]]),
        covariance_names=("Yv", "rudder_mmg.aH"),
    )
    tests = small.select("static_drift")
    for one, two in zip(
        *(compare_captive(model, tests, floor=0.0)[0] for model in (alone, both)), strict=True
    ):
        assert one.shares["model"]["Y"][0] == two.shares["model"]["Y"][0]


@pytest.mark.slow
def test_the_covariance_between_two_speeds_is_that_of_the_mean(s175, truth):
    """Half way between two Froude numbers with equal, independent errors: σ/√2."""
    names = truth.Fn[0], truth.Fn[2]
    table = load_truth().table(names)
    model = pk.to_model(table, parts="s175-3dof")
    model = model.with_(covariance=np.diag([0.001**2] * 2), covariance_names=("Nr",))
    runs, _ = compare_captive(model, s175.select("pure_yaw"), floor=0.0)
    first, middle = runs[0], next(run for run in runs if run.view.speed == 1.5)
    ratio = np.linalg.norm(middle.shares["model"]["N"]) / np.linalg.norm(first.shares["model"]["N"])
    assert ratio == pytest.approx(1.5**2 / math.sqrt(2), rel=1e-3)


def test_the_numerical_uncertainty_and_the_floor_count(small, one_set):
    numerical = small.select("static_drift").with_(numerical={"N": 3.0})
    runs, _ = compare_captive(one_set, numerical, floor=0.02)
    sizes = [run.view.force["Y"][0] / run.view.speed**2 for run in runs]
    for run in runs:
        assert run.shares["numerical"]["N"][0] == 3.0
        assert run.shares["numerical"]["Y"][0] == 0.0
        expected = 0.02 * run.view.speed**2 * np.sqrt(np.mean(np.square(sizes)))
        assert run.shares["floor"]["Y"][0] == pytest.approx(expected)


# Runs that state no noise


def mean_run(name, Y, N, *, drift=0.1, repeat_of=None, **more):
    data = xr.Dataset({"Y": Y, "N": N, **more})
    return Run(
        id=name,
        test="static_drift",
        kind="means",
        loader=lambda: data,
        settings=Settings(speed=2.0, drift=drift, repeat_of=repeat_of),
    )


def table_campaign(small, *runs, **changes):
    return Campaign(title="tables", ship=small.ship, water=small.water, runs=runs, **changes)


def test_forces_of_tables_are_kept_when_they_are_asked_for(small):
    campaign = table_campaign(small, mean_run("a", 10.0, 5.0))
    (plain,) = View.of(campaign)
    assert dict(plain.force) == {}
    (kept,) = View.of(campaign, unknown_noise=True)
    assert kept.force["Y"].tolist() == [10.0]
    assert not kept.known("Y")
    assert kept.covariance["Y"].tolist() == [[0.0]]


def test_the_noise_of_tables_comes_from_repeats_then_statements_then_the_numerics(small):
    """Repeats 10 and 12 N: half the square of their difference, √2 N each."""
    runs = (mean_run("a", 10.0, 5.0), mean_run("b", 12.0, math.nan, repeat_of="a"))
    stated = (TypeB(name="Y_gauge", std=0.5), TypeB(name="N_gauge", std=0.1, relative=True))
    numerical = {"Y": 7.0, "N": 7.0}
    campaign = table_campaign(small, *runs, uncertainty=stated, numerical=numerical)
    first = View.of(campaign, unknown_noise=True)[0]
    assert dict(first.noise) == {"Y": "repeats", "N": "stated"}
    assert first.covariance["Y"][0, 0] == pytest.approx(2.0)
    assert first.covariance["N"][0, 0] == pytest.approx(0.5**2)
    alone = View.of(table_campaign(small, runs[0], numerical=numerical), unknown_noise=True)[0]
    assert dict(alone.noise) == {"Y": "numerical", "N": "numerical"}
    assert alone.covariance["Y"][0, 0] == 49.0
    assert alone.known("Y")


def test_a_stated_noise_of_a_mean_is_its_own(small):
    (view,) = View.of(table_campaign(small, mean_run("a", 10.0, 5.0, Y_std=0.2)))
    assert view.covariance["Y"][0, 0] == pytest.approx(0.04)


def test_views_of_records_are_the_same_bit_for_bit(s175):
    some = s175.with_(runs=s175.runs[::12])
    for one, two in zip(View.of(some), View.of(some, unknown_noise=True), strict=True):
        assert one.force.keys() == two.force.keys()
        for name in one.force:
            np.testing.assert_array_equal(one.force[name], two.force[name])
            np.testing.assert_array_equal(one.covariance[name], two.covariance[name])
        assert all(two.known(name) for name in two.force)


def test_the_scatter_of_repeats_is_found():
    """Gains and offsets of the tank's runs: repeats differ by more than the noise says."""
    campaign = hidden_campaign("full", noise="standard", seed=3)
    repeated = [run for run in campaign if run.settings.repeat_of]
    chosen = {run.id for run in repeated} | {run.settings.repeat_of for run in repeated}
    views = View.of(campaign.with_(runs=tuple(run for run in campaign if run.id in chosen)))
    late = {view.run.id: view for view in views if not view.early}
    found = repeat_scatter(views)
    for dynamic in (False, True):
        halves = [
            np.mean((late[run.id].force["Y"] - late[run.settings.repeat_of].force["Y"]) ** 2) / 2
            for run in repeated
            if run.dynamic == dynamic
        ]
        assert found["Y", dynamic] == pytest.approx(math.sqrt(np.mean(halves)))


def test_repeats_need_not_be_declared(small):
    """Eight runs, each setting twice, 8 N between runs: the same scatter whether it is said."""
    rng = np.random.default_rng(1)
    runs = [
        mean_run(f"{name}{k}", 100.0 * drift + 8.0 * rng.normal(), 5.0, drift=drift)
        for k, drift in enumerate((0.05, 0.1, 0.15, 0.2))
        for name in "ab"
    ]
    said = [
        run.with_(
            settings=replace(run.settings, repeat_of=f"a{run.id[1:]}" if "b" in run.id else None)
        )
        for run in runs
    ]
    found = repeat_scatter(View.of(table_campaign(small, *runs), unknown_noise=True))
    assert found["Y", False] == pytest.approx(8.0, rel=0.6)
    assert found == repeat_scatter(View.of(table_campaign(small, *said), unknown_noise=True))


# What stands out


@pytest.mark.slow
def test_a_missing_coupling_is_named_with_what_it_grows_with(lacking):
    """N_vvr v²r excites nothing but yaw with drift, in phase with the yaw rate."""
    found = lacking
    (sentence,) = found.standouts()
    assert sentence.startswith("N, yaw with drift, first harmonic, all speeds: ")
    assert sentence.endswith(" times the uncertainty; grows with drift squared and yaw rate")
    (one,) = found.outstanding()
    table = found.misfit()
    own = table[(table.channel == "N") & (table.test == "yaw_drift") & (table.harmonic == 1)]
    assert len(own) == 3
    assert one.ratio == pytest.approx(np.sqrt(np.mean(own["ratio"] ** 2)))
    assert (own["with_velocity"] > 10 * own["with_displacement"]).all()
    assert (table["ratio"].drop(own.index) < 2.0).all()


@pytest.mark.slow
def test_a_cubic_damping_is_told_by_its_power(s175, truth):
    found = {
        (item.channel, item.test, item.harmonic): item
        for item in pk.compare(
            without(truth, "Yvvv"), s175.select("static_drift", "pure_sway")
        ).outstanding()
    }
    assert found["Y", "static_drift", 0].growth == {"drift": 3}
    assert found["Y", "pure_sway", 1].growth == {"sway velocity": 3}
    assert ("Y", "pure_sway", 3) in found


def test_a_missing_inertia_is_in_phase_with_the_displacement(s175, truth):
    wrong = truth.with_values("added_mass", Yvdot=0.8 * -0.007049)
    table = pk.compare(wrong, s175.select("pure_sway")).misfit()
    first = table[(table.channel == "Y") & (table.harmonic == 1)]
    assert (first["with_displacement"] > 10 * first["with_velocity"]).all()


@pytest.mark.slow
def test_a_law_of_speed_is_told_where_it_is(s175, truth):
    """Resistance that does not follow the speed: the mean of X, not at the lowest speed."""
    flat = truth.parts["hull_polynomial"].values["Xuu"][0]
    model = truth.with_values("hull_polynomial", Xuu=(flat, flat, flat))
    found = pk.compare(model, s175.select("static_drift")).outstanding()
    assert [(item.channel, item.speeds) for item in found] == [("X", (1.5, 2.0))]
    assert found[0].growth == {"speed": 1}


@pytest.mark.slow
def test_the_sign_of_an_error_is_that_of_the_force_or_of_its_value(s175, truth):
    """Too little drag on drift on both sides; a force to starboard that the model has not."""
    drift = s175.select("static_drift")
    weak = pk.compare(truth.with_values("hull_polynomial", Yv=-0.008), drift).outstanding()
    cell = next(item for item in weak if item.channel == "Y")
    assert cell.sign == "too small"
    by_hand = [
        abs(run.error("Y")[0])
        for run in pk.compare(truth.with_values("hull_polynomial", Yv=-0.008), drift).captive
        if round(run.view.speed, 4) in cell.speeds
    ]
    assert cell.error == pytest.approx(np.sqrt(np.mean(np.square(by_hand))))

    def pushed(run):
        data = run.data
        return run.with_(loader=lambda: data.assign(Y=data["Y"] + 20.0))

    moved = drift.with_(runs=tuple(map(pushed, drift.runs)))
    cell = next(x for x in pk.compare(truth, moved).outstanding() if x.channel == "Y")
    assert cell.sign == "too low"
    assert cell.error == pytest.approx(20.0, rel=0.1)


def test_speeds_are_merged_listed_or_counted():
    item = Standout(
        channel="Y",
        test="static_drift",
        harmonic=0,
        speeds=(1.0, 2.0),
        tested=(1.0, 2.0),
        ratio=4.4,
        growth={},
        known=True,
    )
    assert str(item) == "Y, static drift, mean, all speeds: 4 times the uncertainty"
    assert "1 and 2 m/s" in str(replace(item, tested=(1.0, 2.0, 3.0)))
    assert "4 of 5 speeds" in str(replace(item, speeds=(1, 2, 3, 4), tested=(1, 2, 3, 4, 5)))
    assert "(noise not known)" in str(replace(item, known=False))
    sized = replace(item, error=3.14, sign="too small")
    assert str(sized).endswith("all speeds: 3.14 N too small, 4 times the uncertainty")
    assert "off by 3.14 N, " in str(replace(sized, sign="off"))
    falls = replace(item, growth={"speed": -1, "drift": 2})
    assert str(falls).endswith("grows with drift squared; falls with speed")


def in_the_tank(effects, seed):
    """A campaign of the tank, and a base fitted to its runs; rudder runs add their terms."""
    campaign = hidden_campaign("middle", effects, seed=seed, stated=True)
    table = pk.reduce(campaign, structure=BASE, fn="pooled")
    parts = {"hull_polynomial": {}, "added_mass": {}, "rudder_abkowitz": {}}
    for name in table.names:
        steered = "rudder_abkowitz" if "d" in name else "hull_polynomial"
        home = "added_mass" if name.endswith("dot") else steered
        parts[home][name] = float(table[name][0])
    model = pk.Model(
        name="base",
        ship=campaign.ship,
        water=campaign.water,
        convention=table.convention,
        parts={effect: Part(effect=effect, values=values) for effect, values in parts.items()},
    )
    return campaign, model


def loud_in_the_tank(effects, seed):
    campaign, model = in_the_tank(effects, seed)
    return pk.compare(model, campaign).outstanding()


@pytest.mark.slow
def test_nothing_stands_out_of_a_tank_without_hidden_effects():
    assert loud_in_the_tank({}, 6) == ()


@pytest.mark.slow
def test_effects_hidden_in_the_tank_stand_out_where_they_act():
    """A yaw-sway coupling in yaw with drift; an asymmetric hull in all means and nowhere else."""
    coupled = loud_in_the_tank({"yaw_sway_coupling": 1.0}, 5)
    assert {item.test for item in coupled[:2]} == {"yaw_drift"}
    assert ("yaw_drift", "N", 1) in {(x.test, x.channel, x.harmonic) for x in coupled[:4]}
    crooked = loud_in_the_tank({"asymmetry": 1.0}, 5)
    assert {item.harmonic for item in crooked} == {0}
    assert {item.test for item in crooked} >= {"static_drift", "pure_sway", "pure_yaw"}


@pytest.mark.slow
def test_the_error_falls_when_the_missing_effect_is_added():
    """To what is left with nothing hidden: errors of about half an expanded uncertainty."""
    campaign, model = in_the_tank({"memory": 1.0}, 4)
    session = begin(model, campaign)
    before, after = (
        pk.compare(item.model(), campaign).harmonics()["ratio"]
        for item in (session, session.add("memory"))
    )
    assert np.sqrt((after**2).mean()) < 0.8 * np.sqrt((before**2).mean())
    assert 0.3 < np.sqrt((after**2).mean()) < 0.5
    assert (after > 1.0).mean() < 0.05


@pytest.mark.slow
def test_the_map_holds_every_channel_test_speed_and_harmonic(s175, perfect):
    found = cells(perfect.captive)
    keys = {(cell.channel, cell.test, cell.speed, cell.harmonic) for cell in found}
    assert len(keys) == len(found) == 3 * 3 * (1 + 3 * 6)
    assert sum(cell.runs for cell in found if cell.harmonic == 0) == 3 * len(s175)


# In time


def test_the_residual_in_time_is_the_record_less_the_prediction(s175, truth):
    found = pk.compare(truth, s175.select("pure_yaw"))
    table = found.residuals("PY_U1.5_r0.4")
    record = s175["PY_U1.5_r0.4"].data
    own = np.isin(record["t"].values.round(6), (table["t"] + float(record["t"][0])).round(6))
    np.testing.assert_allclose(table["N_measured"], record["N"].values[own])
    np.testing.assert_allclose(table["N_error"], table["N_predicted"] - table["N_measured"])
    with pytest.raises(UnknownNameError):
        found.residuals("no such run")


def test_a_balance_reading_is_brought_to_the_force_of_the_water():
    """The same run with the model's inertia left inside gives the same residual in time."""
    water, balance = (
        hidden_campaign("small", noise="none", balance=inside).select("pure_yaw")
        for inside in (False, True)
    )
    model = pk.load_model("s175-3dof")
    one, two = (pk.compare(model, campaign) for campaign in (water, balance))
    name = water.runs[0].id
    for column in ("X_error", "Y_error", "N_error"):
        np.testing.assert_allclose(
            one.residuals(name)[column], two.residuals(name)[column], atol=1e-4
        )


# Free running


def free_campaign(model, *, noise=0.0, seed=0):
    """A zigzag and a turn of a model, as a campaign of free-running records."""
    runs = []
    rng = np.random.default_rng(seed)
    for test, settings in (
        ("zigzag", {"rudder_deg": 20.0, "switch_deg": 20.0}),
        ("turning", {"rudder_deg": 35.0}),
    ):
        track = pk.simulate(model, test, speed=1.179, dt=0.1, **settings)
        t = np.concatenate([np.arange(-10.0, 0.0, 0.1), track.t])
        before = len(t) - len(track.t)
        held = {
            name: np.concatenate([np.full(before, x[0]), x])
            for name, x in (("y", track.y), ("psi", track.psi), ("n", track.n), ("r", track.r))
        }
        x = np.concatenate([1.179 * t[:before], track.x])
        delta = np.concatenate([np.zeros(before), track.delta])
        channels = {"x": x, "delta": delta, **held}
        for name, size in (("x", noise), ("y", noise), ("psi", 0.1 * noise), ("r", 0.01 * noise)):
            channels[name] = channels[name] + rng.normal(0.0, size or 1e-6, len(t))
        data = xr.Dataset({name: ("t", x) for name, x in channels.items()}, coords={"t": t})
        runs.append(
            Run(
                id=test,
                test=test,
                kind="history",
                loader=lambda data=data: data,
                settings=Settings(
                    speed=1.179,
                    rudder=math.radians(settings["rudder_deg"]),
                    switch=math.radians(20.0) if test == "zigzag" else None,
                ),
            )
        )
    return Campaign(
        title="free", kind="free-running", ship=model.ship, water=model.water, runs=tuple(runs)
    )


@pytest.fixture(scope="module")
def tanker():
    return pk.load_model("kvlcc2-l7")


@pytest.fixture(scope="module")
def sea(tanker):
    return free_campaign(tanker, noise=0.003)


@pytest.mark.slow
def test_a_model_sails_its_own_records(tanker, sea):
    found = pk.compare(tanker, sea)
    table = found.to_pandas().set_index(["run", "channel"])
    for run in ("zigzag", "turning"):
        assert (
            table.loc[(run, "position"), "error"] < 0.01 * table.loc[(run, "position"), "measured"]
        )
        assert table.loc[(run, "heading"), "error"] < 1.0
        assert table.loc[(run, "Y"), "relative"] < 0.1
    metrics = found.metrics().set_index(["run", "measure"])
    for key in (
        ("zigzag", "overshoot_1_deg"),
        ("zigzag", "overshoot_2_deg"),
        ("turning", "advance"),
        ("turning", "tactical_diameter"),
    ):
        assert abs(metrics.loc[key, "relative"]) < 0.02
    assert found.kind == "free-running"
    assert len(found.residuals("zigzag")) > 100
    assert len(found.harmonics()) == len(errors_in_percent(found.captive)) == 0
    data = found.to_xarray()
    swung = data.sel(run="zigzag").dropna("sample", subset=["t"])
    off = swung["error"].sel(channel="psi")
    assert str(off["unit"].values) == "rad"
    assert math.degrees(math.sqrt(float((off**2).mean()))) == pytest.approx(
        table.loc[("zigzag", "heading"), "error"]
    )
    Y = swung["measured"].sel(channel="Y")
    assert math.sqrt(float((Y**2).mean())) == pytest.approx(table.loc[("zigzag", "Y"), "measured"])


@pytest.mark.slow
def test_a_speed_is_as_uncertain_as_its_velocities_make_it(tanker, sea):
    """Drawn in plain numpy: v counts with sin β, not with all that is unknown of it."""
    draw = np.random.default_rng(2)
    for run in pk.compare(tanker, sea).free:
        off = np.zeros((20_000, len(run.t)))
        for values, std, side in (
            (run.predicted, run.predicted_std, 1.0),
            (run.measured, run.std, -1.0),
        ):
            u, v = (values[x] + std[x] * draw.normal(size=off.shape) for x in "uv")
            off += side * np.hypot(u, v)
        told = run.errors()["speed"].uncertainty
        np.testing.assert_allclose(told, COVERAGE * off.std(axis=0), rtol=0.04)


@pytest.mark.slow
def test_too_much_yaw_damping_shows_in_overshoots_and_in_the_moment(tanker, sea):
    damped = tanker.with_values("hull_polynomial", Nr=-0.049 * 1.6)
    found = pk.compare(damped, sea)
    errors = {(row["run"], row["channel"]): row["error"] for row in found.rows()}
    own = {(row["run"], row["channel"]): row["error"] for row in pk.compare(tanker, sea).rows()}
    for run in ("zigzag", "turning"):
        assert errors[run, "N"] > 5 * own[run, "N"]
        assert errors[run, "heading"] > 5 * own[run, "heading"]
    text = " ".join(found.standouts())
    assert "overshoot 1, zigzag, the one run: predicted" in text
    assert "less than measured" in text
    assert "tactical diameter, turning, the one run: predicted" in text
    assert found.misfit().query("channel == 'N'")["ratio"].max() > 1.0


def test_a_record_without_revolutions_is_left_out_with_the_reason(tanker, sea):
    lame = sea.runs[0].data.drop_vars("n")
    runs = (sea.runs[0].with_(id="lame", loader=lambda: lame), sea.runs[1])
    found = pk.compare(tanker, sea.with_(runs=runs))
    assert {run.run.id for run in found.free} == {"turning"}
    assert any("lame is left out" in note and "no n" in note for note in found.notes)
    with pytest.raises(DataError, match="lame is left out"):
        pk.compare(tanker, sea.with_(runs=runs[:1]))
    with pytest.raises(DataError, match=r"Open it first: pk\.open_campaign"):
        pk.compare(tanker, "tests")
    both = (runs[0], runs[0].with_(id="halt"))
    with pytest.raises(DataError, match="lame and halt are left out: it has no n"):
        pk.compare(tanker, sea.with_(runs=both))


# Real measurements


@pytest.mark.slow
def test_hmri_tables_have_forces_and_an_unknown_noise(shared_data, datasets):
    campaign = pk.open_campaign(datasets / "kvlcc2_hmri", data=shared_data)
    found = pk.compare("kvlcc2-l7", campaign)
    table = found.to_pandas()
    assert len(table) > 200
    assert not table["known"].any()
    assert any("Nothing is known of the noise of N, X, Y" in note for note in found.notes)
    within_ten = table[(table.test == "pure_sway") & (table.channel == "N")]["relative"]
    assert within_ten.max() < 0.15
    stated = campaign.with_(uncertainty=(TypeB(name="N_gauge", std=0.05, relative=True),))
    again = pk.compare("kvlcc2-l7", stated).to_pandas()
    assert again[again.channel == "N"]["known"].all()


@pytest.mark.slow
def test_hsva_zigzags_are_sailed(shared_data, datasets):
    campaign = pk.open_campaign(datasets / "kvlcc2_hsva", data=shared_data)
    some = campaign.with_(runs=tuple(r for r in campaign if r.id in ("Z_20_10_P", "Z_35_05")))
    found = pk.compare("kvlcc2-l7", some)
    metrics = found.metrics().set_index(["run", "measure"])
    first = metrics.xs("overshoot_1_deg", level="measure")
    assert first.loc["Z_20_10_P", "measured"] == pytest.approx(11.0, abs=1.5)
    assert (first["predicted"] < first["measured"]).all()
    assert {"X", "Y", "N", "position"} <= set(found.to_pandas()["channel"])


# Figures


@pytest.mark.slow
def test_every_figure_of_captive_tests_says_what_and_in_which_unit(lacking):
    figures = comparison_figures(lacking)
    drawn = {"errors", "residuals", "static_forces", "over_phase", "loops", "in_time"}
    assert set(figures) == {"misfit", *drawn}
    for name in drawn:
        for axis in figures[name].axes:
            for text in (axis.xlabel.text, axis.ylabel.text):
                assert not text or text.endswith("]")
    texts = {text.text for axis in figures["misfit"].axes for text in axis.words}
    loudest = max(cell.ratio for cell in lacking.cells())
    assert f"{loudest:.0f}" in texts


@pytest.mark.slow
def test_bars_of_errors_are_those_of_the_rows_over_the_rms_force(lacking):
    rows = pd.DataFrame(lacking.rows())
    rows = rows[(rows["channel"] == "N") & (rows["test"] == "yaw_drift")]
    fastest = rows[rows["Fn"] > 0.28]
    whole = pd.DataFrame(lacking.rows()).query("channel == 'N'")["measured"]
    expected = 100 * np.sqrt(np.mean(fastest["error"] ** 2) / np.mean(whole**2))
    axis = errors_beside_uncertainty(lacking).axes[2]
    assert axis.title.text == "N"
    names = axis.yticks.labels
    place = names.index("yaw with drift, Fn 0.290")
    bars = [mark for mark in axis.marks if isinstance(mark, BarSeries)]
    lengths = {at: x for own in bars for at, x in zip(own.place, own.length, strict=True)}
    assert lengths[place] == pytest.approx(expected, rel=1e-6)
    beyond = {own.label: len(own.place) for own in bars}
    assert beyond["E beyond $U_V$"] + beyond["E within $U_V$"] == len(names)
    assert beyond["E beyond $U_V$"] >= 3


@pytest.mark.slow
def test_residuals_are_parted_by_kind_of_test_and_speed(lacking):
    figure = residuals_over(lacking)
    kinds = list(dict.fromkeys(run.view.run.test for run in lacking.captive))
    assert len(figure.axes) == 3 * len(kinds)
    heads = [axis.title.text for axis in figure.axes[: len(kinds)]]
    assert heads == ["static drift", "pure sway", "pure yaw", "yaw with drift"]
    drift = figure.axes[0]
    assert [item.label for item in drift.points] == ["Fn 0.145", "Fn 0.217", "Fn 0.290"]
    points = drift.points[0]
    runs = [r for r in lacking.captive if r.view.run.test == "static_drift" and r.Fn < 0.15]
    lengths = 0.5 * lacking.water.rho * lacking.ship.L**2
    error = [1e3 * float(r.error("X")[0]) / (lengths * r.view.speed**2) for r in runs]
    np.testing.assert_allclose(points.y, error, rtol=1e-9)
    assert figure.axes[-len(kinds)].xlabel.text == "sway velocity v' [-]"


def test_the_measured_loop_is_that_of_its_harmonics(s175, truth):
    runs, _ = compare_captive(truth, s175.select("pure_sway"), floor=0.005)
    (run,) = worst_of_each_test(runs)
    axis = loops([run]).axes[1]
    assert axis.ylabel.text == "Y [N]"
    v, Y = axis.points[0].x, axis.points[0].y
    amplitude = run.view.run.settings.amplitude * run.view.omega
    assert np.max(v) == pytest.approx(amplitude, rel=0.02)
    assert np.mean(Y[:-1]) == pytest.approx(run.view.force["Y"][0], abs=1e-9)


@pytest.mark.slow
def test_figures_of_free_running_tests(tanker, sea):
    figures = comparison_figures(pk.compare(tanker, sea))
    assert set(figures) == {"sailed", "force_residuals", "turning_circles", "zigzag"}
    assert [axis.ylabel.text for axis in figures["force_residuals"].axes][::2] == [
        "X [N]",
        "Y [N]",
        "N [N m]",
    ]


def test_several_campaigns_are_told_each_and_together(s175, truth):
    """Two halves of a programme as two campaigns: each has its own answer, and the mean square of
    the errors of all is that of the whole programme over what each half measured."""
    wrong = without(truth, "Nvvr")
    halves = [
        s175.with_(title=title, runs=s175.runs[at::2]) for at, title in enumerate(("even", "odd"))
    ]
    found = pk.compare(wrong, halves)
    assert list(found.each) == ["even", "odd"]
    for tests, mine in zip(halves, found.each.values(), strict=True):
        pd.testing.assert_frame_equal(mine.to_pandas(), pk.compare(wrong, tests).to_pandas())
    rows = found.to_pandas()
    assert len(rows) == 3 * len(s175.runs)
    told = found.joint().set_index(["channel", "campaign"])
    for channel, own in rows.groupby("channel"):
        size = own.groupby("campaign")["measured"].transform(lambda x: np.sqrt(np.mean(x**2)))
        both = told.loc[(channel, "all")]
        assert both["runs"] == len(own)
        assert both["error"] == pytest.approx(np.sqrt(np.mean((own["error"] / size) ** 2)))
        assert both["ratio"] == pytest.approx(np.sqrt(np.mean(own["ratio"] ** 2)))
        assert both["within"] == own["within"].sum()
    assert "even: What stands out" in str(found)


def test_campaigns_of_one_title_are_numbered_and_none_is_refused(s175, truth):
    few = s175.with_(runs=s175.runs[:2])
    found = pk.compare(truth, [few, few])
    assert list(found.each) == [s175.title, f"{s175.title} (2)"]
    assert list(pk.compare(truth, {"mine": few}).joint()["campaign"].unique()) == ["mine"]
    with pytest.raises(DataError, match="no campaign"):
        pk.compare(truth, [])
