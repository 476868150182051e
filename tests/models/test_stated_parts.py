"""What a campaign file may state of propeller and rudder, and what is refused with which words."""

from __future__ import annotations

import pytest

from pmmkit import open_campaign
from pmmkit.base import CampaignError
from pmmkit.intake import examine
from pmmkit.models import SECTIONS

SHIP = '[campaign]\n[ship]\nname = "kvlcc2-l7"\n[water]\nrho = 1000.0\n'
RUN = '[[runs]]\nid = "a"\ntest = "static_drift"\nfile = "a.csv"\nspeed = 1.0\ndrift_deg = 4.0\n'


def refusal(tmp_path, text):
    (tmp_path / "a.csv").write_text("t,X,Y,N\n0,0,1,2\n1,0,1,2\n2,0,1,2\n")
    (tmp_path / "campaign.toml").write_text(SHIP + text + RUN)
    with pytest.raises(CampaignError) as caught:
        open_campaign(tmp_path)
    return str(caught.value)


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("[propeller]\ndiametr = 0.2\n", "key 'diametr': is not known"),
        ("[rudder]\nare = 0.05\n", "did you mean 'area'"),
        ("[propeller]\nD = -0.2\n", "must be at least 1e-06 m, it is -0.2"),
        ("[propeller]\nt = 1.9\n", "must be at most 0.99, it is 1.9"),
        ('[propeller]\nD = "0.2 m"\n', "must be a number, it is '0.2 m'"),
        ("[rudder]\nrate_deg_s = true\n", "must be a number, it is True"),
        ('[propeller]\npropulsion_point = "towed"\n', "must be model or ship"),
        ("[propeller]\nopen_water = 3\n", "must be a table or the name of a file"),
        ("[propeller]\nopen_water = { J = [0.0, inf], KT = [1.0, 1.0] }\n", "it is inf"),
        ("[propeller]\n", "states nothing. Write what is known, such as D (diameter) [m]"),
        ("[rudder]\n", "or take the section away"),
    ],
)
def test_what_is_wrong_is_said_with_the_key(tmp_path, text, says):
    assert says in refusal(tmp_path, text)


def test_names_of_the_geometry_are_not_those_of_the_effect():
    for section in SECTIONS.values():
        values = {item.name for item in section.effect.parameters}
        assert values.isdisjoint(item.name for item in section.geometry)


def test_everything_that_the_effects_take_can_be_stated():
    for section in SECTIONS.values():
        parameters = section.effect.parameters
        stated = {item.name: max(item.low, min(0.5, item.high)) for item in parameters}
        assert list(section.problems(stated)) == []


@pytest.mark.slow
def test_an_open_water_table_that_is_not_there_is_told(tmp_path):
    (tmp_path / "a.csv").write_text("t,X,Y,N\n" + "".join(f"{i},0,1,2\n" for i in range(50)))
    text = SHIP + '[propeller]\nD = 0.2\nopen_water = "curve.csv"\n' + RUN
    (tmp_path / "campaign.toml").write_text(text)
    found = [item for item in examine(open_campaign(tmp_path)) if item.check == "open water"]
    assert ["curve.csv" in item.message for item in found] == [True]
