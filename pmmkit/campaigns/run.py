"""One captive or free-running test with its data, and the files that these are read from."""

from __future__ import annotations

import json
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar, Final

import numpy as np
from numpy.typing import ArrayLike

from pmmkit.base import DataError
from pmmkit.campaigns.run_settings import RUN_SETTINGS
from pmmkit.campaigns.setting import ANGLE
from pmmkit.campaigns.stated_run import StatedRun
from pmmkit.conventions import CHANNEL_UNITS
from pmmkit.effects import State
from pmmkit.files import Origin, local_copy
from pmmkit.numerics import Array, even_clock
from pmmkit.presentation import Described, Section, number
from pmmkit.readers import Request, reader_for, recognise

if TYPE_CHECKING:
    import xarray as xr

    from pmmkit.plotting import Figure
    from pmmkit.signals import FourierBasis


FEWEST: Final = 2
"""Runs that a group has at least, and that stand beside it."""
PARTS_OF_DAY: Final = (1.0 / 3.0, 0.5, 2.0 / 3.0)
"""Where the day may change."""
AT_ONCE: Final = 8
"""Files that are fetched side by side, as each waits for its store most of the time."""


def at_hand(request: Request, *, proven: bool = True) -> Request:
    """The request with its file on this machine: as it is, or copied from its URL."""
    if request.origin is None:
        return request
    try:
        path = local_copy(request.origin, proven=proven)
    except DataError as error:
        shown = replace(request, withheld=False)
        raise request.error(
            *(shown.problem(item.message, remedy=item.remedy) for item in error.problems)
        ) from error
    withheld = request.withheld and recognise(path) is None
    return replace(request, path=path, origin=None, withheld=withheld)


