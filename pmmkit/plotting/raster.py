"""A figure as PNG or PDF, and the ground of an animation: its shapes as artists of matplotlib."""

from __future__ import annotations

import io
import warnings
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from functools import cache
from typing import TYPE_CHECKING, Any, Final

import matplotlib as mpl
import numpy as np
from matplotlib.figure import Figure as Drawing
from matplotlib.font_manager import FontProperties, fontManager
from matplotlib.patches import PathPatch
from matplotlib.path import Path
from matplotlib.text import Text
from matplotlib.transforms import Affine2D, Bbox, Transform, TransformedBbox

from pmmkit.numerics import Array
from pmmkit.plotting.letters import runs_of
from pmmkit.plotting.marks import OPEN
from pmmkit.plotting.scene import Box, Dots, Fill, Letters, Scene, Shape, Stroke, clip_of
from pmmkit.plotting.vector import DASHED, marker_path

if TYPE_CHECKING:
    from matplotlib.axes import Axes

_LATIN: Final = "DejaVu Sans"
_EASTERN: Final = (
    "Noto Sans CJK JP",
    "Noto Sans CJK SC",
    "Yu Gothic",
    "MS Gothic",
    "Microsoft YaHei",
    "SimHei",
    "Malgun Gothic",
    "Hiragino Sans",
    "Apple SD Gothic Neo",
    "PingFang SC",
    "WenQuanYi Zen Hei",
)
"""Families that hold Japanese, Chinese or Korean names of runs, where one is installed."""
_OF_THE_SESSION: Final = frozenset(
    {
        "animation.ffmpeg_path",
        "backend",
        "backend_fallback",
        "date.epoch",
        "interactive",
        "timezone",
        "toolbar",
    }
)
"""Settings of matplotlib that say where figures are shown and programs lie, not how they look."""


@contextmanager
def plain() -> Iterator[None]:
    """matplotlib's own settings, whatever the user's matplotlibrc says; nothing stays."""
    here, own = mpl.rcParams, mpl.rcParamsDefault
    changed: Any = {
        name: own[name] for name in own if name not in _OF_THE_SESSION and here[name] != own[name]
    }
    with mpl.rc_context(changed), warnings.catch_warnings():
        # a name in a script without a font is drawn as boxes; tables have it in letters
        warnings.filterwarnings("ignore", message="Glyph .* missing from font")
        yield


def png(scene: Scene, dots: float) -> bytes:
    """A picture of so many dots per inch."""
    return _written(scene, format="png", dpi=dots, metadata={"Software": None})


def pdf(scene: Scene) -> bytes:
    """A page of its size."""
    return _written(scene, format="pdf", metadata={"CreationDate": None})


def _written(scene: Scene, **how: Any) -> bytes:
    buffer = io.BytesIO()
    with plain():
        drawn(scene).savefig(buffer, **how)
    return buffer.getvalue()


def drawn(scene: Scene) -> Drawing:
    """All that a figure shows as artists, at its size."""
    drawing = Drawing(figsize=(scene.width / 72, scene.height / 72), facecolor="white")
    place = Affine2D().scale(1 / 72, -1 / 72).translate(0.0, scene.height / 72)
    to_dots = place + drawing.dpi_scale_trans
    for number, shape in enumerate(scene.shapes):
        for artist in _artists(shape, to_dots):
            artist.set_zorder(number)
            drawing.add_artist(artist)
            if (clip := clip_of(shape)) is not None:
                artist.set_clip_box(TransformedBbox(_bounds(clip), to_dots))
    return drawing


def moving_axes(drawing: Drawing, scene: Scene) -> list[Axes]:
    """Axes without a frame over those of a figure, with the same ends: for what moves on them."""
    found = []
    for frame in scene.frames:
        box, wide, high = frame.box, scene.width, scene.height
        place = (box.left / wide, 1.0 - box.bottom / high, box.width / wide, box.height / high)
        axes = drawing.add_axes(place, frameon=False, xlim=frame.x, ylim=frame.y)
        axes.set_axis_off()
        found.append(axes)
    return found


def _bounds(box: Box) -> Bbox:
    return Bbox.from_extents(box.left, box.top, box.right, box.bottom)


def _artists(shape: Shape, place: Transform) -> Iterator[Any]:
    match shape:
        case Stroke():
            dashes = (0, DASHED[shape.dash]) if shape.dash in DASHED else "-"
            yield PathPatch(
                _path([shape.points], closed=False), fill=False, edgecolor=shape.colour,
                linewidth=shape.width, linestyle=dashes, alpha=shape.alpha, transform=place,
                capstyle="butt", joinstyle="round",
            )  # fmt: skip
        case Fill():
            path = _path(shape.rings, closed=True)
            edge = shape.outline or "none"
            yield PathPatch(
                path, facecolor=shape.colour, edgecolor=edge, linewidth=shape.outline_width,
                alpha=shape.alpha, transform=place,
            )  # fmt: skip
            if shape.hatch:
                yield PathPatch(
                    path, fill=False, edgecolor="white", linewidth=0.0, hatch=shape.hatch,
                    transform=place,
                )  # fmt: skip
        case Dots() if len(shape.points):
            rings = shape.points[:, None, :] + marker_path(shape.marker, shape.size / 2)[None]
            stroked = shape.marker in OPEN
            yield PathPatch(
                _path(list(rings), closed=not stroked), facecolor=shape.face or "none",
                edgecolor=shape.edge, linewidth=shape.edge_width, alpha=shape.alpha,
                transform=place, fill=not stroked,
            )  # fmt: skip
        case Letters():
            yield from _texts(shape, place)


def _path(rings: Sequence[Array], *, closed: bool) -> Path:
    """Rings, or lines with gaps at NaN, as one path."""
    points, codes = [], []
    for ring in rings:
        known = np.asarray(np.isfinite(ring).all(axis=1))
        code = np.full(len(ring), Path.LINETO, Path.code_type)
        code[np.concatenate([[True], ~known[:-1]])] = Path.MOVETO
        points.append(ring[known])
        codes.append(code[known])
        if closed:
            points.append(ring[:1])
            codes.append(np.array([Path.CLOSEPOLY], Path.code_type))
    return Path(np.concatenate(points), np.concatenate(codes))


def _texts(shape: Letters, place: Transform) -> Iterator[Text]:
    """A text for each run, one behind the other."""
    runs = runs_of(shape.text)
    alone = len(runs) == 1  # stands exactly where it is to, whatever its letters become
    box, along = shape.box, 0.0
    for run in runs:
        up = run.rise * shape.size
        if alone:
            x, y = shape.x, shape.y
        elif shape.turned:
            x, y = shape.x - up, box.bottom - along
        else:
            x, y = box.left + along, shape.y - up
        yield Text(
            x, y, run.text.replace("$", r"\$"), transform=place, color=shape.colour,
            va="baseline", ha=shape.across if alone else "left",
            rotation=90.0 if shape.turned else 0.0, rotation_mode="anchor",
            fontproperties=FontProperties(
                family=_families(), size=run.scale * shape.size,
                style="italic" if run.italic else "normal",
                weight="bold" if shape.bold else "normal",
            ),
        )  # fmt: skip
        along += run.width * shape.size


@cache
def _families() -> list[str]:
    """The family of all figures, and those that have the letters which it lacks."""
    there = {font.name for font in fontManager.ttflist}
    return [_LATIN, *(name for name in _EASTERN if name in there)]
