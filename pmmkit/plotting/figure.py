"""A figure: axes in a grid, as plain data, and how it is written."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

import numpy as np

from pmmkit.base import DataError
from pmmkit.files import atomic_path
from pmmkit.plotting.axes import Axes, AxesGrid, Key, Title
from pmmkit.plotting.layout import laid_out
from pmmkit.plotting.marks import Mosaic
from pmmkit.plotting.vector import PROLOG, svg
from pmmkit.plotting.words import in_words


@dataclass(kw_only=True, eq=False)
class Figure(AxesGrid):
    """Axes in a grid, and what stands about them.

    Parameters
    ----------
    width, height : float
        Of the whole [inch].
    axes : list of Axes
        In the order of the grid, row by row.
    widths, heights : tuple of float
        Of columns and rows, over each other.
    title, xlabel, ylabel : Title
        Of all axes together.
    key : Key, optional
        A scale of colours at the right.
    legend : tuple of Axes
        Whose labels stand below the figure.
    legend_columns : int
        So many of them side by side at most.

    Examples
    --------
    >>> figure = Figure(height=3.0)
    >>> left, right = figure.subplots(1, 2)
    >>> line = left.plot([0.0, 1.0], [0.0, 1.0], color="#000000", label="measured")
    >>> figure.legend_below([left, right])
    >>> [own.columns for own in figure.axes]
    [(0, 0), (1, 1)]
    """

    def subplots(
        self,
        rows: int = 1,
        columns: int = 1,
        *,
        squeeze: bool = True,
        sharex: bool | Literal["col"] = False,
        sharey: bool | Literal["col", "row"] = False,
        width_ratios: Sequence[float] | None = None,
        height_ratios: Sequence[float] | None = None,
    ) -> Any:
        """Axes in a grid of `rows` and `columns`.

        Shared sides have the same ends; their numbers stand below and at the left alone. Returns
        an array (rows, columns) of `Axes`, without sides of length 1 where `squeeze`.
        """
        self.widths = tuple(width_ratios or [1.0] * columns)
        self.heights = tuple(height_ratios or [1.0] * rows)
        grid = np.empty((rows, columns), object)
        for row in range(rows):
            for column in range(columns):
                grid[row, column] = Axes(rows=(row, row), columns=(column, column))
        self.axes = [*self.axes, *grid.ravel().tolist()]
        for row, column in np.ndindex(rows, columns):
            own: Axes = grid.item(row, column)
            if sharex:
                kin = grid[:, column] if sharex == "col" else grid
                own.xshared = [other for other in kin.ravel() if other is not own]
                own.xticks.shown = row == rows - 1
            if sharey:
                kin = {"col": grid[:, column], "row": grid[row]}.get(str(sharey), grid)
                own.yshared = [other for other in kin.ravel() if other is not own]
                own.yticks.shown = sharey == "col" or column == 0
        if not squeeze:
            return grid
        return grid[0, 0] if grid.size == 1 else np.squeeze(grid)

    def legend_below(self, axes: Sequence[Axes], columns: int = 4) -> None:
        """One legend for several axes under the figure, where it covers nothing: each label once,
        so many `columns` side by side, fewer where they are too long for the width."""
        self.legend, self.legend_columns = tuple(axes), columns

    def suptitle(self, text: str, *, fontsize: float = 10.0) -> None:
        """A title of all, at the left."""
        self.title = Title(text=text, size=fontsize)

    def supxlabel(self, text: str) -> None:
        """A name below all axes."""
        self.xlabel = Title(text=text)

    def supylabel(self, text: str) -> None:
        """A name at the left of all axes."""
        self.ylabel = Title(text=text)

    def colour_key(self, cells: Mosaic, title: str, *, beyond: bool = False) -> None:
        """At the right, what the colours of some cells mean; ``beyond``: values lie beyond it."""
        self.key = Key(shades=cells.shades, title=title, beyond=beyond)

    def save(self, path: str | Path) -> Path:
        """Write it, all or nothing; the ending of the name says how (svg, png, pdf).

        Raises
        ------
        DataError
            If the name has another ending.

        Examples
        --------
        >>> import tempfile
        >>> figure = Figure(height=2.0)
        >>> line = figure.subplots().plot([0, 1], [0, 1], color="#000000")
        >>> with tempfile.TemporaryDirectory() as folder:
        ...     figure.save(f"{folder}/line.svg").name
        'line.svg'
        """
        target = Path(path)
        ending = target.suffix.lower()
        if ending not in (".svg", ".png", ".pdf"):
            raise DataError(f"{target.name}: a figure is a file .svg, .png or .pdf.")
        if ending == ".svg":
            content = (PROLOG + self.svg()).encode()
        elif ending == ".png":
            content = self.png()
        else:
            from pmmkit.plotting.raster import pdf

            content = pdf(laid_out(self))
        with atomic_path(target) as part:
            part.write_bytes(content)
        return target

    def svg(self, words: str = "") -> str:
        """An ``<svg>`` element to stand inside a page.

        Parameters
        ----------
        words : str
            What it shows, for those who do not see it; `in_words` by default.

        Examples
        --------
        >>> figure = Figure(height=1.0)
        >>> line = figure.subplots().plot([0, 1], [0, 1], color="#000000")
        >>> figure.svg().startswith('<svg xmlns="http://www.w3.org/2000/svg" width="648pt"')
        True
        """
        return svg(laid_out(self), words or self.in_words())

    def png(self, dots: float = 150.0) -> bytes:
        """A picture of so many dots per inch."""
        from pmmkit.plotting.raster import png

        return png(laid_out(self), dots)

    def in_words(self) -> str:
        """What it shows, for those who do not see it."""
        return in_words(self)

    def _repr_svg_(self) -> str:
        """What a notebook shows."""
        return self.svg()
