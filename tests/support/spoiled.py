"""Ways to spoil a captive campaign: slips of the hand, faults of gauges, clocks, rigs and files.

Each takes a campaign of the virtual tank and gives one in which a run, or every run, is wrong. They
are written here by hand and share nothing with the actions of the catalogue that the checks look
for: a campaign that is spoiled and searched by one function would prove nothing.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import Any, Literal

import numpy as np
import xarray as xr

from pmmkit import Campaign, Run
from tests.support.hidden_effects import hidden_campaign
from tests.support.hidden_effects.hull import TRUTH, one_pole

Change = Callable[[Run, xr.Dataset], Mapping[str, np.ndarray]]
Scope = Literal["one", "all"]
Base = Literal["plain", "balance", "recorded"]

COUPLED = {"yaw_sway_coupling": 1.0, "surge_yaw_coupling": 1.0}
TESTS = ("static_drift", "pure_sway", "pure_yaw", "yaw_drift")
OSCILLATING = TESTS[1:]
LIBRARY_CHANNELS = ("X", "Y", "N")
LATE_PHASE, LATE_CLOCK, FILTER = math.radians(5.0), 0.2, 0.1


def clean(programme: str = "small", seed: int = 0, base: Base = "plain") -> Campaign:
    """A campaign in which only what is usual is wrong: noise, gains and offsets run by run."""
    made = hidden_campaign(
        programme, COUPLED, noise="standard", seed=seed, balance=base == "balance"
    )
    made = each(made, made.runs, keep_without_roll)
    return each(made, made.runs, record_motion) if base == "recorded" else made


def keep_without_roll(run: Run, data: xr.Dataset) -> Mapping[str, np.ndarray]:
    """The forces alone."""
    return {name: data[name].values for name in LIBRARY_CHANNELS}


def record_motion(run: Run, data: xr.Dataset) -> Mapping[str, np.ndarray]:
    """The forces and the motion as encoders show it, to a thousandth of the speed."""
    state = run.nominal_motion(data["t"].values)
    rng = np.random.default_rng(sum(map(ord, run.id)))
    speed, L = run.settings.speed, 4.861111
    unit = {"u": speed, "v": speed, "r": speed / L}
    motion = {
        name: getattr(state, name) + 1e-3 * size * rng.standard_normal(len(data["t"]))
        for name, size in unit.items()
    }
    return {name: data[name].values for name in data} | motion


def truth() -> dict[str, float]:
    """The derivatives behind the campaigns."""
    coupling = {"Yvvr": 0.0214, "Yvrr": -0.0405, "Nvvr": -0.0424, "Nvrr": 0.00156, "Xvr": 0.0039}
    return {**TRUTH, **coupling}


def each(campaign: Campaign, runs: tuple[Run, ...], change: Change) -> Campaign:
    """The campaign with the samples of some runs changed."""
    names = {run.id for run in runs}

    def spoilt(run: Run) -> Run:
        def load() -> xr.Dataset:
            data = run.data
            values = change(run, data)
            t = values.get("t", data["t"].values)
            rest = {name: ("t", part) for name, part in values.items() if name != "t"}
            return xr.Dataset(rest, coords={"t": t}, attrs=data.attrs)

        return run.with_(loader=load)

    return campaign.with_(
        runs=tuple(spoilt(run) if run.id in names else run for run in campaign.runs)
    )


def channel(name: str, change: Callable[[np.ndarray, np.ndarray], np.ndarray]) -> Change:
    """A change of one channel, from its times and values."""

    def changed(run: Run, data: xr.Dataset) -> Mapping[str, np.ndarray]:
        values = {key: data[key].values for key in data}
        return values | {name: change(data["t"].values, values[name])}

    return changed


def factor(name: str, by: float) -> Change:
    """A channel shown on another scale."""
    return channel(name, lambda _, values: by * values)


def frozen(t: np.ndarray, x: np.ndarray) -> np.ndarray:
    """The channel holds its value from the middle of the record on."""
    middle = len(x) // 2
    return np.where(np.arange(len(x)) < middle, x, x[middle])


def stuck(t: np.ndarray, x: np.ndarray) -> np.ndarray:
    """The channel sticks again and again, for a fifth of the record in all."""
    place = np.arange(len(x))
    hold = (place % 40) < 8
    source = np.where(hold, place - place % 40, place)
    return x[source]


def stepped(t: np.ndarray, x: np.ndarray) -> np.ndarray:
    """The zero jumps after three fifths of the record, by half of what the channel swings."""
    size = 0.5 * np.ptp(x) if np.ptp(x) > 0.3 * abs(x.mean()) else 0.3 * abs(x.mean())
    return x + size * (np.arange(len(x)) > 0.6 * len(x))


def drifting(t: np.ndarray, x: np.ndarray) -> np.ndarray:
    """The zero creeps over the record, by four tenths of what the channel swings."""
    size = 0.4 * np.ptp(x) if np.ptp(x) > 0.3 * abs(x.mean()) else 0.3 * abs(x.mean())
    return x + size * np.linspace(0, 1, len(x))


def clipped(t: np.ndarray, x: np.ndarray) -> np.ndarray:
    """The amplifier ends at three quarters of the amplitude."""
    middle, half = 0.5 * (x.max() + x.min()), 0.5 * np.ptp(x)
    return np.clip(x, middle - 0.75 * half, middle + 0.75 * half)


def soft(t: np.ndarray, x: np.ndarray) -> np.ndarray:
    """The amplifier bends: a hyperbolic tangent of its input, straight near zero."""
    size = 1.2 * np.abs(x).max()
    return size * np.tanh(x / size)


def late(seconds: float, *names: str) -> Change:
    """Channels that come later than the motion."""

    def changed(run: Run, data: xr.Dataset) -> Mapping[str, np.ndarray]:
        t = data["t"].values
        values = {key: data[key].values for key in data}
        if not run.dynamic:
            return values
        chosen = names or LIBRARY_CHANNELS
        period = run.settings.period
        shifted = {
            key: np.interp(t - seconds, t, values[key], period=None)
            if seconds < t[1]
            else _wrapped(t, values[key], seconds, period)
            for key in chosen
        }
        return values | shifted

    return changed


def _wrapped(t: np.ndarray, x: np.ndarray, seconds: float, period: float) -> np.ndarray:
    """Values of a periodic record as they were before; its start comes from a cycle later."""
    asked = t - seconds
    return np.interp(np.where(asked < 0, asked + period, asked), t, x)


def by_clock(run: Run) -> float:
    """Seconds by which the record of a run starts too early or too late."""
    return float(np.random.default_rng(sum(map(ord, run.id))).uniform(-0.3, 0.3))


def off_the_clock(run: Run, data: xr.Dataset) -> Mapping[str, np.ndarray]:
    """Each record starts when it likes."""
    return late(by_clock(run))(run, data)


def half_a_cycle(run: Run, data: xr.Dataset) -> Mapping[str, np.ndarray]:
    """The record starts with the motion to the other side."""
    return late(0.5 * run.settings.period)(run, data) if run.dynamic else dict(data.items())


def five_degrees_late(run: Run, data: xr.Dataset) -> Mapping[str, np.ndarray]:
    """The phase of the motion is stated 5° early."""
    seconds = LATE_PHASE / run.settings.omega if run.dynamic else 0.0
    return late(seconds)(run, data)


def filtered(run: Run, data: xr.Dataset) -> Mapping[str, np.ndarray]:
    """A one-pole filter on the forces."""
    values = {key: data[key].values for key in data}
    t = data["t"].values
    for name in LIBRARY_CHANNELS:
        values[name] = one_pole(values[name], t[1] - t[0], FILTER)
    return values


def in_tank_axes(*names: str) -> Change:
    """Forces or velocities along and across the tank."""

    def changed(run: Run, data: xr.Dataset) -> Mapping[str, np.ndarray]:
        t = data["t"].values
        values = {key: data[key].values for key in data}
        psi = heading(run, t)
        along, across = (values[name] for name in names)
        return values | {
            names[0]: along * np.cos(psi) - across * np.sin(psi),
            names[1]: along * np.sin(psi) + across * np.cos(psi),
        }

    return changed


def heading(run: Run, t: np.ndarray) -> np.ndarray:
    """Heading in the tank [rad]."""
    if not run.dynamic:
        return np.full(len(t), run.settings.drift)
    return np.asarray(
        run.kind_of_test.in_tank(run.settings, run.settings.omega * t + run.settings.phase).psi
    )


def exchanged_channels(run: Run, data: xr.Dataset) -> Mapping[str, np.ndarray]:
    """Y and N in each other's columns."""
    values = {key: data[key].values for key in data}
    return values | {"Y": values["N"], "N": values["Y"]}


