"""What the name of a file and the lines above its columns say: kind of test, speed, angles, period.

Names such as ``SD_U1.5_b+08``, ``static drift/beta12deg``, ``PMM_sway_T12.5_a0.2``, ``ZZ10-10``.
Only what cannot mean anything else becomes a setting; the rest is a hint for a person.
"""

from __future__ import annotations

import itertools
import math
import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Final

from pmmkit.campaigns import RUN_SETTINGS, TEST_KINDS, RunSetting, TestKind
from pmmkit.conventions import factor_to
from pmmkit.intake.blocks import held_too
from pmmkit.intake.drafts.motion import RunFacts
from pmmkit.intake.guessing import bare_header, suggest
from pmmkit.presentation import meanings

_NUMBER: Final = r"([+-]?(?:\d+(?:[.,p]\d+)?|\.\d+))"
_ALONE: Final = re.compile(_NUMBER + "(deg|°|mm|m|s|sec)")
"""A number with nothing but its unit."""

_BESIDE: Final = (
    ("froude", r"(?:[Ff][nr]|FN|FR|[Ff]roude)#"),
    ("hint v", r"v#"),
    ("hint r", r"r#"),
    ("hint p", r"p#"),
)
"""What names hold besides settings: the Froude number, and letters that may mean several things."""


def _signs(settings: Iterable[RunSetting]) -> tuple[tuple[str, re.Pattern[str], float], ...]:
    """What stands in a name for a key, and by what its number becomes the key's."""

    def compiled(pattern: str) -> re.Pattern[str]:
        return re.compile(pattern.replace("#", _NUMBER))

    return (
        *(
            (item.in_file, compiled(pattern), factor)
            for item in settings
            for pattern, factor in item.in_names
        ),
        *((key, compiled(pattern), 1.0) for key, pattern in _BESIDE),
    )


def _codes() -> Mapping[str, str]:
    """Usual abbreviations, in capitals at the beginning of a part of the name."""
    return {code: kind.name for kind in TEST_KINDS.values() for code in kind.codes}


def _phrases() -> tuple[tuple[str, re.Pattern[str]], ...]:
    """Words for kinds of test, those of combined tests first: they hold those of simple ones.

    Sway, yaw and surge name forces and moments too: of simple tests the steady ones come first.
    """
    ordered = sorted(
        (kind for kind in TEST_KINDS.values() if kind.phrase),
        key=lambda kind: (-_motions(kind), kind.oscillates == (_motions(kind) == 1)),
    )
    return tuple((kind.name, re.compile(kind.phrase)) for kind in ordered)


def _motions(kind: TestKind) -> int:
    """How many swings and held angles a captive test combines."""
    angles = [name for name in kind.held if name != "yaw_rate"]
    return len(kind.swings) + len(angles) if kind.captive else 0


def facts_of(name: str) -> RunFacts:
    """What the name of a file says, folders included, the file before its folders.

    Examples
    --------
    >>> found = facts_of("KCS/SD_U1.5_b+08")
    >>> found.test, found.settings["speed"], found.settings["drift_deg"]
    ('static_drift', (1.5, 'U1.5'), (8.0, 'b+08'))
    >>> facts_of("pure yaw T=9 s psi0=8.275 deg").settings["yaw_amplitude_deg"]
    (8.275, 'psi8.275deg')
    >>> facts_of("PS_U1.0_v0.08").hints
    {'v_amplitude': (0.08, 'v0.08, if it is the sway velocity over U')}
    """
    parts = list(reversed(name.split("/")))
    test = next((found for part in parts if (found := test_named(part)) is not None), None)
    settings: dict[str, tuple[float, str]] = {}
    marks: dict[str, tuple[float, str]] = {}
    for part in parts:
        for key, item in _orders(test, part):
            settings.setdefault(key, item)
        for token in _tokens(part):
            for key, value in _values(token):
                (marks if key.startswith("hint") else settings).setdefault(key, (value, token))
    test = _refined(test, settings)
    settings = _along_the_path(test, settings)
    alone = _along_the_path(test, dict(_alone(test, [x for part in parts for x in _tokens(part)])))
    return RunFacts(
        test=test,
        settings=_kept(test, settings),
        alone=_kept(test, alone),
        hints=_hints(test, marks),
    )


