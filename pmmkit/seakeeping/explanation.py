"""Which number of a loading would explain what was measured in waves."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from types import MappingProxyType
from typing import Final

import numpy as np

from pmmkit.base import DataError
from pmmkit.numerics import Array
from pmmkit.presentation import Described, Grid, Group, Section, number
from pmmkit.seakeeping.measured import MeasuredTransfer, beside
from pmmkit.seakeeping.motions import rao
from pmmkit.seakeeping.transfer import MODES, Rao

_UPRIGHT: Final = MODES[2:5:2]
_ACROSS: Final = MODES[1::2]
CANDIDATES: Final[Mapping[str, tuple[str, str, tuple[str, ...]]]] = MappingProxyType(
    {
        "kyy": ("radius of gyration in pitch", "m", _UPRIGHT),
        "kxx": ("radius of gyration in roll", "m", _ACROSS),
        "kzz": ("radius of gyration in yaw", "m", _ACROSS),
        "KG": ("centre of gravity above the base line", "m", _ACROSS),
        "roll_damping": ("roll damping beside that of waves, over critical", "-", MODES[3:4]),
    }
)
"""Numbers of `Loading` that records may tell: in words, unit, and the motions that feel them."""
FLOOR: Final = 0.04
"""How far strip theory is off by itself: of the wave, and of its slope."""
_SPAN: Final = (0.5, 2.0)


@dataclass(frozen=True, kw_only=True)
class Change:
    """One number of the loading, moved to where the motions are nearest to the measured ones.

    `before, after`: its value as given, and where it explains most. `misfit`: mean square of
    the differences over their uncertainty, with it moved.
    """

    name: str
    before: float
    after: float
    misfit: float


@dataclass(frozen=True, kw_only=True, repr=False, eq=False)
class Explained(Described):
    """What each number of the loading would explain by itself, the best first.

    `misfit`: mean square of the differences over their uncertainty as the loading was given; 1
    is what the measurements and the theory are uncertain by. `changes`: one for each number
    that the measured motions feel.
    """

    name: str
    points: int
    misfit: float
    changes: tuple[Change, ...]

    @property
    def best(self) -> Change | None:
        """The one that explains most; None where none does so beyond what chance would.

        A change must lessen the sum of squares by ln n and 6 more (odds of 20 to 1 by Schwarz
        1978).
        """
        if not self.changes:
            return None
        gained = self.points * (self.misfit - self.changes[0].misfit)
        return self.changes[0] if gained > math.log(self.points) + 6.0 else None

    def _headline(self) -> str:
        best = self.best
        if best is None:
            return f"{self.name}: no number of the loading explains the records better"
        words, unit, _ = CANDIDATES[best.name]
        told = "" if unit == "-" else f" {unit}"
        return f"{self.name}: {words} {number(best.after, 4)}{told} for {number(best.before, 4)}"

    def _sections(self) -> Sequence[Section]:
        rows = [
            [CANDIDATES[x.name][0], number(x.before, 4), number(x.after, 4), number(x.misfit, 3)]
            for x in self.changes
        ]
        head = ["", "given", "best", "misfit"]
        told = (
            f"Misfit as given {number(self.misfit, 3)}, of {self.points} values: the mean square "
            f"of the differences over their uncertainty, in which strip theory has {FLOOR} of the "
            "wave and of its slope."
        )
        return [
            Section(
                title="What would explain the records",
                paragraphs=[told],
                tables=[Grid(head=head, groups=[Group(rows=rows)])],
            )
        ]


def explained(
    measured: Mapping[str, MeasuredTransfer],
    found: Rao,
    *,
    speed: float | None = None,
    heading_deg: float | None = None,
) -> Explained:
    """What a wrong number of the loading would explain, each by itself."""
    from scipy.optimize import minimize_scalar

    if not measured:
        raise DataError("Nothing was measured.")
    loading, strips = found.loading, found.strip_sections
    assert loading is not None
    if loading.roll_quadratic > 0.0:
        raise DataError(
            "Roll damping that grows with the rate of roll is not sought: leave it out."
        )

    def scores(moved: Rao) -> Array:
        rows = []
        for mode, one in measured.items():
            case = beside(one, moved, mode, speed=speed, heading_deg=heading_deg)
            a, b = moved.case(speed, heading_deg)
            k = np.interp(case.encounter, moved.encounter[a, b], moved.wavenumber)
            floor = FLOOR * (k if MODES.index(mode) > 2 else 1.0)
            rows.append((case.measured - case.computed) / np.hypot(case.std, floor))
        return np.concatenate(rows)

    def misfit_of(name: str, factor: float) -> float:
        changed = replace(loading, **{name: getattr(loading, name) * factor})
        moved = rao(
            strips.hull,
            speeds=found.speed,
            headings_deg=np.degrees(found.heading),
            omega=found.omega,
            loading=changed,
            rho=found.rho,
            g=found.g,
            strips=strips,
        )
        return float(np.mean(scores(moved) ** 2))

    given = scores(found)
    changes = []
    for name, (_, _, felt) in CANDIDATES.items():
        if not set(felt) & set(measured) or getattr(loading, name) == 0.0:
            continue
        highest = _SPAN[1]
        if name == "KG":
            highest = min(highest, 0.995 * strips.hull.hydrostatics.KM / loading.KG)
        best = minimize_scalar(
            lambda factor, name=name: misfit_of(name, factor),
            bounds=(_SPAN[0], highest),
            method="bounded",
            options={"xatol": 1e-3},
        )
        before = getattr(loading, name)
        changes.append(
            Change(name=name, before=before, after=before * float(best.x), misfit=float(best.fun))
        )
    return Explained(
        name=found.name,
        points=given.size,
        misfit=float(np.mean(given**2)),
        changes=tuple(sorted(changes, key=lambda change: change.misfit)),
    )