def aft(run: Run, data: xr.Dataset) -> Mapping[str, np.ndarray]:
    """The sway velocity is that of a point 0.1 L aft of midship."""
    values = {key: data[key].values for key in data}
    return values | {"v": values["v"] - 0.1 * 4.861111 * values["r"]}


def silent_and_high(run: Run, data: xr.Dataset) -> Mapping[str, np.ndarray]:
    """A record with a hundredth of the noise and a gain 3 % high."""
    values = {key: data[key].values for key in data}
    for name in LIBRARY_CHANNELS:
        x = values[name]
        if run.dynamic:
            theta = run.settings.omega * data["t"].values
            basis = np.stack(
                [f(n * theta) for n in range(6) for f in ((np.cos, np.sin) if n else (np.cos,))], 1
            )
            smooth = basis @ np.linalg.lstsq(basis, x, rcond=None)[0]
        else:
            smooth = np.full_like(x, x.mean())
        values[name] = 1.03 * (smooth + 0.01 * (x - smooth))
    return values


def set_(campaign: Campaign, runs: tuple[Run, ...], **changes: Any) -> Campaign:
    """The campaign with settings of some runs stated otherwise; callables take the run."""
    names = {run.id for run in runs}

    def stated(run: Run) -> Run:
        new = {key: make(run) if callable(make) else make for key, make in changes.items()}
        return run.with_(settings=replace(run.settings, **new))

    return campaign.with_(
        runs=tuple(stated(run) if run.id in names else run for run in campaign.runs)
    )


