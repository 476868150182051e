"""From a campaign to a derivative table, run by run and then together."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from pmmkit.base import CampaignError, ContradictionError, Problem, Workers, __version__
from pmmkit.campaigns import Campaign
from pmmkit.conventions import CHANNEL_UNITS, CHANNELS, Convention, Structure
from pmmkit.intake import CheckFinding, Untold, examine, refuse
from pmmkit.models import DerivativeTable, TableVerdict
from pmmkit.numerics import one_thread
from pmmkit.presentation import Described, Section, counted
from pmmkit.reduction.agreement import Difference, differences, worst
from pmmkit.reduction.between_runs import between_runs
from pmmkit.reduction.choice import all_terms, largest_determined
from pmmkit.reduction.derivatives import DerivativeNames, columns_of
from pmmkit.reduction.groups import groups_at_odds
from pmmkit.reduction.influence import Influences, influences
from pmmkit.reduction.methods.families import by_family, by_run, library_of
from pmmkit.reduction.methods.method import Estimate, MethodInputs, channels_over_time
from pmmkit.reduction.methods.registry import ALL, METHODS, estimates, methods_of
from pmmkit.reduction.notes import Offset, misfits, notes, offsets
from pmmkit.reduction.observations.equations import Rows, Sensitivity, excited_alone
from pmmkit.reduction.observations.prepare import CycleChoice, RunResult
from pmmkit.reduction.observations.stated import idle
from pmmkit.reduction.odd_runs import at_odds, runs_at_odds, weighed_down
from pmmkit.reduction.propulsion import (
    Propulsion,
    Resistance,
    propulsion,
    resistance,
    thrust_inside,
)
from pmmkit.reduction.reading.all_runs import Means, read_all
from pmmkit.reduction.reading.run import ReductionSettings, speed_increase
from pmmkit.reduction.solve import Solution, froude_groups, measured_and_fitted, solve, to_table
from pmmkit.reduction.surge_zero import surge_zero
from pmmkit.reduction.verdict import verdict

if TYPE_CHECKING:
    import pandas as pd

    from pmmkit.plotting import Figure


# Sinkage and trim of straight runs: squat over the Froude number.


def squat(results: Sequence[RunResult]) -> pd.DataFrame:
    """Of steady runs without drift, turn, heel and rudder, a row per Froude number.

    Fn; means of sinkage [m], positive down, and trim [deg], as the file counts it, and the standard
    deviations between runs, NaN of a single one; runs.
    """
    import pandas as pd

    straight = [item for item in results if _straight(item)]
    rows = []
    for Fn, places in froude_groups([item.froude for item in straight]):
        own = [straight[place] for place in places]
        sinkage = _known([x.extras.get("sinkage") for x in own])
        trim = _known([x.extras.get("trim") for x in own])
        rows.append(
            {
                "Fn": Fn,
                "sinkage": _mean(sinkage),
                "sinkage_std": _deviation(sinkage),
                "trim_deg": math.degrees(_mean(trim)),
                "trim_std_deg": math.degrees(_deviation(trim)),
                "runs": len(own),
            }
        )
    return pd.DataFrame(rows)


def _straight(item: RunResult) -> bool:
    settings = item.run.settings
    turned = (settings.drift, settings.rudder, settings.heel, settings.turn_rate)
    return (
        not item.run.dynamic
        and bool({"sinkage", "trim"} & set(item.extras))
        and not any(turned)
        and math.isfinite(item.froude)
    )


def _known(values: Sequence[float | None]) -> list[float]:
    return [x for x in values if x is not None and math.isfinite(x)]


def _mean(known: Sequence[float]) -> float:
    return float(np.mean(known)) if known else math.nan


def _deviation(known: Sequence[float]) -> float:
    return float(np.std(known, ddof=1)) if len(known) > 1 else math.nan


Progress = Callable[[int, int, str], None]
OddRuns = Literal["tell", "weigh", "refuse"]
THIRD = 3
"""Cycle over which papers integrate, the first two being transient."""


@dataclass(frozen=True, kw_only=True, eq=False, repr=False)
class Reduction(Described):
    """Everything a reduction found.

    Parameters
    ----------
    table : DerivativeTable
        The derivatives by the method asked for, by default one global regression per Froude
        number.
    method : str
        The method of the table, a key of `estimates`.
    estimates : dict of str to Estimate
        By each method, the global regression first.
    runs : tuple of RunResult
        Mean or harmonics of each run.
    findings : tuple of CheckFinding
        What the checks found.
    offsets : tuple of Offset
        Zero offsets of Y, N and K.
    notes : tuple of str
        What a reader should know, in words.
    resistance, propulsion : Resistance, Propulsion or None
        What the straight runs give.
    campaign : Campaign
        What was reduced.
    rows : tuple of Rows
        The equations of each run.
    sensitivities : tuple of tuple of Sensitivity
        How they change with each stated uncertainty.
    columns : DerivativeNames
        The derivatives asked for.
    convention : Convention
        Meaning of the derivatives.
    solution : Solution
        The fits behind the table.
    because : str
        Why the structure was taken, where the runs chose it.
    influences : Influences
        What each run does to each derivative, and which are at odds with the others.
    families : dict of str to DerivativeTable
        The derivatives from each family of tests alone, by its title.
    verdict : TableVerdict
        Whether the table can be used, what stands against it, and on what that hangs; the table
        keeps it.
    untold : tuple of Untold
        What the runs cannot tell of their own errors, what most hangs on first; in the notes too.
    """

    table: DerivativeTable
    method: str
    estimates: dict[str, Estimate]
    runs: tuple[RunResult, ...]
    findings: tuple[CheckFinding, ...]
    offsets: tuple[Offset, ...]
    notes: tuple[str, ...]
    resistance: Resistance | None
    propulsion: Propulsion | None
    campaign: Campaign
    rows: tuple[Rows, ...]
    sensitivities: tuple[tuple[Sensitivity, ...], ...]
    columns: DerivativeNames
    convention: Convention
    solution: Solution
    influences: Influences
    families: dict[str, DerivativeTable]
    verdict: TableVerdict
    untold: tuple[Untold, ...] = ()
    because: str = ""

    @cached_property
    def single_runs(self) -> dict[str, DerivativeTable]:
        """The derivatives from each oscillating run alone, by its id."""
        with one_thread():
            return by_run(
                self.rows,
                self.sensitivities,
                self.columns,
                self.solution,
                self.campaign,
                self.convention,
            )

    @cached_property
    def differences(self) -> tuple[Difference, ...]:
        """Derivatives for which neither 95 % interval holds the other method's value, and why."""
        return differences(self.estimates, self.families)

    def farthest(self, method: str) -> Difference | None:
        """The derivative for which a method is farthest from the regression; None without any."""
        return worst(self.estimates, method)

    @property
    def way(self) -> str:
        """By which method the table was found, in words."""
        if self.method == next(iter(METHODS)):
            return "one regression over all runs weighted with the noise of their records"
        return f"{self.estimates[self.method].method} ({METHODS[self.method].text[:-1]})"

    @property
    def speed_increase(self) -> float | None:
        """By what share the water passes the model faster between the walls, at the highest speed;
        None where the tank is not stated or the flow is critical."""
        return speed_increase(self.campaign, max(run.settings.speed for run in self.campaign.runs))

    @property
    def thrust_inside(self) -> tuple[int, ...]:
        """Froude groups in which Xuu holds thrust."""
        return thrust_inside(self.solution, self.rows)

    def squat_to_pandas(self) -> pd.DataFrame:
        """Sinkage and trim straight ahead: a row per Froude number; none where not measured."""
        return squat(self.runs)

    def runs_to_pandas(self) -> pd.DataFrame:
        """A row per run: settings, window, cycles, harmonics [N, N m], sinkage, trim …"""
        import pandas as pd

        return pd.DataFrame([_run_row(item) for item in self.runs])

    def plot(self) -> Figure:
        """What the fit leaves of the measured means and harmonics, by channel."""
        from pmmkit.reduction.figures import left_by_the_fit

        return left_by_the_fit(measured_and_fitted(self.rows, self.solution), CHANNEL_UNITS)

    def _headline(self) -> str:
        title = self.campaign.title or self.campaign.ship.name
        return f"{title}: {counted(len(self.runs), 'run')} to {self.table._headline()}"

    def _sections(self) -> Sequence[Section]:
        loud = [str(item) for item in self.findings if item.severity != "info"]
        quiet = len(self.findings) - len(loud)
        checks = [*loud, *([f"and {counted(quiet, 'remark')}"] if quiet else [])]
        left = [f"{run.id}: {reason}" for run, reason in self.campaign.excluded]
        lists = [
            Section(title="Checks", points=checks or ["they found nothing to say"]),
            Section(title="Left out", points=left),
            Section(title="What the runs do not tell", points=self.notes),
        ]
        beside = (
            f"By family of tests as well: {', '.join(self.families)}; by "
            f"{counted(len(self.single_runs), 'single run')}."
        )
        judged = self.verdict
        doubts = [Section(title="Doubts", points=judged.reasons)] if judged.reasons else []
        return [
            Section(paragraphs=[self.campaign.ship.words, beside, str(judged)]),
            *doubts,
            Section(title="Derivatives", tables=[self.table.grid()]),
            *(section for section in lists if section.points),
        ]


