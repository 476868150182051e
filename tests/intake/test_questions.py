"""What a campaign file still leaves to a person, line by line."""

from __future__ import annotations

import tomllib

import pytest
from small_campaign import write_campaign

from pmmkit.intake import DraftAnswers, questions_of, written
from pmmkit.intake.drafts.draft import draft_of
from pmmkit.intake.drafts.questions import with_answer

SHIP = """[ship]
L = 4.0
xG = 0.1
# mass = ...     # TODO mass as tested [kg]
volume = 0.45
# Izz = ...      # TODO yaw inertia about midship [kg m²]
[water]
rho = 1000.0
"""


def test_every_question_names_the_line_where_it_is_answered(tmp_path):
    write_campaign(tmp_path)
    (tmp_path / "campaign.toml").unlink()
    text = written(draft_of(tmp_path, tmp_path / "campaign.toml")).text
    lines, found = text.splitlines(), questions_of(text)
    asked = {item.key for item in found if item.kind == "needed"}
    assert {x for x in asked if x.startswith("ship.")} == {
        "ship.L", "ship.B", "ship.d", "ship.mass", "ship.Izz",
    }  # fmt: skip
    (density,) = (item for item in found if item.key == "water.rho")
    assert (density.kind, density.guess, density.why) == (
        "guessed",
        "999.1",
        "fresh water of 15 °C",
    )
    for item in found:
        for line in item.lines:
            assert "TODO" in lines[line - 1]
            assert item.key.rpartition(".")[2] in lines[line - 1]
    assert sum(len(item.lines) for item in found) == sum("TODO " in line for line in lines[3:])


def test_a_guess_is_told_by_what_it_comes_from():
    """Mass by density and volume, the inertia of a quarter of the length about midship."""
    inertia, mass = questions_of(SHIP)
    assert (mass.guess, mass.why) == ("450", "density times volume")
    assert float(inertia.guess) == pytest.approx(450 * (1.0 + 0.1**2), rel=1e-3)
    assert (inertia.kind, mass.kind) == ("needed", "off")


def test_a_ship_of_the_library_answers_all_questions_of_the_ship():
    named = SHIP.replace("L = 4.0\nxG = 0.1\n", 'name = "kcs"\n').replace("volume = 0.45\n", "")
    assert questions_of(named) == ()
    unknown = {item.key for item in questions_of(named.replace("kcs", "no-such-ship"))}
    assert unknown == {"ship.mass", "ship.Izz"}


def test_mass_and_volume_are_one_question_that_either_answers(tmp_path):
    write_campaign(tmp_path)
    (tmp_path / "campaign.toml").unlink()
    text = written(draft_of(tmp_path, tmp_path / "campaign.toml")).text
    (mass,) = (item for item in questions_of(text) if item.key == "ship.mass")
    assert not [item for item in questions_of(text) if item.key == "ship.volume"]
    for answer, told in (("450", {"mass": 450}), ("volume = 0,45", {"volume": 0.45})):
        answered = with_answer(text, mass.lines, answer)
        assert tomllib.loads(answered)["ship"] == told
        assert not [x for x in questions_of(answered) if x.key in ("ship.mass", "ship.volume")]


@pytest.mark.parametrize(
    ("answers", "density"),
    [
        ({"ship.name": "kvlcc2"}, 1026.0),
        ({"ship.name": "kvlcc2-l7"}, 999.1),
        ({"ship.L": "320"}, 1026.0),
        ({"ship.L": "320", "water.rho": "1000"}, 1000),
    ],
)
def test_a_ship_that_is_named_afterwards_brings_her_water(answers, density, tmp_path):
    """The sea's for a ship at full scale, that of a tank for a model, unless somebody states it."""
    write_campaign(tmp_path)
    (tmp_path / "campaign.toml").unlink()
    found = DraftAnswers(folder=tmp_path, answers=answers).drafted()
    assert tomllib.loads(found.text)["water"]["rho"] == density


def test_an_answer_is_no_guess_though_the_mark_was_left():
    assert not questions_of('[campaign]\nforces = "balance"   # TODO "balance" if so\n')
    (usual,) = questions_of('[campaign]\nforces = "hydrodynamic"   # TODO "balance" if so\n')
    assert (usual.kind, usual.guess) == ("guessed", '"hydrodynamic"')
    assert not questions_of('[campaign]\nforces = "hydrodynamic"\n')
    assert not questions_of("[ship]\nL = 4.0     # TODO length [m]\n")


def test_the_same_question_about_many_runs_is_one():
    runs = '[[runs]]\nid = "{0}"\n# test = ...   # TODO one of these\n'
    (found,) = questions_of("".join(runs.format(k) for k in range(9)))
    assert found.lines == tuple(range(3, 28, 3))
    assert str(found).startswith("lines 3, 6, 9 and 6 more, runs.test: one of these")


@pytest.mark.parametrize(
    "ship", ['ship = "x"', "[ship]\nvolume = 'much'", "[ship]\nvolume = [1]", "[ship"]
)
def test_a_file_that_says_nonsense_is_asked_all_the_same(ship):
    text = f"{ship}\n[water]\n# rho = ...  # TODO density\n"
    assert [item.key for item in questions_of(text)] == ["water.rho"]


def test_a_line_that_is_off_says_what_holds_instead():
    (found,) = questions_of("[water]\n# g = 9.81   # TODO gravity [m/s2]\n")
    assert (found.kind, found.guess) == ("off", "9.81")
    (centre,) = questions_of("[ship]\n# xG = 0.0   # TODO centre of gravity [m]\n")
    assert (centre.kind, centre.guess) == ("off", "")
    (absent,) = questions_of("[cfd]\n# ramp_s = ...   # TODO start-up\n")
    assert (absent.kind, absent.guess) == ("off", "")
