"""The catalogue: the effects of this folder, of installed packages, and those registered here."""

from __future__ import annotations

import importlib
import pkgutil
from collections.abc import Callable, Iterator, Mapping
from functools import cache
from inspect import signature
from types import MappingProxyType
from typing import Any, Final

import pmmkit.effects as folder
from pmmkit.base import ModelError, UnknownNameError, offered
from pmmkit.conventions import did_you_mean
from pmmkit.effects.definition import Effect

GROUP: Final = "pmmkit.effects"
"""Entry points under which installed packages offer an effect, or a sequence of them."""
_registered: Final[dict[str, Effect]] = {}
_editions: Final[dict[str, int]] = {}


def catalogue() -> Mapping[str, Effect]:
    """All effects by name: those of pmmkit in the order of their files, then those of others.

    Examples
    --------
    >>> catalogue()["propeller"].family
    'propeller'
    """
    return MappingProxyType({**_installed(), **_registered})


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
    known = _registered.get(name) or _installed().get(name)
    if known is None:
        every = catalogue()
        raise UnknownNameError(
            f"There is no effect {name!r}{did_you_mean(name, every) or '.'} "
            f"There are: {', '.join(every)}."
        )
    return known


def register_effect(effect: Effect) -> Effect:
    """Let an effect of one's own take part wherever one of pmmkit does, for this session.

    Parameters
    ----------
    effect : Effect
        `pmmkit.testing.check_effect` says whether it keeps what an effect promises. To have it in
        every session and on the command line, offer it from an installed package under the entry
        point ``pmmkit.effects``. Registered again under its name, it replaces the one before.

    Returns
    -------
    Effect
        The same.

    Raises
    ------
    ModelError
        If the name is one of pmmkit's own, or no name.
    """
    if effect.name in _installed():
        raise ModelError(f"There is an effect {effect.name!r} already: choose another name.")
    if not effect.name.isidentifier():
        raise ModelError(f"{effect.name!r} is no name: take letters, digits and _.")
    if _registered.get(effect.name) is not effect:
        _editions[effect.name] = edition_of(effect.name) + 1
    _registered[effect.name] = effect
    return effect


def edition_of(name: str) -> int:
    """How often an effect of a name was registered in this session; 0 for those of pmmkit."""
    return _editions.get(name, 0)


def effect(**declared: Any) -> Callable[[Callable[..., Any]], Effect]:
    """A function as an effect of one's own, registered.

    Parameters
    ----------
    **declared
        Fields of `Effect` but ``force``, which is the function; ``name`` is that of the function
        and ``summary`` the first line of its docstring where they are not given; ``kind`` is
        ``force``, and ``outputs`` must be given.

    Returns
    -------
    callable
        A decorator.

    Examples
    --------
    >>> from pmmkit.effects.definition import Parameter
    >>> from pmmkit.effects.primitives import fabs
    >>> @effect(family="own", outputs=("Y",), check="static drift to 20°",
    ...         parameters=(Parameter(name="size", text="of the keel", typical=-0.01),))
    ... def doc_keel(v: float, L: float, rho: float, size: float) -> tuple[float]:
    ...     "Drag of a keel."
    ...     return (0.5 * rho * L * L * v * fabs(v) * size,)
    >>> doc_keel
    <Effect doc_keel: force of own, asked in captive tests and free running>
    """

    def made(function: Callable[..., Any]) -> Effect:
        said = (function.__doc__ or "").strip().split("\n")[0]
        fields = {"name": function.__name__, "kind": "force", "summary": said} | declared
        return register_effect(Effect(force=function, **fields))

    return made


def forget_effect(name: str) -> None:
    """Take a registered effect out of the catalogue again; nothing where there is none."""
    if _registered.pop(name, None) is not None:
        _editions[name] = edition_of(name) + 1  # what a package offers under its name is another


def arguments_of(effect: Effect) -> tuple[str, ...]:
    """What the force of an effect asks for, by name; nothing where it has none."""
    return _arguments(effect.force) if effect.force is not None else ()


@cache
def _arguments(function: Callable[..., Any]) -> tuple[str, ...]:
    return tuple(signature(function).parameters)


@cache
def _installed() -> Mapping[str, Effect]:
    found: dict[str, Effect] = {}
    for module in sorted(_modules()):
        for item in getattr(importlib.import_module(module), "EFFECTS", ()):
            found[item.name] = item
    found |= offered(GROUP, Effect, found)
    return MappingProxyType(found)


def _modules() -> Iterator[str]:
    for module in pkgutil.walk_packages(folder.__path__, f"{folder.__name__}."):
        if module.name != __name__:
            yield module.name


def is_fault(name: str) -> bool:
    """Whether a name is that of a fault of the measurement.

    Examples
    --------
    >>> is_fault("fault_gauge_zero"), is_fault("memory")
    (True, False)
    """
    known = _registered.get(name) or _installed().get(name)
    return known is not None and known.faulty
