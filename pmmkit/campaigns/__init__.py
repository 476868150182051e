"""Runs and campaigns: reading them, saving them, and what is known of each test."""

from typing import TYPE_CHECKING

from pmmkit.base import lazy

if TYPE_CHECKING:
    from pmmkit.campaigns.campaign import Campaign, by_title
    from pmmkit.campaigns.file.campaign_file import campaign_of, open_campaign
    from pmmkit.campaigns.file.packed import is_packed_campaign
    from pmmkit.campaigns.file.rewriting import CampaignFile
    from pmmkit.campaigns.file.schema import keys_of, read_table
    from pmmkit.campaigns.motion.counted import Counted, TankRecord
    from pmmkit.campaigns.motion.hull_path import Attitude
    from pmmkit.campaigns.motion.inertia import Rig
    from pmmkit.campaigns.repeated_runs import repeats
    from pmmkit.campaigns.run import Run, bring
    from pmmkit.campaigns.run_settings import (
        OURS,
        RUN_SETTINGS,
        brought,
        names_taken_unasked,
        setting_key,
        setting_units,
        settings_by_key,
        unit_of,
        ways_to_state,
    )
    from pmmkit.campaigns.samples.conversions import Frame
    from pmmkit.campaigns.samples.loading import read_columns
    from pmmkit.campaigns.segments import Cut, Fixes, usable
    from pmmkit.campaigns.setting import RunSetting, Sensor
    from pmmkit.campaigns.settings import Settings
    from pmmkit.campaigns.stated_run import Correction
    from pmmkit.campaigns.store import load_campaign, save_campaign
    from pmmkit.campaigns.test_kinds.free_running import STOPPING, TURNING, ZIGZAG
    from pmmkit.campaigns.test_kinds.kind import TestKind
    from pmmkit.campaigns.test_kinds.registry import TEST_KINDS
    from pmmkit.campaigns.uncertainty import TypeB

__all__ = [
    "OURS",
    "RUN_SETTINGS",
    "STOPPING",
    "TEST_KINDS",
    "TURNING",
    "ZIGZAG",
    "Attitude",
    "Campaign",
    "CampaignFile",
    "Correction",
    "Counted",
    "Cut",
    "Fixes",
    "Frame",
    "Rig",
    "Run",
    "RunSetting",
    "Sensor",
    "Settings",
    "TankRecord",
    "TestKind",
    "TypeB",
    "bring",
    "brought",
    "by_title",
    "campaign_of",
    "is_packed_campaign",
    "keys_of",
    "load_campaign",
    "names_taken_unasked",
    "open_campaign",
    "read_columns",
    "read_table",
    "repeats",
    "save_campaign",
    "setting_key",
    "setting_units",
    "settings_by_key",
    "unit_of",
    "usable",
    "ways_to_state",
]

lazy(__name__)
