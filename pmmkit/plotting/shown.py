"""Figures that a notebook shows where they are the last word of a cell, and what draws them."""

from __future__ import annotations

import io
from typing import Any, Final

from matplotlib.backends import backend_svg
from matplotlib.backends.backend_svg import FigureCanvasSVG
from matplotlib.figure import Figure
from matplotlib.ticker import ScalarFormatter

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


class Measured(FigureCanvasSVG):
    """A canvas whose layout measures with the renderer that draws, which so parses formulas once.

    file: what the renderer writes to. dots: dots per inch of what is no line.
    """

    def __init__(self, figure: Figure, file: io.StringIO, dots: float) -> None:
        super().__init__(figure)
        untyped: Any = backend_svg
        width, height = figure.get_size_inches()
        size = width * self.fixed_dpi, height * self.fixed_dpi
        lines = untyped.RendererSVG(*size, file, image_dpi=dots, metadata={"Date": None})
        self._renderer = untyped.MixedModeRenderer(figure, width, height, dots, lines)

    def get_renderer(self) -> Any:
        """What layout asks a canvas for."""
        return self._renderer


class Powers(ScalarFormatter):
    """Numbers as plain text, since formulas take long to draw, and their power of ten as one."""

    def get_offset(self) -> str:
        """The power of ten, as a formula."""
        self.set_useMathText(True)
        power = super().get_offset()
        self.set_useMathText(False)
        return power
