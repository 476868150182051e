"""Posterior sampling: closed forms, quadrature, files, and what is said where it fails."""

from __future__ import annotations

import hashlib
import math
import sys
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace

import h5py
import numpy as np
import pytest
from scipy.integrate import quad
from scipy.stats import chi2, expon, multivariate_normal, norm
from test_filters import SENSORS, SPEED, TANKER, off, sailed

import pmmkit as pk
from pmmkit import identify
from pmmkit.base import DataError, ModelError
from pmmkit.identification import Posterior, Prior
from pmmkit.identification.filters import kalman
from pmmkit.identification.methods import METHODS, SECONDS
from pmmkit.identification.posterior.density import DEGREES, ROUGHNESS, density_of, likelihood_of
from pmmkit.identification.posterior.ensembles import drawn_from
from pmmkit.identification.posterior.posterior import sample_posterior
from pmmkit.identification.posterior.tree import draws_of, read_posterior, write_posterior

pytest.importorskip("emcee", reason="emcee is not installed")

RECORD = sailed(dt=1.0).at(slice(0, 24)).only(("x", "y", "psi", "r"))
ONE = off(Prior.of(TANKER, ("Nr",), SPEED, spread=0.3), 1)
MIDDLE = np.array([1.0, -2.0, 3.0])
SPREAD = np.array([[2.0, 0.5, 0.2], [0.5, 1.0, -0.3], [0.2, -0.3, 0.5]])


def normal(x):
    """ln of a normal density, and a number beside it."""
    away = x - MIDDLE
    return -0.5 * float(away @ np.linalg.solve(SPREAD, away)), float(x[0])


def starts(shift=0.0):
    noise = np.random.default_rng(5).normal(size=(4, 18, 3))
    return MIDDLE + 3.0 * noise + shift * np.arange(4)[:, None, None]


@pytest.fixture(scope="module")
def drawn():
    return drawn_from(normal, starts(), ("a", "b", "c"), seed=1, steps=2000)


def test_a_normal_density_is_drawn_with_its_mean_and_covariance(drawn):
    assert drawn.convergence.reached
    assert drawn.convergence.least >= 400
    flat = drawn.draws.reshape(-1, 3)
    size = drawn.convergence.least
    std = np.sqrt(np.diagonal(SPREAD))
    assert np.all(np.abs(flat.mean(axis=0) - MIDDLE) < 4.0 * std / math.sqrt(size))
    error = np.sqrt((np.outer(std, std) ** 2 + SPREAD**2) / size)
    assert np.all(np.abs(np.cov(flat, rowvar=False) - SPREAD) < 4.0 * error)
    np.testing.assert_array_equal(drawn.more[..., 0], drawn.draws[..., 0])
    assert np.all((drawn.accepted > 0.2) & (drawn.accepted < 0.8))


@pytest.mark.slow
def test_the_same_seed_draws_the_same_wherever_that_is(drawn):
    with ThreadPoolExecutor(2) as pool:
        again = drawn_from(normal, starts(), ("a", "b", "c"), seed=1, steps=2000, executor=pool)
    np.testing.assert_array_equal(again.draws, drawn.draws)
    other = drawn_from(normal, starts(), ("a", "b", "c"), seed=2, steps=60)
    assert np.all(other.draws[:, -1] != drawn.draws[:, 39])


def test_ensembles_in_different_places_are_not_taken_for_one():
    """Two hills with a valley that no walker crosses, two ensembles on each."""

    def hills(x):
        return -0.5 * min(float(x @ x), float((x - 50.0) @ (x - 50.0))), 0.0

    noise = np.random.default_rng(0).normal(size=(4, 12, 1))
    places = noise + np.array([0.0, 0.0, 50.0, 50.0])[:, None, None]
    found = drawn_from(hills, places, ("a",), seed=0, steps=100)
    assert found.steps == 100
    assert not found.convergence.reached
    assert found.convergence.r_hat[0] > 1.5


def prior_of_factor(factor):
    """Scaled inverse χ² about 1."""
    return chi2(DEGREES).pdf(DEGREES / factor) * DEGREES / factor**2


def test_one_factor_of_all_variances_is_averaged_over():
    """Innovations given the factor, times its scaled inverse χ² about 1, by quadrature."""
    residuals, spreads = np.array([0.3, -1.1, 2.0]), np.array([0.5, 1.0, 2.0])

    def product(factor):
        given = norm(scale=np.sqrt(factor * spreads)).pdf(residuals)
        return prior_of_factor(factor) * np.prod(given)

    squares = float(np.sum(residuals**2 / spreads))
    told = likelihood_of(squares, float(np.sum(np.log(spreads))), 3, DEGREES + 3)
    assert told == pytest.approx(math.log(quad(product, 0.0, np.inf)[0]), abs=1e-8)


@pytest.fixture(scope="module")
def density():
    about = kalman(TANKER, [RECORD], ONE, sensors=SENSORS, roughness=0.0)
    return density_of(TANKER, [RECORD], ONE, about, sensors=SENSORS, roughness=0.0)


