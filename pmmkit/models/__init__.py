"""Models of ships: parts, derivative tables, the library, and estimates from particulars."""

from typing import TYPE_CHECKING

from pmmkit.base import lazy

if TYPE_CHECKING:
    from pmmkit.models.astern import as_it_stops, with_estimated_astern
    from pmmkit.models.build import Missing, needed, to_model
    from pmmkit.models.by_depth import carried_by_formulas, grown, model_at_depth
    from pmmkit.models.changes import before_of, restored
    from pmmkit.models.edit import with_effect, without_effect
    from pmmkit.models.empirical import METHODS, HullEstimate, estimate
    from pmmkit.models.estimates import estimated_model, of_a_model, with_open_couplings
    from pmmkit.models.library import load_ship, number, ships
    from pmmkit.models.model import TAKE_PARTS, Model, Part
    from pmmkit.models.particulars import (
        TOGETHER,
        hull_less_model,
        roll_from_particulars,
        straight_polynomial,
    )
    from pmmkit.models.provenance import Standing, missing_parts
    from pmmkit.models.records import FileReader, entries
    from pmmkit.models.reference import ReferenceTable, hull_table
    from pmmkit.models.revise import lent, with_part_of, with_stated, with_stated_parts
    from pmmkit.models.scale import full_scale, scaled
    from pmmkit.models.stated_parts import SECTIONS
    from pmmkit.models.step import Step, odds
    from pmmkit.models.store import load_model, model_text, save_model
    from pmmkit.models.straight import held_straight
    from pmmkit.models.tables.by_depth import TablesByDepth
    from pmmkit.models.tables.compare import alike, compare
    from pmmkit.models.tables.convert import converted
    from pmmkit.models.tables.interpolate import interpolate
    from pmmkit.models.tables.io import read_table, write_table
    from pmmkit.models.tables.table import DerivativeTable, from_values
    from pmmkit.models.tables.verdict import TableVerdict
    from pmmkit.models.vessel import Sailing

__all__ = [
    "METHODS",
    "SECTIONS",
    "TAKE_PARTS",
    "TOGETHER",
    "DerivativeTable",
    "FileReader",
    "HullEstimate",
    "Missing",
    "Model",
    "Part",
    "ReferenceTable",
    "Sailing",
    "Standing",
    "Step",
    "TableVerdict",
    "TablesByDepth",
    "alike",
    "as_it_stops",
    "before_of",
    "carried_by_formulas",
    "compare",
    "converted",
    "entries",
    "estimate",
    "estimated_model",
    "from_values",
    "full_scale",
    "grown",
    "held_straight",
    "hull_less_model",
    "hull_table",
    "interpolate",
    "lent",
    "load_model",
    "load_ship",
    "missing_parts",
    "model_at_depth",
    "model_text",
    "needed",
    "number",
    "odds",
    "of_a_model",
    "read_table",
    "restored",
    "roll_from_particulars",
    "save_model",
    "scaled",
    "ships",
    "straight_polynomial",
    "to_model",
    "with_effect",
    "with_estimated_astern",
    "with_open_couplings",
    "with_part_of",
    "with_stated",
    "with_stated_parts",
    "without_effect",
    "write_table",
]

lazy(__name__)