def _alone(test: str | None, tokens: Sequence[str]) -> Iterator[tuple[str, tuple[float, str]]]:
    """What the only number with a unit and no letter can be in a captive test of that kind."""
    kind = None if test is None else TEST_KINDS[test]
    if kind is None or not kind.captive:
        return
    found: dict[str, list[tuple[float, str]]] = {}
    for token in tokens:
        if (number := _ALONE.fullmatch(token)) is not None:
            unit = {"sec": "s", "°": "deg", "mm": "m"}.get(number[2], number[2])
            factor = 1e-3 if number[2] == "mm" else 1.0
            found.setdefault(unit, []).append((_value(number[1]) * factor, token))
    turned = "yaw_amplitude_deg" if kind.pure == "r" else "drift_deg" if kind.steady else ""
    for unit, key in (("s", "period"), ("m", "amplitude_m"), ("deg", turned)):
        if key and len(found.get(unit, ())) == 1:
            yield key, found[unit][0]


def _tokens(part: str) -> list[str]:
    """Parts of a name between separators, a word joined with the number that follows it."""
    # an amplitude is y0, psi0 …
    part = re.sub(rf"(?<=[A-Za-zβδψφ])0?\s*=\s*(?={_NUMBER})", "", part)
    part = _LETTERED.sub(lambda found: found[1] + {"m": "-", "p": "+"}[found[2].lower()], part)
    part = re.sub(r"(?<=\d)\s(?=(?:deg|°|mm|m|s)(?![A-Za-z]))", "", part)
    parts = re.split(r"(?:[_\s;=()\[\]]|(?<!\d),|,(?!\d))+|(?<=[A-Za-z\d])-(?=[A-Za-z])", part)
    pieces = [piece for piece in parts if piece]
    joined = [
        first + second
        for first, second in itertools.pairwise(pieces)
        if re.fullmatch(r"[A-Za-zβδψφ]{2,}", first) and re.fullmatch(_NUMBER + r"\w*", second)
    ]
    return [*pieces, *joined]


def _values(token: str) -> Iterable[tuple[str, float]]:
    for key, pattern, factor in RUN_SETTINGS.derived(_signs):
        found = pattern.fullmatch(token)
        if found is None:
            continue
        text = next(group for group in found.groups() if group is not None)
        value = _value(text)
        if key in _BELOW_ONE and factor == 1.0 and re.fullmatch(r"0\d+", text):
            value = float(f"0.{text[1:]}")
        yield key, value * factor
        return


_LETTERED: Final = re.compile(
    r"((?<![A-Za-z])(?:beta|drift|delta|rudder|rud|heel|phi|b)[_-]?)([mp])(?=\d)", re.IGNORECASE
)
"""A sign as a letter, such as ``beta_m04``: file names do not like a plus."""
_BELOW_ONE: Final = ("froude", "amplitude_m")
"""Of these 025 in a name is 0.25."""


def _value(text: str) -> float:
    return float(re.sub("[,p]", ".", text))


def test_named(part: str) -> str | None:
    """Kind of test that a text names, or None; `part` is a part of a name, or a cell.

    Examples
    --------
    >>> test_named("Pure sway, large amplitude"), test_named("Schrägschlepp"), test_named("No. 4")
    ('pure_sway', 'static_drift', None)
    """
    words = re.sub(r"(?<=[a-z])(?=[A-Z])", " ", part)
    plain = " ".join(re.findall(r"[A-Za-z]+", words)).lower()
    for test, pattern in _phrases():
        if pattern.search(plain):
            return test
    in_other_words = [test for test, *_ in meanings("test", part) if test in TEST_KINDS]
    if in_other_words:
        return in_other_words[0]
    codes = _codes()
    for token in re.split(r"[_\s-]+", part):
        found = re.fullmatch(r"([A-Z]{2,3})(?:\d+[A-Z]?)?", token)
        if found and found[1] in codes:
            return codes[found[1]]
    return next((test for test, orders in _ORDERS.items() if orders.search(part)), None)


