"""The base of each campaign of one ship: what captive tests know of it, at the length tested."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Final

from pmmkit.campaigns.run import Campaign
from pmmkit.conventions import parse_derivative
from pmmkit.diagnosis.captive.system import System
from pmmkit.models import Model, scaled

SAME: Final = 1e-3
"""Share by which two lengths of one ship may differ without carrying the model over."""


@dataclass(frozen=True, kw_only=True)
class Based:
    """A model as the base of a campaign, with what is to be said of it.

    Parameters
    ----------
    model : Model
        The base.
    notes : tuple of str
        How it came to be.
    """

    model: Model
    notes: tuple[str, ...] = ()


@dataclass(frozen=True, kw_only=True, eq=False)
class Fitted:
    """Captive tests that the base is fitted to.

    Parameters
    ----------
    name : str
        Of the campaign.
    system : System
        Runs and base.
    model : callable
        The model with its derivatives fitted to them; None if they excite too little.
    """

    name: str
    system: System
    model: Callable[[], Model | None]


def known_from(model: Model, tests: Sequence[Fitted]) -> Based:
    """The model with what captive tests know of its base.

    Parameters
    ----------
    model : Model
        As it is given; one with a covariance is taken as it is.
    tests : sequence of Fitted
        Of bare hulls the first is used.
    """
    if model.covariance is not None:
        return Based(model=model, notes=("the base is known as the covariance of the model says",))
    for item in tests:
        if _is_bare(item.system) and (found := item.model()) is not None:
            said = f"the base is known as {item.name} tells it: its derivatives are fitted"
            return Based(model=found, notes=(said,))
    said = (
        "the base stays as the model has it: in the captive tests rudder or propeller took part, "
        "or too little is excited; reduce them for a model with covariance"
    )
    return Based(model=model, notes=(said,) if tests else ())


def carried(model: Model, name: str, campaign: Campaign) -> Based:
    """The model at the length of the ship that was tested.

    Parameters
    ----------
    model : Model
        At its own length.
    name : str
        Of the campaign.
    campaign : Campaign
        Free-running records.
    """
    ship = campaign.ship
    if abs(ship.L / model.ship.L - 1.0) < SAME:
        return Based(model=model)
    said = (
        f"{name}: the model is carried from L = {model.ship.L:g} m to {ship.L:g} m by Froude's "
        f"law, without correction of friction or wake; its propulsion point stays"
    )
    return Based(model=scaled(model, ship.L), notes=(said,))


def _is_bare(system: System) -> bool:
    """Whether tests show the forces of the hull alone."""
    names = [name for own in system.base.names.values() for name in own]
    return "XT" not in names and not any(parse_derivative(name).count("d") for name in names)