def test_the_likelihood_is_that_of_the_whole_record_at_once(density):
    """All instants together, starts and factor integrated out: normal about the simulated record,
    of covariance J P Jᵀ + f R with slopes J over the start by differences, times the prior of f.
    The factor is of the sensors alone: what is known of the start is not known better by them."""
    item = density.records[0]
    binding = density.binding
    values = ONE.mean - 0.2 * ONE.std

    def simulated(start):
        k, out = binding.constants(values), np.empty((len(item.t), 6))
        assert density.functions.complete(k) == 0
        edges = np.array([0, len(item.t)])
        density.functions.windows(item.t, item.inputs, edges, start[None], k, 0.1, out)
        return out[:, item.kinds].ravel()

    step = 1e-4
    slopes = np.stack(
        [
            (simulated(item.start + step * e) - simulated(item.start - step * e)) / (2 * step)
            for e in np.eye(6)
        ],
        axis=1,
    )
    root = np.sqrt(np.tile(item.variances, len(item.t)))
    seen = slopes / root[:, None]
    sizes, axes = np.linalg.eigh(seen * item.spread @ seen.T)
    away = axes.T @ ((item.measured.ravel() - simulated(item.start)) / root)

    def given(factor):
        spreads = 2.0 * math.pi * (factor + np.maximum(sizes, 0.0))
        return -0.5 * np.sum(np.log(spreads) + 2.0 * math.pi * away**2 / spreads)

    least, most = 0.3, 4.0
    top = max(given(x) for x in np.linspace(least, most, 50))
    whole = quad(lambda f: math.exp(given(f) - top) * prior_of_factor(f), least, most)[0]
    told = density(density.numbers(values))
    right = top + math.log(whole) - float(np.sum(np.log(root)))
    assert density.freedom == pytest.approx(DEGREES + density.measurements - 6, abs=0.3)
    assert told[1] == pytest.approx(right, abs=0.05)
    assert told[0] == pytest.approx(told[1] - 0.5 * 0.2**2, abs=1e-9)


def test_numbers_of_which_the_prior_is_a_standard_normal():
    prior = Prior.of(TANKER, ("Yv", "Nr"), SPEED, spread=0.2)
    about = kalman(TANKER, [RECORD], prior, sensors=SENSORS, roughness=0.0)
    found = density_of(TANKER, [RECORD], prior, about, sensors=SENSORS)
    assert found.names == ("Yv", "Nr", "process_noise")
    z = np.random.default_rng(0).normal(size=(2000, 3))
    own = found.parameters(z)
    np.testing.assert_allclose(found.numbers(own), z, atol=1e-6)
    tied = multivariate_normal(prior.mean, prior.covariance)
    shift = tied.logpdf(own[:, :2]) - norm.logpdf(z[:, :2]).sum(axis=1)
    assert np.ptp(shift) < 1e-6
    np.testing.assert_allclose(expon(scale=ROUGHNESS).cdf(own[:, 2]), norm.cdf(z[:, 2]), rtol=1e-9)


@pytest.fixture(scope="module")
def found():
    told = []
    made = identify(
        TANKER.with_values("hull_polynomial", Nr=float(ONE.mean[0])),
        [RECORD],
        method="posterior",
        prior=ONE,
        sensors=SENSORS,
        roughness=0.0,
        progress=lambda *state: told.append(state),
    )
    assert told
    assert "R-hat at most" in told[-1][2]
    return made


def test_mean_and_spread_are_those_of_the_density(found, density):
    """One parameter: the density itself, summed over a fine grid."""
    z0 = float(density.numbers(found.values)[0])
    width = found.std[0] / ONE.std[0]
    grid = z0 + width * np.linspace(-6.0, 6.0, 241)
    weights = np.exp([density(np.array([z]))[0] for z in grid])
    weights /= weights.sum()
    mean = float(weights @ grid)
    std = math.sqrt(float(weights @ (grid - mean) ** 2))
    size = found.detail.convergence.least
    assert abs(z0 - mean) < 4.0 * std / math.sqrt(size)
    assert width == pytest.approx(std, rel=4.0 / math.sqrt(2.0 * size))


def test_what_is_found_is_a_model_with_the_covariance_of_the_draws(found):
    assert found.detail.converged
    assert found.unseen == ()
    assert abs(found.values[0] - -0.049) < 4.0 * found.std[0]
    assert found.model.covariance_names == ("Nr",)
    np.testing.assert_array_equal(found.model.covariance, found.covariance)
    flat = found.detail.draws.values[:, 0]
    assert np.std(flat) == pytest.approx(found.std[0], rel=0.2)
    assert "posterior" in found.model.history[-1]
    assert "converged: R-hat at most" in str(found)
    assert "NOT" not in str(found)


def test_groups_and_dimensions_are_those_of_arviz(found):
    tree = found.detail.tree
    assert {"posterior", "sample_stats", "prior", "observed_data", "constant_data"} <= set(
        tree.children
    )
    assert tree["posterior"].to_dataset()["Nr"].dims == ("chain", "draw")
    assert tree["posterior"].sizes["chain"] == 4
    np.testing.assert_array_equal(tree["observed_data/x"], RECORD.measured["x"])
    np.testing.assert_array_equal(tree["constant_data/delta"], RECORD.delta)
    scale = tree["posterior/sensor_scale"].to_numpy()
    assert 0.7 < scale.mean() < 1.4
    numbers = tree["sample_stats/step"].to_numpy()
    assert numbers.min() >= found.detail.beginning
    assert numbers.max() < found.detail.steps


