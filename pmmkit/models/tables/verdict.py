"""Whether a derivative table can be used: what a reduction found against it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Literal

from pmmkit.presentation import counted

Use = Literal["usable", "usable with doubts", "not usable"]


@dataclass(frozen=True, kw_only=True)
class TableVerdict:
    """Whether a derivative table can be used.

    Parameters
    ----------
    faults : tuple of str
        What makes it not usable, the gravest first.
    doubts : tuple of str
        What stands against it besides.

    Examples
    --------
    >>> print(TableVerdict(doubts=("Y: misfit.",)))
    Usable with the 1 doubt above.
    >>> print(TableVerdict(faults=("Yv is positive, which no hull has.",)))
    Not usable: Yv is positive, which no hull has.
    """

    faults: tuple[str, ...] = ()
    doubts: tuple[str, ...] = ()

    @property
    def use(self) -> Use:
        """The verdict in one word."""
        if self.faults:
            return "not usable"
        return "usable with doubts" if self.doubts else "usable"

    @property
    def reasons(self) -> tuple[str, ...]:
        """All that stands against it, the gravest first."""
        return (*self.faults, *self.doubts)

    def __str__(self) -> str:
        if self.use == "usable":
            return "Usable: nothing speaks against these derivatives."
        if self.use == "usable with doubts":
            return f"Usable with the {counted(len(self.doubts), 'doubt')} above."
        more = len(self.reasons) - 1
        rest = f" ({more} more above)" if more else ""
        return f"Not usable: {self.faults[0]}{rest}"

    def to_dict(self) -> dict[str, Any]:
        """As plain data, as a table keeps it."""
        return {"use": self.use, "faults": list(self.faults), "doubts": list(self.doubts)}


def kept_verdict(provenance: Mapping[str, Any]) -> TableVerdict | None:
    """The verdict that a table's provenance holds; None where nobody judged it.

    Examples
    --------
    >>> kept_verdict({"verdict": {"use": "usable", "faults": [], "doubts": []}}).use
    'usable'
    """
    kept = provenance.get("verdict")
    if not isinstance(kept, Mapping):
        return None
    faults, doubts = (tuple(map(str, kept.get(name, ()))) for name in ("faults", "doubts"))
    return TableVerdict(faults=faults, doubts=doubts)
