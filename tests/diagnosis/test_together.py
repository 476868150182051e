"""Several campaigns at once: whose an effect is, and what campaigns say together."""

from __future__ import annotations

import json
import math
from dataclasses import dataclass

import numpy as np
import pytest
from hidden_effects import hidden_campaign
from hypothesis import example, given, settings
from hypothesis import strategies as st
from small_campaign import write_campaign

import pmmkit as pk
from pmmkit import without_effect
from pmmkit.base import DataError
from pmmkit.diagnosis.evidence import PRICE
from pmmkit.diagnosis.joint.belongs import LaboratoryValues, log_shared, owner, third
from pmmkit.diagnosis.joint.captive_vote import Ballot
from pmmkit.diagnosis.joint.result import Belonging, JointEntry
from pmmkit.diagnosis.joint.scatter import FLAT, Groups, Learned, next_laboratory, scatter_of_base
from pmmkit.diagnosis.joint.together import with_shown
from pmmkit.effects import is_fault
from tests.support.zigzags import SENSORS, SHIP, sailed


def asked(model, campaigns, **settings):
    """What several campaigns say together."""
    return pk.begin(model, campaigns, **settings).diagnose()


def normal(x, mean, variance):
    return np.exp(-0.5 * (x - mean) ** 2 / variance) / np.sqrt(2 * math.pi * variance)


def measured(values, covariance):
    return LaboratoryValues(
        laboratory="", values=np.atleast_1d(values), covariance=np.atleast_2d(covariance)
    )


@pytest.mark.parametrize(
    ("values", "variances"),
    [
        ((1.0, 1.2), (0.1, 0.3)),
        ((1.0, -1.5), (0.1, 0.3)),
        ((0.2, 0.1), (4.0, 0.5)),
        ((1.0, 1.4, 0.9), (0.2, 0.1, 0.3)),
    ],
)
def test_the_odds_are_those_of_integrating_over_the_coefficient(values, variances):
    """∫ Π N(c_i; c, S_i) N(c; 0, P) dc over Π ∫ N(c_i; c, S_i) N(c; 0, P) dc."""
    P = 2.25
    c = np.linspace(-15.0, 15.0, 60001)
    each = [normal(x, c, v) for x, v in zip(values, variances, strict=True)]
    prior = normal(c, 0.0, P)
    shared = np.trapezoid(np.prod(each, axis=0) * prior, c)
    alone = [np.trapezoid(item * prior, c) for item in each]
    expected = math.log(shared) - sum(map(math.log, alone))
    found = [measured(x, v) for x, v in zip(values, variances, strict=True)]
    assert log_shared(found, np.array([[P]])) == pytest.approx(expected, abs=1e-8)


def test_the_odds_of_two_correlated_coefficients_are_those_of_integration():
    a, b = np.array([1.0, -0.4]), np.array([0.7, -0.6])
    A, B = np.array([[0.3, 0.1], [0.1, 0.2]]), np.array([[0.2, -0.1], [-0.1, 0.4]])
    P, centre = np.diag([2.25, 0.5]), np.array([0.2, 0.1])
    x = np.linspace(-9.0, 9.0, 901)
    grid = np.stack(np.meshgrid(x, x, indexing="ij"), axis=-1)

    def density(mean, covariance):
        away = grid - mean
        square = np.einsum("...i,ij,...j", away, np.linalg.inv(covariance), away)
        return np.exp(-0.5 * square) / (2 * math.pi * math.sqrt(np.linalg.det(covariance)))

    def total(y):
        return math.log(np.trapezoid(np.trapezoid(y, x), x))

    of_a, of_b, prior = density(a, A), density(b, B), density(centre, P)
    expected = total(of_a * of_b * prior) - total(of_a * prior) - total(of_b * prior)
    found = log_shared([measured(a, A), measured(b, B)], P, centre)
    assert found == pytest.approx(expected, abs=1e-6)


def test_whose_an_effect_is():
    assert owner(1.1) == "the ship's"
    assert owner(-1.1) == "the laboratory's"
    assert owner(0.9) == owner(-0.9) == "cannot tell"


