"""Figures as they stand in reports, with what they show in words, for those who do not see it."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from pmmkit.numerics import Array
from pmmkit.plotting import svg
from pmmkit.presentation import Picture

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


_PANELS: Final = 6
"""Panels that are told one by one."""
_SERIES: Final = 4
"""Series of a panel that are told one by one."""


def seen(figure: Figure) -> str:
    """Panels, what they plot over what, which series there are and between which values they lie.

    Examples
    --------
    >>> from pmmkit.plotting import canvas
    >>> figure = canvas(3.0)
    >>> axis = figure.subplots()
    >>> line = axis.plot([0.0, 2.0], [1.0, 3.5], label="measured")
    >>> text = axis.set_title("yaw rate r [deg/s]"), axis.set_xlabel("time [s]")
    >>> print(seen(figure))
    Yaw rate r [deg/s] over time [s], 0 to 2: measured 1 to 3.5.
    """
    panels = [text for axis in figure.axes if axis.axison and (text := _panel(axis))]
    more = len(panels) - _PANELS
    told = [f"{text[0].upper()}{text[1:]}." for text in panels[:_PANELS]]
    counted = f"{len(panels)} panels. " if len(panels) > 1 else ""
    return counted + " ".join([*told, *([f"And {more} more of the kind."] if more > 0 else [])])


def _panel(axis: Axes) -> str:
    if axis.get_label() == "<colorbar>":
        return ""
    name = _name(axis)
    if axis.images or _meshes(axis):
        return "; ".join(text for text in (name, *_map(axis)) if text)
    bars = list(_bars(axis))
    if bars:
        return f"{name or plain(_xlabel(axis))}: {'; '.join(bars)}"
    series = list(_series(axis))
    if not series:
        return ""
    over = plain(_xlabel(axis))
    rows = _rows(axis)
    told = [f"{label} {_span(x if rows else y)}".strip() for label, x, y in series[:_SERIES]]
    more = len(series) - _SERIES
    rest = [f"{more} more series"] if more > 0 else []
    if rows:
        listed = f"{len(rows)} rows, {rows[0]} to {rows[-1]}"
        return f"{', '.join(filter(None, (name, over, listed)))}: {'; '.join([*told, *rest])}"
    ends = _span(np.concatenate([x for _, x, _ in series]))
    abscissa = f" over {over}, {ends}" if over else ""
    return f"{name}{abscissa}: {'; '.join([*told, *rest])}"


def _rows(axis: Axes) -> list[str]:
    """Names of the rows where the ordinates are no numbers."""
    from matplotlib.ticker import FixedLocator

    if not isinstance(axis.yaxis.get_major_locator(), FixedLocator):
        return []
    return [text for label in axis.get_yticklabels() if (text := plain(label.get_text()))]


def _name(axis: Axes) -> str:
    """Title and ordinate of a panel, else those at the head of its column and of its row."""
    title, ylabel = _title(axis), axis.get_ylabel()
    spec = axis.get_subplotspec()
    figure = axis.get_figure()
    if spec is not None and figure is not None:
        for other in figure.axes:
            place = other.get_subplotspec()
            if place is None or place.get_gridspec() is not spec.get_gridspec():
                continue
            if place.colspan.start == spec.colspan.start and place.rowspan.start == 0:
                title = title or _title(other)
            if place.rowspan.start == spec.rowspan.start and place.colspan.start == 0:
                ylabel = ylabel or other.get_ylabel()
    return plain(", ".join(dict.fromkeys(filter(None, (title, ylabel)))))


def _title(axis: Axes) -> str:
    return axis.get_title(loc="left") or axis.get_title()


def _xlabel(axis: Axes) -> str:
    """Of the axis itself, or of one that shares its abscissa."""
    shared = [other.get_xlabel() for other in axis.get_shared_x_axes().get_siblings(axis)]
    return axis.get_xlabel() or next(filter(None, shared), "")


def _series(axis: Axes) -> Iterator[tuple[str, Array, Array]]:
    """Series with a name, else all; points of one name are one series."""
    lines = [line for line in axis.get_lines() if len(np.atleast_1d(line.get_xdata())) > 0]
    named = {id(c[0]): str(c.get_label()) for c in axis.containers if _is_errorbar(c)}
    groups: dict[str, list[Any]] = {}
    for line in lines:
        label = named.get(id(line), str(line.get_label()))
        groups.setdefault("" if label.startswith("_") else plain(label), []).append(line)
    chosen = {label: own for label, own in groups.items() if label} or groups
    for label, own in chosen.items():
        across = [line for line in own if line.get_transform() == axis.transData]
        x = np.concatenate(
            [np.asarray(line.get_xdata(), float).ravel() for line in across] or [np.empty(0)]
        )
        y = np.concatenate([np.asarray(line.get_ydata(), float).ravel() for line in own])
        if np.isfinite(y).any():
            yield label, x, y


def _is_errorbar(container: Any) -> bool:
    return container.__class__.__name__ == "ErrorbarContainer" and container[0] is not None


def _bars(axis: Axes) -> Iterator[str]:
    """Sets of bars, with the longest of each by the name of its place."""
    for container in axis.containers:
        if container.__class__.__name__ != "BarContainer" or not len(container):
            continue
        sideways = getattr(container, "orientation", "") == "horizontal"
        sizes = np.array([p.get_width() if sideways else p.get_height() for p in container])
        if not np.any(sizes):
            continue
        longest = container[int(np.nanargmax(np.abs(sizes)))]
        middle = (
            longest.get_y() + longest.get_height() / 2
            if sideways
            else longest.get_x() + longest.get_width() / 2
        )
        ticks = axis.get_yticks() if sideways else axis.get_xticks()
        labels = axis.get_yticklabels() if sideways else axis.get_xticklabels()
        place = plain(labels[int(np.argmin(np.abs(np.asarray(ticks) - middle)))].get_text())
        label = str(container.get_label())
        most = f"{_number(float(sizes[np.nanargmax(np.abs(sizes))]))}"
        yield " ".join(
            filter(None, ["" if label.startswith("_") else plain(label), "up to", most, place])
        )


def _meshes(axis: Axes) -> list[Any]:
    return [item for item in axis.collections if item.__class__.__name__ == "QuadMesh"]


def _map(axis: Axes) -> Iterator[str]:
    picture: Any = axis.images[0] if axis.images else _meshes(axis)[0]
    values: Array = np.ma.filled(np.ma.asarray(picture.get_array(), float), np.nan)
    rows = [plain(label.get_text()) for label in axis.get_yticklabels()]
    columns = [plain(label.get_text()) for label in axis.get_xticklabels()]
    values = values.reshape(-1, values.shape[-1]) if values.ndim > 1 else values[None]
    yield f"a map of {values.shape[0]} rows and {values.shape[1]} columns"
    if not np.isfinite(values).any():
        return
    if values.shape[0] == values.shape[1] and np.allclose(np.diagonal(values), 1.0):
        values = np.where(np.eye(len(values), dtype=bool), np.nan, values)
    row, column = np.unravel_index(int(np.nanargmax(np.abs(values))), values.shape)
    at = " and ".join(
        names[place]
        for names, place in ((rows, row), (columns, column))
        if place < len(names) and names[place]
    )
    yield f"values {_span(values)}, the largest {_number(float(values[row, column]))} at {at}"


def _span(values: Array) -> str:
    there = values[np.isfinite(values)]
    if not len(there):
        return "without values"
    low, high = _number(float(there.min())), _number(float(there.max()))
    return low if low == high else f"{low} to {high}"


def _number(value: float) -> str:
    return f"{value:.3g}".replace("-", "−") if value else "0"


def plain(text: str) -> str:
    """Mathematical text as it is read aloud.

    Examples
    --------
    >>> plain(r"$10^3\\,$$Y'_{\\dot{v}}$"), plain("drift with\\nrudder")
    ("10³ Y'_v-dot", 'drift with rudder')
    """
    text = re.sub(r"\\dot\{(.*?)\}", r"\1-dot", text)
    text = text.replace("^3", "³").replace("\\,", " ").replace("\\", "")
    return " ".join(re.sub(r"[${}]", "", text).split())


# A figure as it stands in a report: drawn, with its caption and what is seen in words.


def drawn(
    figure: Figure, caption: str, *, facts: Iterable[str] = (), narrow: bool = False, file: str = ""
) -> Picture:
    """A figure with its caption, and an alternative text from what it holds."""
    alt = " ".join([*facts, seen(figure)]) or caption
    drawing = svg(figure, final=True)
    return Picture(svg=drawing, caption=caption, narrow=narrow, alt=alt, file=file, figure=figure)
