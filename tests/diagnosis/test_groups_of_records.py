"""Records that disagree with the others: a group is told beside a name, or in its place."""

from __future__ import annotations

import pytest

import pmmkit as pk
from pmmkit.campaigns import Run
from pmmkit.diagnosis.free_running.diagnose import diagnose_free
from pmmkit.diagnosis.free_running.disagreement import run_of
from pmmkit.diagnosis.free_running.question import records_of
from pmmkit.models import load_model
from tests.support.free_tank.campaigns import Setup, write

SHIP = load_model("kvlcc2-l7")


def recorded(case, folder, seed=3):
    """Turns and zigzags of a tanker that another program sails: three of each."""
    home = write(Setup(case=case, seed=seed, ship="kvlcc2-l7"), folder)
    return list(records_of(pk.open_campaign(home), SHIP))


@pytest.mark.slow
def test_zigzags_with_another_zero_of_the_rudder_flag_the_name(tmp_path):
    """The rudder's zero is off in the zigzags alone: no effect of the ship is in all records."""
    sound, slipped = recorded("none", tmp_path), recorded("rudder_zero", tmp_path)
    found = diagnose_free(SHIP, [*sound[:3], *slipped[3:]], most=1)
    (told,) = found.disagreements
    assert (told.channel, told.group, len(told.runs)) == ("N", "in zigzag", 3)
    assert found.flags[:2] == ("not_the_whole_story", str(told))
    assert str(told) in str(found)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("case", "verdict"), [("none", "noise"), ("rudder_zero", "missing_effect")]
)
def test_records_of_one_ship_say_nothing_of_groups(tmp_path, case, verdict):
    found = diagnose_free(SHIP, recorded(case, tmp_path, seed=1), most=1)
    assert (found.verdict, found.disagreements, found.flags) == (verdict, (), ())


@pytest.mark.slow
def test_records_are_grouped_by_what_their_rudder_did(tmp_path):
    records = recorded("none", tmp_path)
    groups = Run.groups([run_of(item) for item in records], range(len(records)))
    turning = {item.name for item in records if item.name.startswith("turning")}
    starboard = {item.name for item in records if "_+" in item.name}
    assert groups["in turning"] == turning
    assert groups["turned to starboard first"] == starboard
