"""pmmkit: from captive ship-model tests to derivatives, a model and manoeuvres.

The words below are reached as ``pmmkit.reduce`` and so on; what stands behind one is imported when
it is first used.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any, Final

__version__ = "0.1.0"

if TYPE_CHECKING:
    from pmmkit.api import hull_table, model_of, reduce
    from pmmkit.checks import examine, refuse
    from pmmkit.diagnosis.adding import with_effect, without_effect
    from pmmkit.diagnosis.comparison import Comparison, compare
    from pmmkit.diagnosis.diagnose import diagnose
    from pmmkit.diagnosis.next_run import next_runs
    from pmmkit.diagnosis.options import Limits
    from pmmkit.diagnosis.own import own_effect, own_effects
    from pmmkit.diagnosis.programme import plan
    from pmmkit.diagnosis.session import fit
    from pmmkit.effects.catalogue import catalogue
    from pmmkit.empirical import estimate
    from pmmkit.errors import PmmkitError
    from pmmkit.exports import export
    from pmmkit.identification import fit_to_forces, free_records, identify
    from pmmkit.model import (
        Model,
        estimated_model,
        full_scale,
        load_model,
        save_model,
        scaled,
        to_model,
    )
    from pmmkit.reduction import Reduction, contributions, reduce_campaign
    from pmmkit.report import write_report
    from pmmkit.runs.campaign_file import open_campaign
    from pmmkit.runs.run import Campaign, Run
    from pmmkit.runs.store import load_campaign, save_campaign
    from pmmkit.ship import Ship, Water
    from pmmkit.ship_library import load_ship, ships
    from pmmkit.simulation import (
        Ensemble,
        Track,
        froude_sweep,
        imo_turning,
        imo_verdicts,
        monte_carlo,
        sensitivities,
        sobol,
        spiral_curve,
        stability,
        sweep,
    )
    from pmmkit.simulation.simulate import simulate
    from pmmkit.tables import DerivativeTable, converted, from_values, interpolate, read_table
    from pmmkit.tables import write as write_table
    from pmmkit.trials import evaluate_trials

__all__ = [
    "Campaign",
    "Comparison",
    "DerivativeTable",
    "Ensemble",
    "Limits",
    "Model",
    "PmmkitError",
    "Reduction",
    "Run",
    "Ship",
    "Track",
    "Water",
    "__version__",
    "catalogue",
    "compare",
    "contributions",
    "converted",
    "diagnose",
    "estimate",
    "estimated_model",
    "evaluate_trials",
    "examine",
    "export",
    "fit",
    "fit_to_forces",
    "free_records",
    "from_values",
    "froude_sweep",
    "full_scale",
    "hull_table",
    "identify",
    "imo_turning",
    "imo_verdicts",
    "interpolate",
    "load_campaign",
    "load_model",
    "load_ship",
    "model_of",
    "monte_carlo",
    "next_runs",
    "open_campaign",
    "own_effect",
    "own_effects",
    "plan",
    "read_table",
    "reduce",
    "reduce_campaign",
    "refuse",
    "save_campaign",
    "save_model",
    "scaled",
    "sensitivities",
    "ships",
    "simulate",
    "sobol",
    "spiral_curve",
    "stability",
    "sweep",
    "to_model",
    "with_effect",
    "without_effect",
    "write_report",
    "write_table",
]

_HOMES: Final = {
    "api": ("hull_table", "model_of", "reduce"),
    "checks": ("examine", "refuse"),
    "diagnosis.adding": ("with_effect", "without_effect"),
    "diagnosis.comparison": ("Comparison", "compare"),
    "diagnosis.diagnose": ("diagnose",),
    "diagnosis.own": ("own_effect", "own_effects"),
    "diagnosis.session": ("fit",),
    "diagnosis.next_run": ("next_runs",),
    "diagnosis.options": ("Limits",),
    "diagnosis.programme": ("plan",),
    "effects.catalogue": ("catalogue",),
    "errors": ("PmmkitError",),
    "exports": ("export",),
    "identification": ("fit_to_forces", "free_records", "identify"),
    "trials": ("evaluate_trials",),
    "empirical": ("estimate",),
    "model": (
        "Model",
        "estimated_model",
        "full_scale",
        "load_model",
        "save_model",
        "scaled",
        "to_model",
    ),
    "reduction": ("Reduction", "contributions", "reduce_campaign"),
    "report": ("write_report",),
    "runs.campaign_file": ("open_campaign",),
    "runs.run": ("Campaign", "Run"),
    "runs.store": ("load_campaign", "save_campaign"),
    "ship": ("Ship", "Water"),
    "ship_library": ("load_ship", "ships"),
    "simulation": (
        "Ensemble",
        "Track",
        "froude_sweep",
        "imo_turning",
        "imo_verdicts",
        "monte_carlo",
        "sensitivities",
        "simulate",
        "sobol",
        "spiral_curve",
        "stability",
        "sweep",
    ),
    "tables": ("DerivativeTable", "converted", "from_values", "interpolate", "read_table"),
}
_RENAMED: Final = {"write_table": ("tables", "write")}
_PLACES: Final = {name: (home, name) for home, names in _HOMES.items() for name in names} | _RENAMED


def __getattr__(name: str) -> Any:
    if name not in _PLACES:
        raise AttributeError(f"module 'pmmkit' has no attribute {name!r}")
    home, word = _PLACES[name]
    value = getattr(import_module(f"pmmkit.{home}"), word)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return sorted({*globals(), *_PLACES})
