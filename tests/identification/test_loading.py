"""From the loading of a trial to full load: R = T F/B of MSC/Circ.1053, 3.4.1."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import pmmkit as pk
from pmmkit import Campaign, imo_turning
from pmmkit.base import DataError
from pmmkit.conventions import Ship, Water
from pmmkit.identification import Corrected, LoadingPrediction, Trial
from pmmkit.identification.trials.evaluate import verdicts_of
from pmmkit.models import Step, estimated_model
from pmmkit.models.model import ASTERN
from pmmkit.views import form_of_trials

SPEED = 8.0


def tanker(draught, block, **changes):
    """A tanker by her particulars; with some derivatives changed, what she really is."""
    volume = block * 320.0 * 58.0 * draught
    mass = 1025.0 * volume
    ship = Ship(
        name=f"d {draught:g}",
        L=320.0,
        B=58.0,
        d=draught,
        volume=volume,
        mass=mass,
        Izz=mass * 80.0**2,
    )
    model = estimated_model(ship, speed=SPEED, propeller_diameter=9.9, rudder_area=137.0)
    own = model.part("hull_polynomial").values
    changed = {name: share * own[name] for name, share in changes.items()}
    return model.with_values("hull_polynomial", **changed)


def sailed(model, rudder_deg=35.0, speed=SPEED):
    """A turning circle as a trial that was measured without any error."""
    track = pk.simulate(model, "turning", speed=speed, rudder_deg=rudder_deg, compiled=False)
    return Trial(
        run="T1",
        speed_std=0.0,
        heading_deg=0.0,
        order=0.0,
        std=dict.fromkeys(track.metrics, 0.05),
        verdicts=tuple(replace(x, unsettled=()) for x in imo_turning(track)),
        x_ground=track.x,
        y_ground=track.y,
        **vars(track),
    )


BALLAST, FULL = (11.0, 0.77), (20.8, 0.81)
REAL = {"Nv": 1.08, "Yr": 0.95}
"""By which the ship differs from her models in either condition."""


def corrected(*trials):
    return LoadingPrediction.of(tanker(*BALLAST)).to_full_load(
        trials, LoadingPrediction.of(tanker(*FULL)), compiled=False
    )


def test_a_model_that_is_right_as_tried_gives_its_own_full_load():
    trial = sailed(tanker(*BALLAST))
    full = sailed(tanker(*FULL))
    for item in corrected(trial):
        assert item.misses == pytest.approx(0.0, abs=1e-9)
        assert item.verdict.value == pytest.approx(full.metrics[item.measured.metric], rel=1e-9)


@pytest.mark.parametrize("rudder_deg", [35.0, -35.0])
def test_what_a_model_misses_in_both_conditions_the_ratio_takes_out(rudder_deg):
    """F alone would be wrong by what the models lack; T F/B by a small part of it."""
    trial = sailed(tanker(*BALLAST, **REAL), rudder_deg)
    truth = sailed(tanker(*FULL, **REAL), rudder_deg).metrics
    found = corrected(trial)
    assert [item.measured.criterion for item in found] == ["advance", "tactical_diameter"]
    for item in found:
        real = truth[item.measured.metric]
        assert abs(item.verdict.value - real) < 0.5 * abs(item.full - real)
        assert item.verdict.margin == pytest.approx(item.verdict.limit - item.verdict.value)
        assert item.verdict.side == ("port" if rudder_deg < 0 else "starboard")


def tank_tests(loading):
    """Model tests of 7 m to both sides, as measured without any error."""
    model = pk.scaled(tanker(*loading), 7.0)
    pace = SPEED * np.sqrt(7.0 / 320.0)
    both = tuple(sailed(model, side * 35.0, pace) for side in (1.0, -1.0))
    return LoadingPrediction(name="tank", L=7.0, draught=model.ship.d, tests=both)


def test_model_tests_do_as_well_as_models_by_froudes_law():
    trial = sailed(tanker(*BALLAST, **REAL), -35.0)
    found = tank_tests(BALLAST).to_full_load([trial], tank_tests(FULL))
    assert [item.measured.criterion for item in found] == ["advance", "tactical_diameter"]
    for item, same in zip(found, corrected(trial), strict=True):
        assert item.verdict.value == pytest.approx(same.verdict.value, rel=1e-6)
    both = tank_tests(BALLAST), tank_tests(FULL)
    assert both[0].notes(both[1], L=320.0, draught=11.0, full_draught=20.8) == ()
    with pytest.raises(DataError, match="same method"):
        tank_tests(BALLAST).to_full_load([trial], LoadingPrediction.of(tanker(*FULL)))


def test_the_uncertainty_of_the_measure_is_carried_with_it():
    trial = sailed(tanker(*BALLAST))
    near = replace(
        trial.verdicts[1], limit=1.02 * sailed(tanker(*FULL)).metrics["tactical_diameter_L"]
    )
    (item,) = corrected(replace(trial, verdicts=(near,)))
    share = item.full / item.tried
    rng = np.random.default_rng(0)
    drawn = share * (item.measured.value + 0.05 * rng.normal(size=200_000))
    assert item.verdict.probability == pytest.approx(np.mean(drawn <= near.limit), abs=0.005)


def test_what_a_model_cannot_sail_stays_as_tried():
    """The Mariner's model has no propeller."""
    ship = pk.load_model("mariner")
    stopped = replace(sailed(tanker(*BALLAST)).verdicts[0], criterion="track_reach", value=7.0)
    trial = replace(sailed(tanker(*BALLAST)), L=ship.ship.L, verdicts=(stopped,))
    assert LoadingPrediction.of(ship).to_full_load([trial], LoadingPrediction.of(ship)) == ()


