"""The sections of the site: the list of pages in docs/index.md, and what the program adds to it."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Final

ROOT: Final = Path(__file__).parents[3]
HEADING: Final = "\n## Where to read on\n"
LINK: Final = re.compile(r"\[([^\]]+)\]\((?!https?:)([^)#]+\.(?:md|rst))\)")


@dataclass(frozen=True, kw_only=True)
class Section:
    """A section of the site.

    Parameters
    ----------
    title : str
        Its heading.
    text : str
        The list of its pages with what each is, in Markdown.
    """

    title: str
    text: str

    @property
    def name(self) -> str:
        """Name of its page."""
        return re.sub(r"\W+", "-", self.title.lower())

    @property
    def pages(self) -> tuple[str, ...]:
        """Pages that the list links to, from the root of the repository, each once."""
        return tuple(dict.fromkeys(target for _, target in LINK.findall(self.text)))

    def with_pages(self, lines: Sequence[str]) -> Section:
        """The section with more lines in its list."""
        return Section(title=self.title, text="\n".join([self.text, *lines]))

    @property
    def page(self) -> str:
        """The page of the section."""
        return f"# {self.title}\n\n{self.text}\n\n{toctree(self.pages)}"


def sections(listing: str) -> dict[str, Section]:
    """The sections of the site by name, as docs/index.md lists their pages, from its own folder.

    Examples
    --------
    >>> listing = "\\n## Where to read on\\n\\n### How to\\n\\n- [Turn](turn.md), [us](../us.md)\\n"
    >>> sections(listing)["how-to"].pages
    ('docs/turn.md', 'us.md')
    """
    _, _, listed = listing.partition(HEADING)
    listed = LINK.sub(r"[\1](docs/\2)", listed).replace("(docs/../", "(")
    _, *parts = re.split(r"^### ", listed, flags=re.M)
    found = []
    for part in parts:
        title, _, rest = part.partition("\n")
        items = re.findall(r"^(?:- .*|  .*)$", rest, re.M)
        found.append(Section(title=title, text="\n".join(items)))
    return {section.name: section for section in found}


def toctree(pages: Iterable[str], titles: Mapping[str, str] | None = None) -> str:
    """A hidden table of contents, which puts pages into the navigation."""
    told = titles or {}
    lines = [f"{told[page]} <{page}>" if page in told else page for page in pages]
    return "\n".join(["```{toctree}", ":hidden:", "", *lines, "```", ""])


def index(readme: str, names: Sequence[str], cards: str) -> str:
    """The first page: the README, with pictures above its licence."""
    before, mark, licence = readme.rpartition("\n\nLicence")
    return f"{before}\n\n## Gallery\n\n{cards}{mark}{licence.rstrip()}\n\n{toctree(names)}"
