"""Runs and campaigns: reading them, saving them, and what is known of each test."""

from typing import TYPE_CHECKING

from pmmkit.base import lazy

if TYPE_CHECKING:
    from pmmkit.campaigns.day import places_in_day, seconds_of, timed
    from pmmkit.campaigns.figures import left_by_the_fit
    from pmmkit.campaigns.file.campaign_file import FILE_NAME, PACKED, campaign_of, open_campaign
    from pmmkit.campaigns.file.faults import Faults
    from pmmkit.campaigns.file.packed import is_packed_campaign
    from pmmkit.campaigns.file.report_entry import GaugeEntry, ReportEntry
    from pmmkit.campaigns.file.rewriting import with_columns, with_correction, without_correction
    from pmmkit.campaigns.file.schema import TABLES, read_entry
    from pmmkit.campaigns.file.single_tables import ImoEntry
    from pmmkit.campaigns.motion.counted import (
        FITTED,
        Counted,
        counted_cycles,
        counted_window,
        travel_of,
        whole_series,
    )
    from pmmkit.campaigns.motion.hull_path import (
        half_window,
        in_ship_axes,
        over_ground,
        true_wind,
        velocity,
    )
    from pmmkit.campaigns.motion.inertia import (
        Rig,
        as_read,
        force_of_water,
        inertia_force,
        inertia_inside,
        moments_of_sway,
        rig_of,
    )
    from pmmkit.campaigns.motion.kinematics import displacement_phase, measured_motion, move_motion
    from pmmkit.campaigns.motion.nominal import (
        beside_motion,
        has_nominal,
        motion_at_phase,
        nominal_motion,
        require_settings,
    )
    from pmmkit.campaigns.open_water_test import open_water, with_open_water
    from pmmkit.campaigns.reach import FARTHEST, out_of_reach, within_reach
    from pmmkit.campaigns.repeated_runs import repeats
    from pmmkit.campaigns.run import FORCES, Campaign, Correction, Run
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
    from pmmkit.campaigns.samples.column_mapping import pick, required_channels
    from pmmkit.campaigns.samples.conversions import TURNED, Frame
    from pmmkit.campaigns.samples.corrections import OF_SAMPLES
    from pmmkit.campaigns.samples.loading import (
        DOUBTFUL,
        HistoryLoader,
        bring,
        data_files,
        file_hashes,
        requests_of,
    )
    from pmmkit.campaigns.segments import (
        GAP,
        HEADING_JUMP,
        Cut,
        fresh_samples,
        heading_jumps,
        jump_limit,
        position_jumps,
        stop_at_end,
        usable,
        without_jumps,
    )
    from pmmkit.campaigns.setting import RunSetting, Sensor
    from pmmkit.campaigns.settings import Settings
    from pmmkit.campaigns.several import by_title, sailing
    from pmmkit.campaigns.store import load_campaign, save_campaign
    from pmmkit.campaigns.test_kinds.free_running import PULL_OUT, STOPPING, TURNING, ZIGZAG
    from pmmkit.campaigns.test_kinds.kind import (
        MAY_BE_ZERO,
        RUDDER,
        SWAY,
        YAW,
        KindFit,
        NominalMotion,
        TestKind,
        ship_axes,
    )
    from pmmkit.campaigns.test_kinds.oscillating import (
        HARMONIC_RUDDER,
        PURE_SWAY,
        PURE_YAW,
        YAW_DRIFT,
    )
    from pmmkit.campaigns.test_kinds.registry import TEST_KINDS, captive_kinds, held_too, kind_with
    from pmmkit.campaigns.test_kinds.steady import (
        DRIFT_RUDDER,
        RESISTANCE,
        STATIC_DRIFT,
        STATIC_HEEL,
        STATIC_RUDDER,
    )
    from pmmkit.campaigns.test_kinds.struts import Struts
    from pmmkit.campaigns.uncertainty import STATABLE, TypeB
    from pmmkit.campaigns.water_depth import by_depth, depths, in_words, one_depth

__all__ = [
    "DOUBTFUL",
    "DRIFT_RUDDER",
    "FARTHEST",
    "FILE_NAME",
    "FITTED",
    "FORCES",
    "GAP",
    "HARMONIC_RUDDER",
    "HEADING_JUMP",
    "MAY_BE_ZERO",
    "OF_SAMPLES",
    "OURS",
    "PACKED",
    "PULL_OUT",
    "PURE_SWAY",
    "PURE_YAW",
    "RESISTANCE",
    "RUDDER",
    "RUN_SETTINGS",
    "STATABLE",
    "STATIC_DRIFT",
    "STATIC_HEEL",
    "STATIC_RUDDER",
    "STOPPING",
    "SWAY",
    "TABLES",
    "TEST_KINDS",
    "TURNED",
    "TURNING",
    "YAW",
    "YAW_DRIFT",
    "ZIGZAG",
    "Campaign",
    "Correction",
    "Counted",
    "Cut",
    "Faults",
    "Frame",
    "GaugeEntry",
    "HistoryLoader",
    "ImoEntry",
    "KindFit",
    "NominalMotion",
    "ReportEntry",
    "Rig",
    "Run",
    "RunSetting",
    "Sensor",
    "Settings",
    "Struts",
    "TestKind",
    "TypeB",
    "as_read",
    "beside_motion",
    "bring",
    "brought",
    "by_depth",
    "by_title",
    "campaign_of",
    "captive_kinds",
    "counted_cycles",
    "counted_window",
    "data_files",
    "depths",
    "displacement_phase",
    "file_hashes",
    "force_of_water",
    "fresh_samples",
    "half_window",
    "has_nominal",
    "heading_jumps",
    "held_too",
    "in_ship_axes",
    "in_words",
    "inertia_force",
    "inertia_inside",
    "is_packed_campaign",
    "jump_limit",
    "kind_with",
    "left_by_the_fit",
    "load_campaign",
    "measured_motion",
    "moments_of_sway",
    "motion_at_phase",
    "move_motion",
    "names_taken_unasked",
    "nominal_motion",
    "one_depth",
    "open_campaign",
    "open_water",
    "out_of_reach",
    "over_ground",
    "pick",
    "places_in_day",
    "position_jumps",
    "read_entry",
    "repeats",
    "requests_of",
    "require_settings",
    "required_channels",
    "rig_of",
    "sailing",
    "save_campaign",
    "seconds_of",
    "setting_key",
    "setting_units",
    "settings_by_key",
    "ship_axes",
    "stop_at_end",
    "timed",
    "travel_of",
    "true_wind",
    "unit_of",
    "usable",
    "velocity",
    "ways_to_state",
    "whole_series",
    "with_columns",
    "with_correction",
    "with_open_water",
    "within_reach",
    "without_correction",
    "without_jumps",
]

lazy(__name__)
