"""pmmkit: from captive ship-model tests to derivatives, a model and manoeuvres.

The public words are reached as ``pmmkit.reduce`` and so on; what stands behind a word is imported
when it is used.
"""

from typing import TYPE_CHECKING

from pmmkit.base import lazy

if TYPE_CHECKING:
    from pmmkit.api import carried_to, citation, model_of, reduce
    from pmmkit.base import PmmkitError, __version__
    from pmmkit.campaigns import Campaign, Run, load_campaign, open_campaign, save_campaign
    from pmmkit.cards import Card, read_card, ship_from_card
    from pmmkit.conventions import Ship, Water
    from pmmkit.diagnosis import Limits, Session, begin, diagnose, fit, next_runs, plan, replay
    from pmmkit.effects import (
        Effect,
        Parameter,
        catalogue,
        effect,
        own_effect,
        own_effects,
        register_effect,
    )
    from pmmkit.exports import export
    from pmmkit.identification import (
        FreeRecord,
        compare_methods,
        evaluate_trials,
        fit_to_forces,
        free_records,
        identify,
    )
    from pmmkit.imo import imo_turning, imo_verdicts
    from pmmkit.intake import examine, refuse
    from pmmkit.models import (
        DerivativeTable,
        Model,
        converted,
        estimate,
        estimated_model,
        from_values,
        full_scale,
        hull_table,
        interpolate,
        load_model,
        load_ship,
        read_table,
        save_model,
        scaled,
        ships,
        to_model,
        with_effect,
        without_effect,
        write_table,
    )
    from pmmkit.reduction import (
        Budget,
        Reduction,
        contributions,
        derivative_budget,
        grid_study,
        grid_uncertainty,
        imo_budget,
        manoeuvre_budget,
        reduce_campaign,
        with_grids,
    )
    from pmmkit.seakeeping import (
        Place,
        added_resistance,
        hull_from_particulars,
        load_hull,
        rao,
        read_hull,
        read_rao,
        response,
        sea,
    )
    from pmmkit.simulation import (
        Ensemble,
        Track,
        froude_sweep,
        monte_carlo,
        sensitivities,
        simulate,
        sobol,
        spiral_curve,
        stability,
        sweep,
    )
    from pmmkit.validation import Comparison, compare, compare_submission, errors_in_percent
    from pmmkit.views import write_report

__all__ = [
    "Budget",
    "Campaign",
    "Card",
    "Comparison",
    "DerivativeTable",
    "Effect",
    "Ensemble",
    "FreeRecord",
    "Limits",
    "Model",
    "Parameter",
    "Place",
    "PmmkitError",
    "Reduction",
    "Run",
    "Session",
    "Ship",
    "Track",
    "Water",
    "__version__",
    "added_resistance",
    "begin",
    "carried_to",
    "catalogue",
    "citation",
    "compare",
    "compare_methods",
    "compare_submission",
    "contributions",
    "converted",
    "derivative_budget",
    "diagnose",
    "effect",
    "errors_in_percent",
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
    "grid_study",
    "grid_uncertainty",
    "hull_from_particulars",
    "hull_table",
    "identify",
    "imo_budget",
    "imo_turning",
    "imo_verdicts",
    "interpolate",
    "load_campaign",
    "load_hull",
    "load_model",
    "load_ship",
    "manoeuvre_budget",
    "model_of",
    "monte_carlo",
    "next_runs",
    "open_campaign",
    "own_effect",
    "own_effects",
    "plan",
    "rao",
    "read_card",
    "read_hull",
    "read_rao",
    "read_table",
    "reduce",
    "reduce_campaign",
    "refuse",
    "register_effect",
    "replay",
    "response",
    "save_campaign",
    "save_model",
    "scaled",
    "sea",
    "sensitivities",
    "ship_from_card",
    "ships",
    "simulate",
    "sobol",
    "spiral_curve",
    "stability",
    "sweep",
    "to_model",
    "with_effect",
    "with_grids",
    "without_effect",
    "write_report",
    "write_table",
]

lazy(__name__)
