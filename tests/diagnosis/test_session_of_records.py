"""The loop on free-running records: diagnose, add, watch the error fall, undo, replay, a page."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from pages import answers_in, texts_in
from term_candidates import polynomial

import pmmkit as pk
from pmmkit.base import DataError, ModelError, UnknownNameError
from pmmkit.diagnosis import undone
from pmmkit.diagnosis.free_running.diagnose import diagnose_free
from pmmkit.diagnosis.free_running.fits import at_place, having
from pmmkit.diagnosis.record_figures import before_and_after
from pmmkit.identification import Prior
from pmmkit.plotting.marks import Rule
from pmmkit.views import page_of, write_report
from tests.support.recorded import recorded
from tests.support.zigzags import ASYMMETRY, KNOWN, SENSORS, SHIP, SPEED, sailed

FEW = ("asymmetry", "fault_rudder_zero", "modulus_yaw_drag")
HOW = {"prior": Prior.of(SHIP, KNOWN, SPEED, spread=0.02), "sensors": SENSORS, "most": 1}


@pytest.fixture(scope="module")
def records():
    return sailed(ASYMMETRY, 5)


@pytest.fixture(scope="module")
def session(records):
    return pk.begin(SHIP, records, candidates=FEW, **HOW)


@pytest.fixture(scope="module")
def found(session):
    return session.diagnose()


@pytest.fixture(scope="module")
def added(session, found):
    """With all that is named."""
    for item in found.findings:
        session = session.add(item, "seen in zigzags")
    return session


@pytest.mark.slow
def test_the_loop_ends_where_nothing_is_missing(added):
    assert added.given == ("asymmetry",)
    again = added.diagnose()
    assert again.verdict == "noise"
    assert again.given == ("asymmetry",)
    asked = {name for item in again.entries for name in item.names}
    assert asked == {"fault_rudder_zero", "modulus_yaw_drag"}, "what is there is not asked again"


@pytest.mark.slow
def test_what_no_step_reaches_is_refused_and_not_added_with_nothing_in_it(records):
    """Gyros that tell another heading at each sample: no path is along such records."""
    rng = np.random.default_rng(2)
    wild = [
        replace(x, measured={**x.measured, "psi": rng.uniform(-0.1, 0.1, len(x.t))})
        for x in records
    ]
    with pytest.raises(DataError, match="give asymmetry no size"):
        pk.begin(SHIP, wild, candidates=FEW, **HOW).add("asymmetry").model()


@pytest.mark.slow
def test_a_session_says_what_a_diagnosis_says(records, found):
    """One way: the same evidence to the bit."""
    alone = diagnose_free(SHIP, records, candidates=FEW, **HOW)
    assert [(x.names, x.log_evidence) for x in alone.entries] == [
        (x.names, x.log_evidence) for x in found.entries
    ]


@pytest.mark.slow
def test_the_error_falls_in_all_that_is_measured(added, found):
    fall = added.fall()
    base, after = fall.totals
    assert fall.steps == ("base", "asymmetry")
    assert fall.useless == ()
    assert after < 0.7 * base
    yaw_rate = fall.errors("yaw_rate")
    assert yaw_rate[1] < 0.6 * yaw_rate[0]
    assert all(fall.errors(name)[1] < fall.errors(name)[0] for name in fall.quantities())
    assert base == found.errors["left out, base refitted"]["heading"]
    names = ["position", "heading", "speed", "yaw_rate"]
    levels = [f"{name}_level" for name in names]
    assert list(fall.to_pandas().columns) == ["step", *names, *levels, "campaign"]
    assert f"heading {base:.3g}° to {after:.3g}°" in str(fall)


@pytest.mark.slow
def test_the_model_has_the_effect_and_tells_how(added, found, session):
    made = added.model()
    assert made.values("hull_polynomial")["Y0"] == pytest.approx(0.0022, rel=0.3)
    step = made.steps[-1]
    assert (step.action, step.effect) == ("effect_added", "asymmetry")
    assert step.log_odds == found.findings[0].log_odds
    base, after = added.fall().totals
    said = f"(seen in zigzags): error of heading {base:.3g}° to {after:.3g}°"
    assert said in made.history[-1]
    assert (step.error_before, step.error_after, step.error_of) == (base, after, "heading")
    hull = made.parts["hull_polynomial"]
    flat = SHIP.ship.d / SHIP.ship.L  # the model is made non-dimensional by Ld, the step by L²
    values = {name: flat * hull.values[name] for name in step.coefficients}
    assert step.coefficients == pytest.approx(values), "those of the model that it belongs to"
    assert hull.source_of("Y0").startswith("measured: ")
    assert hull.source_of("Yv").startswith(SHIP.parts["hull_polynomial"].source_of("Yv"))
    back, name = undone(made)
    assert name == "asymmetry"
    assert "Y0" not in back.values("hull_polynomial")
    bare = session.model()
    assert "Y0" not in bare.values("hull_polynomial")
    assert [item.action for item in bare.steps] == ["fitted"]


@pytest.mark.slow
def test_the_model_is_as_uncertain_as_the_diagnosis_says(added, found, tmp_path):
    """What is written holds the fit's covariance: a turn of it has an error bar."""
    pk.save_model(added.model(), tmp_path / "model.toml")
    written = pk.load_model(tmp_path / "model.toml")
    (item,) = found.findings
    C = dict(zip(written.covariance_names, np.diagonal(written.covariance), strict=True))
    for name, value in item.coefficients.items():
        own = math.sqrt(C[name]) / abs(written.values("hull_polynomial")[name])
        assert own == pytest.approx(item.std[name] / abs(value), rel=0.05), "each in its own unit"
    assert found.model.covariance_names == written.covariance_names