_ANGLE: Final = r"(?P<rudder>[+-]?\d{1,2}(?:\.\d+)?)(?:deg)?"
_SIDE: Final = r"(?:[-_ ]?(?:[PpSs]|[Pp]ort|PORT|[Ss]tbd|STBD|[Ss]tarboard|SB|PS))?"
_ORDERS: Final = {
    "zigzag": re.compile(
        r"(?<![A-Za-z\d])(?:ZZ?|zz|[Zz]ig[-_ ]?[Zz]ag)[-_ ]?"
        r"(?:(?P<both>\d\d)(?P<after>\d\d)|" + _ANGLE + r")"
        r"(?:[-_ /x](?P<switch>\d{1,2}(?:\.\d+)?)(?!\d|[-_]\w{3}[-_]))?"
        rf"(?![\d.]|[-_ ]\+\d|_-\d|-\w{{3}}-){_SIDE}(?![A-Za-z])"
    ),
    # A bare number behind "turn" is that of a run as often as not, unless rudders are laid to it.
    "turning": re.compile(
        rf"(?<![A-Za-z\d])(?:(?:TC|tc){_SIDE}[-_ ]?(?=[+-]?\d\d)|"
        rf"[Tt]urn(?:ing)?(?:[-_ ]?[Cc]ircle)?{_SIDE}[-_ ]?(?=[+-]?(?:[123][05])(?!\d)))"
        rf"{_ANGLE}{_SIDE}(?![\dA-Za-z.]|[-_ ]*[+-]?\d|-\w{{3}}-)"
    ),
}
"""Orders of manoeuvres in names, such as ``Z_10_05``, ``zigzag2020``, ``tc_-35``, ``TC35S``."""


def _orders(test: str | None, part: str) -> Iterable[tuple[str, tuple[float, str]]]:
    """Rudder and switching heading of a zigzag, rudder of a turn."""
    found = _ORDERS[test].search(part) if test in _ORDERS else None
    if found is None:
        return
    told = found.groupdict()
    rudder = told.get("both") or told["rudder"]
    yield "rudder_deg", (float(rudder), found[0])
    if test == "zigzag":
        switch = told.get("after") or told["switch"] or abs(float(rudder))
        yield "switch_deg", (float(switch), found[0])


def _refined(test: str | None, settings: Mapping[str, tuple[float, str]]) -> str | None:
    """Yaw with a drift angle in its name is yaw with drift, and so on."""
    kind = None if test is None else TEST_KINDS[test]
    if kind is None or kind.free_running or not (kind.pure or kind.held):
        return test
    stated = {key.removesuffix("_deg") for key, (value, _) in settings.items() if value}
    for name in ("drift", "rudder"):
        if name in stated and stated >= set(kind.held):
            kind = held_too(kind, name)
    return kind.name


def _along_the_path(
    test: str | None, settings: Mapping[str, tuple[float, str]]
) -> dict[str, tuple[float, str]]:
    """An amplitude in metres of a test that only yaws is that of its path, else of its heading."""
    kind = None if test is None else TEST_KINDS[test]
    if kind is None or _swinging(kind) != ["r"]:
        return dict(settings)
    value, token = settings.get("amplitude_m", (0.0, ""))
    left = {key: item for key, item in settings.items() if key != "amplitude_m"}
    if token.endswith("m"):
        return {**left, "path_amplitude_m": (value, token)}
    return {"yaw_amplitude_deg": (value, token), **left} if value >= _DEGREE else left


_DEGREE: Final = 1.0
"""An amplitude of yaw without a unit that is as large is no path, and no radians."""


