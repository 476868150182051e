"""Seakeeping: seas, hulls in sections, strip theory, responses and added resistance."""

from typing import TYPE_CHECKING

from pmmkit.base import lazy

if TYPE_CHECKING:
    from pmmkit.seakeeping.hull_forms.hull import Hull
    from pmmkit.seakeeping.hull_forms.offsets import read_hull
    from pmmkit.seakeeping.hull_forms.particulars import hull_from_particulars, load_hull
    from pmmkit.seakeeping.ikeda import RollDamping
    from pmmkit.seakeeping.loading import Loading
    from pmmkit.seakeeping.motions import frequencies, rao
    from pmmkit.seakeeping.operating_limits import Operability
    from pmmkit.seakeeping.records import beside_records
    from pmmkit.seakeeping.responses import Place, Response, response
    from pmmkit.seakeeping.seas import Sea, sea, sea_states
    from pmmkit.seakeeping.second_order.added_resistance import AddedResistance, added_resistance
    from pmmkit.seakeeping.second_order.in_manoeuvre import drift_part, in_waves, motions_in
    from pmmkit.seakeeping.superposition import MotionInWaves, superposed
    from pmmkit.seakeeping.transfer import Rao
    from pmmkit.seakeeping.transfer_files import read_rao

__all__ = [
    "AddedResistance",
    "Hull",
    "Loading",
    "MotionInWaves",
    "Operability",
    "Place",
    "Rao",
    "Response",
    "RollDamping",
    "Sea",
    "added_resistance",
    "beside_records",
    "drift_part",
    "frequencies",
    "hull_from_particulars",
    "in_waves",
    "load_hull",
    "motions_in",
    "rao",
    "read_hull",
    "read_rao",
    "response",
    "sea",
    "sea_states",
    "superposed",
]

lazy(__name__)