@one_thread()
def reduce_campaign(
    campaign: Campaign,
    *,
    structure: str | Sequence[str] | Structure = "abkowitz3",
    fn: Literal["each", "pooled"] = "each",
    cycles: CycleChoice = None,
    carriage_speed: bool = False,
    blockage: Literal["report", "correct"] = "report",
    method: str = "regression",
    library: str | Sequence[str] | Structure | None = None,
    fourier: Literal["least-squares", "trapezoid"] = "least-squares",
    check: bool = True,
    odd_runs: OddRuns = "tell",
    progress: Progress | None = None,
    executor: Workers = None,
    memory: float = 1000.0,
    resume: Path | None = None,
) -> Reduction:
    """Reduce captive tests to derivatives.

    Each run is read once and cut to its steady window or its whole cycles; forces and regressors
    are projected onto means or harmonics; all runs of a Froude number are fitted together,
    weighted by the noise of their records.

    Parameters
    ----------
    campaign : Campaign
        The tests.
    structure : str, sequence of str or Structure
        Name of a structure or a list of derivatives; ``auto`` takes the largest structure of which
        the runs determine every term of side force and moment, and a note says why.
    fn : {"each", "pooled"}
        A set of derivatives per Froude number, or one over all speeds.
    cycles : int or (int, int), optional
        Take only this cycle, or these (the first is 1), of oscillating runs. By default the
        cycle-to-cycle test decides.
    carriage_speed : bool
        Make non-dimensional with the carriage speed instead of the instantaneous one. It shifts
        Yvvv by about Yv/2 and may flip the sign of Nvvv.
    blockage : {"report", "correct"}
        Whether the mean blockage of the tank is only reported or corrected for.
    method : str
        One of `pmmkit.reduction.methods.registry.METHODS`: ``regression``, ``harmonics``,
        ``sindy``, ``ekf``; or ``all`` for all of them side by side, with the table of the
        regression.
    library : str, sequence of str or Structure, optional
        Terms among which ``sindy`` chooses, beside those of the structure; by default those of
        all structures in the same variables.
    fourier : {"least-squares", "trapezoid"}
        Fourier coefficients for ``harmonics``: by least squares on the cycles that count, or by
        trapezoidal integrals over the third cycle (over `cycles` where given).
    check : bool
        Refuse data that contradict themselves.
    odd_runs : {"tell", "weigh", "refuse"}
        What becomes of a run at odds with the others: a warning, also less weight, or an error.
    progress : callable, optional
        Called with (runs done, runs in all, what is done).
    executor : int, str or concurrent.futures.Executor, optional
        Who reads the runs: so many processes of this machine, once reading takes long; by default
        as many as there are processors; 1 for this process alone. An executor, or a cluster by the
        address of its dask scheduler (``tcp://…``), reads all of them.
    memory : float
        What processes of this machine may take together [MB]; fewer read at a time where files are
        large.
    resume : path, optional
        Folder in which the results of runs are kept once reading takes long. A call that was
        interrupted goes on from there; the result is the same. The caller removes the folder.

    Returns
    -------
    Reduction
        The table and all that stands behind it.

    Raises
    ------
    ContradictionError
        If the checks find contradictions, or a run at odds with the others is to be refused.
    CampaignError
        If runs cannot be read; all problems of all runs at once. If they were made at several
        depths of the water: `reduce_depths` reduces each.
    """
    campaign = campaign.at_one_depth().within_reach().with_gauges_checked()
    free = structure == "auto"
    wanted = all_terms() if free else Structure.meant_by(structure)
    convention = Convention(
        system=wanted.system,
        surge=wanted.surge,
        U="carriage" if carriage_speed else "instantaneous",
    )
    tell = progress or _silent
    means = Means(executor=executor, memory=memory, kept=resume)
    chosen = methods_of(method)
    asked = columns_of(wanted, campaign.runs, CHANNELS)
    over_time = any(item.over_time for item in chosen)
    settings = ReductionSettings(
        campaign=campaign,
        columns=asked,
        convention=convention,
        cycles=cycles,
        blockage=blockage,
        library=library_of(asked, wanted, library) if over_time else None,
    )
    read = read_all(settings, tell, means)
    findings = examine(campaign, [item.summary for item in read])
    if check:
        refuse(findings)
    rows = tuple(item.rows for item in read)
    sensitivities = tuple(item.sensitivities for item in read)
    measured = {channel for item in rows for channel in item.force}
    groups = _groups(rows, fn)
    rows = _excited(rows, groups, campaign, convention)
    between = between_runs(rows, campaign, convention)
    because = ""
    if free:
        wanted, because = largest_determined(
            measured,
            lambda structure: columns_of(structure, campaign.runs, measured),
            lambda terms: solve(rows, sensitivities, terms, groups, between),
        )
    columns = columns_of(wanted, campaign.runs, measured)
    if not columns.required:
        raise CampaignError(
            f"The structure {wanted.name!r} has no derivative of the measured channels "
            f"({', '.join(sorted(measured))})."
        )
    tell(len(rows), len(rows), "fitting")
    solution = solve(rows, sensitivities, columns, groups, between)
    each = influences(solution, rows)
    odd = runs_at_odds(each, solution, rows, sensitivities, columns)
    if odd and odd_runs == "refuse":
        raise ContradictionError(
            [
                Problem(message=item.message, run=item.runs[0], remedy=item.remedy)
                for item in at_odds(odd)
            ],
            title="Runs are at odds with the others",
        )
    if odd and odd_runs == "weigh":
        rows = weighed_down(rows, solution, odd)
        solution = solve(rows, sensitivities, columns, groups, solution.between.unknown())
    results = tuple(item.result for item in rows)
    curve = resistance(results)
    table = to_table(
        solution,
        columns,
        campaign,
        convention,
        method="global regression",
        provenance={
            **_provenance(campaign, results, wanted, fn, cycles, blockage),
            "misfit": list(misfits(solution)),
        },
    )
    hidden = Untold.of(campaign, [item.summary for item in read], values=_clear(table))
    remarks = (
        *([because] if because else []),
        *(note for item in results for note in item.notes),
        *notes(solution, rows),
        *idle(campaign.uncertainty, [(item.run, tuple(item.measured)) for item in results]),
        *map(str, hidden),
        *_tank(campaign, blockage),
    )
    table = table.with_(notes=remarks)
    histories = tuple(item.history for item in read if item.history is not None)
    evidence = MethodInputs(
        campaign=campaign,
        convention=convention,
        columns=columns,
        solution=solution,
        table=table,
        rows=rows,
        cycles=(1.0,) * len(rows),
        sensitivities=sensitivities,
        histories=histories,
        channels=channels_over_time(solution, histories, settings.library or {})
        if over_time
        else (),
    )
    if fourier == "trapezoid" and "harmonics" in {item.name for item in chosen}:
        evidence = _integrated(evidence, settings, tell, means)
    found = estimates(chosen, evidence)
    main = chosen[0].name if method == ALL else method
    if main != chosen[0].name:
        origin = {**table.provenance, "method": main}
        table = found[main].table.with_(notes=remarks, provenance=origin)
    weighed = odd_runs == "weigh"
    told = (
        *surge_zero(solution),
        # groups are asked below beside the derivatives that were asked for
        *(item for item in findings if item.cause != "odd_group"),
        *at_odds(odd, weighed=weighed),
        *groups_at_odds(solution, rows, campaign),
    )
    told = tuple(sorted(told, key=lambda item: item.rank))
    families = by_family(rows, sensitivities, columns, solution, campaign, convention)
    moved = Influences(items=each, odd=odd)
    judged = verdict(
        table,
        families,
        solution,
        moved,
        told,
        rows,
        conditions=[item.condition for item in hidden if item.condition],
        weighed=weighed,
    )
    return Reduction(
        table=table.judged(judged),
        method=main,
        estimates={
            name: replace(item, table=item.table.judged(judged)) for name, item in found.items()
        },
        runs=results,
        findings=told,
        offsets=offsets(solution),
        notes=remarks,
        resistance=curve,
        propulsion=propulsion(results, campaign, curve),
        campaign=campaign,
        rows=rows,
        sensitivities=sensitivities,
        columns=columns,
        convention=convention,
        solution=solution,
        influences=moved,
        families=families,
        verdict=judged,
        untold=hidden,
        because=because,
    )


