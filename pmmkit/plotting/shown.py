"""Figures that a notebook shows where they are the last word of a cell."""

from __future__ import annotations

import io
from typing import Final

from matplotlib.figure import Figure

DOTS: Final = 130
"""Dots per inch in a notebook."""


class Shown(Figure):
    """A figure that shows itself in a notebook.

    Notebooks know by themselves only figures of pyplot, whose state is global.
    """

    def _repr_png_(self) -> bytes:
        buffer = io.BytesIO()
        self.savefig(buffer, format="png", dpi=DOTS)
        return buffer.getvalue()