@dataclass(frozen=True, kw_only=True, repr=False)
class Run(StatedRun, Described):
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

    loader: Callable[[], xr.Dataset] = field(repr=False, compare=False)
    OTHERWISE: ClassVar[tuple[float, ...]] = (0.005, 0.01, 0.02, 0.04, 0.08)
    """Sizes of what a group of runs may read otherwise, over the rms force of a channel."""
    RECKONED: ClassVar[str] = "reckoned"
    """Attribute of a channel that follows from others and was not measured."""
    DOUBTFUL: ClassVar[str] = "doubtful: "
    """How a note on its data begins that somebody should look at."""

    @property
    def data(self) -> xr.Dataset:
        """The channels, SI, ship axes, pmmkit's signs; read anew at each call.

        A history has the dimension ``t`` [s] and variables of design names (``X``, ``Y``, ``N``,
        ``u``, ``v``, ``r``, ``delta`` …). Means are scalars of the same names. Harmonics have the
        dimension ``harmonic`` (0, 1, 2 …) and variables ``X_cos``, ``X_sin`` …: θ = ωt with the
        motion ∝ sin θ, cosines in phase with the velocity, ``X_cos`` at 0 the mean.
        """
        data = self.loader()
        if "t" not in data.coords:
            return data
        clock, notes = told_evenly(data["t"].values)  # records in memory; files are told already
        if not notes:
            return data
        said = [*json.loads(data.attrs.get("conversions", "[]")), *notes]
        data = data.assign_coords(t=("t", clock, data["t"].attrs))
        return data.assign_attrs(conversions=json.dumps(said, ensure_ascii=False))

    @property
    def requests(self) -> tuple[Request, ...]:
        """What is read for it: its file, and that of its motion; none where it has no file."""
        return tuple(getattr(self.loader, "requests", ()))

    @property
    def own_file(self) -> Path | None:
        """The file of its history alone; None of a row of a table."""
        return self.requests[0].path if hasattr(self.loader, "untrimmed") else None

    @property
    def untrimmed(self) -> Run:
        """With all of its record, that too which a correction cuts off."""
        return self.with_(loader=getattr(self.loader, "untrimmed", self.loader))

    def files(self) -> dict[str, Path]:
        """The files that its data come from, by the names that messages give them.

        Raises
        ------
        CampaignError
            If a folder holds nothing of its format, or a file behind a URL cannot be fetched.
        """
        asked = [at_hand(request, proven=False) for request in self.requests]
        return {
            request.inside(path).shown: path
            for request in asked
            for path in reader_for(request).files(request)
        }

    @staticmethod
    def fetch(runs: Sequence[Run]) -> None:
        """Fetch files behind URLs side by side; what cannot be fetched is told when it is read.

        Parameters
        ----------
        runs : sequence of Run
            The runs; files of this machine are left alone.
        """
        requests = [request for run in runs for request in run.requests]
        afar = {request.origin for request in requests if request.origin is not None}
        if not afar:
            return

        def fetch(origin: Origin) -> None:
            try:
                local_copy(origin)
            except DataError:
                return

        with ThreadPoolExecutor(min(AT_ONCE, len(afar))) as pool:
            list(pool.map(fetch, afar))

    @staticmethod
    def repeats(runs: Sequence[Run]) -> tuple[tuple[Run, ...], ...]:
        """Runs in groups that repeat each other.

        A run that states `repeat_of` belongs to that run, whatever its settings are; any other to
        the first run of the same test that was set like it, within `RUN_SETTINGS.resolution`. A
        setting that one of them does not state is another setting.

        Parameters
        ----------
        runs : sequence of Run
            In any order.

        Returns
        -------
        tuple of tuple of Run
            Each run in one group, alone where nothing repeats it. Groups, and the runs in a group,
            in the order in which they came.

        Examples
        --------
        >>> from pmmkit.campaigns import Settings
        >>> runs = [Run(id=name, test="static_drift", kind="means", loader=None,
        ...             settings=Settings(speed=speed, drift=drift))
        ...         for name, speed, drift in (("a", 1.0, 0.1), ("b", 1.0, 0.2), ("c", 1.001, 0.1))]
        >>> [[run.id for run in group] for group in Run.repeats(runs)]
        [['a', 'c'], ['b']]
        """
        origin = _stated(runs)
        free = [run for run in runs if origin[run.id] == run.id]
        leader = _set_alike(free)
        groups: dict[str, list[Run]] = {}
        for run in runs:
            first = origin[run.id]
            groups.setdefault(leader.get(first, first), []).append(run)
        return tuple(tuple(group) for group in groups.values())

    @staticmethod
    def levels(runs: Sequence[Run]) -> dict[str, dict[str, frozenset[str]]]:
        """Names of runs by kind of test, speed, side of the drift and frequency.

        The side of a free-running manoeuvre is that to which its rudder is put first.

        Parameters
        ----------
        runs : sequence of Run
            In any order.

        Returns
        -------
        dict of str to dict of str to frozenset of str
            By factor: each level in words, with the runs that have it.

        Examples
        --------
        >>> from pmmkit.campaigns import Settings
        >>> runs = [Run(id=name, test="static_drift", kind="means", loader=None,
        ...             settings=Settings(speed=1.0, drift=drift))
        ...         for name, drift in (("a", 0.1), ("b", -0.1), ("c", 0.0))]
        >>> {level: sorted(own) for level, own in Run.levels(runs)["side"].items()}
        {'at positive drift': ['a'], 'at negative drift': ['b']}
        """
        sides = {1.0: "at positive drift", -1.0: "at negative drift"}
        turns = {1.0: "turned to starboard first", -1.0: "turned to port first"}

        def side(run: Run) -> str:
            if run.kind_of_test.free_running:
                return turns.get(float(np.sign(run.settings.rudder)), "")
            return sides.get(float(np.sign(run.settings.drift)), "")

        def by(words: Callable[[Run], str], order: Callable[[Run], float]) -> dict[str, Any]:
            levels: dict[str, list[str]] = {}
            for run in sorted(runs, key=order):
                levels.setdefault(words(run), []).append(run.id)
            return {level: frozenset(own) for level, own in levels.items() if level}

        def omega(run: Run) -> float:
            return (run.settings.omega or 0.0) if run.dynamic else 0.0

        return {
            "kind of test": by(lambda run: f"in {run.kind_of_test.title}", lambda _: 0.0),
            "speed": by(
                lambda run: f"at {round(run.settings.speed, 6):g} m/s",
                lambda run: run.settings.speed,
            ),
            "side": by(side, lambda _: 0.0),
            "frequency": by(lambda run: f"at {omega(run):.3g} rad/s" if omega(run) else "", omega),
        }

    @staticmethod
    def groups(runs: Sequence[Run], days: Sequence[float]) -> dict[str, frozenset[str]]:
        """Groups of runs that may have been tested otherwise than the rest, in words.

        Kinds of test and their later halves, steady runs, speeds, sides of the drift, and the day
        from a third, a half and two thirds on; two runs at least, and two beside them.

        Parameters
        ----------
        runs : sequence of Run
            In any order.
        days : sequence of float
            Where each stands in the day (`Campaign.places_in_day`).

        Examples
        --------
        >>> from pmmkit.campaigns import Settings
        >>> runs = [Run(id=name, test=test, kind="means", loader=None,
        ...             settings=Settings(speed=1.0, drift=0.1))
        ...         for name, test in zip("abcd", 2 * ["static_drift"] + 2 * ["pure_sway"])]
        >>> {words: sorted(own) for words, own in Run.groups(runs, [0.0, 0.3, 0.6, 1.0]).items()}
        {'in static drift': ['a', 'b'], 'in pure sway': ['c', 'd']}
        """
        levels = Run.levels(runs)
        steady = frozenset(run.id for run in runs if not run.dynamic)
        asked = {**levels["kind of test"], "in steady runs": steady}
        asked |= {**levels["speed"], **levels["side"]}
        order = sorted(range(len(runs)), key=lambda place: days[place])
        names = [runs[place].id for place in order]
        for part in PARTS_OF_DAY:
            later = names[int(part * len(names)) :]
            asked[f"from {later[0]} on"] = frozenset(later)
        for kind, own in levels["kind of test"].items():
            later = [name for name in names if name in own][len(own) // 2 :]
            asked[f"{kind} from {later[0]} on"] = frozenset(later)
        groups: dict[frozenset[str], str] = {}
        for words, ids in asked.items():
            if FEWEST <= len(ids) <= len(names) - FEWEST:
                groups.setdefault(ids, words)
        return {words: ids for ids, words in groups.items()}

    def measured_motion(
        self,
        data: xr.Dataset,
        times: ArrayLike,
        basis: FourierBasis | None = None,
        *,
        within: slice = slice(None),
    ) -> State:
        """Motion of the record: what was measured, and the nominal motion for the rest.

        For each of u, v, r the order is: its own channel, what follows from the positions and
        heading ``x, y, psi``, the nominal value (at the phase of the measured motion). Where the
        carriage's speed ``U_carriage`` was recorded it stands for the nominal speed: its mean, and
        in an oscillating test its series where it swings with the motion. Accelerations that were
        not measured follow from the velocity: in an oscillating test through its least-squares
        Fourier series (harmonics 0 to 5 at the frequency of the run, on the actual times), in a
        static test they are zero. In a static test only the mean heading and the mean speeds are
        taken from positions, of a circle only the yaw rate; where the rudder alone swings the hull
        counts as in a static test.

        Parameters
        ----------
        data : Dataset
            The run's data, or a part of them. Channels ``u, v, r, p, phi, udot, vdot, rdot, pdot,
            delta, n, T, x, y, psi, U_carriage`` are used; scalars hold for all times. A channel
            that is NaN throughout counts as not measured, and so does a single value of what
            oscillates. ``x`` may count from the tank or from the carriage; its trend tells.
            Harmonics of a motion (``v_cos``, ``v_sin``) are summed at the nominal phase.
        times : array (n,)
            Times of the samples [s], even or not.
        basis : FourierBasis, optional
            Of harmonics 0 to 5 or above at these times, where there is one: its phase goes with
            ωt.
        within : slice
            The samples of the data that lie at these times.

        Returns
        -------
        State
            Referred to the point that the measurements refer to, see `State.moved_aft`.

        Raises
        ------
        CampaignError
            If lengths differ, if a setting is needed and missing, or if the record is shorter than
            a period and has to be differentiated.

        Examples
        --------
        >>> from pmmkit.campaigns import Settings
        >>> import xarray as xr
        >>> run = Run(id="PS", test="pure_sway", kind="history", loader=None,
        ...           settings=Settings(speed=1.5, period=8.0, amplitude=0.2))
        >>> t = np.arange(0.0, 8.0, 0.5)
        >>> data = xr.Dataset({"v": ("t", 0.3 * np.sin(2 * np.pi * t / 8.0))}, coords={"t": t})
        >>> run.measured_motion(data, t).vdot[:2].round(4)
        array([0.2356, 0.2177])
        """
        from pmmkit.campaigns.motion.kinematics import measured_motion

        return measured_motion(self, data, times, basis, within=within)

    def displacement_phase(
        self, data: xr.Dataset, times: ArrayLike, *, within: slice = slice(None)
    ) -> Array:
        """Phase θ of the displacement of an oscillating test: the motion is ∝ sin θ.

        The displacement is the heading in yaw tests, the sway displacement in sway tests, the
        surge displacement in surge tests, the angle of a rudder that swings. The phase is that of
        the fundamental of the measured displacement (``psi``; ``y``; ``x``; ``delta``), else of
        the velocity (``r``; ``v``; ``u``, which go with cos θ), else the nominal ωt + phase. It is
        measured where the fundamental stands five standard errors clear of zero. Tables of
        harmonics have the nominal phase.

        Parameters
        ----------
        data : Dataset
            The run's data, or a part of them.
        times : array (n,)
            Times of the samples [s], even or not.
        within : slice
            Samples by which the phase is told; a ramp of the carriage stays out of them.

        Returns
        -------
        array (n,)
            θ [rad], rising with time, the branch nearest to ωt + phase.

        Raises
        ------
        CampaignError
            If the test does not oscillate, has no period, or the record is shorter than one.
        """
        from pmmkit.campaigns.motion.kinematics import displacement_phase

        return displacement_phase(self, data, times, within=within)

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
            f"Forces: {self.forces_in_words}",
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


def told_evenly(times: Array) -> tuple[Array, list[str]]:
    """Times; where stamps stand twice the even clock that they tell, with a note that says so."""
    clock = even_clock(times)
    if clock is None:
        return times, []
    step = float(clock[1] - clock[0])
    return clock, [f"stamps of t stand twice: the even clock of {step:.5g} s that they tell"]


def _stated(runs: Sequence[Run]) -> dict[str, str]:
    """The run at the end of the chain of `repeat_of`; one that is not among `runs` counts too."""
    named = {run.id: run.settings.repeat_of or run.id for run in runs}
    found = {}
    for start in named:
        seen = [start]
        while (following := named.get(seen[-1], seen[-1])) not in seen:
            seen.append(following)
        # where runs name each other in a circle, the one that comes first in `runs` is the origin
        circle = seen[seen.index(following) :]
        found[start] = next((x for x in named if x in circle), following)
    return found


def _set_alike(runs: Sequence[Run]) -> dict[str, str]:
    """The first run of the same test that was set like each, by id."""
    kinds: dict[tuple[object, ...], dict[tuple[float | None, ...], list[str]]] = {}
    for run in runs:
        values = tuple(run.settings.value(name) for name in RUN_SETTINGS.resolution)
        stated = tuple(value is None for value in values)
        kinds.setdefault((run.test, stated), {}).setdefault(values, []).append(run.id)
    found = {}
    for equal in kinds.values():
        together = list(equal.values())
        for own, first in zip(together, _first_alike(list(equal)), strict=True):
            found.update(dict.fromkeys(own, together[first][0]))
    return found


def _first_alike(settings: Sequence[tuple[float | None, ...]]) -> list[int]:
    """Place of the first of settings that each is alike; all state the same ones."""
    limits = RUN_SETTINGS.resolution
    values = np.array(settings, float)
    values[np.isnan(values)] = 0.0
    allowed = np.array(list(limits.values()))
    angular = np.array([limit is ANGLE for limit in limits.values()])
    first = np.full(len(settings), -1)
    for place in range(len(settings)):
        if first[place] < 0:
            later = np.flatnonzero(first < 0)
            first[later[_alike(values[later], values[place], allowed, angular)]] = place
    return [int(place) for place in first]


def _alike(values: Array, one: Array, allowed: Array, angular: Array) -> Array:
    """Whether rows of values are as one of them; 180° is -180°."""
    apart = np.abs(values - one)
    apart = np.where(angular, np.abs(np.remainder(apart + np.pi, 2 * np.pi) - np.pi), apart)
    # the last digits of numbers that were converted may differ
    limit = np.maximum(allowed[:, 0], allowed[:, 1] * np.abs(one)) * (1 + 1e-9)
    alike: Array = np.all(apart <= limit, axis=1)
    return alike
