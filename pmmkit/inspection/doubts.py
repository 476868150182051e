"""Columns of which their header says that they are not to be believed."""

from __future__ import annotations

import re
from typing import Final

from pmmkit.conventions import unit_factor
from pmmkit.errors import DataError
from pmmkit.vocabulary import meanings

_REMARK: Final = re.compile(r"\(([^()]*)\)|\[([^\[\]]*)\]")
_FORCES: Final = re.compile(
    r"force|kraft|kr[aä]fte|kracht|load|moment|fuerza|força|力|힘", re.IGNORECASE
)
"""A doubt about forces leaves the angle beside them alone."""


def doubt_in(title: str) -> str:
    """What a header says against its column, as it stands there; empty where it says nothing.

    Parameters
    ----------
    title : str
        The whole header, with that of its group.

    Examples
    --------
    >>> doubt_in("RUDDER (force measurements not useful) X (N)"), doubt_in("Fx [N]")
    ('force measurements not useful', '')
    >>> doubt_in("Dehnung, defekt [V]")
    'Dehnung, defekt [V]'
    """
    for found in _REMARK.finditer(title):
        said = found[1] or found[2] or ""
        if meanings("doubt", said):
            return said.strip()
    return title.strip() if meanings("doubt", title) else ""


def concerns(doubt: str, unit: str | None) -> bool:
    """Whether a doubt is about a column of that unit: one about forces only about those.

    Parameters
    ----------
    doubt : str
        From `doubt_in`.
    unit : str or None
        As stated.

    Examples
    --------
    >>> concerns("force measurements not useful", "N"), concerns("force measurements n/a", "°")
    (True, False)
    """
    if not doubt or unit is None or not _FORCES.search(doubt):
        return bool(doubt)
    try:
        return unit_factor(unit)[0] in ("N", "N m")
    except DataError:
        return True


def without_doubt(header: str) -> str:
    """A header without the remark in brackets that doubts it.

    Parameters
    ----------
    header : str
        Without its unit.

    Examples
    --------
    >>> without_doubt("RUDDER (force measurements not useful) given")
    'RUDDER given'
    """
    kept = _REMARK.sub(lambda x: "" if meanings("doubt", x[1] or x[2] or "") else x[0], header)
    return " ".join(kept.split())
