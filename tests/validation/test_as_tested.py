"""What a model's steps tell of some tests is in the comparison with them, and in no other.

Records come from a tank of free-running ships that shares no code with the package; what is hidden
enters there at its source. The model is the tank's own ship, exact where nothing is hidden, and its
step says the hidden size.
"""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from free_tank.campaigns import Setup, hidden_in, write
from free_tank.cases import FLEETS
from hidden_effects import hidden_campaign
from small_campaign import write_campaign

import pmmkit as pk
from pmmkit.cli import main
from pmmkit.diagnosis.free_running.question import records_of
from pmmkit.identification import PredictedWindow, Smoothed
from pmmkit.models import Step

SHIP = "kvlcc2-l7"
FAULTS = {
    "current": ("current", lambda h: {"current_x": h.current[0], "current_y": h.current[1]}),
    "rudder_zero": ("fault_rudder_zero", lambda h: {"angle": math.degrees(h.rudder_zero)}),
    "clock": ("fault_clock_lag", lambda h: {"clock_lag": h.late_positions}),
    "antenna": ("fault_antenna", lambda h: {"antenna_x": h.antenna, "antenna_y": 0.0}),
    "heading": (
        "fault_heading_offset",
        lambda h: {"heading_offset": math.degrees(h.heading_offset)},
    ),
    "log": ("fault_log", lambda h: {"log_gain": h.log_gain}),
}
"""Name of what a case hides, and its coefficients with their units in the catalogue."""


@pytest.fixture(scope="module", params=FAULTS)
def compared(request, tmp_path_factory):
    """A turning circle: compared by the model as given, and as its step says of these tests."""
    effect, coefficients = FAULTS[request.param]
    setup = Setup(case=request.param, runs=3, seed=2, ship=SHIP)
    campaign = pk.open_campaign(write(setup, tmp_path_factory.mktemp(request.param)))
    campaign = campaign.with_(runs=campaign.runs[:1])
    step = Step(
        action="fault_corrected",
        effect=effect,
        coefficients=coefficients(hidden_in(setup)),
        campaign=campaign.title,
    )
    ship = pk.load_model(SHIP)
    return step, campaign, pk.compare(ship, campaign), pk.compare(ship.stepped(step), campaign)


def errors(comparison):
    """Errors over their uncertainty, all channels of all records."""
    return np.array([row["ratio"] for row in comparison.rows()])


def test_what_was_added_makes_the_comparison_right(compared):
    """With nothing hidden any more, errors are those of a true model: 95 % within U."""
    _, _, before, after = compared
    assert np.sum(errors(after) > 1.0) <= 1
    assert np.sqrt(np.mean(errors(after) ** 2)) < 0.75 * np.sqrt(np.mean(errors(before) ** 2))
    assert any("as the model's steps say" in note for note in after.notes)


@pytest.mark.parametrize("compared", ["rudder_zero"], indirect=True)
def test_a_fault_belongs_to_its_laboratory(compared):
    """Told of other tests, it changes nothing here, to the digit."""
    step, campaign, before, _ = compared
    elsewhere = replace(step, campaign="another trial")
    ship = pk.load_model(SHIP).stepped(elsewhere)
    assert pk.compare(ship, campaign).rows() == before.rows()


def test_measures_of_a_circle_in_a_current_are_those_through_the_water(tmp_path):
    setup = Setup(case="current", runs=3, seed=4, ship=SHIP)
    campaign = pk.open_campaign(write(setup, tmp_path))
    campaign = campaign.with_(runs=campaign.runs[:1])
    step = Step(
        action="fault_corrected",
        effect="current",
        coefficients=FAULTS["current"][1](hidden_in(setup)),
        campaign=campaign.title,
    )
    found = {}
    models = {"given": pk.load_model(SHIP), "stepped": pk.load_model(SHIP).stepped(step)}
    for name, model in models.items():
        rows = [row for item in pk.compare(model, campaign).manoeuvres for row in item.rows()]
        found[name] = {row["measure"]: row["relative"] for row in rows if row["test"] == "turning"}
    assert abs(found["given"]["advance"]) > 0.03
    for measure in ("advance", "transfer", "tactical_diameter"):
        assert abs(found["stepped"][measure]) < 0.005


