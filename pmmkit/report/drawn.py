"""A figure as it stands in a report: drawn, with its caption and what is seen in words."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING

from pmmkit.figures import svg
from pmmkit.plotting.seen import seen
from pmmkit.presentation import Picture

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def drawn(
    figure: Figure, caption: str, *, facts: Iterable[str] = (), narrow: bool = False, file: str = ""
) -> Picture:
    """A figure with its caption, and an alternative text from what it holds.

    Parameters
    ----------
    figure : Figure
        What is shown.
    caption : str
        The line below it.
    facts : iterable of str
        Sentences on what it says, from the numbers behind it; they stand first.
    narrow : bool
        Whether it needs but half of the width.
    file : str
        Name of the file in which it stands beside the page too.
    """
    alt = " ".join([*facts, seen(figure)])
    return Picture(svg=svg(figure), caption=caption, narrow=narrow, alt=alt or caption, file=file)
