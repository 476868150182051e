"""What the page shows is what the commands say, and no more samples than a screen has."""

from __future__ import annotations

import json
import math
from dataclasses import replace

import numpy as np
import pytest
from hidden_effects import hidden_campaign
from hypothesis import given
from hypothesis import strategies as st

from pmmkit import begin, compare, open_campaign, own_effect
from pmmkit.models import load_model
from pmmkit.simulation import simulate
from pmmkit.validation.statistics import STATISTICS
from pmmkit.views import page_of, trials_page
from pmmkit.views.pages.numbers import BUCKETS, short, thinned
from pmmkit.views.pages.records import history_page
from tests.support.uncoupled import uncoupled


@pytest.fixture(scope="module")
def esso_osaka(datasets, shared_data):
    return open_campaign(datasets / "esso_osaka", data=shared_data)


@pytest.fixture(scope="module")
def sailed(esso_osaka):
    return compare(load_model("esso-osaka-3m"), esso_osaka)


@pytest.fixture(scope="module")
def bare():
    return uncoupled()


@pytest.fixture(scope="module")
def campaign():
    return hidden_campaign("middle", {"yaw_sway_coupling": 1.0, "fault_misalignment": 1.0}, seed=3)


@pytest.fixture(scope="module")
def comparison(bare, campaign):
    return compare(bare, campaign)


@pytest.fixture(scope="module")
def session(bare, campaign):
    return begin(bare, campaign)


@pytest.fixture(scope="module")
def missing(session):
    return page_of(session.diagnose(), session)


def summed(labels, values, theta):
    """A force at phases from its harmonics, as the page sums it."""
    parts = [
        x * (np.cos if label[0] == "C" else np.sin)(int(label[1:]) * theta)
        for label, x in zip(labels, values, strict=True)
    ]
    return np.sum(parts, axis=0)


@pytest.mark.slow
@pytest.mark.parametrize("kind", ["comparison", "sailed"])
def test_the_map_holds_every_row_of_the_comparison(kind, request):
    comparison = request.getfixturevalue(kind)
    page = page_of(comparison)
    shown = {
        (row["run"], channel): cell
        for group in page["groups"]
        for row in group["rows"]
        for channel, cell in row["cells"].items()
    }
    rows = comparison.rows()
    assert len(shown) == len(rows) == page["cells"]
    for row in rows:
        cell = shown[row["run"], row["channel"]]
        for name in (*(item.name for item in STATISTICS), "ratio"):
            assert cell[name] == pytest.approx(row[name], rel=1e-3), name
        assert cell["within"] == row["within"]
    assert page["within"] == sum(row["within"] for row in rows)
    assert f"in {page['within']} of {page['cells']} channels" in str(comparison)
    assert page["sentences"][0]["text"] == comparison.standouts()[0]
    json.dumps(page, allow_nan=False)


@pytest.mark.slow
@pytest.mark.parametrize("kind", ["comparison", "sailed"])
def test_console_file_and_page_tell_the_same_statistics(kind, request):
    comparison = request.getfixturevalue(kind)
    page = page_of(comparison)
    head = next(line for line in str(comparison).splitlines() if "channel, test" in line)
    for item in STATISTICS:
        assert item.title in head
        assert item.name in comparison.to_pandas()
        assert {"name": item.name, "title": item.title} in page["statistics"]


@pytest.mark.slow
def test_a_sentence_leads_to_the_runs_that_stand_out(comparison):
    """Of each sentence a run and channel of the map that errs by more than it may."""
    page = page_of(comparison)
    shown = {row["run"]: row["cells"] for group in page["groups"] for row in group["rows"]}
    tests = {item.view.run.id: item.view.run.test for item in comparison.captive}
    assert page["sentences"]
    for sentence, item in zip(page["sentences"], comparison.statements(), strict=False):
        cells = [shown[run][sentence["channel"]] for run in sentence["runs"]]
        assert max(cell["ratio"] for cell in cells) > 1.0
        told = {x.test for x in comparison.outstanding() if x.channel == item.channel}
        assert {tests[run] for run in item.runs} <= told


@pytest.mark.slow
def test_a_sentence_on_a_measure_leads_to_the_records_that_it_joins(sailed):
    page = page_of(sailed)
    shown = {row["run"] for group in page["groups"] for row in group["rows"]}
    assert page["sentences"]
    for sentence in page["sentences"]:
        assert sentence["runs"]
        assert set(sentence["runs"]) <= shown