def test_a_stall_by_an_angle_and_one_by_cubes_are_not_compared():
    """Captive tests and a rudder of its own measure it by other coefficients."""
    none = [
        LaboratoryValues(laboratory=name, values=np.zeros(0), covariance=np.zeros((0, 0)))
        for name in ("A", "B")
    ]
    found = Belonging(
        effect="rudder_stall", owner="cannot tell", log_odds=math.nan, coefficients=(), usual=(),
        size=1.0, measured=tuple(none), thirds=(), shown={},
    )  # fmt: skip
    assert found.sentence.endswith("A and B measure no coefficient of it that all have.")
    assert found.rows() == []


@dataclass(frozen=True)
class Voter:
    """A campaign that measures effects of one coefficient each, known to 0.01."""

    name: str
    values: dict[str, float]
    asked: frozenset[str] = frozenset()

    def sizes(self, names, _faults):
        return {
            x: LaboratoryValues(
                laboratory=self.name,
                values=np.array([self.values[x]]),
                covariance=np.array([[1e-4]]),
                coefficients=("c",),
                typical=(1.0,),
            )
            for x in names
        }


def entry(names, **ballots):
    total = sum(ballots.values()) - PRICE * len(names)
    told = {x: Ballot(log_evidence=value) for x, value in ballots.items()}
    return JointEntry(names=names, log_evidence=total, ballots=told)


@pytest.mark.parametrize(("of_b", "unshown"), [(3.5, True), (9.0, False)])
def test_what_no_campaign_shows_and_all_see_otherwise_is_refused(of_b, unshown):
    """A drag that both have at one size, and a coupling of which each has a size of its own: alone
    it pays in none, together it pays once."""
    votes = [
        Voter("A", {"drag": 1.0, "coupling": 0.8}),
        Voter("B", {"drag": 1.01, "coupling": -0.6}),
    ]
    entries = (
        entry(("coupling", "drag"), A=43.0, B=40.0 + of_b),
        entry(("drag",), A=40.0, B=40.0),
        entry(("coupling",), A=3.0, B=of_b),
    )
    assert entries[0].log_evidence > entries[1].log_evidence
    left, belongs, refused = with_shown(votes, entries)
    assert [item.effect for item in refused] == ["coupling"] * unshown
    assert left[0].names == (("drag",) if unshown else ("coupling", "drag"))
    owners = {item.effect: item for item in belongs}
    assert owners["drag"].owner == "the ship's"
    if unshown:
        assert "A +3.0, B +3.5" in refused[0].refusal
    else:
        assert owners["coupling"].owner == "the laboratory's"
        assert "B alone shows it" in owners["coupling"].sentence


def test_another_laboratory_without_scatter_finds_the_weighted_mean():
    """Closed form: precisions add, those of the prior among them."""
    found = [measured(1.0, 0.1), measured(1.4, 0.3)]
    precision = 1 / 0.1 + 1 / 0.3 + 1 / 2.25
    got = third(found, np.array([[2.25]]), np.ones(1), scale=1e-6)
    assert got.values[0] == pytest.approx((1.0 / 0.1 + 1.4 / 0.3) / precision)
    assert got.std[0] == pytest.approx(precision**-0.5)


def test_another_laboratory_by_drawing_ships_and_laboratories():
    """The mean and spread of draws of (shared, τ, third) weighted by how probable the two are."""
    rng = np.random.default_rng(3)
    n, scale = 400_000, 0.5
    tau = np.abs(rng.normal(0.0, scale, n))
    shared = rng.normal(0.0, 1.5, n)
    weight = normal(0.9, shared, 0.05 + tau**2) * normal(0.4, shared, 0.02 + tau**2)
    other = rng.normal(shared, tau)
    mean = np.average(other, weights=weight)
    std = math.sqrt(np.average((other - mean) ** 2, weights=weight))
    found = [measured(0.9, 0.05), measured(0.4, 0.02)]
    got = third(found, np.array([[2.25]]), np.ones(1), scale=scale)
    assert got.values[0] == pytest.approx(mean, abs=0.01)
    assert got.std[0] == pytest.approx(std, rel=0.02)


@pytest.fixture(scope="module")
def base():
    return without_effect(pk.load_model("s175-3dof"), "yaw_sway_coupling")


