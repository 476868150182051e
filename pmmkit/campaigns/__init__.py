"""Runs and campaigns: reading them, saving them, and what is known of each test."""

from typing import TYPE_CHECKING

from pmmkit.base import lazy

if TYPE_CHECKING:
    from pmmkit.campaigns.campaign import Campaign
    from pmmkit.campaigns.file.campaign_file import campaign_of, open_campaign
    from pmmkit.campaigns.file.rewriting import CampaignFile
    from pmmkit.campaigns.motion.counted import Counted, TankRecord
    from pmmkit.campaigns.motion.hull_path import Attitude
    from pmmkit.campaigns.motion.inertia import Rig
    from pmmkit.campaigns.run import Run
    from pmmkit.campaigns.run_settings import RUN_SETTINGS, unit_of
    from pmmkit.campaigns.samples.conversions import Frame
    from pmmkit.campaigns.samples.loading import read_columns
    from pmmkit.campaigns.segments import Cut, Fixes, usable
    from pmmkit.campaigns.setting import RunSetting, Sensor
    from pmmkit.campaigns.settings import Settings
    from pmmkit.campaigns.stated_run import Correction
    from pmmkit.campaigns.store import load_campaign, save_campaign
    from pmmkit.campaigns.test_kinds.kind import TEST_KINDS, TestKind
    from pmmkit.campaigns.uncertainty import TypeB

__all__ = [
    "RUN_SETTINGS",
    "TEST_KINDS",
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
    "campaign_of",
    "load_campaign",
    "open_campaign",
    "read_columns",
    "save_campaign",
    "unit_of",
    "usable",
]

lazy(__name__)
