"""Models of ships: parts, derivative tables, the library, and estimates from particulars."""

from typing import TYPE_CHECKING

from pmmkit.base import lazy

if TYPE_CHECKING:
    from pmmkit.models.astern import (
        DEDUCTION,
        DEDUCTION_STD,
        ESTIMATED,
        as_it_stops,
        astern_can_be_estimated,
        knows_astern,
        reversed_by_bucket,
        with_estimated_astern,
    )
    from pmmkit.models.build import HULL_TERMS, NEEDED, Missing, to_model
    from pmmkit.models.by_depth import NEARLY, carried_by_formulas, grown, model_at_depth
    from pmmkit.models.changes import before_of, restored
    from pmmkit.models.edit import with_effect, without_effect
    from pmmkit.models.empirical import (
        METHODS,
        EmpiricalMethod,
        HullEstimate,
        StraightLine,
        estimate,
        straight_line,
    )
    from pmmkit.models.estimates import estimated_model, resistance_derivative, with_open_couplings
    from pmmkit.models.hull import hull_table
    from pmmkit.models.library import load_ship, number, ships
    from pmmkit.models.model import (
        DERIVATIVE_PARTS,
        FN_TOLERANCE,
        TAKE_PARTS,
        Model,
        Part,
        knows_heel,
        needs_roll,
        place_name,
    )
    from pmmkit.models.particulars import (
        LONGEST_MODEL,
        STATED,
        TOGETHER,
        parts_from_particulars,
        roll_from_particulars,
        straight_polynomial,
    )
    from pmmkit.models.provenance import (
        ASSUMED,
        Standing,
        any_across,
        drives,
        estimates_in,
        in_role,
        lacking,
        parts_of,
        standing,
        steers,
    )
    from pmmkit.models.records import FileReader, entries
    from pmmkit.models.reference import ReferenceTable, published_of, reference_of
    from pmmkit.models.revise import TURNS, lent, with_part_of, with_stated, with_stated_parts
    from pmmkit.models.scale import full_scale, scaled
    from pmmkit.models.stated_parts import (
        OPEN_WATER,
        SECTIONS,
        WANTED,
        numbers_of,
        problems_of,
        words_of,
    )
    from pmmkit.models.step import Step, Value, added, faults_of, odds
    from pmmkit.models.store import load_model, model_text, read_steps, save_model
    from pmmkit.models.straight import HELD, held_straight
    from pmmkit.models.tables.by_depth import RATIO, TablesByDepth, in_step
    from pmmkit.models.tables.compare import Reference, alike, compare, worst_deviation
    from pmmkit.models.tables.convert import converted
    from pmmkit.models.tables.interpolate import interpolate
    from pmmkit.models.tables.io import is_table, read_table, write_table
    from pmmkit.models.tables.io.text import sidecar_of
    from pmmkit.models.tables.table import CONFIDENCE, DerivativeTable, from_values
    from pmmkit.models.tables.verdict import KEY, MISFIT, TableVerdict
    from pmmkit.models.terms import home_of
    from pmmkit.models.vessel import Sailing, moves_of, told

__all__ = [
    "ASSUMED",
    "CONFIDENCE",
    "DEDUCTION",
    "DEDUCTION_STD",
    "DERIVATIVE_PARTS",
    "ESTIMATED",
    "FN_TOLERANCE",
    "HELD",
    "HULL_TERMS",
    "KEY",
    "LONGEST_MODEL",
    "METHODS",
    "MISFIT",
    "NEARLY",
    "NEEDED",
    "OPEN_WATER",
    "RATIO",
    "SECTIONS",
    "STATED",
    "TAKE_PARTS",
    "TOGETHER",
    "TURNS",
    "WANTED",
    "DerivativeTable",
    "EmpiricalMethod",
    "FileReader",
    "HullEstimate",
    "Missing",
    "Model",
    "Part",
    "Reference",
    "ReferenceTable",
    "Sailing",
    "Standing",
    "Step",
    "StraightLine",
    "TableVerdict",
    "TablesByDepth",
    "Value",
    "added",
    "alike",
    "any_across",
    "as_it_stops",
    "astern_can_be_estimated",
    "before_of",
    "carried_by_formulas",
    "compare",
    "converted",
    "drives",
    "entries",
    "estimate",
    "estimated_model",
    "estimates_in",
    "faults_of",
    "from_values",
    "full_scale",
    "grown",
    "held_straight",
    "home_of",
    "hull_table",
    "in_role",
    "in_step",
    "interpolate",
    "is_table",
    "knows_astern",
    "knows_heel",
    "lacking",
    "lent",
    "load_model",
    "load_ship",
    "model_at_depth",
    "model_text",
    "moves_of",
    "needs_roll",
    "number",
    "numbers_of",
    "odds",
    "parts_from_particulars",
    "parts_of",
    "place_name",
    "problems_of",
    "published_of",
    "read_steps",
    "read_table",
    "reference_of",
    "resistance_derivative",
    "restored",
    "reversed_by_bucket",
    "roll_from_particulars",
    "save_model",
    "scaled",
    "ships",
    "sidecar_of",
    "standing",
    "steers",
    "straight_line",
    "straight_polynomial",
    "to_model",
    "told",
    "with_effect",
    "with_estimated_astern",
    "with_open_couplings",
    "with_part_of",
    "with_stated",
    "with_stated_parts",
    "without_effect",
    "words_of",
    "worst_deviation",
    "write_table",
]

lazy(__name__)
