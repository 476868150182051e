"""Settings of a run: each keeps the contract, and what the rest of pmmkit asks of it is there."""

from __future__ import annotations

from dataclasses import fields, replace

import pytest

from pmmkit.base import UnknownNameError
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
