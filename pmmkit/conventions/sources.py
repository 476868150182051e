"""Sources that pmmkit quotes, by key: what they are and how far they were seen."""

from __future__ import annotations

import tomllib
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, fields
from functools import cache
from importlib.resources import files
from types import MappingProxyType
from typing import Final, Literal

from pmmkit.base import UnknownNameError, __version__

Known = Literal["read", "quoted", "unseen"]
"""A source that was read; one as public programs or pages quote it; one that was not at hand."""
_OURS: Final = frozenset({"key", "kind", "short", "known"})
_AUTHORS_IN_FULL: Final = 3


@dataclass(frozen=True, kw_only=True)
class Reference:
    """One source.

    `kind`: the kind of entry in BibTeX. `known`: how far it was seen. `author`: ``Family,
    Initials`` each; an institution in braces; last, ``others`` for more. `short`: how it is
    quoted, where that is not by author and year.
    """

    key: str
    kind: str
    known: Known
    author: tuple[str, ...] = ()
    title: str = ""
    year: int | None = None
    journal: str = ""
    booktitle: str = ""
    publisher: str = ""
    institution: str = ""
    school: str = ""
    volume: str = ""
    number: str = ""
    pages: str = ""
    doi: str = ""
    url: str = ""
    note: str = ""
    short: str = ""

    @property
    def families(self) -> tuple[str, ...]:
        """Family names of the authors."""
        return tuple(name.partition(",")[0].strip("{}") for name in self.author)

    @property
    def cited(self) -> str:
        """Authors and year, as in a sentence."""
        if self.short:
            return self.short
        names = self.families
        if len(names) > _AUTHORS_IN_FULL or "others" in names:
            told = f"{names[0]} et al."
        else:
            told = " and ".join((*filter(None, [", ".join(names[:-1])]), names[-1]))
        return f"{told} {self.year}"

    @property
    def bibtex(self) -> str:
        """The entry in BibTeX."""
        told = {
            field.name: getattr(self, field.name)
            for field in fields(self)
            if field.name not in _OURS and getattr(self, field.name)
        }
        if self.author:
            told["author"] = " and ".join(self.author)
        if self.title:  # the second pair of braces keeps capitals
            told["title"] = f"{{{self.title}}}"
        lines = [f"  {name} = {{{_escaped(str(value))}}}," for name, value in told.items()]
        return "\n".join([f"@{self.kind}{{{self.key},", *lines, "}"])


def _escaped(text: str) -> str:
    return text.replace("&", r"\&").replace("%", r"\%")


@cache
def bibliography() -> Mapping[str, Reference]:
    """All sources by key, pmmkit itself first.

    Examples
    --------
    >>> bibliography()["yasukawa_yoshimura_2015"].doi
    '10.1007/s00773-014-0293-y'
    """
    text = files(__package__).joinpath("bibliography.toml").read_text(encoding="utf-8")
    found = {
        key: Reference(key=key, **{**data, "author": tuple(data.get("author", ()))})
        for key, data in tomllib.loads(text).items()
    }
    return MappingProxyType({"pmmkit": _itself(), **found})


def _itself() -> Reference:
    return Reference(
        key="pmmkit",
        kind="misc",
        known="read",
        author=("{The pmmkit developers}",),
        title="pmmkit: from captive ship-model tests to hydrodynamic derivatives and manoeuvres",
        note=f"Version {__version__}",
        short=f"pmmkit {__version__}",
    )


def cite(*keys: str) -> str:
    """Sources as a sentence names them.

    Parameters
    ----------
    *keys : str
        Keys of the bibliography.

    Examples
    --------
    >>> cite("abkowitz_1964", "son_nomoto_1981")
    'Abkowitz 1964; Son and Nomoto 1981'
    >>> cite("kijima_1990"), cite("ittc_7.5-02-06-02")
    ('Kijima et al. 1990', 'ITTC 7.5-02-06-02')
    """
    return "; ".join(_reference(key).cited for key in keys)


def bibtex(keys: Iterable[str]) -> str:
    """Entries in BibTeX, each once, in the order of their keys given.

    Parameters
    ----------
    keys : iterable of str
        Keys of the bibliography.

    Examples
    --------
    >>> print(bibtex(["fossen_2011"]))
    @book{fossen_2011,
      author = {Fossen, T. I.},
      title = {{Handbook of marine craft hydrodynamics and motion control}},
      year = {2011},
      publisher = {Wiley},
      doi = {10.1002/9781119994138},
    }
    <BLANKLINE>
    """
    return "".join(f"{_reference(key).bibtex}\n" for key in dict.fromkeys(keys))


def _reference(key: str) -> Reference:
    known = bibliography()
    if key not in known:
        raise UnknownNameError(f"There is no source {key!r}; there are {', '.join(known)}.")
    return known[key]
