"""Cards of ships: manoeuvres as a wheelhouse poster has them, and models made from them."""

from typing import TYPE_CHECKING

from pmmkit.base import lazy

if TYPE_CHECKING:
    from pmmkit.cards.card import Card, empty_card, read_card
    from pmmkit.cards.fit import ship_from_card

__all__ = ["Card", "empty_card", "read_card", "ship_from_card"]

lazy(__name__)
