"""Settings of a run: each keeps the contract, and what the rest of pmmkit asks of it is there."""

from __future__ import annotations

from dataclasses import fields, replace

import pytest

from pmmkit import open_campaign
from pmmkit.base import CampaignError, UnknownNameError
from pmmkit.campaigns import RUN_SETTINGS, Settings, unit_of
from pmmkit.campaigns.file.schema import SettingsEntry
from pmmkit.campaigns.setting import Bounds
from pmmkit.testing.test_kinds import check_run_setting


@pytest.mark.parametrize("name", RUN_SETTINGS.own)
def test_every_setting_keeps_the_contract(name):
    RUN_SETTINGS.check(RUN_SETTINGS[name])


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"key": "drift"}, "is in degrees and does not end in _deg"),
        ({"unit": "m"}, "is not in degrees and ends in _deg"),
        ({"name": "Drift"}, "'Drift' is not of small letters"),
        ({"unit": "furlong", "key": "drift"}, "its unit 'furlong' is not known"),
        ({"meaning": ""}, "what its key means is not said"),
        ({"word": ""}, "it has no word"),
        ({"states": ("nothing",)}, "it states nothing, which is no setting"),
        ({"header": "("}, "is no regular expression"),
        ({"in_names": (("b", 1.0),)}, "has no # for the number"),
        ({"bounds": Bounds(most=1.0)}, "is not within its bounds"),
        ({"key": "rudder_deg"}, "its key is that of rudder"),
    ],
)
def test_a_setting_that_is_wrong_is_told(change, said):
    with pytest.raises(AssertionError, match=said):
        check_run_setting(replace(RUN_SETTINGS["drift"], **change))


def test_settings_have_a_field_each_and_a_file_has_all_keys():
    beside = {"strut_spacing", "strut_centre", "repeat_of", "further"}
    own = {item.name for item in RUN_SETTINGS.own.values() if item.kept}
    brought = {item.name for item in RUN_SETTINGS.brought}
    assert {item.name for item in fields(Settings)} == own - brought | beside
    assert list(SettingsEntry.model_fields) == [*RUN_SETTINGS.units, "repeat_of"]


def test_a_setting_that_nobody_has_is_an_error():
    with pytest.raises(UnknownNameError, match="no setting 'yaw_ampltude'; did you mean"):
        Settings(speed=1.0).value("yaw_ampltude")
    with pytest.raises(UnknownNameError):
        Settings.of({"speed": 1.0, "trim": 0.1})


def test_settings_by_name_are_those_of_the_fields():
    given = {"speed": 1.5, "drift": 0.1, "strut_spacing": 2.0, "repeat_of": "a"}
    assert Settings.of(given) == Settings(**given)
    assert Settings(**given).with_("drift", 0.2) == Settings(**{**given, "drift": 0.2})
    assert Settings.of(Settings(**given).plain()) == Settings(**given)


def test_units_of_columns_and_ways_to_state():
    assert unit_of("drift_deg", table=True) == "deg"
    assert unit_of("drift_deg", table=False) is None
    assert RUN_SETTINGS.ways_to_state("yaw_amplitude") == {
        *("yaw_amplitude_deg", "path_amplitude_m", "strut_amplitude_m"),
        *("r_amplitude", "rdot_amplitude"),
    }
    assert not {item.name for item in RUN_SETTINGS.brought} & {x.name for x in fields(Settings)}


@pytest.mark.parametrize(
    ("key", "value", "words"),
    [
        (
            "speed",
            "1170.0",
            "is 1170 m/s, and tests have 0.01 to 50 m/s; write 1.17 if it is in mm/s",
        ),
        ("speed", "1e-5", "is 1e-05 m/s, and tests have 0.01 to 50 m/s."),
        ("period", "9044.0", "write 9.044 if it is in ms"),
        ("period", "1e-300", "is 1e-300 s, and tests have 0.05 to 600 s."),
    ],
)
def test_a_number_that_no_test_has_is_refused_with_the_unit_that_fits(key, value, words, tmp_path):
    stated = {"speed": "1.2", "period": "9.0", "amplitude_m": "0.25", key: value}
    settings = "\n".join(f"{name} = {number}" for name, number in stated.items())
    (tmp_path / "campaign.toml").write_text(
        "[ship]\nL = 3000.0\nB = 0.5\nd = 0.2\nvolume = 0.24\nIzz = 135.0\n[water]\nrho = 1000.0\n"
        f'[[runs]]\nid = "a"\ntest = "pure_sway"\nfile = "a.csv"\n{settings}\n',
        encoding="utf-8",
    )
    with pytest.raises(CampaignError) as raised:
        open_campaign(tmp_path / "campaign.toml")
    assert words in str(raised.value)
    assert "key 'L': is 3000 m, and tests have 0.5 to 500 m; write 3 if" in str(raised.value)


def test_an_id_that_would_write_to_a_terminal_is_refused(tmp_path):
    (tmp_path / "campaign.toml").write_text(
        "[ship]\nL = 3.0\nB = 0.5\nd = 0.2\nvolume = 0.24\nIzz = 135.0\n[water]\nrho = 1000.0\n"
        '[[runs]]\nid = "a\\u001b[2J"\ntest = "static_drift"\nfile = "a.csv"\nspeed = 1.0\n',
        encoding="utf-8",
    )
    with pytest.raises(CampaignError, match="a sign that would control a terminal"):
        open_campaign(tmp_path / "campaign.toml")