@pytest.fixture(scope="module")
def captive(base):
    """Two tanks test a ship with a coupling; in one the model is turned on the carriage."""
    hidden = {"yaw_sway_coupling": 1.0}
    one = hidden_campaign("middle", {**hidden, "fault_misalignment": 1.0}, seed=3)
    other = hidden_campaign("middle", hidden, seed=4)
    return asked(base, {"turned": one, "straight": other})


@pytest.mark.slow
def test_the_effect_is_the_ships_and_the_fault_stays_with_its_campaign(captive):
    assert captive.verdict == "missing_effect"
    assert captive.best == ("yaw_sway_coupling",)
    ballots = captive.entries[0].ballots
    assert "fault_misalignment" in ballots["turned"].faults
    assert "fault_misalignment" not in ballots["straight"].faults
    (belongs,) = captive.belongs
    assert belongs.owner == "the ship's"
    spreads = [float(item.std[0]) for item in belongs.thirds]
    assert spreads[1] < spreads[0] < spreads[2]


@pytest.mark.slow
def test_campaigns_add_and_the_price_is_paid_once(captive):
    for item in captive.entries:
        total = sum(ballot.log_evidence for ballot in item.ballots.values())
        assert item.log_evidence == pytest.approx(total - PRICE * len(item.names))
    # A campaign counts what a set adds to its own faults, and takes its own price off these alone.
    entries = captive.diagnoses["straight"].entries
    own = {item.names: item.log_evidence for item in entries}
    faults = max(x for names, x in own.items() if all(map(is_fault, names)))
    expected = own[("yaw_sway_coupling",)] + PRICE - faults
    assert captive.entries[0].ballots["straight"].log_evidence == pytest.approx(expected)


@pytest.mark.slow
def test_the_answer_prints_and_is_plain_data(captive):
    text = str(captive)
    assert "turned: missing_effect" in text
    assert "yaw_sway_coupling: the ship's" in text
    assert json.loads(json.dumps(captive.to_dict()))["group"][0]["odds"] == 1.0
    table = captive.to_pandas()
    assert list(table.columns) == ["effect", "family", "turned", "straight", "together", "named"]
    assert table.effect[table.named].tolist() == ["yaw_sway_coupling"]
    assert "Yvvr" in captive.model.parts["hull_polynomial"].values


@pytest.mark.slow
def test_an_effect_of_another_size_in_each_is_the_laboratorys(base):
    found = asked(
        base,
        {
            "large": hidden_campaign("middle", {"yaw_sway_coupling": 1.0}, seed=4),
            "small": hidden_campaign("middle", {"yaw_sway_coupling": 0.3}, seed=5),
        },
    )
    assert [item.owner for item in found.belongs] == ["the laboratory's"]


@pytest.mark.slow
def test_what_one_laboratory_reads_otherwise_in_some_runs_is_not_the_ships(base):
    """A coupling is in both; the steady runs of one read 5 % more of N."""

    def steady_reads_more(campaign):
        def one(run):
            data = run.data.assign(N=1.05 * run.data.N)
            return run if run.dynamic else run.with_(loader=lambda: data)

        return campaign.with_(runs=tuple(map(one, campaign.runs)))

    hidden = {"yaw_sway_coupling": 1.0}
    one = steady_reads_more(hidden_campaign("full", hidden, seed=6))
    other = hidden_campaign("full", hidden, seed=7)
    found = asked(base, {"scaled": one, "sound": other})
    assert "yaw_sway_coupling" in found.best
    assert list(found.disagreements) == ["scaled"]
    (told,) = found.disagreements["scaled"]
    assert (told.channel, told.rival) == ("N", False)
    assert any(str(told) in flag for flag in found.flags)
    assert found.to_dict()["disagreements"]["scaled"][0]["channel"] == "N"


@pytest.mark.slow
def test_each_campaign_says_what_fits_and_what_it_cannot_tell(base):
    """A drag of the acceleration is in no catalogue: a formula may stand for it."""
    found = asked(
        base,
        {"tank": hidden_campaign("full", {"outside_vr3": 1.0, "yaw_sway_coupling": 1.0}, seed=3)},
    )
    alone = found.diagnoses["tank"]
    assert alone.untold
    assert f"tank: {alone.untold[0]}" in " ".join(str(found).split())
    assert alone.formula is not None
    assert "What fits where no effect explains it" in str(found)


