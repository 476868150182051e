"""Forces of a hull polynomial at one motion, for programs that publish what theirs gives."""

from __future__ import annotations

from typing import Final

from pmmkit.conventions import Convention, Ship, Water
from pmmkit.effects import Regressors, State
from scripts.validation.published import Values

FRESH: Final = Water(rho=1000.0, g=9.81)
MMG: Final = Convention(system="prime-d", surge="constant", coriolis="in-derivatives")
"""Of the MMG model, as a captive test measures it."""


def polynomial(values: Values, ship: Ship, convention: Convention, **motion: float) -> Values:
    """X, Y, N and K [N, N m] in fresh water of 1000 kg/m³."""
    state = State.of(**motion)
    given = {"ship": ship, "water": FRESH, "convention": convention}
    forces = {}
    for channel in ("X", "Y", "N", "K"):
        names = [name for name in list(values) if name[0] == channel]
        columns = Regressors.at(names, state, approach_speed=float(state.speed[0]), **given).columns
        forces[channel] = sum(x * values[n] for x, n in zip(columns[0], names, strict=True))
    return forces
