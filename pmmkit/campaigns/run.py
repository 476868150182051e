"""Run and Campaign: one captive or free-running test, and the tests of one ship."""

from __future__ import annotations

import fnmatch
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, Final, Literal

from pmmkit.base import DataError, UnknownNameError, did_you_mean
from pmmkit.campaigns.settings import Settings
from pmmkit.campaigns.test_kinds.kind import TestKind
from pmmkit.campaigns.test_kinds.registry import TEST_KINDS
from pmmkit.campaigns.uncertainty import TypeB
from pmmkit.conventions import CHANNEL_UNITS, Ship, Water
from pmmkit.presentation import Described, Grid, Group, Section, counted, number

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure

Kind = Literal["history", "means", "harmonics"]
FORCES: Final = {
    "hydrodynamic": "those of the water on the hull",
    "balance": "readings of the balance, with the inertia of the model",
}
MOST: Final = 6
"""Froude numbers that are listed one by one."""


@dataclass(frozen=True, kw_only=True)
class Correction:
    """Something that was done to the data because the campaign file says so, and why.

    Parameters
    ----------
    runs : tuple of str
        Ids of runs, ``*`` and ``?`` allowed.
    action : str
        ``exclude``, ``scale``, ``shift``, ``flip``, ``trim``, ``window``, ``tare``,
        ``drop means``, ``drop``, ``inertia still inside``, ``inertia already removed``,
        ``accept`` (what a check says).
    reason : str
        Why, in the user's words.
    values : mapping
        What the action needs, e.g. ``{"channels": ["X"], "factor": 2.0}``.
    """

    runs: tuple[str, ...]
    action: str
    reason: str
    values: Mapping[str, Any] = field(default_factory=lambda: MappingProxyType({}))

    def applies_to(self, run_id: str) -> bool:
        """Whether a run is meant."""
        return any(fnmatch.fnmatchcase(run_id, pattern) for pattern in self.runs)


@dataclass(frozen=True, kw_only=True, repr=False)
class Run(Described):
    """One test.

    Parameters
    ----------
    id, test : str
        Name of the run, name of the kind of test (`TEST_KINDS`).
    kind : {"history", "means", "harmonics"}
        A time history, or a row of a table of means or of harmonics.
    settings : Settings
        Nominal values.
    loader : callable
        Gives the Dataset; called by `data`.
    forces : {"hydrodynamic", "balance"}
        Whether the model's inertia is still inside the forces.
    use_means : bool
        False where the mean of an oscillating test is known to be wrong.
    stated : mapping
        Further numbers of the source's table, as they stand there.
    corrections : tuple of Correction
        What the campaign file asked for on this run.
    source : str
        File (and row) the data come from, relative to the campaign's folder.
    started : str
        When it started, ISO 8601; empty where that is not stated.
    """

    id: str
    test: str
    kind: Kind
    settings: Settings
    loader: Callable[[], xr.Dataset] = field(repr=False, compare=False)
    forces: Literal["hydrodynamic", "balance"] = "hydrodynamic"
    use_means: bool = True
    stated: Mapping[str, float] = field(default_factory=lambda: MappingProxyType({}))
    corrections: tuple[Correction, ...] = ()
    source: str = ""
    started: str = ""

    @property
    def data(self) -> xr.Dataset:
        """The channels, SI, ship axes, pmmkit's signs; read anew at each call.

        A history has the dimension ``t`` [s] and variables of design names (``X``, ``Y``, ``N``,
        ``u``, ``v``, ``r``, ``delta`` …). Means are scalars of the same names. Harmonics have the
        dimension ``harmonic`` (0, 1, 2 …) and variables ``X_cos``, ``X_sin`` …: θ = ωt with the
        motion ∝ sin θ, cosines in phase with the velocity, ``X_cos`` at 0 the mean.
        """
        return self.loader()

    @property
    def kind_of_test(self) -> TestKind:
        """What there is to know of tests such as this one."""
        return TEST_KINDS[self.test]

    @property
    def dynamic(self) -> bool:
        """Whether the model oscillates."""
        return self.kind_of_test.oscillates

    @property
    def setting(self) -> str:
        """What it was set to, with the speed, without the kind of test."""
        surges = self.kind_of_test.surges
        parts = [
            f"{'surge' if surges and item.symbol == 'a' else item.word} {item.value:.3g}{item.unit}"
            for item in self.settings.told
        ]
        return ", ".join([f"{self.settings.speed:.3g} m/s", *parts])

    def plot(self) -> Figure:
        """The channels of its history over time.

        Raises
        ------
        DataError
            If the run is a row of means or harmonics: it has no history.
        """
        from pmmkit.campaigns.figures import record

        if self.kind != "history":
            raise DataError(
                f"Run {self.id} is a row of {self.kind}: it has no history to draw, see `data`."
            )
        data = self.data
        channels = {str(name): x.values for name, x in data.items() if x.dims == ("t",)}
        units = {
            name: CHANNEL_UNITS.get(name, str(data[name].attrs.get("units", "-")))
            for name in channels
        }
        return record(self._headline(), data["t"].values, channels, units)

    def _headline(self) -> str:
        setting = ", ".join(self.settings.words)
        return (
            f"{self.id}: {self.kind_of_test.title} at {self.settings.speed:.4g} m/s"
            f"{f', {setting}' if setting else ''}, {self.kind}"
        )

    def _sections(self) -> Sequence[Section]:
        told = [
            f"Forces: {FORCES[self.forces]}",
            f"From {self.source}" if self.source else "The source is not stated",
            *([] if self.use_means else ["Its mean is known to be wrong and is not used."]),
        ]
        stated = [f"{name} = {number(value)}" for name, value in self.stated.items()]
        done = [f"{item.action}: {item.reason}" for item in self.corrections]
        lists = [
            Section(title="Further numbers of the source", points=stated),
            Section(title="Corrections", points=done),
        ]
        return [Section(paragraphs=told), *(section for section in lists if section.points)]

    def with_(self, **changes: Any) -> Run:
        """A copy with some entries changed."""
        return replace(self, **changes)


