"""What a test report holds: chapters of stated items and of sections, and what nobody supplied."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Final

from pmmkit.presentation import Described, Grid, Group, Section, counted

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
