"""Derivative tables for LaTeX (booktabs)."""

from __future__ import annotations

from pathlib import Path
from typing import Literal

from pmmkit.conventions import CHANNELS
from pmmkit.files import write_text
from pmmkit.models.tables.table import DerivativeTable
from pmmkit.presentation import plus_minus, with_uncertainty

Style = Literal["parentheses", "plus-minus"]


def to_latex(table: DerivativeTable, *, style: Style = "parentheses") -> str:
    """The table as LaTeX text for the package booktabs: a column per Froude number, rows grouped
    by channel. An empty cell is a value that the runs do not determine.
    """
    std = table.std
    heads = [""] if table.pooled else [f"$Fn = {speed:.3f}$" for speed in table.Fn]
    told = plus_minus if style == "plus-minus" else with_uncertainty
    lines = [
        rf"\begin{{tabular}}{{l{'r' * len(heads)}}}",
        r"\toprule",
        " & ".join(["", *heads] if any(heads) else ["", "all speeds"]) + r" \\",
    ]
    for channel in CHANNELS:
        columns = [place for place, name in enumerate(table.names) if name[0] == channel]
        if columns:
            lines.append(r"\midrule")
        for column in columns:
            cells = [
                told(value, spread).replace("±", r"\pm")
                for value, spread in zip(table.value[:, column], std[:, column], strict=True)
            ]
            name = table.convention.latex(table.names[column])
            lines.append(
                " & ".join([f"${name}$", *(f"${cell}$" if cell else "--" for cell in cells)])
                + r" \\"
            )
    return "\n".join([*lines, r"\bottomrule", r"\end{tabular}", ""])


def write_latex(table: DerivativeTable, path: str | Path, *, style: Style = "parentheses") -> None:
    """Write a table as LaTeX text."""
    write_text(path, to_latex(table, style=style))
