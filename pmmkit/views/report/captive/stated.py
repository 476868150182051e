"""What a campaign file states, item by item, and where it takes what it does not state."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

from pmmkit.campaigns import Campaign, TypeB
from pmmkit.conventions import CHANNEL_UNITS
from pmmkit.effects import Parameter
from pmmkit.models import SECTIONS
from pmmkit.presentation import number
from pmmkit.views.report.captive.document import Item
from pmmkit.views.report.tables import particulars_of

DIGITS = 6


def of_report(campaign: Campaign, *keys: str) -> list[Item]:
    """Items of ``[report]``, labelled as its schema describes them.

    Examples
    --------
    >>> from pmmkit.conventions import Ship, Water
    >>> ship = Ship(name="m", L=4.0, B=1.0, d=.25, volume=.5, mass=500., Izz=500.)
    >>> tests = Campaign(title="", ship=ship, water=Water(), runs=(), report={"customer": "Yard"})
    >>> for item in of_report(tests, "customer", "facility"):
    ...     print(f"{item.what}: {item.text}")
    Customer: Yard
    Tank or basin: not supplied
    """
    from pmmkit.campaigns import CampaignFile

    fields = CampaignFile.keys_of("report")
    return [
        Item(
            what=_label(fields[key].description or key),
            value=_text(campaign.report.get(key)),
            table="report",
            key=key,
        )
        for key in keys
    ]


def of_particulars(campaign: Campaign, table: str) -> list[Item]:
    """Items of ``[ship]`` or of ``[water]``."""
    return [
        Item(
            what=f"{item.what} [{item.unit}]",
            value=None if item.value is None else number(item.value, DIGITS),
            table=item.table,
            key=item.key,
        )
        for item in particulars_of(campaign.ship, campaign.water)
        if item.table == table
    ]


def of_part(campaign: Campaign, section: str) -> list[Item]:
    """What is stated of the propeller or of the rudder, in words and numbers."""
    stated: Mapping[str, Any] = getattr(campaign, section)
    fitted = of_report(campaign, f"{section}_fitted")
    if not stated and campaign.report.get(f"{section}_fitted"):
        return fitted
    can = SECTIONS[section]
    known = can.numbers
    rows = [
        Item(
            what=f"{section.capitalize()}: {_particular(key, known)}",
            value=_text(value),
            table=section,
            key=key,
        )
        for key, value in stated.items()
        if key in known or key in can.words
    ]
    return [
        *fitted,
        *(rows or [Item(what=f"{section.capitalize()}: particulars", value=None, table=section)]),
    ]


def _particular(key: str, known: Mapping[str, Parameter]) -> str:
    if key not in known:
        return key.replace("_", " ")
    return f"{_unquoted(known[key].text)} [{_unit(known[key].unit) or '–'}]"


def of_gauges(campaign: Campaign) -> list[Item]:
    """Each gauge with its make, capacity and calibration."""
    from pmmkit.campaigns import CampaignFile

    gauges: Mapping[str, Mapping[str, Any]] = campaign.report.get("gauges", {})
    fields = {
        key: item.description or key for key, item in CampaignFile.keys_of("report.gauges").items()
    }
    if not gauges:
        what, keys = ", ".join(fields.values()), ", ".join(fields)
        return [Item(what=f"Gauges: {what}", value=None, table="report.gauges.NAME", key=keys)]
    return [
        Item(
            what=f"Gauge {name}: {what}",
            value=_text(stated.get(key)),
            table=f"report.gauges.{name}",
            key=key,
        )
        for name, stated in gauges.items()
        for key, what in fields.items()
    ]


def of_uncertainties(campaign: Campaign, channels: Sequence[str]) -> list[Item]:
    """Stated standard uncertainties, and those of gauges, water, rig and settings not stated."""
    settings = [run.settings for run in campaign.runs]
    items = []
    for kind in TypeB.STATABLE.values():
        if kind.of == "gauge" and kind.channel not in channels:
            continue
        if kind.of == "setting" and not any(getattr(each, kind.name, None) for each in settings):
            continue
        stated = [item for item in campaign.uncertainty if item.name == kind.name]
        told = [
            (
                f"{number(100 * item.std)} %"
                if item.relative
                else f"{number(_shown(item.std, kind.unit))} {_unit(kind.unit)}"
            )
            + (", the same in all runs" if item.shared else ", anew in each run")
            for item in stated
        ]
        items.append(
            Item(
                what=f"Standard uncertainty: {kind.title}",
                value="; ".join(told) or None,
                table="uncertainty",
                key=kind.key,
            )
        )
    if campaign.cfd or campaign.numerical:
        items += [
            Item(
                what=f"Numerical standard uncertainty U_SN of {channel} [{CHANNEL_UNITS[channel]}]",
                value=_text(campaign.numerical.get(channel)),
                table="cfd",
                key=f"U_SN.{channel}",
            )
            for channel in channels
        ]
    return items


def _shown(value: float, unit: str) -> float:
    return math.degrees(value) if unit == "deg" else value


def _unit(unit: str) -> str:
    """A unit with its powers set high."""
    return unit.translate({ord("2"): "²", ord("3"): "³"})


def _unquoted(text: str) -> str:
    return text.replace("`", "")


def _label(text: str) -> str:
    return text[:1].upper() + text[1:]


def _text(value: Any) -> str | None:
    """What is stated as text; None where nothing is."""
    if value is None or value == "" or value == []:
        return None
    if isinstance(value, float | int) and not isinstance(value, bool):
        return number(value, DIGITS)
    return ", ".join(map(str, value)) if isinstance(value, list | tuple) else str(value)
