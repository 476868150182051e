"""One session about several campaigns: captive tests and free-running records of one ship."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from hidden_effects import hidden_campaign

import pmmkit as pk
from pmmkit import without_effect
from pmmkit.base import DataError, ModelError, UnknownNameError
from pmmkit.diagnosis.captive.held_out import condition, held_out
from pmmkit.diagnosis.captive.verdict import about
from tests.support.free_tank.campaigns import Setup, write
from tests.support.zigzags import ASYMMETRY, SENSORS, SHIP, sailed

FEW = ("yaw_sway_coupling", "asymmetry", "current")


@pytest.fixture(scope="module")
def base():
    return without_effect(pk.load_model("s175-3dof"), "yaw_sway_coupling")


@pytest.fixture(scope="module")
def tanks():
    """Two tanks test a ship with a coupling; in one the model is turned on the carriage."""
    hidden = {"yaw_sway_coupling": 1.0}
    return {
        "turned": hidden_campaign("middle", {**hidden, "fault_misalignment": 1.0}, seed=3),
        "straight": hidden_campaign("middle", hidden, seed=4),
    }


@pytest.fixture(scope="module")
def session(base, tanks):
    return pk.begin(base, tanks)


@pytest.mark.slow
def test_what_all_say_is_added_and_each_error_falls(session):
    found = session.diagnose()
    assert found.best == ("yaw_sway_coupling",)
    odds = found.added["yaw_sway_coupling"]
    added = session.add("yaw_sway_coupling", "both show it", log_odds=odds)
    assert added.steps[-1].log_odds == odds
    fall = added.fall()
    for before, after in fall.by_campaign.values():
        assert after < 0.3 * before
    again = added.diagnose()
    assert again.verdict == "noise"
    assert again.given == ("yaw_sway_coupling",)
    assert "turned has fault_misalignment of its own." in again.flags
    corrected = added.add("fault_misalignment", campaign="turned").fall()
    assert corrected.by_campaign["turned"][-1] < 1.5
    assert corrected.steps[-1] == "fault_misalignment (turned)"
    assert corrected.only("straight").steps == ("base", "yaw_sway_coupling")
    assert not again.others, "what another laboratory makes of a step is not asked"


@pytest.mark.slow
def test_each_campaign_says_what_it_says_alone(session, base, tanks):
    """To the bit: one way to the numbers, in a session of one campaign and of several."""
    step = session.add("yaw_sway_coupling")
    for name in tanks:
        alone = pk.begin(base, tanks[name]).add("yaw_sway_coupling").fall()
        own = step.fall().only(name)
        assert [replace(row, campaign="") for row in own.rows] == [
            replace(row, campaign="") for row in alone.rows
        ]
    alone = pk.begin(base, tanks["turned"]).add("yaw_sway_coupling").model()
    hull = step.model().parts["hull_polynomial"].values
    assert dict(hull) == dict(alone.parts["hull_polynomial"].values)


@pytest.mark.slow
def test_a_session_of_several_is_saved_undone_and_replayed(session, base, tanks, tmp_path):
    added = session.add("yaw_sway_coupling", "for a reason")
    assert added.undo().given == session.given
    added.save(tmp_path / "steps.toml")
    again = pk.replay(tmp_path / "steps.toml", base, tanks)
    assert again.fall().totals == added.fall().totals
    assert "turned, straight" in str(again)


@pytest.mark.slow
def test_the_fall_of_several_prints_and_is_data(session):
    fall = session.add("yaw_sway_coupling").fall()
    text = str(fall)
    assert "turned: force [%]" in text
    assert "straight: yaw_sway_coupling" in text
    table = fall.to_pandas()
    assert set(table.campaign) == {"turned", "straight"}
    assert fall.steps == ("base", "yaw_sway_coupling")
    assert len(fall.plot().shown) == 2
    assert fall.useless == ()
    assert fall.by_campaign["turned"] == fall.totals


def test_what_cannot_be_begun_says_what_to_do(base, tanks, session):
    with pytest.raises(DataError, match="no campaign"):
        pk.begin(base, {})
    with pytest.raises(DataError, match="complete model"):
        pk.begin("abkowitz3", tanks)
    with pytest.raises(DataError, match="Of no use for captive tests: spread"):
        pk.begin(base, tanks, spread=0.1)
    with pytest.raises(DataError, match="need a name"):
        pk.begin(base, [*tanks.values(), *sailed(SHIP, 0)])
    with pytest.raises(UnknownNameError):
        session.add("no_such_effect")
    with pytest.raises(DataError, match=r"say of which \(turned, straight\)"):
        session.add("fault_misalignment")
    with pytest.raises(DataError, match="'north' cannot have fault_misalignment"):
        session.add("fault_misalignment", campaign="north")
    with pytest.raises(DataError, match="effect of the ship"):
        session.add("memory", campaign="turned")
    with pytest.raises(ModelError, match="has memory already"):
        session.add("memory").add("memory")
    with pytest.raises(ModelError, match="was not named"):
        session.evidence.rival((), ("no_such_effect",))


def test_campaigns_without_names_go_by_their_titles(base, tanks):
    found = pk.begin(base, list(tanks.values())).evidence.order
    assert len(set(found)) == 2


@pytest.mark.slow
def test_records_of_two_basins_are_one_session():
    ship = {"one": sailed(ASYMMETRY, 0), "two": sailed(ASYMMETRY, 5)}
    how = {"candidates": ["asymmetry", "fault_rudder_zero"], "most": 1, "sensors": SENSORS}
    begun = pk.begin(SHIP, ship, **how, spread=0.03)
    assert begun.diagnose().best == ("asymmetry",)
    rival = begun.evidence.rival((), ("asymmetry",))
    assert np.all(np.isfinite(rival.covariance))
    session = begun.add("asymmetry")
    for before, after in session.fall().by_campaign.values():
        assert after < 0.7 * before
    hull = session.model().parts["hull_polynomial"].values
    assert (hull["Y0"], hull["N0"]) == pytest.approx((0.0022, -0.001), rel=0.3)
    again = session.diagnose()
    assert again.verdict == "noise"
    assert "asymmetry" not in {x for item in again.entries for x in item.names}


@pytest.fixture(scope="module")
def both(tmp_path_factory):
    """A tank tests the hull at model scale; the ship sails in a current: a tank and a sea that
    share no code with the package, nor with each other."""
    folder = write(
        Setup(case="current", runs=3, seed=1, ship="s175"), tmp_path_factory.mktemp("sea")
    )
    tests = {
        "tank": hidden_campaign("middle", {"yaw_sway_coupling": 1.0}, seed=3),
        "sea": pk.open_campaign(folder),
    }
    base = without_effect(pk.load_model("s175"), "yaw_sway_coupling")
    return pk.begin(base, tests, candidates=list(FEW), most=2)


@pytest.mark.slow
def test_a_tank_and_the_sea_are_one_session(both):
    """Each measures the coupling by itself, the current is the sea's; what is left turns as the
    ship of the library does, which neither has seen."""
    session = both.add("yaw_sway_coupling").add("current", campaign="sea")
    fall = session.fall()
    assert fall.only("tank").steps == ("base", "yaw_sway_coupling")
    assert fall.steps == ("base", "yaw_sway_coupling", "current (sea)")
    for before, *_, after in fall.by_campaign.values():
        assert after < 0.25 * before
    full, made = (
        pk.simulate(m, "turning", rudder_deg=-35.0, speed=7.0, extrapolate=True).metrics
        for m in ("s175", session.model())
    )
    for name in ("advance", "tactical_diameter"):
        assert made[name] == pytest.approx(full[name], rel=0.005)


@pytest.mark.slow
def test_what_only_the_tank_can_show_is_fitted_beside_what_both_can(both):
    """Nothing is late in these flows: beside the coupling the memory is nothing. Without it, it
    stood for the coupling (nine times as large), and so did the base that the sea was told."""
    session = both.add("yaw_sway_coupling").add("memory").add("current", campaign="sea")
    model, fall = session.model(), session.fall()
    step = next(step for step in model.steps if step.effect == "memory")
    errors = fall.only("tank").totals
    assert (100 * step.error_before, 100 * step.error_after) == pytest.approx(errors[1:])
    values, C = model.values("memory"), model.std
    assert abs(values["Yv_late"]) < 0.001
    assert [x.effect for x in model.steps[1:]] == ["memory", "yaw_sway_coupling", "current"]
    before, *_, after = fall.by_campaign["sea"]
    assert after < 0.5 * before < 2.0
    assert "fault_misalignment" not in model.parts
    assert set(C) >= {"Yvvr", "Nvvr"}


@pytest.mark.slow
def test_what_only_the_tank_can_show_reaches_the_ship(both):
    """Memory is added as the tank measures it; the fall of the records stays that of their base."""
    session = both.add("memory")
    assert session.fall().only("sea").steps == ("base",)
    assert math.isfinite(session.fall().by_campaign["sea"][-1])
    assert any(step.effect == "memory" for step in session.model().steps)


@pytest.mark.slow
def test_runs_of_a_tank_are_held_out(base, tanks):
    """One condition held out is missed by as much as where all are left out in turn."""
    campaign, added = tanks["straight"], "yaw_sway_coupling"
    turned = pk.begin(base, campaign, floor=1e-5).add(added).evidence
    left_out = held_out(*about(turned.system, (added,)))
    for place in (left_out.tests.index("pure_yaw"), left_out.tests.index("yaw_drift")):
        kept = [x.id for x in campaign.runs if left_out.conditions[place] == condition(x)]
        session = pk.begin(base, {"tank": campaign}, test_runs=kept, floor=1e-5).add(added)
        before, after = session.held_out_errors().values()
        errors = dict(zip(left_out.channels, left_out.error[place], strict=True))
        for channel in ("Y", "N"):
            assert after[channel] == pytest.approx(errors[channel], rel=0.02)
    assert after["N"] < 0.5 * before["N"]
    found = session.undo().diagnose()
    assert found.errors["tank"]["held out, with the effects"] == pytest.approx(after, rel=0.05)
    assert found.proposed == (added,)


def test_a_pattern_fits_runs_of_any_campaign(base, tanks):
    with pytest.raises(UnknownNameError, match="No run is called nothing"):
        pk.begin(base, tanks, test_runs=["nothing*"])