@dataclass(frozen=True, kw_only=True, repr=False)
class Campaign(Described):
    """Runs of one ship, with what must be known to reduce them.

    Parameters
    ----------
    title : str
        Title for reports.
    kind : {"captive", "free-running"}
        Kind of tests.
    ship, water : Ship, Water
        The model as tested.
    runs : tuple of Run
        The tests that are used.
    excluded : tuple of (Run, str)
        Tests left out, with the reason.
    forces : {"hydrodynamic", "balance"}
        What the campaign file says of the inertia (each run has its own after corrections).
    moment_reference_x, moment_reference_z, motion_reference_x : float
        Points to which moments and motions refer, from midship [m].
    free : tuple of str
        Motions that the mount leaves free.
    uncertainty : tuple of TypeB
        Stated standard uncertainties.
    cfd, propeller, rudder : mapping
        As in the campaign file, SI.
    trial : mapping
        Sea trials: ``antenna_x``, ``antenna_y``, ``position_std`` [m], and ``order``, the instant
        of the order by run [s].
    imo : mapping
        What ``[imo]`` says for the form of the IMO's explanatory notes.
    report : mapping
        What the test report says and nothing else here holds: customer, tank, gauges …
    numerical : mapping of str to float
        Numerical standard uncertainty per channel, ``U_SN`` [N, N m].
    folder : Path
        Where the campaign lies.
    provenance : mapping
        Files read with their hashes, conversions made, pmmkit's version.
    """

    title: str
    ship: Ship
    water: Water
    runs: tuple[Run, ...]
    kind: Literal["captive", "free-running"] = "captive"
    excluded: tuple[tuple[Run, str], ...] = ()
    forces: Literal["hydrodynamic", "balance"] = "hydrodynamic"
    moment_reference_x: float = 0.0
    moment_reference_z: float = 0.0
    motion_reference_x: float = 0.0
    free: tuple[str, ...] = ()
    uncertainty: tuple[TypeB, ...] = ()
    cfd: Mapping[str, Any] = field(default_factory=lambda: MappingProxyType({}))
    propeller: Mapping[str, Any] = field(default_factory=lambda: MappingProxyType({}))
    rudder: Mapping[str, Any] = field(default_factory=lambda: MappingProxyType({}))
    numerical: Mapping[str, float] = field(default_factory=lambda: MappingProxyType({}))
    trial: Mapping[str, Any] = field(default_factory=lambda: MappingProxyType({}))
    imo: Mapping[str, Any] = field(default_factory=lambda: MappingProxyType({}))
    report: Mapping[str, Any] = field(default_factory=lambda: MappingProxyType({}))
    folder: Path = Path()
    provenance: Mapping[str, Any] = field(default_factory=lambda: MappingProxyType({}))

    def __len__(self) -> int:
        return len(self.runs)

    def plot(self) -> Figure:
        """Which tests were made at which Froude numbers, with how many runs.

        Raises
        ------
        DataError
            If the campaign has no run.
        """
        from pmmkit.campaigns.figures import programme

        if not self.runs:
            raise DataError(f"Campaign {self.title!r} has no run to draw.")
        return programme(
            [run.kind_of_test.title for run in self.runs],
            [self.ship.froude(run.settings.speed, self.water.g) for run in self.runs],
        )

    def _headline(self) -> str:
        left = f", {len(self.excluded)} left out" if self.excluded else ""
        return f"{self.title or self.ship.name}: {self.kind}, {counted(len(self), 'run')}{left}"

    def _sections(self) -> Sequence[Section]:
        told = [
            self.ship.words,
            f"Water: {self.water.rho:.5g} kg/m³"
            + (f", depth {self.water.depth:g} m" if self.water.depth else ""),
            f"Forces: {FORCES[self.forces]}",
            f"Free to move in: {', '.join(self.free)}" if self.free else "",
        ]
        left = [f"{run.id}: {reason}" for run, reason in self.excluded]
        corrections = dict.fromkeys(
            f"{', '.join(item.runs)}: {item.action} ({item.reason})"
            for run in self.runs
            for item in run.corrections
        )
        stated = [
            f"{item.name}: {number(item.std)}{' of the value' if item.relative else ''}, "
            f"{'the same in all runs' if item.shared else 'anew in each run'}"
            for item in self.uncertainty
        ]
        lists = [
            Section(title="Left out", points=left),
            Section(title="Corrections", points=list(corrections)),
            Section(title="Stated standard uncertainties [SI, radians]", points=stated),
        ]
        return [
            Section(paragraphs=[text for text in told if text]),
            Section(title="Tests", tables=[self._tests()]),
            *(section for section in lists if section.points),
        ]

    def _tests(self) -> Grid:
        """A row per kind of test: how many runs, at which speeds, as what they are given."""
        found: dict[str, list[Run]] = {}
        for run in self.runs:
            found.setdefault(run.test, []).append(run)
        rows = []
        for runs in found.values():
            speeds = sorted({run.settings.speed for run in runs})
            ends = [f"{speeds[0]:.4g}", *([f"{speeds[-1]:.4g}"] if len(speeds) > 1 else [])]
            froude = dict.fromkeys(f"{self.ship.froude(x, self.water.g):.3f}" for x in speeds)
            numbers = list(froude)
            rows.append(
                [
                    runs[0].kind_of_test.title,
                    str(len(runs)),
                    " to ".join(ends),
                    ", ".join(numbers) if len(numbers) <= MOST else f"{len(numbers)} of them",
                    ", ".join(dict.fromkeys(run.kind for run in runs)),
                ]
            )
        head = ["test", "runs", "speed [m/s]", "Fn", "as"]
        return Grid(head=head, groups=[Group(rows=rows)], texts=(3, 4))

    def __iter__(self) -> Iterator[Run]:
        return iter(self.runs)

    def __getitem__(self, run_id: str) -> Run:
        for run in self.runs:
            if run.id == run_id:
                return run
        raise UnknownNameError(
            f"Campaign {self.title!r} has no run {run_id!r}"
            f"{did_you_mean(run_id, [run.id for run in self.runs]) or '.'} It has "
            f"{', '.join(run.id for run in self.runs[:12])}{' …' if len(self) > 12 else ''}."
        )

    def select(self, *tests: str) -> Campaign:
        """The campaign with only some kinds of tests.

        Parameters
        ----------
        *tests : str
            Names of kinds, such as ``static_drift``.

        Raises
        ------
        UnknownNameError
            If there is no such kind.
        """
        for name in {*tests} - {run.test for run in self.runs}:
            TEST_KINDS[name]
        return replace(self, runs=tuple(run for run in self.runs if run.test in tests))

    def with_(self, **changes: Any) -> Campaign:
        """A copy with some entries changed."""
        return replace(self, **changes)

    def froude(self, run: Run) -> float:
        """Froude number of a run."""
        return self.ship.froude(run.settings.speed, self.water.g)

    def depth_of(self, run: Run) -> float | None:
        """Depth of the water in which a run was made [m]; None where it is not stated."""
        return self.water.depth if run.settings.depth is None else run.settings.depth

    def to_xarray(self) -> xr.DataTree:
        """All runs as one DataTree, a node a run (reads everything)."""
        import xarray as xr

        return xr.DataTree.from_dict({run.id: run.data for run in self.runs}, name=self.title)
