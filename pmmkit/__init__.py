"""pmmkit: from captive ship-model tests to derivatives, a model and manoeuvres.

The words below are reached as ``pmmkit.reduce`` and so on; what stands behind one is imported when
it is first used.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any, Final

from pmmkit.version import __version__

if TYPE_CHECKING:
    from pmmkit.api import hull_table, model_of, reduce
    from pmmkit.campaigns.file.campaign_file import open_campaign
    from pmmkit.campaigns.run import Campaign, Run
    from pmmkit.campaigns.store import load_campaign, save_campaign
    from pmmkit.checks import examine, refuse
    from pmmkit.diagnosis.diagnose import diagnose
    from pmmkit.effects.catalogue import catalogue
    from pmmkit.effects.grammar import own_effect, own_effects
    from pmmkit.empirical import estimate
    from pmmkit.errors import PmmkitError
    from pmmkit.exports import export
    from pmmkit.identification import fit_to_forces, free_records, identify
    from pmmkit.loop.session import fit
    from pmmkit.models import (
        Model,
        estimated_model,
        full_scale,
        load_model,
        save_model,
        scaled,
        to_model,
    )
    from pmmkit.models.edit import with_effect, without_effect
    from pmmkit.reduction import Reduction, contributions, reduce_campaign
    from pmmkit.report import write_report
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
    from pmmkit.test_planning.next_run import next_runs
    from pmmkit.test_planning.options import Limits
    from pmmkit.test_planning.programme import plan
    from pmmkit.trials import evaluate_trials
    from pmmkit.validation.comparison import Comparison, compare

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
    "models.edit": ("with_effect", "without_effect"),
    "validation.comparison": ("Comparison", "compare"),
    "diagnosis.diagnose": ("diagnose",),
    "effects.grammar": ("own_effect", "own_effects"),
    "loop.session": ("fit",),
    "test_planning.next_run": ("next_runs",),
    "test_planning.options": ("Limits",),
    "test_planning.programme": ("plan",),
    "effects.catalogue": ("catalogue",),
    "errors": ("PmmkitError",),
    "exports": ("export",),
    "identification": ("fit_to_forces", "free_records", "identify"),
    "trials": ("evaluate_trials",),
    "empirical": ("estimate",),
    "models": (
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
    "campaigns.file.campaign_file": ("open_campaign",),
    "campaigns.run": ("Campaign", "Run"),
    "campaigns.store": ("load_campaign", "save_campaign"),
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
