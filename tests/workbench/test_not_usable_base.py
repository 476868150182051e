"""The page opens on tests that give no ship, and says so beside each number of it."""

from __future__ import annotations

import pytest

import pmmkit as pk
from pmmkit.actions import action
from pmmkit.reduction import reduce_campaign
from pmmkit.views import page_of
from pmmkit.workbench import WorkbenchState
from pmmkit.workbench.desk import command_lines
from pmmkit.workbench.saved import model_file
from pmmkit.workbench.tasks import Tasks, Work
from tests.support.small_campaign import write_campaign

ODD = "PS_U1_a0.3"


@pytest.mark.slow
def test_a_base_by_force_is_marked_wherever_the_page_sails_it(tmp_path):
    folder = write_campaign(tmp_path / "tests", hundredfold=ODD)
    place = tmp_path / "page"
    place.mkdir()
    work = Work(folder=place, campaigns=(str(folder),))
    Tasks().open(work, "abkowitz3", None, tell=lambda *_: None)
    base = pk.load_model(model_file(place, ()))
    assert ODD in base.not_usable
    (made, *_) = command_lines(WorkbenchState(campaign=str(folder), model=""), place, action)
    assert "--force" in made["line"]
    page = page_of(base, "turning", speed=1.5, rudder_deg=35.0)
    assert base.not_usable in page["unsettled"]
    assert {item["passed"] for item in page["verdicts"]} == {None}
    told = page_of(reduce_campaign(pk.open_campaign(folder), executor=1))
    assert told["use"] == "not usable"
    assert any(ODD in text for text in told["reasons"])
