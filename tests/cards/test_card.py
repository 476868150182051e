"""The card of a ship: what a person fills in, what is said of slips, and the card of a model."""

from __future__ import annotations

import math
import tomllib
from dataclasses import replace

import pytest

import pmmkit as pk
from pmmkit.cards import Card, empty_card, read_card

PARTICULARS = """
[card]
speed = "15.5 kn"
[ship]
name = "tanker"
L = 320.0
B = 58.0
d = 20.8
CB = 0.81
"""


@pytest.fixture
def reads(tmp_path):
    """Read a card of the particulars above and what stands below them."""

    def read(text, particulars=PARTICULARS):
        file = tmp_path / "card.toml"
        file.write_text(particulars + text, encoding="utf-8")
        return read_card(file)

    return read


def only(card):
    """The single measure of a card."""
    ((measure,),) = (test.measures for test in card.tests)
    return measure


@pytest.mark.parametrize(
    ("written", "lengths"),
    [
        ('"3.2 L"', 3.2),
        ('"3.2 ship lengths"', 3.2),
        ('"1024 m"', 3.2),
        ('"5 cables"', 926.0 / 320.0),
        ('"0.5 nm"', 926.0 / 320.0),
        ('"3359.58 ft"', 3.2),
    ],
)
def test_a_length_has_the_unit_that_the_poster_has(reads, written, lengths):
    found = only(reads(f"[[turning]]\nadvance = {written}\n"))
    assert found.name == "advance_L"
    assert found.value == pytest.approx(lengths, rel=1e-4)


@pytest.mark.parametrize(
    ("line", "name", "value"),
    [
        ("overshoot_1_deg = 7.5", "overshoot_1_deg", 7.5),
        ('overshoot_2_deg = "7.5°"', "overshoot_2_deg", 7.5),
        ('overshoot_1_deg = "0.1 rad"', "overshoot_1_deg", math.degrees(0.1)),
    ],
)
def test_an_angle_is_in_degrees_unless_it_says_so(reads, line, name, value):
    found = only(reads(f"[[zigzag]]\n{line}\n"))
    assert (found.name, found.value) == (name, pytest.approx(value))


@pytest.mark.parametrize(
    ("line", "name", "value"),
    [
        ('steady_radius = "1.5 L"', "steady_diameter_L", 3.0),
        ("speed_loss = 0.6", "speed_ratio", 0.4),
        ('speed_loss = "60 %"', "speed_ratio", 0.4),
        ('advance_L = "3.1"', "advance_L", 3.1),
        ("advance_L = 3.1", "advance_L", 3.1),
        ('time_90 = "3 min"', "time_90", 180.0),
    ],
)
def test_other_words_for_a_measure(reads, line, name, value):
    found = only(reads(f"[[turning]]\n{line}\n"))
    assert (found.name, found.value) == (name, pytest.approx(value))


@pytest.mark.parametrize("sign", ["±", "+-", "+/-"])
def test_what_stands_after_the_sign_is_half_of_the_interval_of_95_percent(reads, sign):
    found = only(reads(f'[[turning]]\nadvance = "1000 {sign} 64 m"\n'))
    assert 1.959964 * found.std == pytest.approx(0.2, rel=1e-4)


def test_the_tolerance_of_a_speed_loss_is_that_of_the_speed(reads):
    found = only(reads('[[turning]]\nspeed_loss = "60 ± 6 %"\n'))
    assert 1.959964 * found.std == pytest.approx(0.06, rel=1e-4)


def test_sides_and_speeds(reads):
    card = reads(
        '[[turning]]\nside = "port"\nspeed = "Fn 0.1"\nadvance = "3 L"\n'
        '[[turning]]\nadvance = "3 L"\n'
        "[[zigzag]]\nrudder_deg = -20\nswitch_deg = 20\novershoot_3_deg = 12\n"
    )
    first, second, third = card.tests
    assert first.settings["rudder_deg"] == -35.0
    assert first.speed == pytest.approx(0.1 * math.sqrt(9.81 * 320.0))
    assert (second.settings["rudder_deg"], second.speed) == (35.0, pytest.approx(7.9739, abs=1e-4))
    assert third.words.startswith("zigzag 20/20, to port")
    assert third.ordered["executes"] == 4, "the third overshoot ends with the fourth order"


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("[[turning]]\nadvance = 3.2\n", 'Write "3.2 L" for ship lengths, "640 m"'),
        ('[[turning]]\nadvance = "3.2 s"\n', "'s' is no length"),
        ('[[turning]]\nadvance = "3,2 L"\n', "with a point for decimals"),
        ('[[turning]]\nadvance = "990 L"\n', "ships have 1 to 12"),
        ('[[turning]]\nadvance = "3.2 m"\n', "is 0.01 L; ships have 1 to 12"),
        ('[[turning]]\nadvence = "3.2 L"\n', "did you mean 'advance'?"),
        ('[[turnign]]\nadvance = "3.2 L"\n', "did you mean 'turning'?"),
        ('[[turning]]\nside = "left"\nadvance = "3.2 L"\n', "'left' is port or starboard"),
        (
            '[[turning]]\nside = "starboard"\nrudder_deg = -35\nadvance = "3.2 L"\n',
            "Write the angle without its sign",
        ),
        (
            '[[turning]]\ntransfer = "4.4 L"\ntactical_diameter = "3 L"\n',
            "transfer 4.4 is more than tactical diameter 3 L: no ship does so",
        ),
        (
            '[[turning]]\nadvance = "3.2 L"\n[[turning]]\ntransfer = "1.5 L"\n',
            "stands twice. Put its measures into one table",
        ),
        ('[[turning]]\nadvance = "3 L"\nadvance_L = "3.1"\n', "a measure stands twice"),
        ("[[zigzag]]\novershoot_1_deg = -5\n", "ships have 0 to 90"),
        ("[[zigzag]]\novershoot_1_deg = true\n", "True cannot be read"),
        ('[[zigzag]]\nrudder_deg = "ten"\novershoot_1_deg = 5\n', "must be a number"),
        ('[[turning]]\nspeed = "fast"\nadvance = "3 L"\n', "'fast' is no speed"),
        ('[[turning]]\nspeed = "99 m/s"\nadvance = "3 L"\n', "is Fn 1.8"),
        ('turning = "3 L"\n', "Write [[turning]] on a line of its own"),
        ("", "the card: has no measure"),
        ("[water]\ndepth = 30.0\n[[zigzag]]\novershoot_1_deg = 5\n", "of deep water"),
        ("[propeller]\nd = 9.9\n[[zigzag]]\novershoot_1_deg = 5\n", "did you mean 'D'?"),
    ],
)
def test_a_slip_is_told_with_what_to_write(reads, text, said):
    particulars = PARTICULARS
    if text.startswith("turning"):
        particulars, text = text + PARTICULARS, ""
    with pytest.raises(pk.PmmkitError) as raised:
        reads(text, particulars)
    assert said in str(raised.value).replace("\n", " ")


