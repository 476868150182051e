"""A figure as SVG: letters stay letters, and nothing is drawn twice."""

from __future__ import annotations

import zlib
from collections.abc import Iterable, Iterator
from dataclasses import replace
from itertools import groupby
from typing import Final
from xml.sax.saxutils import escape, quoteattr

import numpy as np

from pmmkit.numerics import Array, stretches
from pmmkit.plotting.letters import runs_of
from pmmkit.plotting.marks import OPEN
from pmmkit.plotting.scene import Box, Dots, Fill, Letters, Scene, Shape, Stroke, clip_of

FAMILY: Final = "'DejaVu Sans', Verdana, 'Noto Sans', 'Noto Sans CJK JP', sans-serif"
"""Families of letters; the first two are as wide as what is reckoned with."""
PROLOG: Final = '<?xml version="1.0" encoding="utf-8"?>\n'
DASHED: Final = {"--": (3.7, 1.6), "-.": (6.4, 1.6, 1.0, 1.6), ":": (1.0, 1.65)}
"""Lengths of dashes and gaps, over the width of the line."""
_NEAR, _PASSES = 0.02, 6
"""How far a point may lie off the line between its neighbours to be left out [pt], so many times:
together less than a sixth of a hair line."""
_FEW: Final = 30
"""Points of a line that are not worth it."""
_HATCHES: Final = {
    "///": "M-1 1L1 -1M0 6L6 0M5 7L7 5",
    "\\\\\\": "M-1 5L1 7M0 0L6 6M5 -1L7 1",
    "...": "M3 3h.01",
}
"""Lines of a tile of 6 by 6 points."""


def svg(scene: Scene, words: str) -> str:
    """A figure as an ``<svg>`` element; words: what it shows, for those who do not see it."""
    hatches = list(
        dict.fromkeys(s.hatch for s in scene.shapes if isinstance(s, Fill) and s.hatch in _HATCHES)
    )
    clips = list(dict.fromkeys(own for shape in scene.shapes if (own := clip_of(shape))))
    # figures of one page share a definition where it is the same
    name = f"p{zlib.crc32(repr((clips, hatches)).encode()):08x}"
    width, height = _number(scene.width), _number(scene.height)
    parts = [
        f'<svg xmlns="http://www.w3.org/2000/svg" width="{width}pt" height="{height}pt" '
        f'viewBox="0 0 {width} {height}" role="img" aria-label={quoteattr(words)} '
        f'font-family="{FAMILY}" fill="none" '
        f'stroke-linejoin="round">',
        *_definitions(name, clips, hatches),
        f'<rect width="{width}" height="{height}" fill="#fff"/>',
    ]
    for clip, shapes in groupby(scene.shapes, clip_of):
        drawn = (part for shape in shapes for part in _element(shape, name, hatches))
        if clip is None:
            parts += drawn
        else:
            parts += [f'<g clip-path="url(#{name}-{clips.index(clip)})">', *drawn, "</g>"]
    return "\n".join([*parts, "</svg>\n"])


def _definitions(name: str, clips: list[Box], hatches: list[str]) -> Iterator[str]:
    if not clips and not hatches:
        return
    yield "<defs>"
    for number, box in enumerate(clips):
        x, y, wide, high = (_number(own) for own in (box.left, box.top, box.width, box.height))
        yield (
            f'<clipPath id="{name}-{number}"><rect x="{x}" y="{y}" width="{wide}" '
            f'height="{high}"/></clipPath>'
        )
    for number, hatch in enumerate(hatches):
        yield (
            f'<pattern id="{name}-h{number}" width="6" height="6" patternUnits="userSpaceOnUse">'
            f'<path d="{_HATCHES[hatch]}" stroke="#fff" stroke-linecap="round" '
            f'stroke-width="{1.8 if hatch == "..." else 1}"/></pattern>'
        )
    yield "</defs>"


def _element(shape: Shape, name: str, hatches: list[str]) -> Iterator[str]:
    match shape:
        case Stroke():
            path = _path(thinned(shape.points))
            if path:
                look = _stroke(shape.colour, shape.width) + _dashes(shape)
                yield f'<path d="{path}" {look}{_faint(shape.alpha, "stroke-")}/>'
        case Fill():
            path = "".join(_path(thinned(ring)) + "Z" for ring in shape.rings)
            edge = f" {_stroke(shape.outline, shape.outline_width)}" if shape.outline else ""
            yield f'<path d="{path}" fill="{shape.colour}"{_faint(shape.alpha)}{edge}/>'
            if shape.hatch in hatches:
                yield f'<path d="{path}" fill="url(#{name}-h{hatches.index(shape.hatch)})"/>'
        case Dots():
            count = (
                len(shape.points) if shape.alpha < 1.0 else 1
            )  # above each other they are darker
            for points in np.array_split(shape.points, max(count, 1)):
                yield from _dots(replace(shape, points=points))
        case Letters():
            yield _text(shape)


def _faint(alpha: float, of: str = "") -> str:
    return f' {of}opacity="{_number(alpha)}"' if alpha < 1.0 else ""


def _stroke(colour: str, width: float) -> str:
    return f'stroke="{colour}" stroke-width="{_number(width)}"'


def _dashes(shape: Stroke) -> str:
    if shape.dash not in DASHED:
        return ""
    lengths = " ".join(_number(own * shape.width) for own in DASHED[shape.dash])
    return f' stroke-dasharray="{lengths}"'