def _clear(table: DerivativeTable) -> dict[str, float]:
    """Derivatives that are clear of zero, the median over the Froude numbers: of another a share
    says nothing."""
    low, high = table.interval()
    found = {}
    for name in table.names:
        column = table.index(name)
        clear = low[:, column] * high[:, column] > 0
        if clear.any():
            found[name] = float(np.median(table.value[clear, column]))
    return found


def _excited(
    rows: Sequence[Rows],
    groups: Sequence[tuple[float, Sequence[int]]],
    campaign: Campaign,
    convention: Convention,
) -> tuple[Rows, ...]:
    """The equations without columns that only noise of the recorded motion makes."""
    rig = campaign.rig
    found = list(rows)
    for _, members in groups:
        kept = excited_alone([rows[place] for place in members], campaign, rig, convention)
        for place, item in zip(members, kept, strict=True):
            found[place] = item
    return tuple(found)


def _integrated(
    evidence: MethodInputs, settings: ReductionSettings, tell: Progress, means: Means
) -> MethodInputs:
    """The evidence with Fourier coefficients by integrals over the third cycle."""
    read = read_all(
        replace(settings, cycles=settings.cycles or THIRD, integrated=True, library=None),
        tell,
        means,
    )
    before = [item.result.cycles or 1 for item in evidence.rows]
    return replace(
        evidence,
        rows=tuple(item.rows for item in read),
        cycles=tuple(
            cycles / (item.rows.result.cycles or 1)
            for cycles, item in zip(before, read, strict=True)
        ),
    )