@pytest.mark.slow
def test_harmonics_over_the_phase_are_the_forces_over_time(comparison):
    """The page draws the model from harmonics: at the samples these give its history again."""
    item = next(x for x in comparison.captive if x.view.omega)
    page = history_page(comparison, item.view.run.id)
    for channel, own in page["channels"].items():
        drawn = summed(page["labels"], own["predicted"], np.array(page["theta"]))
        history = np.array(page["predicted"][channel])
        assert np.sqrt(np.mean((drawn - history) ** 2)) < 0.1 * np.ptp(history)
    assert len(page["t"]) == len(page["theta"]) == len(page["measured"]["Y"])
    assert np.all(np.diff(page["t"]) > 0)
    json.dumps(page, allow_nan=False)


@pytest.mark.slow
def test_a_steady_run_stands_among_its_family(comparison):
    item = next(x for x in comparison.captive if not x.view.omega and x.view.run.settings.drift)
    page = history_page(comparison, item.view.run.id)
    family = page["family"]
    assert (page["steady"], family["over"]) == (True, "drift")
    place = family["runs"].index(item.view.run.id)
    assert family["at"][place] == pytest.approx(
        math.degrees(item.view.run.settings.drift), abs=1e-3
    )
    assert family["at"] == sorted(family["at"])


@pytest.mark.slow
def test_what_hides_is_named_with_its_share_of_the_misfit(missing, session):
    named = [item for item in missing["candidates"] if item["named"]]
    assert {item["effect"] for item in named} == {"yaw_sway_coupling", "fault_misalignment"}
    assert {item["kind"] for item in named} == {"physics", "fault"}
    assert max(item["share"]["all"] for item in named) > 0.3
    before, after = (
        state.fall().totals[-1] for state in (session, session.add("yaw_sway_coupling"))
    )
    own = next(item for item in named if item["effect"] == "yaw_sway_coupling")
    assert own["share"]["all"] == pytest.approx(1 - (after / before) ** 2, abs=0.02)


@pytest.mark.slow
def test_a_formula_stands_there_to_be_taken_as_effects_of_ones_own(bare):
    session = begin(bare, hidden_campaign("full", {"outside_vr3": 1.0}, seed=7000))
    found = session.diagnose()
    told = page_of(found, session)["formula"]
    assert told["remarks"] == found.formula.remarks()
    beside = replace(found.formula, beside=("yaw_sway_coupling", "my_own_effect"))
    page = page_of(replace(found, formula=beside), session)
    words = "It stands beside Yaw–sway coupling and my_own_effect."
    assert words in page["formula"]["remarks"]
    assert words in page["remarks"]
    made = [own_effect(**item) for item in told["effects"]]
    assert [tuple(item.typical) for item in made] == [("Xvrrr",), ("Yvrr|r|",)]


@pytest.mark.slow
def test_an_overlay_is_what_adding_the_effect_does(missing, session, bare, campaign):
    """Drawn over a run before anything is added: the model that comes of it predicts the same.

    Runs with a rudder angle are left out: the ship keeps its own rudder, which is not fitted.
    """
    before, after = (
        {item.view.run.id: item for item in compare(model, campaign).captive}
        for model in (session.model(), session.add("yaw_sway_coupling").model())
    )
    drawn = missing["overlays"]["yaw_sway_coupling"]
    moved = []
    for run, channels in drawn.items():
        if after[run].view.run.settings.rudder:
            continue
        change = after[run].predicted["Y"] - before[run].predicted["Y"]
        moved.append((np.array(channels["Y"]), change))
    told, found = (np.concatenate(x) for x in zip(*moved, strict=True))
    assert np.linalg.norm(told - found) < 1e-3 * np.linalg.norm(found)


@pytest.mark.slow
def test_the_waterfall_tells_the_errors_of_the_session(session):
    page = page_of(session.add("yaw_sway_coupling").fall())
    assert [step["step"] for step in page["steps"]] == ["base", "yaw_sway_coupling"]
    assert page["steps"][1]["error"] < page["steps"][0]["error"]
    assert page["steps"][1]["level"] > 0.0


