"""Intervals that hold what they promise, and a covariance that Monte Carlo confirms.

How often they hold it over many programmes is what scripts.studies.interval_coverage counts.
"""

from __future__ import annotations

import math

import numpy as np
import pytest
import xarray as xr
from few_runs import few
from monte_carlo import monte_carlo

from pmmkit import Campaign, Run
from pmmkit.campaigns import Settings, TypeB
from pmmkit.reduction import reduce_campaign
from pmmkit.reduction.observations.noise import degrees, shrunk_levels
from scripts.datasets.virtual_tank import SHIP, SON_NOMOTO, WATER, captive

SIZE = {"X": 0.4, "Y": 1.2, "N": 2.5}


def autocorrelated(channel, speed, n, seed, rho=0.8):
    """AR(1) noise in newtons, the same at every speed."""
    from scipy.signal import lfilter

    rng = np.random.default_rng([seed, ord(channel)])
    white = rng.normal(size=n) * SIZE[channel] * math.sqrt(1 - rho**2)
    white[0] = rng.normal() * SIZE[channel]
    return lfilter([1.0], [1.0, -rho], white)


@pytest.mark.slow
def test_errors_are_of_the_size_of_their_standard_deviations():
    found = reduce_campaign(captive(noise=autocorrelated, cycles=6.0), check=False)
    table = found.table
    error = (table.value[0] - [SON_NOMOTO[name] for name in table.names]) / table.std[0]
    assert np.abs(error).max() < 4.5
    assert 0.5 < np.sqrt(np.mean(error**2)) < 1.6


SOURCES = {
    "gauges, alignment, mass": (
        TypeB(name="Y_gauge", std=30.0, shared=True),
        TypeB(name="N_gauge", std=0.01, relative=True, shared=True),
        TypeB(name="drift", std=math.radians(0.1), shared=True),
        TypeB(name="Izz", std=20.0, shared=True),
        TypeB(name="xG", std=0.02, shared=True),
    ),
    "settings of each run, a lever": (
        TypeB(name="drift", std=math.radians(0.15)),
        TypeB(name="speed", std=0.01),
        TypeB(name="moment_reference_x", std=0.01, shared=True),
    ),
    "motion and water": (
        TypeB(name="period", std=0.02, relative=True),
        TypeB(name="yaw_amplitude", std=0.02, relative=True, shared=True),
        TypeB(name="rho", std=10.0, shared=True),
    ),
}


@pytest.mark.slow
@pytest.mark.parametrize("sources", SOURCES.values(), ids=SOURCES)
def test_covariance_agrees_with_monte_carlo(sources):
    """Each source makes two fifths and more of the variance of some derivative, so that none of
    them can be wrong behind the others."""
    made = captive(noise=autocorrelated, balance=True, runs=few())

    def reduced(*own):
        return reduce_campaign(made.with_(uncertainty=own), check=False)

    found = reduced(*sources)
    std = found.table.std[0]
    for source in sources:
        rest = reduced(*(other for other in sources if other is not source)).table.std[0]
        assert np.max(1 - (rest / std) ** 2) > 0.4, source
    ratio = monte_carlo(found, n=130, seed=3)[:, 0].std(axis=0, ddof=1) / std
    assert ratio.min() > 0.8
    assert ratio.max() < 1.25


@pytest.mark.slow
def test_shared_bias_does_not_average_out_but_scatter_does():
    """Twice the runs leave a common drift error as it is and shrink a private one by √2."""
    single = captive(noise=autocorrelated)
    twice = single.with_(runs=(*single.runs, *(run.with_(id=f"{run.id}'") for run in single.runs)))

    def variance(made, *sources):
        table = reduce_campaign(made.with_(uncertainty=sources), check=False).table
        return table.std[0, table.index("Nvvr")] ** 2

    common, own = (
        TypeB(name="drift", std=math.radians(1.0), shared=shared) for shared in (True, False)
    )
    shared = [variance(made, common) - variance(made) for made in (single, twice)]
    private = [variance(made, own) for made in (single, twice)]
    assert math.sqrt(shared[1] / shared[0]) == pytest.approx(1.0, abs=0.05)
    assert math.sqrt(private[1] / private[0]) == pytest.approx(1 / math.sqrt(2), abs=0.05)


@pytest.mark.slow
def test_a_gauge_offset_that_is_not_declared_is_found_as_zero_offset():
    made = captive(noise=autocorrelated)
    runs = tuple(
        run.with_(loader=lambda data=run.data: data.assign(Y=data["Y"] + 5.0)) for run in made
    )
    found = reduce_campaign(made.with_(runs=runs), check=False)
    offset = next(item for item in found.offsets if item.channel == "Y")
    unit = 0.5 * WATER.rho * SHIP.L**2 * 1.5**2
    assert offset.clear
    assert offset.value * unit == pytest.approx(5.0, abs=0.5)
    assert offset.drift_deg == pytest.approx(math.degrees(5.0 / unit / 0.0116), rel=0.15)


