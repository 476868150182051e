"""The catalogue: every effect that the files of this folder define."""

from __future__ import annotations

import importlib
import pkgutil
from collections.abc import Mapping
from functools import cache
from types import MappingProxyType

import pmmkit.effects as folder
from pmmkit.effects.effect import Effect
from pmmkit.errors import UnknownNameError


@cache
def catalogue() -> Mapping[str, Effect]:
    """All effects by name, in the order of their files.

    Examples
    --------
    >>> catalogue()["propeller"].family
    'propeller'
    """
    found: dict[str, Effect] = {}
    for module in pkgutil.iter_modules(folder.__path__):
        if module.name != "catalogue":
            loaded = importlib.import_module(f"{folder.__name__}.{module.name}")
            found |= {effect.name: effect for effect in getattr(loaded, "EFFECTS", ())}
    return MappingProxyType(found)


def effect_of(name: str) -> Effect:
    """The effect of a name.

    Raises
    ------
    UnknownNameError
        With the names there are.

    Examples
    --------
    >>> effect_of("added_mass").kind
    'mass'
    """
    known = catalogue()
    if name not in known:
        raise UnknownNameError(f"There is no effect {name!r}; there are: {', '.join(known)}.")
    return known[name]


def is_fault(name: str) -> bool:
    """Whether a name is that of a fault of the measurement.

    Examples
    --------
    >>> is_fault("fault_gauge_zero"), is_fault("memory")
    (True, False)
    """
    known = catalogue().get(name)
    return known is not None and known.kind == "observation"
