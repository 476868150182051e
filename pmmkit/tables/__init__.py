"""Derivative tables: what a reduction gives and a model takes."""

from pmmkit.tables.compare import identical
from pmmkit.tables.io import read_table, to_latex, write
from pmmkit.tables.table import DerivativeTable, from_values

__all__ = ["DerivativeTable", "from_values", "identical", "read_table", "to_latex", "write"]