@pytest.mark.slow
def test_nothing_hidden_is_named_by_none(base):
    campaigns = {str(seed): hidden_campaign("small", {}, seed=seed) for seed in (1, 2)}
    found = asked(pk.load_model("s175-3dof"), campaigns)
    assert found.verdict == "noise"
    assert found.best == ()


@pytest.mark.slow
def test_tests_of_the_bare_hull_tell_the_base(tmp_path):
    campaign = pk.open_campaign(write_campaign(tmp_path))
    found = asked(pk.load_model("s175-3dof"), [campaign])
    assert any("its derivatives are fitted" in note for note in found.notes)


@pytest.mark.slow
def test_records_of_two_basins_vote_together():
    """An asymmetry, sailed twice with other noise: evidence adds, and one size holds for both."""
    ship = SHIP.with_values("hull_polynomial", Y0=0.0022, N0=-0.001)
    found = asked(
        SHIP,
        {"one": sailed(ship, 0), "two": sailed(ship, 5)},
        candidates=["asymmetry", "fault_rudder_zero"],
        most=1,
        sensors=SENSORS,
        spread=0.03,
    )
    assert found.best == ("asymmetry",)
    assert found.belongs[0].owner == "the ship's"
    ballots = found.entries[0].ballots
    assert min(item.log_evidence for item in ballots.values()) > 10.0
    assert found.entries[0].log_evidence > max(x.log_evidence for x in ballots.values())
    ratio = SHIP.ship.d / SHIP.ship.L
    shared = found.belongs[0].thirds[0]
    assert shared.values == pytest.approx([0.0022 * ratio, -0.001 * ratio], rel=0.15)
    to_use, half, double = found.others
    hull = to_use.model.parts["hull_polynomial"].values
    assert (hull["Y0"], hull["N0"]) == pytest.approx((0.0022, -0.001), rel=0.2)
    assert half.model.std["Yv"] < to_use.model.std["Yv"] < double.model.std["Yv"]
    assert "rudder_mmg.aH" in to_use.model.std
    drawn = pk.monte_carlo(to_use.model, "turning", n=64, rudder_deg=35.0, speed=1.179)
    low, high = drawn.interval("tactical_diameter_L")
    exact = pk.simulate(ship, "turning", rudder_deg=35.0, speed=1.179)
    assert low < exact.metrics["tactical_diameter_L"] < high


def test_no_campaign_is_refused():
    with pytest.raises(DataError, match="no campaign"):
        asked(SHIP, {})


def learned(value, variance, **kind):
    return Learned(
        laboratory="",
        information=np.diag(1.0 / np.atleast_1d(variance)),
        score=np.atleast_1d(value) / np.atleast_1d(variance),
        **kind,
    )


def groups(usual, scales, of=(0,), base=0.05, shared=FLAT, offset=0.0):
    return Groups(
        names=tuple(map(str, range(len(scales) + 1))),
        base=base,
        of=np.array(of),
        usual=np.array(usual, float),
        scales=np.array(scales, float),
        shared=np.broadcast_to(np.asarray(shared, float), len(usual)),
        offset=np.broadcast_to(np.asarray(offset, float), len(usual)),
    )


def test_the_next_laboratory_is_what_another_finds():
    """One effect, measured by two: the same as by the integral over one scatter."""
    P, scale = 2.25, 0.5
    found = next_laboratory(
        [learned(0.9, 0.05), learned(0.4, 0.02)],
        groups([1.0], [scale], of=[1], shared=math.sqrt(P)),
    )
    told = third(
        [measured(0.9, 0.05), measured(0.4, 0.02)], np.array([[P]]), np.ones(1), scale=scale
    )
    assert found.values[0] == pytest.approx(told.values[0], abs=1e-3)
    assert math.sqrt(found.covariance[0, 0]) == pytest.approx(told.std[0], rel=0.01)


VALUES = st.lists(st.tuples(st.floats(-1.0, 1.0), st.floats(-0.3, 0.3)), min_size=2, max_size=2)


