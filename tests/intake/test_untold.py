"""What runs cannot tell of their own errors, from their settings alone, and what hangs on it."""

from __future__ import annotations

import json
from dataclasses import replace
from datetime import datetime, timedelta

import numpy as np
import pytest
import small_campaign

import pmmkit as pk
from pmmkit.cli import main
from pmmkit.intake import Untold
from pmmkit.intake.checks.untold import share_of_day
from pmmkit.models import TableVerdict
from pmmkit.models.tables.table import kept_verdict
from pmmkit.reduction import reduce_campaign


@pytest.fixture(scope="module")
def small(tmp_path_factory):
    return pk.open_campaign(
        small_campaign.write_campaign(tmp_path_factory.mktemp("untold") / "tests")
    )


def names(campaign, **options):
    return {item.name: item for item in Untold.of(campaign, **options)}


def in_order(campaign, order):
    """The runs as they were made one after another, a quarter of an hour each."""
    begin = datetime(2026, 5, 4, 8)
    times = {run: begin + timedelta(minutes=15 * place) for place, run in enumerate(order)}
    return campaign.with_(
        runs=tuple(
            run.with_(started=times[place].isoformat()) for place, run in enumerate(campaign)
        )
    )


def shuffled(count, seed):
    return np.random.default_rng(seed).permutation(count).tolist()


def test_a_programme_by_speed_is_confounded_with_the_day(small):
    """All of 1 m/s in the morning, all of 2 m/s in the afternoon: a zero that drifts is an offset
    for each speed, to three quarters."""
    by_speed = in_order(small, range(len(small)))
    found = names(by_speed)["day"]
    assert (
        "Through the day the runs go by the speed (it explains 74 % of their order)" in found.text
    )
    assert "a change with the speed" in found.text
    day = np.array(by_speed.places_in_day)
    offsets = np.array([[run.settings.speed == x for x in (1.0, 2.0)] for run in by_speed], float)
    left = day - offsets @ np.linalg.lstsq(offsets, day, rcond=None)[0]
    assert np.var(left) / np.var(day) == pytest.approx(1 - 0.751, abs=0.002)


@pytest.mark.parametrize("seed", range(8))
def test_the_same_runs_in_random_order_are_not(small, seed):
    assert "day" not in names(in_order(small, shuffled(len(small), seed)))


def test_a_programme_from_port_to_starboard_is_confounded_with_the_side(small):
    drift = [run for run in small if run.test == "static_drift" and run.settings.drift]
    twice = [run.with_(id=f"{run.id} {again}") for again in "ab" for run in drift]
    twice.sort(key=lambda run: run.settings.drift)
    held = small.with_(runs=tuple(twice))
    found = names(in_order(held, range(len(twice))))["day"]
    assert "the side" in found.text
    assert "an asymmetry" in found.text


def test_an_order_that_nobody_states_is_that_of_the_file_and_says_so(small):
    found = names(small)["day"]
    assert found.text.startswith("In the order in which they stand")
    assert "state started" in found.check


def test_chance_is_taken_off():
    """Of random orders of 16 runs at three speeds fewer than one in fifty look ordered by half."""
    day = np.linspace(0.0, 1.0, 16)
    rng = np.random.default_rng(0)
    found = [share_of_day(day, rng.permutation(np.arange(16) % 3).tolist()) for _ in range(2000)]
    assert np.mean(np.array(found) > 0.5) < 0.02
    assert np.mean(found) < 0.1
    assert share_of_day(day[:8], [1] * 4 + [2] * 4) == 0.0


def test_one_speed_and_one_side(small):
    one = small.with_(runs=tuple(run for run in small if run.settings.speed == 1.0))
    assert "one speed" in names(one)
    assert "one speed" not in names(small)
    assert (
        "the zero of a gauge and an asymmetry of the hull are one" in names(one)["one speed"].text
    )
    starboard = small.with_(
        runs=tuple(x for x in small if x.test == "static_drift" and x.settings.drift > 0)
    )
    assert "side" in names(starboard)
    assert "side" not in names(small.select("static_drift"))


