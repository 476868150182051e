"""Scatter between runs against likelihoods written out in full and against known draws."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.stats import multivariate_normal, norm

from pmmkit.observations.channels import Channel
from pmmkit.observations.scatter import USUAL, WIDE, RunScatter, half_width, restricted, run_scatter


def few_runs(rng, sizes, *, runs=6, rows=5, noise=0.02, columns=2):
    """A channel of some runs whose rows follow a line in two coefficients, of so many."""
    design = rng.normal(size=(runs * rows, columns))
    mean = design[:, :2] @ [1.0, -2.0]
    own = np.zeros((runs * rows, 3))
    own[::rows, 0] = 3.0
    own[:, 1] = mean
    own[:, 2] = rng.normal(size=runs * rows)
    y = mean + noise * rng.normal(size=runs * rows)
    places = [np.arange(k * rows, (k + 1) * rows) for k in range(runs)]
    for place in places:
        y[place] += own[place] @ (sizes * rng.normal(size=3))
    channel = Channel(
        name="Y",
        views=tuple(range(runs)),
        rows=tuple(slice(p[0], p[-1] + 1) for p in places),
        runs=tuple(places),
        y=y,
        design=design,
        noise=(noise**2 * np.eye(rows),) * runs,
        scale=1.0,
    )
    return channel, own


def dense(channel, own, sizes):
    """Covariance of all rows, element by element."""
    cover = np.zeros((len(channel.y), len(channel.y)))
    for place, noise in zip(channel.runs, channel.noise, strict=True):
        drawn = own[place] * sizes
        cover[np.ix_(place, place)] = noise + drawn @ drawn.T
    return cover


def of_two_kinds(rng, sizes):
    """A channel of four runs with a mean and harmonics, and of five with a mean alone."""
    channel, own = few_runs(rng, sizes, runs=5)
    sizes_of = (5, 5, 5, 5, 1, 1, 1, 1, 1)
    ends = np.cumsum(sizes_of).tolist()
    places = tuple(np.arange(end - size, end) for end, size in zip(ends, sizes_of, strict=True))
    return (
        replace(
            channel,
            views=tuple(range(len(places))),
            rows=tuple(slice(int(p[0]), int(p[-1]) + 1) for p in places),
            runs=places,
            noise=tuple(4e-4 * np.eye(size) for size in sizes_of),
        ),
        own,
    )


def test_runs_of_a_mean_alone_stand_beside_runs_of_harmonics():
    sizes = np.array([0.02, 0.01, 0.1])
    channel, own = of_two_kinds(np.random.default_rng(3), sizes)
    tried = np.array([[0.01, 0.02, 0.03], sizes])
    q, _ = np.linalg.qr(channel.design, mode="complete")
    contrasts = q[:, 2:].T
    full = [
        multivariate_normal(cov=contrasts @ dense(channel, own, s) @ contrasts.T).logpdf(
            contrasts @ channel.y
        )
        for s in tried
    ]
    told = restricted(channel, own, channel.design).log_likelihood(tried)
    assert np.diff(told) == pytest.approx(np.diff(full), rel=1e-8)


few_or_many = pytest.mark.parametrize(("columns", "runs"), [(2, 6), (WIDE + 8, 12)])


@few_or_many
def test_differences_of_the_likelihood_are_those_of_contrasts_of_the_rows(columns, runs):
    """The restricted likelihood is the density of what no coefficient reaches (Harville 1974)."""
    sizes = np.array([0.01, 0.02, 0.03])
    channel, own = few_runs(np.random.default_rng(1), sizes, columns=columns, runs=runs)
    tried = np.array([[0.0, 0.0, 0.0], [0.01, 0.02, 0.03], [0.1, 0.001, 0.2]])
    q, _ = np.linalg.qr(channel.design, mode="complete")
    contrasts = q[:, columns:].T
    full = [
        multivariate_normal(cov=contrasts @ dense(channel, own, s) @ contrasts.T).logpdf(
            contrasts @ channel.y
        )
        for s in tried
    ]
    told = restricted(channel, own, channel.design).log_likelihood(tried)
    assert np.diff(told) == pytest.approx(np.diff(full), rel=1e-8)


@few_or_many
def test_estimates_are_generalised_least_squares(columns, runs):
    drawn = np.array([0.01, 0.02, 0.03])
    channel, own = few_runs(np.random.default_rng(2), drawn, columns=columns, runs=runs)
    sizes = np.array([0.02, 0.01, 0.1])
    inverse = np.linalg.inv(dense(channel, own, sizes))
    cover = np.linalg.inv(channel.design.T @ inverse @ channel.design)
    value, variance = restricted(channel, own, channel.design).estimates(sizes[None])
    assert value[0] == pytest.approx(cover @ channel.design.T @ inverse @ channel.y, rel=1e-9)
    assert variance[0] == pytest.approx(np.diagonal(cover), rel=1e-9)


@pytest.mark.parametrize("rows", [1, 2, 5])
def test_quiet_records_lose_no_digits_to_the_scatter_of_their_runs(rows):
    """Noise a hundredth of the scatter and less; fewer rows than what a run draws, too."""
    sizes = np.array([0.01, 0.02, 0.03])
    channel, own = few_runs(np.random.default_rng(5), sizes, runs=24, rows=rows, noise=1e-4)
    inverse = np.linalg.inv(dense(channel, own, sizes))
    cover = np.linalg.inv(channel.design.T @ inverse @ channel.design)
    value, variance = restricted(channel, own, channel.design).estimates(sizes[None])
    assert value[0] == pytest.approx(cover @ channel.design.T @ inverse @ channel.y, rel=1e-8)
    assert variance[0] == pytest.approx(np.diagonal(cover), rel=1e-7)


def test_many_runs_tell_their_scatter_and_few_leave_it_to_the_prior():
    rng = np.random.default_rng(3)
    true = np.array([0.012, 0.016, 0.03])
    channel, own = few_runs(rng, true, runs=300)
    found = run_scatter({"Y": [restricted(channel, own, channel.design)]}).sizes("Y")
    assert found == pytest.approx(true, rel=0.25)
    nothing = RunScatter.usual(["Y"])
    assert nothing.sizes("Y")[1] > USUAL["gain"]


def test_a_channel_leans_on_the_others_of_its_laboratory():
    """A channel that says nothing takes the size that two others have, not the prior's."""
    rng = np.random.default_rng(4)
    calm = [few_runs(rng, np.array([0.0003, 0.0004, 0.003]), runs=60) for _ in range(2)]
    silent, own = few_runs(rng, np.zeros(3), runs=2, rows=1)
    found = run_scatter(
        {
            "X": [restricted(calm[0][0], calm[0][1], calm[0][0].design)],
            "Y": [restricted(calm[1][0], calm[1][1], calm[1][0].design)],
            "N": [restricted(silent, own, silent.design)],
        }
    )
    assert found.sizes("N")[0] < 0.6 * RunScatter.usual(["N"]).sizes("N")[0]


def test_half_width_of_two_normals_holds_their_mixture():
    value, variance = np.array([[0.1], [-0.2]]), np.array([[1.0], [9.0]])
    weight = np.array([0.7, 0.3])
    half = half_width(value, variance, weight, np.zeros(1), 0.95)[0]
    held = sum(
        w * (norm.cdf(half, v, s**0.5) - norm.cdf(-half, v, s**0.5))
        for w, v, s in zip(weight, value[:, 0], variance[:, 0], strict=True)
    )
    assert held == pytest.approx(0.95, abs=1e-9)