def exchanged(campaign: Campaign, one: str, other: str) -> Campaign:
    """Two runs with each other's record."""
    loaders = {one: campaign[other].loader, other: campaign[one].loader}
    return campaign.with_(
        runs=tuple(
            run.with_(loader=loaders[run.id]) if run.id in loaders else run for run in campaign.runs
        )
    )


def of(campaign: Campaign, test: str) -> tuple[Run, ...]:
    """The runs of one kind, the smallest motion first; none that repeats another."""
    return tuple(run for run in campaign.runs if run.test == test and not run.settings.repeat_of)


@dataclass(frozen=True, kw_only=True)
class Way:
    """A way to spoil.

    Parameters
    ----------
    name : str
        What is wrong, in words.
    cause : str
        Regular expression for what a user should read: the cause by its name.
    spoil : callable
        From a campaign and the runs that are spoiled to a campaign.
    tests : tuple of str
        Kinds of test of which one run is spoiled.
    scopes : tuple of {"one", "all"}
        Whether one run is spoiled, or all.
    base : {"plain", "balance", "recorded"}
        What the campaign holds.
    told : bool
        Whether a campaign can tell at all; where not, a note must say what would.
    """

    name: str
    cause: str
    spoil: Callable[[Campaign, tuple[Run, ...]], Campaign]
    tests: tuple[str, ...] = TESTS
    scopes: tuple[Scope, ...] = ("one", "all")
    base: Base = "plain"
    told: bool = True


def _samples(name: str, cause: str, change: Change, **more: Any) -> Way:
    return Way(name=name, cause=cause, spoil=lambda found, runs: each(found, runs, change), **more)


def _whole(name: str, cause: str, spoil: Callable[[Campaign], Campaign], **more: Any) -> Way:
    return Way(name=name, cause=cause, spoil=lambda found, _: spoil(found), **more)


def _ship(**changes: Any) -> Callable[[Campaign], Campaign]:
    return lambda found: found.with_(
        ship=replace(
            found.ship,
            **{
                key: by * (getattr(found.ship, key.removeprefix("balance_")))
                for key, by in changes.items()
            },
        )
    )


def _sway_under_yaw(found: Campaign) -> Campaign:
    return exchanged(found, of(found, "pure_sway")[-1].id, of(found, "pure_yaw")[-1].id)


def _sway_file_twice(found: Campaign) -> Campaign:
    loader = of(found, "pure_sway")[-1].loader
    last = of(found, "pure_yaw")[-1].id
    return found.with_(
        runs=tuple(run.with_(loader=loader) if run.id == last else run for run in found.runs)
    )


def _copied(found: Campaign) -> Campaign:
    static = [run for run in of(found, "static_drift") if run.settings.speed == 1.5]
    source, target = static[-1], static[-2]

    def copy(run: Run, data: xr.Dataset) -> Mapping[str, np.ndarray]:
        return {name: 1.001 * source.data[name].values for name in data}

    return each(found, (target,), copy)


def _drifts_exchanged(found: Campaign) -> Campaign:
    static = [run for run in of(found, "static_drift") if run.settings.speed == 1.5]
    return exchanged(found, static[-1].id, static[-2].id)