def _silent(*_: object) -> None:
    """Tell nobody."""


def _groups(rows: Sequence[Rows], fn: str) -> list[tuple[float, tuple[int, ...]]]:
    if fn == "pooled":
        return [(math.nan, tuple(range(len(rows))))]
    groups = froude_groups([item.result.froude for item in rows])
    manoeuvring = [
        (froude, members)
        for froude, members in groups
        if not all(rows[place].result.run.kind_of_test.straight_ahead for place in members)
    ]
    return manoeuvring or groups


def _tank(campaign: Campaign, blockage: str) -> Iterator[str]:
    speeds = [run.settings.speed for run in campaign.runs]
    share = speed_increase(campaign, max(speeds))
    if share is not None:
        done = "corrected for" if blockage == "correct" else "not corrected for"
        yield (
            f"Blockage at {max(speeds):.3g} m/s: the water passes the model {100 * share:.2f} % "
            f"faster on average ({done}); forces follow with about {200 * share:.1f} %."
        )


def _provenance(
    campaign: Campaign,
    results: Sequence[RunResult],
    structure: Structure,
    fn: str,
    cycles: CycleChoice,
    blockage: str,
) -> dict[str, Any]:
    return {
        "pmmkit": __version__,
        "campaign": campaign.title,
        "structure": structure.name,
        "source": structure.source,
        "fn": fn,
        "cycles": cycles,
        "blockage": blockage,
        "runs": len(campaign),
        "excluded": {run.id: reason for run, reason in campaign.excluded},
        "conversions": list(dict.fromkeys(step for item in results for step in item.conversions)),
        "corrections": list(
            dict.fromkeys(
                f"{correction.action}: {correction.reason}"
                for run in campaign
                for correction in run.corrections
            )
        ),
        "files": campaign.file_hashes(),
        **dict(campaign.provenance),
    }


