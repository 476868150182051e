"""What a test report holds: chapters of stated items and of sections, and what nobody supplied."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, Final

from pmmkit.campaigns import Campaign, TypeB
from pmmkit.conventions import CHANNEL_UNITS
from pmmkit.effects import Parameter
from pmmkit.models import SECTIONS
from pmmkit.presentation import Described, Grid, Group, Section, counted, number
from pmmkit.views.report.tables import particulars_of

NOT_SUPPLIED: Final = "not supplied"
"""What stands where the campaign says nothing."""


@dataclass(frozen=True, kw_only=True)
class Item:
    """Something that a report states.

    `what`: what it is, with its unit in brackets. `value`: what is stated; None where the
    campaign does not say it. `table, key`: where the campaign file takes it; empty where it
    follows from the runs.

    Examples
    --------
    >>> item = Item(what="Customer", value=None, table="report", key="customer")
    >>> print(f"{item.text}: {item.supply}")
    not supplied: [report] customer
    """

    what: str
    value: str | None
    table: str = ""
    key: str = ""

    @property
    def supply(self) -> str:
        """Table and key as they stand in a campaign file."""
        return f"[{self.table}] {self.key}".rstrip() if self.table else ""

    @property
    def text(self) -> str:
        """What is printed."""
        return NOT_SUPPLIED if self.value is None else self.value


@dataclass(frozen=True, kw_only=True)
class Chapter:
    """A chapter: what is stated, then sections of sentences, tables and figures.

    `title`: its title, without a number. `sections`: what follows; the first may have no title.
    `appendix`: whether it stands behind the numbered chapters, under a letter.
    """

    title: str
    items: Sequence[Item] = ()
    sections: Sequence[Section] = ()
    appendix: bool = False


@dataclass(frozen=True, kw_only=True, repr=False)
class Document(Described):
    """A test report, as data.

    `items`: of the cover: number, customer, laboratory, authors …. `basis`: by which procedure
    it is ordered, and what that does not say. `chapters`: in the order of the report,
    appendices last.

    Examples
    --------
    >>> report = Document(
    ...     title="Drift tests", subtitle="Model 7", basis=["Ordered as agreed."],
    ...     items=[Item(what="Customer", value=None, table="report", key="customer")],
    ...     chapters=[Chapter(title="Facility"), Chapter(title="Runs", appendix=True)])
    >>> [(mark, chapter.title) for mark, chapter in report.numbered]
    [('1', 'Facility'), ('2', 'What was not supplied'), ('A', 'Runs')]
    >>> report
    <Document Drift tests: 3 chapters, 1 item not supplied>
    """

    title: str
    subtitle: str
    items: Sequence[Item]
    basis: Sequence[str]
    chapters: Sequence[Chapter]

    @property
    def numbered(self) -> list[tuple[str, Chapter]]:
        """All chapters with their numbers or letters; last but the appendices what is missing."""
        main = [chapter for chapter in self.chapters if not chapter.appendix]
        rest = [chapter for chapter in self.chapters if chapter.appendix]
        marks = [str(number) for number in range(1, len(main) + 2)]
        letters = [chr(ord("A") + number) for number in range(len(rest))]
        return list(zip([*marks, *letters], [*main, self._lacks, *rest], strict=True))

    @property
    def missing(self) -> list[tuple[str, Item]]:
        """What the campaign does not say, with the title of the place where it is printed."""
        places = [("Cover", self.items), *((x.title, x.items) for x in self.chapters)]
        return [(title, item) for title, items in places for item in items if item.value is None]

    @property
    def _lacks(self) -> Chapter:
        """The list of what was not supplied, and how each is."""
        missing = self.missing
        if not missing:
            told = Section(paragraphs=["Every item of this report was supplied."])
            return Chapter(title="What was not supplied", sections=[told])
        places = dict.fromkeys(title for title, _ in missing)
        groups = [
            Group(
                title=place,
                rows=[[item.what, item.supply] for title, item in missing if title == place],
            )
            for place in places
        ]
        told = Section(
            paragraphs=[
                f"{counted(len(missing), 'item').capitalize()} of this report "
                f"{'was' if len(missing) == 1 else 'were'} not supplied. Each is taken from "
                f"the campaign file; write it there under the key named, and make the report anew."
            ],
            tables=[Grid(head=["Item", "Key of campaign.toml"], groups=groups, texts=(0, 1))],
        )
        return Chapter(title="What was not supplied", sections=[told])

    def _headline(self) -> str:
        lacks = counted(len(self.missing), "item")
        return f"{self.title}: {counted(len(self.numbered), 'chapter')}, {lacks} not supplied"

    def _sections(self) -> Sequence[Section]:
        chapters = [f"{mark} {chapter.title}" for mark, chapter in self.numbered]
        keys: dict[str, list[str]] = {}
        for place, item in self.missing:
            keys.setdefault(place, []).append(item.supply)
        lacks = [f"{place}: {', '.join(own)}" for place, own in keys.items()]
        return [
            Section(paragraphs=[self.subtitle, *self.basis]),
            Section(title="Chapters", points=chapters),
            *([Section(title="Not supplied", points=lacks)] if lacks else []),
        ]


def untitled(section: Section) -> Section:
    """A section that stands under the title of its chapter."""
    return replace(section, title="")


# What a campaign file states, item by item, and where it takes what it does not state.


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
            what=f"{what} [{unit}]",
            value=None if value is None else number(value, DIGITS),
            table=table,
            key=key,
        )
        for what, value, unit, where, key in particulars_of(campaign.ship, campaign.water)
        if where == table
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
    return f"{known[key].text.replace('`', '')} [{_unit(known[key].unit) or '–'}]"


def of_gauges(campaign: Campaign) -> list[Item]:
    """Each gauge with its make, capacity and calibration."""
    from pmmkit.campaigns import CampaignFile

    gauges: Mapping[str, Mapping[str, Any]] = campaign.report.get("gauges", {})
    stated = CampaignFile.keys_of("report.gauges")
    fields = {key: item.description or key for key, item in stated.items()}
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
    if campaign.computed:
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


def _label(text: str) -> str:
    return text[:1].upper() + text[1:]


def _text(value: Any) -> str | None:
    """What is stated as text; None where nothing is."""
    if value is None or value == "" or value == []:
        return None
    if isinstance(value, float | int) and not isinstance(value, bool):
        return number(value, DIGITS)
    return ", ".join(map(str, value)) if isinstance(value, list | tuple) else str(value)