def _dots(shape: Dots) -> Iterator[str]:
    """Round marks as points of a round pen, others as one path each."""
    if not len(shape.points):
        return
    faint = _faint(shape.alpha)
    if shape.marker in "o." and shape.face == shape.edge:
        path = "".join(f"M{x} {y}h0" for x, y in _pairs(shape.points))
        size = shape.size + shape.edge_width
        yield f'<path d="{path}" {_stroke(shape.face, size)} stroke-linecap="round"{faint}/>'
        return
    outline = marker_path(shape.marker, shape.size / 2)
    rings = shape.points[:, None, :] + outline[None]
    end = "" if shape.marker in OPEN else "Z"
    path = "".join(_path(ring) + end for ring in rings)
    face = f'fill="{shape.face}" ' if shape.face else ""
    edge = _stroke(shape.edge, shape.edge_width) if shape.edge_width else ""
    yield f'<path d="{path}" {face}{edge}{faint}/>'


def marker_path(marker: str, half: float) -> Array:
    """Corners of a mark of half a size, y downwards; NaN lifts the pen."""
    corners: dict[str, list[tuple[float, float]]] = {
        "s": [(-1, -1), (1, -1), (1, 1), (-1, 1)],
        "^": [(0, -1), (1, 1), (-1, 1)],
        "v": [(0, 1), (1, -1), (-1, -1)],
        ">": [(1, 0), (-1, 1), (-1, -1)],
        "<": [(-1, 0), (1, -1), (1, 1)],
        "D": [(0, -1.41), (1.41, 0), (0, 1.41), (-1.41, 0)],
        "P": [
            (-0.33, -1), (0.33, -1), (0.33, -0.33), (1, -0.33), (1, 0.33), (0.33, 0.33),
            (0.33, 1), (-0.33, 1), (-0.33, 0.33), (-1, 0.33), (-1, -0.33), (-0.33, -0.33),
        ],
        "X": [
            (-1, -0.55), (-0.55, -1), (0, -0.45), (0.55, -1), (1, -0.55), (0.45, 0), (1, 0.55),
            (0.55, 1), (0, 0.45), (-0.55, 1), (-1, 0.55), (-0.45, 0),
        ],
        "x": [(-1, -1), (1, 1), (np.nan, np.nan), (-1, 1), (1, -1)],
        "+": [(-1, 0), (1, 0), (np.nan, np.nan), (0, -1), (0, 1)],
        "|": [(0, -1), (0, 1)],
    }  # fmt: skip
    if marker in corners:
        return half * np.array(corners[marker])
    angle = np.linspace(0.0, 2 * np.pi, 24, endpoint=False)
    return half * np.stack([np.cos(angle), np.sin(angle)], axis=1)


def _text(shape: Letters) -> str:
    anchor = {"left": "", "center": ' text-anchor="middle"', "right": ' text-anchor="end"'}
    x, y = _number(shape.x), _number(shape.y)
    turned = f' transform="rotate(-90 {x} {y})"' if shape.turned else ""
    bold = ' font-weight="bold"' if shape.bold else ""
    head = (
        f'<text x="{x}" y="{y}" font-size="{_number(shape.size)}" fill="{shape.colour}"'
        f"{anchor[shape.across]}{bold}{turned}>"
    )
    runs = runs_of(shape.text)
    if len(runs) == 1 and not runs[0].italic:
        return f"{head}{escape(runs[0].text)}</text>"
    level, parts = 0.0, []
    for run in runs:
        down = _number((level - run.rise) * shape.size)
        look = f' dy="{down}"' if down != "0" else ""
        look += f' font-size="{_number(run.scale * shape.size)}"' if run.scale != 1.0 else ""
        look += ' font-style="italic"' if run.italic else ""
        parts.append(f"<tspan{look}>{escape(run.text)}</tspan>")
        level = run.rise
    return f"{head}{''.join(parts)}</text>"


def thinned(points: Array) -> Array:
    """Points without those that lie on the line between their neighbours.

    Examples
    --------
    >>> x = np.linspace(0.0, 100.0, 1001)
    >>> len(thinned(np.stack([x, np.abs(x - 50.0)], axis=1)))
    19
    """
    for number in range(_PASSES):
        if len(points) < _FEW:
            break
        before, here, after = points[:-2], points[1:-1], points[2:]
        chord, to = after - before, here - before
        length = np.hypot(chord[:, 0], chord[:, 1])
        with np.errstate(invalid="ignore", divide="ignore"):
            off = np.abs(chord[:, 0] * to[:, 1] - chord[:, 1] * to[:, 0]) / length
            along = (chord * to).sum(axis=1) / length**2
            needless = (off < _NEAR) & (along >= 0.0) & (along <= 1.0)
        needless[number % 2 :: 2] = False  # of two neighbours one stays
        points = points[np.concatenate([[True], ~needless, [True]])]
    return points


def _path(points: Array) -> str:
    """Points as a path, a new piece behind each NaN."""
    known = np.isfinite(points).all(axis=1)
    if not known.all():
        pieces = (
            points[begin:end] for begin, end in zip(*stretches(np.asarray(known)), strict=True)
        )
        return "".join(_path(own) for own in pieces if len(own) > 1)
    if not len(points):
        return ""
    text = ("L%.2f %.2f" * len(points)) % tuple(points.ravel().tolist())
    return "M" + text[1:]


def _pairs(points: Array) -> Iterable[tuple[str, str]]:
    return ((f"{x:.2f}", f"{y:.2f}") for x, y in points.tolist())


def _number(value: float) -> str:
    """A number to hundredths, as short as it can be."""
    text = f"{value:.2f}".rstrip("0").rstrip(".")
    return "0" if text in ("-0", "") else text
