"""The catalogue: the effects of this folder, of installed packages, and those registered here."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any, Final

from pmmkit.base import Registry
from pmmkit.effects.definition import Effect

GROUP: Final = "pmmkit.effects"
"""Entry points under which installed packages offer an effect, or a sequence of them."""
CATALOGUE: Final = Registry(
    Effect,
    what="effect",
    listed="pmmkit.effects:EFFECTS",
    group=GROUP,
    contract="pmmkit.testing.effects:check_effect",
)
"""All effects by name: those of pmmkit in the order of their files, then those of others."""


def catalogue() -> Mapping[str, Effect]:
    """All effects by name: those of pmmkit in the order of their files, then those of others.

    Examples
    --------
    >>> catalogue()["propeller"].family
    'propeller'
    """
    return CATALOGUE


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
    CATALOGUE.register(effect)
    return effect


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


def is_fault(name: str) -> bool:
    """Whether a name is that of a fault of the measurement.

    Parameters
    ----------
    name : str
        Of the catalogue, or any other.

    Examples
    --------
    >>> is_fault("fault_gauge_zero"), is_fault("memory")
    (True, False)
    """
    known = CATALOGUE.get(name)
    return known is not None and known.faulty
