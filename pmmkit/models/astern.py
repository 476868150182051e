"""What a propeller does astern, where only its open water ahead is known."""

from __future__ import annotations

from dataclasses import replace
from types import MappingProxyType
from typing import Final

from pmmkit.base import ModelError
from pmmkit.effects import CATALOGUE
from pmmkit.models.model import Model
from pmmkit.models.step import Step

ESTIMATED: Final = (
    "What the propeller does astern is estimated: curves of Wageningen B4-70 of the pitch at which "
    "its thrust vanishes, joined to its open water ahead; no wake or side force astern."
)


def astern_can_be_estimated(model: Model) -> bool:
    """Whether a model has a propeller with KT as a polynomial, which says nothing of astern."""
    part = model.parts.get("propeller")
    return part is not None and "kt0" in part.values and not model.knows_astern


def as_it_stops(model: Model) -> Model | None:
    """A model that knows what its propulsion does astern, by an estimate where it must be.

    Parameters
    ----------
    model : Model
        Any.

    Returns
    -------
    Model or None
        The model itself, or `with_estimated_astern`; None where nothing is known.
    """
    if model.knows_astern:
        return model
    return with_estimated_astern(model) if astern_can_be_estimated(model) else None


def with_estimated_astern(model: Model) -> Model:
    """A model whose propeller turns astern by the curves of a series.

    Parameters
    ----------
    model : Model
        With a part ``propeller`` and its KT as a polynomial of J.

    Returns
    -------
    Model
        Its propeller has curves in all four quadrants: ahead, from bollard pull to the J at which
        the thrust vanishes, those that it had; beyond, those of Wageningen B4-70 as
        `effects.four_quadrant.estimate` joins them. An estimate, not a measurement.

    Raises
    ------
    ModelError
        If it knows what its propulsion does astern, or has no such propeller.

    Examples
    --------
    >>> from pmmkit.models.store import load_model
    >>> made = with_estimated_astern(load_model("kvlcc2"))
    >>> made.knows_astern, made.values("four_quadrant_propeller")["kt0"]
    (True, 0.2931)
    """
    if not astern_can_be_estimated(model):
        raise ModelError(
            f"Model {model.name!r} "
            + (
                "says already what its propulsion does astern."
                if model.knows_astern
                else "has no propeller whose KT is a polynomial of J, from which curves astern "
                "could be estimated: state a part four_quadrant_propeller."
            )
        )
    own = model.parts["propeller"]
    shared = {item.name for item in CATALOGUE["four_quadrant_propeller"].parameters}
    turning = replace(
        own,
        effect="four_quadrant_propeller",
        values=MappingProxyType({name: x for name, x in own.values.items() if name in shared}),
        options=MappingProxyType(
            {
                x: word
                for x, word in own.options.items()
                if x in CATALOGUE["four_quadrant_propeller"].options
            }
        ),
    )
    parts = {
        turning.effect if name == own.effect else name: turning if name == own.effect else part
        for name, part in model.parts.items()
    }
    made = model.with_(parts=MappingProxyType(parts))
    return made.stepped(Step(action="noted", note=ESTIMATED))
