"""The terms among which a method may choose."""

from __future__ import annotations

from collections.abc import Sequence

from pmmkit.conventions import bare, parse_derivative
from pmmkit.reduction.derivatives import Columns
from pmmkit.structures import Structure, structure_of, structures


def library_of(
    columns: Columns, structure: Structure, library: str | Sequence[str] | Structure | None
) -> dict[str, tuple[str, ...]]:
    """Terms by channel: those asked for, then those of the library.

    Parameters
    ----------
    columns : Columns
        The derivatives asked for, with what rudder, heel and propeller runs add.
    structure : Structure
        What the user asks for.
    library : str, sequence of str or Structure, optional
        More terms; by default those of all structures that mean the same by their factors, in
        the variables of the structure.

    Examples
    --------
    >>> from pmmkit.structures import structures
    >>> asked = Columns(required={"Y": ("Yv", "Yvvv")}, optional={"Y": ("Y0",)})
    >>> library_of(asked, structure_of("Yv Yvvv"), None)["Y"]
    ('Yv', 'Yvvv', 'Y0', 'Yv|v|')
    """
    if library is None:
        known = {factor for name in structure.derivatives for factor in _variables(name)}
        more = [
            name
            for other in structures().values()
            if other.surge == structure.surge
            for name in other.derivatives
            if _variables(name) <= known
        ]
    else:
        more = list(structure_of(library).derivatives)
    return {
        channel: tuple(dict.fromkeys((*own, *(name for name in more if name[0] == channel))))
        for channel, own in columns.names.items()
    }


def _variables(name: str) -> set[str]:
    return {bare(factor) for factor in parse_derivative(name).factors}