@pytest.mark.parametrize(
    ("ship", "said"),
    [
        ("L = 320.0\nB = 58.0\n", "d, CB (or volume or mass) are missing"),
        ("L = 320.0\nB = 58.0\nd = 20.8\nmass = 320415.0\n", "a tonne is 1000 kg"),
        ("L = 58.0\nB = 320.0\nd = 20.8\nCB = 0.81\n", "L is the longest"),
        ("L = 320.0\nB = 58.0\nd = 20.8\nCB = 81.0\n", "CB"),
    ],
)
def test_particulars_that_are_no_ships(reads, ship, said):
    text = f'[card]\nspeed = "15 kn"\n[ship]\nname = "x"\n{ship}'
    with pytest.raises(pk.PmmkitError) as raised:
        reads('[[turning]]\nadvance = "3 L"\n', text)
    assert said in str(raised.value)


def test_all_slips_of_a_card_are_told_at_once(reads):
    with pytest.raises(pk.PmmkitError) as raised:
        reads('[[turning]]\nadvance = 3\ntransfer = "x"\n[[zigzga]]\n')
    assert str(raised.value).count("card.toml, ") == 3


def test_slips_of_manoeuvres_are_told_beside_those_of_the_particulars(reads):
    text = '[card]\nspeed = "Fn 0.15"\n[ship]\nL = "320 m"\nB = 58.0\nd = 20.8\nCB = 0.81\n'
    with pytest.raises(pk.PmmkitError) as raised:
        reads('[[turning]]\nadvance = "990 m"\ntransfer = 2\ndepth = 30\n', text)
    told = str(raised.value)
    assert "3 problems" in told
    assert "must be a number, it is '320 m'" in told
    assert "turning has no depth" in told


def test_the_empty_card_is_a_card_once_it_is_filled_in(tmp_path):
    text = empty_card()
    for key, value in {"L": 320, "B": 58, "d": 20.8, "CB": 0.81}.items():
        text = text.replace(f'\n{key} = ""', f"\n{key} = {value}")
    text = text.replace('speed = ""', 'speed = "15.5 kn"', 1).replace(
        'tactical_diameter = ""', 'tactical_diameter = "3.0 L"', 1
    )
    file = tmp_path / "card.toml"
    file.write_text(text, encoding="utf-8")
    assert only(read_card(file)).name == "tactical_diameter_L"


def test_the_empty_card_asks_for_what_poster_and_standard_show():
    content = tomllib.loads(empty_card())
    sides = [(test["rudder_deg"], test["side"]) for test in content["turning"]]
    assert sides == [(35, "starboard"), (35, "port")]
    assert {test["rudder_deg"] for test in content["zigzag"]} == {10, 20}
    assert {"track_reach", "turns", "reversal_s"} <= content["stopping"][0].keys()


def test_a_library_ship_needs_her_name_alone(reads):
    text = '[card]\nspeed = "24 kn"\n[ship]\nname = "kcs"\n[[turning]]\nadvance = "3 L"\n'
    assert reads("", text).ship.L == 230.0


def test_the_card_of_a_model_shows_what_she_does_and_is_read_back(tmp_path):
    card = Card.of("esso190k", 8.23)
    turn = pk.simulate("esso190k", "turning", rudder_deg=-35, speed=8.23)
    port = next(test for test in card.tests if test.words.startswith("turning 35°, to port"))
    shown = {item.name: item.value for item in port.measures}
    assert shown["advance_L"] == pytest.approx(turn.metrics["advance_L"])
    file = tmp_path / "card.toml"
    file.write_text(card.text(), encoding="utf-8")
    back = read_card(file)
    assert back.ship == replace(card.ship, block_stated=None, zG=None, GM=None, Ixx=None)
    assert [test.words for test in back.tests] == [test.words for test in card.tests]
    for one, two in zip(card.tests, back.tests, strict=True):
        for mine, theirs in zip(one.measures, two.measures, strict=True):
            assert theirs.value == pytest.approx(mine.value, abs=0.06 * mine.std)
            assert theirs.std == pytest.approx(mine.std, rel=0.06)