@pytest.mark.slow
def test_a_turn_is_that_of_the_simulator_in_ship_lengths():
    model = load_model("kvlcc2")
    page = page_of(model, "turning", speed=7.97, rudder_deg=35.0)
    track = simulate(model, "turning", speed=7.97, rudder_deg=35.0, compiled=False)
    found = {item["name"]: item["value"] for item in page["metrics"]}
    assert found["advance_L"] == pytest.approx(track.metrics["advance_L"], rel=1e-4)
    assert max(page["y"]) == pytest.approx(float(track.y.max()) / track.L, rel=1e-2)
    assert {item["criterion"] for item in page["verdicts"]} == {"advance", "tactical_diameter"}
    rudder = next(item for item in page["forces"] if item["effect"] == "rudder_mmg")
    assert len(rudder["Y"]) == len(page["t"])
    assert rudder["Y"][-1] < 0.0 < rudder["N"][-1]


@pytest.mark.slow
@pytest.mark.parametrize(("share", "passed"), [(1.0, True), (0.2, None)])
def test_a_limit_inside_the_band_is_neither_met_nor_failed(share, passed):
    """KVLCC2's advance is 3.0 L, with a fifth of her rudder far more: if either may be true?"""
    model = load_model("kvlcc2")
    area = share * model.parts["rudder_mmg"].values["area"]
    other = model.with_values("rudder_mmg", area=area)
    rivals = [(model, 1.0, ()), (other, 1.0, ("small rudder",))]
    page = page_of(model, "turning", speed=7.97, band=True, rivals=rivals)
    (advance,) = (item for item in page["verdicts"] if item["criterion"] == "advance")
    low, high = page["band"]["measures"]["advance_L"]
    assert (low <= 4.5 < high) is (passed is None)
    assert advance["passed"] is passed


@pytest.mark.slow
def test_measured_tracks_are_those_of_the_trials_at_the_scale_of_the_ship(sailed, esso_osaka):
    """Froude's law: four times the length, twice the time; paths in lengths stay."""
    length = esso_osaka.ship.L
    page = trials_page(sailed.manoeuvres, 4.0 * length)
    assert {name: len(found) for name, found in page.items()} == {"turning": 4, "zigzag": 6}
    for item in sailed.manoeuvres:
        trial = item.trial
        drawn = next(x for x in page[trial.manoeuvre] if x["run"] == trial.run)
        assert drawn["t"][0] >= 0.0
        assert drawn["t"][-1] == pytest.approx(2.0 * trial.t[-1], rel=1e-3)
        assert drawn["x"][-1] == pytest.approx(trial.x[-1] / length, rel=1e-3, abs=1e-3)
        assert drawn["rudder"] == pytest.approx(trial.rudder_deg, rel=1e-3)
    json.dumps(page, allow_nan=False)


@given(
    length=st.integers(0, 5000),
    places=st.lists(st.integers(0, 4999), min_size=1, max_size=5, unique=True),
)
def test_no_spike_is_lost_where_a_record_is_thinned(length, places):
    values = np.zeros(length)
    spikes = [place for place in places if place < length]
    values[spikes] = np.arange(1, len(spikes) + 1)
    kept = thinned({"X": values}, 50)
    assert len(kept) <= max(2 * 50 + 4, min(length, 100))
    if spikes:
        assert spikes[-1] in kept
        assert kept[0] == 0
        assert kept[-1] == length - 1


@given(length=st.integers(1, 5000))
def test_no_stretch_of_a_record_is_drawn_more_coarsely_than_the_others(length):
    """Of 1000 samples in 400 pieces the last 200 were once a single one."""
    kept = thinned({"X": np.sin(np.arange(length) / 7.0)}, 50)
    assert np.diff(kept).max(initial=1) <= 2 * -(-length // 50)


def test_three_gigabytes_of_samples_would_be_as_few_on_the_screen():
    values = np.sin(np.arange(2_000_000) / 5000.0)
    kept = thinned({"X": values, "Y": -values})
    assert len(kept) <= 4 * BUCKETS + 6
    assert values[kept].max() == values.max()


@given(st.floats(-1e300, 1e300) | st.sampled_from([math.nan, math.inf, -math.inf]))
def test_short_numbers_stay_what_they_are(value):
    told = short(value)
    if math.isfinite(value):
        assert told == pytest.approx(value, rel=1e-4, abs=1e-320)
    else:
        assert told is None