@settings(max_examples=5, deadline=None)
@given(VALUES, st.floats(1e-3, 0.2), st.floats(-0.8, 0.8), st.floats(0.02, 0.25))
@example([(0.5, 0.0), (0.4, 0.005)], 1e-3, 0.0, 0.25)  # 512 sets of the prior: 12 % off
def test_the_next_laboratory_is_the_mean_over_the_density_of_scatters(values, noise, alike, scale):
    """Two effects of one coefficient each, found at once: by brute force over both scatters."""
    heads, apart = np.array(values).T
    told = np.concatenate([heads, heads + apart])
    S = noise**2 * np.array([[1.0, alike], [alike, 1.0]])
    log = np.linspace(-16.0, 2.0, 145)
    x = np.stack(np.meshgrid(log, log), axis=-1).reshape(-1, 2)
    between = (scale * np.exp(x))[:, :, None] ** 2 * np.eye(2)
    whole = np.tile(np.eye(2), (2, 2)) + np.kron(np.eye(2), S)
    whole = whole + np.concatenate(
        [np.concatenate([between, 0 * between], 2), np.concatenate([0 * between, between], 2)], 1
    )
    known = np.linalg.solve(whole, np.tile(np.eye(2), (2, 1)))
    mean = told @ known
    density = np.sum(x - 0.5 * np.exp(2.0 * x), axis=1) - 0.5 * np.linalg.slogdet(whole)[1]
    density = density - 0.5 * np.linalg.solve(whole, told[:, None])[:, :, 0] @ told
    share = np.exp(density - density.max())
    share = share / share.sum()
    square = np.eye(2) + between - known[:, :2] - known[:, 2:]
    square = np.einsum("t,tii->i", share, square) + share @ mean**2
    std = np.sqrt(square - (share @ mean) ** 2)

    found = next_laboratory(
        [
            Learned(laboratory="", information=np.linalg.inv(S), score=np.linalg.solve(S, x))
            for x in (told[:2], told[2:])
        ],
        groups([1.0, 1.0], [scale, scale], of=[1, 2], shared=1.0),
    )
    np.testing.assert_allclose(found.values, share @ mean, atol=0.003 * std.min())
    np.testing.assert_allclose(np.sqrt(np.diagonal(found.covariance)), std, rtol=0.003)
    rms = np.sqrt(share @ (scale * np.exp(x)) ** 2)
    np.testing.assert_allclose(found.scatter[1:], rms, rtol=0.003)


@pytest.mark.slow
def test_many_values_tell_by_what_laboratories_differ():
    """Two that know 100 values exactly, drawn 0.1 apart: the scatter is found, and the next one is
    √(1 + ½) of it off their mean."""
    rng = np.random.default_rng(7)
    n, tau = 100, 0.1
    one, other = rng.normal(0.0, tau, (2, n))
    exact = np.full(n, 1e-8)
    found = next_laboratory(
        [learned(one, exact), learned(other, exact)], groups(np.ones(n), [0.05], of=[1] * n)
    )
    assert found.scatter[1] == pytest.approx(tau, rel=0.15)
    np.testing.assert_allclose(found.values, 0.5 * (one + other), atol=1e-3)
    np.testing.assert_allclose(
        np.diagonal(found.covariance), 1.5 * found.scatter[1] ** 2, rtol=0.05
    )


@settings(max_examples=20, deadline=None)
@given(st.floats(1e-4, 0.2), st.floats(0.02, 0.1))
@example(0.01063, 0.0547)  # a sum over a fixed grid of τ and σ gave .00995
def test_scatter_and_offset_make_up_how_far_records_move_the_base(size, scale):
    """Of many directions σ² + 2τ² is known, whatever the priors are."""
    tau, sigma = scatter_of_base([(size, 1e3)], scale, 0.15)
    assert math.sqrt(sigma**2 + 2.0 * tau**2) == pytest.approx(size, rel=0.005)
    assert scatter_of_base([], scale, 0.15) == (scale, 0.0)
    vague, _ = scatter_of_base([(size, 1e-6)], scale, 0.15)
    assert vague == pytest.approx(scale, rel=1e-3)


SIZES = st.tuples(st.floats(0.003, 1.0), st.floats(0.3, 300.0))


