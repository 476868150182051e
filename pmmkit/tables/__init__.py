"""Derivative tables: what a reduction gives and a model takes."""

from pmmkit.tables.compare import Deviation, compare, identical, worst_deviation
from pmmkit.tables.convert import converted, to_system
from pmmkit.tables.interpolate import interpolate
from pmmkit.tables.io import is_table, read_table, to_latex, write_table
from pmmkit.tables.table import DerivativeTable, from_values

__all__ = [
    "DerivativeTable",
    "Deviation",
    "compare",
    "converted",
    "from_values",
    "identical",
    "interpolate",
    "is_table",
    "read_table",
    "to_latex",
    "to_system",
    "worst_deviation",
    "write_table",
]
