"""Numbers in words, tables with units, and text that is safe in HTML, TOML and LaTeX."""

from typing import TYPE_CHECKING

from pmmkit.base import lazy

if TYPE_CHECKING:
    from pmmkit.presentation.layout import (
        Described,
        Grid,
        Group,
        Picture,
        Section,
        Symbol,
        aligned,
        figure_text,
        printable,
        quoted,
        safe_cell,
        text_of,
        text_of_cell,
    )
    from pmmkit.presentation.numbers import (
        ABSENT,
        WIDE,
        at_froude,
        counted,
        fixed,
        listed,
        number,
        percent,
        plus_minus,
        with_uncertainty,
    )
    from pmmkit.presentation.vocabulary import letters, meanings

__all__ = [
    "ABSENT",
    "WIDE",
    "Described",
    "Grid",
    "Group",
    "Picture",
    "Section",
    "Symbol",
    "aligned",
    "at_froude",
    "counted",
    "figure_text",
    "fixed",
    "letters",
    "listed",
    "meanings",
    "number",
    "percent",
    "plus_minus",
    "printable",
    "quoted",
    "safe_cell",
    "text_of",
    "text_of_cell",
    "with_uncertainty",
]

lazy(__name__)
