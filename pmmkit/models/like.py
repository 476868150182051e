"""A model with the propeller and the rudder of another build of the same ship."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Final

from pmmkit.effects.propeller import PROPELLER
from pmmkit.effects.rudder import RUDDER_MMG
from pmmkit.models.model import Model
from pmmkit.models.revise import with_stated

TURNS: Final = ("area", "area_movable")
"""What a campaign file calls the area that the effect ``rudder_mmg`` has."""


def with_stated_parts(
    model: Model, propeller: Mapping[str, Any], rudder: Mapping[str, Any], because: str
) -> Model:
    """A model whose propeller and rudder have the values that somebody states.

    Parameters
    ----------
    model : Model
        At the scale of what is stated.
    propeller, rudder : mapping
        Values by the names of the effects ``propeller`` and ``rudder_mmg``, the ``area_movable`` of
        the rudder [m²] and its ``height`` [m]. Other entries do not count.
    because : str
        Whose they are, which the model keeps.

    Returns
    -------
    Model
        What is not stated keeps its value. The slipstream reaches as much of the rudder as the
        stated diameter and height say, or as the diameter has changed.

    Examples
    --------
    >>> from pmmkit.models.store import load_model
    >>> ship = load_model("kvlcc2-l7")
    >>> other = with_stated_parts(ship, {"D": 0.22}, {}, "the new propeller")
    >>> round(other.values("rudder_mmg")["eta"] / ship.values("rudder_mmg")["eta"], 3)
    1.019
    """
    stated: dict[str, float] = {}
    if PROPELLER.name in model.parts:
        stated |= _values(model, PROPELLER.name, propeller)
    if RUDDER_MMG.name in model.parts:
        areas = [x for name in TURNS if (x := rudder.get(name))]
        given = {**rudder, "area": areas[0]} if areas else rudder
        stated |= _values(model, RUDDER_MMG.name, given)
        place = f"{RUDDER_MMG.name}.eta"
        if place not in stated and (eta := _reach(model, stated, rudder)) is not None:
            stated[place] = eta
    return with_stated(model, stated, because) if stated else model


def _values(model: Model, part: str, given: Mapping[str, Any]) -> dict[str, float]:
    """Those entries that are values of a part and differ from what it has."""
    own = model.parts[part]
    return {
        f"{part}.{item.name}": float(x)
        for item in own.known.parameters
        if isinstance(x := given.get(item.name), int | float)
        and not isinstance(x, bool)
        and own.values.get(item.name) != x
    }


def _reach(model: Model, stated: Mapping[str, float], rudder: Mapping[str, Any]) -> float | None:
    """Diameter of the propeller over the height of the rudder; None where nothing changes it."""
    if PROPELLER.name not in model.parts:
        return None
    before = model.parts[PROPELLER.name].values.get("D")
    eta = model.parts[RUDDER_MMG.name].values.get("eta")
    after = stated.get(f"{PROPELLER.name}.D", before)
    if not (isinstance(before, float) and isinstance(after, float) and isinstance(eta, float)):
        return None
    height = rudder.get("height")
    new = after / float(height) if height else eta * after / before
    return None if new == eta else new
