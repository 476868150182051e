"""Sizes of what runs draw for themselves: likelihoods written out in full, and known draws."""

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.optimize import approx_fprime
from scipy.stats import multivariate_normal, norm

from pmmkit.inference import RunEffects
from pmmkit.reduction.between_runs import half_width


class Rows:
    """Runs of a mean and harmonics, and of a mean alone, on a line in some coefficients.

    Each draws an offset (size 3), a gain, a setting, and an error of each harmonic (size 3).
    """

    def __init__(self, rng, sizes, *, runs=(5, 5, 5, 1, 1, 1), noise=0.02, columns=2, shared=0):
        self.noise, self.runs, self.shared = noise, runs, shared
        self.design = [rng.normal(size=(m, columns)) for m in runs]
        self.floor = [0.1 * rng.normal(size=(m, shared)) for m in runs]
        self.own, self.y = [], []
        weights = rng.normal(size=shared)
        for X, F, m in zip(self.design, self.floor, runs, strict=True):
            mean = X[:, :2] @ [1.0, -2.0]
            first = np.eye(m)[0]
            own = np.column_stack([3 * first, mean, rng.normal(size=m), 3 * np.diag(1 - first)])
            drawn = own @ (RunEffects.per_column(sizes, m) * rng.normal(size=3 + m))
            self.own.append(own)
            self.y.append(mean + F @ weights + noise * rng.normal(size=m) + drawn)

    def likelihood(self):
        groups = []
        for m in dict.fromkeys(self.runs):
            at = [i for i, rows in enumerate(self.runs) if rows == m]
            columns = [
                np.column_stack([self.design[i], self.floor[i], self.y[i]]) / self.noise for i in at
            ]
            groups.append((np.stack(columns), np.stack([self.own[i] for i in at]) / self.noise))
        return RunEffects.likelihood(groups, self.design[0].shape[1], self.shared)

    def covariance(self, sizes):
        """Of all rows, element by element."""
        total, begin = np.zeros((sum(self.runs),) * 2), 0
        for own, m in zip(self.own, self.runs, strict=True):
            part = slice(begin, begin + m)
            drawn = own * RunEffects.per_column(sizes, m)
            total[part, part] = self.noise**2 * np.eye(m) + drawn @ drawn.T
            begin += m
        floor = np.concatenate(self.floor)
        return total + floor @ floor.T

    def full(self, sizes):
        """Log density of what no coefficient reaches (Harville 1974)."""
        X = np.concatenate(self.design)
        q, _ = np.linalg.qr(X, mode="complete")
        rest = q[:, X.shape[1] :].T
        cover = rest @ self.covariance(sizes) @ rest.T
        return multivariate_normal(cov=cover).logpdf(rest @ np.concatenate(self.y))


TRUE = np.array([0.01, 0.02, 0.03, 0.015])
TRIED = np.array([[1e-6, 1e-6, 1e-6, 1e-6], [0.01, 0.02, 0.03, 0.015], [0.1, 0.001, 0.2, 0.05]])


@pytest.mark.parametrize("shared", [0, 3])
@pytest.mark.parametrize("runs", [(5, 5, 5, 1, 1, 1), (5,) * 12, (1,) * 9])
def test_differences_of_the_likelihood_are_those_of_contrasts_of_the_rows(runs, shared):
    rows = Rows(np.random.default_rng(1), TRUE, runs=runs, shared=shared)
    told = rows.likelihood().log_likelihoods(np.log(TRIED))
    assert np.diff(told) == pytest.approx(np.diff([rows.full(x) for x in TRIED]), rel=1e-8)


def test_columns_that_depend_on_others_change_nothing():
    rows = Rows(np.random.default_rng(2), TRUE)
    plain = np.diff(rows.likelihood().log_likelihoods(np.log(TRIED)))
    rows.design = [np.column_stack([X, X[:, :1] - X[:, 1:2]]) for X in rows.design]
    twice = np.diff(rows.likelihood().log_likelihoods(np.log(TRIED)))
    assert twice == pytest.approx(plain, rel=1e-8)


@pytest.mark.parametrize("sizes", TRIED[1:])
def test_the_slope_is_that_of_the_likelihood(sizes):
    found = Rows(np.random.default_rng(3), TRUE, shared=2).likelihood()
    at = np.log(sizes)
    value, gradient, information = found.slope(at)
    assert value == pytest.approx(found.log_likelihoods(at[None])[0])
    assert gradient == pytest.approx(
        approx_fprime(at, lambda x: found.log_likelihoods(x[None])[0], 1e-6), abs=1e-3
    )
    assert np.all(np.linalg.eigvalsh(information) > -1e-9)