def test_draws_sail_any_manoeuvre(found):
    ships = {"speed": SPEED, "rudder_deg": 20.0, "n": 40}
    many = pk.monte_carlo(found.model, "turning", spread=found.detail.draws, **ships)
    alike = pk.monte_carlo(found.model, "turning", seed=0, **ships)
    assert many.failed == 0
    assert "draws of a posterior" in many.origin
    own, other = (float(np.std(item.metrics["advance_L"])) for item in (many, alike))
    assert 0.4 < own / other < 2.5
    stranger = pk.load_model("s175-3dof")
    lost = draws_of(found.detail.tree)
    with pytest.raises(ModelError, match=r"has no wake\.Nr"):
        pk.monte_carlo(
            stranger, spread=type(lost)(names=("wake.Nr",), values=lost.values, origin=""), **ships
        )


@pytest.mark.slow
def test_the_file_holds_the_same_and_is_the_same(found, tmp_path):
    tree = found.detail.tree
    for name in ("a.nc", "b.nc"):
        write_posterior(tree, tmp_path / name)
    assert (tmp_path / "a.nc").read_bytes() == (tmp_path / "b.nc").read_bytes()
    again = read_posterior(tmp_path / "a.nc")
    assert again.identical(tree)
    np.testing.assert_array_equal(draws_of(again).values, found.detail.draws.values)


def sealed(path):
    """A file of somebody else's with a right checksum."""
    whole = path.read_bytes()
    path.write_bytes(whole + b"\npmmkit sha256 " + hashlib.sha256(whole).hexdigest().encode())
    return path


def test_damaged_foreign_and_swollen_files_are_refused(found, tmp_path):
    write_posterior(found.detail.tree, tmp_path / "whole.nc")
    whole = (tmp_path / "whole.nc").read_bytes()
    for place in (100, len(whole) // 2, len(whole) - 3):
        (tmp_path / "bad.nc").write_bytes(
            whole[:place] + bytes([whole[place] ^ 1]) + whole[place + 1 :]
        )
        with pytest.raises(DataError, match="is damaged"):
            read_posterior(tmp_path / "bad.nc")
    (tmp_path / "cut.nc").write_bytes(whole[: len(whole) // 2])
    with pytest.raises(DataError, match="it has no checksum"):
        read_posterior(tmp_path / "cut.nc")
    with pytest.raises(DataError, match="cannot be read"):
        read_posterior(tmp_path / "none.nc")
    with h5py.File(tmp_path / "large.nc", "w") as file:
        file.create_dataset("posterior/Yv", shape=(4, 10**9), dtype=float, chunks=(1, 1000))
    with pytest.raises(DataError, match="far more than it holds"):
        read_posterior(sealed(tmp_path / "large.nc"))
    with h5py.File(tmp_path / "linked.nc", "w") as file:
        file["posterior"] = h5py.ExternalLink(str(tmp_path / "whole.nc"), "/posterior")
    with pytest.raises(DataError, match="posterior lies elsewhere"):
        read_posterior(sealed(tmp_path / "linked.nc"))
    with h5py.File(tmp_path / "nested.nc", "w") as file:
        group = file.create_group("posterior")
        for _ in range(30):  # each twice in the one before: a thousand million ways to the last
            inner = group.create_group("a")
            group["b"] = inner
            group = inner
    with pytest.raises(DataError, match="has another name too"):
        read_posterior(sealed(tmp_path / "nested.nc"))
    with h5py.File(tmp_path / "other.nc", "w") as file:
        file["x"] = [1.0]
    with pytest.raises(DataError, match="has no group posterior"):
        read_posterior(sealed(tmp_path / "other.nc"))


def test_it_says_plainly_where_the_ensembles_do_not_agree(found):
    told = found.detail.convergence
    detail = replace(found.detail, convergence=replace(told, r_hat=np.array([1.2])))
    assert isinstance(detail, Posterior)
    shown = str(replace(found, detail=detail))
    assert "by posterior, NOT converged" in shown
    assert "R-hat at most 1.200 (Nr)" in shown
    assert "are not to be used" in shown


def test_without_emcee_it_says_what_to_install(monkeypatch):
    monkeypatch.setitem(sys.modules, "emcee", None)
    with pytest.raises(DataError, match=r"pip install 'pmmkit\[posterior\]'"):
        sample_posterior(TANKER, [RECORD], ONE, sensors=SENSORS)


def test_fewer_than_four_ensembles_show_nothing():
    with pytest.raises(DataError, match="from 4 or more"):
        sample_posterior(TANKER, [RECORD], ONE, sensors=SENSORS, ensembles=3)


def test_what_takes_minutes_is_not_compared_unless_asked():
    assert set(METHODS) - set(SECONDS) == {"posterior"}