@pytest.mark.slow
def test_zeros_that_each_record_shows_at_rest_are_told(tmp_path, small):
    place = small_campaign.write_campaign(tmp_path / "tests", rest=4.0)
    file = place / "campaign.toml"
    shown = reduce_campaign(pk.open_campaign(place), check=False, executor=1)
    file.write_text(file.read_text().replace("[[runs]]", "[defaults]\ntare = true\n[[runs]]", 1))
    tared = reduce_campaign(pk.open_campaign(place), check=False, executor=1)
    never = reduce_campaign(small, check=False, executor=1)
    days = ["day" in {item.name for item in found.untold} for found in (never, shown, tared)]
    assert days == [True, False, False]


def test_a_solver_has_no_gauges_and_no_day(small):
    computed = small.with_(cfd={"solver": "any"}, numerical={"X": 0.1, "Y": 0.1, "N": 0.1})
    found = names(computed)
    assert found["scale"].condition == "the scale of the forces (X, Y, N)"
    assert not {"day", "inertia"} & set(found)


@pytest.mark.slow
def test_a_slip_of_the_point_moves_what_the_line_says(small):
    """N about a point 0.01 L off, made here: N grows by 0.01 L Y in every record."""
    found = reduce_campaign(small, executor=1)
    (told,) = [item for item in found.untold if item.name == "moments' point"]
    words = told.text.partition(" moves ")[2].split()
    name, share = words[0], float(words[2])
    step = 0.01 * small.ship.L

    def slipped(run):
        data = run.data
        moved = data.assign(N=data.N + step * data.Y)
        return run.with_(loader=lambda: moved)

    other = reduce_campaign(
        small.with_(runs=tuple(map(slipped, small))), check=False, executor=1
    ).table
    change = {x: np.median(other[x] / found.table[x]) - 1 for x in ("Nv", "Nr", "Nvdot", "Nrdot")}
    assert name == max(change, key=lambda x: abs(change[x])) == "Nvdot"
    assert share == pytest.approx(100 * abs(change[name]), rel=0.1)
    truth = small_campaign.TRUTH
    assert share == pytest.approx(100 * 0.01 * truth["Yvdot"] / truth["Nvdot"], rel=0.1)


def test_a_stated_uncertainty_of_the_point_stands_in_the_line(small):
    point = pk.campaigns.TypeB(name="moment_reference_x", std=0.005, shared=True)
    found = names(small.with_(moment_reference_x=-0.01, uncertainty=(point,)))
    assert found["moments' point"].condition == "the moments' point (x = -0.01 ± 0.0098 m)"


def test_the_line_names_five_things_and_counts_the_rest():
    conditions = tuple("abcdefg")
    assert str(TableVerdict(conditions=conditions[:1])) == "Usable, if a is right."
    line = str(TableVerdict(conditions=conditions, doubts=("x",)))
    assert line == (
        "Usable with the 1 doubt above, if a, b, c, d, e and 2 things more in the notes are right."
    )
    assert str(TableVerdict(faults=("bad.",), conditions=conditions)) == "Not usable: bad."


def test_a_table_of_before_still_reads():
    old = {"verdict": {"use": "usable", "faults": [], "doubts": []}}
    assert str(kept_verdict(old)) == "Usable."


@pytest.mark.slow
def test_a_plan_says_it_before_the_first_test(tmp_path, capsys, monkeypatch):
    monkeypatch.chdir(tmp_path)
    asked = ["plan", "s175-3dof", "--speeds", "1.0,2.0", "--runs", "4", "--out", "plan"]
    assert main(asked) == 0
    out = capsys.readouterr().out
    told = out.partition("What these runs cannot tell:")[2]
    assert "the scale of the gauges of X, Y and N" in told
    assert "A slip of 0.01 L (" in told
    assert main([*asked, "--json"]) == 0
    found = json.loads(capsys.readouterr().out)["untold"]
    assert [item["name"] for item in found][:2] == ["scale", "moments' point"]
    assert all({"text", "check", "condition"} <= set(item) for item in found)


def test_nothing_is_said_of_free_running_tests(small):
    assert Untold.of(small.with_(kind="free-running")) == ()
    assert Untold.of(small.with_(runs=())) == ()


@pytest.mark.slow
def test_a_diagnosis_says_it_by_the_settings(small):
    found = pk.diagnose("cubic", small)
    assert [item.name for item in found.untold][:3] == ["scale", "moments' point", "day"]
    assert "What these runs cannot tell" in str(found)
    assert found.to_dict()["untold"][0]["name"] == "scale"
    assert replace(found, untold=()).untold == ()
