"""What takes part in the contest: an effect or a fault as columns over all runs and channels."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from types import MappingProxyType
from typing import Literal

import numpy as np

from pmmkit.channels import did_you_mean
from pmmkit.diagnosis.captive.base import Base
from pmmkit.errors import UnknownNameError
from pmmkit.numerics import Array
from pmmkit.observations.views import View

Columns = Callable[[View, Base, float], Mapping[str, Array]]
"""Harmonics of an effect in one view by channel, (m, q), at one grid point, q coefficients."""


@dataclass(frozen=True, kw_only=True)
class Candidate:
    """One effect, or one fault of the measurement.

    Parameters
    ----------
    name, family : str
        Name in the catalogue; family by which an answer is given first.
    kind : {"physics", "fault"}
        Whether it is the ship and the water, or the measurement.
    summary : str
        One sentence for people.
    coefficients : tuple of str
        What is fitted: derivatives, or the size of a fault with its unit.
    typical : tuple of float
        Their usual sizes, signed where nature has a sign.
    columns : callable
        From a view, the base and a grid value to harmonics per unit coefficient; channels without
        force are left out.
    grid : tuple of float
        Values of a nonlinear parameter; one without meaning where there is none.
    parameter : str
        What the grid is, with unit.
    continuous : bool
        Whether values between those of the grid have a meaning.
    centre : tuple of float
        Values about which coefficients are expected; zeros where absent.
    check : str
        A check at the bench or a run that shows it, in words.
    excites : tuple of str
        What a campaign must hold: ``several speeds``, ``roll``, ``rudder`` …
    """

    name: str
    family: str
    kind: Literal["physics", "fault"]
    summary: str
    coefficients: tuple[str, ...]
    typical: tuple[float, ...]
    columns: Columns
    grid: tuple[float, ...] = (0.0,)
    parameter: str = ""
    continuous: bool = False
    centre: tuple[float, ...] = ()
    check: str = ""
    excites: tuple[str, ...] = field(default=())

    @property
    def size(self) -> int:
        """Number of coefficients."""
        return len(self.coefficients)


def polynomial(
    name: str,
    family: str,
    summary: str,
    sizes: Mapping[str, float],
    *,
    check: str = "",
    law: Callable[[Base, float], Mapping[str, float]] | None = None,
    excites: tuple[str, ...] = (),
) -> Candidate:
    """An effect whose forces are derivatives that the base does not have.

    Parameters
    ----------
    name, family, summary : str
        As in `Candidate`.
    sizes : mapping of str to float
        Derivatives with their typical sizes.
    check : str
        A run or a check that shows it.
    law : callable, optional
        From the base and the speed to a factor of each derivative, for dependence on speed.
    excites : tuple of str
        What a campaign must hold.

    Returns
    -------
    Candidate

    Examples
    --------
    >>> polynomial("sway_drag", "hull", "Drag of sway.", {"Yv|v|": -0.02}).coefficients
    ('Yv|v|',)
    """
    names = tuple(sizes)

    def columns(view: View, base: Base, value: float) -> Mapping[str, Array]:
        del value
        found: dict[str, Array] = {}
        factors = law(base, view.speed) if law is not None else {}
        for channel in dict.fromkeys(label[0] for label in names):
            if channel not in view.force:
                continue
            own = [plain(label) for label in names if label[0] == channel]
            part = view.project(base.columns(own, view.motion, view.speed))
            block = np.zeros((view.rows, len(names)))
            at = [i for i, label in enumerate(names) if label[0] == channel]
            block[:, at] = part * [factors.get(names[i], 1.0) for i in at]
            found[channel] = block
        return MappingProxyType(found)

    return Candidate(
        name=name,
        family=family,
        kind="physics",
        summary=summary,
        coefficients=names,
        typical=tuple(sizes.values()),
        columns=columns,
        check=check,
        excites=excites,
    )


def plain(label: str) -> str:
    """The derivative of a label: what stands after a mark of speed dependence is cut off."""
    return label.split(" ")[0]


def spread_over(
    view: View, parts: Mapping[str, Sequence[Array]], count: int
) -> Mapping[str, Array]:
    """Columns by channel from single columns: channel to one array per coefficient."""
    return MappingProxyType(
        {
            channel: np.stack([np.asarray(part, float) for part in own], axis=1)
            for channel, own in parts.items()
            if channel in view.force and len(own) == count
        }
    )


def no_such_effect(name: str, known: Iterable[str]) -> UnknownNameError:
    """The error that names the effects that take part, the nearest one first."""
    listed = list(dict.fromkeys(known))
    guess = did_you_mean(name, listed) or "."
    return UnknownNameError(f"No effect {name!r} takes part{guess} These do: {', '.join(listed)}.")