def _swinging(kind: TestKind) -> list[str]:
    return [swing.velocity for swing in kind.swings]


def _kept(
    test: str | None, settings: Mapping[str, tuple[float, str]]
) -> dict[str, tuple[float, str]]:
    """Settings that a test of that kind can have."""
    kind = None if test is None else TEST_KINDS[test]
    dropped: set[str] = set()
    if kind is None or kind.steady:
        dropped |= {"period", "frequency_hz", "yaw_amplitude_deg", "amplitude_m"}
    if kind is None or not (kind.surges or kind.sways):
        dropped.add("amplitude_m")
    if kind is None or not kind.oscillates:
        dropped |= {"period", "frequency_hz"}
    if kind is None or "yaw_rate" not in kind.held:
        dropped.add("radius")
    dropped |= {
        item.in_file
        for item in RUN_SETTINGS.brought
        if kind is None or item.name not in (*kind.needs, *kind.takes)
    }
    return {key: item for key, item in settings.items() if key not in dropped}


def _hints(
    test: str | None, marks: Mapping[str, tuple[float, str]]
) -> dict[str, tuple[float, str]]:
    """Letters that may mean several things, as the likeliest of them."""
    swinging = [] if test is None else _swinging(TEST_KINDS[test])
    yaw = swinging == ["r"]
    likely = {
        "hint v": ("v_amplitude", "the sway velocity over U", swinging == ["v"]),
        "hint r": ("r_amplitude", "the yaw rate times L/U", yaw),
        "hint p": ("yaw_amplitude_deg", "the amplitude of the heading", yaw),
    }
    return {
        key: (marks[mark][0], f"{marks[mark][1]}, if it is {what}")
        for mark, (key, what, fits) in likely.items()
        if mark in marks and fits
    }


_SAID: Final = re.compile(
    r"[\W_]*(?P<name>[^:=\t;]*?[^\W\d][^:=\t;]*?)\s*[:=\t;]\s*(?P<number>[+-]?\d*[.,]?\d+)\s*"
    r"\[?(?P<unit>[^\W\d_][\w/²]*|°)?\]?[\s;,\"]*"
)
"""A line such as ``# Sway amplitude [m]: 0.25`` or ``Periode; 9,0; s``."""


_STATED: Final = re.compile("[:;\t]")
"""Between what a line states and what it is of: ``Test: Pure sway``, ``Versuch;Gieren``."""
_LONGEST_LINE: Final = 200
"""A longer line above the columns says nothing of one test."""


def facts_of_header(lines: Sequence[str]) -> RunFacts:
    """What the lines above the columns of a file say of its test.

    Examples
    --------
    >>> found = facts_of_header(["# Test: Pure sway", "# Sway amplitude: 250 mm"])
    >>> found.test, found.settings
    ('pure_sway', {'amplitude_m': (0.25, 'Sway amplitude: 250 mm')})
    """
    settings: dict[str, tuple[float, str]] = {}
    short = [line for line in lines if len(line) <= _LONGEST_LINE]
    stated = [text for line in short for text in _STATED.split(line, maxsplit=1)[1:]]
    tests = {test for text in stated if (test := test_named(text)) is not None}
    test = tests.pop() if len(tests) == 1 else None
    for line in short:
        if (found := _SAID.fullmatch(line)) is None:
            continue
        name, unit = bare_header(found["name"], found["unit"])
        (item,) = suggest([name], [unit], {}, table=True)
        if item is None or item.certainty == "perhaps" or item.name not in RUN_SETTINGS.units:
            continue
        factor = factor_to(unit, RUN_SETTINGS.units[item.name]) if unit else 1.0
        if factor is not None:
            value = float(f"{_value(found['number']) * factor:.9g}")
            settings.setdefault(item.name, (value, line[found.start("name") :].rstrip('; \t"')))
    test = _refined(test, settings)
    return RunFacts(test=test, settings=settings)


# What the settings of a run are put to: what name, header and record say, held against each other.


