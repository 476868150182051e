"""Turning circles, zigzags and stops of a submission beside the measured ones."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, Final

from pmmkit.campaigns.run import Campaign, Run
from pmmkit.campaigns.test_kinds.registry import kind_of
from pmmkit.errors import DataError, PmmkitError
from pmmkit.metrics import in_lengths, in_words, told, unit_of
from pmmkit.presentation import ABSENT, Described, Grid, Group, Section, counted, number
from pmmkit.trials import Trial
from pmmkit.trials.evaluate import JUDGED, evaluate
from pmmkit.validation.uncertainty import COVERAGE

if TYPE_CHECKING:
    import pandas as pd

_FROUDE: Final = 0.05
"""Share by which Froude numbers of the same manoeuvre may differ: approaches are never alike."""
_ANGLE: Final = math.radians(1.0)
"""Rudder and heading of execute may differ by this."""


@dataclass(frozen=True, kw_only=True, eq=False)
class TrialPair:
    """A manoeuvre measured and submitted.

    Parameters
    ----------
    measured : Trial
        What workshops call D.
    submitted : Trial
        S, at the length and the approach speed of D.
    """

    measured: Trial
    submitted: Trial

    def rows(self) -> Iterator[dict[str, Any]]:
        """A row a measure that both have: D, S, E = D - S, U_D and U_V (k = 2)."""
        for name in in_lengths(self.measured.metrics):
            D, S = self.measured.metrics[name], self.submitted.metrics.get(name, math.nan)
            if not (math.isfinite(D) and math.isfinite(S)):
                continue
            own = COVERAGE * self.measured.std.get(name, math.nan)
            both = math.hypot(own, COVERAGE * self.submitted.std.get(name, math.nan))
            size = abs(D) if abs(D) > own else math.nan
            yield {
                "run": self.measured.run,
                "submitted_run": self.submitted.run,
                "test": self.measured.test,
                "rudder_deg": self.measured.rudder_deg,
                "measure": name,
                "unit": unit_of(name),
                "D": D,
                "S": S,
                "E": D - S,
                "E_percent": 100 * (D - S) / math.copysign(size, D),
                "U_D": own,
                "U_V": both,
                "U_V_percent": 100 * both / size,
                "within": bool(abs(D - S) <= both),
            }


@dataclass(frozen=True, kw_only=True, eq=False, repr=False)
class TrialComparison(Described):
    """The manoeuvres of a submission beside those of a measurement.

    Parameters
    ----------
    submission, campaign : str
        Titles.
    pairs : tuple of TrialPair
        Manoeuvres that both have.
    notes : tuple of str
        What a reader must know.
    """

    submission: str
    campaign: str
    pairs: tuple[TrialPair, ...]
    notes: tuple[str, ...]

    def rows(self) -> list[dict[str, Any]]:
        """A row per manoeuvre and measure, as `TrialPair.rows` gives it."""
        return [row for pair in self.pairs for row in pair.rows()]

    def to_pandas(self) -> pd.DataFrame:
        """The rows as a table: run, submitted_run, test, rudder_deg, measure, unit, D, S, E,
        E_percent (of D; NaN where D is no larger than its own uncertainty), U_D, U_V (expanded),
        U_V_percent, within."""
        import pandas as pd

        return pd.DataFrame(self.rows())

    def to_dict(self) -> dict[str, Any]:
        """As plain data: what ``pmmkit compare --json`` prints."""
        return {
            "submission": self.submission,
            "campaign": self.campaign,
            "coverage_factor": COVERAGE,
            "measures": self.rows(),
            "notes": list(self.notes),
        }

    def _told(self) -> list[dict[str, Any]]:
        rows = self.rows()
        chosen = set(told("comparison", [row["measure"] for row in rows], counted=2))
        return [row for row in rows if row["measure"] in chosen]

    def _headline(self) -> str:
        rows = self._told()
        inside = sum(row["within"] for row in rows)
        return (
            f"{self.submission} beside {self.campaign}: {counted(len(self.pairs), 'manoeuvre')}, "
            f"E within U_V in {inside} of {len(rows)} measures"
        )

    def _sections(self) -> Sequence[Section]:
        rows = [
            [
                f"{row['run']} {in_words(row['measure'])} [{row['unit']}]",
                number(row["D"], 3),
                number(row["S"], 3),
                _percent(row["E_percent"]),
                number(row["U_D"], 2),
                number(row["U_V"], 2),
            ]
            for row in self._told()
        ]
        head = ["measure", "D", "S", "E = D - S", "U_D", "U_V"]
        title = "Measured (D), submitted (S), E in per cent of D, uncertainties (k = 2)"
        return [
            Section(title=title, tables=[Grid(head=head, groups=[Group(rows=rows)])]),
            *([Section(title="Notes", points=self.notes)] if self.notes else []),
        ]


def compare_trials(submission: Campaign, campaign: Campaign) -> TrialComparison:
    """Free-running manoeuvres of one campaign beside those of another, the measurement.

    Parameters
    ----------
    submission : Campaign
        Free-running tests of the same ship, measured or computed, at any scale: what workshops
        call S.
    campaign : Campaign
        The measurement, D.

    Returns
    -------
    TrialComparison
        Turning circles, zigzags and stops with the same orders: rudder and heading of execute
        within 1°, Froude number within 5 %; of several the run of the same id, or the nearest
        in speed. Lengths go over in ship lengths and times in ship lengths over the approach
        speed; angles as they are.

    Raises
    ------
    DataError
        If a campaign is captive, or no manoeuvre has a counterpart.

    Notes
    -----
    Both sides are evaluated as `evaluate_trials` does, with its standard uncertainties (of fixes,
    headings, instants and current); U_V is that of both.

    Examples
    --------
    >>> import pmmkit as pk
    >>> from pmmkit.campaigns.settings import Settings
    >>> def sailed(title, degrees):
    ...     track = pk.simulate("kvlcc2-l7", "turning", rudder_deg=degrees, speed=1.18)
    ...     settings = Settings(speed=1.18, rudder=math.radians(35))
    ...     run = Run(id="T", test="turning", kind="history", settings=settings,
    ...               loader=track.to_xarray)
    ...     return Campaign(title=title, kind="free-running", ship=pk.load_ship("kvlcc2-l7"),
    ...                     water=pk.Water(), runs=(run,))
    >>> found = compare_trials(sailed("S", 34.5), sailed("D", 35.0))
    >>> [row["measure"] for row in found.rows()][:3]
    ['advance_L', 'transfer_L', 'tactical_diameter_L']
    >>> bool(-3.0 < found.rows()[2]["E_percent"] < 0.0)
    True
    """
    for tests in (submission, campaign):
        if tests.kind != "free-running":
            raise DataError(f"{tests.title!r} is captive: only free-running tests are sailed.")
    pairs: list[TrialPair] = []
    alone: list[str] = []
    notes: list[str] = []
    for run in campaign:
        if run.test not in JUDGED:
            continue
        other = _counterpart(run, campaign, submission)
        if other is None:
            alone.append(run.id)
            continue
        try:
            measured, submitted = evaluate(run, campaign), evaluate(other, submission)
        except PmmkitError as error:
            notes.append(f"{run.id} is left out: {error}")
            continue
        pairs.append(
            TrialPair(measured=measured, submitted=resized(submitted, measured.L, measured.speed))
        )
    if not pairs:
        raise DataError(
            [
                f"No turning circle, zigzag or stop of {submission.title!r} has the orders of one "
                f"of {campaign.title!r}: nothing can be compared.",
                *notes,
            ]
        )
    if alone:
        notes.append(f"Without a counterpart in the submission: {', '.join(alone)}.")
    return TrialComparison(
        submission=submission.title, campaign=campaign.title, pairs=tuple(pairs), notes=tuple(notes)
    )


def resized(trial: Trial, L: float, speed: float) -> Trial:
    """A trial at another length and approach speed, the same in ship lengths.

    Parameters
    ----------
    trial : Trial
        As it was evaluated.
    L, speed : float
        Ship length [m] and approach speed [m/s].
    """
    length, pace = L / trial.L, speed / trial.speed
    time = length / pace
    per_unit = {"m": length, "s": time, "deg/s": 1.0 / time, "m/s": pace}

    def scaled(values: Mapping[str, float]) -> dict[str, float]:
        return {name: x * per_unit.get(unit_of(name), 1.0) for name, x in values.items()}

    return replace(
        trial,
        L=L,
        speed=speed,
        speed_std=trial.speed_std * pace,
        order=trial.order * time,
        orders=tuple(t * time for t in trial.orders),
        rudder_rate_deg=trial.rudder_rate_deg / time,
        metrics=scaled(trial.metrics),
        std=scaled(trial.std),
        t=trial.t * time,
        x=trial.x * length,
        y=trial.y * length,
        x_ground=trial.x_ground * length,
        y_ground=trial.y_ground * length,
    )


def _counterpart(run: Run, ours: Campaign, theirs: Campaign) -> Run | None:
    """The run of the submission with the same orders, nearest in speed, of the same id first."""
    Fn = ours.froude(run)
    near = [
        other
        for other in theirs
        if other.test == run.test
        and abs(theirs.froude(other) / Fn - 1.0) <= _FROUDE
        and all(abs(a - b) <= _ANGLE for a, b in zip(_orders(run), _orders(other), strict=True))
    ]
    near.sort(key=lambda other: (other.id != run.id, abs(theirs.froude(other) / Fn - 1.0)))
    return next(iter(near), None)


def _orders(run: Run) -> tuple[float, float]:
    """Rudder and heading of execute [rad], 0 where a test has none."""
    given = run.settings
    if not kind_of(run.test).turns_rudder:
        return 0.0, 0.0
    rudder = given.rudder
    switch = abs(rudder) if given.switch is None else abs(given.switch)
    return rudder, switch if kind_of(run.test).switches else 0.0


def _percent(share: float) -> str:
    return f"{share:+.1f} %" if math.isfinite(share) else ABSENT
