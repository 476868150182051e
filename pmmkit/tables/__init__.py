"""Derivative tables: what a reduction gives and a model takes."""

from pmmkit.tables.table import DerivativeTable, from_values

__all__ = ["DerivativeTable", "from_values"]
