"""Where the texts of a figure stand, and whether they cover each other."""

from __future__ import annotations

import itertools
import math
from collections.abc import Collection

from pmmkit.plotting import Figure
from pmmkit.plotting.layout import laid_out
from pmmkit.plotting.scene import Box, PlacedAxes, Scene


def overlap(a: Box, b: Box) -> bool:
    """Whether two rectangles have a part in common."""
    return a.left < b.right and b.left < a.right and a.top < b.bottom and b.top < a.bottom


def shrunk(box: Box, wide: float, high: float) -> Box:
    """A part of a rectangle about its middle."""
    x, y = (1 - wide) * box.width / 2, (1 - high) * box.height / 2
    return Box(box.left + x, box.top + y, box.right - x, box.bottom - y)


def collisions(figure: Figure) -> list[tuple[str, str]]:
    """Texts that cover each other."""
    boxes = [(own.text, shrunk(own.box, 0.96, 0.8)) for own in laid_out(figure).letters]
    pairs = itertools.combinations(boxes, 2)
    return [(one, other) for (one, a), (other, b) in pairs if overlap(a, b)]


def boxes_at(scene: Scene, frame: PlacedAxes, texts: Collection[tuple[str, float]]) -> list[Box]:
    """Rectangles of some texts of some size on axes or beside them."""
    boxes = [own.box for own in scene.letters if (own.text, own.size) in texts]
    return [box for box in boxes if min(scene.frames, key=lambda own: _away(own.box, box)) is frame]


def _away(axes: Box, text: Box) -> float:
    """How far the middle of a text lies off some axes."""
    x, y = (text.left + text.right) / 2, (text.top + text.bottom) / 2
    return math.hypot(
        max(axes.left - x, 0.0, x - axes.right), max(axes.top - y, 0.0, y - axes.bottom)
    )
