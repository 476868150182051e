"""Models of ships: parts, derivative tables, the library, and estimates from particulars."""

from typing import TYPE_CHECKING

from pmmkit.base import lazy

if TYPE_CHECKING:
    from pmmkit.models.build import Missing, to_model
    from pmmkit.models.by_depth import model_at_depth
    from pmmkit.models.edit import with_effect, without_effect
    from pmmkit.models.empirical import HullEstimate, estimate
    from pmmkit.models.estimates import estimated_model, with_open_couplings
    from pmmkit.models.library import load_ship, number, ships
    from pmmkit.models.model import Model
    from pmmkit.models.part import Part
    from pmmkit.models.particulars import hull_less_model, straight_polynomial
    from pmmkit.models.provenance import Standing
    from pmmkit.models.records import FileReader
    from pmmkit.models.reference import ReferenceTable, hull_table
    from pmmkit.models.revise import lent, with_part_of, with_stated
    from pmmkit.models.scale import full_scale, scaled
    from pmmkit.models.stated_parts import SECTIONS
    from pmmkit.models.step import Step, odds
    from pmmkit.models.store import load_model, model_text, save_model
    from pmmkit.models.tables.by_depth import TablesByDepth
    from pmmkit.models.tables.compare import alike, compare
    from pmmkit.models.tables.convert import converted
    from pmmkit.models.tables.interpolate import interpolate
    from pmmkit.models.tables.io import read_table, write_table
    from pmmkit.models.tables.table import DerivativeTable, TableVerdict, from_values
    from pmmkit.models.vessel import Sailing

__all__ = [
    "SECTIONS",
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
    "compare",
    "converted",
    "estimate",
    "estimated_model",
    "from_values",
    "full_scale",
    "hull_less_model",
    "hull_table",
    "interpolate",
    "lent",
    "load_model",
    "load_ship",
    "model_at_depth",
    "model_text",
    "number",
    "odds",
    "read_table",
    "save_model",
    "scaled",
    "ships",
    "straight_polynomial",
    "to_model",
    "with_effect",
    "with_open_couplings",
    "with_part_of",
    "with_stated",
    "without_effect",
    "write_table",
]

lazy(__name__)
