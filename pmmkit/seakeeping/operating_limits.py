"""Where a ship can sail in a sea: what motions come to over what they may, by speed and heading."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType
from typing import TYPE_CHECKING, Final, Self

import numpy as np

from pmmkit.base import DataError, UnknownNameError
from pmmkit.numerics import Array
from pmmkit.presentation import Described, Grid, Group, Section
from pmmkit.seakeeping.figures import polar
from pmmkit.seakeeping.responses import Place, Response, response
from pmmkit.seakeeping.seas import Sea
from pmmkit.seakeeping.transfer import MODES, Rao

if TYPE_CHECKING:
    import pandas as pd

    from pmmkit.plotting import Figure

LIMITS: Final[Mapping[str, float]] = MappingProxyType(
    {"roll_deg": 6.0, "acceleration": 1.5, "slam": 0.02, "wet": 0.05}
)
"""What is allowed where a user says nothing, about what NORDFORSK 1987 has for merchant ships: root
mean squares of roll [deg] and of vertical acceleration at each place [m/s²], shares of waves that
slam and that wet the deck. Round numbers between those of small and large ships."""


@dataclass(frozen=True, kw_only=True, repr=False, eq=False)
class Operability(Described):
    """The largest of all values over what is allowed, by speed and heading; beyond 1 is too much.

    Parameters
    ----------
    name : str
        Of the ship.
    sea : Sea
        The sea.
    speed, heading_deg : array
        [m/s, deg].
    limits : mapping of str to float
        What was allowed.
    ratios : mapping of str to array, shape (speeds, headings)
        Each value over its limit; NaN where it is not known.
    """

    name: str
    sea: Sea
    speed: Array
    heading_deg: Array
    limits: Mapping[str, float]
    ratios: Mapping[str, Array]

    @property
    def worst(self) -> Array:
        """The largest ratio, (speeds, headings); NaN where one is not known."""
        return np.asarray(np.max(np.stack(list(self.ratios.values())), axis=0))

    @property
    def share(self) -> float:
        """Share of the speeds and headings at which nothing is too much."""
        return float(np.mean(self.worst <= 1.0))

    def to_pandas(self) -> pd.DataFrame:
        """One row for each speed [m/s] and heading [deg]: each value over its limit."""
        import pandas as pd

        U, heading = np.meshgrid(self.speed, self.heading_deg, indexing="ij")
        ratios = {name: values.ravel() for name, values in self.ratios.items()}
        return pd.DataFrame({"speed": U.ravel(), "heading_deg": heading.ravel(), **ratios})

    def plot(self) -> Figure:
        """The largest ratio over heading, a line for each speed, with the limit at 1."""
        curves = {f"{U:.2f} m/s": row for U, row in zip(self.speed, self.worst, strict=True)}
        return polar(self.heading_deg, curves, limit=1.0, label="largest value over its limit")

    def _headline(self) -> str:
        return f"{self.name} in {self.sea.words}: {100 * self.share:.0f} % of speeds and headings"

    def _sections(self) -> Sequence[Section]:
        names = list(self.ratios)
        rows = []
        for i, speed in enumerate(self.speed):
            for j, heading in enumerate(self.heading_deg):
                values = [float(self.ratios[name][i, j]) for name in names]
                cells = [f"{value:.2f}" if math.isfinite(value) else None for value in values]
                rows.append([f"{speed:.2f} m/s, {heading:.0f}°", *cells])
        told = ", ".join(f"{name} {value:g}" for name, value in self.limits.items())
        return [
            Section(
                title="Values over what is allowed",
                paragraphs=[f"Allowed: {told}."],
                tables=[Grid(head=["", *names], groups=[Group(rows=rows[:60])])],
            )
        ]

    @classmethod
    def of(
        cls,
        rao: Rao,
        sea: Sea,
        *,
        places: Sequence[Place] = (),
        limits: Mapping[str, float] = LIMITS,
    ) -> Self:
        """What motions come to over what they may, at each speed and heading that was computed.

        Parameters
        ----------
        rao : Rao
            The motions.
        sea : Sea
            The sea.
        places : sequence of Place
            Where acceleration, wet decks and slams are judged.
        limits : mapping of str to float
            Some of `LIMITS`: ``roll_deg`` and ``acceleration`` are root mean squares [deg, m/s²],
            ``slam`` and ``wet`` shares of the waves.

        Returns
        -------
        Operability

        Raises
        ------
        UnknownNameError
            If a limit is not known.
        DataError
            If a limit is not positive, or there is nothing to judge.
        """
        unknown = [name for name in limits if name not in LIMITS]
        if unknown:
            raise UnknownNameError(
                f"There is no limit {', '.join(unknown)}. There are {', '.join(LIMITS)}."
            )
        if not limits or not all(value > 0.0 for value in limits.values()):
            raise DataError("Limits must be positive, one or more.")
        headings = np.degrees(rao.heading)
        found: dict[str, Array] = {}
        for i, speed in enumerate(rao.speed):
            for j, heading in enumerate(headings):
                one = response(
                    rao, sea, speed=float(speed), heading_deg=float(heading), places=places
                )
                for name, value in _values(one).items():
                    if name in limits:
                        table = found.setdefault(
                            name, np.full((rao.speed.size, headings.size), np.nan)
                        )
                        table[i, j] = value / limits[name]
        if not found:
            raise DataError("There is nothing to judge: give places with freeboard and draught.")
        return cls(
            name=rao.name,
            sea=sea,
            speed=rao.speed,
            heading_deg=headings,
            limits=MappingProxyType({name: limits[name] for name in found}),
            ratios=MappingProxyType(found),
        )


def _values(one: Response) -> dict[str, float]:
    """What is judged, the largest over the places."""
    found = {"roll_deg": math.degrees(math.sqrt(one.motions[MODES[3]].m0))}
    judged = {
        "acceleration": [math.sqrt(place.acceleration.m0) for place in one.places],
        "slam": [place.slam for place in one.places if place.slam is not None],
        "wet": [place.wet for place in one.places if place.wet is not None],
    }
    return found | {name: max(values) for name, values in judged.items() if values}