@pytest.mark.parametrize("case", ["none", "current"])
def test_a_drift_of_circles_that_nobody_asked_about_is_told(case, tmp_path, monkeypatch):
    """More than a full circle is sailed: its positions tell the current, whatever the model."""
    longer = replace(FLEETS[SHIP], turn=330.0)
    monkeypatch.setitem(FLEETS, SHIP, longer)
    setup = Setup(case=case, runs=3, seed=4, ship=SHIP)
    campaign = pk.open_campaign(write(setup, tmp_path))
    campaign = campaign.with_(runs=campaign.runs[:1])
    x, y = hidden_in(setup).current
    step = Step(
        action="fault_corrected",
        effect="current",
        coefficients={"current_x": x, "current_y": y},
        campaign=campaign.title,
    )
    given, stepped = (
        [note for note in pk.compare(model, campaign).notes if note.startswith("Circles drift")]
        for model in (pk.load_model(SHIP), pk.load_model(SHIP).stepped(step))
    )
    assert stepped == []
    if case == "none":
        assert given == []
        return
    (told,) = given
    assert float(told.split()[3]) == pytest.approx(math.hypot(x, y), rel=0.1)
    assert "pmmkit diagnose" in told


TANK = {
    "fault_gauge_gain": ({"share": 0.1}, lambda t, Y, N: (1.1 * Y, N)),
    "fault_gauge_zero": ({"Y": 8.0, "N": 12.0}, lambda t, Y, N: (Y + 8.0, N + 12.0)),
    "fault_time_lag": (
        {"lag": 0.04},
        lambda t, Y, N: tuple(np.interp(t - 0.04, t, force) for force in (Y, N)),
    ),
}


@pytest.fixture(scope="module")
def programme(tmp_path_factory):
    """The small programme of the S175 with her forces by hand; surge is not compared."""
    campaign = pk.open_campaign(write_campaign(tmp_path_factory.mktemp("tank") / "tests"))
    chosen = [run for run in campaign.runs if run.settings.speed == 2.0][::3]
    return campaign.with_(runs=tuple(chosen))


@pytest.mark.parametrize("name", TANK)
def test_faults_of_a_towing_tank_are_in_the_prediction_of_its_tests(programme, name):
    """Gain, zero and lag of gauges put into the records by hand; the model is the truth."""
    coefficients, spoil = TANK[name]

    def spoiled(run):
        data = run.data
        t, Y, N = (np.asarray(data[x].values, float) for x in ("t", "Y", "N"))
        changed = dict(zip("YN", spoil(t, Y, N), strict=True))
        made = data.assign({x: data[x].copy(data=y) for x, y in changed.items()})
        return run.with_(loader=lambda: made)

    tests = programme.with_(runs=tuple(spoiled(run) for run in programme.runs))
    step = Step(
        action="fault_corrected", effect=name, coefficients=coefficients, campaign=tests.title
    )
    ship = pk.load_model("s175-3dof")
    clean, before, after = (
        np.array([row["error"] for row in pk.compare(model, each).rows() if row["channel"] != "X"])
        for model, each in ((ship, programme), (ship, tests), (ship.stepped(step), tests))
    )
    assert np.linalg.norm(before) > 2 * np.linalg.norm(clean)
    # a lag is linear in the catalogue, and is not: of the third harmonic 1 % is left
    assert np.linalg.norm(after) < (1.6 if name == "fault_time_lag" else 1.15) * np.linalg.norm(
        clean
    )


@pytest.mark.parametrize("fault", ["fault_misalignment", "fault_gauge_zero", "fault_cross_talk"])
def test_a_fault_that_a_session_adds_is_in_the_next_comparison_with_its_tests(fault, tmp_path):
    """A tank of its own; the ship is the tank's but for what is hidden. Written and read again."""
    hidden = {"yaw_sway_coupling": 1.0, "surge_yaw_coupling": 1.0, fault: 2.0}
    tests = hidden_campaign("small", hidden, seed=2)
    tests = tests.with_(runs=tuple(run for run in tests.runs if not run.settings.rudder))
    ship = pk.load_model("s175-3dof")
    pk.save_model(pk.begin(ship, tests).add(fault).model(), tmp_path / "model.toml")
    before, after = (pk.compare(model, tests) for model in (ship, tmp_path / "model.toml"))
    assert any(note.endswith(f"of these tests: {fault}.") for note in after.notes)
    least = {
        comparison: np.sqrt(np.mean(np.square([row["ratio"] for row in comparison.rows()])))
        for comparison in (before, after)
    }
    assert least[after] < 0.75 * least[before]
    assert np.mean([row["within"] for row in after.rows()]) > 0.9


