"""The tests of one ship, with what must be known to reduce them."""

from __future__ import annotations

import csv
import fnmatch
import math
from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field, replace
from functools import cached_property
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, ClassVar, Final, Literal

import numpy as np

from pmmkit.base import CampaignError, DataError, Problem, UnknownNameError, did_you_mean
from pmmkit.campaigns.check_loads import GaugeCheck, gauge_checks
from pmmkit.campaigns.motion.inertia import Rig
from pmmkit.campaigns.run import Run
from pmmkit.campaigns.setting import LENGTH
from pmmkit.campaigns.stated_run import FORCES
from pmmkit.campaigns.test_kinds.kind import TEST_KINDS
from pmmkit.campaigns.uncertainty import TypeB
from pmmkit.conventions import Ship, Water
from pmmkit.files import sha256
from pmmkit.numerics import Array
from pmmkit.presentation import Described, Grid, Group, Section, counted, number
from pmmkit.readers import READERS

if TYPE_CHECKING:
    import xarray as xr

    from pmmkit.plotting import Figure

MOST: Final = 6
"""Froude numbers that are listed one by one."""
TENFOLD: Final = "10kq"
"""What tables often call KQ, drawn beside KT."""
_FACTORS: Final = ("KT_factor", "KQ_factor")


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
    check_loads : tuple of Run
        Known weights on the balance at rest: they tell its scale, and are none of the tests.
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
    check_loads: tuple[Run, ...] = ()
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
    REQUIRED: ClassVar[Mapping[str, tuple[str, ...]]] = MappingProxyType(
        {"captive": ("t", "X", "Y", "N"), "free-running": ("t", "x", "y", "psi")}
    )
    """Channels that a history must have, by kind."""

    @property
    def computed(self) -> bool:
        """Whether a solver stands for the tank: as is stated, or by the format of its files."""
        formats = {request.options.format for run in self.runs for request in run.requests}
        return bool(self.cfd or self.numerical) or any(
            READERS[name].computed for name in formats if name is not None
        )

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
            f"Forces: {self.forces_in_words}",
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
        for run in (*self.runs, *self.check_loads):
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
        for run in (*self.runs, *self.check_loads):
            if run.id == run_id:
                return run
        raise UnknownNameError(
            f"Campaign {self.title!r} has no run {run_id!r}"
            f"{did_you_mean(run_id, [run.id for run in self.runs]) or '.'} It has "
            f"{', '.join(run.id for run in self.runs[:12])}{' …' if len(self) > 12 else ''}."
        )

    def matching(self, patterns: Sequence[str]) -> list[Run]:
        """Runs whose id fits one of the patterns, such as ``SD_*``.

        Raises
        ------
        UnknownNameError
            If a pattern fits no run.
        """

        def fitting(patterns: Sequence[str]) -> list[Run]:
            return [
                run
                for run in self.runs
                if any(fnmatch.fnmatchcase(run.id, pattern) for pattern in patterns)
            ]

        lost = [pattern for pattern in patterns if not fitting([pattern])]
        if lost:
            ids = [run.id for run in self.runs]
            raise UnknownNameError(
                f"No run is called {', '.join(lost)}{did_you_mean(lost[0], ids) or '.'} There are "
                f"{', '.join(ids)}."
            )
        return fitting(patterns)

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

    @property
    def draught(self) -> float:
        """Mean draught as tried [m]: that of the ends that ``[imo]`` states, else the ship's."""
        fore, aft = self.imo.get("draught_fore"), self.imo.get("draught_aft")
        return self.ship.d if fore is None or aft is None else 0.5 * (fore + aft)

    @property
    def forces_in_words(self) -> str:
        """Whether the inertia of the model is inside the forces."""
        return FORCES[self.forces]

    @property
    def rig(self) -> Rig:
        """What oscillates; the dry mass on the balance counts before that of the ship."""
        ship = self.ship
        return Rig(
            mass=ship.mass if ship.balance_mass is None else ship.balance_mass,
            Izz=ship.Izz if ship.balance_Izz is None else ship.balance_Izz,
            xG=ship.xG if ship.balance_xG is None else ship.balance_xG,
            zG=ship.zG or 0.0,
            Ixx=ship.Ixx or 0.0,
            moment_x=self.moment_reference_x,
            moment_z=self.moment_reference_z,
            motion_x=self.motion_reference_x,
        )

    @cached_property
    def gauge_checks(self) -> tuple[GaugeCheck, ...]:
        """What its check loads tell of each gauge; read when first asked for.

        Raises
        ------
        CampaignError
            If some cannot be read, with the problems of all of them.
        """
        return gauge_checks(self.check_loads, self.moment_reference_x)

    def with_gauges_checked(self) -> Campaign:
        """With the uncertainties that its check loads leave, where the file states none.

        Of a gauge whose gain they find to be 1 that of the gain, and of the moments' point, where
        they find it as stated, that of its place.
        """
        kept = {
            item.name
            for item in self.uncertainty
            if item.kind.of != "gauge" or (item.relative and item.shared)
        }
        more = [
            TypeB(name=f"{check.channel}_gauge", std=check.std, relative=True, shared=True)
            for check in self.gauge_checks
            if check.agrees
        ]
        more += [
            TypeB(name="moment_reference_x", std=check.point_std, shared=True)
            for check in self.gauge_checks
            if check.at(self.moment_reference_x)
        ]
        return self.with_(
            uncertainty=(*self.uncertainty, *(item for item in more if item.name not in kept))
        )

    @property
    def depths(self) -> tuple[float | None, ...]:
        """Depths of the water of the runs [m], the deepest first; None where none is stated.

        Depths within a millimetre are one.

        Examples
        --------
        >>> from pmmkit.campaigns.settings import Settings
        >>> ship = Ship(name="m", L=4.0, B=1.0, d=.25, volume=.5, mass=500., Izz=500.)
        >>> runs = tuple(Run(id=str(h), test="static_drift", kind="means", loader=None,
        ...                  settings=Settings(speed=1.0, depth=h)) for h in (.3, .5, .4998, None))
        >>> Campaign(title="", ship=ship, water=Water(depth=1.0), runs=runs).depths
        (1.0, 0.5, 0.3)
        """
        found: list[float | None] = []
        stated = sorted(
            (self.depth_of(run) for run in self.runs),
            key=lambda depth: float("-inf") if depth is None else -depth,
        )
        for depth in stated:
            if not found or not _one_depth(depth, found[-1]):
                found.append(depth)
        return tuple(found)

    @property
    def depth_in_words(self) -> str:
        """Depth of the water as a person says it."""
        return _in_words(self.water.depth)

    def by_depth(self) -> tuple[Campaign, ...]:
        """A campaign for each depth, the deepest first: its runs, in water of that depth.

        Returns
        -------
        tuple of Campaign
            Each with `water.depth`; the campaign as it is where it has no runs.
        """
        found = self.depths

        def here(run: Run, depth: float | None) -> bool:
            return next((x for x in found if _one_depth(self.depth_of(run), x)), ()) == depth

        return tuple(
            self.with_(
                runs=tuple(run for run in self.runs if here(run, depth)),
                excluded=tuple((run, why) for run, why in self.excluded if here(run, depth)),
                water=replace(self.water, depth=depth),
            )
            for depth in found
        ) or (self,)

    def as_deep_as(self, depth: float | None, draught: float) -> Campaign:
        """The runs in water as deep as that of a model, where they were made at several depths.

        Parameters
        ----------
        depth, draught : float
            Of the model [m]; depths are compared over the draught, so that its scale is any.

        Returns
        -------
        Campaign
            Of one depth; the campaign as it is where none of its depths is within 2 % of it.

        Examples
        --------
        >>> from pmmkit.campaigns.settings import Settings
        >>> ship = Ship(name="m", L=4.0, B=1.0, d=.25, volume=.5, mass=500., Izz=500.)
        >>> runs = tuple(Run(id=str(h), test="static_drift", kind="means", loader=None,
        ...                  settings=Settings(speed=1.0, depth=h)) for h in (.3, .5))
        >>> found = Campaign(title="", ship=ship, water=Water(), runs=runs).as_deep_as(20.0, 10.0)
        >>> [run.id for run in found], found.water.depth
        (['0.5'], 0.5)
        """
        wanted = math.inf if depth is None else depth / draught * self.ship.d
        near = [
            part
            for part in self.by_depth()
            if (part.water.depth is None and depth is None)
            or abs((part.water.depth or 0.0) - wanted) <= AS_DEEP * wanted < math.inf
        ]
        return near[0] if len(near) == 1 else self

    def at_one_depth(self) -> Campaign:
        """The campaign, its water as deep as it was for all of its runs.

        Raises
        ------
        CampaignError
            If they were made at several depths.
        """
        found = self.by_depth()
        if len(found) > 1:
            *most, last = map(_in_words, self.depths)
            raise CampaignError(
                f"The runs of {self.title or self.ship.name!r} were made in water "
                f"of {', '.join(most)} and {last}; derivatives and forces hold at one depth.",
                remedy="`pmmkit reduce` reduces each depth by itself, in Python reduce_depths(). "
                "Elsewhere name a model of one of them (model.toml in the folder of a depth): its "
                "runs are taken, in Python campaign.by_depth().",
            )
        return found[0]

    def within_reach(self) -> Campaign:
        """Without the runs across the flow, which are left out with the reason.

        A campaign that holds no others stays as it is.

        Examples
        --------
        >>> from pmmkit.campaigns.settings import Settings
        >>> ship = Ship(name="m", L=4.0, B=1.0, d=.25, volume=.5, mass=500., Izz=500.)
        >>> runs = tuple(Run(id=f"{drift}°", test="static_drift", kind="means", loader=None,
        ...                  settings=Settings(speed=1.0, drift=np.radians(drift)))
        ...              for drift in (10, 90))
        >>> near = Campaign(title="", ship=ship, water=Water(), runs=runs).within_reach()
        >>> [run.id for run in near.runs], [run.id for run, _ in near.excluded]
        (['10°'], ['90°'])
        """
        far = [run for run in self.runs if run.across_the_flow]
        if not far or len(far) == len(self.runs):
            return self
        reason = (
            f"its drift is above {math.degrees(Run.FARTHEST):.0f}°, where the flow goes across the "
            "hull: a polynomial about straight ahead does not reach so far (use cross-flow drag)"
        )
        return self.with_(
            runs=tuple(run for run in self.runs if not run.across_the_flow),
            excluded=(*self.excluded, *((run, reason) for run in far)),
        )

    @property
    def places_in_day(self) -> tuple[float, ...]:
        """Where each run stands between the first (0) and the last (1).

        By the instants at which they started where all runs state them; else by their order.

        Examples
        --------
        >>> from pmmkit.campaigns.settings import Settings
        >>> ship = Ship(name="m", L=4.0, B=1.0, d=.25, volume=.5, mass=500., Izz=500.)
        >>> runs = tuple(Run(id=hour, test="resistance", kind="means", loader=None,
        ...                  settings=Settings(speed=1.0), started=f"2026-05-04T{hour}:00:00")
        ...              for hour in ("12", "09", "10"))
        >>> day = Campaign(title="", ship=ship, water=Water(), runs=runs)
        >>> [round(place, 3) for place in day.places_in_day]
        [1.0, 0.0, 0.333]
        >>> day.with_(runs=tuple(run.with_(started="") for run in runs)).places_in_day
        (0.0, 0.5, 1.0)
        """
        instants = [run.start for run in self.runs if run.start is not None]
        if instants and len(instants) == len(self.runs):
            span = max(instants) - min(instants)
            if span > 0:
                return tuple((instant - min(instants)) / span for instant in instants)
        last = max(len(self.runs) - 1, 1)
        return tuple(number / last for number in range(len(self.runs)))

    @property
    def open_water(self) -> tuple[Array, Array, Array] | None:
        """J, KT, KQ of the propeller; None where there is no table that can be read.

        ``open_water`` of ``[propeller]`` is a table with the lists J, KT and KQ, or the name of a
        CSV file with such columns (in any case of letters) beside the data; a column ``10KQ`` is
        ten times KQ. ``KT_factor`` and ``KQ_factor`` multiply them.
        """
        source = self.propeller.get("open_water")
        table = self._columns_of(source) if isinstance(source, str) else source
        if not isinstance(table, Mapping):
            return None
        columns = {str(name).strip().lower(): values for name, values in table.items()}
        try:
            if TENFOLD in columns:
                columns["kq"] = (np.asarray(columns[TENFOLD], float) / 10.0).tolist()
            J, KT, KQ = (
                np.asarray(columns[name.lower()], float) * self.propeller.get(f"{name}_factor", 1.0)
                for name in ("J", "KT", "KQ")
            )
        except (KeyError, ValueError, TypeError):
            return None
        return (J, KT, KQ) if len(J) == len(KT) == len(KQ) else None

    def with_open_water(self) -> Campaign:
        """With the curve itself in place of the name of its file, for files that travel.

        What cannot be read stays the name that it was.
        """
        curve = self.open_water
        if curve is None or not isinstance(self.propeller.get("open_water"), str):
            return self
        kept = {name: x for name, x in self.propeller.items() if name not in _FACTORS}
        table = {name: x.tolist() for name, x in zip(("J", "KT", "KQ"), curve, strict=True)}
        return self.with_(propeller={**kept, "open_water": table})

    def _columns_of(self, name: str) -> Mapping[str, list[str]] | None:
        """Columns of a CSV file beside the data."""
        beside = [path.parent for run in self.runs if (path := getattr(run.loader, "path", None))]
        for folder in dict.fromkeys((*beside, self.folder)):
            if (folder / name).is_file():
                with (folder / name).open(
                    encoding="utf-8-sig", newline="", errors="replace"
                ) as file:
                    rows = [row for row in csv.reader(file) if row]
                if not rows:
                    return None
                full = [row for row in rows[1:] if len(row) == len(rows[0])]
                return {title: [row[place] for row in full] for place, title in enumerate(rows[0])}
        return None

    @property
    def not_made(self) -> tuple[str, ...]:
        """Runs of a programme (``planned = true``) that have no file yet; they are left out."""
        return tuple(self.provenance.get("not_made", ()))

    def file_hashes(self) -> dict[str, str]:
        """SHA-256 of every data file that its runs come from, by the file's name.

        Of a folder these are the files in it that are read. Runs that do not come from a file of
        their own are passed over, and of those left out the files that are not there.

        Raises
        ------
        CampaignError
            If a file cannot be read.
        """
        hashes: dict[str, str] = {}
        problems: list[Problem] = []
        files: dict[str, Path] = {}
        for run in self.runs:
            try:
                files |= run.files()
            except DataError as error:
                problems += [problem for problem in error.problems if problem not in problems]
        for run, _ in self.excluded:
            with suppress(DataError):
                files |= {shown: path for shown, path in run.files().items() if path.exists()}
        for shown, path in files.items():
            try:
                hashes[shown] = sha256(path)
            except OSError as error:
                problems.append(Problem(message=f"cannot be read: {error.strerror}.", file=shown))
        if problems:
            raise CampaignError(problems)
        return hashes

    @staticmethod
    def by_title(campaigns: Sequence[Campaign]) -> dict[str, Campaign]:
        """Campaigns by their titles, numbered where two have the same.

        Parameters
        ----------
        campaigns : sequence of Campaign
            One without a title goes by its ship.

        Raises
        ------
        DataError
            If what is given is the path of one.
        """
        if isinstance(campaigns, (str, Path)):
            raise DataError(
                f"{campaigns} is a path and no campaign.",
                remedy=f"Open it first: pk.open_campaign({str(campaigns)!r}).",
            )
        found: dict[str, Campaign] = {}
        for place, item in enumerate(campaigns, 1):
            name = item.title or item.ship.name
            found[f"{name} ({place})" if name in found else name] = item
        return found

    @staticmethod
    def fitting(
        campaigns: Mapping[str, Campaign], patterns: Sequence[str]
    ) -> dict[str, tuple[str, ...]]:
        """By campaign the patterns that fit ids of its runs; without those of which none does.

        Parameters
        ----------
        campaigns : mapping of str to Campaign
            Several of one ship.
        patterns : sequence of str
            Such as ``SD_*``.

        Raises
        ------
        UnknownNameError
            If one fits no run of any campaign.
        """
        found: dict[str, tuple[str, ...]] = {}
        for name, item in campaigns.items():
            ids = [run.id for run in item.runs]
            if own := tuple(x for x in patterns if fnmatch.filter(ids, x)):
                found[name] = own
        lost = [x for x in patterns if not any(x in own for own in found.values())]
        if lost:
            next(iter(campaigns.values())).matching(lost)
        return found

    def to_xarray(self) -> xr.DataTree:
        """All runs as one DataTree, a node a run (reads everything)."""
        import xarray as xr

        return xr.DataTree.from_dict({run.id: run.data for run in self.runs}, name=self.title)


def _in_words(depth: float | None) -> str:
    return "no stated depth" if depth is None else f"{depth:.4g} m"


AS_DEEP: Final = 0.02
"""Depths over the draught within this are one: scales and draughts are rounded to three figures."""


def _one_depth(one: float | None, other: float | None) -> bool:
    if one is None or other is None:
        return one is other
    return abs(one - other) <= LENGTH[0]
