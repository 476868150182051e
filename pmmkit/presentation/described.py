"""Objects that tell their own state: one line, a report, and the same in a notebook."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence
from typing import Final

from pmmkit.escaping import printable
from pmmkit.presentation.layout import Section, section_html, text_of

LONGEST: Final = 110
"""Characters of a `repr`."""


class Described(ABC):
    """An object with a `repr` of one line, a `str` that reports, and HTML for notebooks.

    A class says what it is in `_headline`, and everything else in `_sections`. A dataclass needs
    ``repr=False``, or it writes a `repr` of its own with every sample in it.

    Examples
    --------
    >>> class Mass(Described):
    ...     def _headline(self):
    ...         return "12 kg"
    ...     def _sections(self):
    ...         return [Section(title="Weighed", paragraphs=["on <a> balance"])]
    >>> Mass()
    <Mass 12 kg>
    >>> print(Mass())
    Mass 12 kg
    <BLANKLINE>
    Weighed
      on <a> balance
    >>> Mass()._repr_html_()
    '<div><p>Mass 12 kg</p><p><strong>Weighed</strong></p><p>on &lt;a&gt; balance</p></div>'
    """

    @abstractmethod
    def _headline(self) -> str:
        """What it is and its size, on one line, without the name of the class."""

    @abstractmethod
    def _sections(self) -> Sequence[Section]:
        """What it says of itself, in sections."""

    def _title(self) -> str:
        return " ".join(printable(f"{type(self).__name__} {self._headline()}").split())

    def __repr__(self) -> str:
        line = self._title()
        return f"<{line}>" if len(line) <= LONGEST else f"<{line[: LONGEST - 1]}…>"

    def __str__(self) -> str:
        return text_of([Section(paragraphs=[self._title()]), *self._sections()])

    def _repr_html_(self) -> str:
        title = section_html(Section(paragraphs=[self._title()]))
        return f"<div>{title}{''.join(map(section_html, self._sections()))}</div>"


def sections_of(thing: Described) -> Sequence[Section]:
    """What an object says of itself, in sections.

    Parameters
    ----------
    thing : Described
        Its `str` begins with a title and goes on with these.
    """
    return thing._sections()
