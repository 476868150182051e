"""The terms among which a method may choose."""

from __future__ import annotations

from collections.abc import Sequence

from pmmkit.conventions import STRUCTURES, Structure, parse_derivative
from pmmkit.reduction.derivatives import DerivativeNames


def library_of(
    columns: DerivativeNames, structure: Structure, library: str | Sequence[str] | Structure | None
) -> dict[str, tuple[str, ...]]:
    """Terms by channel: those asked for, then those of the library.

    Examples
    --------
    >>> from pmmkit.conventions import STRUCTURES
    >>> asked = DerivativeNames(required={"Y": ("Yv", "Yvvv")}, optional={"Y": ("Y0",)})
    >>> library_of(asked, Structure.meant_by("Yv Yvvv"), None)["Y"]
    ('Yv', 'Yvvv', 'Y0', 'Yv|v|')
    """
    if library is None:
        known = {factor for name in structure.derivatives for factor in _variables(name)}
        more = [
            name
            for other in STRUCTURES.values()
            if other.surge == structure.surge
            for name in other.derivatives
            if _variables(name) <= known
        ]
    else:
        more = list(Structure.meant_by(library).derivatives)
    return {
        channel: tuple(dict.fromkeys((*own, *(name for name in more if name[0] == channel))))
        for channel, own in columns.names.items()
    }


def _variables(name: str) -> frozenset[str]:
    return parse_derivative(name).variables
