"""Reading one run: what is kept of it is small, however long its record."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace

from pmmkit.campaigns.motion.inertia import rig_of
from pmmkit.campaigns.run import Campaign, Run
from pmmkit.campaigns.uncertainty import TypeB
from pmmkit.checks import Known, Summary, summarise
from pmmkit.conventions import Convention
from pmmkit.observations.blockage import speed_increase
from pmmkit.observations.equations import Rows, Sensitivity, rows_of, sensitivity
from pmmkit.observations.histories import History, history_of
from pmmkit.observations.prepare import CycleChoice, Prepared, prepare
from pmmkit.reduction.derivatives import Columns


@dataclass(frozen=True, kw_only=True)
class ReductionSettings:
    """How the runs of a campaign are read.

    Parameters
    ----------
    campaign : Campaign
        Ship, water, rig and uncertainties; its runs are not looked at.
    columns : Columns
        The derivatives that may be asked for.
    convention : Convention
        Meaning of the derivatives.
    cycles, blockage
        As for `reduce_campaign`.
    integrated : bool
        As for `prepare`.
    library : mapping of channel to names, optional
        Derivatives whose regressors are wanted over time; no histories are kept without.
    """

    campaign: Campaign
    columns: Columns
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

    Parameters
    ----------
    rows : Rows
        Its equations.
    sensitivities : tuple of Sensitivity
        How they change with each stated uncertainty.
    summary : Summary
        What the checks look at.
    history : History or None
        The run over time, where the settings ask for it.
    """

    rows: Rows
    sensitivities: tuple[Sensitivity, ...]
    summary: Summary
    history: History | None = None


def read_run(run: Run, settings: ReductionSettings) -> Reading:
    """Read the samples of a run once and keep what the reduction needs.

    Parameters
    ----------
    run : Run
        The run.
    settings : ReductionSettings
        How.

    Raises
    ------
    DataError
        If the run cannot be read or reduced.
    """
    data = run.data
    once = run.with_(loader=lambda: data)
    prepared = prepare(
        once, settings.campaign, cycles=settings.cycles, integrated=settings.integrated
    )
    rows, changes, history = _equations(prepared, once, settings)
    known = Known(
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
    prepared: Prepared, run: Run, settings: ReductionSettings
) -> tuple[Rows, Iterator[Sensitivity], History | None]:
    """What a run says about the derivatives, how that changes with the uncertainties, over time."""
    campaign = settings.campaign
    rig = rig_of(campaign)
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
