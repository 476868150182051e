"""The truth behind the synthetic S175 programme: datasets/s175/truth.toml, read."""

from __future__ import annotations

import tomllib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from pmmkit.conventions import Convention
from pmmkit.files import datasets_folder
from pmmkit.conventions import Water
from pmmkit.models import load_ship
from pmmkit.models import DerivativeTable, from_values


@dataclass(frozen=True, kw_only=True)
class Truth:
    """Derivatives that change linearly with the square of the Froude number.

    Parameters
    ----------
    at_low : mapping of str to float
        Total derivatives (added-mass Coriolis terms inside), prime, instantaneous speed, at
        `Fn_low`; acceleration derivatives too.
    slopes : mapping of str to float
        Relative change of each from `Fn_low` to `Fn_high`; 0 where absent.
    Fn_low, Fn_high : float
        Ends of the range.
    """

    at_low: Mapping[str, float]
    slopes: Mapping[str, float]
    Fn_low: float
    Fn_high: float

    def at(self, Fn: float) -> dict[str, float]:
        """The derivatives at a Froude number."""
        share = (Fn**2 - self.Fn_low**2) / (self.Fn_high**2 - self.Fn_low**2)
        return {
            name: value * (1 + self.slopes.get(name, 0.0) * share)
            for name, value in self.at_low.items()
        }

    def table(self, Fn: Sequence[float]) -> DerivativeTable:
        """The derivatives at some Froude numbers as a table of the full-scale ship."""
        rows = [self.at(x) for x in Fn]
        return from_values(
            {name: [row[name] for row in rows] for name in self.at_low},
            ship=load_ship("s175-3dof"),
            water=Water(),
            Fn=list(Fn),
            convention=Convention(),
            method="truth",
        )


def load_truth(path: Path | None = None) -> Truth:
    """The truth from its file (default: datasets/s175/truth.toml)."""
    file = path or datasets_folder() / "s175" / "truth.toml"
    data = tomllib.loads(file.read_text(encoding="utf-8"))
    return Truth(
        at_low=data["derivatives"],
        slopes=data["slopes"],
        Fn_low=data["Fn_low"],
        Fn_high=data["Fn_high"],
    )
