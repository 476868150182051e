"""What the name of a file says of its test: kind, speed, angles, period.

Names such as ``SD_U1.5_b+08``, ``static drift/beta12deg``, ``PMM_sway_T12.5_a0.2``, ``ZZ10-10``.
Only what cannot mean anything else becomes a setting; the rest is a hint for a person.
"""

from __future__ import annotations

import itertools
import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Final

from pmmkit.campaigns import RUN_SETTINGS, TEST_KINDS, RunSetting, TestKind, brought
from pmmkit.intake.blocks import held_too
from pmmkit.presentation import meanings


@dataclass(frozen=True, kw_only=True)
class NameMeaning:
    """What a name says.

    `settings`: value and the part of the name it stands in, by key of the campaign file;
    ``froude`` is the Froude number. `hints`: values whose meaning a person must confirm, and
    why.
    """

    test: str | None
    settings: Mapping[str, tuple[float, str]]
    hints: Mapping[str, tuple[float, str]]


_NUMBER: Final = r"([+-]?\d+(?:[.p]\d+)?)"

_BESIDE: Final = (
    ("froude", r"(?:[Ff][nr]|FN|FR|[Ff]roude)#"),
    ("hint v", r"v#"),
    ("hint r", r"r#"),
    ("hint p", r"p#"),
)
"""What names hold besides settings: the Froude number, and letters that may mean several things."""


@dataclass(frozen=True)
class _Sign:
    """What stands in a name for a key, and by what its number becomes the key's."""

    key: str
    pattern: re.Pattern[str]
    factor: float = 1.0


def _signs(settings: Iterable[RunSetting]) -> tuple[_Sign, ...]:
    def compiled(pattern: str) -> re.Pattern[str]:
        return re.compile(pattern.replace("#", _NUMBER))

    return (
        *(
            _Sign(item.in_file, compiled(pattern), factor)
            for item in settings
            for pattern, factor in item.in_names
        ),
        *(_Sign(key, compiled(pattern)) for key, pattern in _BESIDE),
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


def facts_of(name: str) -> NameMeaning:
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
    return NameMeaning(test=test, settings=_kept(test, settings), hints=_hints(test, marks))


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
    for sign in RUN_SETTINGS.derived(_signs):
        found = sign.pattern.fullmatch(token)
        if found is None:
            continue
        text = next(group for group in found.groups() if group is not None)
        value = float(text.replace("p", "."))
        if sign.key == "froude" and re.fullmatch(r"0\d+", text):
            value = float(f"0.{text[1:]}")
        yield sign.key, value * sign.factor
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
        for item in brought()
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