_ALSO: Final = ("drift_deg", "rudder_deg", "heel_deg", "phase_deg", "propeller_rps")
_CLOSE: Final = {"speed": 0.03, "period": 0.02, "propeller_rps": 0.03}
"""Relative difference up to which name and record agree; 6 % for others, angles 0.6°."""


@dataclass(frozen=True, kw_only=True)
class RunKey:
    """A key of a run.

    `value`: none where nobody knows. `reason`: where it comes from. `todo`: what a person must
    decide; empty where nothing. `active`: whether the line counts, or is commented out.
    """

    key: str
    value: float | None
    reason: str = ""
    todo: str = ""
    active: bool = True


def asked_of(test: str | None) -> tuple[str, ...]:
    """Keys of a campaign file that describe a test, in the order in which they are written.

    Examples
    --------
    >>> asked_of("yaw_drift"), asked_of("circular_motion"), asked_of(None)
    (('period', 'yaw_amplitude_deg', 'drift_deg'), ('drift_deg', 'yaw_rate'), ())
    """
    if test is None:
        return ()
    kind = TEST_KINDS[test]
    # A free-running record tells by itself what it may take besides.
    names = (*(kind.takes if kind.captive else ()), *kind.needs)
    return tuple(RUN_SETTINGS.key_of(name) for name in names)


def settled(
    test: str | None,
    named: RunFacts,
    moved: RunFacts,
    headed: RunFacts | None = None,
    *,
    length: float | None,
    g: float = 9.81,
) -> tuple[RunKey, ...]:
    """The settings of a run from its name, the lines above its columns and its record.

    length [m]; g [m/s²].
    """
    above = {} if headed is None else _kept(test, _along_the_path(test, headed.settings))
    alone = {
        key: item
        for key, item in named.alone.items()
        if key not in moved.settings or _agree(key, item[0], moved.settings[key][0])
    }
    said = _with_speed({**alone, **named.settings}, length, g)
    said = {key: _with_point(key, item, moved.settings) for key, item in said.items()}
    if test is not None and TEST_KINDS[test].swings_rudder and "rudder_deg" in said:
        said["rudder_amplitude_deg"] = said.pop("rudder_deg")
    said = {key: (value, f"{text} in the name") for key, (value, text) in said.items()}
    above = {key: (value, f"{text!r} in the header") for key, (value, text) in above.items()}
    sources = {"name": said, "header": above, "record": moved.settings}
    wanted = ("speed", *asked_of(test))
    free = test is not None and TEST_KINDS[test].free_running
    # What a sensor shows is not asked; a heading at which the rudder turned may be late.
    sure = {"rudder_deg", "propeller_rps", *(("speed",) if moved.steady else ())}
    out = [
        _one(key, sources, named, said.get("froude"), unsure=free and key not in sure)
        for key in wanted
    ]
    first = {**moved.settings, **above, **said}
    out += [
        _one(key, sources, named, unsure=free and key not in sure)
        for key in _ALSO
        if key not in wanted and abs(first.get(key, (0.0, ""))[0]) > 0.2
    ]
    return tuple(out)


_FEET: Final = (("ft", 0.3048), ("in", 0.0254))
_POINTED: Final = ("speed", "amplitude_m", "path_amplitude_m")
"""Settings that are seldom whole numbers."""
_OTHER_UNITS: Final = {
    "speed": (("ft/s", 0.3048), ("kn", 1852 / 3600)),
    "amplitude_m": _FEET,
    "path_amplitude_m": _FEET,
}
"""Units of a number in a name that states none, and their factors to ours."""


def _with_point(
    key: str, said: tuple[float, str], recorded: Mapping[str, tuple[float, str]]
) -> tuple[float, str]:
    """A number whose point names left out, such as U12 for 1.2, or that is in feet or knots,
    where the record says so."""
    value, text = said
    if key not in _POINTED or key not in recorded:
        return said
    tenths = () if re.search(r"\d[.,p]\d", text) else (1.0, 0.1, 0.01, 0.001)
    for unit, factor in (*(("", x) for x in tenths), *_OTHER_UNITS[key]):
        if _agree(key, value * factor, recorded[key][0]):
            told = f"{text}, as {unit}," if unit else text
            return float(f"{value * factor:.6g}"), told
    return said


