"""What every kind of test must hold."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from dataclasses import fields
from typing import Final, get_args, get_type_hints

import numpy as np

from pmmkit.campaigns import RUN_SETTINGS, TEST_KINDS, RunSetting, Settings, TestKind
from pmmkit.conventions import is_unit
from pmmkit.numerics import Array
from pmmkit.testing import hold

SPEED: Final = 1.5
_ANGLES: Final = ("drift", "heel", "rudder")
_VARIABLES: Final = ("u", *TestKind.MAY_BE_ZERO, "rps")
_MOTION: Final = ("u", "v", "r", "udot", "vdot", "rdot")
_DIMENSIONS: Final = {
    "u": (1, -1),
    "v": (1, -1),
    "r": (0, -1),
    "udot": (1, -2),
    "vdot": (1, -2),
    "rdot": (0, -2),
}
"""Powers of length and time of each part of a motion."""
_SAMPLES: Final = 240
_STEP: Final = 1e-4
"""Step of the central differences over the period: their error is about 1e-7."""
_TOLERANCE: Final = 1e-5


def check_test_kind(kind: TestKind) -> None:
    """Whether a kind of test can stand beside those of pmmkit.

    Its names can be written in files and are found in names of files; its settings are those of a
    run; its motion is periodic, has the right units, its accelerations are the derivatives of its
    velocities and its path has them; what it says oscillates does so with the amplitude and the
    phase that are stated; what it says is zero is zero, and what it says varies varies.

    Parameters
    ----------
    kind : TestKind
        An entry, yours or pmmkit's.

    Raises
    ------
    AssertionError
        With everything that does not hold.

    Examples
    --------
    >>> from dataclasses import replace
    >>> from pmmkit.campaigns import TEST_KINDS
    >>> check_test_kind(TEST_KINDS["pure_sway"])
    >>> check_test_kind(replace(TEST_KINDS["pure_sway"], varies=("v", "r"), codes=("sway",)))
    Traceback (most recent call last):
    AssertionError: Kind of test 'pure_sway':
    - its code 'sway' is not of two or three capital letters
    - vdot should be zero and is up to 0.185
    - r should vary and does not
    """
    found = [*_words(kind), *(described := list(_settings(kind)))]
    if kind.captive and not described:
        found += _moves(kind)
    hold(f"Kind of test {kind.name!r}", found)


def check_run_setting(setting: RunSetting) -> None:
    """Whether a setting of a run can stand beside those of pmmkit.

    Its key says its unit and is no other's, its words are there, its patterns are regular
    expressions that find it, and its usual value lies within its bounds and is told.

    Parameters
    ----------
    setting : RunSetting
        An entry, yours or pmmkit's.

    Raises
    ------
    AssertionError
        With everything that does not hold.

    Examples
    --------
    >>> from dataclasses import replace
    >>> check_run_setting(RUN_SETTINGS["drift"])
    >>> check_run_setting(replace(RUN_SETTINGS["drift"], key="drift", word=""))
    Traceback (most recent call last):
    AssertionError: Setting 'drift':
    - its key 'drift' is in degrees and does not end in _deg
    - its uncertainty can be stated, and it has no word
    """
    hold(f"Setting {setting.name!r}", _faults(setting))


def _faults(setting: RunSetting) -> Iterator[str]:
    """What is wrong with a setting."""
    for name in {setting.name, setting.in_file}:
        if not re.fullmatch(r"[a-z][a-z0-9]*(_[a-z0-9]+)*", name):
            yield f"{name!r} is not of small letters, digits and underscores"
    if setting.angle != setting.in_file.endswith("_deg"):
        are = "is in degrees and does not end" if setting.angle else "is not in degrees and ends"
        yield f"its key {setting.in_file!r} {are} in _deg"
    others = (item for item in RUN_SETTINGS.values() if item.name != setting.name)
    yield from (f"its key is that of {x.name}" for x in others if x.in_file == setting.in_file)
    if setting.unit and not is_unit(setting.unit):
        yield f"its unit {setting.unit!r} is not known"
    if not setting.meaning:
        yield "what its key means is not said"
    if setting.stated_std and not setting.word:
        yield "its uncertainty can be stated, and it has no word"
    placed = {*RUN_SETTINGS} & {item.name for item in fields(Settings)}
    yield from (f"it states {x}, which is no setting" for x in setting.states if x not in placed)
    try:
        re.compile(setting.header)
        for pattern, _ in setting.in_names:
            if "#" not in pattern:
                yield f"{pattern!r} has no # for the number in a name"
            re.compile(pattern.replace("#", "([0-9]+)"))
    except re.error as error:
        yield f"a pattern is no regular expression: {error}"
    bounds, value = setting.bounds, setting.to_file(setting.typical or 0.0)
    if setting.typical is not None and not (
        (bounds.above is None or value > bounds.above)
        and (bounds.least is None or value >= bounds.least)
        and (bounds.below is None or value < bounds.below)
        and (bounds.most is None or value <= bounds.most)
    ):
        yield f"its usual value {value:g} {setting.unit} is not within its bounds"


def _words(kind: TestKind) -> Iterator[str]:
    if not re.fullmatch(r"[a-z][a-z0-9]*(_[a-z0-9]+)*", kind.name):
        yield "its name is not of small letters, digits and underscores"
    if not kind.title or "_" in kind.title:
        yield f"its title {kind.title!r} is not one for people"
    other = TEST_KINDS.get(kind.name)
    if other is not None and other.motion != kind.motion:
        yield "another kind of test has its name"
    for code in kind.codes:
        if not re.fullmatch("[A-Z]{2,3}", code):
            yield f"its code {code!r} is not of two or three capital letters"
        yield from (
            f"its code {code!r} is one of {item.name}"
            for item in TEST_KINDS.values()
            if code in item.codes and item.name != kind.name
        )
    plain = " ".join(re.findall("[A-Za-z]+", kind.title)).lower()
    try:
        if kind.phrase and not re.search(kind.phrase, plain):
            yield f"its phrase does not find its title, {plain!r}"
    except re.error as error:
        yield f"its phrase is no regular expression: {error}"


def _settings(kind: TestKind) -> Iterator[str]:
    """What is wrong with what it says of its settings and parts."""
    if kind.family not in get_args(get_type_hints(TestKind)["family"]):
        yield f"its family is {kind.family!r}"
    known = {*RUN_SETTINGS, *(item.name for item in fields(Settings))}
    for name in (*kind.needs, *kind.takes):
        if name not in known:
            yield f"{name} is no setting"
        elif name not in RUN_SETTINGS or RUN_SETTINGS[name].typical is None:
            yield f"{name} goes without saying, or stands for another setting"
    if len({*kind.needs, *kind.takes}) < len((*kind.needs, *kind.takes)):
        yield "a setting comes twice"
    yield from (f"{name} is no variable of a motion" for name in set(kind.varies) - {*_VARIABLES})
    swung = {"period", *(swing.amplitude for swing in kind.swings)}
    if kind.oscillates and not kind.swings:
        yield "nothing swings in it"
    if kind.swings and not kind.oscillates:
        yield "it is not of the oscillating family and has swings"
    if kind.oscillates and not swung <= set(kind.needs):
        yield f"it needs {', '.join(sorted(swung - set(kind.needs)))}, and does not say so"
    amplitudes = {item.name for item in RUN_SETTINGS.values() if item.swings}
    if not kind.oscillates and {"period", *amplitudes} & set(kind.needs):
        yield "it needs the settings of an oscillation and is none"
    planned = {*_ANGLES, "amplitude", "yaw_amplitude"} & set(kind.needs)
    for name, shares in (kind.shares or {}).items():
        if name not in planned:
            yield f"its shares are of {name}, which it does not need or no rig limits"
        if not all(0 < share <= 1 for share in shares):
            yield f"its shares of {name} are not above 0 and up to 1"
    if kind.shares is not None and not set(kind.held) <= set(kind.shares):
        yield f"its shares leave out {', '.join(set(kind.held) - set(kind.shares))}"
    if kind.fit is not None:
        unknown = set(kind.fit.beside) - set(TEST_KINDS)
        yield from (f"its fit takes in {name}, which is no kind of test" for name in unknown)
    if not kind.quasi_steady > 0:
        yield "the frequency up to which it is quasi-steady is not positive"
    has_motion = kind.motion != TestKind.motion
    if kind.free_running and (has_motion or kind.fit or kind.shares is not None):
        yield "it is free running, and has a motion, a fit or a plan"
    if kind.captive and kind.motion.tank is None and kind.motion.ship is None:
        yield "it has no nominal motion"
    if kind.oscillates and kind.motion.tank is None:
        yield "it has no motion in tank axes, which measured positions are put into"
    if kind.motion.place is not None and kind.motion.tank is None:
        yield "it says where the hull is, but not in tank axes how it moves"


def _example(
    kind: TestKind, size: float = 1.0, *, length: float = 1.0, time: float = 1.0
) -> Settings:
    """A test of the kind, its angles and amplitudes scaled, or all of it by length and time."""
    powers = {"s": (0, 1), "m": (1, 0), "m/s": (1, -1), "rad/s": (0, -1), "1/s": (0, -1)}
    speed = SPEED * (0.5 + 0.5 * size) * length / time
    given: dict[str, float] = {"speed": speed, "phase": 0.4}
    for item in (RUN_SETTINGS[name] for name in (*kind.needs, *kind.takes)):
        along, during = powers.get(item.unit, (0, 0))
        share = 1.0 if item.name == "period" else size
        given[item.name] = share * (item.typical or 0.0) * length**along * time**during
    return Settings.of(given)


def _nominal(kind: TestKind, settings: Settings, theta: Array) -> dict[str, Array]:
    found = kind.nominal(settings, theta)
    return {name: np.broadcast_to(found.get(name, 0.0), theta.shape) for name in _MOTION}


def _moves(kind: TestKind) -> list[str]:
    """What is wrong with its motion; where it cannot be had, why."""
    theta = 2 * np.pi * np.arange(_SAMPLES) / _SAMPLES
    settings = _example(kind)
    try:
        motion = _nominal(kind, settings, theta)
        if not all(np.isfinite(part).all() for part in motion.values()):
            return ["its motion is not finite"]
        return [
            *_rates(kind, settings, theta),
            *_units(kind, motion, theta),
            *_varied(kind, motion, theta),
            *_phases(kind, settings, motion, theta),
        ]
    except Exception as error:
        return [f"its motion fails with {', '.join(kind.needs) or 'a speed'} given: {error}"]


def _differs(found: Array, wanted: Array, size: float) -> bool:
    return bool(np.max(np.abs(found - wanted)) > _TOLERANCE * max(size, 1e-3))


def _slope(before: Array, after: Array, settings: Settings) -> Array:
    """Derivative in time from values a step of the phase before and after."""
    return np.asarray((after - before) / (2 * _STEP) * (settings.omega or 0.0))


def _rates(kind: TestKind, settings: Settings, theta: Array) -> Iterator[str]:
    """Derivatives that do not go with what they are the derivatives of."""
    here, before, after = (_nominal(kind, settings, theta + x) for x in (0.0, -_STEP, _STEP))
    size = max(float(np.max(np.abs(part))) for part in here.values())
    for name in ("u", "v", "r"):
        if _differs(here[f"{name}dot"], _slope(before[name], after[name], settings), size):
            yield f"{name}dot is not the rate of change of {name}"
    roll, behind, ahead = (kind.nominal(settings, theta + x) for x in (0.0, -_STEP, _STEP))
    for name, rate in (("phi", "p"), ("p", "pdot")):
        slope = _slope(
            np.asarray(behind.get(name, 0.0)), np.asarray(ahead.get(name, 0.0)), settings
        )
        if _differs(np.asarray(roll.get(rate, 0.0)), slope, size):
            yield f"{rate} is not the rate of change of {name}"
    later = _nominal(kind, settings, theta + 2 * np.pi)
    if any(_differs(later[name], here[name], size) for name in _MOTION):
        yield "its motion does not come back after a period"
    if kind.motion.tank is None:
        return
    tank, back, on = (kind.in_tank(settings, theta + x) for x in (0.0, -_STEP, _STEP))
    kind.in_tank(Settings(speed=SPEED, period=RUN_SETTINGS["period"].typical), theta)
    for name, rate in (("psi", "r"), ("r", "rdot"), ("xdot", "xddot"), ("ydot", "yddot")):
        slope = _slope(getattr(back, name), getattr(on, name), settings)
        if _differs(getattr(tank, rate), slope, size):
            yield f"in tank axes {rate} is not the rate of change of {name}"
    if any(_differs(part, here[name], size) for name, part in tank.in_ship_axes.items()):
        yield "its motions in tank axes and in ship axes are not one"
    if kind.motion.place is not None:
        places = [kind.motion.place(settings, theta + x) for x in (-_STEP, _STEP)]
        x, y = (_slope(places[0][axis], places[1][axis], settings) for axis in (0, 1))
        if _differs(x + settings.speed, tank.xdot, size) or _differs(y, tank.ydot, size):
            yield "the hull is not where its velocities take it"


def _units(kind: TestKind, motion: Mapping[str, Array], theta: Array) -> Iterator[str]:
    """Parts that do not grow as their unit does when lengths and times are scaled."""
    length, time = 3.0, 2.0
    scaled = _nominal(kind, _example(kind, length=length, time=time), theta)
    for name, (along, during) in _DIMENSIONS.items():
        factor = length**along * time**during
        if _differs(scaled[name] / factor, motion[name], float(np.max(np.abs(motion[name])))):
            yield f"{name} has not the unit m^{along} s^{during}, by the settings that make it"


def _varied(kind: TestKind, motion: Mapping[str, Array], theta: Array) -> Iterator[str]:
    """Variables that are not zero, or do not vary, against what it says."""
    weak = _nominal(kind, _example(kind, 0.5), theta)
    for name in kind.zero:
        if name in motion and np.max(np.abs(motion[name])) > 1e-12:
            yield f"{name} should be zero and is up to {np.max(np.abs(motion[name])):.3g}"
    angles = {"phi": "heel", "delta": "rudder"}
    for name in kind.varies:
        if name in motion and np.ptp([motion[name], weak[name]]) < 1e-9:
            yield f"{name} should vary and does not"
        if name in angles and angles[name] not in (*kind.needs, *kind.takes):
            yield f"{name} should vary, and {angles[name]} is none of its settings"


def _phases(
    kind: TestKind, settings: Settings, motion: Mapping[str, Array], theta: Array
) -> Iterator[str]:
    """Oscillations without the amplitude or the phase that is stated."""
    seen = {name: _fundamental(motion[name], theta) for name in ("u", "v", "r")}
    if kind.motion.tank is not None:
        seen["psi"] = _fundamental(kind.in_tank(settings, theta).psi, theta)
    if kind.motion.place is not None:
        place = kind.motion.place(settings, theta)
        seen |= {name: _fundamental(place[axis], theta) for axis, name in enumerate("xy")}
    if "phi" in (nominal := kind.nominal(settings, theta)):
        seen["phi"] = _fundamental(np.broadcast_to(nominal["phi"], theta.shape), theta)
    for swing in kind.swings:
        stated = settings.value(swing.amplitude) or 0.0
        found = abs(seen.get(swing.displacement, complex(stated)))
        if abs(found / stated - 1.0) > _TOLERANCE:
            yield f"{swing.displacement} swings by {found:.4g}, stated are {stated:.4g}"
    for told in kind.phase_channels:
        part = seen.get(told.channel, 1.0 if told.with_cosine else 1.0j)
        along, across = (part.real, part.imag) if told.with_cosine else (part.imag, part.real)
        if along <= 0 or abs(across) > _TOLERANCE * along:
            yield f"{told.channel} does not go with {'cos' if told.with_cosine else 'sin'} θ"


def _fundamental(values: Array, theta: Array) -> complex:
    """C + iS of the part C cos θ + S sin θ."""
    return complex(2 * np.mean(values * np.cos(theta)), 2 * np.mean(values * np.sin(theta)))
