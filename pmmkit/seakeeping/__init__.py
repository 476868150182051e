"""Seakeeping: seas, hulls in sections, strip theory, responses and added resistance."""

from pmmkit.seakeeping.hull import Hull, Hydrostatics, Station
from pmmkit.seakeeping.loading import Loading, loading_of
from pmmkit.seakeeping.motions import Rao, rao
from pmmkit.seakeeping.offsets import read_hull
from pmmkit.seakeeping.particulars import hull_from_particulars
from pmmkit.seakeeping.seas import Sea, SeaState, sea, sea_states, state_of

__all__ = [
    "Hull",
    "Hydrostatics",
    "Loading",
    "Rao",
    "Sea",
    "SeaState",
    "Station",
    "hull_from_particulars",
    "loading_of",
    "rao",
    "read_hull",
    "sea",
    "sea_states",
    "state_of",
]
