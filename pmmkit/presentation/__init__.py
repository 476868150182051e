"""How results are told: numbers, tables, and objects that tell their own state."""

from pmmkit.presentation.described import Described, sections_of
from pmmkit.presentation.layout import (
    Cell,
    Grid,
    Group,
    Picture,
    Section,
    aligned,
    section_lines,
    table_lines,
    text_of,
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

__all__ = [
    "ABSENT",
    "WIDE",
    "Cell",
    "Described",
    "Grid",
    "Group",
    "Picture",
    "Section",
    "aligned",
    "at_froude",
    "counted",
    "fixed",
    "listed",
    "number",
    "percent",
    "plus_minus",
    "section_lines",
    "sections_of",
    "table_lines",
    "text_of",
    "with_uncertainty",
]