def _run_row(item: RunResult) -> dict[str, Any]:
    settings = item.run.settings
    row: dict[str, Any] = {
        "run": item.run.id,
        "test": item.run.test,
        "Fn": item.froude,
        "speed": settings.speed,
        "drift_deg": math.degrees(settings.drift),
        "heel_deg": math.degrees(settings.heel),
        "rudder_deg": math.degrees(settings.rudder),
        "propeller_rps": settings.propeller_rps,
        "period": settings.period,
        "cycles": item.cycles,
        "samples": item.samples,
        "window": item.window,
    }
    for channel, values in item.measured.items():
        covariance = item.covariance[channel]
        for place, label in enumerate(item.labels):
            name = _harmonic_name(channel, label)
            row[name] = float(values[place])
            if covariance is not None:
                row[f"{name}_std"] = math.sqrt(covariance[place, place])
            if channel in item.scatter:
                row[f"{name}_scatter"] = float(item.scatter[channel][place])
    return row | {f"{name}_mean": value for name, value in item.extras.items()}


def _harmonic_name(channel: str, label: str) -> str:
    """C0 as ``X_mean``, C1 as ``X_cos1``, S1 as ``X_sin1``."""
    if label == "C0":
        return f"{channel}_mean"
    return f"{channel}_{'cos' if label[0] == 'C' else 'sin'}{label[1:]}"
