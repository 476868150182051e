"""What the name of a file says of its test: kind, speed, angles, period.

Names such as ``SD_U1.5_b+08``, ``static drift/beta12deg``, ``PMM_sway_T12.5_a0.2``, ``ZZ10-10``.
Only what cannot mean anything else becomes a setting; the rest is a hint for a person.
"""

from __future__ import annotations

import itertools
import math
import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Final

from pmmkit.campaigns import RUN_SETTINGS, TEST_KINDS, RunSetting, TestKind
from pmmkit.intake.blocks import held_too
from pmmkit.intake.drafts.motion import RunFacts
from pmmkit.presentation import meanings

_NUMBER: Final = r"([+-]?\d+(?:[.p]\d+)?)"

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
    >>> facts_of("PS_U1.0_v0.08").hints
    {'v_amplitude': (0.08, 'v0.08, if it is the sway velocity over U')}
    """
    parts = list(reversed(name.split("/")))
    test = next((found for part in parts if (found := test_named(part)) is not None), None)
    settings: dict[str, tuple[float, str]] = {}
    marks: dict[str, tuple[float, str]] = {}
    for part in parts:
        for key, item in _zigzag(part) if test == "zigzag" else ():
            settings.setdefault(key, item)
        for token in _tokens(part):
            for key, value in _values(token):
                (marks if key.startswith("hint") else settings).setdefault(key, (value, token))
    test = _refined(test, settings)
    settings = _along_the_path(test, settings)
    return RunFacts(test=test, settings=_kept(test, settings), hints=_hints(test, marks))


def _tokens(part: str) -> list[str]:
    """Parts of a name between separators, a word joined with the number that follows it."""
    part = re.sub(rf"(?<=[A-Za-zβδψφ])=(?={_NUMBER})", "", part)
    parts = re.split(r"[_\s,;=()\[\]]+|(?<=[A-Za-z])-(?=[A-Za-z])", part)
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
        value = float(text.replace("p", "."))
        if key == "froude" and re.fullmatch(r"0\d+", text):
            value = float(f"0.{text[1:]}")
        yield key, value * factor
        return


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
        found = re.fullmatch(r"([A-Z]{2,3})\d*", token)
        if found and found[1] in codes:
            return codes[found[1]]
    return "zigzag" if _ORDERS.search(part) else None


_ORDERS: Final = re.compile(
    r"(?<![A-Za-z])(?:ZZ?|[Zz]ig[-_ ]?[Zz]ag)[-_ ]?(?P<rudder>[+-]?\d{1,2}(?:\.\d+)?)"
    r"(?:deg)?(?:[-_ /x](?P<switch>\d{1,2}(?:\.\d+)?)(?!\d|[-_]\w{3}[-_]))?(?![\d.]|-\w{3}-)"
)


def _zigzag(part: str) -> Iterable[tuple[str, tuple[float, str]]]:
    """Rudder and switching heading of a zigzag such as ``Z_10_05``."""
    found = _ORDERS.search(part)
    if found is None:
        return
    yield "rudder_deg", (float(found["rudder"]), found[0])
    yield "switch_deg", (float(found["switch"] or abs(float(found["rudder"]))), found[0])


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
    """An amplitude in metres of a test that only yaws is that of its path."""
    kind = None if test is None else TEST_KINDS[test]
    if kind is None or _swinging(kind) != ["r"]:
        return dict(settings)
    value, token = settings.get("amplitude_m", (0.0, ""))
    left = {key: item for key, item in settings.items() if key != "amplitude_m"}
    return {**left, "path_amplitude_m": (value, token)} if token.endswith("m") else left


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


# What the settings of a run are put to: the name's word beside the record's.


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
    test: str | None, named: RunFacts, moved: RunFacts, *, length: float | None, g: float = 9.81
) -> tuple[RunKey, ...]:
    """The settings of a run from its name and its record.

    length [m]; g [m/s²].
    """
    said = _with_speed(named.settings, length, g)
    if test is not None and TEST_KINDS[test].swings_rudder and "rudder_deg" in said:
        said["rudder_amplitude_deg"] = said.pop("rudder_deg")
    wanted = ("speed", *asked_of(test))
    free = test is not None and TEST_KINDS[test].free_running
    out = [
        _one(key, said, moved.settings, named, said.get("froude"), unsure=free) for key in wanted
    ]
    out += [
        _one(key, said, moved.settings, named, unsure=free)
        for key in _ALSO
        if key not in wanted
        and (key in said or key in moved.settings)
        and abs(said.get(key, moved.settings.get(key, (0.0, "")))[0]) > 0.2
    ]
    return tuple(out)


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


def _one(
    key: str,
    said: Mapping[str, tuple[float, str]],
    recorded: Mapping[str, tuple[float, str]],
    named: RunFacts,
    froude: tuple[float, str] | None = None,
    *,
    unsure: bool,
) -> RunKey:
    if key in said and key in recorded:
        value, text = said[key]
        other, where = recorded[key]
        if _agree(key, value, other):
            return RunKey(key=key, value=value, reason=f"{text} in the name; {where}: {other:g}")
        todo = f"the name says {value:g}, the record ({where}) {other:g}: which is right?"
        return RunKey(key=key, value=value, reason=f"{text} in the name", todo=todo)
    if key in said:
        value, text = said[key]
        return RunKey(key=key, value=value, reason=f"{text} in the name")
    if key in recorded:
        value, where = recorded[key]
        return RunKey(key=key, value=value, reason=where, todo="right?" if unsure else "")
    known = RUN_SETTINGS.by_key.get(key)
    instead, meant = _INSTEAD.get(key, ("", ""))
    if instead in said:
        value, text = said[instead]
        return RunKey(key=instead, value=value, reason=f"{text} in the name: {meant}, in metres")
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


def _agree(key: str, value: float, other: float) -> bool:
    if key.endswith("_deg"):
        return abs(value - other) < 0.6 + 0.03 * abs(value)
    return abs(value - other) <= _CLOSE.get(key, 0.06) * abs(value)