def test_a_stop_by_an_estimate_of_the_propeller_astern_is_corrected_with_that_said():
    stopped = replace(sailed(tanker(*BALLAST)).verdicts[0], criterion="track_reach", value=7.0)
    (found,) = corrected(replace(sailed(tanker(*BALLAST)), verdicts=(stopped,)))
    reach = [
        pk.simulate(tanker(*loaded).with_estimated_astern(), "stopping", speed=SPEED)
        for loaded in (BALLAST, FULL)
    ]
    ratio = reach[1].metrics["track_reach_L"] / reach[0].metrics["track_reach_L"]
    assert found.verdict.value == pytest.approx(7.0 * ratio, rel=1e-6)


def test_models_of_another_length_or_draught_are_named():
    trial = sailed(tanker(*BALLAST))
    with pytest.raises(DataError, match="pmmkit scale"):
        LoadingPrediction.of("kvlcc2-l7").to_full_load([trial], LoadingPrediction.of("kvlcc2-l7"))
    full = LoadingPrediction.of(tanker(*FULL))
    notes = full.notes(full, L=320.0, draught=11.0, full_draught=20.8)
    assert len(notes) == 2
    assert "is for 20.8 m of draught, the ship draws 11 m" in notes[0]
    assert ASTERN in notes[1]


def test_the_table_names_its_columns_by_the_letters_of_the_notes():
    trial = sailed(tanker(*BALLAST))
    found = corrected(trial)
    grid = Corrected.grid(found)
    assert {"T", "B", "F", "R = T F/B"} < set(grid.head)
    told = found[0].to_dict()
    assert told["R"] == pytest.approx(told["T"] * told["F"] / told["B"])


def test_what_was_carried_on_one_side_alone_is_not_judged_on_both():
    starboard, port = (sailed(tanker(*BALLAST), side * 35.0) for side in (1.0, -1.0))
    trials = [starboard, replace(port, run="T2")]
    campaign = Campaign(title="trial", ship=tanker(*BALLAST).ship, water=Water(), runs=())
    one, both = (
        form_of_trials(campaign, trials, corrected=corrected(*some))
        for some in (trials[:1], trials)
    )
    assert [line.passed for line in one.lines[:2]] == [None, None]
    assert [line.tried for line in one.lines[:2]] == [True, True]
    assert [line.passed for line in both.lines[:2]] == [True, True]
    assert one.lines[0].words == "turning circle 35°: advance, as tried"


def test_nothing_is_met_by_a_ratio_to_a_model_that_is_not_usable():
    trial = sailed(pk.load_model("kvlcc2"))
    why = Step(action="forced", ship="tanker", names=("Yv is positive.",))
    forced = tanker(*FULL).stepped(why)
    (first, *_) = LoadingPrediction.of(tanker(*BALLAST)).to_full_load(
        [trial], LoadingPrediction.of(forced), compiled=False
    )
    assert first.measured.passed is True
    assert first.verdict.passed is None
    assert [row[-1] for row in Corrected.grid([first]).groups[0].rows] == ["not settled"]


def test_a_trial_and_a_simulation_name_one_manoeuvre_alike():
    asked = {"L": 320.0, "speed": 8.0, "rudder_deg": 9.9, "switch_deg": 10.0}
    (trial, *_) = verdicts_of("zigzag", {"overshoot_1_deg": 8.0}, {}, **asked)
    model = pk.imo_verdicts("esso190k", 8.0, n=0, compiled=False)
    (zigzag,) = [
        item
        for item in model
        if item.criterion == "first_overshoot_10_10" and item.side == "starboard"
    ]
    assert trial.manoeuvre == zigzag.manoeuvre == "zigzag 10/10, to starboard"


def test_a_small_uncertainty_of_a_trial_is_not_told_as_none():
    trial = replace(sailed(tanker(*FULL)), speed_std=2e-4)
    trial = replace(trial, std=dict.fromkeys(trial.metrics, 0.0026))
    assert "approach 8.00000 ± 0.00039 m/s" in trial._headline()
    assert {row[2] for row in trial._measures().groups[0].rows} <= {"0.0026 m", "0.0026 s", "–"}
