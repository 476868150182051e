"""A model beside measurements: errors against what may differ anyway, and where it fails."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import asdict, dataclass
from typing import TYPE_CHECKING, Any, Final, Literal

import numpy as np

from pmmkit.base import Progress, UnknownNameError
from pmmkit.campaigns import TEST_KINDS, Campaign, Rig, Run
from pmmkit.conventions import CHANNEL_UNITS, METRICS, Metric, Ship, Water
from pmmkit.inference import COVERAGE
from pmmkit.intake import Disagreement
from pmmkit.models import Model
from pmmkit.numerics import rms
from pmmkit.presentation import Described, Grid, Group, Section, counted, number, percent
from pmmkit.reduction import View
from pmmkit.validation.captive import CaptiveRun, compare_captive
from pmmkit.validation.dataset import of_harmonics, of_samples, rows_of
from pmmkit.validation.free_running import MOTIONS, FreeRun, ManoeuvreComparison, compare_free
from pmmkit.validation.groups import groups_off, records_off
from pmmkit.validation.misfit import (
    STANDS_OUT,
    MisfitCell,
    Standout,
    Statement,
    cells,
    conditions,
    order_words,
    standouts_of,
    statements_of,
)
from pmmkit.validation.statistics import STATISTICS, ChannelError, statistics, together
from pmmkit.validation.uncertainty import SHARES

if TYPE_CHECKING:
    import pandas as pd
    import xarray as xr

    from pmmkit.plotting import Figure

MOST: Final = 12
"""Sentences of a report; `Comparison.standouts` has all of them."""
_CELL: Final = ("channel", "test", "speed", "Fn")
"""What the records of a cell of the map have in common."""
_HARMONICS: Final = (
    *("run", "test", "speed", "Fn", "channel", "harmonic"),
    *("measured", "predicted", "error", "uncertainty", "ratio", "known"),
)
"""Columns of `Comparison.harmonics`, before what a run varies."""
OVERSHOOTS: Final = 2
"""Overshoots of a zigzag that are told: those for which the IMO has limits."""


@dataclass(frozen=True, kw_only=True, eq=False, repr=False)
class Comparison(Described):
    """A model, or a submission, beside the runs of a campaign.

    Parameters
    ----------
    model, campaign : str
        Name of the model or title of the submission, title of the campaign.
    kind : {"captive", "free-running"}
        Kind of tests.
    ship, water : Ship, Water
        As tested.
    floor : float
        Share of the rms force of a channel that counts as uncertain whatever else is known.
    captive : tuple of CaptiveRun
        Captive runs; empty for free-running tests.
    free : tuple of FreeRun
        Free-running records; empty of a submission, which sails manoeuvres of its own.
    manoeuvres : tuple of ManoeuvreComparison
        Turning circles, zigzags and stops, measured and predicted.
    rig : Rig
        Of captive tests.
    notes : tuple of str
        What a reader must know.
    disagreements : tuple of Disagreement
        Groups of runs, or of records, that the model misses otherwise than the rest.
    """

    model: str
    campaign: str
    kind: Literal["captive", "free-running"]
    ship: Ship
    water: Water
    floor: float
    captive: tuple[CaptiveRun, ...]
    free: tuple[FreeRun, ...]
    manoeuvres: tuple[ManoeuvreComparison, ...]
    rig: Rig
    notes: tuple[str, ...]
    disagreements: tuple[Disagreement, ...] = ()

    def rows(self) -> list[dict[str, Any]]:
        """A row per run and channel.

        Forces of captive runs: root mean squares over a cycle of the comparison error (predicted
        less measured), of the measured force and of the expanded validation uncertainty, with the
        shares of the latter as standard uncertainties. Free-running records: the forces through the
        smoother, and the motion over the whole record, with the errors over `window` seconds.
        """
        if self.captive:
            return [_captive_row(run, name) for run in self.captive for name in run.channels]
        return [row for run in self.free for row in _free_rows(run, self.floor)]

    def to_pandas(self) -> pd.DataFrame:
        """The rows as a table: run, test, speed, Fn, channel, unit, error, measured, relative,
        uncertainty, ratio, within, known, and the shares or the errors over windows."""
        import pandas as pd

        return pd.DataFrame(self.rows())

    def to_dict(self) -> dict[str, Any]:
        """As plain data: what ``pmmkit compare --json`` prints."""
        return {
            "campaign": self.campaign,
            "model": self.model,
            "kind": self.kind,
            "floor": self.floor,
            "coverage_factor": COVERAGE,
            "runs": self.rows(),
            "misfit": self.misfit().to_dict("records"),
            "standouts": [{"text": str(item), **asdict(item)} for item in self.outstanding()]
            if self.captive
            else [{"text": text} for text in self.standouts()],
            "manoeuvres": [row for item in self.manoeuvres for row in item.rows()],
            "disagreements": [asdict(item) for item in self.disagreements],
            "notes": list(self.notes),
        }

    def plot(self) -> Figure:
        """The map of misfit; of free-running tests the record that is predicted worst; of a
        submission of such tests the first manoeuvre."""
        from pmmkit.plotting import trajectory
        from pmmkit.validation.figures import misfit_map, sailed

        if not self.captive and not self.free:
            item = self.manoeuvres[0]
            names = (f"{item.trial.run}, measured", f"{item.trial.run}, submitted")
            return trajectory([item.trial.ordered, item.track.ordered], names)
        if self.captive:
            return misfit_map(self.cells())
        worst = self.worst_record()
        title = f"{worst.run.kind_of_test.title} {worst.name}"
        return sailed(title, worst.t, worst.measured, worst.predicted, worst.delta)

    def worst_record(self) -> FreeRun:
        """The free-running record whose heading is predicted worst."""
        return max(self.free, key=lambda run: statistics(run.errors()["heading"])["error"])

    def _headline(self) -> str:
        rows, what = self.rows(), "channels"
        runs = counted(len(self.captive or self.free), "run")
        if not rows:
            rows, what = [row for item in self.manoeuvres for row in _told(item)], "measures"
            runs = counted(len(self.manoeuvres), "manoeuvre")
        inside = sum(row["ratio"] < 1.0 for row in rows)
        within = f"error within its uncertainty in {inside} of {len(rows)} {what}"
        return f"{self.model} beside {self.campaign}: {runs}, {within}"

    def _sections(self) -> Sequence[Section]:
        leading, more = self.leading()
        shown = [item.text for item in leading]
        if more:
            shown.append(f"and {more} more (`standouts`)")
        errors = (
            f"Root mean square errors and expanded validation uncertainty (k = {COVERAGE:g}, floor "
            f"{100 * self.floor:g} % of the channel)"
        )
        own = "simulated with the ship's own steering"
        sailed = Section(
            title=f"Manoeuvres, {own if self.free else 'submitted'}",
            tables=[self._measures()],
            points=self._overshoots(),
        )
        by_channel = [Section(title=errors, tables=[self._errors()])]
        return [
            *([Section(paragraphs=self.notes)] if self.notes else []),
            *(by_channel if self.captive or self.free else []),
            *([sailed] if self.manoeuvres else []),
            Section(title="What stands out", points=shown)
            if shown
            else Section(paragraphs=["Nothing stands out."]),
        ]

    def _errors(self) -> Grid:
        """Errors by channel and kind of test."""
        found: dict[tuple[str, str, str], list[Mapping[str, Any]]] = {}
        for row in self.rows():
            found.setdefault((row["channel"], row["unit"], row["test"]), []).append(row)
        rows = []
        for (channel, unit, test), group in found.items():
            told = together(group)
            rows.append(
                [
                    f"{channel} [{unit}], {TEST_KINDS[test].title}",
                    str(len(group)),
                    *(number(told[item.name], 3) for item in STATISTICS),
                    percent(told["relative"], signed=False),
                    f"{told['within']} of {len(group)}",
                ]
            )
        rows.sort(key=lambda row: row[0].split(",")[0])
        head = ["channel, test", "runs", *(item.title for item in STATISTICS)]
        head += ["over measured", "within it"]
        return Grid(head=head, groups=[Group(rows=rows)])

    def _measures(self) -> Grid:
        told = [row for item in self.manoeuvres for row in _told(item)]
        late = any(np.isfinite(row["as_executed"]) for row in told)
        rows = [
            [
                f"{row['run']} {row['measure'].replace('_', ' ')} [{row['unit']}]",
                number(row["measured"], 3),
                number(row["predicted"], 3),
                number(row["error"], 2, signed=True),
                *([number(row["error_as_executed"], 2, signed=True)] if late else []),
                number(row["uncertainty"], 2),
            ]
            for row in told
        ]
        head = ["measure", "measured", "predicted", "error"]
        head += ["as executed"] if late else []
        return Grid(head=[*head, "uncertainty"], groups=[Group(rows=rows)])

    def _overshoots(self) -> list[str]:
        """Overshoots over all zigzags, in words: as ordered, and at the headings of the runs."""
        found: dict[str, list[dict[str, Any]]] = {}
        for item in self.manoeuvres:
            for row in _told(item):
                if np.isfinite(row["as_executed"]) and row["measure"].startswith("overshoot"):
                    found.setdefault(row["measure"], []).append(row)
        return [
            f"{Metric.in_words(measure)}: off by "
            f"{rms([row['error'] for row in rows]):.2f}° (rms of {len(rows)}), with each execute "
            f"at the heading of the run by {rms([row['error_as_executed'] for row in rows]):.2f}°"
            for measure, rows in found.items()
            if len(rows) > 1
        ]

    def to_xarray(self) -> xr.Dataset:
        """All that was compared, labelled.

        Returns
        -------
        xarray.Dataset
            ``measured``, ``predicted``, ``error`` (predicted less measured), ``uncertainty``
            (expanded, k = 2) over run, channel and harmonic of captive tests, sample of
            free-running ones (with ``t`` [s]); ``standard_uncertainty`` over source too. NaN where
            a run has none. The unit of a channel is in ``unit``; the floor of free-running forces
            is not among their sources.
        """
        return of_harmonics(self.captive) if self.captive else of_samples(self.free)

    def harmonics(self) -> pd.DataFrame:
        """A row per run, channel and harmonic of captive tests: run, test, speed, Fn, channel,
        harmonic (C0, C1, S1 …), measured, predicted, error, uncertainty (expanded), ratio, known,
        and what the run varies beside its speed."""
        import pandas as pd

        table = rows_of(of_harmonics(self.captive))
        table["ratio"] = table["error"].abs() / table["uncertainty"]
        varied = {run.view.run.id: conditions(run, self.ship.L) for run in self.captive}
        beside = pd.DataFrame.from_dict(varied, orient="index").drop(
            columns="speed", errors="ignore"
        )
        return table[[*_HARMONICS]].join(beside, on="run")

    def cells(self) -> tuple[MisfitCell, ...]:
        """The cells of the map of misfit of captive tests."""
        return cells(self.captive)

    def misfit(self) -> pd.DataFrame:
        """The map of misfit: a row per channel, test type, speed and harmonic.

        The column `ratio` is the error in units of the expanded uncertainty, root mean square over
        the runs of the cell; `with_velocity` and `with_displacement` are its parts by phase. Of
        free-running tests a cell holds whole records (`harmonic` is -1) and is told by
        `statistics.together`, as the console tells it.
        """
        import pandas as pd

        if self.captive:
            found = pd.DataFrame([asdict(cell) for cell in self.cells()])
            found.insert(5, "what", [order_words(order) for order in found["harmonic"]])
            return found
        groups: dict[tuple[Any, ...], list[Mapping[str, Any]]] = {}
        for row in self.rows():
            groups.setdefault(tuple(row[name] for name in _CELL), []).append(row)
        return pd.DataFrame(
            [
                {
                    **dict(zip(_CELL, key, strict=True)),
                    "harmonic": -1,
                    "what": "record",
                    "runs": len(group),
                    **together(group),
                }
                for key, group in groups.items()
            ]
        )

    def outstanding(self, least: float = STANDS_OUT) -> tuple[Standout, ...]:
        """What stands out of the map of captive tests, speeds merged, the worst first.

        Parameters
        ----------
        least : float
            Error over expanded uncertainty from which a cell stands out.
        """
        return standouts_of(self.captive, self.ship.L, least=least)

    def standouts(self, least: float = STANDS_OUT) -> tuple[str, ...]:
        """One sentence per channel and kind of test that stands out, the worst first.

        Parameters
        ----------
        least : float
            As for `outstanding`.
        """
        return tuple(item.text for item in self.statements(least))

    def statements(self, least: float = STANDS_OUT) -> tuple[Statement, ...]:
        """The sentences of `standouts`, each with the channel and the runs that it speaks of; those
        of groups that disagree with the others first.

        Parameters
        ----------
        least : float
            As for `outstanding`.
        """
        apart = [
            Statement(text=str(item), channel=item.channel, runs=item.runs)
            for item in self.disagreements
        ]
        if self.captive:
            return (*apart, *statements_of(self.outstanding(least), self.captive))
        return (
            *apart,
            *(_record_statements(self.misfit(), self.free, least) if self.free else ()),
            *_measure_statements(self.manoeuvres, self.free),
        )

    def leading(self) -> tuple[tuple[Statement, ...], int]:
        """The first of `statements`, as many as a report tells, and how many more there are."""
        every = self.statements()
        return every[:MOST], max(len(every) - MOST, 0)

    @property
    def statistics(self) -> dict[str, str]:
        """Names and titles of the numbers that `rows` tells of each error, in its unit."""
        return {item.name: item.title for item in STATISTICS}

    def metrics(self) -> pd.DataFrame:
        """Measures of manoeuvres side by side: run, test, speed, measure, unit, measured,
        predicted, error, relative, uncertainty (expanded, of the measured and of what is
        submitted), ratio, and of zigzags as_executed and error_as_executed: simulated with each
        execute at the heading of the run."""
        import pandas as pd

        return pd.DataFrame([row for item in self.manoeuvres for row in item.rows()])

    def residuals(self, run: str) -> pd.DataFrame:
        """One run in time: t [s], and per channel measured, predicted and error [N, N m].

        Parameters
        ----------
        run : str
            Id of a run, or name of a record.

        Raises
        ------
        UnknownNameError
            If it is not among those compared.
        DataError
            If it is a row of a table.
        """
        import pandas as pd

        for item in self.captive:
            if item.view.run.id == run:
                columns = item.residual(self.rig)
                for name in item.channels:
                    columns[f"{name}_error"] = (
                        columns[f"{name}_predicted"] - columns[f"{name}_measured"]
                    )
                return pd.DataFrame(columns)
        for record in self.free:
            if run in (record.name, record.run.id):
                return pd.DataFrame(
                    {"t": record.t}
                    | {f"{name}_measured": x for name, x in record.force.items()}
                    | {f"{name}_predicted": x for name, x in record.force_predicted.items()}
                    | {
                        f"{name}_error": record.force_predicted[name] - x
                        for name, x in record.force.items()
                    }
                )
        raise UnknownNameError(f"No run {run!r} was compared.")


def compare_one(
    known: Model,
    campaign: Campaign,
    *,
    floor: float,
    window: float | None = None,
    extrapolate: bool = False,
    views: Sequence[View] | None = None,
    progress: Progress | None = None,
) -> Comparison:
    """A model beside the tests of one campaign; settings as for `compare`."""
    captive: tuple[CaptiveRun, ...] = ()
    free: tuple[FreeRun, ...] = ()
    manoeuvres: tuple[ManoeuvreComparison, ...] = ()
    if campaign.kind == "captive":
        captive, notes = compare_captive(
            known, campaign, floor=floor, extrapolate=extrapolate, views=views, progress=progress
        )
    else:
        free, manoeuvres, notes = compare_free(
            known, campaign, window=window, extrapolate=extrapolate, progress=progress
        )
    return Comparison(
        model=known.name,
        campaign=campaign.title,
        kind=campaign.kind,
        ship=campaign.ship,
        water=campaign.water,
        floor=floor,
        captive=captive,
        free=free,
        manoeuvres=manoeuvres,
        rig=campaign.rig,
        notes=(known.not_usable, *notes) if known.not_usable else notes,
        disagreements=groups_off(captive, campaign) if captive else records_off(free, campaign),
    )


def _row(run: Run, name: str, Fn: float, channel: str, error: ChannelError) -> dict[str, Any]:
    return {
        "run": name,
        "test": run.test,
        "speed": run.settings.speed,
        "Fn": Fn,
        "channel": channel,
        "unit": MOTIONS.get(channel) or CHANNEL_UNITS[channel],
        **statistics(error),
    }


def _captive_row(run: CaptiveRun, channel: str) -> dict[str, Any]:
    own = run.view.run
    return {
        **_row(own, own.id, run.Fn, channel, run.errors(channel)),
        "known": run.view.known(channel),
        **{name: run.rms(run.shares[name][channel]) for name in SHARES},
    }


def _free_rows(run: FreeRun, floor: float) -> Iterable[dict[str, Any]]:
    for channel, error in run.errors(floor).items():
        yield {
            **_row(run.run, run.name, run.Fn, channel, error),
            "window": run.window if channel in MOTIONS else np.nan,
            "window_error": run.window_errors.get(channel, np.nan),
        }


def _record_statements(
    table: pd.DataFrame, records: Sequence[FreeRun], least: float
) -> list[Statement]:
    """Motions, and forces through the smoother, that stand out."""
    rows: list[dict[str, Any]] = [
        {str(name): value for name, value in row.items()}
        for row in table[table["ratio"] >= least]
        .sort_values("ratio", ascending=False)
        .to_dict("records")
    ]
    return [
        Statement(
            text=f"{Metric.in_words(row['channel'])}, {TEST_KINDS[row['test']].title}, "
            f"{row['speed']:.3g} m/s: {row['ratio']:.1f} times the uncertainty, {_size(row)}",
            channel=row["channel"],
            runs=tuple(
                item.name
                for item in records
                if (item.run.test, item.run.settings.speed) == (row["test"], row["speed"])
            ),
        )
        for row in rows
    ]


def _size(row: Mapping[str, Any]) -> str:
    """How large an error is: of a motion in its unit, of a force over what was measured."""
    if row["channel"] in MOTIONS:
        return f"error {number(row['error'], 3)} {MOTIONS[row['channel']]}"
    return f"{100 * row['relative']:.0f} % of the measured force"


def _told(item: ManoeuvreComparison) -> list[dict[str, Any]]:
    """The rows of the measures that a comparison tells."""
    chosen = METRICS.told("comparison", item.trial.metrics, counted=OVERSHOOTS)
    return [row for row in item.rows() if row["measure"] in chosen]


def _measure_statements(
    manoeuvres: Sequence[ManoeuvreComparison], records: Sequence[FreeRun]
) -> list[Statement]:
    """Measures that differ to one side in all runs of a kind of test."""
    found: dict[tuple[str, str], list[Mapping[str, Any]]] = {}
    for item in manoeuvres:
        for row in _told(item):
            found.setdefault((row["test"], row["measure"]), []).append(row)
    statements = []
    for (test, measure), rows in found.items():
        signs = {np.sign(row["error"]) for row in rows}
        if len(signs) > 1 or not all(row["ratio"] > 1.0 for row in rows):
            continue
        share = 100.0 * float(np.mean([row["relative"] for row in rows]))
        text = (
            f"{Metric.in_words(measure)}, {TEST_KINDS[test].title}, "
            f"{'all' if len(rows) > 1 else 'the'} {len(rows) if len(rows) > 1 else 'one'} "
            f"run{'s' if len(rows) > 1 else ''}: predicted {abs(share):.0f} % "
            f"{'more' if share > 0 else 'less'} than measured"
        )
        told = {row["run"] for row in rows}
        runs = tuple(item.name for item in records if item.run.id in told)
        statements.append(Statement(text=text, channel="", runs=runs))
    return statements
