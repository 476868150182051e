"""What is to be said of a model wherever it sails: made by force, or with an estimated hull."""

from __future__ import annotations

from typing import Final

from pmmkit.effects.hull import HULL
from pmmkit.models.model import Model

EMPIRICAL: Final = "empirical:"
"""How the source of an estimate begins."""
FASTEST: Final = 0.29
"""Largest Froude number of the ships that the standard errors of the estimates come from: KVLCC2,
KCS and S175."""
GUESSED: Final = (
    "All derivatives of the hull's side force and moment are estimates from particulars: a first "
    "look, not a verdict."
)
TOO_FAST: Final = (
    "At Fn {:.2f} nothing says how good they are: they were held against ships at Fn {:g} at most."
)


def caution(model: Model, speed: float) -> tuple[str, ...]:
    """What a reader of its manoeuvres must know of a model that nobody should trust.

    Parameters
    ----------
    model : Model
        Whose steps say whether it was made by force, and whose sources which values are estimates.
    speed : float
        Of the approach [m/s].

    Returns
    -------
    tuple of str
        Sentences; none of a hull of which a derivative of side force or moment is no estimate.

    Examples
    --------
    >>> from pmmkit.models.estimates import estimated_model
    >>> from pmmkit.models.store import load_model
    >>> ship = load_model("kcs").ship
    >>> made = estimated_model(ship, speed=12.35, propeller_diameter=7.9, rudder_area=45.3)
    >>> len(caution(load_model("kcs"), 12.35)), len(caution(made, 12.35)), len(caution(made, 20.0))
    (0, 1, 2)
    """
    marked = (model.not_usable,) if model.not_usable else ()
    part = model.parts.get(HULL)
    if part is None:
        return marked
    across = [part.source_of(name) for name in part.values if name[0] in "YN"]
    if not across or not all(source.startswith(EMPIRICAL) for source in across):
        return marked
    Fn = model.ship.froude(speed, model.water.g)
    return (*marked, GUESSED, *([TOO_FAST.format(Fn, FASTEST)] if Fn > FASTEST else []))
