"""The manoeuvres: those that the files of this folder define, and those of other packages."""

from __future__ import annotations

import importlib
import pkgutil
from collections.abc import Mapping
from functools import cache
from types import MappingProxyType
from typing import Final

import pmmkit.simulation.kinds as folder
from pmmkit.base import UnknownNameError
from pmmkit.simulation.kinds.manoeuvre import Manoeuvre

GROUP: Final = "pmmkit.manoeuvres"
"""Entry point group by which an installed package brings manoeuvres."""


@cache
def _ours() -> Mapping[str, Manoeuvre]:
    found: dict[str, Manoeuvre] = {}
    for module in pkgutil.iter_modules(folder.__path__):
        if module.name != "catalogue":
            loaded = importlib.import_module(f"{folder.__name__}.{module.name}")
            found |= {item.name: item for item in getattr(loaded, "MANOEUVRES", ())}
    return MappingProxyType(found)


@cache
def manoeuvres() -> Mapping[str, Manoeuvre]:
    """All manoeuvres by name: pmmkit's, then those of other installed packages.

    Examples
    --------
    >>> manoeuvres()["zigzag"].filled({"rudder_deg": 20.0})
    {'rudder_deg': 20.0, 'switch_deg': 10.0, 'executes': 5}
    """
    from pmmkit.base import offered

    ours = _ours()
    return MappingProxyType({**ours, **offered(GROUP, Manoeuvre, taken=ours)})


def manoeuvre_of(name: str | Manoeuvre) -> Manoeuvre:
    """The manoeuvre of a name; one that is given stays as it is.

    Parameters
    ----------
    name : str or Manoeuvre
        One of `manoeuvres`.

    Raises
    ------
    UnknownNameError
        With the nearest name, and all there are.

    Examples
    --------
    >>> manoeuvre_of("turning").title
    'turning circle'
    """
    if isinstance(name, Manoeuvre):
        return name
    # What other packages bring is looked for only when it must be: it costs 40 ms.
    if name in _ours():
        return _ours()[name]
    known = manoeuvres()
    if name in known:
        return known[name]
    from pmmkit.conventions import did_you_mean

    raise UnknownNameError(
        f"There is no manoeuvre {name!r}{did_you_mean(name, known) or '.'} There are: "
        f"{', '.join(known)}."
    )