def test_estimates_are_generalised_least_squares():
    rows = Rows(np.random.default_rng(4), TRUE)
    sizes = np.array([0.02, 0.01, 0.1, 0.03])
    X, y = np.concatenate(rows.design), np.concatenate(rows.y)
    inverse = np.linalg.inv(rows.covariance(sizes))
    cover = np.linalg.inv(X.T @ inverse @ X)
    value, variance = rows.likelihood().estimates(sizes[None])
    assert value[0] == pytest.approx(cover @ X.T @ inverse @ y, rel=1e-9)
    assert variance[0] == pytest.approx(np.diagonal(cover), rel=1e-9)
    left = y - X @ value[0]
    assert rows.likelihood().misfits(sizes[None])[0] == pytest.approx(left @ inverse @ left)


@pytest.mark.parametrize("rows", [1, 2, 5])
def test_quiet_records_lose_no_digits_to_the_scatter_of_their_runs(rows):
    """Noise a hundredth of the scatter and less; fewer rows than what a run draws, too."""
    made = Rows(np.random.default_rng(5), TRUE, runs=(rows,) * 24, noise=1e-4)
    X, y = np.concatenate(made.design), np.concatenate(made.y)
    inverse = np.linalg.inv(made.covariance(TRUE))
    value, _ = made.likelihood().estimates(TRUE[None])
    assert value[0] == pytest.approx(
        np.linalg.solve(X.T @ inverse @ X, X.T @ inverse @ y), rel=1e-7
    )


def test_a_known_kind_is_noise():
    rows = Rows(np.random.default_rng(6), TRUE)
    found, last = rows.likelihood(), RunEffects.KINDS.index("harmonics")
    known = found.given(last, 0.05)
    tried = np.array([[0.01, 0.02, 0.03], [0.1, 0.001, 0.2]])
    told = known.log_likelihoods(np.log([[*x, 1.0] for x in tried]))
    asked = found.log_likelihoods(np.log([[*x, 0.05] for x in tried]))
    assert np.diff(told) == pytest.approx(np.diff(asked), rel=1e-8)
    assert [known.acts(kind) for kind in range(4)] == [True, True, True, False]


def of(rows, scale=3.0):
    return RunEffects.of({"Y": [rows.likelihood()]}, {"Y": scale})


def test_many_runs_tell_their_scatter_and_few_leave_it_to_the_prior():
    true = np.array([0.012, 0.016, 0.03, 0.006])
    many = Rows(np.random.default_rng(7), true, runs=(5,) * 300)
    assert of(many).sizes("Y") == pytest.approx(true, rel=0.25)
    mode = RunEffects.most_probable({"Y": [many.likelihood()]})["Y"]
    assert mode == pytest.approx(true, rel=0.25)
    usual = RunEffects.usual({"Y": 3.0})
    few = of(Rows(np.random.default_rng(7), true, runs=(1, 1, 1)))
    assert few.sizes("Y")[3] == pytest.approx(usual.sizes("Y")[3], rel=0.05)
    assert few.informed["Y"] == RunEffects.KINDS[:3]


@pytest.mark.parametrize("times", [0.01, 1.0, 30.0])
def test_sizes_have_no_edge(times):
    """A laboratory a hundred times quieter than the usual one, and one thirty times louder."""
    true = times * np.array([0.003, 0.004, 0.03, 0.003])
    rows = Rows(np.random.default_rng(8), true, runs=(5,) * 200, noise=0.01 * float(true[0]))
    assert of(rows).sizes("Y") == pytest.approx(true, rel=0.3)


def test_a_force_of_repeated_runs_alone_tells_what_they_draw():
    """The rms force is 40 N, each run draws an offset of 2 N: 5 % of it."""
    rng = np.random.default_rng(9)
    drawn = np.column_stack([np.eye(3)[0], np.zeros((3, 2)), np.diag([0.0, 1.0, 1.0])]) * 40.0
    conditions = [
        (
            100.0 * rng.normal(size=3) + np.array([2.0, 0.5, 0.5]) * rng.normal(size=(6, 3)),
            drawn,
            1e-6 * np.eye(3),
        )
        for _ in range(20)
    ]
    found = RunEffects.of({"Y": [RunEffects.repeatability(conditions)]}, {"Y": 40.0})
    told = found.in_units("Y")
    assert set(told) == {"offset", "harmonics"}
    assert told["offset"] == pytest.approx(2.0, rel=0.15)
    assert told["harmonics"] == pytest.approx(0.5, rel=0.15)
    single = [(rows[:1], own, noise) for rows, own, noise in conditions]
    assert RunEffects.repeatability(single) is None