def _with_speed(
    settings: Mapping[str, tuple[float, str]], length: float | None, g: float
) -> dict[str, tuple[float, str]]:
    """With the speed of a Froude number where the ship is known, the period of a frequency."""
    said = dict(settings)
    if "froude" in said and "speed" not in said and length is not None:
        value, text = said.pop("froude")
        speed = float(f"{value * math.sqrt(g * length):.4g}")
        said["speed"] = (speed, f"{text} and L = {length:g} m")
    if "frequency_hz" in said:
        value, text = said.pop("frequency_hz")
        said.setdefault("period", (float(f"{1 / value:.6g}"), text))
    return said


_SIGNED: Final = r"\+|(?<![A-Za-z\d])-(?=\d)"
"""A sign of a number in a name; a stroke behind a letter or a digit parts two words."""


def _one(
    key: str,
    sources: Mapping[str, Mapping[str, tuple[float, str]]],
    named: RunFacts,
    froude: tuple[float, str] | None = None,
    *,
    unsure: bool,
) -> RunKey:
    """What the first of the sources says, and what the others say beside it."""
    told = {source: facts[key] for source, facts in sources.items() if key in facts}
    if told:
        (source, (value, text)), *others = told.items()
        if key == "rudder_deg" and source == "name" and not re.search(_SIGNED, text):
            # A name tells how much, and seldom to which side.
            value = math.copysign(value, next((x for _, (x, _) in others), value))
        apart = [
            f"the {other} ({where}) {number:g}"
            for other, (number, where) in others
            if not _agree(key, value, number)
        ]
        if apart:
            todo = f"the {source} says {value:g}, {', '.join(apart)}: which is right?"
            return RunKey(key=key, value=value, reason=text, todo=todo)
        beside = [
            f"{where}: {number:g}" if other == "record" else where
            for other, (number, where) in others
        ]
        todo = "right?" if unsure and source == "record" else ""
        return RunKey(key=key, value=value, reason="; ".join((text, *beside)), todo=todo)
    said = sources["name"]
    known = RUN_SETTINGS.by_key.get(key)
    instead, meant = _INSTEAD.get(key, ("", ""))
    if instead in said:
        value, text = said[instead]
        return RunKey(key=instead, value=value, reason=f"{text}: {meant}, in metres")
    hint = next(
        (
            (name, item)
            for name, item in named.hints.items()
            if name in RUN_SETTINGS.ways_to_state(known.name if known else key)
        ),
        None,
    )
    if hint is not None:
        name, (value, why) = hint
        return RunKey(key=name, value=value, todo=f"{why}; else {key} = ...", active=False)
    todo = (known and known.asked) or key
    if key == "speed" and froude is not None:
        todo += f": Fn = {froude[0]:g} times the root of 9.81 L"
    return RunKey(key=key, value=None, todo=todo, active=False)


_INSTEAD: Final[dict[str, tuple[str, str]]] = {
    "yaw_amplitude_deg": ("path_amplitude_m", "of the path"),
    "yaw_rate": ("radius", "of the circle"),
}
"""What a name may state instead of a key, and what that is."""


_LATE: Final = 2.5
"""By how much a heading passes that of its reversal before the rudder leaves its angle [°]: HSVA's
free model of 7 m by 1 to 2°."""


def _agree(key: str, value: float, other: float) -> bool:
    if key == "switch_deg":
        return -0.6 < other - value < _LATE
    if key.endswith("_deg"):
        return abs(value - other) < 0.6 + 0.03 * abs(value)
    return abs(value - other) <= _CLOSE.get(key, 0.06) * abs(value)
