"""Seakeeping: seas, hulls in sections, strip theory, responses and added resistance."""

from pmmkit.seakeeping.seas import Sea, SeaState, sea, sea_states, state_of

__all__ = ["Sea", "SeaState", "sea", "sea_states", "state_of"]
