"""Figures as they stand in reports, with what they show in words, for those who do not see it."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING

from pmmkit.presentation import Picture

if TYPE_CHECKING:
    from pmmkit.plotting import Figure


def drawn(
    figure: Figure, caption: str, *, facts: Iterable[str] = (), narrow: bool = False, file: str = ""
) -> Picture:
    """A figure with its caption, and an alternative text from what it holds."""
    alt = " ".join([*facts, figure.in_words()]) or caption
    return Picture(figure=figure, caption=caption, narrow=narrow, alt=alt, file=file)
