"""A figure as it stands in a report: drawn, with its caption and what is seen in words."""

from __future__ import annotations

import io
from collections.abc import Iterable
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Final

from pmmkit.plotting import styled, svg
from pmmkit.presentation import Picture
from pmmkit.views.figures.captions import seen

if TYPE_CHECKING:
    from matplotlib.figure import Figure

DOTS: Final = 170
"""Dots per inch of a figure where SVG is not taken."""


@dataclass(frozen=True, kw_only=True)
class PictureWithData(Picture):
    """A figure with what it was drawn from, for documents that take no SVG."""

    figure: Figure = field(repr=False, compare=False)

    def png(self) -> bytes:
        """The figure as PNG."""
        buffer = io.BytesIO()
        with styled():
            self.figure.savefig(buffer, format="png", dpi=DOTS, metadata={"Software": None})
        return buffer.getvalue()


def drawn(
    figure: Figure, caption: str, *, facts: Iterable[str] = (), narrow: bool = False, file: str = ""
) -> PictureWithData:
    """A figure with its caption, and an alternative text from what it holds."""
    alt = " ".join([*facts, seen(figure)]) or caption
    return PictureWithData(
        svg=svg(figure), caption=caption, narrow=narrow, alt=alt, file=file, figure=figure
    )
