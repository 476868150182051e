"""Seakeeping: seas, hulls in sections, strip theory, responses and added resistance."""

from pmmkit.seakeeping.answers import AtPlace, Moments, Place, Response
from pmmkit.seakeeping.explained import Explained, explained
from pmmkit.seakeeping.hulls.hull import Hull, Hydrostatics, Station
from pmmkit.seakeeping.hulls.library import hull_of, hulls, load_hull
from pmmkit.seakeeping.hulls.offsets import read_hull
from pmmkit.seakeeping.hulls.particulars import hull_from_particulars
from pmmkit.seakeeping.ikeda import RollDamping, ikeda_damping
from pmmkit.seakeeping.loading import Loading, loading_of
from pmmkit.seakeeping.measured import Measured, RaoComparison, beside, from_irregular, from_regular
from pmmkit.seakeeping.motions import frequencies, rao
from pmmkit.seakeeping.operability import LIMITS, Operability, operability
from pmmkit.seakeeping.records import MotionRecord, read_record, together
from pmmkit.seakeeping.responses import response
from pmmkit.seakeeping.seas import Sea, SeaState, sea, sea_states, state_of
from pmmkit.seakeeping.second_order.added_resistance import AddedResistance, added_resistance
from pmmkit.seakeeping.second_order.in_manoeuvre import drift_part, in_waves, motions_in
from pmmkit.seakeeping.second_order.mean_drift import drift, drift_table
from pmmkit.seakeeping.superposed import MotionInWaves, superposed
from pmmkit.seakeeping.transfer import Rao

__all__ = [
    "LIMITS",
    "AddedResistance",
    "AtPlace",
    "Explained",
    "Hull",
    "Hydrostatics",
    "Loading",
    "Measured",
    "Moments",
    "MotionInWaves",
    "MotionRecord",
    "Operability",
    "Place",
    "Rao",
    "RaoComparison",
    "Response",
    "RollDamping",
    "Sea",
    "SeaState",
    "Station",
    "added_resistance",
    "beside",
    "drift",
    "drift_part",
    "drift_table",
    "explained",
    "frequencies",
    "from_irregular",
    "from_regular",
    "hull_from_particulars",
    "hull_of",
    "hulls",
    "ikeda_damping",
    "in_waves",
    "load_hull",
    "loading_of",
    "motions_in",
    "operability",
    "rao",
    "read_hull",
    "read_record",
    "response",
    "sea",
    "sea_states",
    "state_of",
    "superposed",
    "together",
]
