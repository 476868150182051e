"""What people look at: each function gives a matplotlib Figure and changes nothing global."""

from pmmkit.figures.derivatives import beside_reference, derivatives_over_froude
from pmmkit.figures.style import save, svg

__all__ = ["beside_reference", "derivatives_over_froude", "save", "svg"]