def _sway_exchanged(found: Campaign) -> Campaign:
    sway = [run for run in of(found, "pure_sway") if run.settings.speed == 1.5]
    return exchanged(found, sway[0].id, sway[1].id)


def _as_pure_yaw(found: Campaign, runs: tuple[Run, ...]) -> Campaign:
    names = {run.id for run in runs}
    return found.with_(
        runs=tuple(
            run.with_(test="pure_yaw", settings=replace(run.settings, drift=0.0))
            if run.id in names
            else run
            for run in found.runs
        )
    )


_GAIN = r"gain|scale|factor|too (large|small)|times"
WAYS: tuple[Way, ...] = (
    *(
        _samples(
            f"{name} dead",
            rf"\b{name}\b.*(constant|dead|stands still|without noise)",
            channel(name, lambda _, x: np.full_like(x, 0.02 * np.abs(x).max())),
        )
        for name in "XYN"
    ),
    _samples("Y frozen", r"\bY\b.*(frozen|stands still|holds its value)", channel("Y", frozen)),
    _samples("X frozen", r"\bX\b.*(frozen|stands still|holds its value)", channel("X", frozen)),
    _samples("N stuck", r"\bN\b.*(sticks|stands still|stuck|holds its value)", channel("N", stuck)),
    _samples("Y stepped", r"\bY\b.*(step|jump)", channel("Y", stepped)),
    _samples("N drifting", r"\bN\b.*(drift|creep|trend)", channel("N", drifting)),
    _samples(
        "Y clipped hard", r"\bY\b.*(flat|clipped|cut off)", channel("Y", clipped), tests=OSCILLATING
    ),
    _samples(
        "Y clipped softly",
        r"\bY\b.*(clipp|bend|saturat|third harmonic|linear)",
        channel("Y", soft),
        tests=OSCILLATING,
    ),
    *(
        _samples(
            f"{name} sign flipped", rf"\b{name}\b.*(sign|flip)|sign.*\b{name}\b", factor(name, -1.0)
        )
        for name in "XYN"
    ),
    _samples("X in kgf", r"\bX\b.*(kilogram-force|kgf|near 1/g)", factor("X", 1 / 9.80665)),
    _samples("Y in kgf", r"\bY\b.*(kilogram-force|kgf|near 1/g)", factor("Y", 1 / 9.80665)),
    _samples("N in lbf ft", r"\bN\b.*(lbf|pound|unit)|unit.*\bN\b", factor("N", 0.737562)),
    Way(
        name="half of the hull",
        cause=r"half",
        spoil=lambda found, runs: each(
            found, runs, lambda _, data: {name: 0.5 * data[name].values for name in data}
        ),
    ),
    Way(
        name="balance_mass 20 % low",
        cause=r"mass|inertia",
        spoil=lambda found, _: _ship(balance_mass=0.8)(found),
        scopes=("all",),
        base="balance",
    ),
    Way(
        name="Izz 20 % high",
        cause=r"Izz|moment of inertia|gyration",
        spoil=lambda found, _: _ship(balance_Izz=1.2)(found),
        scopes=("all",),
        base="balance",
        told=False,
    ),
    _samples(
        "v 0.1 L aft",
        r"point|aft|motion_reference",
        aft,
        tests=("pure_yaw", "yaw_drift"),
        base="recorded",
    ),
    _samples("clock offsets", r"clock|late|early|time|phase", off_the_clock, tests=OSCILLATING),
    _samples(
        "half a cycle off", r"half a (cycle|period)|180°|phase", half_a_cycle, tests=OSCILLATING
    ),
    _whole(
        "sway file under a yaw entry",
        r"record of|belongs to|copies|same numbers",
        _sway_file_twice,
        scopes=("one",),
        tests=("pure_yaw",),
    ),
    _whole(
        "sway and yaw files exchanged",
        r"record of|belongs to|exchanged",
        _sway_under_yaw,
        scopes=("one",),
        tests=("pure_yaw",),
    ),
    _whole(
        "two drift angles exchanged",
        r"exchanged|record of|drift",
        _drifts_exchanged,
        scopes=("one",),
        tests=("static_drift",),
    ),
    _whole(
        "two sway runs exchanged",
        r"exchanged|record of|amplitude",
        _sway_exchanged,
        scopes=("one",),
        tests=("pure_sway",),
    ),
    _whole(
        "copy x 1.001", r"cop(y|ies|ied)|agree", _copied, scopes=("one",), tests=("static_drift",)
    ),
    _samples("Y and N exchanged", r"Y and N.*exchanged|exchanged.*Y and N", exchanged_channels),
    Way(
        name="yaw with drift as pure yaw", cause=r"drift", spoil=_as_pure_yaw, tests=("yaw_drift",)
    ),
    Way(
        name="drift 4° off",
        cause=r"drift|turned",
        spoil=lambda found, runs: set_(
            found, runs, drift=lambda run: run.settings.drift + math.radians(4.0)
        ),
        tests=("static_drift", "yaw_drift"),
    ),
    _whole("L 3 % off", r"length|\bL\b", _ship(L=1.03), scopes=("all",), told=False),
    _samples("Y gain 5 %", rf"\bY\b.*({_GAIN})|gain.*\bY\b", factor("Y", 1.05)),
    _samples("N gain 5 %", rf"\bN\b.*({_GAIN})|gain.*\bN\b", factor("N", 1.05)),
    Way(
        name="amplitude 5 % off",
        cause=r"amplitude|sway larger|larger than stated",
        spoil=lambda found, runs: set_(
            found,
            tuple(run for run in runs if run.dynamic),
            amplitude=lambda run: run.settings.amplitude and 1.05 * run.settings.amplitude,
            yaw_amplitude=lambda run: (
                run.settings.yaw_amplitude and 1.05 * run.settings.yaw_amplitude
            ),
        ),
        tests=("pure_sway", "pure_yaw"),
    ),
    Way(
        name="amplitude peak to peak",
        cause=r"peak to peak|twice",
        spoil=lambda found, runs: set_(
            found,
            tuple(run for run in runs if run.dynamic),
            amplitude=lambda run: run.settings.amplitude and 2 * run.settings.amplitude,
            yaw_amplitude=lambda run: run.settings.yaw_amplitude and 2 * run.settings.yaw_amplitude,
        ),
        tests=("pure_sway", "pure_yaw"),
    ),
    _samples(
        "forces in tank axes",
        r"tank",
        in_tank_axes("X", "Y"),
        tests=("static_drift", "pure_yaw", "yaw_drift"),
    ),
    _samples(
        "velocities in tank axes",
        r"tank|earth",
        in_tank_axes("u", "v"),
        tests=("static_drift", "pure_yaw", "yaw_drift"),
        base="recorded",
    ),
    _samples("phase 5° late", r"late|phase|lag", five_degrees_late, tests=OSCILLATING),
    _samples("filter lag 0.1 s", r"filter|late|lag", filtered, tests=OSCILLATING),
    _samples(
        "Y 0.2 s late",
        r"\bY\b.*(late|lag)|(late|lag).*\bY\b",
        late(LATE_CLOCK, "Y"),
        tests=OSCILLATING,
    ),
    _samples("quiet and 3 % high", rf"noise|{_GAIN}", silent_and_high, scopes=("one",)),
)
"""All ways; `cause` is what a user should read of each."""