@pytest.mark.slow
def test_a_fault_corrects_the_records_and_is_known_in_the_next_session():
    """A rudder zero of 1.5°: fitted, in no model, and part of the base of what follows."""
    records = sailed(SHIP, 0, zero=math.radians(1.5))
    made = pk.begin(SHIP, records, candidates=FEW, **HOW).add("fault_rudder_zero").model()
    (step,) = made.steps[-1:]
    assert (step.action, step.effect) == ("fault_corrected", "fault_rudder_zero")
    assert step.coefficients["angle"] == pytest.approx(1.5, rel=0.1)
    assert made.values("hull_polynomial").keys() == SHIP.values("hull_polynomial").keys()
    later = pk.begin(made, records, candidates=("asymmetry",), **HOW)
    assert later.given == ("fault_rudder_zero",)
    again = later.diagnose()
    assert again.verdict == "noise"
    assert again.corrections["rudder_zero"] == pytest.approx(math.radians(1.5), rel=0.1)


@pytest.mark.slow
def test_steps_are_undone_saved_and_replayed(session, added, records, tmp_path):
    assert added.undo().steps == session.steps == ()
    with pytest.raises(ModelError, match="no step"):
        session.undo()
    added.save(tmp_path / "steps.toml")
    again = pk.replay(tmp_path / "steps.toml", SHIP, records, candidates=FEW, **HOW)
    assert again.steps == added.steps
    assert str(again) == str(added)
    assert again.fall().rows == added.fall().rows


def test_what_cannot_be_asked_or_added_is_said(session, records):
    with pytest.raises(UnknownNameError, match="did you mean 'asymmetry'"):
        session.add("asymetry")
    with pytest.raises(ModelError, match="already"):
        session.add("asymmetry").add("asymmetry")
    with pytest.raises(UnknownNameError, match="did you mean 'asymmetry'"):
        pk.begin(SHIP, records, candidates=["asymetry"])
    with pytest.raises(DataError, match="sensors"):
        pk.begin(SHIP, records, noise=0.01)
    with pytest.raises(DataError, match="complete model"):
        pk.begin("cubic", records)
    with pytest.raises(DataError, match="captive"):
        pk.begin(SHIP, records, candidates=[polynomial("twist", "hull", "A twist.", {"Yvv": 1e-3})])


@pytest.mark.slow
def test_a_candidate_of_the_base_is_weighed_as_one_that_is_added(session):
    """ln p(y | base has a) is that of the set {a}: it was only counted elsewhere."""
    place = session.evidence.system.place
    inside = having(place, ("asymmetry",))
    for rest in ((), ("modulus_yaw_drag",)):
        one = at_place(place, ("asymmetry", *rest))
        other = at_place(inside, rest)
        assert other.log_probability == pytest.approx(one.log_probability, abs=1e-3)
    assert set(inside.question.numbers.columns) == {"fault_rudder_zero", "modulus_yaw_drag"}


