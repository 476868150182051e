"""Numbers in words, tables with units, and text that is safe in HTML, TOML and LaTeX."""

from typing import TYPE_CHECKING

from pmmkit.base import lazy

if TYPE_CHECKING:
    from pmmkit.presentation.escaping import (
        PYTHON_FIRST,
        WIDTH,
        comment,
        content_hash,
        figure_text,
        html_text,
        lines_of,
        matlab_string,
        plain,
        printable,
        quoted,
        safe_cell,
        text_of_cell,
        toml_comment,
        toml_string,
    )
    from pmmkit.presentation.layout import (
        Cell,
        Described,
        Grid,
        Group,
        Picture,
        Section,
        aligned,
        sections_of,
        table_lines,
        text_of,
    )
    from pmmkit.presentation.numbers import (
        ABSENT,
        WIDE,
        Style,
        at_froude,
        counted,
        fixed,
        listed,
        number,
        percent,
        plus_minus,
        with_uncertainty,
    )
    from pmmkit.presentation.vocabulary import letters, meanings, same

__all__ = [
    "ABSENT",
    "PYTHON_FIRST",
    "WIDE",
    "WIDTH",
    "Cell",
    "Described",
    "Grid",
    "Group",
    "Picture",
    "Section",
    "Style",
    "aligned",
    "at_froude",
    "comment",
    "content_hash",
    "counted",
    "figure_text",
    "fixed",
    "html_text",
    "letters",
    "lines_of",
    "listed",
    "matlab_string",
    "meanings",
    "number",
    "percent",
    "plain",
    "plus_minus",
    "printable",
    "quoted",
    "safe_cell",
    "same",
    "sections_of",
    "table_lines",
    "text_of",
    "text_of_cell",
    "toml_comment",
    "toml_string",
    "with_uncertainty",
]

lazy(__name__)
