"""Seakeeping: seas, hulls in sections, strip theory, responses and added resistance."""

from typing import TYPE_CHECKING

from pmmkit.base import lazy

if TYPE_CHECKING:
    from pmmkit.seakeeping.answers import Place, Response
    from pmmkit.seakeeping.explanation import Explained, explained
    from pmmkit.seakeeping.figures import beside_measured
    from pmmkit.seakeeping.hull_forms.hull import Hull
    from pmmkit.seakeeping.hull_forms.offsets import read_hull
    from pmmkit.seakeeping.hull_forms.particulars import (
        hull_from_particulars,
        hull_of,
        hulls,
        load_hull,
    )
    from pmmkit.seakeeping.ikeda import RollDamping, ikeda_damping
    from pmmkit.seakeeping.loading import Loading, loading_of
    from pmmkit.seakeeping.measured import MeasuredTransfer, RaoComparison, beside
    from pmmkit.seakeeping.motions import frequencies, rao
    from pmmkit.seakeeping.operating_limits import Operability, operability
    from pmmkit.seakeeping.records import read_record, together
    from pmmkit.seakeeping.responses import response
    from pmmkit.seakeeping.seas import Sea, SeaState, sea, sea_states
    from pmmkit.seakeeping.second_order.added_resistance import AddedResistance, added_resistance
    from pmmkit.seakeeping.second_order.in_manoeuvre import drift_part, in_waves, motions_in
    from pmmkit.seakeeping.superposition import MotionInWaves, superposed
    from pmmkit.seakeeping.transfer import Rao

__all__ = [
    "AddedResistance",
    "Explained",
    "Hull",
    "Loading",
    "MeasuredTransfer",
    "MotionInWaves",
    "Operability",
    "Place",
    "Rao",
    "RaoComparison",
    "Response",
    "RollDamping",
    "Sea",
    "SeaState",
    "added_resistance",
    "beside",
    "beside_measured",
    "drift_part",
    "explained",
    "frequencies",
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
    "superposed",
    "together",
]

lazy(__name__)