@pytest.mark.slow
def test_the_page_tells_the_errors_before_and_after(session, added, found, tmp_path):
    path = write_report(found, tmp_path / "report.html", session=session, title="Zigzags, 7 m")
    page = answers_in(path)
    told = page["told missing"]
    titles = [section["title"] for section in told["after"]]
    assert titles[0] == "Records before and after"
    assert titles[1].startswith("Errors over windows")
    assert {item["effect"] for item in page["missing"]["covered"]} == {
        x.name for x in found.covered
    }
    assert "zigzag 1" in told["after"][0]["figures"][0]["svg"]
    base, after = added.fall().totals
    assert f"{base:.2g} → {after:.2g}°" in texts_in(told["facts"])
    errors = [step["error"] for step in page["fall"]["steps"]]
    assert errors == pytest.approx([base, after], rel=1e-4)


@pytest.mark.slow
def test_records_are_drawn_as_they_were_measured_and_sailed(added, records):
    """The lines of the figure are the records, and break where a window begins."""
    drawn = added.evidence.sailed(added.steps, most=2)
    assert len(drawn) == 2
    figure = before_and_after(drawn)
    axes = np.array(figure.axes).reshape(4, 2)
    for axis, item in zip(axes[1], drawn, strict=True):
        measured, *models = axis.points
        own = next(x for x in records if x.name == item.name)
        np.testing.assert_array_equal(measured.y, np.degrees(own.measured["psi"]))
        assert len(models) == 2
        for line in models:
            assert np.isnan(line.y).sum() == len(item.begins) - 1
    assert {axis.ylabel.text for axis in axes[:, 0]} >= {"heading [deg]", "yaw rate [deg/s]"}


@pytest.mark.slow
def test_what_noise_alone_gives_stands_beside_the_error(added, found):
    """The asymmetry is all that is missing: with it the error is the noise's, without it more."""
    fall = added.fall()
    base, after = fall.totals
    level = fall.levels("heading")[-1]
    (finding,) = found.findings
    assert level == pytest.approx(finding.error_level, rel=0.5)
    assert after < 1.6 * level < base
    assert finding.to_dict()["errors"]["heading"]["level"] == finding.error_level
    assert f" with noise of {finding.error_level:.3g}" in str(found)
    assert found.errors["left out, noise alone"]["heading"] == finding.error_level
    assert "noise alone" in str(fall)
    drawn = fall.plot().shown[fall.quantities().index("heading")]
    (rule,) = (mark for mark in drawn.marks if isinstance(mark, Rule))
    assert rule.at == level
    shown = [step["level"] for step in page_of(fall)["steps"]]
    assert shown == pytest.approx([level] * 2, rel=1e-4)


def test_nothing_to_draw_is_refused():
    with pytest.raises(DataError, match="no record"):
        before_and_after([])


@pytest.mark.slow
def test_one_record_that_the_model_turns_away_from_does_not_decide_for_all():
    """A turn whose rudder column has the other sign: with it no step of a fit was taken, and
    nothing was named (a ship that goes astern, of the Esso Osaka)."""
    track = pk.simulate(SHIP, "turning", rudder_deg=35.0, speed=SPEED, dt=0.5)
    turned = recorded(track, SENSORS, np.random.default_rng(9), name="other sign", speed=SPEED)
    turned = turned.with_(delta=-turned.delta).cut(0.0, 75.0)
    how = {"candidates": ["asymmetry", "fault_rudder_zero"], "most": 1, "sensors": SENSORS}
    sound = pk.begin(SHIP, sailed(ASYMMETRY, 0), **how, spread=0.03).diagnose()
    found = pk.begin(SHIP, [*sailed(ASYMMETRY, 0), turned], **how, spread=0.03).diagnose()
    assert found.best == sound.best == ("asymmetry",)
    assert found.entries == sound.entries
    assert any("left out: other sign" in note for note in found.notes)
