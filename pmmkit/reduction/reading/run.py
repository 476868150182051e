"""Reading one run: what is kept of it is small, however long its record."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace

from pmmkit.campaigns import Campaign, Run, TypeB
from pmmkit.conventions import Convention
from pmmkit.intake import KnownHistory, Summary, summarise
from pmmkit.reduction.derivatives import DerivativeNames
from pmmkit.reduction.observations.equations import Rows, Sensitivity, rows_of, sensitivity
from pmmkit.reduction.observations.histories import RunHistory, history_of
from pmmkit.reduction.observations.prepare import CycleChoice, PreparedRun

# Blockage of the tank: how much faster the water passes the model than the carriage says.


def speed_increase(campaign: Campaign, speed: float) -> float | None:
    """Mean increase of the water's speed beside the model, as a share of the carriage's.

    One-dimensional continuity with the lowered surface: m/(1 - m - Fh²), m the model's midship
    section over the tank's and Fh the Froude number on the tank's depth. A mean over the section:
    a first estimate, not a wall correction of moments.

    speed [m/s].

    Examples
    --------
    >>> from pmmkit.conventions import Ship, Water
    >>> ship = Ship(name="m", L=6.9, B=1.25, d=.45, volume=3.1, mass=3100., Izz=9500.)
    >>> tank = Water(tank_width=14.0, tank_depth=6.0)
    >>> round(speed_increase(Campaign(title="", ship=ship, water=tank, runs=()), 1.17), 5)
    0.0069
    """
    water, ship = campaign.water, campaign.ship
    depth = water.depth or water.tank_depth
    if water.tank_width is None or depth is None:
        return None
    section = ship.B * ship.d / (water.tank_width * depth)
    room = 1 - section - speed**2 / (water.g * depth)
    return section / room if room > 0 else None


@dataclass(frozen=True, kw_only=True)
class ReductionSettings:
    """How the runs of a campaign are read.

    `campaign`: ship, water, rig and uncertainties; its runs are not looked at. `columns`: the
    derivatives that may be asked for. `convention`: meaning of the derivatives. `library`:
    derivatives whose regressors are wanted over time; no histories are kept without.
    """

    campaign: Campaign
    columns: DerivativeNames
    convention: Convention
    cycles: CycleChoice
    blockage: str
    integrated: bool = False
    library: Mapping[str, tuple[str, ...]] | None = None

    @property
    def sources(self) -> tuple[TypeB, ...]:
        """Stated uncertainties; the numerical one of a solver is a zero error of all runs."""
        numerical = (
            TypeB(name=f"{channel}_gauge", std=float(std), shared=True)
            for channel, std in self.campaign.numerical.items()
        )
        return (*self.campaign.uncertainty, *numerical)


@dataclass(frozen=True, kw_only=True, eq=False)
class Reading:
    """What is kept of one run.

    `sensitivities`: how they change with each stated uncertainty. `summary`: what the checks
    look at. `history`: the run over time, where the settings ask for it.
    """

    rows: Rows
    sensitivities: tuple[Sensitivity, ...]
    summary: Summary
    history: RunHistory | None = None


def read_run(run: Run, settings: ReductionSettings) -> Reading:
    """Read the samples of a run once and keep what the reduction needs."""
    data = run.data
    once = run.with_(loader=lambda: data)
    prepared = PreparedRun.of(
        once, settings.campaign, cycles=settings.cycles, integrated=settings.integrated
    )
    rows, changes, history = _equations(prepared, once, settings)
    known = KnownHistory(
        channels=tuple(prepared.result.measured),
        window=prepared.window,
        counted=prepared.counted,
        motion=prepared.motion,
    )
    kept = run.with_(settings=rows.result.run.settings)
    return Reading(
        rows=replace(rows, result=replace(rows.result, run=kept)),
        sensitivities=tuple(changes),
        summary=replace(summarise(once, settings.campaign, known=known), run=run),
        history=history,
    )


def _equations(
    prepared: PreparedRun, run: Run, settings: ReductionSettings
) -> tuple[Rows, Iterator[Sensitivity], RunHistory | None]:
    """What a run says about the derivatives, how that changes with the uncertainties, over time."""
    campaign = settings.campaign
    rig = campaign.rig
    share = speed_increase(campaign, run.settings.speed) if settings.blockage == "correct" else None
    names = {
        channel: listed
        for channel, listed in settings.columns.names.items()
        if channel in prepared.result.measured
    }
    rows = rows_of(prepared, campaign, rig, names, settings.convention, blockage=share or 0.0)
    changes = (
        sensitivity(rows, source, campaign, rig, names, settings.convention)
        for source in settings.sources
    )
    if settings.library is None:
        return rows, changes, None
    wanted = {channel: own for channel, own in settings.library.items() if channel in names}
    history = history_of(
        prepared, run, campaign, rig, wanted, settings.convention, blockage=share or 0.0
    )
    return rows, changes, history