def test_weights_are_the_posterior_of_one_size():
    """One kind alone is informed: its mean square against an integral over the size."""
    rows = Rows(
        np.random.default_rng(10), np.array([0.02, 0.0, 0.0, 0.0]), runs=(1,) * 12, noise=0.01
    )
    rows.own = [own * np.array([1.0, 0.0, 0.0, 0.0]) for own in rows.own]
    found, likelihood = of(rows), rows.likelihood()
    usual = RunEffects.usual({"Y": 3.0})
    logs = np.log(usual.nodes["Y"][:, 0])
    mean = usual.weights["Y"] @ logs
    spread = np.sqrt(usual.weights["Y"] @ (logs - mean) ** 2)
    mode = np.log(RunEffects.most_probable({"Y": [likelihood]})["Y"])
    top = likelihood.log_likelihoods(mode[None])[0]

    def density(x):
        at = np.array([x, *mode[1:]])
        return norm.pdf(x, mean, spread) * np.exp(likelihood.log_likelihoods(at[None])[0] - top)

    total = quad(density, -12, 1, limit=200)[0]
    square = quad(lambda x: np.exp(2 * x) * density(x), -12, 1, limit=200)[0] / total
    assert found.sizes("Y")[0] == pytest.approx(np.sqrt(square), rel=0.05)


def test_a_channel_leans_on_the_others_of_its_laboratory():
    """A channel that says nothing takes after two calm ones, and its setting is theirs."""
    rng = np.random.default_rng(11)
    calm = np.array([0.0003, 0.0004, 0.003, 0.0003])
    silent = Rows(rng, np.zeros(4), runs=(1, 1), noise=10.0)
    quiet = [Rows(rng, calm, runs=(5,) * 60, noise=0.0005) for _ in range(2)]
    found = RunEffects.of(
        {"X": [quiet[0].likelihood()], "Y": [quiet[1].likelihood()], "N": [silent.likelihood()]},
        dict.fromkeys("XYN", 3.0),
    )
    usual = RunEffects.usual({"N": 3.0}).sizes("N")
    assert found.sizes("N")[0] < 0.7 * usual[0]
    assert found.sizes("N")[2] == pytest.approx(found.sizes("X")[2], rel=0.05)


def test_of_two_modes_the_higher_is_found_wherever_the_search_begins():
    """Where offset and gain act alike, either can be the large one, but not both."""
    scatter = np.random.default_rng(3).normal(size=40)
    columns = scatter[:, None, None] / 0.001
    alike = np.zeros((40, 1, 4))
    alike[..., :2] = 1.0 / 0.001
    likelihood = {"Y": [RunEffects.likelihood([(columns, alike)], 0)]}
    large = {
        kind: RunEffects(
            nodes={"Y": np.where(np.array(RunEffects.KINDS) == kind, 1.0, 0.003)[None]},
            weights={"Y": np.ones(1)},
            scale={"Y": 1.0},
            informed={"Y": ()},
        )
        for kind in ("offset", "gain")
    }
    alone = {
        kind: RunEffects.of(likelihood, {"Y": 1.0}, [begin]).nodes["Y"][0]
        for kind, begin in large.items()
    }
    assert alone["offset"][0] == pytest.approx(1.0, rel=0.3)
    assert alone["gain"][1] == pytest.approx(1.0, rel=0.3)
    for begin in (large.values(), reversed(large.values())):
        both = RunEffects.of(likelihood, {"Y": 1.0}, list(begin)).nodes["Y"][0]
        # The prior's median is nearer to a large gain.
        assert both.tolist() == alone["gain"].tolist()


def test_half_width_of_two_normals_holds_their_mixture():
    value, variance = np.array([[0.1], [-0.2]]), np.array([[1.0], [9.0]])
    weight = np.array([0.7, 0.3])
    half = half_width(value, variance, weight, np.zeros(1), 0.95)[0]
    held = sum(
        w * (norm.cdf(half, v, s**0.5) - norm.cdf(-half, v, s**0.5))
        for w, v, s in zip(weight, value[:, 0], variance[:, 0], strict=True)
    )
    assert held == pytest.approx(0.95, abs=1e-9)
