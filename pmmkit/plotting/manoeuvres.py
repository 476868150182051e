"""Which figures show a manoeuvre, by the way in which it is drawn."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Final, Literal

from pmmkit.plotting.histories import histories, path, spiral, zigzag
from pmmkit.plotting.turns import trajectory, turn_histories

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from pmmkit.plotting.history import History

Drawn = Literal["turning circle", "zigzag", "spiral", "path"]


def manoeuvre(history: History, drawn: Drawn) -> dict[str, Figure]:
    """The figures that show a manoeuvre, by the name of their file.

    Parameters
    ----------
    history : History
        Of the manoeuvre.
    drawn : {"turning circle", "zigzag", "spiral", "path"}
        How it is drawn.
    """
    return {name: figure(history) for name, figure in _FIGURES[drawn].items()}


_FIGURES: Final[Mapping[Drawn, Mapping[str, Callable[[History], Figure]]]] = {
    "turning circle": {
        "trajectory": lambda history: trajectory([history]),
        "histories": lambda history: turn_histories([history]),
    },
    "zigzag": {"zigzag": lambda history: zigzag([history])},
    "spiral": {"spiral": spiral, "histories": histories},
    "path": {"path": path, "histories": histories},
}
