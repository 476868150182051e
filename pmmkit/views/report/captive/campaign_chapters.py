"""The chapters on the tests themselves: technique, model, tank, carriage, gauges, runs."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from itertools import pairwise
from statistics import median

from pmmkit.campaigns import RUN_SETTINGS, TEST_KINDS, Campaign, Run, RunSetting, Settings
from pmmkit.conventions import CHANNEL_UNITS
from pmmkit.models import SECTIONS
from pmmkit.presentation import Grid, Group, Section, counted, number, plus_minus
from pmmkit.reduction import Reduction, RunResult
from pmmkit.views.figures.captions import drawn
from pmmkit.views.report import tables
from pmmkit.views.report.captive.document import (
    Chapter,
    Item,
    of_gauges,
    of_part,
    of_particulars,
    of_report,
)


def technique(reduction: Reduction) -> Chapter:
    """What was tested and why, and in which axes it is told."""
    campaign = reduction.campaign
    return Chapter(
        title="Experimental technique",
        items=[
            *of_report(campaign, "purpose"),
            Item(what="Kinds of test", value=_kinds(campaign)),
            Item(what="Forces as recorded", value=campaign.forces_in_words),
        ],
        sections=[
            Section(
                title="Axes and signs",
                paragraphs=[
                    "Ship axes: x forward, y to starboard, z down, origin midship; N positive bow "
                    "to starboard. The drift angle β is positive with the bow to starboard of the "
                    "track; a positive rudder angle turns the ship to starboard. What was "
                    "recorded otherwise has been converted. Numbers are those of the model."
                ],
            )
        ],
    )


def _kinds(campaign: Campaign) -> str:
    count = {kind.title: len(campaign.select(kind.name).runs) for kind in TEST_KINDS.values()}
    return ", ".join(f"{title} ({counted(n, 'run')})" for title, n in count.items() if n)


def ship_model(reduction: Reduction) -> Chapter:
    """Particulars, scale, appendages, turbulence stimulation, loading, inertia."""
    campaign = reduction.campaign
    ship = campaign.ship
    hung = [
        (ship.balance_mass, "Mass on the balance [kg]"),
        (ship.balance_xG, "Its centre of gravity forward of midship [m]"),
        (ship.balance_Izz, "Its yaw inertia about midship [kg m²]"),
    ]
    gyration = math.sqrt(ship.Izz / ship.mass) / ship.L
    return Chapter(
        title="Ship model",
        items=[
            Item(what="Ship", value=ship.name or None, table="ship", key="name"),
            *of_report(campaign, "model_number", "scale", "model_material", "model_made"),
            *of_report(campaign, "hull_lines"),
            *of_particulars(campaign, "ship"),
            *(Item(what=what, value=number(value, 6)) for value, what in hung if value is not None),
            Item(what="Radius of gyration of yaw about midship, over L", value=f"{gyration:.4f}"),
            *of_report(campaign, "draught_forward", "draught_aft", "wetted_surface"),
            *of_report(campaign, "appendages", "turbulence_stimulation", "loading"),
            *of_report(campaign, "inertia_found"),
            *(item for section in SECTIONS for item in of_part(campaign, section)),
        ],
    )


def facility(reduction: Reduction) -> Chapter:
    """The tank and its water."""
    campaign = reduction.campaign
    return Chapter(
        title="Facility",
        items=[
            *of_report(campaign, "facility", "tank_length"),
            *of_particulars(campaign, "water"),
            *of_report(campaign, "water_temperature", "bottom", "wave_absorption"),
        ],
    )


def mount(reduction: Reduction) -> Chapter:
    """The carriage, what moves the model, and what the mount leaves free."""
    campaign = reduction.campaign
    motions = [
        ("Point of the moments, forward of midship", campaign.moment_reference_x),
        ("Point of the moments, below the origin", campaign.moment_reference_z),
        ("Point of the motions, forward of midship", campaign.motion_reference_x),
    ]
    return Chapter(
        title="Carriage and mount",
        items=[
            *of_report(campaign, "carriage", "speed_regulation", "mechanism", "mount"),
            Item(
                what="Motions that the mount leaves free",
                value=", ".join(campaign.free) or None,
                table="campaign",
                key="free",
            ),
            *(Item(what=f"{what} [m]", value=number(x)) for what, x in motions),
        ],
    )


def measured(reduction: Reduction) -> Chapter:
    """What was recorded, by which gauges, how often."""
    campaign = reduction.campaign
    return Chapter(
        title="Measured data",
        items=[
            Item(what="Data as", value=_data(campaign)),
            *of_gauges(campaign),
            *_check_loads(campaign),
            *of_report(campaign, "acquisition"),
            *_rate(reduction),
            *of_report(campaign, "analogue_filter"),
        ],
        sections=[Section(title="Channels of the runs", tables=[_channels(reduction.runs)])],
    )


def _check_loads(campaign: Campaign) -> list[Item]:
    """What known weights on the balance said of each gauge, with 95 % intervals."""
    return [
        Item(
            what=f"Check loads on {item.channel}: reading over load",
            value=f"{plus_minus(item.gain, item.half)} "
            f"({counted(len(item.runs), 'load')}, up to {number(item.largest)} "
            f"{CHANNEL_UNITS[item.channel]})",
        )
        for item in campaign.gauge_checks
    ]


def _data(campaign: Campaign) -> str:
    words = {"history": "time histories", "means": "means", "harmonics": "harmonics"}
    found = [words[kind] for kind in words if any(run.kind == kind for run in campaign.runs)]
    return ", ".join(found)


def _rate(reduction: Reduction) -> list[Item]:
    """Samples a second: those of the records, else what is stated."""
    rates = [
        (item.samples - 1) / item.duration
        for item in reduction.runs
        if item.run.kind == "history" and item.duration > 0
    ]
    (stated,) = of_report(reduction.campaign, "sample_rate")
    read = [Item(what="Samples a second in the files read [Hz]", value=_range(rates))]
    return [stated, *(read if rates else [])]


def _channels(runs: Sequence[RunResult]) -> Grid:
    """The channels that the reduction took, with the number of their runs."""
    names = dict.fromkeys(name for item in runs for name in (*item.measured, *item.extras))
    rows = [
        [
            name,
            CHANNEL_UNITS[name],
            str(sum(name in item.measured or name in item.extras for item in runs)),
        ]
        for name in names
    ]
    return Grid(head=["Channel", "Unit", "Runs"], groups=[Group(rows=rows)], texts=(1,))


def programme(reduction: Reduction) -> Chapter:
    """How many runs of each kind at which speeds, and what they were set to."""
    return Chapter(
        title="Test programme",
        sections=[
            Section(
                tables=[tables.runs(reduction), _settings(reduction.campaign)],
                figures=[
                    drawn(reduction.campaign.plot(), "Tests by Froude number; numbers are runs.")
                ],
            )
        ],
    )


def _set_to(settings: Settings, item: RunSetting) -> float | None:
    """What a run is set to, as a report tells it; a circle by its rate, which may not be zero."""
    if item.told and item.told.shown:
        return settings.value(item.told.shown) or None
    value = settings.value(item.name)
    return None if value is None else item.to_file(value)


def _settings(campaign: Campaign) -> Grid:
    """The range of each setting, a row a kind of test; settings that no run has are left out."""
    headed = sorted((x for x in RUN_SETTINGS.values() if x.head), key=lambda x: x.place)
    kept = [item for item in headed if any(_set_to(run.settings, item) for run in campaign.runs)]
    rows: list[list[str | None]] = []
    for kind in TEST_KINDS.values():
        runs = campaign.select(kind.name).runs
        if runs:
            values = ([_set_to(run.settings, item) for run in runs] for item in kept)
            rows.append([kind.title, *(_range(x for x in own if x is not None) for own in values)])
    return Grid(
        head=["Test", *(f"{x.head} [{'°' if x.angle else x.unit}]" for x in kept)],
        groups=[Group(rows=rows)],
        caption="What the runs were set to, from the lowest to the highest.",
    )


def _range(values: Iterable[float]) -> str | None:
    found = sorted(values)
    if not found or not any(found):
        return "0" if found else None
    low, high = number(found[0]), number(found[-1])
    return low if low == high else f"{low} … {high}"


def procedure(reduction: Reduction) -> Chapter:
    """Waiting time, zeros, order, repeats, what counts of the records, what was left out."""
    campaign = reduction.campaign
    return Chapter(
        title="Procedure",
        items=[
            *of_report(campaign, "waiting_time"),
            _starts(campaign.runs),
            *of_report(campaign, "run_order", "zero_readings", "revolutions"),
            *of_report(campaign, "friction_correction"),
            Item(what="Runs used", value=str(len(reduction.runs))),
            Item(what="Runs left out", value=str(len(campaign.excluded))),
            *_counts(reduction.runs),
            *of_report(campaign, "inspection"),
        ],
        sections=[
            Section(title=title, tables=grids)
            for title, grids in (
                ("Runs left out", tables.left_out(campaign)),
                ("Corrections", tables.corrections(campaign)),
            )
            if grids
        ],
    )


def _starts(runs: Sequence[Run]) -> Item:
    """From the start of a run to that of the next, where their starts are known."""
    starts = sorted(run.start for run in runs if run.start is not None)
    gaps = [later - earlier for earlier, later in pairwise(starts)]
    return Item(
        what="Time from start to start [s]",
        value=f"{min(gaps):.0f} at least, median {median(gaps):.0f}" if gaps else None,
        table="[runs]",
        key="started",
    )


def _counts(runs: Sequence[RunResult]) -> list[Item]:
    """What counts of the records: seconds of steady ones, cycles of oscillating ones."""
    steady = [x.duration for x in runs if not x.run.dynamic and math.isfinite(x.duration)]
    cycles = [float(x.cycles) for x in runs if x.cycles]
    entries = (("Steady record that counts [s]", steady), ("Cycles that count", cycles))
    return [Item(what=what, value=_range(own)) for what, own in entries if own]