@pytest.mark.slow
def test_misfit_of_a_wrong_structure_widens_the_intervals_and_is_told():
    made = captive(noise=autocorrelated)
    right = reduce_campaign(made, check=False)
    wrong = reduce_campaign(made, structure="linear", check=False)
    assert not any("misfit" in note for note in right.notes)
    assert any("misfit" in note and "N at Fn" in note for note in wrong.notes)


def test_like_noise_levels_borrow_strength_and_unlike_ones_do_not():
    alike, _, doubt = shrunk_levels(np.array([0.8, 1.3, 1.0, 0.9, 1.1]), np.full(5, 8.0))
    assert np.ptp(alike) < 0.05
    assert degrees(np.sum(doubt**2, axis=1)).min() > 20
    unlike, own, doubt = shrunk_levels(np.array([1.0, 100.0, 1e4, 1.0, 1e3]), np.full(5, 50.0))
    assert unlike == pytest.approx([1.0, 100.0, 1e4, 1.0, 1e3], rel=0.1)
    assert degrees(np.sum(doubt**2, axis=1)).max() < 60
    assert own.min() > 0.95


@pytest.mark.slow
def test_same_input_same_output_whatever_the_threads():
    made = captive(noise=autocorrelated, runs=few())
    one = reduce_campaign(made, check=False, executor=1).table
    many = reduce_campaign(made, check=False, executor=4).table
    assert np.array_equal(one.value, many.value)
    assert np.array_equal(one.covariance, many.covariance)


@pytest.mark.slow
def test_repeats_that_scatter_widen_the_intervals():
    """Each run has an error of its own, 3 N, far above its record's noise: repeats show it."""
    angles = (-12, -8, -4, 0, 4, 8, 12)
    rng = np.random.default_rng(4)
    runs, repeated = [], []
    for number in range(3):
        for beta in angles:
            name = f"SD{beta}_{number}"
            runs.append((name, "static_drift", 1.5, {"drift": math.radians(beta)}))
    made = captive(runs=runs, noise=autocorrelated)
    for run in made:
        off = 3.0 * rng.normal()
        shifted = run.data.assign(Y=run.data["Y"] + off)
        repeated.append(run.with_(loader=lambda data=shifted: data))
    structure = "Yv Yvvv Nv Nvvv"
    quiet = reduce_campaign(made, structure=structure, check=False).table
    loud = reduce_campaign(made.with_(runs=tuple(repeated)), structure=structure, check=False).table
    assert loud.std[0, 0] > 3 * quiet.std[0, 0]
    # The gauge of the moment is of the same laboratory, whose sizes are alike to a factor of two.
    assert loud.std[0, 2] == pytest.approx(quiet.std[0, 2], rel=0.15)
    assert abs(loud.value[0, 0] - SON_NOMOTO["Yv"]) < 3 * loud.std[0, 0]


@pytest.mark.slow
def test_numerical_uncertainty_of_a_solver_counts_as_a_common_zero_error():
    """CFD has no noise, and its runs agree: what is stated as U_SN makes the intervals."""
    made = captive()
    bare = reduce_campaign(made, check=False).table
    grid = reduce_campaign(made.with_(numerical={"Y": 2.0}), check=False).table
    same = made.with_(uncertainty=(TypeB(name="Y_gauge", std=2.0, shared=True),))
    assert grid.std[0, 5] > 30 * bare.std[0, 5]
    assert np.array_equal(grid.std, reduce_campaign(same, check=False).table.std)


def test_means_without_stated_noise_have_the_intervals_of_ordinary_regression():
    """A line with a zero offset through six points: the runs share one level of noise, which has
    rows minus coefficients degrees of freedom, as scipy's linear regression has it."""
    from scipy.stats import linregress, t

    rng = np.random.default_rng(6)
    beta = np.radians([-10, -6, -2, 2, 6, 10])
    side = 40.0 * np.sin(beta) + 3.0 * rng.normal(size=6)
    runs = tuple(
        Run(
            id=f"SD{number}",
            test="static_drift",
            kind="means",
            forces="hydrodynamic",
            loader=lambda Y=Y: xr.Dataset({"Y": float(Y)}),
            settings=Settings(speed=1.5, drift=float(angle)),
        )
        for number, (angle, Y) in enumerate(zip(beta, side, strict=True))
    )
    made = Campaign(title="means", ship=SHIP, water=WATER, runs=runs, forces="hydrodynamic")
    table = reduce_campaign(made, structure="Yv", check=False).table
    line = linregress(-np.sin(beta), side)
    low, high = table.interval()
    assert table.dof[0, 0] == pytest.approx(4.0, rel=1e-4)
    assert (high - low)[0, 0] / table.value[0, 0] == pytest.approx(
        2 * t.ppf(0.975, 4) * line.stderr / line.slope, rel=1e-3
    )
