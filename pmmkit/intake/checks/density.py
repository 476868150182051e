"""Forces that may be per density of the water."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping, Sequence
from typing import TYPE_CHECKING

from pmmkit.campaigns import Run
from pmmkit.intake.checks.finding import Check, CheckFinding

if TYPE_CHECKING:
    import xarray as xr

    from pmmkit.campaigns import Campaign
    from pmmkit.intake.checks.finding import Summary


def density_facts(data: xr.Dataset) -> Mapping[str, float]:
    """Whether the notes of the conversions doubt the density of a run's forces."""
    said = json.loads(data.attrs.get("conversions", "[]"))
    doubted = any(note.startswith(Run.DOUBTFUL) and "rho_inf" in note for note in said)
    return {"density_doubted": 1.0} if doubted else {}


def examine_density(_campaign: Campaign, summaries: Sequence[Summary]) -> Iterator[CheckFinding]:
    """Runs of an incompressible flow for which nobody says what multiplies the pressure."""
    runs = tuple(each.run.id for each in summaries if each.facts.get("density_doubted"))
    if runs:
        yield CheckFinding(
            check="density",
            severity="warning",
            message="The solver computes an incompressible flow with rhoInf 1 or none, so the "
            "forces may be per density, a thousand times too small.",
            runs=runs,
            remedy="Write rho_inf = 1.0 under [cfd] if they are, or rho_inf = rho if not.",
        )


CHECKS = (Check("density", "forces of a computation that may be per density", examine_density),)