def test_a_fault_whose_size_says_nothing_of_a_run_is_left_out_with_words(programme):
    step = Step(
        action="fault_corrected",
        effect="fault_transient",
        coefficients={"share": 0.1},
        campaign=programme.title,
    )
    ship = pk.load_model("s175-3dof")
    found = pk.compare(ship.stepped(step), programme)
    assert found.rows() == pk.compare(ship, programme).rows()
    assert any("Not in the prediction" in x and "fault_transient" in x for x in found.notes)


@pytest.mark.slow
def test_a_current_is_found_added_and_gone_from_the_next_comparison(tmp_path, capsys, monkeypatch):
    """The user's sentence, typed: compare, diagnose, what `Next:` prints, compare again."""
    monkeypatch.chdir(tmp_path)
    write(Setup(case="current", runs=3, seed=4, ship=SHIP), tmp_path).rename("trial")
    assert main(["compare", SHIP, "trial", "--no-figures", "--out", "c1"]) == 0
    assert "position, turning, " in capsys.readouterr().out.split("What stands out")[1]
    assert main(["diagnose", SHIP, "trial", "--no-figures", "--out", "d1"]) == 0
    said = capsys.readouterr().out
    (following,) = (line for line in said.splitlines() if line.startswith("Next: pmmkit add"))
    assert main(following.split()[2:]) == 0
    assert main(["compare", "model2.toml", "trial", "--no-figures", "--out", "c2"]) == 0
    assert "Nothing stands out" in capsys.readouterr().out
    trial = pk.open_campaign("trial")
    before, after = (
        {row["channel"]: row["error"] for row in pk.compare(model, trial).rows()}
        for model in (pk.load_model(SHIP), pk.load_model("model2.toml"))
    )
    assert after["position"] < 0.4 * before["position"]
    assert after["N"] < 0.4 * before["N"]
    assert main(["diagnose", "model2.toml", "trial", "--no-figures", "--out", "d2"]) == 0
    assert "nothing is missing" in capsys.readouterr().out


@pytest.mark.slow
def test_a_current_that_is_identified_is_in_predictions_and_comparisons(tmp_path):
    setup = Setup(case="current", runs=3, seed=4, ship=SHIP)
    campaign = pk.open_campaign(write(setup, tmp_path))
    ship = pk.load_model(SHIP)
    records = records_of(campaign, ship)
    found = pk.compare_methods(
        ship,
        records[1:],
        ["current_x", "current_y"],
        methods=("trajectory",),
        references=Smoothed.references(ship, records[:1]),
        window=60.0,
    )
    assert found.found["trajectory"].current == pytest.approx(hidden_in(setup).current, abs=3e-3)
    before, after = (found.predictions[name].pooled() for name in ("before", "trajectory"))
    assert after["position"] < 0.3 * before["position"]
    models = {"before": ship, "trajectory": found.found["trajectory"].model}
    still, drawn = (
        PredictedWindow.of(models, Smoothed.references(ship, records[:1]), currents=currents)
        for currents in ({}, found.currents)
    )

    def off(sailed, name):
        ends = (sailed.predicted[name][x][-1] - sailed.measured[x][-1] for x in "xy")
        return math.hypot(*ends)

    assert off(drawn, "trajectory") < 0.2 * off(still, "trajectory")
    assert off(drawn, "trajectory") < 0.2 * off(drawn, "before")
    turn = campaign.with_(runs=campaign.runs[:1])
    given, identified = (
        {row["channel"]: row["error"] for row in pk.compare(model, turn).rows()}
        for model in (ship, found.found["trajectory"].model)
    )
    assert identified["position"] < 0.3 * given["position"]