@settings(max_examples=20, deadline=None)
@given(st.lists(SIZES, min_size=1, max_size=3), st.floats(0.01, 0.1), st.floats(0.05, 0.3))
@example([(1.0, 119.0)], 0.03125, 0.0625)  # far beyond both priors
def test_scatter_and_offset_are_means_over_their_density(moved, scale, offset):
    """By brute force: a sum over ln τ and ln σ, fine and wide."""
    grid = np.exp(np.linspace(-14.0, 4.0, 1501))
    tau, sigma = scale * grid[:, None], offset * grid
    apart = sigma**2 + 2.0 * tau**2
    log = np.log(tau * sigma) - 0.5 * ((tau / scale) ** 2 + (sigma / offset) ** 2)
    for size, directions in moved:
        log = log - 0.5 * directions * (np.log(apart) + size**2 / apart)
    share = np.exp(log - log.max())
    means = [np.sqrt(np.sum(share * x**2) / share.sum()) for x in (tau, sigma)]
    assert scatter_of_base(moved, scale, offset) == pytest.approx(means, rel=1e-3)


def test_what_only_laboratories_have_scatters_about_nothing():
    found = next_laboratory(
        [learned([0.0, 0.8], [1e-4, 1e-4]), learned([0.0, 0.2], [1e-4, 1e-4])],
        groups([1.0, 1.0], [0.5], of=[0, 1], shared=[FLAT, 0.0]),
    )
    assert found.values[1] == 0.0
    assert found.covariance[1, 1] == pytest.approx(found.scatter[1] ** 2, rel=1e-6)
    assert 0.3 < found.scatter[1] < 0.8


def test_a_base_that_does_not_move_is_that_of_the_tests():
    """Closed forms: one value known by both, or by each its own."""
    tests, records, tau = learned(0.0, 1e-4), (0.3, 1e-2), 0.1
    own = groups([1.0], [], base=tau)
    tied = next_laboratory([tests, learned(*records, moves=False)], own)
    precision = 1.0 / 1e-4 + 1.0 / 1e-2
    assert tied.values[0] == pytest.approx(0.3 / 1e-2 / precision, abs=1e-3)
    assert tied.covariance[0, 0] == pytest.approx(1.0 / precision + 2.0 * tau**2, rel=1e-3)
    free = next_laboratory([tests, learned(*records)], own)
    weights = np.array([1.0 / (1e-4 + tau**2), 1.0 / (1e-2 + tau**2)])
    assert free.values[0] == pytest.approx(0.3 * weights[1] / weights.sum(), abs=1e-3)
    assert free.covariance[0, 0] == pytest.approx(1.0 / weights.sum() + tau**2, rel=1e-3)


def test_a_ship_that_sails_free_is_near_one_that_did():
    """Closed form: a captive value is off by the offset beside both scatters."""
    tau, sigma = 0.1, 0.5
    own = groups([1.0], [], base=tau, offset=sigma)
    found = next_laboratory([learned(0.0, 1e-4, offset=True), learned(0.3, 1e-2)], own)
    weights = np.array([1.0 / (1e-4 + tau**2 + sigma**2), 1.0 / (1e-2 + tau**2)])
    assert found.values[0] == pytest.approx(0.3 * weights[1] / weights.sum(), abs=1e-3)
    assert found.covariance[0, 0] == pytest.approx(1.0 / weights.sum() + tau**2, rel=1e-3)


@pytest.mark.slow
def test_captive_tests_say_how_the_base_moves_with_an_effect(base):
    """A regression with an effect is that without it, less what both share, times its size."""
    campaign = hidden_campaign("middle", {"yaw_sway_coupling": 1.0}, seed=4)
    session = pk.begin(base, {"tank": campaign})
    (vote,) = session.evidence.votes(())
    found = vote.beside(("yaw_sway_coupling",), ())
    held = vote.model_with((), ()).parts["hull_polynomial"].values
    moved = vote.model_with(("yaw_sway_coupling",), ()).parts["hull_polynomial"].values
    change = dict(zip(found.base, found.along @ found.values, strict=True))
    for name in ("Yv", "Yr", "Nv", "Nr", "Nrrr"):
        assert moved[name] - held[name] == pytest.approx(change[name], abs=0.02 * abs(held[name]))
