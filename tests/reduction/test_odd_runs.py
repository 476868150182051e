"""One bad run among good ones: found, named, weighed down or refused, and never silently taken."""

import numpy as np
import pytest

from pmmkit.base import ContradictionError
from pmmkit.reduction import reduce_campaign
from scripts.studies.run_scatter import CASES, first
from tests.support import spoiled
from tests.support.hidden_effects import BASE, hidden_campaign
from tests.support.hidden_effects.hull import TRUTH

ASKED = [*BASE, "Xdd", "Yd", "Nd"]
SWAY = "SW_1.5_0.22"


def spoilt(run_id, change, seed=1):
    """The small programme with one run's record changed."""
    made = hidden_campaign("small", seed=seed)

    def one(run):
        data = change(run.data)
        return run.with_(loader=lambda: data)

    return made.with_(runs=tuple(one(run) if run.id == run_id else run for run in made))


def dead(data):
    """A side-force gauge that says nothing."""
    return data.assign(Y=0 * data.Y)


def reduced(made, **options):
    return reduce_campaign(made, structure=ASKED, check=False, executor=1, **options)


@pytest.fixture(scope="module")
def with_a_dead_gauge():
    return reduced(spoilt(SWAY, dead))


def test_a_dead_gauge_is_named_with_its_run_and_channel(with_a_dead_gauge):
    (odd,) = with_a_dead_gauge.influences.odd
    assert (odd.run, odd.channel) == (SWAY, "Y")
    assert odd.chance < 1e-12
    warnings = [item for item in with_a_dead_gauge.findings if item.check == "odd_run"]
    assert [item.runs for item in warnings] == [(SWAY,)]
    judged = with_a_dead_gauge.verdict
    assert judged.use != "usable"
    assert any(SWAY in reason for reason in judged.reasons)


def test_the_other_runs_are_not_blamed_for_it(with_a_dead_gauge):
    assert {one.run for one in with_a_dead_gauge.influences.odd} == {SWAY}


@pytest.mark.slow
def test_it_is_named_too_where_all_speeds_are_fitted_at_once():
    found = reduced(spoilt(SWAY, dead), fn="pooled")
    assert [(one.run, one.channel) for one in found.influences.odd] == [(SWAY, "Y")]


@pytest.mark.slow
def test_weighed_down_it_does_no_harm():
    """Yv within 3 % of the truth, where the dead run at full weight takes 90 % of it."""
    found = reduced(spoilt(SWAY, dead), odd_runs="weigh").table
    assert found["Yv"][0] == pytest.approx(TRUTH["Yv"], rel=0.03)


@pytest.mark.slow
def test_it_can_be_refused():
    with pytest.raises(ContradictionError, match=SWAY):
        reduced(spoilt(SWAY, dead), odd_runs="refuse")


@pytest.mark.slow
def test_nothing_is_at_odds_in_a_clean_programme():
    found = reduced(hidden_campaign("small", seed=2))
    assert found.influences.odd == ()
    assert found.verdict.use == "usable"


@pytest.mark.slow
def test_the_influence_of_a_run_is_the_fit_without_it():
    """Against a second reduction of the other runs, scatter held at what all runs gave."""
    made = hidden_campaign("small", seed=3)
    found = reduced(made)
    from pmmkit.reduction.solve import solve

    run = "SD_1.5_12"
    keep = [place for place, item in enumerate(found.rows) if item.result.run.id != run]
    rest = solve(
        found.rows,
        found.sensitivities,
        found.columns,
        [(float(found.solution.Fn[0]), keep)],
        found.solution.between,
    )
    value = dict(zip(rest.joint.labels, rest.joint.value, strict=True))
    for one in found.influences.items:
        if one.run != run or one.channel != "N":
            continue
        for name, shift in zip(one.names, one.shift, strict=True):
            change = found.table[name][0] - value[0, name] if name in found.table else np.nan
            if np.isfinite(change) and abs(one.share[one.names.index(name)]) > 0.3:
                assert shift == pytest.approx(change, rel=0.3)


def test_what_only_noise_of_the_motion_makes_has_no_value():
    """A recorded sway of rounding size in straight runs is no excitation of Yv."""
    rng = np.random.default_rng(5)
    made = hidden_campaign("small", seed=4)
    straight = tuple(run for run in made if run.id.startswith(("RS", "SD_1.5_0")))
    noisy = tuple(
        run.with_(
            loader=lambda data=run.data: data.assign(
                v=("t", 1e-6 * rng.normal(size=data.sizes["t"])),
                r=("t", 1e-6 * rng.normal(size=data.sizes["t"])),
            )
        )
        for run in straight
    )
    found = reduced(made.with_(runs=noisy)).table
    for name in ("Yv", "Yr", "Nv"):
        if name in found:
            assert np.isnan(found[name][0])


@pytest.mark.slow
@pytest.mark.parametrize(("seed", "law"), [(29, "normal"), (4, "none")])
def test_a_sound_run_with_two_lucky_cycles_is_not_named(seed, law):
    """Of one run two quiet cycles are kept, whose noise comes out at 0.3 to 0.4 of what it is."""
    case = next(case for case in CASES if case.law == law)
    made, _ = first("speeds", seed, case)
    found = reduce_campaign(made, structure=tuple(spoiled.truth()), fn="pooled", check=False)
    assert found.influences.odd == ()


def test_the_first_run_of_a_day_is_no_run_at_odds():
    """One static run has nobody beside it: all it tells is told, and nothing is compared."""
    made = hidden_campaign("small", seed=1)
    alone = made.with_(runs=tuple(run for run in made if run.test == "static_drift")[:1])
    found = reduced(alone)
    assert found.influences.odd == ()
    assert not np.isfinite(found.table["Yvvv"]).any()


def steady_runs_read_more(made, share):
    """Static tests on another balance for the yaw moment."""

    def one(run):
        data = run.data.assign(N=(1.0 + share) * run.data.N)
        return run if run.dynamic else run.with_(loader=lambda: data)

    return made.with_(runs=tuple(map(one, made)))


@pytest.mark.slow
@pytest.mark.parametrize("fn", ["each", "pooled"])
def test_a_group_of_runs_that_reads_more_is_told_with_its_gain(fn):
    found = reduced(steady_runs_read_more(hidden_campaign("full", seed=9711), 0.04), fn=fn)
    (group,) = (item for item in found.findings if item.check == "odd_group")
    assert group.channels == ("N",)
    assert "static drift" in group.message
    assert group.numbers["gain"] == pytest.approx(0.04, abs=0.02)
    assert any(group.message in text for text in found.verdict.doubts)


@pytest.mark.slow
@pytest.mark.parametrize("fn", ["each", "pooled"])
@pytest.mark.parametrize("seed", [1, 2, 3])
def test_no_group_of_a_sound_campaign_is_told(fn, seed):
    found = reduced(hidden_campaign("full", seed=seed), fn=fn)
    assert not [item for item in found.findings if item.check == "odd_group"]