@dataclass(frozen=True, kw_only=True)
class Case:
    """A campaign to be spoiled in one way."""

    way: Way
    programme: str
    scope: Scope
    test: str = ""
    seed: int = 0

    @property
    def name(self) -> str:
        """In words."""
        return f"{self.way.name} ({self.test or 'all runs'}, {self.programme})"

    def clean(self) -> Campaign:
        """The campaign before."""
        return clean(self.programme, self.seed, self.way.base)

    def target(self, campaign: Campaign) -> tuple[Run, ...]:
        """The runs that are spoiled."""
        if self.scope == "all":
            tests = self.way.tests
            if set(tests) == set(TESTS):
                return campaign.runs
            more = ("sway_yaw",) if set(OSCILLATING) <= set(tests) else ()
            return tuple(run for run in campaign.runs if run.test in (*tests, *more))
        return (next(run for run in of(campaign, self.test)[::-1] if run.settings.speed == 1.5),)

    def spoiled(self) -> Campaign:
        """The campaign after."""
        campaign = self.clean()
        return self.way.spoil(campaign, self.target(campaign))


def cases(programme: str, seed: int = 0) -> tuple[Case, ...]:
    """Every way, with one run of each kind of test and with all runs."""
    found = []
    for way in WAYS:
        if "one" in way.scopes:
            found += [
                Case(way=way, programme=programme, scope="one", test=test, seed=seed)
                for test in way.tests
            ]
        if "all" in way.scopes:
            found.append(Case(way=way, programme=programme, scope="all", seed=seed))
    return tuple(found)
