"""The same derivatives by several methods, on forces that are written by hand."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
import reduced
from few_runs import few

from pmmkit.base import CampaignError, UnknownNameError
from pmmkit.campaigns import TypeB
from pmmkit.models.tables.compare import identical
from pmmkit.reduction import reduce_campaign
from pmmkit.reduction.methods.kalman import filtered
from pmmkit.reduction.methods.method import OverTime, channels_over_time
from pmmkit.reduction.methods.registry import METHODS
from scripts.datasets.virtual_tank import SHIP, SON_NOMOTO, captive, motion, water_forces

SIZES = {"X": 0.3, "Y": 0.8, "N": 1.6}
"""Noise of the gauges [N, N m]: about 1 % of the largest forces."""


def noise(channel, speed, n, seed):
    return np.random.default_rng(seed).normal(0.0, SIZES[channel], n)


def quiet(*_):
    """A whisper, so that the filter has something to weigh by."""
    return np.random.default_rng(0).normal(0.0, 1e-7, _[2])


def value(found, method, name):
    table = found.estimates[method].table
    return float(table[name][0]), float(table.std[0, table.index(name)])


@pytest.fixture(scope="module")
def noisy():
    """A small programme with noise, by all methods."""
    return reduce_campaign(captive(noise=noise, runs=few()), method="all", check=False)


@pytest.mark.slow
@pytest.mark.parametrize("method", [name for name in METHODS if name != "regression"])
def test_each_method_finds_the_truth_of_forces_without_noise(method):
    found = reduce_campaign(
        captive(noise=quiet, balance=True, runs=few()), method=method, check=False
    )
    assert found.method == method
    for name, right in SON_NOMOTO.items():
        assert value(found, method, name)[0] == pytest.approx(right, rel=2e-4), name


@pytest.mark.slow
def test_uneven_samples_are_as_good_as_even_ones():
    def jittered(t):
        step = t[1] - t[0]
        return t + 0.4 * step * np.random.default_rng(5).uniform(-1, 1, len(t))

    found = reduce_campaign(
        captive(noise=quiet, times=jittered, runs=few()), method="ekf", check=False
    )
    for name, right in SON_NOMOTO.items():
        assert value(found, "ekf", name)[0] == pytest.approx(right, rel=2e-4), name


@pytest.mark.slow
def test_other_methods_leave_the_regression_as_it_is_to_the_bit(noisy):
    alone = reduce_campaign(captive(noise=noise, runs=few()), check=False)
    assert list(alone.estimates) == ["regression"]
    assert identical(alone.table, noisy.table)
    assert identical(alone.table, noisy.estimates["regression"].table)


@pytest.mark.slow
def test_all_methods_agree_within_their_intervals(noisy):
    assert list(noisy.estimates) == list(METHODS)
    for method in ("harmonics", "ekf"):
        far = noisy.farthest(method)
        assert abs(far.sigma) < 3.0, far.sentence
    assert not [item for item in noisy.differences if item.method == "ekf"]


@pytest.mark.slow
def test_the_filter_is_right_about_white_noise_and_says_so(noisy):
    tests = noisy.estimates["ekf"].tests
    for channel, own in tests.channels.items():
        assert 0.9 < own.nis < 1.1, channel
        assert own.samples > 1000
    assert noisy.estimates["ekf"].notes == (
        "Innovations are as large as the filter thinks, and white.",
    )


@pytest.mark.slow
def test_the_filter_sees_what_the_terms_lack():
    """Forces with v|v| where the structure has only linear terms: innovations hang together."""
    truth = SON_NOMOTO | {"Yvvv": 0.0, "Yv|v|": -0.12}
    found = reduce_campaign(
        captive(truth, noise=noise, runs=few()), structure="linear", method="ekf", check=False
    )
    faults = found.estimates["ekf"].tests.channels["Y"].faults()
    assert "tied" in faults


def test_the_filter_is_recursive_least_squares():
    """Against updates by single samples as textbooks have them, and against plain least squares."""
    rng = np.random.default_rng(3)
    truth = np.array([2.0, -1.0, 0.5])
    design = [rng.normal(size=(size, 3)) for size in (40, 25, 60)]
    rows = [X @ truth + rng.normal(size=len(X)) for X in design]
    channel = OverTime(
        base=None,
        names=("a", "b", "c"),
        blocks=(),
        noise=(),
        private=(),
        drawn=(),
        whiteners=(),
        design=tuple(design),
        rows=tuple(rows),
    )
    known, innovations = filtered(channel, ["a", "b", "c"])
    X, y = np.concatenate(design), np.concatenate(rows)
    np.testing.assert_allclose(known.mean, np.linalg.lstsq(X, y, rcond=None)[0], rtol=1e-4)
    np.testing.assert_allclose(known.covariance, np.linalg.inv(X.T @ X), rtol=1e-3)
    size = np.sqrt(np.mean(X**2, axis=0))
    P = np.diag((100.0 * np.sqrt(np.mean(y**2)) / size) ** 2)
    state, new = np.zeros(3), []
    for x, measured in zip(X, y, strict=True):
        S = x @ P @ x + 1.0
        new.append((measured - x @ state) / math.sqrt(S))
        state = state + P @ x / S * (measured - x @ state)
        P = P - np.outer(P @ x, P @ x) / S
    found = np.concatenate(innovations)
    learnt = np.isfinite(found)
    assert 100 < learnt.sum() < 125
    np.testing.assert_allclose(found[learnt], np.array(new)[learnt], atol=1e-7)


@pytest.mark.slow
def test_scatter_between_runs_reaches_every_method_alike(noisy):
    """A drift angle that each run sets 0.3° off widens Yv of all methods as much."""
    own = TypeB(name="drift", std=math.radians(0.3), shared=False)
    loose = reduce_campaign(
        captive(noise=noise, runs=few(), uncertainty=(own,)), method="all", check=False
    )
    wider = {name: value(loose, name, "Yv")[1] / value(noisy, name, "Yv")[1] for name in METHODS}
    assert wider["regression"] > 1.5
    assert wider["ekf"] == pytest.approx(wider["regression"], rel=0.1)
    assert wider["harmonics"] > 1.5
    assert value(loose, "sindy", "Yv")[1] > 0.95 * value(loose, "regression", "Yv")[1]


@pytest.mark.slow
def test_error_columns_of_the_regression_are_those_of_the_histories(noisy):
    """A gain error of one run, as a column over its harmonics, is that of its forces over time."""
    solution = noisy.solution
    group, item = next((g, x) for g, x in solution.fits if x.channel == "Y")
    gains = tuple(0.02 * block.rows[:, None] for block in item.blocks)
    changed = replace(solution, fits=((group, replace(item, private=gains)),))
    histories = _histories(noisy)
    ((_, channel),) = channels_over_time(changed, histories, {})
    for block, column in zip(channel.blocks, channel.private, strict=True):
        smooth = np.abs(column[:, 0] - 0.02 * block.rows)
        assert smooth.max() < 0.02 * 6 * SIZES["Y"]
    free = channel.fitted(["Yv"]).fit.value
    assert np.isfinite(free).all()


def _histories(found):
    from pmmkit.reduction.reading.run import ReductionSettings, read_run

    settings = ReductionSettings(
        campaign=found.campaign,
        columns=found.columns,
        convention=found.convention,
        cycles=None,
        blockage="report",
        library=found.columns.names,
    )
    return [read_run(run, settings).history for run in found.campaign.runs]


@pytest.mark.slow
def test_sparse_regression_takes_the_terms_that_are_there():
    """Forces with v|v| and without v³, asked for by a structure that has v³ alone."""
    truth = {name: x for name, x in SON_NOMOTO.items() if name not in ("Yvvv", "Nvvv")}
    truth |= {"Yv|v|": -0.05, "Nv|v|": 0.01}
    found = reduce_campaign(captive(truth, noise=noise, runs=few()), method="sindy", check=False)
    estimate = found.estimates["sindy"]
    assert {name for name in estimate.table.names if name[0] == "Y"} == {
        name for name in truth if name[0] == "Y"
    }
    assert estimate.shares["Yv|v|"][0] > 0.9
    assert estimate.shares["Yvvv"][0] < 0.3
    assert value(found, "sindy", "Yv|v|")[0] == pytest.approx(
        -0.05, abs=3 * value(found, "sindy", "Yv|v|")[1]
    )
    said = [item for item in found.differences if item.derivative == "Yvvv"]
    assert [item.cause for item in said] == ["structure"]
    assert "without Yvvv and with Yv|v|" in said[0].why


@pytest.mark.slow
def test_a_library_of_ones_own_is_what_is_chosen_from(noisy):
    found = reduce_campaign(
        captive(noise=noise, runs=few()),
        structure="cubic",
        method="sindy",
        library="Yvvr Yvrr Nvvr Nvrr",
        check=False,
    )
    assert set(found.estimates["sindy"].shares) >= {"Yvvr", "Yvrr", "Nvvr", "Nvrr", "Yvvv"}
    assert "Yv|v|" not in found.estimates["sindy"].shares
    assert "Yv|v|" in noisy.estimates["sindy"].shares


@pytest.mark.slow
def test_families_that_disagree_are_named_as_the_cause():
    """Pure sway feels a Yv of 0.8 of that of static drift, as if it hung on the frequency."""
    plan = [(f"SD{b}", "static_drift", 1.5, {"drift": math.radians(b)}) for b in (-8, -4, 0, 4, 8)]
    plan += [(f"PS{V}", "pure_sway", 1.5, {"v": V}) for V in (0.1, 0.15, 0.2, 0.25, 0.3, 0.35)]
    slow = captive(noise=noise, runs=plan)
    fast = captive(SON_NOMOTO | {"Yv": 0.8 * SON_NOMOTO["Yv"]}, noise=noise, runs=plan)
    runs = tuple(
        other if run.test == "pure_sway" else run
        for run, other in zip(slow.runs, fast.runs, strict=True)
    )
    found = reduce_campaign(
        slow.with_(runs=runs), structure="Yv Yvvv Yvdot", method="harmonics", check=False
    )
    said = {item.derivative: item for item in found.differences}
    assert said["Yv"].cause == "excitation"
    assert "static drift" in said["Yv"].why
    assert "pure sway" in said["Yv"].why
    assert value(found, "harmonics", "Yv")[0] == pytest.approx(SON_NOMOTO["Yv"], rel=0.02)


@pytest.mark.slow
def test_integrals_over_the_third_cycle_are_those_of_the_third_cycle():
    """The second cycle is spoiled; integrals over the third do not see it."""
    clean = captive(noise=quiet, runs=few())
    runs = [_spoiled(run) if run.dynamic else run for run in clean.runs]
    found = reduce_campaign(
        clean.with_(runs=tuple(runs)),
        method="harmonics",
        fourier="trapezoid",
        cycles=None,
        check=False,
    )
    for name, right in SON_NOMOTO.items():
        assert value(found, "harmonics", name)[0] == pytest.approx(right, rel=1e-4), name
    _, single = value(found, "harmonics", "Yvdot")
    _, several = value(
        reduce_campaign(clean, method="harmonics", check=False), "harmonics", "Yvdot"
    )
    assert single >= several * (1 - 1e-6)


def _spoiled(run):
    data = run.data.copy(deep=True)
    second = slice(64, 128)
    for channel in ("X", "Y", "N"):
        data[channel].values[second] *= 1.01
    return run.with_(loader=lambda: data)


def test_a_record_without_a_third_cycle_is_refused_by_name():
    short = captive(cycles=2.0, runs=[("PS", "pure_sway", 1.5, {"v": 0.1})])
    with pytest.raises(CampaignError, match="PS"):
        reduce_campaign(short, method="harmonics", fourier="trapezoid", check=False)


def test_an_unknown_method_is_refused_with_those_there_are():
    with pytest.raises(UnknownNameError, match="regression, harmonics, sindy, ekf, all"):
        reduce_campaign(captive(), method="magic")


@pytest.mark.slow
def test_tables_of_harmonics_go_through_every_method(kept, datasets, shared_data):
    """HMRI's tests of the KVLCC2: pure sway and static drift are known to disagree."""
    found = reduced.hmri(kept, datasets, shared_data)
    row = len(found.table.Fn) - 1
    ekf, base = found.estimates["ekf"].table, found.estimates["regression"].table
    np.testing.assert_allclose(ekf.value[row], base.value[row], rtol=1e-3)
    said = {item.derivative: item for item in found.differences if item.method == "harmonics"}
    assert said["Yv"].cause == "excitation"


@pytest.mark.slow
def test_a_reduction_by_several_methods_tells_its_own_state(noisy):
    text = str(noisy.estimates["sindy"])
    assert "Part of the bags of runs in which a term was taken" in text
    assert repr(noisy.estimates["ekf"]).startswith("<Estimate by Kalman filter: ")


def test_forces_by_hand_are_those_of_the_structure():
    """The virtual tank writes its forces term by term: static drift at -8°."""
    state = motion("static_drift", 1.5, np.zeros(3), 1.0, drift=math.radians(8))
    side = water_forces(SON_NOMOTO, *state)["Y"]
    v = -math.sin(math.radians(8))
    unit = 0.5 * 999.1 * SHIP.L**2 * 1.5**2
    np.testing.assert_allclose(side, unit * (SON_NOMOTO["Yv"] * v + SON_NOMOTO["Yvvv"] * v**3))
