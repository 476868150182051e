"""The manoeuvres: those that the files of this folder define, and those of other packages."""

from __future__ import annotations

from typing import Final

from pmmkit.base import Registry
from pmmkit.simulation.kinds.manoeuvre import Manoeuvre

GROUP: Final = "pmmkit.manoeuvres"
"""Entry point group by which an installed package brings manoeuvres."""


MANOEUVRES: Final = Registry(
    Manoeuvre,
    what="manoeuvre",
    listed="pmmkit.simulation.kinds:MANOEUVRES",
    group=GROUP,
    contract="pmmkit.testing.manoeuvres:check_manoeuvre",
)
"""All manoeuvres by name: pmmkit's, then those of other installed packages."""


def manoeuvre_of(name: str | Manoeuvre) -> Manoeuvre:
    """The manoeuvre of a name; one that is given stays as it is.

    Parameters
    ----------
    name : str or Manoeuvre
        One of `MANOEUVRES`.

    Raises
    ------
    UnknownNameError
        With the nearest name, and all there are.

    Examples
    --------
    >>> manoeuvre_of("turning").title
    'turning circle'
    """
    return name if isinstance(name, Manoeuvre) else MANOEUVRES[name]
